"""Graph Hopper kernel of graphs whose nodes have vectors, such as the features of rooms (Feragen et al., 2013)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import isfinite
from numbers import Real
from typing import Literal, Self

import networkx as nx
import numpy as np
from scipy.spatial.distance import cdist
from sklearn.base import BaseEstimator, TransformerMixin
from sklearn.utils.validation import check_is_fitted

from pianta._types import Floats
from pianta.errors import GraphError, OptionError
from pianta.graphs.feature_counts import divide
from pianta.graphs.graph_hopper import count_hops
from pianta.graphs.labelled_graphs import LabelledGraph, name_some, read_labelled_graphs
from pianta.graphs.stable_hash import Codes
from pianta.io._faults import join_faults

# Eigenvalues of a Gram matrix below this share of the largest are rounding errors.
MIN_EIGENVALUE = 1e-12


class GaussianGraphHopper(TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """Graph Hopper (graph_hopper.py) with the node kernel exp(-gamma |x - x'|²) of two nodes' vectors x.

    It has no explicit features, so all pairs of graphs are compared; `transform` maps onto the space that the fitted
    graphs span. The kernel of a graph without nodes is 0, even with itself.

    attribute: the node attribute with d numbers. label: a node attribute that must be equal besides, or None.
    gamma: "scale" for 1 / (d · variance of all fitted numbers), as in scikit-learn.
    standardize: subtract the means and divide by the standard deviations of the fitted nodes.
    normalize: divide by the length of both graphs.

    gamma_: the value of gamma. means_, scales_: by which vectors are standardised, shape (d,).
    """

    def __init__(
        self,
        *,
        attribute: str = "features",
        label: str | None = None,
        gamma: float | Literal["scale"] = "scale",
        standardize: bool = True,
        normalize: bool = True,
    ) -> None:
        self.attribute = attribute
        self.label = label
        self.gamma = gamma
        self.standardize = standardize
        self.normalize = normalize

    def fit(self, graphs: Iterable[nx.Graph], y: object = None) -> Self:  # noqa: ARG002
        """Learn the scale of the vectors, and store the graphs for `compare`.

        Raises GraphError for anything but simple undirected graphs, nodes without d finite numbers, and no nodes at
        all; OptionError for gamma.
        """
        _check_gamma(self.gamma)
        read = read_labelled_graphs(graphs, node_label=self.label)
        vectors = _read_vectors(read, self.attribute)
        if not any(map(len, vectors)):
            raise GraphError("graphs have no nodes to learn from, give some that have")
        together = np.concatenate(vectors)
        self.means_, self.scales_ = np.zeros(together.shape[1]), np.ones(together.shape[1])
        if self.standardize:
            self.means_, deviations = together.mean(axis=0), together.std(axis=0)
            # Equal numbers may have a tiny deviation by rounding.
            self.scales_ = np.where((np.ptp(together, axis=0) > 0) & (deviations > 0), deviations, 1.0)
        variance = float(self._scale(together).var())
        self.gamma_ = 1 / (together.shape[1] * (variance or 1)) if self.gamma == "scale" else float(self.gamma)
        self.fitted_ = [_order(graph, self._scale(each)) for graph, each in zip(read, vectors, strict=True)]
        self._gram = self._compare_fitted()
        return self

    def compare(self, graphs: Iterable[nx.Graph] | None = None) -> Floats:
        """Gram matrix, shape (graphs, fitted graphs); None: the fitted graphs with each other.

        If normalised, isomorphic graphs have exactly 1. Raises GraphError as `fit`, but accepts graphs without nodes.
        """
        check_is_fitted(self)
        gram, squares = self._gram, np.diag(self._gram)
        if graphs is not None:
            others = self._read(graphs)
            rows = [[_compare_two(one, other, self.gamma_) for other in self.fitted_] for one in others]
            gram = np.array(rows).reshape(len(others), len(self.fitted_))
            squares = np.array([_compare_two(graph, graph, self.gamma_) for graph in others])
        if not self.normalize:
            return gram.copy()
        # The root of a product instead of a product of roots: exact for equal numbers.
        return divide(gram, np.sqrt(np.outer(squares, np.diag(self._gram))))

    def transform(self, graphs: Iterable[nx.Graph]) -> Floats:
        """Vectors, shape (graphs, fitted graphs), whose inner products with those of fitted graphs are the kernel.

        K(graphs, fitted) K(fitted)^-½, so among new graphs the inner products are the kernel within the span of the
        fitted graphs. If fitted graphs are nearly equal, six digits are correct.
        """
        return self._project(self.compare(graphs))

    def fit_transform(self, graphs: Iterable[nx.Graph], y: object = None) -> Floats:  # noqa: ARG002
        """As `fit` and then `transform`, but comparing the graphs once."""
        return self._project(self.fit(graphs).compare())

    def _project(self, gram: Floats) -> Floats:
        """The projection of a Gram matrix onto the span of the fitted graphs."""
        values, vectors = np.linalg.eigh(self.compare())
        is_nonzero = values > MIN_EIGENVALUE * values[-1]
        vectors = vectors[:, is_nonzero]
        return np.asarray(gram @ (vectors / np.sqrt(values[is_nonzero])) @ vectors.T)

    def _scale(self, vectors: Floats) -> Floats:
        return (vectors - self.means_) / self.scales_

    def _read(self, graphs: Iterable[nx.Graph]) -> list[_OrderedGraph]:
        read = read_labelled_graphs(graphs, node_label=self.label)
        vectors = _read_vectors(read, self.attribute, size=len(self.means_))
        return [_order(graph, self._scale(each)) for graph, each in zip(read, vectors, strict=True)]

    def _compare_fitted(self) -> Floats:
        gram = np.zeros((len(self.fitted_), len(self.fitted_)))
        for row, one in enumerate(self.fitted_):
            for column, other in enumerate(self.fitted_[: row + 1]):
                gram[row, column] = gram[column, row] = _compare_two(one, other, self.gamma_)
        return gram


@dataclass(frozen=True, eq=False)
class _OrderedGraph:
    """A graph of n nodes in a canonical order, so that sums are equal to the last bit.

    labels: shape (n,). vectors: shape (n, d).
    hops: M_v(l, i) for i ≤ l / 2, shape (n, k), by l and then i; the others are equal by symmetry.
    weights: the number of M_v(l, i) that each column represents, shape (k,).
    """

    labels: Codes
    vectors: Floats
    hops: Floats
    weights: Floats


def _order(graph: LabelledGraph, vectors: Floats) -> _OrderedGraph:
    """A graph with its nodes in canonical order, and their hop counts; vectors: of the nodes, shape (n, d)."""
    cube = count_hops(graph, np.arange(len(graph)))
    further, positions = np.meshgrid(*map(np.arange, cube.shape[:2]), indexing="ij")
    half = np.flatnonzero((positions <= further) & (positions + further < len(cube)))
    half = half[np.lexsort((positions.flat[half], (positions + further).flat[half]))]
    hops = cube.reshape(len(cube) ** 2, len(graph))[half].T
    order = np.lexsort((*hops.T, *vectors.T, graph.labels))
    weights = np.where(positions.flat[half] == further.flat[half], 1.0, 2.0)
    return _OrderedGraph(graph.labels[order], vectors[order], np.ascontiguousarray(hops[order]), weights)


def _compare_two(one: _OrderedGraph, other: _OrderedGraph, gamma: float) -> float:
    """Σ_v Σ_v' k(v, v') <M_v, M_v'>, over the lengths of paths that both graphs have."""
    if not len(one.labels) or not len(other.labels):
        return 0.0
    shared = min(len(one.weights), len(other.weights))
    # Sums of products of integers are exact in any order.
    paths = (one.hops[:, :shared] * one.weights[:shared]) @ other.hops[:, :shared].T
    similarity = np.exp(-gamma * cdist(one.vectors, other.vectors, "sqeuclidean"))
    return float((paths * similarity * (one.labels[:, None] == other.labels)).sum())


