"""Doors, windows, stairs, furniture and signs of a drawn plan, as marks in metres."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike
from shapely import LineString, Point, Polygon, affinity, box, contains_xy, get_coordinates, unary_union
from shapely.geometry.base import BaseGeometry

from pianta._types import Floats
from pianta.floor import Door, Floor, Room
from pianta.plan.symbols.drawings import SYMBOLS, WALL_DEPTH, Mark
from pianta.worlds.wall_axes import INNER_WALL, OUTER_WALL

DoorStyle = Literal["arc", "arc 45", "leaf", "leaf 45", "sliding", "double", "gap"]
DOOR_STYLES: tuple[DoorStyle, ...] = get_args(DoorStyle)
SYMBOL_OF_STYLE = {
    "arc": "door",
    "arc 45": "door 45",
    "leaf": "leaf",
    "leaf 45": "leaf 45",
    "sliding": "sliding door",
    "double": "door",
}

# The sizes are usual ones (chosen by hand); lengths in metres.
# Width of a double door.
DOUBLE_WIDTH = 1.6
# Wall beside a double door on each side, at least.
WALL_BESIDE_DOOR = 0.2
WINDOW_WIDTH = 1.5
# Length of wall for each window, at least.
WINDOW_SPACING = 2.4
# Distance from the axis of an inner wall to a point that is certainly in the room.
OFF_WALL = INNER_WALL / 2 + 0.02
# Share of the doors that swing into the room with the smaller id, which is the passage in floors of worlds.
OUTWARDS_SHARE = 0.1
SIGN_SIZE = 0.7
# Least distance between two signs.
SIGN_SPACING = 2.5
SIGNS = ("way out", "extinguisher", "way out", "exit", "way out", "hydrant", "way out", "first aid")
# Floor area per piece of furniture at density 1; m².
AREA_PER_PIECE = 5.0
# Attempts to place each piece.
MAX_ATTEMPTS = 12
# Clear space between furniture and doors, walls and other pieces.
DOOR_CLEARANCE = 1.1
WALL_CLEARANCE = 0.1
PIECE_CLEARANCE = 0.3


@dataclass(frozen=True)
class Window:
    """A window: the middle line of its gap in the wall, and the thickness of the wall, metres."""

    line: LineString
    wall: float = OUTER_WALL


def widen_doors(floor: Floor) -> Floor:
    """The floor with all doors widened to DOUBLE_WIDTH that have enough wall beside them."""
    doors = list(floor.doors)
    polygons = {room.id: room.polygon for room in floor.rooms}
    for index, door in enumerate(floor.doors):
        wider = _widen_door(door, polygons)
        others = [other.line for other in doors if other is not door]
        if wider and all(wider.line.distance(line) > WALL_BESIDE_DOOR for line in others):
            doors[index] = wider
    return replace(floor, doors=tuple(doors))


def _widen_door(door: Door, polygons: dict[int, Polygon]) -> Door | None:
    """The door with DOUBLE_WIDTH; None if a wall ends too near."""
    if not door.joins_rooms or not door.line.length:
        return None
    middle, along, across = _frame_of_line(door.line)
    needed = along * (DOUBLE_WIDTH / 2 + WALL_BESIDE_DOOR)
    for off in (-OFF_WALL, OFF_WALL):
        face = LineString([middle - needed + across * off, middle + needed + across * off])
        if not any(polygons[room].contains(face) for room in door.room_ids):
            return None
    half = along * DOUBLE_WIDTH / 2
    return replace(door, line=LineString([middle - half, middle + half]), width=DOUBLE_WIDTH)


def _frame_of_line(line: LineString) -> tuple[Floats, Floats, Floats]:
    """Middle of a straight line, and the unit vectors along it and to its left."""
    first, last = get_coordinates(line)[[0, -1]]
    along = (last - first) / np.hypot(*(last - first))
    return (first + last) / 2, along, np.array([-along[1], along[0]])


def mark_doors(floor: Floor, style: DoorStyle, *, wall: float, rng: np.random.Generator) -> list[Mark]:
    """Marks of all doors of a floor, without openings; their leaves hang in a face of the wall.

    wall: thickness of the drawn walls, metres. Doors of DOUBLE_WIDTH have two leaves if the style is "double".
    """
    marks: list[Mark] = []
    polygons = {room.id: room.polygon for room in floor.rooms}
    for door in floor.doors:
        turned, outwards = rng.random() < 0.5, rng.random() < OUTWARDS_SHARE
        if style == "gap" or door.kind == "opening" or not door.line.length:
            continue
        twice = style == "double" and door.width >= DOUBLE_WIDTH
        symbol = SYMBOLS["double door" if twice else SYMBOL_OF_STYLE[style]]
        into = polygons[door.room_ids[0 if outwards else -1]]
        marks += place_marks(symbol.marks, *_frame_of_door(door, into, wall, turned=turned, units=1 + twice))
    return marks


def _frame_of_door(
    door: Door, into: Polygon, wall: float, *, turned: bool, units: int
) -> tuple[Floats, Floats, Floats]:
    """Origin and axes, metres, of a symbol that is units wide and swings into a room."""
    middle, along, across = _frame_of_line(door.line)
    inwards = across if into.distance(Point(middle + across)) < into.distance(Point(middle - across)) else -across
    along = -along if turned else along
    width = door.line.length
    # Symbols swing to where y is negative.
    return middle - along * width / 2 + inwards * wall / 2, along * width / units, -inwards * width / units


def find_windows(floor: Floor, footprint: BaseGeometry) -> list[Window]:
    """Windows in all outer walls that are long enough, evenly along each.

    footprint: the floor with its outer walls, metres.
    """
    return [window for room in floor.rooms for window in _find_windows(room.polygon, footprint)]


def _find_windows(room: Polygon, footprint: BaseGeometry) -> Iterator[Window]:
    """Windows evenly along the outer walls of a room; footprint: the floor with its outer walls, metres."""
    for ends in pairwise(get_coordinates(room.exterior)):
        side = LineString(ends)
        count = int(side.length / WINDOW_SPACING)
        if not count:
            continue
        _, along, left = _frame_of_line(side)
        for share in (np.arange(count) + 0.5) / count:
            middle = ends[0] + (ends[1] - ends[0]) * share - left * OUTER_WALL / 2
            jambs = [middle - along * WINDOW_WIDTH / 2, middle + along * WINDOW_WIDTH / 2]
            beyond = [jamb - left * (OUTER_WALL / 2 + 0.1) for jamb in jambs]
            if not footprint.intersects(LineString(beyond)):
                yield Window(LineString(jambs))


def mark_windows(windows: Sequence[Window], panes: int) -> list[Mark]:
    """Marks of windows as 2 or 3 lines along the wall."""
    symbol = SYMBOLS["window 3" if panes == 3 else "window"]
    marks: list[Mark] = []
    for window in windows:
        middle, along, across = _frame_of_line(window.line)
        unit = along * WINDOW_WIDTH / 1.5
        marks += place_marks(symbol.marks, middle - along * WINDOW_WIDTH / 2, unit, across * window.wall / WALL_DEPTH)
    return marks


def mark_room_symbol(room: Room) -> list[Mark]:
    """Stairs or a lift in the middle of a room with that label, as large as fits; empty for other rooms."""
    name = {"STAIRS": "stairs", "ELEVATOR": "lift"}.get(room.label or "")
    if name is None:
        return []
    points = np.concatenate([mark.points for mark in SYMBOLS[name].marks])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    (x0, y0, x1, y1), (width, height) = room.polygon.bounds, np.ptp(points, axis=0)
    upright = (y1 - y0) > (x1 - x0)
    long_side, short_side = max(x1 - x0, y1 - y0) - 0.2, min(x1 - x0, y1 - y0) - 0.2
    unit = min(long_side / width, short_side / height, 1.2)
    x_axis = np.array([0.0, 1.0] if upright else [1.0, 0.0]) * unit
    y_axis = np.array([x_axis[1], -x_axis[0]])
    origin = np.array([(x0 + x1) / 2, (y0 + y1) / 2]) - middle[0] * x_axis - middle[1] * y_axis
    return place_marks(SYMBOLS[name].marks, origin, x_axis, y_axis)


def mark_signs(room: BaseGeometry, rng: np.random.Generator) -> list[Mark]:
    """Signs of an evacuation map in a room: those of SIGNS, in turn."""
    marks: list[Mark] = []
    for index, point in enumerate(_space_points(room.buffer(-SIGN_SIZE))):
        name = SIGNS[index % len(SIGNS)]
        size = SIGN_SIZE / (1.6 if name == "way out" else 1)
        middle = np.array([0.8, 0.3] if name == "way out" else [0.5, 0.5]) * size
        side = -1 if name == "way out" and rng.random() < 0.5 else 1
        corner = point + np.array([-middle[0] * side, middle[1]])
        marks += place_marks(SYMBOLS[name].marks, corner, (size * side, 0), (0, -size))
    return marks


def _space_points(area: BaseGeometry) -> list[Floats]:
    """Points of an area at least SIGN_SPACING apart; empty for an empty area."""
    if area.is_empty:
        return []
    x0, y0, x1, y1 = area.bounds
    xs, ys = np.arange(x0 + 0.1, x1, 0.4), np.arange(y0 + 0.1, y1, 0.4)
    grid = np.column_stack([np.repeat(xs, len(ys)), np.tile(ys, len(xs))])
    points: list[Floats] = []
    for point in grid[contains_xy(area, *grid.T)]:
        if all(np.hypot(*(point - other)) >= SIGN_SPACING for other in points):
            points.append(point)
    return points


def mark_furniture(
    room: Room, doors: Sequence[Door], *, density: float, blocked: BaseGeometry, rng: np.random.Generator
) -> list[Mark]:
    """Outlines of desks with chairs, round tables and shelves, clear of doors and of each other.

    density: 0 empty … 1 as full as in a furniture catalogue. blocked: area without furniture, metres.
    """
    at_doors = [door.line.buffer(DOOR_CLEARANCE) for door in doors if room.id in door.room_ids]
    clear = room.polygon.buffer(-WALL_CLEARANCE).difference(unary_union([*at_doors, blocked]))
    wanted = round(density * room.polygon.area / AREA_PER_PIECE)
    placed: list[BaseGeometry] = []
    marks: list[Mark] = []
    for _ in range(MAX_ATTEMPTS * wanted):
        pieces = _draw_pieces(room.polygon, rng)
        outline = unary_union(pieces)
        if clear.contains(outline) and all(outline.distance(other) > PIECE_CLEARANCE for other in placed):
            placed.append(outline)
            marks += [Mark(get_coordinates(piece.exterior)[:-1], closed=True) for piece in pieces]
        if len(placed) == wanted:
            break
    return marks


def _draw_pieces(room: Polygon, rng: np.random.Generator) -> list[Polygon]:
    """The outlines of one piece of furniture at a random position in the bounds of a room."""
    piece_type = int(rng.integers(4))
    chair = box(-0.22, -0.22, 0.22, 0.22)
    if piece_type == 0:
        pieces = [box(-0.8, -0.4, 0.8, 0.4), affinity.translate(chair, 0, -0.7)]
    elif piece_type == 1:
        around = [affinity.translate(chair, *(0.85 * step)) for step in np.array([(1, 0), (0, 1), (-1, 0), (0, -1)])]
        pieces = [Point(0, 0).buffer(0.55, quad_segs=8), *around]
    elif piece_type == 2:
        pieces = [box(-0.7, -0.2, 0.7, 0.2)]
    else:
        pieces = [box(-1.2, -0.45, 0.0, 0.45), box(0.0, -0.45, 1.2, 0.45)]
        pieces += [affinity.translate(chair, x, y) for x in (-0.6, 0.6) for y in (-0.75, 0.75)]
    x0, y0, x1, y1 = room.bounds
    position = x0 + (x1 - x0) * rng.random(), y0 + (y1 - y0) * rng.random()
    angle = 90 * int(rng.integers(4))
    return [affinity.translate(affinity.rotate(piece, angle, origin=(0, 0)), *position) for piece in pieces]


def place_marks(marks: Sequence[Mark], origin: ArrayLike, x_axis: ArrayLike, y_axis: ArrayLike) -> list[Mark]:
    """Marks transformed into a frame with an origin and two axes, given as vectors."""
    axes = np.array([x_axis, y_axis], float)
    return [replace(mark, points=mark.points @ axes + np.asarray(origin, float)) for mark in marks]
