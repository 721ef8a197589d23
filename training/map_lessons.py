"""Simulate furnished robot maps with true layouts, as lessons for the network of map regions.

    python training/map_lessons.py DIR --minutes 30 --seed 0 [--data DIR]

Each lesson is a floor of `data/buildings` or `pianta.worlds`, furnished, with doors open, half open and shut, and
mapped by a robot that drives through some of its rooms: a lidar with noise, drift, shifted scans (ghost walls), glass,
short reach and holes. A file holds at CELL metres: the map (free and occupied share of each cell), the true class of
each cell, its true room, and where the loss counts. Floors of the benches' buildings are never used.
"""

from __future__ import annotations

import argparse
import time
import warnings
from dataclasses import dataclass
from math import cos, pi, sin
from pathlib import Path

import cv2
import numpy as np
import shapely
from numba import njit
from numpy.typing import NDArray
from shapely import LineString, Polygon, affinity

from pianta.errors import PiantaError
from pianta.floor import Floor
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.layout.structure.evidence import CELL, DOOR, FLOOR, FURNITURE, OUTSIDE, WALL
from pianta.worlds.dense_furniture import furnish_densely
from pianta.worlds.floors import make_floor
from pianta_bench.data.folders import find_data

# Cells of the simulated robot's map; metres.
FINE = 0.05
MARGIN = 3.0
# No lesson is made of a floor with longer sides; metres.
MAX_SIDE = 90.0
# Unseen cells further than this from any seen cell do not count in the loss; metres.
UNSEEN_REACH = 0.8
# A room of which a smaller share of cells is free was not seen.
MIN_SEEN_SHARE = 0.03
# Median area of the rooms of a floor: annotated floors are scaled by the eye, and brought into this range; m².
MEDIAN_ROOM = (10.0, 45.0)
# How often a floor is made by each maker of pianta.worlds, if it is not a drawn one.
MAKERS = {
    "home": 0.4,
    "office": 0.2,
    "open_plan": 0.1,
    "ward": 0.08,
    "depot": 0.07,
    "corridor": 0.04,
    "l": 0.04,
    "ring": 0.04,
    "hall": 0.03,
}
UNKNOWN_CELL, FREE_CELL, OCCUPIED_CELL = 0, 1, 2


@dataclass(frozen=True, eq=False)
class World:
    """A furnished floor on fine cells, shape (H, W) each.

    rooms: true room, 0 none. classes: as in pianta.layout.structure.evidence. stops: cells that end a beam.
    glass: those that some beams pass.
    """

    rooms: NDArray[np.int32]
    classes: NDArray[np.uint8]
    stops: NDArray[np.bool_]
    glass: NDArray[np.bool_]


def list_drawn_floors(data: Path) -> list[Floor]:
    """Floors of the buildings that no bench of maps measures on."""
    measured = {path.stem.replace("_gt", "") for path in (data / "slam").glob("*_gt.xml")}
    measured |= {path.stem.rsplit("_", 1)[0] for path in (data / "doors").glob("*_GT.png")}
    # Other floors of measured buildings.
    measured |= {"rockislandgroundfloor", "scuolasconosciuta2", "plans1"}
    floors = []
    for path in sorted((data / "buildings").glob("*/*.xml")):
        if path.stem in measured:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            floors.append(read_building_xml(path))
    return floors


def draw_floor(drawn: list[Floor], rng: np.random.Generator) -> tuple[Floor, float]:
    """A random floor, and the scale at which it is used."""
    if drawn and rng.random() < 0.4:
        floor = drawn[int(rng.integers(len(drawn)))]
        median = float(np.median([room.polygon.area for room in floor.rooms]))
        low, high = MEDIAN_ROOM
        target = min(max(median, low), high) * rng.uniform(0.8, 1.25)
        return floor, (target / median) ** 0.5
    name = str(rng.choice(list(MAKERS), p=list(MAKERS.values())))
    return make_floor(name, seed=int(rng.integers(10**6))), 1.0


