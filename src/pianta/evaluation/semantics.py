"""Labels of reconstructed rooms against those of true rooms (thesis, section 5.3), and calibration of probabilities."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon

from pianta.evaluation.coverage import backward_coverage, forward_coverage

# Bins of equal width for calibration.
BINS = 10


@dataclass(frozen=True)
class LabelPair:
    """The predicted label of a room and the true one; None if no room overlaps it."""

    predicted: str | None
    true: str | None

    @property
    def agree(self) -> bool:
        """1_EQ of section 5.3; a label never agrees with a missing room."""
        return self.predicted is not None and self.predicted == self.true


@dataclass(frozen=True)
class Reliability:
    """Accuracy of labels by their probability, in bins of equal width.

    edges: of the bins, shape (bins + 1,). counts: of rooms in each, shape (bins,). confidence: mean probability of
    their labels. accuracy: share of correct ones. Both are NaN in empty bins, shape (bins,).
    """

    edges: NDArray[np.float64]
    counts: NDArray[np.intp]
    confidence: NDArray[np.float64]
    accuracy: NDArray[np.float64]

    @property
    def error(self) -> float:
        """Expected calibration error, 0 … 1: mean distance of both, weighted by rooms; NaN without rooms."""
        if not self.counts.sum():
            return float("nan")
        return float(np.nansum(np.abs(self.confidence - self.accuracy) * self.counts) / self.counts.sum())


def pair_forward(
    rooms: Sequence[Polygon], labels: Sequence[str], truth: Sequence[Polygon], true_labels: Sequence[str]
) -> list[LabelPair]:
    """For each room its label and that of FC(r), the true room that overlaps it most (eq. 5.1).

    Rooms are in one planar frame. Raises ValueError unless each side has one label for each room.
    """
    true = _choose_labels(forward_coverage(rooms, truth), true_labels, rooms=truth)
    return [LabelPair(*pair) for pair in zip(labels, true, strict=True)]


def pair_backward(
    rooms: Sequence[Polygon], labels: Sequence[str], truth: Sequence[Polygon], true_labels: Sequence[str]
) -> list[LabelPair]:
    """For each true room the label of BC(r'), the room that overlaps it most, and its own (eq. 5.2).

    Rooms are in one planar frame. Raises ValueError unless each side has one label for each room.
    """
    predicted = _choose_labels(backward_coverage(rooms, truth), labels, rooms=rooms)
    return [LabelPair(*pair) for pair in zip(predicted, true_labels, strict=True)]


def semantic_accuracy(pairs: Sequence[LabelPair]) -> float:
    """SemanticAccuracy of section 5.3: the share of the pairs that agree, 1 without pairs."""
    return sum(pair.agree for pair in pairs) / len(pairs) if pairs else 1.0


def count_confusion(pairs: Sequence[LabelPair], labels: Sequence[str]) -> NDArray[np.float64]:
    """Confusion matrix in %, shape (labels, labels + 1): of rooms with a true label (row), the share with each label.

    The last column is for rooms that no reconstructed room overlaps. A row without rooms is NaN; reconstructed rooms
    that overlap no true room are not counted. Raises ValueError for a label that is not in `labels`.
    """
    order = [*labels, None]
    counts = np.zeros((len(labels), len(order)))
    for pair in pairs:
        if pair.true is not None:
            counts[order.index(pair.true), order.index(pair.predicted)] += 1
    rooms = counts.sum(axis=1, keepdims=True)
    shares = np.divide(100 * counts, rooms, out=np.full(counts.shape, np.nan), where=rooms > 0)
    return np.asarray(shares)


def measure_reliability(
    probabilities: NDArray[np.float64], truth: NDArray[np.integer], *, bins: int = BINS
) -> Reliability:
    """Reliability of the most probable label of each room (Guo et al., On Calibration of Modern Neural Networks, 2017).

    probabilities: shape (rooms, labels). truth: the column of the true label, shape (rooms,).
    bins: of equal width from 0 to 1; a value on an edge belongs to the bin below it.
    """
    is_correct = probabilities.argmax(axis=1) == truth if len(truth) else np.zeros(0, bool)
    return bin_reliability(probabilities.max(axis=1, initial=0.0), is_correct, bins=bins)


def bin_reliability(confidence: NDArray[np.float64], is_correct: NDArray[np.bool_], *, bins: int) -> Reliability:
    """Reliability of labels with some probabilities, shape (n,) each."""
    edges = np.linspace(0, 1, bins + 1)
    indices = np.clip(np.searchsorted(edges, confidence, side="left") - 1, 0, bins - 1)
    counts = np.bincount(indices, minlength=bins)
    sums = (np.bincount(indices, weights=values, minlength=bins) for values in (confidence, is_correct))
    means = (np.divide(total, counts, out=np.full(bins, np.nan), where=counts > 0) for total in sums)
    return Reliability(edges, counts, *means)


def _choose_labels(
    chosen: Sequence[int | None], labels: Sequence[str], *, rooms: Sequence[Polygon]
) -> list[str | None]:
    """The labels of the chosen rooms."""
    if len(labels) != len(rooms):
        raise ValueError(f"{len(rooms)} rooms have {len(labels)} labels, give one each")
    return [None if index is None else labels[index] for index in chosen]
