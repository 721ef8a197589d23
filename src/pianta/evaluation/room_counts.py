"""Rooms and doors counted as a reader of a map counts them: right, split, merged, and doors that lead nowhere."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pianta.errors import FloorError
from pianta.floor import Door

# IoU from which a room is right; that of the review of real maps, issue 22.
RIGHT_IOU = 0.6
# m²; smaller pieces of a true room are no split; that of the review of real maps, issue 22.
MIN_PIECE_AREA = 0.4


@dataclass(frozen=True)
class RoomCounts:
    """Numbers of rooms; a room lies mostly in another one if that has more than half of its cells.

    true, detected: true and reconstructed rooms.
    right: true rooms with which a reconstructed room has an IoU of at least 0.6.
    right_whole: those of them without a split.
    splits: reconstructed rooms of at least 0.4 m² that lie mostly in one true room, without the first of them.
    merges: true rooms that lie mostly in one reconstructed room, without the first of them.
    no_rooms: reconstructed rooms of which at most half lies in true rooms.
    true_ids: for each other reconstructed room the true room that covers most of it, by id.
    right_ids: the reconstructed rooms that are right.
    """

    true: int
    detected: int
    right: int
    right_whole: int
    splits: int
    merges: int
    no_rooms: int
    true_ids: Mapping[int, int]
    right_ids: frozenset[int]


@dataclass(frozen=True)
class DoorCounts:
    """Numbers of reconstructed doors.

    within: doors that join a true room with itself. nowhere: doors beside a room that is no room, and entrances.
    """

    doors: int
    within: int
    nowhere: int


def count_rooms(
    labels: NDArray[np.integer], truth: NDArray[np.integer], *, counted: NDArray[np.bool_], resolution: float
) -> RoomCounts:
    """Counts of the rooms of a label image against the true one.

    labels, truth: shape (H, W); n > 0 is the room with id n, other values are no room.
    counted: shape (H, W), the cells that count, such as `GridMap.free`; a room without a counted cell is ignored.
    resolution: metres per cell.
    Raises FloorError if the shapes differ.
    """
    if not labels.shape == truth.shape == counted.shape:
        shapes = f"labels {labels.shape}, truth {truth.shape} and counted {counted.shape}"
        raise FloorError(f"images of different shapes cannot be compared: {shapes}, give three of one shape")
    ids, rooms = np.unique(np.maximum(labels[counted], 0), return_inverse=True)
    true_ids, true_rooms = np.unique(np.maximum(truth[counted], 0), return_inverse=True)
    cells = np.zeros((len(ids), len(true_ids)))
    np.add.at(cells, (rooms, true_rooms), 1)
    areas, true_areas = (cells.sum(axis=axis)[each > 0] for axis, each in ((1, ids), (0, true_ids)))
    overlaps = cells[ids > 0][:, true_ids > 0]
    agrees = overlaps >= RIGHT_IOU * (areas[:, None] + true_areas - overlaps)
    is_right = agrees.any(axis=0)
    is_piece = (2 * overlaps > areas[:, None]) & (areas * resolution**2 >= MIN_PIECE_AREA)[:, None]
    splits = np.maximum(is_piece.sum(axis=0) - 1, 0)
    merges = np.maximum((2 * overlaps > true_areas).sum(axis=1) - 1, 0)
    is_room = 2 * overlaps.sum(axis=1) > areas
    main = true_ids[true_ids > 0][overlaps.argmax(axis=1)] if overlaps.size else []
    return RoomCounts(
        true=len(true_areas),
        detected=len(areas),
        right=int(is_right.sum()),
        right_whole=int((is_right & (splits == 0)).sum()),
        splits=int(splits.sum()),
        merges=int(merges.sum()),
        no_rooms=int((~is_room).sum()),
        true_ids={int(room): int(true) for room, true, real in zip(ids[ids > 0], main, is_room, strict=False) if real},
        right_ids=frozenset(ids[ids > 0][agrees.any(axis=1)].tolist()),
    )


def count_doors(doors: Sequence[Door], true_ids: Mapping[int, int]) -> DoorCounts:
    """Counts of doors.

    true_ids: the true room of each room by id, such as `RoomCounts.true_ids`; rooms that it lacks are no rooms.
    """
    sides = [[true_ids.get(room) for room in door.room_ids] for door in doors]
    nowhere = sum(None in side or len(side) < 2 for side in sides)
    within = sum(len(side) == 2 and None not in side and side[0] == side[1] for side in sides)
    return DoorCounts(len(sides), within, nowhere)
