"""Evidence of the scale, each piece with its own error, combined to metres per pixel with an interval.

All errors are of the logarithm of a length, since a scale is wrong by a factor. Most evidence is right or nonsense: a
text was misread, a room was cut, curves in furniture are no doors. So each measure, and each kind as a whole, is a
mixture of a normal distribution and an even one over all scales: nonsense loses against what agrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import log

import numpy as np
from scipy.ndimage import gaussian_filter1d

from pianta._types import Floats

STEP = 0.005  # of the logarithm of metres per pixel, between two scales that are compared
# Shares of the density that the two intervals hold
USUAL_SHARE = 0.80
WIDE_SHARE = 0.95
LEAST_DENSITY = 1e-300  # above 0, for its logarithm
RIGHT_FACTOR = 1.15  # a scale is right within this factor


@dataclass(frozen=True)
class Measure:
    """Metres per pixel by one text, room or door.

    resolutions: more than one if it can be read in several ways, such as a size in feet or metres.
    log_sd: standard deviation of the logarithm. rough_sd: the same if what was measured is not quite what is meant, as
    a room that was cut; it is as likely as nonsense.
    """

    resolutions: tuple[float, ...]
    log_sd: float
    rough_sd: float | None = None


@dataclass(frozen=True)
class ScaleEvidence:
    """Metres per pixel by one kind of evidence.

    text: what it is, in words, such as "8 doors". measures: each on its own. common_sd: standard deviation of the
    logarithm of the factor by which all measures are off together. outlier_rate: probability that one measure is
    nonsense. failure_rate: that all are. is_look: whether it says nothing but how buildings usually look.
    """

    text: str
    measures: tuple[Measure, ...]
    common_sd: float
    outlier_rate: float
    failure_rate: float
    is_look: bool = False


@dataclass(frozen=True)
class CombinedScale:
    """Metres per pixel by all evidence.

    resolution: the median. usual, wide: intervals that hold USUAL_SHARE and WIDE_SHARE of the density.
    agreeing: the kinds that support it, the strongest first. certainty: probability that it is right.
    """

    resolution: float
    usual: tuple[float, float]
    wide: tuple[float, float]
    agreeing: tuple[ScaleEvidence, ...] = field(default=())
    certainty: float = 0.0


def combine_evidence(evidence: Sequence[ScaleEvidence], *, low: float, high: float) -> CombinedScale:
    """The scale by all evidence, between two scales, metres per pixel.

    Without evidence every scale is as likely as any other.
    """
    grid = np.linspace(log(low), log(high), round(log(high / low) / STEP) + 2)
    densities = np.array([density_of(each, grid) for each in evidence]).reshape(-1, len(grid))
    logarithm = np.log(np.maximum(densities, LEAST_DENSITY)).sum(axis=0)
    density = np.exp(logarithm - logarithm.max())
    density /= density.sum()
    reached = np.cumsum(density)

    def quantile(share: float) -> float:
        return float(np.exp(grid[min(int(np.searchsorted(reached, share)), len(grid) - 1)]))

    median = quantile(0.5)
    usual, wide = ((quantile((1 - share) / 2), quantile((1 + share) / 2)) for share in (USUAL_SHARE, WIDE_SHARE))
    off = np.abs(grid - log(median))
    # What supports the result makes it likelier than the even distribution does
    gains = densities[:, int(off.argmin())] * (grid[-1] - grid[0])
    agreeing = tuple(evidence[index] for index in np.argsort(-gains, kind="stable") if gains[index] > 1)
    return CombinedScale(median, usual, wide, agreeing, float(density[off <= log(RIGHT_FACTOR)].sum()))


def density_of(evidence: ScaleEvidence, grid: Floats) -> Floats:
    """The density of a kind of evidence, shape (N,), over even logarithms of metres per pixel, shape (N,)."""
    even, step = 1 / (grid[-1] - grid[0]), float(grid[1] - grid[0])
    logarithm = np.zeros(len(grid))
    for measure in evidence.measures:
        off = grid - np.log(np.array(measure.resolutions))[:, None]
        doubtful = np.full(len(grid), even)
        if measure.rough_sd is not None:
            doubtful = (doubtful + _normal(off, measure.rough_sd)) / 2
        density = (1 - evidence.outlier_rate) * _normal(off, measure.log_sd) + evidence.outlier_rate * doubtful
        logarithm += np.log(np.maximum(density, LEAST_DENSITY))
    density = np.exp(logarithm - logarithm.max())
    if evidence.common_sd > 0:
        density = gaussian_filter1d(density, evidence.common_sd / step, mode="constant")
    density /= max(float(density.sum()) * step, LEAST_DENSITY)
    return np.asarray((1 - evidence.failure_rate) * density + evidence.failure_rate * even)


def _normal(off: Floats, sd: float) -> Floats:
    """The mean density, shape (N,), of normal distributions at offsets, shape (M, N)."""
    return np.asarray(np.exp(-((off / sd) ** 2) / 2).mean(axis=0) / (sd * np.sqrt(2 * np.pi)))
