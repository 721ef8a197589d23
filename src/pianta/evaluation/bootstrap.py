"""Bootstrap intervals of means and ratios (Efron, 1979).

Not by scipy.stats.bootstrap: it draws other samples from the same seed, so published figures would change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pianta._types import Floats
from pianta.errors import OptionError

REPEATS = 10_000
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Interval:
    """A mean with its confidence interval; count: number of items."""

    mean: float
    low: float
    high: float
    count: int


def bootstrap_mean(
    values: Sequence[float], *, seed: int, repeats: int = REPEATS, share: float = CONFIDENCE
) -> Interval | None:
    """The mean of values with its bootstrap interval; None without values.

    share: of the resampled means that are in the interval; as many are below as above.
    Raises OptionError for values that are not finite, repeats below 1, and a share outside 0 … 1.
    """
    return bootstrap_ratio(values, [1.0] * len(values), seed=seed, repeats=repeats, share=share)


def bootstrap_ratio(
    values: Sequence[float],
    others: Sequence[float],
    *,
    seed: int,
    repeats: int = REPEATS,
    share: float = CONFIDENCE,
) -> Interval | None:
    """The ratio of two sums with its bootstrap interval, resampled by pairs; None without values.

    share: as in bootstrap_mean. others: a positive one for each value.
    Raises OptionError as bootstrap_mean, and for others that are not positive.
    """
    above, below = np.array(values, float), np.array(others, float)
    _check(above, below, repeats=repeats, share=share)
    if not len(above):
        return None
    samples = np.random.default_rng(seed).integers(len(above), size=(repeats, len(above)))
    ratios = above[samples].sum(axis=1) / below[samples].sum(axis=1)
    low, high = np.quantile(ratios, [(1 - share) / 2, (1 + share) / 2]).tolist()
    return Interval(float(above.sum() / below.sum()), low, high, len(above))


def _check(above: Floats, below: Floats, *, repeats: int, share: float) -> None:
    """Raise OptionError for unequal shapes, values not finite, `below` not above 0, and options out of range."""
    if above.shape != below.shape:
        raise OptionError(f"{len(above)} values stand beside {len(below)} others, give as many")
    if not (np.isfinite(above).all() and np.isfinite(below).all()):
        raise OptionError("some of the values are not finite, leave them out")
    if (below <= 0).any():
        raise OptionError(f"the least of the values to divide by is {below.min():g}, give those above 0")
    if repeats < 1 or not 0 < share < 1:
        raise OptionError(
            f"repeats are {repeats}, share is {share}, give 1 repeat at least and a share between 0 and 1"
        )
