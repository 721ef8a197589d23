"""Ways over the free cells of a grid: how far each cell is, and the way there.

Steps lead to the eight cells around one; a diagonal step needs both cells beside it. Costs are whole numbers, 70 for a
straight step and 99 for a diagonal one (√2 to within 3 in 100,000), so that every implementation finds the same.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import ceil, hypot, inf

import numpy as np
from numpy.typing import NDArray

from pianta._types import Mask
from pianta.exploration.kernels import choose_kernel

Costs = NDArray[np.int32]

STRAIGHT, DIAGONAL = 70, 99
UNREACHED = np.iinfo(np.int32).max
STEPS = ((-1, 0), (0, -1), (0, 1), (1, 0), (-1, -1), (-1, 1), (1, -1), (1, 1))


def measure_distances(passable: Mask, sources: Iterable[tuple[int, int]], *, resolution: float) -> NDArray[np.float64]:
    """How far each cell is from the nearest source over passable cells, metres, shape (H, W); inf where no way leads.

    passable: shape (H, W). sources: row, col; those that are not passable are left out. resolution: metres per cell.
    """
    distances = np.full(passable.shape, inf)
    starts = np.array([source for source in sources if passable[source]], np.int64).reshape(-1, 2)
    if not len(starts):
        return distances
    rows, cols = (np.flatnonzero(passable.any(axis=axis)) for axis in (1, 0))
    window = slice(rows[0], rows[-1] + 1), slice(cols[0], cols[-1] + 1)
    find = choose_kernel(spread_costs, solve_costs)
    costs = find(np.pad(passable[window], 1), starts - [rows[0] - 1, cols[0] - 1])[1:-1, 1:-1]
    reached = costs != UNREACHED
    distances[window][reached] = costs[reached] * (resolution / STRAIGHT)
    return distances


def find_route(distances: NDArray[np.float64], target: tuple[int, int], *, resolution: float) -> NDArray[np.int_]:
    """The cells, shape (N, 2), of a shortest way from a source to a target, both included.

    distances: of measure_distances, metres; that of the target is finite. resolution: metres per cell.
    """
    height, width = distances.shape
    straight = resolution
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
            length = distances[other] + straight * (DIAGONAL / STRAIGHT if down and right else 1)
            # Sums of the same length may differ in their last bits.
            if length < best - straight / 1000:
                best, following = length, other
        row, col = following
        cells.append(following)
    return np.array(cells[::-1])


def straighten_route(route: NDArray[np.int_], passable: Mask) -> NDArray[np.int_]:
    """The corners, shape (N, 2), of a route pulled tight: from each the furthest that lies in a straight line of sight.

    route: cells, shape (M, 2), of find_route. passable: shape (H, W).
    """
    corners, here = [0], 0
    while here < len(route) - 1:
        # Twice as far while it is in sight, then halfway back: what is in sight need not be found, only near it.
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


def spread_costs(passable: Mask, sources: NDArray[np.int64]) -> Costs:
    """Costs from the sources by Dijkstra's algorithm with a bucket for each cost (Dial, 1969); for numba.

    passable: shape (H, W), with a rim that is not.
    A cell waits in one bucket at most. Buckets are rings through `after` and `before`, where their own numbers follow
    those of the cells, and the cost of a step is less than their number.
    """
    width, cells, buckets = passable.shape[1], passable.size, DIAGONAL + 1
    is_open, costs = passable.ravel(), np.full(cells, UNREACHED, np.int32)
    after = np.arange(cells + buckets, dtype=np.int32)
    before = after.copy()
    waiting = cost = 0
    for row, col in sources:
        source = row * width + col
        if costs[source] != 0:
            costs[source], after[source], before[source] = 0, after[cells], cells
            before[after[cells]] = after[cells] = source
            waiting += 1
    while waiting:
        bucket = cells + cost % buckets
        cell = after[bucket]
        if cell == bucket:
            cost += 1
            continue
        after[bucket], before[after[cell]] = after[cell], bucket
        waiting -= 1
        for down, right in STEPS:
            other = cell + down * width + right
            if not (is_open[other] and is_open[cell + down * width] and is_open[cell + right]):
                continue
            new = cost + (DIAGONAL if down and right else STRAIGHT)
            if new >= costs[other]:
                continue
            if costs[other] == UNREACHED:
                waiting += 1
            else:
                after[before[other]], before[after[other]] = after[other], before[other]
            head = cells + new % buckets
            costs[other], after[other], before[other] = new, after[head], head
            before[after[head]] = after[head] = other
    return costs.reshape(passable.shape)


def solve_costs(passable: Mask, sources: NDArray[np.int64]) -> Costs:
    """Costs from the sources by scipy's Dijkstra over the graph of cells; without numba."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import dijkstra

    height, width = passable.shape
    numbers = np.full((height + 2, width + 2), -1)
    here = numbers[1:-1, 1:-1]
    here[passable] = np.arange(np.count_nonzero(passable))
    starts, ends, costs = [], [], []
    for down, right in STEPS:
        there, beside, above = (
            numbers[1 + i : height + 1 + i, 1 + j : width + 1 + j] for i, j in ((down, right), (0, right), (down, 0))
        )
        open_ = (here >= 0) & (there >= 0) & (beside >= 0) & (above >= 0)
        starts.append(here[open_])
        ends.append(there[open_])
        costs.append(np.full(np.count_nonzero(open_), float(DIAGONAL if down and right else STRAIGHT)))
    count = np.count_nonzero(passable)
    graph = coo_array((np.concatenate(costs), (np.concatenate(starts), np.concatenate(ends))), shape=(count, count))
    of_cells = dijkstra(graph.tocsr(), indices=here[tuple(sources.T)], min_only=True)
    found = np.full(passable.shape, UNREACHED, np.int32)
    found[passable] = np.where(np.isfinite(of_cells), of_cells, UNREACHED).astype(np.int32)
    return found
