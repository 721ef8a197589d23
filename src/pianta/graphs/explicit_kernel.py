"""ExplicitKernel: a graph kernel that counts features of graphs, as a transformer of scikit-learn.

The kernel of two graphs is the inner product of their counts, so a new graph is compared with others without looking
at these again.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from numbers import Integral
from typing import Self

import networkx as nx
import numpy as np
from scipy.sparse import csr_array, hstack
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.graphs.feature_counts import FeatureCounts, divide
from pianta.graphs.stable_hash import Codes


class ExplicitKernel(TransformerMixin, BaseEstimator, ABC):  # type: ignore[misc]
    """A graph kernel with an explicit sparse feature map: fit, then transform or compare.

    Graphs are simple undirected networkx graphs with a label at each node, of any number of parts. A graph without
    nodes has no features; it is unlike everything, itself included.

    vocabularies_: by block of the kernel, the codes of the features that `fit` saw, sorted.
    fitted_: by block, the features of the fitted graphs.
    """

    normalize: bool

    @abstractmethod
    def count_features(self, graphs: Iterable[nx.Graph]) -> list[FeatureCounts]:
        """Features of graphs, known or not, by the blocks that the kernel is the sum of; needs no `fit`.

        Raises GraphError that lists nodes without a label and what is no simple undirected graph, and OptionError.
        """

    def fit(self, graphs: Iterable[nx.Graph], y: object = None) -> Self:  # noqa: ARG002
        """Learn which features there are, and keep those of the graphs for `compare`."""
        return self.fit_counts(self.count_features(graphs))

    def transform(self, graphs: Iterable[nx.Graph]) -> csr_array:
        """Features, shape (graphs, features), whose inner products are the kernel, but for features new since `fit`."""
        check_is_fitted(self)
        return self.transform_counts(self.count_features(graphs))

    def fit_transform(self, graphs: Iterable[nx.Graph], y: object = None) -> csr_array:  # noqa: ARG002
        """As `fit` and then `transform`, looking at the graphs once."""
        counts = self.count_features(graphs)
        return self.fit_counts(counts).transform_counts(counts)

    def compare(self, graphs: Iterable[nx.Graph] | None = None) -> Floats:
        """Gram matrix, shape (graphs, fitted graphs); of the fitted graphs among themselves where none are given.

        Normalised, all blocks count the same, and graphs with the same features have exactly 1.
        """
        check_is_fitted(self)
        return self.compare_counts(None if graphs is None else self.count_features(graphs))

    def fit_counts(self, counts: Sequence[FeatureCounts]) -> Self:
        """As `fit`, with what `count_features` gave."""
        self.vocabularies_ = [np.unique(block.codes) for block in counts]
        self.fitted_ = self._tabulate(counts)
        return self

    def transform_counts(self, counts: Sequence[FeatureCounts]) -> csr_array:
        """As `transform`, with what `count_features` gave."""
        check_is_fitted(self)
        blocks = self._tabulate(counts)
        tables = [block.counts for block in blocks]
        if self.normalize:
            filled = _count_filled(blocks)
            scales = [divide(1.0, np.sqrt(filled * block.squares)) for block in blocks]
            tables = [table.multiply(scale[:, None]) for table, scale in zip(tables, scales, strict=True)]
        table = csr_array(hstack(tables))
        # Support vector machines of scikit-learn take no longer indices.
        parts = table.data, table.indices.astype(np.int32), table.indptr.astype(np.int32)
        return csr_array(parts, shape=table.shape)

    def compare_counts(self, counts: Sequence[FeatureCounts] | None = None) -> Floats:
        """As `compare`, with what `count_features` gave."""
        check_is_fitted(self)
        blocks = self.fitted_ if counts is None else self._tabulate(counts)
        pairs = list(zip(blocks, self.fitted_, strict=True))
        grams = [(one.counts @ other.counts.T).toarray() for one, other in pairs]
        if not self.normalize:
            return np.asarray(np.sum(grams, axis=0))
        # One square root of a product, not a product of two: of equal numbers it is exactly the number.
        lengths = [np.sqrt(np.outer(one.squares, other.squares)) for one, other in pairs]
        gram = np.sum([divide(gram, length) for gram, length in zip(grams, lengths, strict=True)], axis=0)
        return divide(gram, np.sqrt(np.outer(_count_filled(blocks), _count_filled(self.fitted_))))

    def _tabulate(self, counts: Sequence[FeatureCounts]) -> list[_Block]:
        return [_tabulate(block, vocabulary) for block, vocabulary in zip(counts, self.vocabularies_, strict=True)]


def check_numbers(**numbers: object) -> None:
    """Raise OptionError that lists what is no whole number of 0 or more."""
    faults = [
        f"{name} is {number!r}"
        for name, number in numbers.items()
        if isinstance(number, bool) or not isinstance(number, Integral) or number < 0
    ]
    if faults:
        raise OptionError("; ".join(faults) + ", give whole numbers of 0 or more")


@dataclass(frozen=True, eq=False)
class _Block:
    """counts: of known features, shape (n, features). squares: sums of the squared counts of all, shape (n,)."""

    counts: csr_array
    squares: Floats


def _tabulate(block: FeatureCounts, vocabulary: Codes) -> _Block:
    codes, columns = np.unique(block.codes, return_inverse=True)
    table = csr_array((block.counts, (block.rows, columns)), shape=(block.n, len(codes)))
    known = np.isin(codes, vocabulary)
    places = np.searchsorted(vocabulary, codes[known])
    entries = table[:, known].tocoo()
    counts = csr_array((entries.data, (entries.row, places[entries.col])), shape=(block.n, len(vocabulary)))
    # Each row times itself, added up in the order in which tables are multiplied: to the bit what its Gram matrix has.
    apart = csr_array((table.data, np.arange(table.nnz), table.indptr), shape=(block.n, table.nnz))
    return _Block(counts, np.asarray((apart @ apart.T).diagonal()))


def _count_filled(blocks: Sequence[_Block]) -> Floats:
    """The number of blocks in which a row has features, shape (n,)."""
    return np.asarray(np.sum([block.squares > 0 for block in blocks], axis=0, dtype=np.float64))
