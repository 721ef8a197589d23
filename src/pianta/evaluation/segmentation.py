"""Coverage of reconstructed rooms by true rooms and back (thesis, section 3.2), for label images."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pianta.errors import FloorError
from pianta.evaluation.coverage import Scores, score_overlaps

# m²; a smaller area is a sliver beside a line, not a room. Chosen by hand.
MIN_ROOM_AREA = 0.25


def score_labels(
    labels: NDArray[np.integer], truth: NDArray[np.integer], *, counted: NDArray[np.bool_] | None = None
) -> Scores:
    """Scores of a label image against the true one; the area of a room is the number of its counted pixels.

    labels, truth: shape (H, W); n > 0 is the room with id n, other values are no room. Ids need not agree.
    counted: shape (H, W), the pixels that count, such as `GridMap.free`; None for all pixels, with walls.

    A counted pixel of a room outside all true rooms lowers forward accuracy and precision; one of a true room outside
    all rooms lowers backward accuracy and recall. A room without a counted pixel is ignored. Every share is 0 if only
    one of the images has rooms, and 1 if neither has. Raises FloorError if the shapes differ.
    """
    labels, truth = np.asarray(labels), np.asarray(truth)
    counted = np.ones(labels.shape, bool) if counted is None else np.asarray(counted, bool)
    if not labels.shape == truth.shape == counted.shape:
        shapes = f"labels {labels.shape}, truth {truth.shape} and counted {counted.shape}"
        raise FloorError(f"images of different shapes cannot be compared: {shapes}, give three of one shape")
    pixels = _count_pixels(labels[counted], truth[counted])
    return score_overlaps(pixels[1:, 1:], pixels[1:].sum(axis=1), pixels[:, 1:].sum(axis=0))


def drop_small_rooms(labels: NDArray[np.integer], *, resolution: float) -> NDArray[np.int32]:
    """The label image, shape (H, W), without the rooms of up to MIN_ROOM_AREA; their pixels become 0.

    resolution: metres per pixel.
    """
    labels = np.maximum(labels, 0)
    is_room = np.bincount(labels.ravel(), minlength=1) * resolution**2 > MIN_ROOM_AREA
    is_room[0] = False
    ids = np.where(is_room, np.arange(len(is_room)), 0).astype(np.int32)
    return np.asarray(ids[labels])


def label_rest(labels: NDArray[np.integer], *, counted: NDArray[np.bool_]) -> NDArray[np.int32]:
    """The label image, shape (H, W), with the counted pixels outside all rooms as one more room.

    counted: shape (H, W), such as the free cells. The rows of Table 3.1b were counted like this: the authors treat the
    pixels that a method leaves unlabelled as a segment.
    """
    labels = np.maximum(labels, 0).astype(np.int32)
    return np.where(counted & (labels == 0), labels.max(initial=0) + 1, labels)


def keep_rooms_at(labels: NDArray[np.integer], truth: NDArray[np.integer]) -> NDArray[np.int32]:
    """The label image, shape (H, W), without the rooms that an incomplete truth does not cover.

    truth: shape (H, W), true rooms; 0 where the truth is unknown. The result has the rooms with more than half of
    their pixels in true rooms, and for each true room the one that covers most of it.
    """
    pixels = _count_pixels(np.ravel(labels), np.ravel(truth))
    inside = pixels[:, 1:]
    keeps = inside.sum(axis=1) > pixels[:, 0]
    if inside[1:].size:
        keeps[1 + inside[1:].argmax(axis=0)[inside[1:].any(axis=0)]] = True
    keeps[0] = False
    rooms, _ = _number_labels(np.ravel(labels))
    return np.where(keeps[rooms].reshape(np.shape(labels)), labels, 0).astype(np.int32)


def match_rooms(labels: NDArray[np.integer], truth: NDArray[np.integer]) -> dict[int, int]:
    """The id of the true room with IoU above 0.5, by the id of the room; no room has two such partners.

    labels, truth: shape (H, W).
    """
    pixels = _count_pixels(np.ravel(labels), np.ravel(truth))
    union = pixels.sum(axis=1, keepdims=True) + pixels.sum(axis=0) - pixels
    rows, cols = np.nonzero(pixels[1:, 1:] > union[1:, 1:] / 2)
    ids, true = (np.unique(image[image > 0]) for image in (np.asarray(labels), np.asarray(truth)))
    return {int(ids[row]): int(true[col]) for row, col in zip(rows, cols, strict=True)}


def _count_pixels(labels: NDArray[np.integer], truth: NDArray[np.integer]) -> NDArray[np.float64]:
    """Confusion matrix of two lists of labels, shape (1 + rooms, 1 + true rooms); row and column 0 are no room."""
    row, rows = _number_labels(labels)
    col, cols = _number_labels(truth)
    return np.bincount(row * cols + col, minlength=rows * cols).reshape(rows, cols).astype(float)


def _number_labels(labels: NDArray[np.integer]) -> tuple[NDArray[np.intp], int]:
    """Labels as 0 for no room and 1 … N for the N rooms in the image; and 1 + N."""
    labels = np.maximum(labels, 0)
    occurs = np.bincount(labels, minlength=1) > 0
    occurs[0] = True
    return (np.cumsum(occurs) - 1)[labels], int(occurs.sum())
