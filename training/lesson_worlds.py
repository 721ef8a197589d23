"""Furnished floors on fine cells, with the true class and room of each cell: what map_lessons.py maps.

The measures, shares and ranges of this module were chosen by hand.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import pairwise
from math import cos, radians, sin
from pathlib import Path

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Point, Polygon, affinity

from pianta._types import Floats, LabelImage, Mask
from pianta.floor import Door, Floor
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.layout.structure.evidence import DOOR, FLOOR, FURNITURE, OUTSIDE, WALL
from pianta.worlds.dense_furniture import furnish_densely
from pianta.worlds.door_leaves import draw_door_leaves
from pianta.worlds.floors import make_floor
from pianta_bench.data.building_of import building_of

# Side of the cells of a simulated map; metres.
FINE = 0.05
# Empty space around a floor; metres.
MARGIN = 3.0
# A floor of the same building as one of the benches, although the data give it a building of its own.
OTHER_BENCH_FLOOR = "scuolasconosciuta2"
# How often a floor is an annotated one.
ANNOTATED_SHARE = 0.4
# Median area of the rooms of a floor: the scale of annotated floors is not exact, and is brought into this range; m².
MEDIAN_ROOM = (10.0, 45.0)
# How often a floor is made by each maker of pianta.worlds, if it is not an annotated one.
MAKERS = {
    "home": 0.5,
    "office": 0.15,
    "open_plan": 0.08,
    "ward": 0.07,
    "depot": 0.08,
    "corridor": 0.03,
    "l": 0.03,
    "ring": 0.03,
    "hall": 0.03,
}
# How often a floor is along the axes of the map, nearly so, or at any angle.
ANGLE_SHARES = (0.45, 0.3, 0.25)
# Standard deviation of the angle of a floor that is nearly along the axes; degrees.
SMALL_ANGLE = 2.0
# By how much annotated floors are made longer in one direction and shorter in the other.
STRETCHES = (0.85, 1.18)
# Width of doors of annotated floors, whose drawn width is the unit of the drawing; metres.
DOOR_WIDTHS = (0.7, 1.1)
# How often inner walls are boards, one cell of FINE thick, as maps of vacuums show them.
BOARD_SHARE = 0.35
# Thickness of other inner walls; metres.
WALL_THICKNESSES = (0.06, 0.3)
# Side of the square that closes the space between rooms that do not touch, which is wall; cells of FINE.
CLOSING_CELLS = 11
# Diameter of the disc that draws outer walls, 0.2 m thick; cells of FINE.
OUTER_WALL_CELLS = 9
# Depth that a door is longer than its wall on each side, so that rounding leaves no wall in it; metres.
DOOR_OVERLAP = 1.5 * FINE
# Greatest share of the doors of a floor that are wide openings, and that of homes.
WIDE_SHARE = 0.24
HOME_WIDE_SHARE = 0.6
# How far from a door its wall is followed to find how wide an opening can be; metres.
WALL_SEARCH = 15.0
# Depth of the boundary of a room in which the boundary of the next room is in the same wall; metres.
SHARED_DEPTH = 0.25
# How often no wall is left on one side of a wide opening, so that only the other side has a stub.
ONE_SIDED_SHARE = 0.25
# Wall beside a wide opening; metres.
OPENING_STUBS = (0.15, 0.9)
# Width of wide openings; metres.
OPENING_WIDTHS = (1.2, 7.0)
# Walls with less space for an opening have none; metres.
MIN_OPENING_SPACE = 1.4
# Doors of this width or wider have no leaf; metres.
WIDEST_LEAF_DOOR = 1.5
# Share of the narrower doors that may have a leaf, and shares of these that are shut and half open.
LEAF_SHARE = 0.625
SHUT_SHARE = 0.19
HALF_OPEN_SHARE = 0.21
# How often rooms are empty, little furnished, and much furnished.
DENSITY_SHARES = (0.12, 0.4, 0.48)
# Density of furniture, as furnish_densely takes it, of little and of much furnished floors.
LOW_DENSITIES = (0.0, 0.6)
HIGH_DENSITIES = (0.5, 1.6)
# How often boxes, legs and pieces at walls stand anywhere, besides the furniture of the rooms' labels.
BOXES_SHARE = 0.4
# Their density relative to that of the furniture.
BOXES_DENSITY = 0.5
# Area of floor for a box, and length of wall for a piece at it, at density 1; m² and metres.
BOX_AREA = 5.0
WALL_PIECE_LENGTH = 3.5
# How often all walls stop beams, and how often they have windows; else some parts of walls are glass.
OPAQUE_SHARE = 0.45
WINDOWS_SHARE = 0.2
# Side of the square by which facades are thicker than outer walls; cells of FINE.
FACADE_CELLS = 9


@dataclass(frozen=True, eq=False)
class World:
    """A furnished floor on cells of FINE metres, row 0 at y = 0, shape (H, W) each.

    rooms: true room, 0 outside of rooms. classes: as in pianta.layout.structure.evidence.
    stops: cells that end a beam. glass: those of them that some beams pass. floor: its rooms in the order of their
    numbers, and its doors, metres to the right and down from the first cell.
    """

    rooms: LabelImage
    classes: NDArray[np.uint8]
    stops: Mask
    glass: Mask
    floor: Floor


def list_annotated_floors(data: Path) -> list[Floor]:
    """Annotated floors of the buildings that no bench of maps measures on."""
    files = sorted((data / "buildings").glob("*/*.xml"))
    measured = [*(data / "slam").glob("*_gt.xml"), *(data / "doors").glob("*_GT.png")]
    measured += [file for file in files if file.stem == OTHER_BENCH_FLOOR]
    building = {file: building_of(data, file.relative_to(data).as_posix()) for file in (*measured, *files)}
    buildings = {building[file] for file in measured}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return [read_building_xml(file) for file in files if building[file] not in buildings]


def draw_floor(annotated: list[Floor], rng: np.random.Generator) -> tuple[Floor, float]:
    """A random floor, and the scale at which it is used; 1 for floors of pianta.worlds."""
    if annotated and rng.random() < ANNOTATED_SHARE:
        floor = annotated[int(rng.integers(len(annotated)))]
        median = float(np.median([room.polygon.area for room in floor.rooms]))
        target = np.clip(median, *MEDIAN_ROOM) * rng.uniform(0.8, 1.25)
        return floor, float(target / median) ** 0.5
    name = str(rng.choice(list(MAKERS), p=list(MAKERS.values())))
    return make_floor(name, seed=int(rng.integers(10**6))), 1.0


def build_world(floor: Floor, scale: float, rng: np.random.Generator) -> World:
    """The floor with walls of random thickness, doors, wide openings, furniture and glass."""
    floor = transform_floor(floor, scale, rng)
    thickness = FINE if rng.random() < BOARD_SHARE else rng.uniform(*WALL_THICKNESSES)
    rooms = _draw_rooms(floor)
    inside = cv2.morphologyEx(_as_image(rooms > 0), cv2.MORPH_CLOSE, np.ones((CLOSING_CELLS,) * 2, np.uint8)) > 0
    walls = _draw_walls(rooms, inside, thickness)
    floor = replace(floor, doors=_widen_openings(floor, rng))
    gaps = _draw_shapes([_outline_gap(floor, door, thickness) for door in floor.doors], rooms.shape)
    gaps &= walls | (rooms == 0)
    leaves = _draw_shapes(_hang_leaves(floor, rng), rooms.shape)
    furniture = _draw_shapes(_furnish(floor, thickness, rng), rooms.shape)
    classes = np.select([gaps, walls, rooms > 0], [DOOR, WALL, FLOOR], OUTSIDE).astype(np.uint8)
    stops = (classes == WALL) | (furniture & (classes == FLOOR)) | leaves
    classes[(furniture | leaves) & (classes == FLOOR)] = FURNITURE
    rooms[(classes != FLOOR) & (classes != FURNITURE)] = 0
    return World(rooms, classes, stops, _draw_glass(walls, inside, rng), floor)


def transform_floor(floor: Floor, scale: float, rng: np.random.Generator) -> Floor:
    """The rooms and doors of a floor scaled, turned, perhaps mirrored, and moved to MARGIN from both axes.

    scale: 1 for a floor of pianta.worlds; any other floor is also stretched, and its doors get DOOR_WIDTHS.
    """
    angles = (0.0, rng.normal(0, SMALL_ANGLE), rng.uniform(0, 90))
    angle = radians(angles[int(rng.choice(len(angles), p=ANGLE_SHARES))] + 90 * int(rng.integers(4)))
    stretch = rng.uniform(*STRETCHES) if scale != 1 else 1.0
    x_scale, y_scale = scale * stretch * rng.choice([-1, 1]), scale / stretch
    matrix = [cos(angle) * x_scale, -sin(angle) * y_scale, sin(angle) * x_scale, cos(angle) * y_scale, 0, 0]
    bounds = shapely.total_bounds([affinity.affine_transform(room.polygon, matrix) for room in floor.rooms])
    matrix[4:] = MARGIN - bounds[:2]
    rooms = tuple(replace(room, polygon=affinity.affine_transform(room.polygon, matrix)) for room in floor.rooms)
    doors = []
    for door in floor.doors:
        line = affinity.affine_transform(door.line, matrix)
        if scale != 1 and door.kind == "door":
            factor = rng.uniform(*DOOR_WIDTHS) / line.length
            line = affinity.scale(line, factor, factor)
        doors.append(replace(door, line=line, width=line.length))
    return Floor(rooms, tuple(doors))


def _as_image(mask: Mask) -> NDArray[np.uint8]:
    return mask.astype(np.uint8)


def _fill(image: NDArray[np.int32], shape: shapely.Geometry, value: int) -> None:
    """Fill the polygons of a shape, metres, on fine cells."""
    for part in shapely.get_parts(shape):
        if part.geom_type == "Polygon" and part.area > 1e-6:
            # In sixteenths of a cell, from the middle of the first one.
            rings = [np.rint(np.array(ring.coords) / FINE * 16 - 8) for ring in (part.exterior, *part.interiors)]
            cv2.fillPoly(image, [ring.astype(np.int32) for ring in rings], value, shift=4)


def _draw_shapes(shapes: Iterable[shapely.Geometry], size: tuple[int, ...]) -> Mask:
    image = np.zeros(size, np.int32)
    for shape in shapes:
        _fill(image, shape, 1)
    return image > 0


def _draw_rooms(floor: Floor) -> LabelImage:
    """The rooms in full, by their order from 1, with MARGIN around them."""
    far = shapely.total_bounds([room.polygon for room in floor.rooms])[2:] + MARGIN
    rooms = np.zeros(np.ceil(far[::-1] / FINE).astype(int), np.int32)
    for number, room in enumerate(floor.rooms, start=1):
        _fill(rooms, room.polygon, number)
    return rooms


def _draw_walls(rooms: LabelImage, inside: Mask, thickness: float) -> Mask:
    """Walls where rooms meet, in the space between them, and around the floor."""
    borders = np.zeros(rooms.shape, bool)
    for before, after in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        differs = rooms[before] != rooms[after]
        borders[before] |= differs
        if thickness > FINE:
            borders[after] |= differs
    diameter = 2 * max(1, round(thickness / 2 / FINE)) + 1 if thickness > FINE else 1
    inner = cv2.dilate(_as_image(borders), _make_disc(diameter)) > 0
    outer = cv2.dilate(_as_image(inside), _make_disc(OUTER_WALL_CELLS)) > 0
    return np.asarray(inner | (inside & (rooms == 0)) | (outer & ~inside))


def _make_disc(diameter: int) -> NDArray[np.uint8]:
    return np.asarray(cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter, diameter)), np.uint8)


def _outline_gap(floor: Floor, door: Door, thickness: float) -> Polygon:
    """The gap of a door, through the wall to both rooms."""
    depth = max(door.line.distance(floor[room_id].polygon) for room_id in door.room_ids)
    return door.line.buffer(depth + thickness / 2 + DOOR_OVERLAP, cap_style="flat")


def _widen_openings(floor: Floor, rng: np.random.Generator) -> tuple[Door, ...]:
    """The doors of a floor, some of them as wide openings."""
    is_home = any(room.label == "LIVING ROOM" for room in floor.rooms)
    share = (HOME_WIDE_SHARE if is_home else WIDE_SHARE) * rng.random()
    doors = []
    for door in floor.doors:
        line = _widen_line(floor, door, rng) if not door.is_entrance and rng.random() < share else None
        doors.append(door if line is None else replace(door, line=line, width=line.length, kind="opening"))
    return tuple(doors)


def _widen_line(floor: Floor, door: Door, rng: np.random.Generator) -> LineString | None:
    """A wide line for a door, in the wall that its two rooms share; None if that wall has no space for it."""
    start, end = (np.array(point[:2]) for point in (door.line.coords[0], door.line.coords[-1]))
    along, middle = (end - start) / np.hypot(*(end - start)), (start + end) / 2
    search = LineString([middle - WALL_SEARCH * along, middle + WALL_SEARCH * along]).buffer(0.3, cap_style="flat")
    first, second = (floor[room_id].polygon.boundary.buffer(SHARED_DEPTH) for room_id in door.room_ids)
    parts = shapely.get_parts(first.intersection(second).intersection(search))
    part = min(parts, key=lambda part: part.distance(door.line), default=Polygon())
    if part.is_empty:
        return None
    offsets = (shapely.get_coordinates(part) - middle) @ along
    stubs = rng.uniform(*OPENING_STUBS, 2)
    if rng.random() < ONE_SIDED_SHARE:
        stubs[int(rng.integers(2))] = 0
    low, high = offsets.min() + stubs[0], offsets.max() - stubs[1]
    if high - low < MIN_OPENING_SPACE:
        return None
    width = rng.uniform(OPENING_WIDTHS[0], min(high - low, OPENING_WIDTHS[1]))
    offset = rng.uniform(low, high - width)
    return LineString([middle + offset * along, middle + (offset + width) * along])


def _hang_leaves(floor: Floor, rng: np.random.Generator) -> list[Polygon]:
    """Leaves of some of the narrow doors: shut, half open and open."""
    doors = [door for door in floor.doors if door.line.length < WIDEST_LEAF_DOOR and rng.random() < LEAF_SHARE]
    leaves, _ = draw_door_leaves(
        replace(floor, doors=tuple(doors)), rng=rng, shut=SHUT_SHARE, half_open=HALF_OPEN_SHARE
    )
    return leaves


def _furnish(floor: Floor, thickness: float, rng: np.random.Generator) -> list[Polygon]:
    """Obstacles between the walls of all rooms, of a random density."""
    densities = (0.0, rng.uniform(*LOW_DENSITIES), rng.uniform(*HIGH_DENSITIES))
    density = float(rng.choice(densities, p=DENSITY_SHARES))
    rooms = tuple(replace(room, polygon=_shrink(room.polygon, thickness / 2)) for room in floor.rooms)
    pieces = furnish_densely(replace(floor, rooms=rooms), density=density, rng=rng)
    if rng.random() < BOXES_SHARE:
        for room in rooms:
            pieces += _place_boxes(room.polygon, BOXES_DENSITY * density, rng)
            pieces += _place_wall_pieces(room.polygon, BOXES_DENSITY * density, rng)
    return pieces


def _shrink(polygon: Polygon, depth: float) -> Polygon:
    """The largest part that is further than a depth from the boundary; else the polygon."""
    return max(shapely.get_parts(polygon.buffer(-depth)), key=shapely.area, default=polygon)


def _place_boxes(polygon: Polygon, density: float, rng: np.random.Generator) -> list[Polygon]:
    """Boxes, rows of boxes, legs and round pieces anywhere in a room, most of them along its first side."""
    west, south, east, north = polygon.bounds
    first, second = np.array(polygon.exterior.coords)[:2, :2]
    along = float(np.degrees(np.arctan2(*(second - first)[::-1])))
    pieces = []
    for _ in range(rng.poisson(density * polygon.area / BOX_AREA)):
        x, y = rng.uniform(west, east), rng.uniform(south, north)
        angle = along + (rng.uniform(0, 360) if rng.random() < 0.15 else 0)
        pieces += [affinity.rotate(piece, angle, origin=(x, y)) for piece in _make_group(x, y, rng)]
    return pieces


def _make_group(x: float, y: float, rng: np.random.Generator) -> list[Polygon]:
    """A box around a point, four legs, a round piece, or a row of boxes."""
    draw = rng.random()
    if draw < 0.35:
        width, depth = rng.uniform(0.15, 1.8), rng.uniform(0.15, 0.8)
        return [shapely.box(x - width / 2, y - depth / 2, x + width / 2, y + depth / 2)]
    if draw < 0.7:
        width, depth = rng.uniform(0.4, 1.8), rng.uniform(0.4, 1.0)
        corners = [(x + right, y + up) for right in (0, width) for up in (0, depth)]
        return [Point(corner).buffer(0.03, cap_style="square") for corner in corners]
    if draw < 0.85:
        return [Point(x, y).buffer(rng.uniform(0.05, 0.3))]
    count, pitch, width, depth = rng.integers(2, 6), rng.uniform(0.8, 2), rng.uniform(0.15, 0.8), rng.uniform(0.3, 0.8)
    return [shapely.box(x + i * pitch, y, x + i * pitch + width, y + depth) for i in range(count)]


def _place_wall_pieces(polygon: Polygon, density: float, rng: np.random.Generator) -> list[Polygon]:
    """Boxes with their backs at the sides of a room."""
    pieces = []
    for start, end in pairwise(np.array(polygon.exterior.coords)[:, :2]):
        length = float(np.hypot(*(end - start)))
        for _ in range(rng.poisson(density * length / WALL_PIECE_LENGTH)):
            offset, width, depth = rng.uniform(0, length), rng.uniform(0.3, 2.2), rng.uniform(0.2, 0.8)
            line = LineString(start + np.outer([offset, min(offset + width, length)], (end - start) / length))
            pieces.append(line.buffer(depth, cap_style="flat").intersection(polygon))
    return pieces


def _draw_glass(walls: Mask, inside: Mask, rng: np.random.Generator) -> Mask:
    """Parts of walls that some beams pass: no part, windows of the facades, or any stretches of walls.

    Other than draw_glass_walls of pianta.worlds, which follows the sides and labels of rooms: here every wall may be
    glass, in any part, so that glass is no sign of a kind of room.
    """
    style = rng.random()
    if style < OPAQUE_SHARE:
        return np.zeros_like(walls)
    if style < OPAQUE_SHARE + WINDOWS_SHARE:
        facades = walls & (cv2.erode(_as_image(inside), np.ones((FACADE_CELLS,) * 2, np.uint8)) == 0)
        return np.asarray(facades & (_draw_blocks(walls.shape, rng) < rng.uniform(0.1, 0.9)))
    glass = np.zeros_like(walls)
    for _ in range(int(rng.integers(1, 12))):
        top, left = rng.integers(walls.shape)
        height, width = (rng.uniform(0.5, 5, 2) / FINE).astype(int)
        glass[top : top + height, left : left + width] = True
    return glass & walls


def _draw_blocks(size: tuple[int, ...], rng: np.random.Generator) -> Floats:
    """Random numbers 0 … 1, the same in blocks whose sides are 0.5 to 4 m."""
    blocks = rng.random([max(2, int(side * FINE / rng.uniform(0.5, 4))) for side in size])
    return np.asarray(cv2.resize(blocks, size[::-1], interpolation=cv2.INTER_NEAREST), np.float64)
