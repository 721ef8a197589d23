"""Coverage of reconstructed rooms by true rooms and back (thesis, section 3.2), for polygons in one planar frame.

Every share is in 0 … 1: 0 if only one side has rooms, 1 if neither has. A room without area, or without any overlap,
counts 0. Invalid polygons are repaired with shapely.make_valid.
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
    """How well reconstructed rooms and true rooms cover each other.

    a_fc, a_bc: forward and backward accuracy, weighted by area (thesis, section 3.2).
    precision, recall: the same as unweighted means over the rooms (thesis, section 3.2).
    mean_iou: mean over the true rooms of the best intersection over union with a reconstructed room.
    f1: harmonic mean of the shares of reconstructed and of true rooms that match one to one with IoU above 0.5.
    reconstructed, true: numbers of rooms.
    """

    a_fc: float
    a_bc: float
    precision: float
    recall: float
    mean_iou: float
    f1: float
    reconstructed: int
    true: int


def score_layout(rooms: Sequence[Polygon], truth: Sequence[Polygon]) -> Scores:
    """Scores of reconstructed rooms against true rooms; the whole area of each polygon counts."""
    reconstructed, true = _repair_polygons(rooms), _repair_polygons(truth)
    overlaps = overlap_areas(reconstructed, true)
    return score_overlaps(overlaps, shapely.area(reconstructed), shapely.area(true))


def forward_coverage(rooms: Sequence[Polygon], truth: Sequence[Polygon]) -> list[int | None]:
    """FC: for each room the index of the true room that overlaps it most, or None."""
    overlaps = overlap_areas(_repair_polygons(rooms), _repair_polygons(truth))
    if not truth:
        return [None] * len(rooms)
    return [int(row.argmax()) if row.any() else None for row in overlaps]


def backward_coverage(rooms: Sequence[Polygon], truth: Sequence[Polygon]) -> list[int | None]:
    """BC: for each true room the index of the room that overlaps it most, or None."""
    return forward_coverage(truth, rooms)


def score_overlaps(
    overlaps: NDArray[np.float64], areas: NDArray[np.float64], true_areas: NDArray[np.float64]
) -> Scores:
    """Scores from the overlaps of N rooms with M true rooms, shape (N, M), and their areas, shapes (N,) and (M,)."""
    reconstructed, true = overlaps.shape
    if not (reconstructed and true):
        share = 1.0 if reconstructed == true else 0.0
        return Scores(share, share, share, share, share, share, reconstructed, true)
    forward, backward = overlaps.max(axis=1), overlaps.max(axis=0)
    iou = _ratio(overlaps, areas[:, None] + true_areas - overlaps)
    return Scores(
        a_fc=float(_ratio(forward.sum(), areas.sum())),
        a_bc=float(_ratio(backward.sum(), true_areas.sum())),
        precision=float(_ratio(forward, areas).mean()),
        recall=float(_ratio(backward, true_areas).mean()),
        mean_iou=float(iou.max(axis=0).mean()),
        f1=2 * count_matches(iou > 0.5) / (reconstructed + true),
        reconstructed=reconstructed,
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
    # Most rooms of a map that grows are as before, which is found faster than their intersection
    is_same = shapely.equals_exact(rooms[room], truth[true])
    overlaps[room, true] = np.where(is_same, shapely.area(rooms[room]), 0.0)
    room, true = room[~is_same], true[~is_same]
    overlaps[room, true] = shapely.area(shapely.intersection(rooms[room], truth[true]))
    return overlaps


def _ratio(part: NDArray[np.float64], total: NDArray[np.float64]) -> NDArray[np.float64]:
    """Share of the total, at most 1 in spite of rounding; 0 if the total is 0."""
    share: NDArray[np.float64] = np.divide(part, total, out=np.zeros(np.shape(total)), where=total > 0)
    return np.minimum(share, 1.0)


def count_matches(is_match: NDArray[np.bool_]) -> int:
    """The size of the largest one-to-one matching, shape (N, M).

    Rooms that do not overlap each other have at most one partner with IoU above 0.5.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import maximum_bipartite_matching

    return int((maximum_bipartite_matching(csr_array(is_match)) >= 0).sum()) if is_match.any() else 0
