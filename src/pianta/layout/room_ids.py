"""Room ids that stay the same from one map of a building to the next, though the map has grown or has moved."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation
from scipy.signal import fftconvolve

from pianta.evaluation.coverage import overlap_areas
from pianta.floor import Floor, Room

# A room is there again where more than this share of the smaller of the two polygons is common to both.
COMMON_SHARE = 0.5
# The frame is taken as given where rooms with this share of the previous area lie where they were, with this IoU.
SETTLED_SHARE, SETTLED_IOU = 0.5, 0.8
# Outlines are compared on cells of this size, m, and of no more than this number along the longest side.
OUTLINE_CELL, MAX_OUTLINE_CELLS = 0.2, 2000
# A shift must lay this share of the previous outlines on the new ones beyond what lies there without it, and must bring
# back this number of rooms, since a single room has its like in every building.
CLEAR_GAIN, LEAST_ROOMS = 0.1, 2

Polygons = NDArray[np.object_]
Shift = NDArray[np.float64]


class Heirs(NamedTuple):
    """For each of P previous rooms the index of the room that takes its id, -1 for none, and their IoU; shapes (P,)."""

    room: NDArray[np.intp]
    iou: NDArray[np.float64]


def keep_room_ids(floor: Floor, previous: Floor) -> Floor:
    """The floor with the ids of the previous one on the rooms that are still there, and new ids on the others.

    A room that has grown keeps its id. Of a room that was split the largest part keeps it; of rooms that were merged
    the one with the largest share in the whole gives it. New rooms are numbered from `previous.last_id + 1` on in the
    order of the floor: an id that was ever given never comes back. A room that says neither label nor probabilities
    gets those of the room whose id it keeps, and one without a name its name. The order of the rooms and everything
    else is the floor's.

    Both floors are in metres of the map frame. Where few rooms lie where they were, as when SLAM has anchored the
    frame anew or an image without map.yaml has grown, the shift between the two frames is estimated first; frames
    turned against each other are not. A shift from each room of a row to its equal neighbour cannot be noticed.
    """
    # In an order of their own, so that equal overlaps are decided alike however the rooms are listed.
    rooms = sorted(floor.rooms, key=lambda room: (room.polygon.bounds, room.id))
    old_rooms = sorted(previous.rooms, key=lambda room: room.id)
    heirs = _match_after_shift(_polygons_of(rooms), _polygons_of(old_rooms))
    kept = {rooms[heir].id: old for heir, old in zip(heirs.room, old_rooms, strict=True) if heir >= 0}
    new_ids = {room_id: old.id for room_id, old in kept.items()}
    for room in floor.rooms:
        new_ids.setdefault(room.id, previous.last_id + 1 + len(new_ids.keys() - kept.keys()))
    return replace(
        floor,
        rooms=tuple(_take_over(room, new_ids[room.id], kept.get(room.id)) for room in floor.rooms),
        doors=tuple(door.renumber_rooms(new_ids) for door in floor.doors),
        last_id=previous.last_id + len(floor.rooms) - len(kept),
    )


def match_rooms(polygons: Polygons, previous: Polygons) -> Heirs:
    """Match N rooms with P previous ones in the same frame, one to one, by the area that they have in common.

    No assignment of the largest total: that would give away the id of a room's largest part to save a smaller room.
    """
    if not (len(polygons) and len(previous)):
        return Heirs(np.full(len(previous), -1), np.zeros(len(previous)))
    common = overlap_areas(previous, polygons)
    # Each room descends from the previous room that it overlaps most ...
    descends = np.arange(len(previous))[:, None] == common.argmax(axis=0)
    # ... and each previous room lives on in the largest of its descendants,
    heir = np.where(descends, common, -1).argmax(axis=1)
    shared = np.where(descends, common, 0).max(axis=1)
    # if the one has grown from the other, or is a good part of it, and does not just touch it.
    old_area, area = shapely.area(previous), shapely.area(polygons)[heir]
    stays = shared > COMMON_SHARE * np.minimum(old_area, area)
    return Heirs(np.where(stays, heir, -1), np.where(stays, shared / (old_area + area - shared), 0))


def find_shift(polygons: Polygons, previous: Polygons) -> tuple[Shift, float]:
    """The shift x, y (m) that lays most of the previous outlines on the new ones, to a cell; and what it gains.

    The gain is a share of the previous outlines: those on the new ones with the shift less those without it. Outlines
    tell more than areas, which overlap wherever one floor lies on another.
    """
    cell = max(OUTLINE_CELL, *(_longest_side(floor) / MAX_OUTLINE_CELLS for floor in (polygons, previous)))
    new, new_low = _draw_outlines(polygons, cell)
    old, old_low = _draw_outlines(previous, cell)
    # A cell on an outline counts twice and one beside it once: walls are never measured alike.
    near = np.pad(new, 1).astype(float) + binary_dilation(np.pad(new, 1), np.ones((3, 3)))
    # For every shift in cells the count of the previous outlines, which whole numbers tell without rounding errors.
    counts = np.rint(fftconvolve(near, old[::-1, ::-1].astype(float)))
    first = new_low - 1 - old_low - (np.array(old.shape) - 1)
    best = np.array(np.unravel_index(counts.argmax(), counts.shape))
    unshifted = counts[tuple(-first)] if ((first <= 0) & (-first < counts.shape)).all() else 0
    return (best + first) * cell, float(counts.max() - unshifted) / (2 * np.count_nonzero(old))


def _match_after_shift(polygons: Polygons, previous: Polygons) -> Heirs:
    """Match rooms in the frames as given, or, where that lays few rooms on each other, after a shift that does."""
    heirs = match_rooms(polygons, previous)
    area = shapely.area(previous)
    settled = area[heirs.iou >= SETTLED_IOU].sum() >= SETTLED_SHARE * area.sum()
    if settled or not (len(polygons) and len(previous)):
        return heirs
    shift, gain = find_shift(polygons, previous)
    shifted = match_rooms(polygons, np.asarray(shapely.transform(previous, lambda xy: xy + shift), dtype=object))
    clear = gain >= CLEAR_GAIN and np.count_nonzero(shifted.room >= 0) >= LEAST_ROOMS
    return shifted if clear else heirs


def _take_over(room: Room, room_id: int, old: Room | None) -> Room:
    """The room with its id for good, and with the name and the label of the old room where it has none."""
    if old is not None and room.name is None:
        room = replace(room, name=old.name)
    if old is None or room.label is not None or room.labels or room.label_probabilities:
        return replace(room, id=room_id)
    return replace(room, id=room_id, label=old.label, labels=old.labels, label_probabilities=old.label_probabilities)


def _polygons_of(rooms: list[Room]) -> Polygons:
    return np.array([room.polygon for room in rooms], dtype=object)


def _longest_side(polygons: Polygons) -> float:
    left, bottom, right, top = shapely.total_bounds(polygons)
    return float(max(right - left, top - bottom))


def _draw_outlines(polygons: Polygons, cell: float) -> tuple[NDArray[np.bool_], NDArray[np.int64]]:
    """Cells on the outlines, indexed by x and y, and the x, y in whole cells of the first one."""
    rings = [np.rint(shapely.get_coordinates(ring) / cell).astype(np.int64) for ring in shapely.get_rings(polygons)]
    corners = np.concatenate(rings)
    low = corners.min(axis=0)
    image = np.zeros(corners.max(axis=0) - low + 1, np.uint8)
    # OpenCV's x runs along the second axis.
    cv2.polylines(image, [(ring - low)[:, ::-1].astype(np.int32) for ring in rings], isClosed=True, color=1)
    return image.astype(bool), low
