"""The order in which to visit targets of different worth: the travelling repairman problem."""

from __future__ import annotations

import numpy as np

from pianta._types import Floats

# Partial tours that the beam search keeps; chosen by hand.
BEAM_WIDTH = 150


def choose_first_target(distances: Floats, between: Floats, worths: Floats, lengths: Floats) -> int:
    """Return the first target of the best tour through all targets, by beam search.

    A tour is better the less worth waits: it minimises Σ worth · distance travelled until half of the target has been
    observed (Afrati et al., The complexity of the travelling repairman problem, 1986).
    distances: from the robot, metres, shape (n,). between: from target to target, shape (n, n). worths: above 0, shape
    (n,). lengths: of the path within each target, metres, shape (n,).
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
        order = np.argsort(following.ravel(), kind="stable")[: 4 * BEAM_WIDTH]
        order = order[np.isfinite(following.ravel()[order])]
        if not len(order):
            break
        tours, targets = order // count, order % count
        extended = visited[tours].copy()
        extended[np.arange(len(tours)), targets] = True
        # Of tours with the same targets and the same end, only the best can become the best whole tour.
        _, firsts = np.unique(np.column_stack([extended, targets]), axis=0, return_index=True)
        best = np.sort(firsts)[:BEAM_WIDTH]
        first, last, visited = first[tours[best]], targets[best], extended[best]
        costs, done = following.ravel()[order[best]], done[tours[best]] + worths[last]
    return int(first[int(np.argmin(costs))])
