"""Corrections of doors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import shapely
from shapely import LineString, Point

from pianta.corrections._positions import (
    POSITION_TOLERANCE,
    draw_line,
    find_door,
    find_nearest_door,
    find_nearest_room,
)
from pianta.corrections.kinds import ChangeDoor, DeleteDoor, DoorKind, DrawDoor, MoveDoor, Points, describe_points
from pianta.errors import CorrectionError
from pianta.floor import Door, Floor

# The constants were chosen by hand.
# Rooms on both sides of a door are looked for up to this far from it, in such steps: thick walls and the error of maps.
SIDE_REACH = 0.8  # metres
SIDE_STEP = 0.1  # metres
# Doors between the same rooms whose lines are nearer than this are the same.
SAME_DOOR = 0.5  # metres


def draw_door(floor: Floor, correction: DrawDoor) -> Floor:
    """A new door or opening between the rooms on both sides of a line; a possible door there is gone."""
    return _add_door(floor, correction.line, correction.door)


def move_door(floor: Floor, correction: MoveDoor) -> Floor:
    """The floor with a door elsewhere."""
    door = find_door(floor, correction.position)
    without = replace(floor, doors=tuple(each for each in floor.doors if each is not door))
    return _add_door(without, correction.line, door.kind)


def delete_door(floor: Floor, correction: DeleteDoor) -> Floor:
    """The floor without a door or opening; the same floor if none is there."""
    door = find_nearest_door(floor, correction.position)
    return replace(floor, doors=tuple(each for each in floor.doors if each is not door)) if door else floor


def change_door(floor: Floor, correction: ChangeDoor) -> Floor:
    """The floor with an opening instead of a door, or the other way round."""
    door = find_door(floor, correction.position)
    if door.kind == correction.door:
        return floor
    changed = replace(door, kind=correction.door, probability=1.0)
    return replace(floor, doors=tuple(changed if each is door else each for each in floor.doors))


def _add_door(floor: Floor, points: Points, door_kind: DoorKind) -> Floor:
    line = draw_line(points)
    if Point(points[0]).distance(Point(points[-1])) < POSITION_TOLERANCE:
        raise CorrectionError(f"the door {describe_points(*points)} ends where it starts, draw it from jamb to jamb")
    one, other = (find_beside(floor, line, side) for side in (1, -1))
    if one is None and other is None:
        raise CorrectionError(f"no room is beside the door {describe_points(*points)}, draw it in a wall of a room")
    if one == other:
        raise CorrectionError(f"room {one} is on both sides of the door {describe_points(*points)}, split it first")
    rooms = (one, other) if one is not None else (other, None)
    door = Door(rooms, line, line.length, door_kind, 1.0)  # type: ignore[arg-type]
    if any(_is_same(each, door) for each in floor.doors):
        return floor
    possible = tuple(each for each in floor.possible_doors if each.line.distance(line) > SAME_DOOR)
    return replace(floor, doors=(*floor.doors, door), possible_doors=possible)


def find_beside(floor: Floor, line: LineString, side: int) -> int | None:
    """The id of the first room on one side of the middle of a line; None without one."""
    ends = shapely.get_coordinates(line)[[0, -1]]
    along = ends[1] - ends[0]
    normal = np.array([-along[1], along[0]]) / np.hypot(*along) * side
    middle = np.array(line.interpolate(0.5, normalized=True).coords[0])
    for distance in np.arange(SIDE_STEP, SIDE_REACH + SIDE_STEP / 2, SIDE_STEP):
        x, y = middle + normal * distance
        room = find_nearest_room(floor.rooms, (x, y), reach=0)
        if room is not None:
            return room.id
    return None


def _is_same(one: Door, other: Door) -> bool:
    """Whether two doors join the same rooms at the same position in the same way."""
    if one.rooms != other.rooms or one.kind != other.kind:
        return False
    middle = Point(other.line.interpolate(0.5, normalized=True))
    nearer = one.line.interpolate(0.5, normalized=True).distance(middle) < SAME_DOOR / 2
    return nearer and abs(one.width - other.width) < SAME_DOOR / 2
