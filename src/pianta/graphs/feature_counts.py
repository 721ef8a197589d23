"""Counts of features of graphs: gathered, merged, and compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices
from pianta.graphs.stable_hash import Codes


@dataclass(frozen=True, eq=False)
class FeatureCounts:
    """Counts of features of n graphs, or of other rows, as triples of shape (m,) each.

    rows: index of the graph, 0 … n - 1. codes: of the features; the counts of repeated triples add up.
    """

    n: int
    rows: Indices
    codes: Codes
    counts: Floats


def gather_counts(
    n: int, rows: Sequence[Indices], codes: Sequence[Codes], counts: Sequence[Floats] | None = None
) -> FeatureCounts:
    """The counts of n rows from those of parts; counts: None for 1 each."""
    all_rows = np.concatenate([np.zeros(0, np.intp), *rows])
    all_codes = np.concatenate([np.zeros(0, np.uint64), *codes])
    all_counts: Floats = np.ones(len(all_rows)) if counts is None else np.concatenate([np.zeros(0), *counts])
    return FeatureCounts(n, all_rows, all_codes, all_counts)


def merge_counts(counts: FeatureCounts) -> FeatureCounts:
    """The same counts with each feature of a row once, sorted by code and then by row."""
    order = np.lexsort((counts.rows, counts.codes))
    rows, codes = counts.rows[order], counts.codes[order]
    is_first = mark_changes(rows, codes)
    group = np.cumsum(is_first) - 1
    sums: Floats = np.bincount(group, counts.counts[order], minlength=int(is_first.sum())).astype(np.float64)
    return FeatureCounts(counts.n, rows[is_first], codes[is_first], sums)


def mark_changes(rows: Indices, codes: Codes) -> NDArray[np.bool_]:
    """Where a sorted sequence of pairs has the first of equal pairs, shape (m,)."""
    is_first = np.ones(len(rows), bool)
    is_first[1:] = (rows[1:] != rows[:-1]) | (codes[1:] != codes[:-1])
    return is_first


def compare_counts(counts: Sequence[FeatureCounts], fitted: Sequence[FeatureCounts]) -> Floats:
    """Normalised Gram matrix of rows and fitted rows, shape (rows, fitted rows); 0 for a row without features.

    All blocks have equal weight. For integer counts, exactly the result of an ExplicitKernel that was fitted to these.
    counts, fitted: merged counts, by block.
    """
    cosines = []
    for one, other in zip(counts, fitted, strict=True):
        lengths = np.sqrt(np.outer(_square(one), _square(other)))
        cosines.append(divide(_multiply(one, other), lengths))
    nonempty, fitted_nonempty = (
        np.sum([_square(block) > 0 for block in blocks], axis=0, dtype=np.float64) for blocks in (counts, fitted)
    )
    return divide(np.sum(cosines, axis=0), np.sqrt(np.outer(nonempty, fitted_nonempty)))


def divide(values: Floats | float, by: Floats) -> Floats:
    """Values / by, but 0 if `by` is 0."""
    quotients: Floats = np.divide(values, by, out=np.zeros_like(by), where=by > 0)
    return quotients


def _multiply(one: FeatureCounts, other: FeatureCounts) -> Floats:
    """Inner products of the rows of merged counts, shape (rows, other rows)."""
    by_row = np.argsort(one.rows, kind="stable")
    bounds = np.searchsorted(one.rows[by_row], np.arange(one.n + 1)).tolist()
    products = np.zeros((one.n, other.n))
    for row, (start, end) in enumerate(pairwise(bounds)):
        own = by_row[start:end]
        first, last = (np.searchsorted(other.codes, one.codes[own], side) for side in ("left", "right"))
        times = last - first
        shared = np.repeat(first - (np.cumsum(times) - times), times) + np.arange(times.sum())
        weights = np.repeat(one.counts[own], times) * other.counts[shared]
        products[row] = np.bincount(other.rows[shared], weights, minlength=other.n)
    return products


def _square(counts: FeatureCounts) -> Floats:
    """Sums of the squared counts of rows, shape (n,)."""
    return np.asarray(np.bincount(counts.rows, counts.counts**2, minlength=counts.n), np.float64)
