"""Room ids that stay the same from one map of a building to the next, though the map has grown or has moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import shapely

from pianta._types import Floats, Indices
from pianta.errors import FloorError
from pianta.evaluation.coverage import overlap_areas
from pianta.floor import Door, Floor, Room
from pianta.layout.frames import Motion, Polygons, find_motion, measure_share

# The constants were chosen by hand.
# Two rooms are the same if they share more than this part of the smaller polygon.
MIN_COMMON_SHARE = 0.5
# The two frames are the same if rooms with this share of the previous area ...
SAME_FRAME_SHARE = 0.5
# ... are matched with at least this IoU, with which a room has its old outline.
SAME_OUTLINE_IOU = 0.8
# A motion must bring this share of the outlines of one map onto those of the other, more than without it, ...
MIN_MOTION_GAIN = 0.1
# ... and must match this number of rooms, since every building has a room similar to any single room.
MIN_MOVED_ROOMS = 2
# Maps are of one building if the mean IoU of the rooms that match is this, where rooms of the smaller floor that match
# none count as 0. Growing maps of data/partial have 0.63 or more (18 pairs); of 105 pairs of different buildings of
# data/slam, data/survey and made worlds 5 have more than 0.5, all of them with made corridors.
SAME_BUILDING_IOU = 0.5


class IdMatches(NamedTuple):
    """For each of P previous rooms the index of the room that gets its id, -1 if none, and their IoU; shapes (P,)."""

    room: Indices
    iou: Floats


def keep_room_ids(
    floor: Floor, previous: Floor, *, earlier: Sequence[Floor] = (), is_same_frame: bool = False
) -> Floor:
    """The floor with the ids of the previous one for rooms that are still there, and new ids for the others.

    A room that has grown keeps its id. If a room was split, the largest part keeps its id; if rooms were merged, the
    result gets the id of the one with the largest part in it. New rooms are numbered from `previous.last_id + 1` in the
    order of the floor: no id is ever used for another room. A room without label and probabilities gets those of the
    room whose id it keeps, and a room without a name its name. Everything else, and the order of the rooms, is the
    floor's.

    earlier: floors before the previous one, the newest first, with the ids of this function. A room that was cut
    differently for a while gets back the id that it had: rooms whose outline is as in one of the floors come first, by
    the newest such floor; then rooms keep ids of the previous floor, then those ids of earlier floors that are left.

    All floors are in metres of the map frame. If few rooms are where they were, because SLAM has anchored the frame
    anew, an image without map.yaml has grown, or the robot stood in another direction, the motion between the frames is
    estimated first, unless is_same_frame. A shift by exactly one room in a row of equal rooms cannot be detected, nor
    can a rotation of a building that is the same after it.
    """
    # Sorted, so that equal overlaps are resolved in the same way for any order of the rooms.
    rooms = sorted(floor.rooms, key=lambda room: (room.polygon.bounds, room.id))
    previous_rooms = _assign_rooms(rooms, [previous, *earlier], is_same_frame=is_same_frame)
    last_id = max(each.last_id for each in (previous, *earlier))
    new_ids = {room_id: old.id for room_id, old in previous_rooms.items()}
    for room in floor.rooms:
        new_ids.setdefault(room.id, last_id + 1 + len(new_ids.keys() - previous_rooms.keys()))
    return replace(
        floor,
        rooms=tuple(_inherit(room, new_ids[room.id], previous_rooms.get(room.id)) for room in floor.rooms),
        doors=tuple(door.renumber_rooms(new_ids) for door in floor.doors),
        possible_doors=tuple(door.renumber_rooms(new_ids) for door in floor.possible_doors),
        last_id=last_id + len(floor.rooms) - len(previous_rooms),
    )


def _assign_rooms(rooms: list[Room], floors: Sequence[Floor], *, is_same_frame: bool) -> dict[int, Room]:
    """The old room whose id each room keeps, by the id of the room. floors: the newest first."""
    polygons, pairs = _list_polygons(rooms), []
    for old_floor in floors:
        old_rooms = sorted(old_floor.rooms, key=lambda room: room.id)
        old_polygons = _list_polygons(old_rooms)
        matches = match_rooms(polygons, old_polygons) if is_same_frame else _find_motion(polygons, old_polygons)[1]
        candidates = zip(matches.room.tolist(), matches.iou.tolist(), old_rooms, strict=True)
        pairs += [(iou < SAME_OUTLINE_IOU, rooms[room].id, old) for room, iou, old in candidates if room >= 0]
    assigned: dict[int, Room] = {}
    used: set[int] = set()
    # Rooms with their old outline first; the order is otherwise kept, from the newest floor to the oldest
    for _, room_id, old in sorted(pairs, key=lambda pair: pair[0]):
        if room_id not in assigned and old.id not in used:
            assigned[room_id] = old
            used.add(old.id)
    return assigned


def match_rooms(polygons: Polygons, previous: Polygons) -> IdMatches:
    """Match N rooms with P previous ones in the same frame, one to one, by common area.

    This is no optimal assignment, which may take the id from the largest part of a room in order to match a small room.
    """
    if not (len(polygons) and len(previous)):
        return IdMatches(np.full(len(previous), -1), np.zeros(len(previous)))
    common = overlap_areas(previous, polygons)
    # Each room descends from the previous room that it overlaps most ...
    descends = np.arange(len(previous))[:, None] == common.argmax(axis=0)
    # ... and each previous room matches the largest of its descendants,
    match = np.where(descends, common, -1).argmax(axis=1)
    shared = np.where(descends, common, 0).max(axis=1)
    # if they have enough area in common.
    old_area, area = shapely.area(previous), shapely.area(polygons)[match]
    stays = shared > MIN_COMMON_SHARE * np.minimum(old_area, area)
    return IdMatches(np.where(stays, match, -1), np.where(stays, shared / (old_area + area - shared), 0))


def find_frame_motion(floor: Floor, previous: Floor) -> Motion:
    """The motion from the frame of a previous floor to that of a floor of the same building.

    Raises FloorError if the floors have too little in common to be of the same building.
    """
    polygons, old = (_list_polygons(sorted(each.rooms, key=lambda room: room.id)) for each in (floor, previous))
    if not (len(polygons) and len(old)):
        return Motion()
    motion, matches = _find_motion(polygons, old)
    iou = matches.iou.sum() / min(len(polygons), len(old))
    if iou < SAME_BUILDING_IOU:
        raise FloorError(
            f"the previous floor is of another building: {100 * iou:.0f} % of its rooms, by mean IoU, are on this one, "
            f"{100 * SAME_BUILDING_IOU:.0f} % are needed; leave it out"
        )
    return motion


def move_floor(floor: Floor, motion: Motion) -> Floor:
    """The floor in another frame."""

    def move_door(door: Door) -> Door:
        return replace(door, line=shapely.transform(door.line, motion.apply))

    rooms = tuple(
        replace(
            room,
            polygon=shapely.transform(room.polygon, motion.apply),
            predicted=shapely.transform(room.predicted, motion.apply) if room.predicted else None,
        )
        for room in floor.rooms
    )
    furniture = (replace(piece, polygon=shapely.transform(piece.polygon, motion.apply)) for piece in floor.furniture)
    return replace(
        floor,
        rooms=rooms,
        doors=tuple(map(move_door, floor.doors)),
        possible_doors=tuple(map(move_door, floor.possible_doors)),
        walls=tuple(shapely.transform(wall, motion.apply) for wall in floor.walls),
        furniture=tuple(furniture),
    )


def _find_motion(polygons: Polygons, previous: Polygons) -> tuple[Motion, IdMatches]:
    """The motion from the frame of the previous rooms to that of the others, and the matches after it.

    There is no motion if most rooms are where they were, or no motion is clearly better.
    """
    matches = match_rooms(polygons, previous)
    area = shapely.area(previous)
    same_frame = area[matches.iou >= SAME_OUTLINE_IOU].sum() >= SAME_FRAME_SHARE * area.sum()
    if same_frame or not (len(polygons) and len(previous)):
        return Motion(), matches
    motion, share = find_motion(polygons, previous)
    moved = match_rooms(polygons, motion.move(previous))
    gain = share - measure_share(polygons, previous)
    clear = gain >= MIN_MOTION_GAIN and np.count_nonzero(moved.room >= 0) >= MIN_MOVED_ROOMS
    return (motion, moved) if clear else (Motion(), matches)


def _inherit(room: Room, room_id: int, old: Room | None) -> Room:
    """The room with its final id, and with the number, the name and the label of the old room if it has none."""
    if old is not None and room.title is None:
        room = replace(room, number=old.number, name=old.name)
    if old is None or room.label is not None or room.labels or room.label_probabilities:
        return replace(room, id=room_id)
    return replace(room, id=room_id, label=old.label, labels=old.labels, label_probabilities=old.label_probabilities)


def _list_polygons(rooms: list[Room]) -> Polygons:
    return np.array([room.polygon for room in rooms], dtype=object)
