"""Persistence of rooms and their ids over growing maps of one building."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta.evaluation.coverage import overlap_areas
from pianta.floor import Floor

# A room persists if a room of the next step has a larger IoU with it, or covers a larger share of it.
MIN_IOU = 0.5
MIN_COVERED_SHARE = 0.8


@dataclass(frozen=True)
class Persistence:
    """Numbers of rooms over all steps but the last; a room counts once a step.

    rooms: all rooms. persisting: those that persist in the next step. same_id: those of these that have the same id
    there.
    """

    rooms: int
    persisting: int
    same_id: int

    @property
    def persisting_share(self) -> float:
        """Share of the rooms that persist in the next step; 1 without rooms."""
        return self.persisting / self.rooms if self.rooms else 1.0

    @property
    def same_id_share(self) -> float:
        """Share of the persisting rooms with the same id; 1 without such rooms."""
        return self.same_id / self.persisting if self.persisting else 1.0


def score_persistence(floors: Sequence[Floor]) -> Persistence:
    """Persistence of rooms and ids over the floors of one building in one frame, the oldest first.

    Of several rooms that one room of the next step covers, because they were merged, only one can keep its id.
    """
    rooms = persisting = same_id = 0
    for floor, following in pairwise(floors):
        persists = _find_persisting(floor, following)
        ids, next_ids = ([room.id for room in each.rooms] for each in (floor, following))
        equal_ids = np.equal.outer(np.array(ids, dtype=object), np.array(next_ids, dtype=object)).astype(bool)
        rooms += len(floor.rooms)
        persisting += int(persists.any(axis=1).sum())
        same_id += int((persists & equal_ids).any(axis=1).sum())
    return Persistence(rooms, persisting, same_id)


def _find_persisting(floor: Floor, following: Floor) -> NDArray[np.bool_]:
    """Whether a room of this step persists as a room of the next, shape (rooms now, rooms next)."""
    now, then = (np.array([room.polygon for room in each.rooms], dtype=object) for each in (floor, following))
    common = overlap_areas(now, then)
    area = shapely.area(now)[:, None]
    return np.asarray((common > MIN_IOU * (area + shapely.area(then) - common)) | (common > MIN_COVERED_SHARE * area))