def turn_floor(floor: Floor, scale: float, rng: np.random.Generator) -> tuple[list[Polygon], list[tuple[LineString, float, tuple[int, ...]]], list[str | None], Floor]:
    """Rooms and doors scaled, stretched a little, turned, and moved to positive x and y."""
    angle = [0.0, rng.normal(0, 2.0), rng.uniform(0, 90)][int(rng.choice(3, p=[0.45, 0.3, 0.25]))] + 90 * int(rng.integers(4))
    stretch = rng.uniform(0.85, 1.18) if scale != 1 else 1.0
    flip = 1 if rng.random() < 0.5 else -1
    c, s = cos(angle * pi / 180), sin(angle * pi / 180)
    sx, sy = scale * stretch * flip, scale / stretch
    matrix = [c * sx, -s * sy, s * sx, c * sy, 0, 0]
    polygons = [affinity.affine_transform(room.polygon, matrix) for room in floor.rooms]
    bounds = shapely.total_bounds(polygons)
    shift = (MARGIN - bounds[0], MARGIN - bounds[1])
    polygons = [affinity.translate(polygon, *shift) for polygon in polygons]
    index = {room.id: i for i, room in enumerate(floor.rooms)}
    doors = []
    for door in floor.doors:
        line = affinity.translate(affinity.affine_transform(door.line, matrix), *shift)
        width = line.length if line.length > 0 else door.width * scale
        # A drawn door has the width that scales the drawing; real ones are 0.7 to 1.1 m.
        if scale != 1 and door.kind == "door":
            factor = rng.uniform(0.7, 1.1) / max(line.length, 0.1)
            line, width = affinity.scale(line, factor, factor), line.length * factor
        doors.append((line, width, tuple(index[i] for i in door.room_ids)))
    return polygons, doors, [room.label for room in floor.rooms], floor


def fill(shape: tuple[int, int], polygon: Polygon, image: NDArray, value: int) -> None:
    """Fill a polygon in metres on fine cells; row 0 is y = 0."""
    if polygon.is_empty:
        return
    for part in shapely.get_parts(polygon):
        if part.geom_type != "Polygon" or part.area < 1e-6:
            continue
        rings = [np.round(np.array(ring.coords)[:, :2] / FINE * 16 - 8).astype(np.int32) for ring in (part.exterior, *part.interiors)]
        cv2.fillPoly(image, rings, value, shift=4)


