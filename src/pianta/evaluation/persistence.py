"""How well rooms and their ids last over maps of one building that grow step by step."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta.evaluation.coverage import overlap_areas
from pianta.floor import Floor

# A room is still there where a room of the next step has this IoU with it, or holds this share of it.
SAME_IOU, HELD_SHARE = 0.5, 0.8


@dataclass(frozen=True)
class Persistence:
    """Counts over all steps but the last, a room counting once a step.

    rooms: rooms that were found.
    still_there: those of them that the next step finds again.
    kept_id: those of these whose id the next step gives to a room that is the same.
    """

    rooms: int
    still_there: int
    kept_id: int

    @property
    def share_still_there(self) -> float:
        """Share of the rooms that the next step finds again, 1 where there are no rooms."""
        return self.still_there / self.rooms if self.rooms else 1.0

    @property
    def share_kept_id(self) -> float:
        """Share of the rooms found again that kept their id, 1 where there are none."""
        return self.kept_id / self.still_there if self.still_there else 1.0


def score_persistence(floors: Sequence[Floor]) -> Persistence:
    """Persistence of rooms and ids over the floors of one building in one frame, the oldest first.

    A room is still there when a room of the next step overlaps it with IoU above 0.5 or holds more than 80 % of it. Of
    several rooms that one room holds, because they were merged, only one can keep its id.
    """
    rooms = still_there = kept_id = 0
    for floor, following in pairwise(floors):
        again = _find_again(floor, following)
        ids, next_ids = ([room.id for room in each.rooms] for each in (floor, following))
        same_id = np.equal.outer(np.array(ids, dtype=object), np.array(next_ids, dtype=object)).astype(bool)
        rooms += len(floor.rooms)
        still_there += int(again.any(axis=1).sum())
        kept_id += int((again & same_id).any(axis=1).sum())
    return Persistence(rooms, still_there, kept_id)


def _find_again(floor: Floor, following: Floor) -> NDArray[np.bool_]:
    """Which room of the next step is which room of this step again, shape (rooms now, rooms next)."""
    now, then = (np.array([room.polygon for room in each.rooms], dtype=object) for each in (floor, following))
    common = overlap_areas(now, then)
    area = shapely.area(now)[:, None]
    return np.asarray((common > SAME_IOU * (area + shapely.area(then) - common)) | (common > HELD_SHARE * area))
