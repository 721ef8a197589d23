"""Graph Hopper kernel of graphs whose nodes have numbers, such as the features of rooms (Feragen et al., 2013)."""

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
from pianta.graphs.hops import count_hops
from pianta.graphs.labelled_graphs import LabelledGraph, name_some, read_labelled_graphs
from pianta.graphs.stable_hash import Codes
from pianta.io._faults import join_faults

# Eigenvalues of a Gram matrix below this share of the largest are rounding.
SMALLEST_EIGENVALUE = 1e-12


class GaussianGraphHopper(TransformerMixin, BaseEstimator):  # type: ignore[misc]
    """Graph Hopper (graph_hopper.py) with the node kernel exp(-gamma |x - x'|²) of two nodes' vectors x.

    It has no explicit features, so that each graph is compared with each; `transform` maps onto the space that the
    fitted graphs span. A graph without nodes is unlike everything, itself included.

    attribute: the node attribute with d numbers. label: a node attribute besides that has to be the same, if any.
    gamma: "scale" for 1 / (d · variance of all numbers that `fit` saw), as scikit-learn has it.
    standardize: subtract means and divide by standard deviations of the fitted nodes first.
    normalize: divide by the length of both graphs.

    gamma_: the gamma that is used. means_, scales_: what vectors are standardised with, shape (d,).
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
        """Learn the scale of the vectors, and keep the graphs for `compare`.

        Raises GraphError for what is no simple undirected graph, nodes without d finite numbers, and no nodes at all;
        OptionError for gamma.
        """
        _check_gamma(self.gamma)
        read = read_labelled_graphs(graphs, node_label=self.label)
        vectors = _read_vectors(read, self.attribute)
        if not any(map(len, vectors)):
            raise GraphError("graphs have no nodes to learn from, give some that have")
        together = np.concatenate(vectors)
        self.means_, self.scales_ = np.zeros(together.shape[1]), np.ones(together.shape[1])
        if self.standardize:
            self.means_, spreads = together.mean(axis=0), together.std(axis=0)
            # Rounding gives numbers that are all the same a spread.
            self.scales_ = np.where((np.ptp(together, axis=0) > 0) & (spreads > 0), spreads, 1.0)
        variance = float(self._scale(together).var())
        self.gamma_ = 1 / (together.shape[1] * (variance or 1)) if self.gamma == "scale" else float(self.gamma)
        self.fitted_ = [_order(graph, self._scale(of_graph)) for graph, of_graph in zip(read, vectors, strict=True)]
        self._gram = self._compare_fitted()
        return self

    def compare(self, graphs: Iterable[nx.Graph] | None = None) -> Floats:
        """Gram matrix, shape (graphs, fitted graphs); of the fitted graphs among themselves where none are given.

        Normalised, isomorphic graphs have exactly 1. Raises GraphError as `fit` does, but takes graphs without nodes.
        """
        check_is_fitted(self)
        gram, squares = self._gram, np.diag(self._gram)
        if graphs is not None:
            given = self._read(graphs)
            rows = [[_compare_two(one, other, self.gamma_) for other in self.fitted_] for one in given]
            gram = np.array(rows).reshape(len(given), len(self.fitted_))
            squares = np.array([_compare_two(graph, graph, self.gamma_) for graph in given])
        if not self.normalize:
            return gram.copy()
        # One square root of a product, not a product of two: of equal numbers it is exactly the number.
        lengths = np.sqrt(np.outer(squares, np.diag(self._gram)))
        return np.divide(gram, lengths, out=np.zeros_like(gram), where=lengths > 0)

    def transform(self, graphs: Iterable[nx.Graph]) -> Floats:
        """Vectors, shape (graphs, fitted graphs), whose inner products with those of fitted graphs are the kernel.

        Among new graphs they are the kernel as far as the fitted graphs span it: K(graphs, fitted) K(fitted)^-½. Where
        fitted graphs are nearly alike, six digits are right.
        """
        return self._project(self.compare(graphs))

    def fit_transform(self, graphs: Iterable[nx.Graph], y: object = None) -> Floats:  # noqa: ARG002
        """As `fit` and then `transform`, comparing the graphs once."""
        return self._project(self.fit(graphs).compare())

    def _project(self, gram: Floats) -> Floats:
        """The map of a Gram matrix onto what the fitted graphs span."""
        values, vectors = np.linalg.eigh(self.compare())
        kept = values > SMALLEST_EIGENVALUE * values[-1]
        vectors = vectors[:, kept]
        return np.asarray(gram @ (vectors / np.sqrt(values[kept])) @ vectors.T)

    def _scale(self, vectors: Floats) -> Floats:
        return (vectors - self.means_) / self.scales_

    def _read(self, graphs: Iterable[nx.Graph]) -> list[_OrderedGraph]:
        read = read_labelled_graphs(graphs, node_label=self.label)
        vectors = _read_vectors(read, self.attribute, size=len(self.means_))
        return [_order(graph, self._scale(of_graph)) for graph, of_graph in zip(read, vectors, strict=True)]

    def _compare_fitted(self) -> Floats:
        gram = np.zeros((len(self.fitted_), len(self.fitted_)))
        for row, one in enumerate(self.fitted_):
            for column, other in enumerate(self.fitted_[: row + 1]):
                gram[row, column] = gram[column, row] = _compare_two(one, other, self.gamma_)
        return gram


@dataclass(frozen=True, eq=False)
class _OrderedGraph:
    """A graph of n nodes in an order that does not depend on how it was given, so that sums are the same to the bit.

    labels: shape (n,). vectors: shape (n, d).
    hops: M_v(l, i) for i ≤ l / 2, shape (n, k), by l and then i; the others mirror these.
    weights: how many M_v(l, i) each column stands for, shape (k,).
    """

    labels: Codes
    vectors: Floats
    hops: Floats
    weights: Floats


def _order(graph: LabelledGraph, vectors: Floats) -> _OrderedGraph:
    cube = count_hops(graph, np.arange(len(graph)))
    further, places = np.meshgrid(*map(np.arange, cube.shape[:2]), indexing="ij")
    half = np.flatnonzero((places <= further) & (places + further < len(cube)))
    half = half[np.lexsort((places.flat[half], (places + further).flat[half]))]
    hops = cube.reshape(len(cube) ** 2, len(graph))[half].T
    order = np.lexsort((*hops.T, *vectors.T, graph.labels))
    weights = np.where(places.flat[half] == further.flat[half], 1.0, 2.0)
    return _OrderedGraph(graph.labels[order], vectors[order], np.ascontiguousarray(hops[order]), weights)


def _compare_two(one: _OrderedGraph, other: _OrderedGraph, gamma: float) -> float:
    """Σ_v Σ_v' k(v, v') <M_v, M_v'>, where paths longer than the longest of one graph meet none."""
    if not len(one.labels) or not len(other.labels):
        return 0.0
    shared = min(len(one.weights), len(other.weights))
    # Sums of products of whole numbers: exact in any order.
    paths = (one.hops[:, :shared] * one.weights[:shared]) @ other.hops[:, :shared].T
    alike = np.exp(-gamma * cdist(one.vectors, other.vectors, "sqeuclidean"))
    return float((paths * alike * (one.labels[:, None] == other.labels)).sum())


