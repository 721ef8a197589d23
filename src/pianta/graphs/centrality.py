"""How central each node of a graph is, by the definitions that reproduce Table 5.1 (thesis, section 5.1).

The functions that measure take a simple undirected graph, of any number of parts, and map its nodes, in its order, to
numbers. Weights of edges do not count.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import nan
from typing import Any, TypeAlias

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.graphs.shortest_paths import Adjacency, ShortestPaths, find_shortest_paths

Centrality: TypeAlias = dict[Any, float]

KATZ_ALPHA, KATZ_BETA = 0.1, 1.0
# Eigenvalues that differ by less than this share are the same.
SAME_EIGENVALUE = 1e-9


def measure_betweenness(graph: nx.Graph) -> Centrality:
    """Shares of shortest paths between two other nodes that lead through a node.

    Each pair of other nodes counts once and the sum is divided by (n - 1)(n - 2), which makes a half of what is usual:
    the centre of a star has 0.5. The thesis prints the sum without a divisor; Table 5.1 has it divided.
    """
    return _by_node(graph, betweenness_from_paths(find_shortest_paths(to_arrays(graph))))


def betweenness_from_paths(paths: ShortestPaths) -> NDArray[np.float64]:
    """`measure_betweenness` of a graph, shape (n,), given its shortest paths."""
    n = len(paths.distances)
    return np.asarray(paths.measure_betweenness() / max(2 * (n - 1) * (n - 2), 1))


def measure_closeness(graph: nx.Graph) -> Centrality:
    """Nodes that can be reached over the sum of distances to them, times their share of all other nodes.

    The thesis prints decay centrality instead (`measure_decay`), which Table 5.1 does not have.
    """
    return _by_node(graph, closeness_from_distances(distances(graph)))


def closeness_from_distances(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """`measure_closeness` of a graph, shape (n,), given its `distances`."""
    joined = np.isfinite(lengths)
    others = joined.sum(axis=1) - 1.0
    total = np.where(joined, lengths, 0).sum(axis=1)
    return np.asarray(others / np.maximum(total, 1) * others / max(len(lengths) - 1, 1))


def measure_decay(graph: nx.Graph) -> Centrality:
    """Sum of 2^-distance over the other nodes, 0 for those out of reach: the closeness that section 5.1 prints."""
    closeness = np.exp2(-distances(graph))
    return _by_node(graph, closeness.sum(axis=1) - 1 if len(graph) else ())


def measure_eigenvector(graph: nx.Graph) -> Centrality:
    """Eigenvector of the adjacency matrix for its largest eigenvalue, scaled to a maximum of 1.

    It is the limit of the power iteration from ones: parts of the graph with a smaller largest eigenvalue have 0.
    All nodes of a graph without edges have 0.
    """
    values = np.zeros(len(graph))
    if graph.number_of_edges():
        # Exact, where the iteration needs a gap to the next eigenvalue.
        eigenvalues, vectors = np.linalg.eigh(nx.to_numpy_array(graph, weight=None))
        largest = eigenvalues >= eigenvalues[-1] * (1 - SAME_EIGENVALUE)
        span = vectors[:, largest]
        # The projection of ones, for where parts share the largest eigenvalue any basis of their space is found.
        values = np.abs(span @ span.T @ np.ones(len(graph)))
        values /= values.max()
    return _by_node(graph, values)


def measure_katz(graph: nx.Graph, *, alpha: float = KATZ_ALPHA) -> Centrality:
    """Solution of x = α M x + β with the adjacency matrix M and β = 1, scaled to length 1.

    nan where α reaches one over the largest eigenvalue of M, where walks add up to no finite number: with 0.1, a
    corridor with 100 rooms that have no other door.
    """
    if not len(graph):
        return {}
    matrix = nx.to_numpy_array(graph, weight=None)
    if alpha * np.linalg.eigvalsh(matrix)[-1] >= 1 - SAME_EIGENVALUE:
        return dict.fromkeys(graph, nan)
    values = np.linalg.solve(np.eye(len(graph)) - alpha * matrix, np.full(len(graph), KATZ_BETA))
    return _by_node(graph, values / np.linalg.norm(values))


def drop_isolated(graph: nx.Graph) -> nx.Graph:
    """A copy without the rooms that no door leads to, which Table 5.1 does not count."""
    return graph.subgraph([node for node, degree in graph.degree() if degree]).copy()


def distances(graph: nx.Graph) -> NDArray[np.float64]:
    """Numbers of edges on shortest paths, shape (n, n), in the order of the graph; infinite where there is none."""
    import rustworkx as rx  # as find_shortest_paths, but faster on large graphs; what reads a map does without

    if not len(graph):
        return np.zeros((0, 0))
    places = {node: place for place, node in enumerate(graph)}
    same = rx.PyGraph(multigraph=False)
    same.add_nodes_from(list(graph))
    same.add_edges_from_no_data([(places[first], places[second]) for first, second in graph.edges])
    return np.asarray(rx.distance_matrix(same, null_value=np.inf))


def to_arrays(graph: nx.Graph) -> Adjacency:
    """The edges of a graph; nodes are their places in its order."""
    places = {node: place for place, node in enumerate(graph)}
    edges = np.array([(places[first], places[second]) for first, second in graph.edges], np.intp).reshape(-1, 2)
    return Adjacency(len(graph), *np.concatenate([edges, edges[:, ::-1]]).T)


def _by_node(graph: nx.Graph, values: Iterable[float]) -> Centrality:
    return {node: float(value) for node, value in zip(graph, values, strict=True)}
