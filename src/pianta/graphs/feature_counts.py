"""Features of graphs and how often they occur: counted, gathered, and compared with those of other graphs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pianta._types import Floats, Indices
from pianta.graphs.stable_hash import Codes


@dataclass(frozen=True, eq=False)
class FeatureCounts:
    """How often graphs, or whatever n rows stand for, have features, as triples of shape (m,) each.

    rows: which graph, 0 … n - 1. codes: which feature; where a feature occurs again, the counts add up.
    """

    n: int
    rows: Indices
    codes: Codes
    counts: Floats


def gather_counts(
    n: int, rows: Sequence[Indices], codes: Sequence[Codes], counts: Sequence[Floats] | None = None
) -> FeatureCounts:
    """The counts of n rows from those of parts; each feature counts once where no counts are given."""
    all_rows = np.concatenate([np.zeros(0, np.intp), *rows])
    all_codes = np.concatenate([np.zeros(0, np.uint64), *codes])
    all_counts: Floats = np.ones(len(all_rows)) if counts is None else np.concatenate([np.zeros(0), *counts])
    return FeatureCounts(n, all_rows, all_codes, all_counts)


def merge_counts(counts: FeatureCounts) -> FeatureCounts:
    """The same counts with each feature of a row once, by code and then by row."""
    order = np.lexsort((counts.rows, counts.codes))
    rows, codes = counts.rows[order], counts.codes[order]
    new = np.ones(len(order), bool)
    new[1:] = (rows[1:] != rows[:-1]) | (codes[1:] != codes[:-1])
    sums: Floats = np.bincount(np.cumsum(new) - 1, counts.counts[order], minlength=int(new.sum())).astype(np.float64)
    return FeatureCounts(counts.n, rows[new], codes[new], sums)


def compare_counts(counts: Sequence[FeatureCounts], known: Sequence[FeatureCounts]) -> Floats:
    """Normalised Gram matrix of rows and known rows; all blocks count the same.

    To the bit what an ExplicitKernel says that was fitted to the known counts, as long as counts are whole numbers.

    Parameters
    ----------
    counts, known : sequences of FeatureCounts
        Merged counts, by block.

    Returns
    -------
    Floats, shape (rows, known rows)
        0 for a row without any feature.

    """
    cosines = []
    for one, other in zip(counts, known, strict=True):
        lengths = np.sqrt(np.outer(_square(one), _square(other)))
        cosines.append(divide(_multiply(one, other), lengths))
    filled, known_filled = (
        np.sum([_square(block) > 0 for block in blocks], axis=0, dtype=np.float64) for blocks in (counts, known)
    )
    return divide(np.sum(cosines, axis=0), np.sqrt(np.outer(filled, known_filled)))


def divide(values: Floats | float, by: Floats) -> Floats:
    """Values / by, 0 where `by` is 0."""
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
