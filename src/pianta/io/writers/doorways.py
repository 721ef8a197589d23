"""Rooms that reach to the lines of their doors, for formats in which rooms and doors share points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import hypot

from shapely import LineString, MultiPolygon, Point, Polygon, unary_union

from pianta.floor import Door, Floor

# How far a room may be from the line of its door, or reach across it, metres: half of a thick wall; chosen by hand.
REACH = 0.6
# What is cut off across a door may be as large, square metres; a room that would lose more keeps its outline.
MAX_LOST = 0.5
# Points are one if they are as close, metres.
SAME = 1e-6

XY = tuple[float, float]


@dataclass(frozen=True)
class DoorPoints:
    """The ends of a door and the middle between them, which are corners of the outlines of its rooms."""

    start: XY
    middle: XY
    end: XY


def place_points(door: Door) -> DoorPoints:
    """The points of a door; those of a line that is not straight are its ends and the middle between them."""
    (x0, y0), (x1, y1) = door.line.coords[0][:2], door.line.coords[-1][:2]
    return DoorPoints((x0, y0), ((x0 + x1) / 2, (y0 + y1) / 2), (x1, y1))


def reach_doors(floor: Floor) -> Mapping[int, Polygon]:
    """The polygon of each room by its id, up to the lines of its doors, whose points are corners of it.

    Outlines of maps end before a door, or reach across it by some cells.
    """
    polygons = {room.id: room.polygon for room in floor}
    for door in floor.doors:
        points = place_points(door)
        if points.start != points.end:
            for room_id, side in _choose_sides(polygons, door, points).items():
                polygons[room_id] = _insert_points(_reach(polygons[room_id], points, side), points)
    return polygons


def _choose_sides(polygons: Mapping[int, Polygon], door: Door, points: DoorPoints) -> Mapping[int, int]:
    """For each room of a door 1 if it is left of the line from start to end, and -1 if it is right of it."""
    left, right = (_make_strip(points, side) for side in (1, -1))
    leaning = {
        room: polygons[room].intersection(left).area - polygons[room].intersection(right).area for room in door.room_ids
    }
    ordered = sorted(leaning, key=lambda room: -leaning[room])
    if len(ordered) == 1:
        return {ordered[0]: 1 if leaning[ordered[0]] > 0 else -1}
    return dict(zip(ordered, (1, -1), strict=True))


def _make_strip(points: DoorPoints, side: int) -> Polygon:
    """The rectangle on one side of a door, as wide as the door and REACH deep."""
    (x0, y0), (x1, y1) = points.start, points.end
    length = hypot(x1 - x0, y1 - y0)
    dx, dy = -(y1 - y0) / length * REACH * side, (x1 - x0) / length * REACH * side
    return Polygon([(x0, y0), (x1, y1), (x1 + dx, y1 + dy), (x0 + dx, y0 + dy)])


def _reach(polygon: Polygon, points: DoorPoints, side: int) -> Polygon:
    """The polygon with the doorway up to the line of the door, and without what it has across the line."""
    near = polygon.intersection(_make_strip(points, side))
    if near.area <= 0:
        return polygon
    doorway = unary_union([near, LineString([points.start, points.end])]).convex_hull
    joined = polygon.difference(_make_strip(points, -side)).union(doorway)
    largest = max(joined.geoms, key=lambda part: part.area) if isinstance(joined, MultiPolygon) else joined
    is_usable = isinstance(largest, Polygon) and largest.is_valid and polygon.difference(largest).area <= MAX_LOST
    return largest if is_usable else polygon


def _insert_points(polygon: Polygon, points: DoorPoints) -> Polygon:
    """The polygon with the points of a door as corners, where they are on its outline."""
    rings = []
    for ring in (polygon.exterior, *polygon.interiors):
        corners = [(x, y) for x, y, *_ in ring.coords]
        for point in (points.start, points.middle, points.end):
            corners = _insert_point(corners, point)
        rings.append(corners)
    inserted = Polygon(rings[0], rings[1:])
    return inserted if inserted.is_valid else polygon


def _insert_point(corners: list[XY], point: XY) -> list[XY]:
    """The corners of a ring, the first again at the end, with a point on one of its sides, or as they are."""
    location = Point(point)
    if LineString(corners).distance(location) > SAME:
        return corners
    for index, corner in enumerate(corners):
        if location.distance(Point(corner)) <= SAME:
            moved = [*corners]
            moved[index] = point
            if index in (0, len(corners) - 1):
                moved[0] = moved[-1] = point
            return moved
    sides = [LineString(side).distance(location) for side in pairwise(corners)]
    side = sides.index(min(sides))
    return [*corners[: side + 1], point, *corners[side + 1 :]]
