"""Corrections of rooms."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import shapely
from shapely import Polygon

from pianta.corrections._positions import (
    NEAR_ROOM,
    draw_line,
    draw_outline,
    find_nearest_room,
    find_room,
    middle_of,
)
from pianta.corrections.kinds import (
    DeleteRoom,
    DrawRoom,
    LabelRoom,
    MarkOutside,
    MergeRooms,
    NameRoom,
    NumberRoom,
    SplitRoom,
    describe_points,
)
from pianta.errors import CorrectionError
from pianta.floor import Door, Floor, Room
from pianta.floor.polygons import find_largest_polygon, list_polygons
from pianta.floor.shapes import MAX_GAP, MIN_ROOM, join_shapes, measure_gap, split_shape

# The constants were chosen by hand.
# A room that is drawn must have this share outside of other rooms.
MIN_FREE_SHARE = 0.5
# A room with this IoU is the one that is drawn.
SAME_IOU = 0.8


def merge_rooms(floor: Floor, correction: MergeRooms) -> Floor:
    """The rooms at the positions as one, with the oldest id, and the label of the largest."""
    merging = {room.id: room for room in (find_room(floor, position) for position in correction.positions)}
    if len(correction.positions) < 2:
        raise CorrectionError("one position alone names no rooms to merge, give two or more")
    if len(merging) == 1:
        return floor
    rooms = sorted(merging.values(), key=lambda room: (-room.polygon.area, room.id))
    merged = replace(
        rooms[0],
        id=min(merging),
        polygon=_join(rooms, [room.polygon for room in floor if room.id not in merging]),
        number=next((room.number for room in rooms if room.number), None),
        name=next((room.name for room in rooms if room.name), None),
        partial=any(room.partial for room in rooms),
        predicted=None,
        confidence=None,
        probability=1.0,
    )
    new_ids = {room.id: merged.id if room.id in merging else room.id for room in floor}

    def lead_elsewhere(doors: Sequence[Door]) -> tuple[Door, ...]:
        return tuple(door.renumber_rooms(new_ids) for door in doors if not merging.keys() >= {*door.rooms})

    remaining = [
        merged if room.id == merged.id else room for room in floor if room.id == merged.id or room.id not in merging
    ]
    return replace(
        floor,
        rooms=tuple(remaining),
        doors=lead_elsewhere(floor.doors),
        possible_doors=lead_elsewhere(floor.possible_doors),
    )


def _join(rooms: Sequence[Room], others: Sequence[Polygon]) -> Polygon:
    """The shape of merged rooms; raises CorrectionError for rooms that are apart, or with another one between them."""
    shapes = [room.polygon for room in rooms]
    gap = measure_gap(shapes)
    ids = " and ".join(str(room.id) for room in sorted(rooms, key=lambda room: room.id))
    if gap > MAX_GAP:
        raise CorrectionError(f"rooms {ids} are {gap:.1f} m apart, rooms to merge must be neighbours")
    joined = join_shapes(shapes, others)
    if any(shapely.difference(shape, joined).area >= MIN_ROOM for shape in shapes):
        raise CorrectionError(f"another room divides rooms {ids}, merge it with them, or split it first")
    return joined


def split_room(floor: Floor, correction: SplitRoom) -> Floor:
    """The parts of a room on both sides of a line; the largest keeps id and name. Between them is an opening."""
    line = draw_line(correction.line)
    one, other = (find_nearest_room(floor.rooms, side) for side in correction.sides)
    if one is not None and other is not None and one.id != other.id:
        return floor
    room = one or other or find_room(floor, middle_of(line))
    parts, border = split_shape(room.polygon, line)
    if len(parts) < 2:
        raise CorrectionError(f"the line does not divide room {room.id}, draw it from wall to wall")
    divided = _divide(floor, room, parts)
    new = [each for each in divided if each.id == room.id or each.id > floor.last_id]
    openings = []
    for piece in border:
        first, second, *_ = sorted(new, key=lambda each: each.polygon.distance(piece.centroid))
        openings.append(Door((first.id, second.id), piece, piece.length, kind="opening"))
    return replace(divided, doors=(*divided.doors, *openings))


def draw_room(floor: Floor, correction: DrawRoom) -> Floor:
    """A new room, as far as no other room is there; entrances beside it become doors to it."""
    outline = draw_outline(correction.outline)
    for room in floor:
        shared = shapely.intersection(room.polygon, outline).area
        if shared >= SAME_IOU * (room.polygon.area + outline.area - shared):
            return floor
    others = shapely.union_all([room.polygon for room in floor])
    polygon = find_largest_polygon(shapely.difference(outline, others))
    if polygon.area < max(MIN_ROOM, MIN_FREE_SHARE * outline.area):
        position = describe_points((outline.centroid.x, outline.centroid.y))
        raise CorrectionError(f"other rooms are where the room at {position} is drawn, split or delete these first")
    new = Room(floor.last_id + 1, polygon, probability=1.0)
    doors = [
        replace(door, rooms=(door.rooms[0], new.id))
        if door.is_entrance and door.line.distance(polygon) <= NEAR_ROOM
        else door
        for door in floor.doors
    ]
    return replace(floor, rooms=(*floor.rooms, new), doors=tuple(doors), last_id=new.id)


def delete_room(floor: Floor, correction: DeleteRoom) -> Floor:
    """The floor without a room and without its doors."""
    room = find_nearest_room(floor.rooms, correction.position, reach=0)
    if room is None:
        return floor
    return _replace_room(floor, room, [], lambda doors: [door for door in doors if room.id not in door.room_ids])


def mark_outside(floor: Floor, correction: MarkOutside) -> Floor:
    """The rooms without an area; doors to rooms that lay in it are entrances."""
    outline = draw_outline(correction.outline)
    for room in floor:
        rest = shapely.difference(room.polygon, outline)
        if room.polygon.area - rest.area >= MIN_ROOM:
            parts = [part for part in list_polygons(rest) if part.area >= MIN_ROOM]
            floor = _divide(floor, room, sorted(parts, key=lambda part: -part.area))
    return floor


def name_room(floor: Floor, correction: NameRoom) -> Floor:
    """The floor with another name of a room."""
    room = find_room(floor, correction.position)
    return _change_room(floor, replace(room, name=correction.name or None))


def number_room(floor: Floor, correction: NumberRoom) -> Floor:
    """The floor with another number of a room."""
    room = find_room(floor, correction.position)
    return _change_room(floor, replace(room, number=correction.number or None))


def label_room(floor: Floor, correction: LabelRoom) -> Floor:
    """The floor with another label of a room, without the probabilities of the labels that were predicted."""
    room = find_room(floor, correction.position)
    if room.label == correction.label and not room.label_probabilities:
        return floor
    return _change_room(floor, replace(room, label=correction.label, labels={}, label_probabilities={}))


def _change_room(floor: Floor, changed: Room) -> Floor:
    """The floor with other properties of a room; the same floor if they are equal."""
    if floor[changed.id] == changed:
        return floor
    return replace(floor, rooms=tuple(changed if room.id == changed.id else room for room in floor))


def _divide(floor: Floor, room: Room, parts: Sequence[Polygon]) -> Floor:
    """The floor with the parts of a room, the first of which keeps its id; without parts its doors are entrances."""
    first = replace(room, predicted=None, confidence=None, probability=1.0)
    rooms = [
        replace(first, polygon=part)
        if number == 0
        else replace(first, id=floor.last_id + number, polygon=part, number=None, name=None, global_id=None)
        for number, part in enumerate(parts)
    ]

    def give_to_parts(doors: Sequence[Door]) -> Iterator[Door]:
        for door in doors:
            others = [room_id for room_id in door.room_ids if room_id != room.id]
            if len(others) == len(door.room_ids):
                yield door
            elif rooms:
                nearest = min(rooms, key=lambda each: (each.polygon.distance(door.line), each.id))
                yield replace(door, rooms=(nearest.id, others[0] if others else None))
            elif others:
                yield replace(door, rooms=(others[0], None))

    return _replace_room(floor, room, rooms, give_to_parts)


def _replace_room(
    floor: Floor, old: Room, new: Sequence[Room], change_doors: Callable[[Sequence[Door]], Iterable[Door]]
) -> Floor:
    """The floor with other rooms instead of one, and with the doors that `change_doors` makes of all doors."""
    rooms = [each for room in floor for each in (new if room.id == old.id else (room,))]
    return replace(
        floor,
        rooms=tuple(rooms),
        doors=tuple(change_doors(floor.doors)),
        possible_doors=tuple(change_doors(floor.possible_doors)),
        last_id=max(floor.last_id, *(room.id for room in new)) if new else floor.last_id,
    )