def build_world(floor: Floor, scale: float, rng: np.random.Generator) -> World:
    """Walls of random thickness, doors, openings and furniture."""
    polygons, doors, labels, _ = turn_floor(floor, scale, rng)
    far = shapely.total_bounds(polygons)[2:] + MARGIN
    shape = tuple(np.ceil(far[::-1] / FINE).astype(int))
    thickness = rng.uniform(0.06, 0.3)
    touching = shapely.union_all(polygons).area < 0.985 * shapely.union_all([p.buffer(0.05) for p in polygons]).area
    rooms = np.zeros(shape, np.int32)
    for number, polygon in enumerate(polygons, start=1):
        fill(shape, polygon, rooms, number)
    whole = cv2.morphologyEx((rooms > 0).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((11, 11), np.uint8)) > 0
    # Walls: where rooms meet, and around the floor
    wall = np.zeros(shape, bool)
    for axis in (0, 1):
        a, b = (np.s_[:-1], np.s_[1:]) if axis == 0 else (np.s_[:, :-1], np.s_[:, 1:])
        edge = rooms[a] != rooms[b]
        wall[a] |= edge
        wall[b] |= edge
    radius = max(1, round(thickness / 2 / FINE))
    wall = cv2.dilate(wall.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1,) * 2)) > 0
    # Space of an unfilled gap between two rooms is wall
    wall |= whole & (rooms == 0)
    outer = cv2.dilate(whole.astype(np.uint8), cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (9, 9))) > 0
    wall |= outer & ~whole
    classes = np.full(shape, OUTSIDE, np.uint8)
    classes[rooms > 0] = FLOOR
    classes[wall] = WALL
    stops = wall.copy()
    door_image = np.zeros(shape, np.uint8)
    leaves = np.zeros(shape, np.uint8)
    wide = 0.12 * rng.random() * 2
    for line, width, sides in doors:
        line = _fit_line(line, polygons, sides, rng)
        if len(sides) == 2 and rng.random() < wide:
            line = _widen_opening(line, polygons, sides, rng)
        reach = max((line.distance(polygons[i]) for i in sides), default=0) + thickness / 2 + 1.5 * FINE
        gap = line.buffer(reach, cap_style="flat")
        state = rng.random()
        fill(shape, gap, door_image, 1)
        if state < 0.12 and line.length < 1.5:
            fill(shape, line.buffer(0.03, cap_style="flat"), leaves, 1)
        elif state < 0.55 and line.length < 1.5:
            _draw_leaf(shape, line, leaves, rng)
    door_cells = (door_image > 0) & (wall | (classes == OUTSIDE))
    classes[door_cells] = DOOR
    stops[door_cells] = False
    # Furniture
    density = float(rng.choice([0, rng.uniform(0, 0.6), rng.uniform(0.5, 1.6)], p=[0.12, 0.4, 0.48]))
    inner = [_inside(p, thickness) for p in polygons]
    pieces = furnish(floor, inner, [d[0] for d in doors], labels, density, rng)
    furniture = np.zeros(shape, np.uint8)
    for piece in pieces:
        fill(shape, piece, furniture, 1)
    furniture = (furniture > 0) & (classes == FLOOR)
    classes[furniture | ((leaves > 0) & (classes == FLOOR))] = FURNITURE
    stops |= furniture | ((leaves > 0) & (classes != WALL))
    rooms[(classes == WALL) | (classes == DOOR) | (classes == OUTSIDE)] = 0
    glass = _draw_glass(shape, wall, whole, rng)
    return World(rooms, classes, stops, glass)


def _inside(polygon: Polygon, thickness: float) -> Polygon:
    inner = polygon.buffer(-thickness / 2)
    parts = shapely.get_parts(inner)
    return max(parts, key=lambda part: part.area) if len(parts) else polygon


def _fit_line(line: LineString, polygons: list[Polygon], sides: tuple[int, ...], rng: np.random.Generator) -> LineString:
    if line.length > 0.3:
        return line
    x, y = line.coords[0][:2]
    return LineString([(x - 0.45, y), (x + 0.45, y)])


def _widen_opening(line: LineString, polygons: list[Polygon], sides: tuple[int, ...], rng: np.random.Generator) -> LineString:
    """The opening made wide, up to most of the wall that the two rooms share along the line of the door."""
    (x0, y0), (x1, y1) = line.coords[0][:2], line.coords[-1][:2]
    dx, dy = (x1 - x0) / line.length, (y1 - y0) / line.length
    mx, my = (x0 + x1) / 2, (y0 + y1) / 2
    long = LineString([(mx - 15 * dx, my - 15 * dy), (mx + 15 * dx, my + 15 * dy)]).buffer(0.3, cap_style="flat")
    one, other = (polygons[i].boundary.buffer(0.25) for i in sides)
    shared = one.intersection(other).intersection(long)
    part = min(shapely.get_parts(shared), key=lambda p: p.distance(line), default=None)
    if part is None or part.is_empty:
        return line
    t = [(x - mx) * dx + (y - my) * dy for x, y in shapely.get_coordinates(part)]
    low, high = min(t) + 0.3 + rng.uniform(0.1, 0.6), max(t) - 0.3 - rng.uniform(0.1, 0.6)
    most = min(high - low, 7.0)
    if most < 1.4:
        return line
    width = rng.uniform(1.2, most)
    start = rng.uniform(low, high - width)
    return LineString([(mx + dx * start, my + dy * start), (mx + dx * (start + width), my + dy * (start + width))])


