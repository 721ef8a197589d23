"""Doors and openings between exact rooms: drawn doors, and borders of two rooms without a wall."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from shapely import LineString, Point, STRtree
from shapely.ops import substring

from pianta._types import Floats
from pianta.floor import Door, Room
from pianta.io.drawings._ifc_passages import rooms_beside

# Limits against hostile files.
MAX_DOORS = 20_000
MAX_PAIRS = 50_000

# Metres.
DOOR_WIDTHS = (0.5, 4.0)  # of what is drawn as a door: from a closet to a gate
MAX_WALL = 0.6  # between two rooms that an opening joins
OPENING_WIDTHS = (0.6, 30.0)
WALL_TOLERANCE = 0.12  # from a border to the lines of its wall, beyond the gap
MIN_WALLED_SHARE = 0.5  # of all borders have lines of walls: else the file draws walls only here and there
STEP = 0.05  # along borders


def find_passages(rooms: Sequence[Room], *, named: Floats, unnamed: Floats, walls: Floats) -> list[Door]:
    """Doors between rooms, all in metres.

    named: doors that the file names, from jamb to jamb, shape (D, 2, 2). unnamed: leaves with arcs, likewise.
    walls: lines of walls, shape (N, 2, 2); where two rooms meet without one, they are open to each other.
    A door that leads from a room into the same room, as of a wardrobe, is left out.
    """
    doors: list[Door] = []
    for ends in [*named[:MAX_DOORS], *unnamed[:MAX_DOORS]]:
        door = _door_at(ends, rooms)
        if door is not None and not any(_is_same_place(door, other) for other in doors):
            doors.append(door)
    return [*doors, *_find_openings(rooms, doors, walls)]


def _door_at(ends: Floats, rooms: Sequence[Room]) -> Door | None:
    line = LineString(ends)
    least, most = DOOR_WIDTHS
    if not least <= line.length <= most:
        return None
    near = [room for room in rooms if shapely.dwithin(room.polygon, line, 1.0)]
    beside = rooms_beside(line, near)
    if not beside or (len(beside) == 2 and beside[0] == beside[1]):
        return None
    return Door((beside[0], beside[1] if len(beside) == 2 else None), line, float(line.length))


def _is_same_place(one: Door, other: Door) -> bool:
    return one.rooms == other.rooms and bool(one.line.centroid.distance(other.line.centroid) < one.width / 2)


def _find_openings(rooms: Sequence[Room], doors: Sequence[Door], walls: Floats) -> list[Door]:
    """Openings where the border of two rooms has no line of a wall and no door; none if borders rarely have walls."""
    if not len(walls) or len(rooms) < 2:
        return []
    shapes = np.array([room.polygon for room in rooms], object)
    first, second = STRtree(shapes).query(shapes, predicate="dwithin", distance=MAX_WALL)
    pairs = [(i, j) for i, j in zip(first.tolist(), second.tolist(), strict=True) if i < j][:MAX_PAIRS]
    lines = shapely.linestrings(walls)
    tree = STRtree(lines)
    total, walled, openings = 0.0, 0.0, []
    for one, other in pairs:
        for border, gap in _borders(rooms[one], rooms[other]):
            near = tree.query(border, predicate="dwithin", distance=gap + WALL_TOLERANCE)
            along = [line for line in lines[near] if _is_along(line, border)]
            cover = shapely.union_all([line.buffer(gap + WALL_TOLERANCE, cap_style="flat") for line in along])
            total += border.length
            walled += shapely.intersection(border, cover).length if along else 0.0
            between = [
                door.line.buffer(MAX_WALL) for door in doors if set(door.rooms) == {rooms[one].id, rooms[other].id}
            ]
            free = shapely.difference(border, shapely.union_all([cover, *between])) if along or between else border
            openings += [
                Door((rooms[one].id, rooms[other].id), part, float(part.length), "opening")
                for part in _long_parts(free)
            ]
    return openings if total and walled >= MIN_WALLED_SHARE * total else []


def _borders(one: Room, other: Room) -> Iterator[tuple[LineString, float]]:
    """The straight stretches of the outline of a room that face another one, and the gap between both."""
    facing = shapely.intersection(
        one.polygon.exterior, other.polygon.buffer(MAX_WALL, cap_style="flat", join_style="mitre")
    )
    merged = shapely.line_merge(facing) if facing.geom_type == "MultiLineString" else facing
    for part in shapely.get_parts(merged):
        if not isinstance(part, LineString):
            continue
        for start, end in zip(part.coords, part.coords[1:], strict=False):
            side = LineString([start, end])
            if side.length < OPENING_WIDTHS[0]:
                continue
            gap = float(shapely.distance(side.interpolate(0.5, normalized=True), other.polygon))
            facing_part = _facing_part(side, other, gap)
            if facing_part is not None and gap <= MAX_WALL:
                yield facing_part, gap


def _facing_part(side: LineString, other: Room, gap: float) -> LineString | None:
    """The stretch of a side straight across which the other room lies."""
    steps = np.linspace(0, side.length, max(3, int(side.length / STEP) + 1))[:2000]
    points = shapely.line_interpolate_point(side, steps)
    across = steps[shapely.distance(points, other.polygon) <= gap + WALL_TOLERANCE / 2]
    if len(across) < 2 or across[-1] - across[0] < OPENING_WIDTHS[0]:
        return None
    part = substring(side, float(across[0]), float(across[-1]))
    return part if isinstance(part, LineString) else None


def _is_along(line: LineString, border: LineString) -> bool:
    (ax, ay), (bx, by) = line.coords[0], line.coords[-1]
    (cx, cy), (dx, dy) = border.coords[0], border.coords[-1]
    cross = abs((bx - ax) * (dy - cy) - (by - ay) * (dx - cx))
    return bool(cross <= 0.2 * line.length * border.length)


def _long_parts(free: shapely.Geometry) -> list[LineString]:
    least, most = OPENING_WIDTHS
    parts = [part for part in shapely.get_parts(free) if isinstance(part, LineString)]
    return [part for part in parts if least <= part.length <= most and not isinstance(part, Point)]
