"""Metropolis-Hastings with a Boltzmann-like stationary distribution, many chains at once (thesis, section 7.4.2)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices, Mask

# Costs are rounded to this many decimals, so that another order of sums gives the same decisions on all machines.
DECIMALS = 9
# Iterations whose random numbers are drawn at once.
BLOCK = 256


def draw_uniforms(generators: Sequence[np.random.Generator], columns: int) -> Iterator[Floats]:
    """Yield numbers in [0, 1), shape (chains, columns), for each iteration.

    Each chain has its own generator, so that it does not depend on the other chains.
    """
    while True:
        block = np.stack([generator.random((BLOCK, columns)) for generator in generators], axis=1)
        yield from block


def choose(draws: Floats, counts: NDArray[np.integer]) -> Indices:
    """Uniform integers in [0, count)."""
    chosen: Indices = np.minimum((draws * counts).astype(np.intp), np.maximum(counts, 1) - 1)
    return chosen


def accept(costs: Floats, proposed: Floats, draws: Floats) -> Mask:
    """Which chains move: with probability min(1, exp(Γ(g) - Γ(g'))), the costs times α (eq. 7.3).

    Proposals count as symmetric, as in the thesis. One with an infinite cost is never accepted.
    """
    gains = np.minimum((costs - proposed).round(DECIMALS), 0)
    accepted: Mask = draws < np.exp(gains)
    return accepted


def measure_convergence(traces: Floats) -> float:
    """R̂, near 1 if chains with the same target have mixed (Gelman and Rubin, 1992; Koller and Friedman, p. 523).

    traces: a number of each chain in each iteration, shape (chains, iterations), at least (2, 2).
    """
    iterations = traces.shape[1]
    within = float(traces.var(axis=1, ddof=1).mean())
    between = iterations * float(traces.mean(axis=1).var(ddof=1))
    if within == 0:
        return 1.0 if between == 0 else np.inf
    return float(np.sqrt((iterations - 1) / iterations + between / iterations / within))
