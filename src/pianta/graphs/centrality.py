"""Centralities of nodes, by the definitions that reproduce Table 5.1 (thesis, section 5.1).

The `measure_` functions take a simple undirected graph with any number of components, and map its nodes, in its order,
to numbers. Weights of edges are ignored.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import nan
from typing import Any, TypeAlias

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.graphs.shortest_paths import Adjacency, ShortestPaths, find_shortest_paths

Centrality: TypeAlias = dict[Any, float]

# Parameters of the Katz centrality in Table 5.1, the defaults of networkx.
KATZ_ALPHA = 0.1
KATZ_BETA = 1.0
# Relative tolerance of equal eigenvalues.
EIGENVALUE_TOLERANCE = 1e-9


def measure_betweenness(graph: nx.Graph) -> Centrality:
    """Sum over pairs of other nodes of the share of their shortest paths through a node, over (n - 1)(n - 2).

    Each pair counts once, so it is half of the usual definition: the centre of a star has 0.5. The formula of the
    thesis has no divisor, but Table 5.1 has it.
    """
    return _by_node(graph, betweenness_from_paths(find_shortest_paths(to_arrays(graph))))


def betweenness_from_paths(paths: ShortestPaths) -> NDArray[np.float64]:
    """`measure_betweenness` of a graph, shape (n,), given its shortest paths."""
    n = len(paths.distances)
    return np.asarray(paths.measure_betweenness() / max(2 * (n - 1) * (n - 2), 1))


def measure_closeness(graph: nx.Graph) -> Centrality:
    """Number of reachable nodes over the sum of their distances, times their share of all other nodes.

    The formula of the thesis is decay centrality (`measure_decay`), but Table 5.1 has this one.
    """
    return _by_node(graph, closeness_from_distances(distances(graph)))


def closeness_from_distances(lengths: NDArray[np.float64]) -> NDArray[np.float64]:
    """`measure_closeness` of a graph, shape (n,), given its `distances`."""
    joined = np.isfinite(lengths)
    others = joined.sum(axis=1) - 1.0
    total = np.where(joined, lengths, 0).sum(axis=1)
    return np.asarray(others / np.maximum(total, 1) * others / max(len(lengths) - 1, 1))


def measure_decay(graph: nx.Graph) -> Centrality:
    """Sum of 2^-distance over the other nodes, 0 for unreachable ones: the closeness of the formula in section 5.1."""
    closeness = np.exp2(-distances(graph))
    return _by_node(graph, closeness.sum(axis=1) - 1 if len(graph) else ())


def measure_eigenvector(graph: nx.Graph) -> Centrality:
    """Eigenvector of the adjacency matrix for its largest eigenvalue, scaled to a maximum of 1.

    The limit of the power iteration that starts with ones: 0 in components with a smaller largest eigenvalue, and in a
    graph without edges.
    """
    values = np.zeros(len(graph))
    if graph.number_of_edges():
        # Exact, unlike the iteration, which needs a gap to the next eigenvalue.
        eigenvalues, vectors = np.linalg.eigh(nx.to_numpy_array(graph, weight=None))
        largest = eigenvalues >= eigenvalues[-1] * (1 - EIGENVALUE_TOLERANCE)
        span = vectors[:, largest]
        # The projection of ones onto the eigenspace, as its basis is arbitrary if components share the eigenvalue.
        values = np.abs(span @ span.T @ np.ones(len(graph)))
        values /= values.max()
    return _by_node(graph, values)


def measure_katz(graph: nx.Graph, *, alpha: float = KATZ_ALPHA) -> Centrality:
    """Solution of x = α M x + β with the adjacency matrix M and β = 1, scaled to length 1.

    nan if α is at least one over the largest eigenvalue of M, where the sum of walks diverges: for 0.1, on a floor of
    one corridor with 100 rooms.
    """
    if not len(graph):
        return {}
    values: Centrality = {}
    for nodes, matrix in _split_into_components(graph):
        if alpha * np.linalg.eigvalsh(matrix)[-1] >= 1 - EIGENVALUE_TOLERANCE:
            return dict.fromkeys(graph, nan)
        solved = np.linalg.solve(np.eye(len(nodes)) - alpha * matrix, np.full(len(nodes), KATZ_BETA))
        values |= dict(zip(nodes, solved, strict=True))
    in_order = np.array([values[node] for node in graph])
    return _by_node(graph, in_order / np.linalg.norm(in_order))


def find_largest_eigenvalue(graph: nx.Graph) -> float:
    """The largest eigenvalue of the adjacency matrix, 0 without edges."""
    if not len(graph):
        return 0.0
    return max(float(np.linalg.eigvalsh(matrix)[-1]) for _, matrix in _split_into_components(graph))


def drop_isolated(graph: nx.Graph) -> nx.Graph:
    """A copy without isolated nodes: rooms without a door, which Table 5.1 does not count."""
    return graph.subgraph([node for node, degree in graph.degree() if degree]).copy()


def distances(graph: nx.Graph) -> NDArray[np.float64]:
    """Lengths of shortest paths, shape (n, n), in the order of the graph; infinite without a path."""
    # Faster than find_shortest_paths on large graphs; slow to import, so the code that reads a map does not use it.
    import rustworkx as rx

    if not len(graph):
        return np.zeros((0, 0))
    indices = {node: index for index, node in enumerate(graph)}
    copy = rx.PyGraph(multigraph=False)
    copy.add_nodes_from(list(graph))
    copy.add_edges_from_no_data([(indices[first], indices[second]) for first, second in graph.edges])
    return np.asarray(rx.distance_matrix(copy, null_value=np.inf))


def to_arrays(graph: nx.Graph) -> Adjacency:
    """The edges of a graph, with nodes as indices in its order."""
    indices = {node: index for index, node in enumerate(graph)}
    edges = np.array([(indices[first], indices[second]) for first, second in graph.edges], np.intp).reshape(-1, 2)
    return Adjacency(len(graph), *np.concatenate([edges, edges[:, ::-1]]).T)


def _split_into_components(graph: nx.Graph) -> Iterator[tuple[list[Any], NDArray[np.float64]]]:
    """The nodes of each component, in the order of the graph, and their adjacency matrix.

    What takes the cube of the nodes takes far less so on a campus, whose buildings are components.
    """
    indices = {node: index for index, node in enumerate(graph)}
    for component in nx.connected_components(graph):
        nodes = sorted(component, key=indices.__getitem__)
        yield nodes, nx.to_numpy_array(graph.subgraph(nodes).copy(), nodes, weight=None)


def _by_node(graph: nx.Graph, values: Iterable[float]) -> Centrality:
    return {node: float(value) for node, value in zip(graph, values, strict=True)}
