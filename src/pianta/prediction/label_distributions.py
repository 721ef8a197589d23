"""Distributions of labels that are made of several others."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pianta._types import Floats

# Steps and rate of the exponentiated gradient descent of find_nearest_distribution; chosen by hand, it has converged.
GRADIENT_STEPS = 200
GRADIENT_RATE = 2.0
# Weight of the samples in the probabilities of labels behind a door; the remaining weight has what was behind similar
# doors. Chosen by training/choose_door_labels.py.
SAMPLES_WEIGHT = 0.5
# Smaller shares count as 0.
MIN_SHARE = 1e-9


def find_nearest_distribution(counts: Floats) -> Floats:
    """The distribution, shape (labels,), with the least mean Jensen-Shannon divergence from the rows of counts.

    counts: shape (n, labels), rows weighted by their sums, which are above 0. By exponentiated gradient descent.
    """
    weights = counts.sum(axis=1)
    rows = counts / weights[:, None]
    weights = weights / weights.sum()
    nearest: Floats = weights @ rows + MIN_SHARE
    nearest /= nearest.sum()
    for _ in range(GRADIENT_STEPS):
        gradient = weights @ np.log2(nearest / ((rows + nearest) / 2)) / 2
        nearest = np.maximum(nearest * np.exp(-GRADIENT_RATE * (gradient - nearest @ gradient)), MIN_SHARE)
        nearest /= nearest.sum()
    return nearest


def mix_labels(sampled: Mapping[str, float], similar: Mapping[str, float]) -> dict[str, float]:
    """The weighted mean of two distributions of labels, the most probable first; if one is empty, the other.

    Of equally probable labels the first of `sampled` is first.
    """
    if not sampled or not similar:
        return {**(sampled or dict(sorted(similar.items(), key=lambda item: -item[1])))}
    mixed = {
        label: SAMPLES_WEIGHT * sampled.get(label, 0.0) + (1 - SAMPLES_WEIGHT) * similar.get(label, 0.0)
        for label in (*sampled, *similar)
    }
    return dict(sorted(mixed.items(), key=lambda item: -item[1]))
