"""Rooms that a person has confirmed are read as in the previous map, as far as the map has not changed.

Two maps of a building, one of which is turned or has grown, are often divided into other rooms though their walls are
the same: one reading finds a room where the other finds two. A person who corrects a room says which reading is right
(`pianta.corrections.confirmed`). The outline of that room on the previous floor, without corrections, is moved into the
new frame, and the new reading must explain where it differs:

- Two new rooms within the outline are one room, unless the new map has a wall along most of the border between them
  that the previous map has not.
- A new room that covers the outline and also most of another previous room is divided along the outline, unless most of
  the wall along it is gone.
- What was free must still be free, else the room is another one.
- A new room that covers the outline and what no previous room covered has grown, and stays as it is.

So a wall that is new in the map, or is gone from it, has priority over what a person has confirmed; every correction is
applied after this, so that a later one has priority over it too. Other rooms are as the map was read, but for what
confirmed rooms take from them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from pianta.corrections._doors import find_beside
from pianta.corrections._positions import middle_of
from pianta.floor import Door, Floor, Room
from pianta.floor.polygons import find_largest_polygon, list_polygons
from pianta.floor.shapes import MIN_ROOM
from pianta.layout.room_ids import MIN_COMMON_SHARE, SAME_OUTLINE_IOU, move_floor
from pianta.reading._map_change import MapChange

# The constants were chosen by hand.
# What was free must be free in this share, so that nothing else stands where the room was.
MIN_STILL_FREE = 0.8
# Rooms that are nearer than this have a border; metres.
BORDER_REACH = 0.6
# A border that is nearer to an outline than this is the same; metres.
SAME_BORDER = 0.25
# Parts of rooms that are narrower than this are the error of outlines and no rooms; metres.
MIN_WIDTH = 0.5
# Doors whose middles are nearer than this are the same; metres.
SAME_DOOR = 0.5


@dataclass(frozen=True)
class Restored:
    """A floor, and how many rooms of it have their previous outline again."""

    floor: Floor
    count: int = 0


def restore_rooms(floor: Floor, previous: Floor, confirmed: Sequence[Room], change: MapChange) -> Restored:
    """The floor with those of the confirmed rooms whose place in the map has not changed.

    previous: the floor that the confirmed rooms are of, in its own frame.
    """
    if not confirmed or not change.is_known:
        return Restored(floor)
    old = move_floor(previous, change.motion)
    ids = {room.id for room in confirmed}
    restored: list[int] = []
    # Doors lead to rooms that may go; they are found again at the end
    now = replace(floor, doors=(), possible_doors=())
    # The largest first, in a fixed order
    for room in sorted((room for room in old if room.id in ids), key=lambda room: (-room.polygon.area, room.id)):
        others = [each.polygon for each in old if each.id != room.id]
        occupied = shapely.union_all([now[room_id].polygon for room_id in restored])
        outline = find_largest_polygon(shapely.difference(room.polygon, occupied))
        touched = [each for each in now if each.id not in restored and each.polygon.intersects(outline)]
        own = [each for each in touched if _descends(each.polygon, outline)]
        if not own or _has_changed(outline, [each.polygon for each in touched], others, change):
            continue
        shape = _grow(outline, own, others)
        if max(_measure_iou(shape, each.polygon) for each in own) >= SAME_OUTLINE_IOU:
            continue
        main = max(own, key=lambda each: shapely.intersection(each.polygon, outline).area)
        new = replace(main, id=now.last_id + 1, polygon=shape, predicted=None, confidence=None, probability=1.0)
        now = _take(now, new, touched)
        restored.append(new.id)
    return Restored(_renew_doors(now, floor, old, {*restored}), len(restored)) if restored else Restored(floor)


def _has_changed(outline: Polygon, new: Sequence[Polygon], others: Sequence[Polygon], change: MapChange) -> bool:
    """Whether the map explains why a previous room is not found again."""
    if change.measure_free(outline) < MIN_STILL_FREE:
        return True
    inside = outline.buffer(-SAME_BORDER)
    for number, one in enumerate(new):
        for other in new[:number]:
            if change.has_new_wall(shapely.intersection(_find_border(one, other), inside)):
                return True
    deep_in_new = shapely.union_all([each.buffer(-SAME_BORDER) for each in new])
    return any(
        change.has_lost_wall(shapely.intersection(_find_border(outline, other), deep_in_new)) for other in others
    )


def _find_border(one: Polygon, other: Polygon) -> BaseGeometry:
    """Where the outline of a room runs beside another room."""
    if one.distance(other) > BORDER_REACH:
        return Polygon()
    return shapely.intersection(one.boundary, other.buffer(BORDER_REACH))


def _grow(outline: Polygon, own: Sequence[Room], others: Sequence[Polygon]) -> Polygon:
    """The outline with the parts of its new rooms that were in no other previous room."""
    beyond = [part for room in own for part in list_polygons(shapely.difference(room.polygon, outline))]
    grown = [part for part in beyond if not _is_room(part) or not any(_descends(part, other) for other in others)]
    return find_largest_polygon(shapely.union_all([outline, *grown]))


def _take(floor: Floor, new: Room, touched: Sequence[Room]) -> Floor:
    """The floor with a room, and without its area in others; what is left of these are rooms if it is wide enough."""
    rooms, last_id = [], new.id
    for room in floor:
        if all(room.id != each.id for each in touched):
            rooms.append(room)
            continue
        left = list_polygons(shapely.difference(room.polygon, new.polygon))
        for number, part in enumerate(sorted(filter(_is_room, left), key=lambda part: -part.area)):
            last_id += number > 0
            rooms.append(
                replace(
                    room,
                    id=last_id if number else room.id,
                    polygon=part,
                    predicted=None,
                    confidence=None,
                    global_id=None if number else room.global_id,
                )
            )
    return replace(floor, rooms=(*rooms, new), last_id=last_id)


def _renew_doors(floor: Floor, read: Floor, old: Floor, restored: set[int]) -> Floor:
    """The floor with doors between the rooms that are there now, and with the previous doors of restored borders.

    read: the floor as the map was read. old: the previous floor in the new frame.
    """
    doors = tuple(_renew(read.doors, floor, read))
    for door in old.doors:
        beside = {find_beside(floor, door.line, side) for side in (1, -1)}
        was_beside = {find_beside(read, door.line, side) for side in (1, -1)}
        rooms = sorted(room for room in beside if room is not None)
        if len(rooms) < 2 or restored.isdisjoint(rooms) or len(was_beside - {None}) > 1:
            continue
        if not any(_is_near(door, each) and {*each.rooms} == {*rooms} for each in doors):
            doors = (*doors, replace(door, rooms=(rooms[0], rooms[1])))
    return replace(floor, doors=doors, possible_doors=tuple(_renew(read.possible_doors, floor, read)))


def _renew(doors: Sequence[Door], floor: Floor, read: Floor) -> Iterator[Door]:
    """The doors with the ids of the rooms beside them; not those that are within a room now."""
    stays = {room.id for room in floor if room.id in read and read[room.id].polygon == room.polygon}
    for door in doors:
        if stays.issuperset(door.room_ids):
            yield door
            continue
        beside = {find_beside(floor, door.line, side) for side in (1, -1)} - {None}
        # A door may end in a part of a room that was too narrow to be one
        rooms = sorted({room for room in beside if room is not None} | (stays & {*door.room_ids}))
        if len(rooms) == 2 or (len(rooms) == 1 and door.is_entrance):
            yield replace(door, rooms=(rooms[0], rooms[1] if len(rooms) == 2 else None))


def _is_near(one: Door, other: Door) -> bool:
    return bool(np.hypot(*np.subtract(middle_of(one.line), middle_of(other.line))) < SAME_DOOR)


def _descends(polygon: Polygon, outline: Polygon) -> bool:
    """Whether most of the smaller one of two outlines is in the other one."""
    shared = shapely.intersection(polygon, outline).area
    return bool(shared > MIN_COMMON_SHARE * min(polygon.area, outline.area))


def _measure_iou(one: Polygon, other: Polygon) -> float:
    shared = shapely.intersection(one, other).area
    return float(shared / (one.area + other.area - shared))


def _is_room(part: Polygon) -> bool:
    """Whether a part of a room is large and wide enough to be one."""
    return part.area >= MIN_ROOM and not part.buffer(-MIN_WIDTH / 2).is_empty
