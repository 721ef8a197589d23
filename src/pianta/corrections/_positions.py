"""Rooms and doors at positions, and positions for rooms."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import shapely
from shapely import LineString, Point, Polygon

from pianta.corrections.kinds import XY, Points, check_positions, describe_points
from pianta.errors import CorrectionError
from pianta.floor import Door, Floor, Room

# The constants were chosen by hand.
# A position that is in no room is in the nearest one, if that is nearer than this: half a wall and the error of a map.
NEAR_ROOM = 0.3  # metres
# A door is at a position if its line is nearer than this: the width of a door.
NEAR_DOOR = 0.9  # metres
# Precision of a position in a room.
POSITION_TOLERANCE = 0.05  # metres
# Digits of coordinates after the point: millimetres.
DIGITS = 3


def find_room(floor: Floor, position: XY) -> Room:
    """The room at a position.

    Raises CorrectionError without one.
    """
    check_positions(position)
    room = find_nearest_room(floor.rooms, position)
    if room is None:
        raise CorrectionError(f"there is no room at {describe_points(position)}, give a position inside a room")
    return room


def find_nearest_room(rooms: Iterable[Room], position: XY, *, reach: float = NEAR_ROOM) -> Room | None:
    """The room nearest to a position, if it is within reach, metres."""
    point = Point(position)
    candidates = [(room.polygon.distance(point), room.id, room) for room in rooms]
    distance, _, room = min(candidates, key=lambda candidate: candidate[:2], default=(np.inf, 0, None))
    return room if distance <= reach else None


def find_door(floor: Floor, position: XY) -> Door:
    """The door or opening at a position.

    Raises CorrectionError without one.
    """
    door = find_nearest_door(floor, position)
    if door is None:
        raise CorrectionError(f"no door is within {NEAR_DOOR} m of {describe_points(position)}, give a position on one")
    return door


def find_nearest_door(floor: Floor, position: XY) -> Door | None:
    """The door or opening nearest to a position, if it is within NEAR_DOOR."""
    check_positions(position)
    point = Point(position)
    nearest = min(floor.doors, key=lambda door: (door.line.distance(point), middle_of(door.line)), default=None)
    return nearest if nearest is not None and nearest.line.distance(point) <= NEAR_DOOR else None


def position_in(polygon: Polygon) -> XY:
    """A position deep inside a room: the centre of a largest circle in it."""
    centre = shapely.get_coordinates(shapely.maximum_inscribed_circle(polygon, POSITION_TOLERANCE))[0]
    x, y = (round(float(value), DIGITS) for value in centre)
    return x, y


def middle_of(line: LineString) -> XY:
    """The middle of a door."""
    point = line.interpolate(0.5, normalized=True)
    return round(point.x, DIGITS), round(point.y, DIGITS)


def draw_line(points: Points) -> LineString:
    """A line of a correction.

    Raises CorrectionError for one without length.
    """
    check_positions(*points)
    line = LineString(points) if len(points) >= 2 else LineString()
    if line.length < POSITION_TOLERANCE:
        raise CorrectionError(f"the line {describe_points(*points)} has no length, give two points or more")
    return line


def draw_outline(points: Points) -> Polygon:
    """An outline of a correction.

    Raises CorrectionError for one that crosses itself or has no area.
    """
    check_positions(*points)
    outline = Polygon(points) if len(points) >= 3 else Polygon()
    if not outline.is_valid or outline.area < POSITION_TOLERANCE:
        raise CorrectionError(
            f"the outline {describe_points(*points)} crosses itself or has no area, give its corners in order"
        )
    return outline
