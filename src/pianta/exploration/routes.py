"""Shortest paths over the free cells of a grid.

Steps lead to the eight cells around one; a diagonal step needs both cells beside it. Costs are whole numbers, 70 for a
straight step and 99 for a diagonal one (√2 to within 3 in 100,000), so that sums do not depend on their order.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import ceil, hypot, inf
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask

if TYPE_CHECKING:
    from scipy.sparse import csr_array

STRAIGHT = 70
DIAGONAL = 99
STEPS = ((-1, 0), (0, -1), (0, 1), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))
# Lengths closer than this share of a cell are equal: sums of the same steps may differ in their last bits.
TOLERANCE_PX = 0.001


def measure_distances(passable: Mask, sources: Iterable[tuple[int, int]], *, resolution: float) -> Floats:
    """Measure the shortest path from each cell to its nearest source, metres, shape (H, W); inf without a path.

    passable: shape (H, W). sources: row, col; those that are not passable are ignored. resolution: metres per cell.
    """
    from scipy.sparse.csgraph import dijkstra

    distances = np.full(passable.shape, inf)
    if starts := [source for source in sources if passable[source]]:
        numbers = np.cumsum(passable).reshape(passable.shape) - 1
        costs = dijkstra(_build_graph(passable), indices=[numbers[start] for start in starts], min_only=True)
        distances[passable] = costs * (resolution / STRAIGHT)
    return distances


def measure_distances_between(
    passable: Mask, cells: NDArray[np.int_], *, resolution: float, coarseness: int = 2
) -> Floats:
    """Measure the shortest path from each cell to each other, metres, shape (n, n); inf without a path.

    passable: shape (H, W). cells: row, col, shape (n, 2). Square blocks of `coarseness` cells count as one, which is
    passable if any of its cells is, so that lengths may be off by some blocks.
    """
    from scipy.sparse.csgraph import dijkstra

    height, width = (-(-length // coarseness) for length in passable.shape)
    padded = np.zeros((height * coarseness, width * coarseness), bool)
    padded[: passable.shape[0], : passable.shape[1]] = passable
    coarse: Mask = np.asarray(padded.reshape(height, coarseness, width, coarseness).any(axis=(1, 3)))
    rows, cols = (cells // coarseness).T
    coarse[rows, cols] = True
    numbers = (np.cumsum(coarse).reshape(coarse.shape) - 1)[rows, cols]
    costs = dijkstra(_build_graph(coarse), indices=numbers)[:, numbers]
    return np.asarray(costs * (resolution * coarseness / STRAIGHT))


def find_route(distances: NDArray[np.float64], target: tuple[int, int], *, resolution: float) -> NDArray[np.int_]:
    """The cells, row, col, shape (N, 2), of a shortest path from a source to a target, both included.

    distances: of `measure_distances`, metres, finite at the target. resolution: metres per cell.
    """
    height, width = distances.shape
    row, col = target
    cells = [(row, col)]
    while distances[row, col] > 0:
        best, following = inf, (row, col)
        for down, right in STEPS:
            other = row + down, col + right
            if not (0 <= other[0] < height and 0 <= other[1] < width):
                continue
            if down and right and not max(distances[row, other[1]], distances[other[0], col]) < inf:
                continue
            length = distances[other] + resolution * (DIAGONAL / STRAIGHT if down and right else 1)
            if length < best - TOLERANCE_PX * resolution:
                best, following = length, other
        row, col = following
        cells.append(following)
    return np.array(cells[::-1])


def straighten_route(route: NDArray[np.int_], passable: Mask) -> NDArray[np.int_]:
    """The corners, shape (N, 2), of a straightened route: from each cell a straight line to the furthest one in sight.

    route: cells, shape (M, 2), of `find_route`. passable: shape (H, W).
    """
    corners, here = [0], 0
    while here < len(route) - 1:
        # Double the stride while in sight, then halve it: an approximation, since sight is not monotonic.
        stride, ahead = 1, here + 1
        while stride:
            further = min(ahead + stride, len(route) - 1)
            if further > ahead and _in_sight(route[here], route[further], passable):
                ahead, stride = further, stride * 2
            else:
                stride //= 2
        here = ahead
        corners.append(here)
    return route[corners]


def _in_sight(start: NDArray[np.int_], end: NDArray[np.int_], passable: Mask) -> bool:
    """Whether the straight line between the middles of two cells stays on passable cells."""
    (row0, col0), (row1, col1) = start.tolist(), end.tolist()
    samples = ceil(4 * hypot(row1 - row0, col1 - col0)) + 1
    rows = np.floor(np.linspace(row0 + 0.5, row1 + 0.5, samples)).astype(int)
    cols = np.floor(np.linspace(col0 + 0.5, col1 + 0.5, samples)).astype(int)
    return bool(passable[rows, cols].all())


def _build_graph(passable: Mask) -> csr_array:
    """The costs of steps between passable cells, which are numbered row by row."""
    from scipy.sparse import csr_array

    is_open = np.pad(passable, 1)
    width, is_open = is_open.shape[1], is_open.ravel()
    cells, numbers = np.flatnonzero(is_open), np.cumsum(is_open, dtype=np.int32) - 1
    # A diagonal step needs both cells beside it; for a straight step these are its own two cells.
    possible = np.column_stack(
        [
            is_open[cells + down * width + right] & is_open[cells + down * width] & is_open[cells + right]
            for down, right in STEPS
        ]
    )
    targets = numbers[cells[:, None] + [down * width + right for down, right in STEPS]][possible]
    costs = np.array([DIAGONAL if down and right else STRAIGHT for down, right in STEPS], float)
    starts = np.concatenate([[0], np.cumsum(possible.sum(axis=1))]).astype(np.int32)
    shape = len(cells), len(cells)
    return csr_array((np.broadcast_to(costs, possible.shape)[possible], targets, starts), shape=shape)