def _draw_leaf(shape: tuple[int, int], line: LineString, leaves: NDArray, rng: np.random.Generator) -> None:
    """The leaf of a door, open by some angle."""
    ends = [line.coords[0][:2], line.coords[-1][:2]]
    if rng.random() < 0.5:
        ends.reverse()
    (hx, hy), (x, y) = ends
    angle = (rng.uniform(60, 115) if rng.random() < 0.7 else rng.uniform(15, 60)) * (1 if rng.random() < 0.5 else -1)
    c, s = cos(angle * pi / 180), sin(angle * pi / 180)
    tip = (hx + c * (x - hx) - s * (y - hy), hy + s * (x - hx) + c * (y - hy))
    fill(shape, LineString([(hx, hy), tip]).buffer(0.025, cap_style="flat"), leaves, 1)


def furnish(floor: Floor, inner: list[Polygon], doors: list[LineString], labels: list[str | None], density: float, rng: np.random.Generator) -> list[Polygon]:
    """Obstacles in all rooms, by the dense furniture of pianta.worlds."""
    from dataclasses import replace

    from pianta.floor import Door, Room

    rooms = tuple(Room(i + 1, polygon, label) for i, (polygon, label) in enumerate(zip(inner, labels, strict=True)))
    lines = []
    for line in doors:
        near = [i + 1 for i, polygon in enumerate(inner) if polygon.distance(line) < 0.5][:2]
        if near and line.length > 0:
            lines.append(Door((near[0], near[1] if len(near) > 1 else None), line, line.length))
    placed = replace(floor, rooms=rooms, doors=tuple(lines), walls=())
    pieces = furnish_densely(placed, density=density, rng=rng)
    return pieces + (_place_boxes(inner, 0.5 * density, rng) if rng.random() < 0.4 else [])


def _place_boxes(inner: list[Polygon], density: float, rng: np.random.Generator) -> list[Polygon]:
    """Boxes, rows of boxes, groups of legs, and pieces at walls, anywhere."""
    pieces = []
    for polygon in inner:
        west, south, east, north = polygon.bounds
        sides = np.array(polygon.exterior.coords)[:, :2]
        turn = float(np.degrees(np.arctan2(*(sides[1] - sides[0])[::-1])))
        for _ in range(rng.poisson(density * polygon.area / 5)):
            x, y = rng.uniform(west, east), rng.uniform(south, north)
            choice = rng.random()
            angle = turn + (rng.uniform(0, 360) if rng.random() < 0.15 else 0)
            if choice < 0.35:
                w, h = rng.uniform(0.15, 1.8), rng.uniform(0.15, 0.8)
                group = [shapely.box(x - w / 2, y - h / 2, x + w / 2, y + h / 2)]
            elif choice < 0.7:
                w, h, r = rng.uniform(0.4, 1.8), rng.uniform(0.4, 1.0), 0.03
                group = [shapely.box(x + a - r, y + b - r, x + a + r, y + b + r) for a in (0, w) for b in (0, h)]
            elif choice < 0.85:
                group = [shapely.Point(x, y).buffer(rng.uniform(0.05, 0.3))]
            else:
                n, step, w, h = int(rng.integers(2, 6)), rng.uniform(0.8, 2.0), rng.uniform(0.3, 1.6), rng.uniform(0.3, 0.8)
                group = [shapely.box(x + k * step, y, x + k * step + w * 0.5, y + h) for k in range(n)]
            if rng.random() < 0.5:
                w0, h0 = sides[int(rng.integers(len(sides) - 1))], None
            pieces += [affinity.rotate(piece, angle, origin=(x, y)) for piece in group]
        # Pieces along walls
        for start, stop in zip(sides[:-1], sides[1:], strict=True):
            length = float(np.hypot(*(stop - start)))
            for _ in range(rng.poisson(density * length / 3.5)):
                a = rng.uniform(0, length)
                w, depth = rng.uniform(0.3, 2.2), rng.uniform(0.2, 0.8)
                along = (stop - start) / max(length, 1e-6)
                p, q = start + along * a, start + along * min(a + w, length)
                pieces.append(LineString([p, q]).buffer(depth, cap_style="flat").intersection(polygon))
    return [piece for piece in pieces if not piece.is_empty]


