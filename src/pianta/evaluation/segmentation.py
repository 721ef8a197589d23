"""Coverage of found rooms by true rooms and back (thesis, section 3.2), for label images."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pianta.errors import FloorError
from pianta.evaluation.coverage import Scores, score_overlaps


def score_labels(
    labels: NDArray[np.integer], truth: NDArray[np.integer], *, counted: NDArray[np.bool_] | None = None
) -> Scores:
    """Scores of a label image against the true one; the area of a room is the number of its counted pixels.

    labels, truth: shape (H, W); n > 0 is the room with id n, anything else is no room. Ids need not agree.
    counted: shape (H, W), the pixels that count, such as `GridMap.free`; all pixels when None, walls too.

    A counted pixel of a found room that is in no true room counts against forward accuracy and precision, and one of
    a true room that is in no found room against backward accuracy and recall. A room without a counted pixel does
    not exist. Where one of the images has no rooms every share is 0; where neither has, every share is 1.
    Raises FloorError when the shapes differ.
    """
    labels, truth = np.asarray(labels), np.asarray(truth)
    counted = np.ones(labels.shape, bool) if counted is None else np.asarray(counted, bool)
    if not labels.shape == truth.shape == counted.shape:
        shapes = f"labels {labels.shape}, truth {truth.shape} and counted {counted.shape}"
        raise FloorError(f"images of different shapes cannot be compared: {shapes}, give three of one shape")
    pixels = _count_pixels(labels[counted], truth[counted])
    return score_overlaps(pixels[1:, 1:], pixels[1:].sum(axis=1), pixels[:, 1:].sum(axis=0))


def _count_pixels(labels: NDArray[np.integer], truth: NDArray[np.integer]) -> NDArray[np.float64]:
    """Confusion matrix, shape (1 + rooms, 1 + true rooms), of two lists of labels; row and column 0 are no room."""
    row, rows = _number_labels(labels)
    col, cols = _number_labels(truth)
    return np.bincount(row * cols + col, minlength=rows * cols).reshape(rows, cols).astype(float)


def _number_labels(labels: NDArray[np.integer]) -> tuple[NDArray[np.intp], int]:
    """Labels as 0 for no room and 1 … N for the N rooms that occur; and 1 + N."""
    labels = np.maximum(labels, 0)
    occurs = np.bincount(labels, minlength=1) > 0
    occurs[0] = True
    return (np.cumsum(occurs) - 1)[labels], int(occurs.sum())