def _read_vectors(graphs: Sequence[LabelledGraph], attribute: str, *, size: int | None = None) -> list[Floats]:
    """Vectors of nodes by graph, shape (n, d) each; d is that of the first node, or `size`."""
    vectors = [[_to_vector(value) for _, value in graph.graph.nodes(data=attribute)] for graph in graphs]
    if size is None:
        size = next((len(vector) for each in vectors for vector in each if len(vector)), 0)
    faults = []
    for number, (graph, each) in enumerate(zip(graphs, vectors, strict=True)):
        bad = [node for node, vector in zip(graph.graph, each, strict=True) if not len(vector) or len(vector) != size]
        if bad:
            what = f"{size} finite numbers" if size else "finite numbers"
            faults.append(f"nodes {name_some(bad)} of graph {number} have no {attribute!r} of {what}, set it")
    if faults:
        raise GraphError(join_faults(faults))
    return [np.array(each, np.float64).reshape(len(each), size) for each in vectors]


def _to_vector(value: object) -> Floats:
    """The numbers, shape (d,); empty unless all are finite."""
    try:
        vector = np.atleast_1d(np.asarray(value, np.float64))
    except (TypeError, ValueError):
        return np.zeros(0)
    return vector if vector.ndim == 1 and np.isfinite(vector).all() else np.zeros(0)


def _check_gamma(gamma: object) -> None:
    if gamma == "scale" or (isinstance(gamma, Real) and isfinite(gamma) and float(gamma) > 0):
        return
    raise OptionError(f'gamma is {gamma!r}, give "scale" or a number above 0')
