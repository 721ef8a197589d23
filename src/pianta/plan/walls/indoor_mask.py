"""Which cells of a sheet lie inside of rooms: a minimum cut between the rooms and what is around them.

A gap in an outer wall joins a room to the paper, and a table may look like a courtyard. So no cell is classified alone:
the space is split at its narrow places, and each part is inside or outside such that two costs are least together: what
the network says against it, and the open borders between inside and outside (Greig, Porteous and Seheult, Exact maximum
a posteriori estimation for binary images, 1989).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask

PartLabels = NDArray[np.int32]


@dataclass(frozen=True, kw_only=True)
class IndoorParameters:
    """Costs and sizes of `indoor_mask`. Chosen by hand, no fit is on record."""

    network_reach: float = 1.5  # m from a barrier: further off the network sees no walls, and does not count
    open_border: float = 2.0  # m² of certain area that a metre of open border costs
    enclosed_bonus: float = 0.3  # by which what barriers enclose is rather inside than the network says
    part_distance: float = 0.5  # m between the middles of two parts of the space, at least
    min_patch_area: float = 1.0  # m²: smaller patches of inside are dropped


PARAMETERS = IndoorParameters()
# Capacities of the cut are whole numbers, thousandths of a m²
CAPACITIES_PER_M2 = 1000


def indoor_mask(free: Mask, outside: NDArray[np.float32], cell: float) -> Mask:
    """Which of the free space lies inside of rooms, shape (H, W).

    free: between the barriers. outside: probability of outside less that of inside, -1 … 1. cell: metres.
    """
    p = PARAMETERS
    padded = np.pad(free.astype(np.uint8), 1, constant_values=1)
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1] * cell
    parts = split_space(distance, cell)
    count = int(parts.max(initial=0)) + 1
    # The network counts where it sees walls; what they enclose is seldom a yard; the edge of the sheet is outside
    evidence = np.where(distance <= p.network_reach, p.enclosed_bonus * enclosed_mask(free) - outside, 0)
    gains: Floats = np.asarray(np.bincount(parts.ravel(), evidence.ravel(), minlength=count) * cell**2, float)
    gains -= p.open_border * cell * np.bincount(_rim(parts), minlength=count)
    pairs, lengths = shared_borders(parts)
    chosen = minimum_cut(gains, pairs, p.open_border * cell * lengths)
    chosen[0] = False
    _, patches, stats, _ = cv2.connectedComponentsWithStats(chosen[parts].view(np.uint8), connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] * cell**2 >= p.min_patch_area
    large[0] = False
    return np.asarray(large[patches])


def split_space(distance: NDArray[np.float32], cell: float) -> PartLabels:
    """Parts of the free space around its widest places, 1 …, and 0 for what is not free; shape (H, W).

    distance: to the next barrier, metres, 0 for what is not free.
    """
    from skimage.segmentation import watershed

    window = max(3, round(PARAMETERS.part_distance / cell)) | 1
    widest = (distance > 0) & (distance == cv2.dilate(distance, np.ones((window, window), np.uint8)))
    _, middles = cv2.connectedComponents(widest.view(np.uint8), connectivity=8)
    # Blocks of 2 × 2 cells are flooded first, as there are fewer; then single cells where a block is not free
    least, highest = _pool(distance, np.minimum), _pool(middles, np.maximum)
    blocks = watershed(-least, highest, mask=least > 0)
    rows, cols = distance.shape
    within = blocks.repeat(2, axis=0).repeat(2, axis=1)[:rows, :cols]
    return grow_labels(-distance, np.where(middles > 0, middles, within), distance > 0)


def grow_labels(heights: NDArray[np.float32], labels: PartLabels, mask: Mask) -> PartLabels:
    """The labels grown over the rest of a mask, from the lowest cells on; shape (H, W).

    labels: 0 where nothing is labelled yet. It is the watershed with the labels for markers.
    """
    from skimage.segmentation import watershed

    rest = mask & (labels == 0)
    # Nothing grows within what has a label, so only its edge is flooded
    flooded = mask & (cv2.dilate(rest.view(np.uint8), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))) > 0)
    grown = watershed(heights, np.where(flooded, labels, 0), mask=flooded)
    return np.where(rest, grown, labels).astype(np.int32)


def _pool(cells: NDArray[Any], reduce: np.ufunc) -> NDArray[Any]:
    """Each block of 2 × 2 cells reduced to one; beyond an odd edge are zeros."""
    rows, cols = cells.shape
    even = np.pad(cells, ((0, rows % 2), (0, cols % 2)))
    pairs = reduce(even[::2], even[1::2])
    return np.asarray(reduce(pairs[:, ::2], pairs[:, 1::2]))


def enclosed_mask(free: Mask) -> Mask:
    """Which of the free space has no way to the edge of the sheet, shape (H, W)."""
    _, patches = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    reached = np.isin(np.arange(patches.max(initial=0) + 1), _rim(patches))
    reached[0] = True
    return np.asarray(~reached[patches])


def _rim(cells: NDArray[Any]) -> NDArray[Any]:
    """The cells along the edge of an image; its corners twice."""
    return np.concatenate([cells[0], cells[-1], cells[:, 0], cells[:, -1]])


def shared_borders(parts: PartLabels) -> tuple[NDArray[np.int64], Floats]:
    """Pairs of parts that touch, shape (N, 2), and along how many sides of cells each does, shape (N,)."""
    sides = []
    for one, other in ((parts[1:], parts[:-1]), (parts[:, 1:], parts[:, :-1])):
        touches = (one != other) & (one > 0) & (other > 0)
        sides.append(np.column_stack([one[touches], other[touches]]))
    pairs, lengths = np.unique(np.sort(np.concatenate(sides), axis=1), axis=0, return_counts=True)
    return pairs.astype(np.int64), lengths.astype(float)


def minimum_cut(gains: Floats, pairs: NDArray[np.int64], costs: Floats) -> Mask:
    """Which parts to choose, shape (N,), for the highest sum of gains less the costs of pairs that are separated.

    gains: shape (N,), of choosing each part, m². pairs: shape (M, 2). costs: shape (M,).
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order, maximum_flow

    count = len(gains)
    source, sink, every = np.full(count, count), np.full(count, count + 1), np.arange(count)
    starts = np.concatenate([source, every, *pairs.T])
    ends = np.concatenate([every, sink, *pairs.T[::-1]])
    capacities = np.concatenate([np.maximum(gains, 0), np.maximum(-gains, 0), costs, costs])
    shape = (count + 2, count + 2)
    whole_numbers = np.rint(CAPACITIES_PER_M2 * capacities).astype(np.int32)
    network = coo_array((whole_numbers, (starts, ends)), shape=shape).tocsr()
    # The source's side of the cut is what it still reaches beside the maximum flow
    residual = network - maximum_flow(network, count, count + 1).flow
    residual.eliminate_zeros()
    chosen = np.zeros(count + 2, bool)
    chosen[breadth_first_order(residual, count, return_predecessors=False)] = True
    return chosen[:count]