def _read_vectors(graphs: Sequence[LabelledGraph], attribute: str, *, size: int | None = None) -> list[Floats]:
    """Vectors of nodes by graph, shape (n, d) each; d is that of the first node, or `size`."""
    given = [[_to_vector(value) for _, value in graph.graph.nodes(data=attribute)] for graph in graphs]
    if size is None:
        size = next((len(vector) for of_graph in given for vector in of_graph if len(vector)), 0)
    faults = []
    for number, (graph, of_graph) in enumerate(zip(graphs, given, strict=True)):
        bad = [
            node for node, vector in zip(graph.graph, of_graph, strict=True) if not len(vector) or len(vector) != size
        ]
        if bad:
            what = f"{size} finite numbers" if size else "finite numbers"
            faults.append(f"nodes {name_some(bad)} of graph {number} have no {attribute!r} of {what}, set it")
    if faults:
        raise GraphError(join_faults(faults))
    return [np.array(of_graph, np.float64).reshape(len(of_graph), size) for of_graph in given]


def _to_vector(value: object) -> Floats:
    """The numbers, shape (d,); none where they are no finite numbers."""
    try:
        vector = np.atleast_1d(np.asarray(value, np.float64))
    except (TypeError, ValueError):
        return np.zeros(0)
    return vector if vector.ndim == 1 and np.isfinite(vector).all() else np.zeros(0)


def _check_gamma(gamma: object) -> None:
    if gamma == "scale" or (isinstance(gamma, Real) and isfinite(gamma) and float(gamma) > 0):
        return
    raise OptionError(f'gamma is {gamma!r}, give "scale" or a number above 0')