def _draw_glass(shape: tuple[int, int], wall: NDArray, whole: NDArray, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Stretches of walls that beams may pass: glass walls, and windows or bright facades all around."""
    glass = np.zeros(shape, np.uint8)
    style = rng.random()
    if style < 0.45:
        return glass > 0
    if style < 0.65:
        inner = cv2.erode(whole.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0
        facade = wall & ~inner
        # Windows of 0.3 to 4 m on a part of the facade
        knots = tuple(max(2, int(side * FINE / rng.uniform(0.5, 4))) for side in shape)
        windows = cv2.resize(rng.random(knots).astype(np.float32), shape[::-1], interpolation=cv2.INTER_NEAREST)
        return facade & (windows < rng.uniform(0.1, 0.9))
    for _ in range(int(rng.integers(1, 12))):
        row, col = rng.integers(shape[0]), rng.integers(shape[1])
        h, w = rng.uniform(0.5, 5, 2) / FINE
        glass[int(row) : int(row + h), int(col) : int(col + w)] = 1
    return (glass > 0) & wall


@njit(cache=True)
def cast(stops, glass, poses, beams, reach, noise, passes, hits, dropout, clear, seed):  # noqa: ANN001, ANN201, PLR0913, PLR0917
    """Count for each cell the beams that pass and end; poses: row, col, shift row, shift col."""
    np.random.seed(seed)
    height, width = stops.shape
    for p in range(len(poses)):
        r0, c0, dr, dc = poses[p]
        turn = np.random.random() * 6.2831853
        through = np.random.random() < 0.6
        for b in range(beams):
            if np.random.random() < dropout:
                continue
            a = turn + b * 6.2831853 / beams
            sr, sc = np.sin(a), np.cos(a)
            # A beam passes all glass, or none; outside it ends somewhere
            passing = np.random.random() < clear
            limit = reach
            hit = False
            n = int(reach / 0.7)
            t = 0.0
            for k in range(n):
                t = k * 0.7
                r, c = int(r0 + sr * t), int(c0 + sc * t)
                if r < 0 or c < 0 or r >= height or c >= width:
                    break
                if stops[r, c] and not (glass[r, c] and through and passing):
                    hit = True
                    break
            limit = t
            if hit:
                limit = t + np.random.normal() * noise
            last = -1
            for k in range(int(limit / 0.7)):
                r, c = int(r0 + dr + sr * k * 0.7), int(c0 + dc + sc * k * 0.7)
                if 0 <= r < height and 0 <= c < width:
                    if r * width + c != last:
                        passes[r, c] += 1
                        last = r * width + c
            if hit:
                # Deep enough to lie in the obstacle
                r, c = int(r0 + dr + sr * (limit + 0.4)), int(c0 + dc + sc * (limit + 0.4))
                if 0 <= r < height and 0 <= c < width:
                    hits[r, c] += 1


def map_world(world: World, rng: np.random.Generator) -> NDArray[np.uint8]:
    """The map of a robot: UNKNOWN_CELL, FREE_CELL or OCCUPIED_CELL on fine cells, shape (H, W)."""
    style = rng.random()
    shape = world.rooms.shape
    open_floor = (world.classes == FLOOR) | ((world.classes == DOOR) & ~world.stops)
    if style < 0.15:
        # As drawn: everything inside is known
        cells = np.where(world.stops & (world.classes != OUTSIDE), OCCUPIED_CELL, UNKNOWN_CELL).astype(np.uint8)
        cells[open_floor] = FREE_CELL
        if rng.random() < 0.5:
            near = cv2.dilate(open_floor.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
            cells[(cells == OCCUPIED_CELL) & ~near] = UNKNOWN_CELL
        return cells
    # Positions of the robot: most rooms are entered, doors are passed
    spacing = rng.uniform(0.8, 2.5)
    clear = cv2.distanceTransform((open_floor & ~world.stops).astype(np.uint8), cv2.DIST_L2, 3)
    rows, cols = np.nonzero(clear > 0.25 / FINE)
    entered = rng.random(world.rooms.max() + 1) < rng.choice([1.0, 0.9, 0.6], p=[0.55, 0.25, 0.2])
    entered[0] = True
    keep = entered[world.rooms[rows, cols]]
    rows, cols = rows[keep], cols[keep]
    if not len(rows):
        return np.zeros(shape, np.uint8)
    count = int(min(500, max(5, len(rows) * FINE**2 / spacing**2)))
    chosen = rng.integers(len(rows), size=count)
    shift = rng.normal(0, rng.choice([0.0, 0.3, 0.8], p=[0.4, 0.4, 0.2]), (count, 2))
    ghost = rng.random(count) < (0.06 if rng.random() < 0.15 else 0)
    shift[ghost] += rng.normal(0, 5, 2)
    poses = np.column_stack([rows[chosen] + 0.5, cols[chosen] + 0.5, shift])
    passes, hits = np.zeros(shape, np.int32), np.zeros(shape, np.int32)
    beams = int(rng.choice([180, 360, 720, 1080], p=[0.1, 0.35, 0.35, 0.2]))
    reach = rng.choice([rng.uniform(3.5, 8), rng.uniform(8, 30)], p=[0.35, 0.65]) / FINE
    noise = rng.choice([0.1, 0.4, 1.0], p=[0.4, 0.4, 0.2])
    dropout = rng.choice([0.0, 0.1, 0.4], p=[0.6, 0.3, 0.1])
    cast(world.stops, world.glass, poses, beams, reach, noise, passes, hits, dropout, rng.choice([0.1, 0.5, 0.95]), int(rng.integers(2**31)))
    threshold = rng.uniform(0.1, 0.5)
    known = passes + hits >= int(rng.choice([1, 1, 2, 4]))
    occupied = known & (hits > 0) & (hits >= threshold * (passes + hits))
    cells = np.where(occupied, OCCUPIED_CELL, np.where(known & (passes > 0), FREE_CELL, UNKNOWN_CELL)).astype(np.uint8)
    return cells


def degrade(cells: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.uint8]:
    """Specks, holes, thick walls, people, missing walls, and other ways of drawing."""
    cells = cells.copy()
    chance = rng.random(cells.shape)
    if rng.random() < 0.4:
        cells[(cells == FREE_CELL) & (chance < 10 ** rng.uniform(-4, -2.0))] = OCCUPIED_CELL
    if rng.random() < 0.3:
        cells[(cells == FREE_CELL) & (chance > 1 - 10 ** rng.uniform(-4, -1.3))] = UNKNOWN_CELL
    if rng.random() < 0.3:
        cells[(cells == OCCUPIED_CELL) & (chance < rng.uniform(0, 0.35))] = rng.choice([FREE_CELL, UNKNOWN_CELL])
    if rng.random() < 0.3:
        thick = cv2.dilate((cells == OCCUPIED_CELL).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        cells[thick & ((cells != FREE_CELL) | (rng.random(cells.shape) < 0.5))] = OCCUPIED_CELL
    style = rng.random()
    if style < 0.1:
        cells[cells == UNKNOWN_CELL] = OCCUPIED_CELL
    elif style < 0.15:
        cells[cells == OCCUPIED_CELL] = UNKNOWN_CELL
    elif style < 0.25:
        # Small unknown spots are filled
        spots = (cells == UNKNOWN_CELL).astype(np.uint8)
        _, labels, stats, _ = cv2.connectedComponentsWithStats(spots, connectivity=4)
        small = stats[:, cv2.CC_STAT_AREA] < rng.uniform(4, 200)
        small[0] = False
        cells[small[labels]] = FREE_CELL
    return cells


def warp(images: list[NDArray], rng: np.random.Generator) -> list[NDArray]:
    """The images moved alike by a smooth field: the drift of the robot."""
    strength = rng.choice([0.0, rng.uniform(0, 3), rng.uniform(2, 8)], p=[0.4, 0.4, 0.2])
    if strength == 0:
        return images
    height, width = images[0].shape
    knots = (max(3, height // 200 + 2), max(3, width // 200 + 2))
    fields = [cv2.resize(rng.normal(0, strength, knots), (width, height), interpolation=cv2.INTER_CUBIC) for _ in range(2)]
    cols, rows = np.meshgrid(np.arange(width), np.arange(height))
    x, y = (cols + fields[0]).astype(np.float32), (rows + fields[1]).astype(np.float32)
    return [cv2.remap(image, x, y, cv2.INTER_NEAREST) for image in images]


def to_cells(cells: NDArray[np.uint8], classes: NDArray[np.uint8], rooms: NDArray[np.int32], coarse: bool) -> dict[str, NDArray]:
    """The lesson at CELL metres."""
    height, width = (size // 2 * 2 for size in cells.shape)

    def blocks(image: NDArray) -> NDArray:
        return image[:height, :width].reshape(height // 2, 2, width // 2, 2).swapaxes(1, 2).reshape(height // 2, width // 2, 4)

    parts = blocks(cells)
    if coarse:
        occupied = (parts == OCCUPIED_CELL).any(-1) * 4
        free = np.where(occupied, 0, (parts == FREE_CELL).any(-1) * 4)
    else:
        occupied, free = (parts == OCCUPIED_CELL).sum(-1), (parts == FREE_CELL).sum(-1)
    true = blocks(classes)
    pooled = true[..., 0].copy()
    for name in (FURNITURE, WALL, DOOR):
        # A thin wall is not lost among floor
        pooled[(true == name).sum(-1) >= (2 if name == FURNITURE else 2)] = name
    room = blocks(rooms).max(-1)
    room[(pooled == WALL) | (pooled == DOOR) | (pooled == OUTSIDE)] = 0
    seen = ((occupied + free) > 0).astype(np.uint8)
    # A room that the robot did not see at all is outside of what the map shows
    size = np.bincount(room.ravel())
    unseen = np.bincount(room.ravel(), free.ravel() > 0, len(size)) < MIN_SEEN_SHARE * size
    unseen[0] = False
    pooled[unseen[room]] = OUTSIDE
    room[unseen[room]] = 0
    near = cv2.distanceTransform(1 - seen, cv2.DIST_L2, 3) <= UNSEEN_REACH / CELL
    return {
        "free": free.astype(np.uint8),
        "occupied": occupied.astype(np.uint8),
        "classes": pooled,
        "rooms": room.astype(np.uint16),
        "counts": near | (pooled == OUTSIDE),
    }


def make_lesson(drawn: list[Floor], rng: np.random.Generator) -> dict[str, NDArray] | None:
    """A lesson, cut to what was seen; None if the floor is too large, or little was seen."""
    floor, scale = draw_floor(drawn, rng)
    bounds = shapely.total_bounds([room.polygon for room in floor.rooms])
    if max(bounds[2] - bounds[0], bounds[3] - bounds[1]) * scale > MAX_SIDE:
        return None
    world = build_world(floor, scale, rng)
    cells = degrade(map_world(world, rng), rng)
    cells, classes, rooms = warp([cells, world.classes, world.rooms.astype(np.float32)], rng)
    lesson = to_cells(cells, classes, rooms.astype(np.int32), coarse=rng.random() < 0.15)
    rows, cols = np.nonzero(lesson["free"])
    if len(rows) < 500:
        return None
    window = np.s_[max(rows.min() - 12, 0) : rows.max() + 13, max(cols.min() - 12, 0) : cols.max() + 13]
    return {name: image[window] for name, image in lesson.items()}


def main() -> None:
    """Make lessons for some minutes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--data", type=Path)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    drawn = list_drawn_floors(find_data(options.data))
    stop, number = time.monotonic() + 60 * options.minutes, 0
    while time.monotonic() < stop:
        rng = np.random.default_rng([options.seed, number])
        number += 1
        try:
            lesson = make_lesson(drawn, rng)
        except (PiantaError, shapely.errors.GEOSException):
            continue
        if lesson is not None:
            path = options.folder / f"{options.seed:03d}_{number:06d}.npz"
            np.savez_compressed(path.with_suffix(".part.npz"), **lesson)
            path.with_suffix(".part.npz").rename(path)


if __name__ == "__main__":
    main()
