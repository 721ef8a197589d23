"""The probability that a cell beyond the explored part is free, from the shares of samples around it."""

from __future__ import annotations

import cv2
import numpy as np
from scipy.ndimage import distance_transform_edt

from pianta._types import Floats, Mask

# Standard deviations of the Gaussians by which shares are blurred, m. With none, 1 and 2 m as well, the log loss on
# schools of other buildings was hardly lower.
BLURS = (4.0, 8.0)
# What is added to a share and to its complement, so that none is certain. Chosen by hand.
LEAST_SHARE = 0.02
FARTHEST = 40.0  # m; larger distances count as this. Chosen by hand.
MOSTLY = 0.5  # a cell is known if a smaller share of it is unknown
# The intercept; the weights of the log-odds of both blurred shares; those of the logarithms of one plus the distances,
# m, to the known part and to the nearest opening. Fitted to 32 schools by benchmarks/measure_predicted_grids.py.
INTERCEPT = 0.774
WEIGHTS = (1.433, -0.991, 1.506, -1.639)


def describe_cells(shares: Floats, unknown: Floats, openings: Mask, *, cell: float) -> Floats:
    """The features of each cell, shape (H, W, 4): those of WEIGHTS.

    shares: of samples in which the unknown part of a cell is free. unknown: the unknown share of each cell.
    openings: cells where the known part goes on. cell: side of a cell, m.
    """
    blurred = [
        _blur(shares * unknown, sigma / cell) / np.maximum(_blur(unknown, sigma / cell), 1e-6) for sigma in BLURS
    ]
    odds = [(share + LEAST_SHARE) / (1 - share + LEAST_SHARE) for share in blurred]
    distances = [_measure_distances(mask, cell) for mask in (unknown < MOSTLY, openings)]
    return np.stack([*map(np.log, odds), *map(np.log1p, distances)], axis=-1)


def find_free_probability(features: Floats) -> Floats:
    """The probability that each cell is free, shape (H, W), by the features of describe_cells."""
    return np.asarray(1 / (1 + np.exp(-(INTERCEPT + features @ np.array(WEIGHTS)))))


def _blur(values: Floats, sigma: float) -> Floats:
    blurred: Floats = cv2.GaussianBlur(values, (0, 0), sigma, borderType=cv2.BORDER_CONSTANT).astype(np.float64)
    return blurred


def _measure_distances(mask: Mask, cell: float) -> Floats:
    """The distance of each cell to the nearest one of a mask, m."""
    if not mask.any():
        return np.full(mask.shape, FARTHEST)
    return np.asarray(np.minimum(distance_transform_edt(~mask) * cell, FARTHEST))
