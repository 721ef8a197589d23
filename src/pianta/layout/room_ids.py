"""Room ids that stay the same from one map of a building to the next, though the map has grown or has moved."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation
from scipy.signal import fftconvolve

from pianta._types import Floats, Indices, Mask
from pianta.evaluation.coverage import overlap_areas
from pianta.floor import Floor, Room

# The constants were chosen by hand.
# Two rooms are the same if they share more than this part of the smaller polygon.
MIN_COMMON_SHARE = 0.5
# The two frames are the same if rooms with this share of the previous area ...
SAME_FRAME_SHARE = 0.5
# ... are matched with at least this IoU, with which a room has its old outline.
SAME_OUTLINE_IOU = 0.8
# Cell size at which outlines are compared; metres.
OUTLINE_CELL = 0.2
# Cells along the longest side, at most; a limit of memory.
MAX_OUTLINE_CELLS = 2000
# A shift must bring this share of the previous outlines onto the new ones, more than without it, ...
MIN_SHIFT_GAIN = 0.1
# ... and must match this number of rooms, since every building has a room similar to any single room.
MIN_SHIFT_ROOMS = 2

Polygons = NDArray[np.object_]


class IdMatches(NamedTuple):
    """For each of P previous rooms the index of the room that gets its id, -1 if none, and their IoU; shapes (P,)."""

    room: Indices
    iou: Floats


def keep_room_ids(floor: Floor, previous: Floor, *, earlier: Sequence[Floor] = ()) -> Floor:
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
    anew or an image without map.yaml has grown, the shift between the two frames is estimated first; a rotation is not.
    A shift by exactly one room in a row of equal rooms cannot be detected.
    """
    # Sorted, so that equal overlaps are resolved in the same way for any order of the rooms.
    rooms = sorted(floor.rooms, key=lambda room: (room.polygon.bounds, room.id))
    previous_rooms = _assign_rooms(rooms, [previous, *earlier])
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


def _assign_rooms(rooms: list[Room], floors: Sequence[Floor]) -> dict[int, Room]:
    """The old room whose id each room keeps, by the id of the room. floors: the newest first."""
    polygons, pairs = _list_polygons(rooms), []
    for old_floor in floors:
        old_rooms = sorted(old_floor.rooms, key=lambda room: room.id)
        matches = _match_after_shift(polygons, _list_polygons(old_rooms))
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


def find_shift(polygons: Polygons, previous: Polygons) -> tuple[Floats, float]:
    """The shift x, y (metres) that brings most of the previous outlines onto the new ones, to one cell; and its gain.

    The gain is the share of the previous outlines on new ones with the shift, less that without it. Outlines locate
    better than areas, which overlap for every shift between two floors.
    """
    cell = max(OUTLINE_CELL, *(_measure_extent(floor) / MAX_OUTLINE_CELLS for floor in (polygons, previous)))
    new, new_low = _draw_outlines(polygons, cell)
    old, old_low = _draw_outlines(previous, cell)
    # A cell on an outline counts twice and one beside it once, because no wall is measured twice at the same position.
    near = np.pad(new, 1).astype(float) + binary_dilation(np.pad(new, 1), np.ones((3, 3)))
    # For every shift in cells the count of the previous outlines; rounded, because counts are integers.
    counts = np.rint(fftconvolve(near, old[::-1, ::-1].astype(float)))
    first = new_low - 1 - old_low - (np.array(old.shape) - 1)
    best = np.array(np.unravel_index(counts.argmax(), counts.shape))
    unshifted = counts[tuple(-first)] if ((first <= 0) & (-first < counts.shape)).all() else 0
    return (best + first) * cell, float(counts.max() - unshifted) / (2 * np.count_nonzero(old))


def _match_after_shift(polygons: Polygons, previous: Polygons) -> IdMatches:
    """Match rooms in the same frame, or, if that matches few rooms, after a shift that matches more."""
    matches = match_rooms(polygons, previous)
    area = shapely.area(previous)
    same_frame = area[matches.iou >= SAME_OUTLINE_IOU].sum() >= SAME_FRAME_SHARE * area.sum()
    if same_frame or not (len(polygons) and len(previous)):
        return matches
    shift, gain = find_shift(polygons, previous)
    shifted = match_rooms(polygons, np.asarray(shapely.transform(previous, lambda xy: xy + shift), dtype=object))
    clear = gain >= MIN_SHIFT_GAIN and np.count_nonzero(shifted.room >= 0) >= MIN_SHIFT_ROOMS
    return shifted if clear else matches


def _inherit(room: Room, room_id: int, old: Room | None) -> Room:
    """The room with its final id, and with the name and the label of the old room if it has none."""
    if old is not None and room.name is None:
        room = replace(room, name=old.name)
    if old is None or room.label is not None or room.labels or room.label_probabilities:
        return replace(room, id=room_id)
    return replace(room, id=room_id, label=old.label, labels=old.labels, label_probabilities=old.label_probabilities)


def _list_polygons(rooms: list[Room]) -> Polygons:
    return np.array([room.polygon for room in rooms], dtype=object)


def _measure_extent(polygons: Polygons) -> float:
    """The longer side of the box around all polygons, in their unit."""
    left, bottom, right, top = shapely.total_bounds(polygons)
    return float(max(right - left, top - bottom))


def _draw_outlines(polygons: Polygons, cell: float) -> tuple[Mask, NDArray[np.int64]]:
    """Cells on the outlines, indexed by x and y, and the x, y in whole cells of the first one."""
    rings = [np.rint(shapely.get_coordinates(ring) / cell).astype(np.int64) for ring in shapely.get_rings(polygons)]
    corners = np.concatenate(rings)
    low = corners.min(axis=0)
    image = np.zeros(corners.max(axis=0) - low + 1, np.uint8)
    # OpenCV's x runs along the second axis.
    cv2.polylines(image, [(ring - low)[:, ::-1].astype(np.int32) for ring in rings], isClosed=True, color=1)
    return image.astype(bool), low
