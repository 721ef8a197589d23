"""Detected doors against true ones: by their positions, and by the rooms that they connect (thesis, section 3.1)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pianta._types import Floats, Mask
from pianta.evaluation.coverage import forward_coverage
from pianta.floor import Door, Floor


@dataclass(frozen=True)
class DetectionScores:
    """Numbers of true and of detected items, and of detected items that are correct.

    Shares are 0 if only one side has items, and 1 if neither has.
    """

    true: int
    detected: int
    correct: int

    @property
    def recall(self) -> float:
        """Share of the true items that were detected."""
        return self.correct / self.true if self.true else float(not self.detected)

    @property
    def precision(self) -> float:
        """Share of the detected items that are correct."""
        return self.correct / self.detected if self.detected else float(not self.true)

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall."""
        both = self.true + self.detected
        return 2 * self.correct / both if both else 1.0


def score_doors(floor: Floor, truth: Floor, *, reach: float | None = None, least_reach: float = 0.0) -> DetectionScores:
    """Doors and openings of a floor against those of the true floor, both in one frame.

    The largest one-to-one matching of doors whose midpoints are at most the reach apart; the rooms beside them do not
    matter. Some truths, such as the thesis', have only doors between rooms: if the truth has no entrances, those of the
    floor are ignored.
    reach: metres; None for half the width of each true door.
    least_reach: metres; a smaller reach is enlarged to it, such as that of a narrow door.
    """
    counted = list_counted_doors(floor, truth)
    is_right = match_doors(counted, truth.doors, reach=reach, least_reach=least_reach)
    return DetectionScores(len(truth.doors), len(counted), int(is_right.sum()))


def list_counted_doors(floor: Floor, truth: Floor) -> list[Door]:
    """The doors of a floor, without entrances if the truth has none: it then leaves them out."""
    has_entrances = any(door.is_entrance for door in truth.doors)
    return [door for door in floor.doors if has_entrances or not door.is_entrance]


def match_doors(
    doors: Sequence[Door], true_doors: Sequence[Door], *, reach: float | None = None, least_reach: float = 0.0
) -> Mask:
    """Whether each door has a true one in a largest one-to-one matching, shape (doors,).

    reach, least_reach: as in score_doors.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import maximum_bipartite_matching

    reaches = np.array([max(door.width / 2 if reach is None else reach, least_reach) for door in true_doors])
    distances = np.linalg.norm(_find_midpoints(doors)[:, None] - _find_midpoints(true_doors)[None], axis=2)
    is_near = distances <= reaches + 1e-9
    if not is_near.any():
        return np.zeros(len(doors), bool)
    return np.asarray(maximum_bipartite_matching(csr_array(is_near), perm_type="column") >= 0)


def score_connections(floor: Floor, truth: Floor) -> DetectionScores:
    """Pairs of rooms that the doors of a floor connect, against those of the true floor; both in one frame.

    A room stands for the true room that it overlaps most. Several doors of one pair count once; entrances, doors within
    one true room, and doors to a room that overlaps no true one do not count.
    """
    true_ids = _find_true_ids(floor, truth)
    pairs = _list_pairs(floor, true_ids)
    true_pairs = _list_pairs(truth, {room.id: room.id for room in truth.rooms})
    return DetectionScores(len(true_pairs), len(pairs), len(pairs & true_pairs))


def match_connections(floor: Floor, truth: Floor) -> Mask:
    """Whether each door of a floor joins two true rooms that a true door joins, shape (doors,); see score_connections.

    Entrances do not.
    """
    true_ids = _find_true_ids(floor, truth)
    true_pairs = _list_pairs(truth, {room.id: room.id for room in truth.rooms})
    pairs = (frozenset(true_ids.get(room, 0) for room in door.room_ids) for door in floor.doors)
    return np.array([pair in true_pairs for pair in pairs], bool)


def score_edges(floor: Floor, truth: Floor, matches: Mapping[int, int]) -> DetectionScores:
    """Edges of the room graph of a floor, which are pairs of rooms that doors connect, against those of the true one.

    An edge is right if both of its rooms match true rooms that a true door connects. Every other edge of the floor is
    wrong, also one of a room that matches no true room. Several doors of one pair count once; entrances do not count.

    matches: the id of the true room by the id of the room, one to one, such as of `match_rooms`; the rooms of the floor
    without a true room are left out.
    """
    pairs = _list_pairs(floor, {room.id: room.id for room in floor.rooms})
    true_pairs = _list_pairs(truth, {room.id: room.id for room in truth.rooms})
    right = sum(frozenset(matches.get(room, 0) for room in pair) in true_pairs for pair in pairs)
    return DetectionScores(len(true_pairs), len(pairs), right)


def _find_true_ids(floor: Floor, truth: Floor) -> dict[int, int]:
    """The id of the true room that a room overlaps most, by the id of the room, if there is one."""
    indices = forward_coverage([room.polygon for room in floor.rooms], [room.polygon for room in truth.rooms])
    return {
        room.id: truth.rooms[index].id for room, index in zip(floor.rooms, indices, strict=True) if index is not None
    }


def _list_pairs(floor: Floor, true_ids: Mapping[int, int]) -> set[frozenset[int]]:
    """Pairs of the true rooms that doors connect."""
    pairs = (frozenset(true_ids.get(room, 0) for room in door.room_ids) for door in floor.doors)
    return {pair for pair in pairs if len(pair) == 2 and 0 not in pair}


def _find_midpoints(doors: Sequence[Door]) -> Floats:
    """Midpoints of doors, shape (N, 2)."""
    points = [door.line.interpolate(0.5, normalized=True) for door in doors]
    return np.array([(point.x, point.y) for point in points]).reshape(-1, 2)
