"""What of a sheet lies inside of rooms: a minimum cut between the rooms and what is around them.

A gap in an outer wall joins a room to the paper, and a table may look like a court. So no spot is judged alone: the
space is parted at its narrow places, and the parts are called inside or outside at the least cost of all, of what the
network says against them, and of the open borders between inside and outside (Greig, Porteous and Seheult, Exact
maximum a posteriori estimation for binary images, 1989).
"""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask

# Only so near to barriers the network sees enough to tell, metres.
SEEN = 1.5
# A metre of open border weighs as much as so much area that the network is sure of; m².
OPEN_BORDER = 2.0
# By how much what is enclosed by barriers is rather inside than what the network says.
ENCLOSED = 0.3
# Parts of the space have their middles at least so far apart, metres.
APART = 0.5
# Smaller patches of space are none; m².
PATCH = 1.0
# Capacities of the cut are whole numbers, parts of a m².
UNITS = 1000

Labels = NDArray[np.int32]


def find_inside(free: Mask, outside: NDArray[np.float32], cell: float) -> Mask:
    """What of the free space lies inside of rooms, shape (H, W).

    free: between the barriers. outside: by how much the network rather takes each spot for outside, -1 … 1.
    cell: metres.
    """
    padded = np.pad(free.astype(np.uint8), 1, constant_values=1)
    distance = cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1] * cell
    parts = part_space(distance, cell)
    count = int(parts.max(initial=0)) + 1
    # The network speaks where it sees walls; what they enclose is seldom a yard; beyond the sheet's edge is nothing
    told = np.where(distance <= SEEN, ENCLOSED * find_enclosed(free) - outside, 0)
    gains: Floats = np.asarray(np.bincount(parts.ravel(), told.ravel(), minlength=count) * cell**2, float)
    rim = np.concatenate([parts[0], parts[-1], parts[:, 0], parts[:, -1]])
    gains -= OPEN_BORDER * cell * np.bincount(rim, minlength=count)
    pairs, lengths = find_borders(parts)
    chosen = cut_parts(gains, pairs, OPEN_BORDER * cell * lengths)
    chosen[0] = False
    _, patches, stats, _ = cv2.connectedComponentsWithStats(chosen[parts].view(np.uint8), connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] * cell**2 >= PATCH
    large[0] = False
    return np.asarray(large[patches])


def part_space(distance: NDArray[np.float32], cell: float) -> Labels:
    """Parts of the free space around the places that are widest, 1 …, and 0 for what is not free; shape (H, W).

    distance: to the next barrier, metres, 0 for what is not free.
    """
    from skimage.segmentation import watershed

    window = max(3, round(APART / cell)) | 1
    widest = (distance > 0) & (distance == cv2.dilate(distance, np.ones((window, window), np.uint8)))
    _, middles = cv2.connectedComponents(widest.view(np.uint8), connectivity=8)
    # Blocks of 2 × 2 cells are flooded first, as there are fewer; cells for themselves where a block is not free
    least, highest = _pool(distance, np.minimum), _pool(middles, np.maximum)
    blocks = watershed(-least, highest, mask=least > 0)
    rows, cols = distance.shape
    within = blocks.repeat(2, axis=0).repeat(2, axis=1)[:rows, :cols]
    return grow_labels(-distance, np.where(middles > 0, middles, within), distance > 0)


def grow_labels(heights: NDArray[np.float32], labels: Labels, mask: Mask) -> Labels:
    """The labels grown over the rest of a mask, the lowest places first; shape (H, W).

    labels: 0 where there is none yet. It is the watershed with the labels for markers.
    """
    from skimage.segmentation import watershed

    rest = mask & (labels == 0)
    # Within what has a label nothing grows, so only its edge is asked
    asked = mask & (cv2.dilate(rest.view(np.uint8), cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))) > 0)
    grown = watershed(heights, np.where(asked, labels, 0), mask=asked)
    return np.where(rest, grown, labels).astype(np.int32)


def _pool(cells: NDArray[Any], choose: np.ufunc) -> NDArray[Any]:
    """What is chosen of each block of 2 × 2 cells; zeros lie beyond an odd edge."""
    rows, cols = cells.shape
    even = np.pad(cells, ((0, rows % 2), (0, cols % 2)))
    pairs = choose(even[::2], even[1::2])
    return np.asarray(choose(pairs[:, ::2], pairs[:, 1::2]))


def find_enclosed(free: Mask) -> Mask:
    """What of the free space has no way to the edge of the sheet, shape (H, W)."""
    _, patches = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    rim = np.concatenate([patches[0], patches[-1], patches[:, 0], patches[:, -1]])
    reached = np.isin(np.arange(patches.max(initial=0) + 1), rim)
    reached[0] = True
    return np.asarray(~reached[patches])


def find_borders(parts: Labels) -> tuple[NDArray[np.int64], Floats]:
    """Pairs of parts that meet, shape (N, 2), and along how many sides of cells each does, shape (N,)."""
    sides = []
    for one, other in ((parts[1:], parts[:-1]), (parts[:, 1:], parts[:, :-1])):
        meet = (one != other) & (one > 0) & (other > 0)
        sides.append(np.column_stack([one[meet], other[meet]]))
    pairs, lengths = np.unique(np.sort(np.concatenate(sides), axis=1), axis=0, return_counts=True)
    return pairs.astype(np.int64), lengths.astype(float)


def cut_parts(gains: Floats, pairs: NDArray[np.int64], costs: Floats) -> Mask:
    """Which parts are chosen, shape (N,), for the highest sum of gains less the costs of pairs that are parted.

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
    network = coo_array((np.rint(UNITS * capacities).astype(np.int32), (starts, ends)), shape=shape).tocsr()
    # What the source still reaches when all flows that can is on its side of the minimum cut
    left = network - maximum_flow(network, count, count + 1).flow
    left.eliminate_zeros()
    chosen = np.zeros(count + 2, bool)
    chosen[breadth_first_order(left, count, return_predecessors=False)] = True
    return chosen[:count]
