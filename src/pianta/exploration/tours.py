"""In which order to visit places of different worth: as the travelling repairman does, for whom all have to wait."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.exploration.routes import measure_distances

# Partial tours that are followed up side by side.
WIDTH = 150


def choose_first_visit(distances: Floats, between: Floats, worths: Floats, lengths: Floats) -> int:
    """The place that the best tour through all places visits first.

    A tour is better the less worth waits over the way: Σ worth · way until half of the place has been seen (Afrati et
    al., The complexity of the travelling repairman problem, 1986). By beam search.
    distances: from the robot, metres, shape (n,). between: from place to place, shape (n, n). worths: above 0, shape
    (n,). lengths: of the way within each place, metres, shape (n,).
    """
    count, total = len(distances), worths.sum()
    first = last = np.arange(count)
    visited = np.eye(count, dtype=bool)
    done = worths.copy()
    costs = distances * total + lengths * (total - worths / 2)
    for _ in range(1, count):
        left = (total - done)[:, None]
        following = costs[:, None] + between[last] * left + lengths * (left - worths / 2)
        following[visited] = np.inf
        order = np.argsort(following.ravel(), kind="stable")[: 4 * WIDTH]
        order = order[np.isfinite(following.ravel()[order])]
        if not len(order):
            break
        tours, places = order // count, order % count
        grown = visited[tours].copy()
        grown[np.arange(len(tours)), places] = True
        # Of tours that have been to the same places and end at the same, the best is enough.
        _, kept = np.unique(np.column_stack([grown, places]), axis=0, return_index=True)
        kept = np.sort(kept)[:WIDTH]
        first, last, visited = first[tours[kept]], places[kept], grown[kept]
        costs, done = following.ravel()[order[kept]], done[tours[kept]] + worths[last]
    return int(first[int(np.argmin(costs))])


def measure_between(passable: Mask, targets: NDArray[np.int_], *, resolution: float, coarseness: int = 2) -> Floats:
    """On foot from each target cell to each other, metres, shape (n, n); inf where no way leads.

    passable: shape (H, W). Measured on cells that are coarser by a whole factor, passable where a part of them is, so
    that ways may be off by some of these.
    """
    height, width = (-(-length // coarseness) for length in passable.shape)
    padded = np.zeros((height * coarseness, width * coarseness), bool)
    padded[: passable.shape[0], : passable.shape[1]] = passable
    coarse: Mask = np.asarray(padded.reshape(height, coarseness, width, coarseness).any(axis=(1, 3)))
    rows, cols = (targets // coarseness).T
    coarse[rows, cols] = True
    found = [
        measure_distances(coarse, [place], resolution=resolution * coarseness)[rows, cols]
        for place in zip(rows.tolist(), cols.tolist(), strict=True)
    ]
    return np.array(found, float).reshape(len(targets), len(targets))
