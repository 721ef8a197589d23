"""Labels of found rooms against those of true rooms (thesis, section 5.3), and how far probabilities can be trusted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon

from pianta.evaluation.coverage import backward_coverage, forward_coverage

BINS = 10


@dataclass(frozen=True)
class LabelPair:
    """The label that a room was given and the true one; None where no room overlaps it."""

    given: str | None
    true: str | None

    @property
    def agree(self) -> bool:
        """1_EQ of section 5.3; a label never agrees with a room that is missing."""
        return self.given is not None and self.given == self.true


@dataclass(frozen=True)
class Reliability:
    """How often a label is right that has a certain probability; shapes (bins,).

    edges: of the bins of equal width, shape (bins + 1,). counts: rooms in each.
    confidence: mean probability of their labels. accuracy: share of the right ones. Both are NaN in empty bins.
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
    """For each found room its label and that of FC(r), the true room that overlaps it most (eq. 5.1).

    Rooms are in any one plane frame. Raises ValueError when a side has not one label for each room.
    """
    true_of = _labels_of(forward_coverage(rooms, truth), true_labels, rooms=truth)
    return [LabelPair(given, true) for given, true in zip(labels, true_of, strict=True)]


def pair_backward(
    rooms: Sequence[Polygon], labels: Sequence[str], truth: Sequence[Polygon], true_labels: Sequence[str]
) -> list[LabelPair]:
    """For each true room the label of BC(r'), the found room that overlaps it most, and its own (eq. 5.2).

    Rooms are in any one plane frame. Raises ValueError when a side has not one label for each room.
    """
    given_of = _labels_of(backward_coverage(rooms, truth), labels, rooms=rooms)
    return [LabelPair(given, true) for given, true in zip(given_of, true_labels, strict=True)]


def semantic_accuracy(pairs: Sequence[LabelPair]) -> float:
    """Share of the pairs that agree, 1 of none: SemanticAccuracy of section 5.3."""
    return sum(pair.agree for pair in pairs) / len(pairs) if pairs else 1.0


def count_confusion(pairs: Sequence[LabelPair], labels: Sequence[str]) -> NDArray[np.float64]:
    """Confusion matrix in %, shape (labels, labels + 1): of the rooms with a true label, the share given each label.

    The last column is rooms that were given none because nothing overlaps them. A row is NaN where no room has the
    true label; found rooms that overlap no true room are in none.
    Raises ValueError for a label that is not among the labels.
    """
    order = [*labels, None]
    counts = np.zeros((len(labels), len(order)))
    for pair in pairs:
        if pair.true is not None:
            counts[order.index(pair.true), order.index(pair.given)] += 1
    rooms = counts.sum(axis=1, keepdims=True)
    shares = np.divide(100 * counts, rooms, out=np.full(counts.shape, np.nan), where=rooms > 0)
    return np.asarray(shares)


def measure_reliability(
    probabilities: NDArray[np.float64], truth: NDArray[np.integer], *, bins: int = BINS
) -> Reliability:
    """Reliability of the most probable label of each room (Guo et al., On Calibration of Modern Neural Networks, 2017).

    probabilities: shape (rooms, labels). truth: the column of the true label, shape (rooms,).
    bins: of equal width from 0 to 1; what lies on an edge belongs to the bin below it.
    """
    edges = np.linspace(0, 1, bins + 1)
    confidence = probabilities.max(axis=1, initial=0.0)
    right = probabilities.argmax(axis=1) == truth if len(truth) else np.zeros(0, bool)
    bin_of = np.clip(np.searchsorted(edges, confidence, side="left") - 1, 0, bins - 1)
    counts = np.bincount(bin_of, minlength=bins)
    sums = (np.bincount(bin_of, weights=values, minlength=bins) for values in (confidence, right))
    means = (np.divide(total, counts, out=np.full(bins, np.nan), where=counts > 0) for total in sums)
    return Reliability(edges, counts, *means)


def _labels_of(chosen: Sequence[int | None], labels: Sequence[str], *, rooms: Sequence[Polygon]) -> list[str | None]:
    """The labels of chosen rooms."""
    if len(labels) != len(rooms):
        raise ValueError(f"{len(rooms)} rooms have {len(labels)} labels, give one each")
    return [None if index is None else labels[index] for index in chosen]
