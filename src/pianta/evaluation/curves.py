"""ROC and precision-recall curves of a binary classifier, and the areas below them (thesis, section 6.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.errors import OptionError


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve with a point for each threshold of the scores, from 0 to 1 on both axes, and the area below it.

    x, y: shape (n,), x ascending. area: 1 for a perfect classifier. chance: expected area for random scores.
    """

    x: Floats
    y: Floats
    area: float
    chance: float


def measure_roc(truth: Sequence[bool], scores: Sequence[float]) -> Curve:
    """False positive rate (x) and true positive rate (y), with straight lines between the points.

    truth: whether each item is positive. scores: higher for predicted positives.
    Raises OptionError unless there are positive and negative items, one score each, all finite.
    """
    from sklearn.metrics import auc, roc_curve

    positive, values = _check(truth, scores)
    x, y, _ = roc_curve(positive, values, drop_intermediate=False)
    return Curve(x, y, float(auc(x, y)), 0.5)


def measure_precision_recall(truth: Sequence[bool], scores: Sequence[float]) -> Curve:
    """Recall (x) and precision (y), as steps, each as high as the point at its right end.

    The area is that of the steps, the average precision: no threshold attains the points of a straight line between
    two others. Arguments and errors as of measure_roc.
    """
    from sklearn.metrics import average_precision_score, precision_recall_curve

    positive, values = _check(truth, scores)
    precision, recall, _ = precision_recall_curve(positive, values)
    return Curve(
        recall[::-1], precision[::-1], float(average_precision_score(positive, values)), float(positive.mean())
    )


def _check(truth: Sequence[bool], scores: Sequence[float]) -> tuple[NDArray[np.bool_], Floats]:
    """The arguments as arrays, shape (N,); OptionError for unequal lengths, scores not finite, or one class only."""
    positive, values = np.asarray(truth, bool), np.asarray(scores, float)
    if positive.shape != values.shape or positive.ndim != 1:
        raise OptionError(f"{len(values)} scores are given for {len(positive)} items, give one each")
    if positive.all() or not positive.any():
        raise OptionError(f"{positive.sum()} of {len(positive)} items are positive, give some that are and some not")
    if not np.isfinite(values).all():
        raise OptionError("scores are not all finite, give numbers")
    return positive, values
