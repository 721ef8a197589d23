"""Rooms that reach to the lines of their doors, for formats in which rooms and doors share points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from shapely import LineString, MultiPoint, Point, Polygon
from shapely.ops import nearest_points

from pianta.floor import Door, Floor

# How far the doorway reaches into the room, so that both overlap, metres; chosen by hand.
OVERLAP = 0.05
# A line further from the outline of its room is not joined, metres: thicker than walls are.
REACH = 1.5
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
    """The polygon of each room by its id, up to the lines of its doors, whose points are corners of it."""
    polygons = {room.id: room.polygon for room in floor}
    for door in floor.doors:
        points = place_points(door)
        for room_id in door.room_ids:
            polygons[room_id] = _insert_points(_reach(polygons[room_id], points), points)
    return polygons


def _reach(polygon: Polygon, points: DoorPoints) -> Polygon:
    """The polygon with the doorway between the door and its outline, unless that would divide it."""
    ends = [Point(points.start), Point(points.end)]
    if any(polygon.distance(end) > REACH for end in ends) or max(map(polygon.boundary.distance, ends)) < SAME:
        return polygon
    inner = [*_step_inside(polygon, ends)]
    doorway = MultiPoint([*ends, *inner]).convex_hull
    # Where a doorway is no strip, the outline stays as it is
    if not isinstance(doorway, Polygon) or LineString([points.start, points.end]).crosses(polygon):
        return polygon
    joined = polygon.union(doorway)
    return joined if isinstance(joined, Polygon) and joined.is_valid else polygon


def _step_inside(polygon: Polygon, ends: list[Point]) -> Iterator[Point]:
    """The points of the outline that are nearest to the ends, moved on into the room."""
    for end in ends:
        near, _ = nearest_points(polygon, end)
        distance = near.distance(end)
        share = OVERLAP / distance if distance > SAME else 0.0
        yield Point(near.x + share * (near.x - end.x), near.y + share * (near.y - end.y))


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
