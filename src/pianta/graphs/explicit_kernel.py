"""Graph kernels that count features of graphs, as transformers of scikit-learn.

The kernel of two graphs is the inner product of their counts, so the features of each graph are counted only once.
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

    Graphs are simple undirected networkx graphs with a label at each node and any number of components. A graph without
    nodes has no features, so its kernel is 0, even with itself.

    vocabularies_: by block of the kernel, the sorted codes of the features in the fitted graphs.
    fitted_: by block, the features of the fitted graphs.
    """

    normalize: bool

    @abstractmethod
    def count_features(self, graphs: Iterable[nx.Graph]) -> list[FeatureCounts]:
        """Features of any graphs, by the blocks of which the kernel is the sum; needs no `fit`.

        Raises GraphError that lists nodes without a label and objects that are not simple undirected graphs, and
        OptionError.
        """

    def fit(self, graphs: Iterable[nx.Graph], y: object = None) -> Self:  # noqa: ARG002
        """Learn the vocabulary, and store the features of the graphs for `compare`."""
        return self.fit_counts(self.count_features(graphs))

    def transform(self, graphs: Iterable[nx.Graph]) -> csr_array:
        """Features, shape (graphs, features), whose inner products are the kernel, without features new since `fit`."""
        check_is_fitted(self)
        return self.transform_counts(self.count_features(graphs))

    def fit_transform(self, graphs: Iterable[nx.Graph], y: object = None) -> csr_array:  # noqa: ARG002
        """As `fit` and then `transform`, but counting the features once."""
        counts = self.count_features(graphs)
        return self.fit_counts(counts).transform_counts(counts)

    def compare(self, graphs: Iterable[nx.Graph] | None = None) -> Floats:
        """Gram matrix, shape (graphs, fitted graphs); None: the fitted graphs with each other.

        If normalised, all blocks have equal weight, and graphs with equal features have exactly 1.
        """
        check_is_fitted(self)
        return self.compare_counts(None if graphs is None else self.count_features(graphs))

    def fit_counts(self, counts: Sequence[FeatureCounts]) -> Self:
        """As `fit`, from the result of `count_features`."""
        self.vocabularies_ = [np.unique(block.codes) for block in counts]
        self.fitted_ = self._tabulate(counts)
        return self

    def transform_counts(self, counts: Sequence[FeatureCounts]) -> csr_array:
        """As `transform`, from the result of `count_features`."""
        check_is_fitted(self)
        blocks = self._tabulate(counts)
        tables = [block.counts for block in blocks]
        if self.normalize:
            nonempty = _count_nonempty(blocks)
            scales = [divide(1.0, np.sqrt(nonempty * block.squares)) for block in blocks]
            tables = [table.multiply(scale[:, None]) for table, scale in zip(tables, scales, strict=True)]
        table = csr_array(hstack(tables))
        # Support vector machines of scikit-learn need 32-bit indices.
        parts = table.data, table.indices.astype(np.int32), table.indptr.astype(np.int32)
        return csr_array(parts, shape=table.shape)

    def compare_counts(self, counts: Sequence[FeatureCounts] | None = None) -> Floats:
        """As `compare`, from the result of `count_features`."""
        check_is_fitted(self)
        blocks = self.fitted_ if counts is None else self._tabulate(counts)
        pairs = list(zip(blocks, self.fitted_, strict=True))
        grams = [(one.counts @ other.counts.T).toarray() for one, other in pairs]
        if not self.normalize:
            return np.asarray(np.sum(grams, axis=0))
        # The root of a product instead of a product of roots: exact for equal numbers.
        lengths = [np.sqrt(np.outer(one.squares, other.squares)) for one, other in pairs]
        gram = np.sum([divide(gram, length) for gram, length in zip(grams, lengths, strict=True)], axis=0)
        return divide(gram, np.sqrt(np.outer(_count_nonempty(blocks), _count_nonempty(self.fitted_))))

    def _tabulate(self, counts: Sequence[FeatureCounts]) -> list[_Block]:
        return [_tabulate(block, vocabulary) for block, vocabulary in zip(counts, self.vocabularies_, strict=True)]


def check_numbers(**numbers: object) -> None:
    """Raise OptionError that lists the values that are not integers of 0 or more."""
    faults = [
        f"{name} is {number!r}"
        for name, number in numbers.items()
        if isinstance(number, bool) or not isinstance(number, Integral) or number < 0
    ]
    if faults:
        raise OptionError("; ".join(faults) + ", give whole numbers of 0 or more")


@dataclass(frozen=True, eq=False)
class _Block:
    """counts: of the vocabulary, shape (n, features). squares: sums of squared counts of all features, shape (n,)."""

    counts: csr_array
    squares: Floats


def _tabulate(block: FeatureCounts, vocabulary: Codes) -> _Block:
    """Counts in columns of the vocabulary, sorted codes; other features count only in the sums of squares."""
    codes, columns = np.unique(block.codes, return_inverse=True)
    table = csr_array((block.counts, (block.rows, columns)), shape=(block.n, len(codes)))
    is_listed = np.isin(codes, vocabulary)
    indices = np.searchsorted(vocabulary, codes[is_listed])
    entries = table[:, is_listed].tocoo()
    counts = csr_array((entries.data, (entries.row, indices[entries.col])), shape=(block.n, len(vocabulary)))
    # The sum of squares in the order of a product of tables, so that it equals the Gram matrix to the last bit.
    diagonal = csr_array((table.data, np.arange(table.nnz), table.indptr), shape=(block.n, table.nnz))
    return _Block(counts, np.asarray((diagonal @ diagonal.T).diagonal()))


def _count_nonempty(blocks: Sequence[_Block]) -> Floats:
    """The number of blocks in which each row has features, shape (n,)."""
    return np.asarray(np.sum([block.squares > 0 for block in blocks], axis=0, dtype=np.float64))
