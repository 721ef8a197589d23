"""Coverage of reconstructed rooms by true rooms and back (thesis, section 3.2), for polygons in any one plane frame.

Every share lies in 0 … 1. Where one of the two sides has no rooms every share is 0; where neither has, each is 1.
A room without area, or one that overlaps nothing, counts 0. Invalid polygons are repaired with shapely.make_valid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, STRtree


@dataclass(frozen=True)
class Scores:
    """How well the found rooms and the true rooms cover each other.

    a_fc, a_bc: forward and backward accuracy, weighted by area (thesis, section 3.2).
    precision, recall: the same as unweighted means over the rooms (thesis, section 3.2).
    mean_iou: mean over the true rooms of the best intersection over union with a found room.
    f1: harmonic mean of the shares of found and of true rooms that match one to one with IoU above 0.5.
    found, true: numbers of rooms.
    """

    a_fc: float
    a_bc: float
    precision: float
    recall: float
    mean_iou: float
    f1: float
    found: int
    true: int


def score_layout(rooms: Sequence[Polygon], truth: Sequence[Polygon]) -> Scores:
    """Scores of reconstructed rooms against true rooms; the whole area of each polygon counts."""
    found, true = _repair_polygons(rooms), _repair_polygons(truth)
    return score_overlaps(overlap_areas(found, true), shapely.area(found), shapely.area(true))


def forward_coverage(rooms: Sequence[Polygon], truth: Sequence[Polygon]) -> list[int | None]:
    """FC: for each room the index of the true room that overlaps it most, None where none does."""
    overlaps = overlap_areas(_repair_polygons(rooms), _repair_polygons(truth))
    if not truth:
        return [None] * len(rooms)
    return [int(row.argmax()) if row.any() else None for row in overlaps]


def backward_coverage(rooms: Sequence[Polygon], truth: Sequence[Polygon]) -> list[int | None]:
    """BC: for each true room the index of the room that overlaps it most, None where none does."""
    return forward_coverage(truth, rooms)


def forward_accuracy(rooms: Sequence[Polygon], truth: Sequence[Polygon]) -> float:
    """A_FC: the share of the rooms' area that lies in the true room each is mapped to; low when under-segmented."""
    return score_layout(rooms, truth).a_fc


def backward_accuracy(rooms: Sequence[Polygon], truth: Sequence[Polygon]) -> float:
    """A_BC: the share of the true rooms' area that lies in the room each is mapped to; low when over-segmented."""
    return score_layout(rooms, truth).a_bc


def precision(rooms: Sequence[Polygon], truth: Sequence[Polygon]) -> float:
    """Mean over the rooms of the share of each that lies in the true room it is mapped to."""
    return score_layout(rooms, truth).precision


def recall(rooms: Sequence[Polygon], truth: Sequence[Polygon]) -> float:
    """Mean over the true rooms of the share of each that lies in the room it is mapped to."""
    return score_layout(rooms, truth).recall


def score_overlaps(
    overlaps: NDArray[np.float64], found_areas: NDArray[np.float64], true_areas: NDArray[np.float64]
) -> Scores:
    """Scores from the overlaps of N found with M true rooms, shape (N, M), and the areas, shapes (N,) and (M,)."""
    found, true = overlaps.shape
    if not (found and true):
        share = 1.0 if found == true else 0.0
        return Scores(share, share, share, share, share, share, found, true)
    forward, backward = overlaps.max(axis=1), overlaps.max(axis=0)
    iou = _ratio(overlaps, found_areas[:, None] + true_areas - overlaps)
    return Scores(
        a_fc=float(_ratio(forward.sum(), found_areas.sum())),
        a_bc=float(_ratio(backward.sum(), true_areas.sum())),
        precision=float(_ratio(forward, found_areas).mean()),
        recall=float(_ratio(backward, true_areas).mean()),
        mean_iou=float(iou.max(axis=0).mean()),
        f1=2 * _count_matches(iou > 0.5) / (found + true),
        found=found,
        true=true,
    )


def _repair_polygons(polygons: Sequence[Polygon]) -> NDArray[np.object_]:
    """The polygons as an array, each valid and without spikes."""
    array = np.array(polygons, dtype=object)
    return np.asarray(shapely.make_valid(array, method="structure", keep_collapsed=False), dtype=object)


def overlap_areas(rooms: NDArray[np.object_], truth: NDArray[np.object_]) -> NDArray[np.float64]:
    """Area that each room shares with each true room, shape (N, M)."""
    overlaps = np.zeros((len(rooms), len(truth)))
    room, true = STRtree(truth).query(rooms, predicate="intersects")
    overlaps[room, true] = shapely.area(shapely.intersection(rooms[room], truth[true]))
    return overlaps


def _ratio(part: NDArray[np.float64], whole: NDArray[np.float64]) -> NDArray[np.float64]:
    """Part of the whole, at most 1 in spite of rounding; 0 where the whole is 0."""
    share: NDArray[np.float64] = np.divide(part, whole, out=np.zeros(np.shape(whole)), where=whole > 0)
    return np.minimum(share, 1.0)


def _count_matches(alike: NDArray[np.bool_]) -> int:
    """Most pairs that match one to one; found rooms that do not overlap each other have no choice above IoU 0.5."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import maximum_bipartite_matching

    return int((maximum_bipartite_matching(csr_array(alike)) >= 0).sum())
