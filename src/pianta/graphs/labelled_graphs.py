"""The nodes, edges and labels of a networkx graph as arrays, for graph kernels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import networkx as nx
import numpy as np

from pianta._types import Floats, Indices
from pianta.errors import GraphError
from pianta.graphs.centrality import distances, to_arrays
from pianta.graphs.shortest_paths import Adjacency
from pianta.graphs.stable_hash import Codes, hash_name
from pianta.io._faults import join_faults
from pianta.io._files import short_repr

# Nodes or edges that a message names.
MAX_NAMED = 5


@dataclass(frozen=True, eq=False)
class LabelledNodes:
    """An undirected graph of n nodes and m edges, with any number of components.

    labels: codes of the node labels, zeros without labels, shape (n,).
    starts, ends: indices of nodes, each edge in both directions, shape (2m,).
    edge_labels: codes of the edge labels, zeros without labels, shape (2m,).
    """

    labels: Codes
    starts: Indices
    ends: Indices
    edge_labels: Codes

    def __len__(self) -> int:
        return len(self.labels)

    @cached_property
    def edges(self) -> Adjacency:
        """The edges without labels."""
        return Adjacency(len(self), self.starts, self.ends)


@dataclass(frozen=True, eq=False)
class LabelledGraph(LabelledNodes):
    """A networkx graph as arrays; graph: the original, with nodes in the same order."""

    graph: nx.Graph

    @cached_property
    def distances(self) -> Floats:
        """Lengths of shortest paths, infinite without a path, shape (n, n)."""
        return distances(self.graph)


def read_labelled_graphs(
    graphs: Iterable[nx.Graph], *, node_label: str | None, edge_label: str | None = None
) -> list[LabelledGraph]:
    """The graphs as arrays; labels are compared by their text.

    node_label, edge_label: names of attributes; None to ignore labels.
    Raises GraphError that lists the nodes and edges without a label, and objects that are not simple undirected graphs.
    """
    if isinstance(graphs, nx.Graph):
        raise GraphError("graphs is one graph, give a list of graphs")
    graphs = list(graphs)
    faults = [f for number, graph in enumerate(graphs) for f in _find_faults(graph, number, node_label, edge_label)]
    if faults:
        raise GraphError(join_faults(faults))
    return [_read(graph, node_label, edge_label) for graph in graphs]


def name_some(items: Sequence[object]) -> str:
    """The first few of nodes or edges, for a message."""
    return ", ".join(map(short_repr, items[:MAX_NAMED])) + (", …" if len(items) > MAX_NAMED else "")


def _find_faults(graph: object, number: int, node_label: str | None, edge_label: str | None) -> list[str]:
    """Messages about missing labels, loops, or an object that is no simple undirected graph; number: its index."""
    if not isinstance(graph, nx.Graph) or graph.is_directed() or graph.is_multigraph():
        return [
            f"graph {number} is a {type(graph).__name__}, give a networkx.Graph with no directions, no parallel edges"
        ]
    nodes, edges = [], []
    if node_label is not None:
        nodes = [node for node, label in graph.nodes(data=node_label) if label is None]
    if edge_label is not None:
        edges = [(first, second) for first, second, label in graph.edges(data=edge_label) if label is None]
    faults = []
    if nodes:
        faults.append(f"nodes {name_some(nodes)} of graph {number} have no {node_label!r}, label them")
    if edges:
        faults.append(f"edges {name_some(edges)} of graph {number} have no {edge_label!r}, label them")
    if loops := [node for node in graph if graph.has_edge(node, node)]:
        faults.append(f"nodes {name_some(loops)} of graph {number} have edges to themselves, remove these")
    return faults


def _read(graph: nx.Graph, node_label: str | None, edge_label: str | None) -> LabelledGraph:
    """A graph as arrays, each edge in both directions; labels are 0 where the name of their attribute is None."""
    edges = to_arrays(graph)
    edge_labels = np.zeros(len(edges.starts) // 2, np.uint64)
    if edge_label is not None:
        edge_labels = hash_labels(label for *_, label in graph.edges(data=edge_label))
    labels = np.zeros(len(graph), np.uint64)
    if node_label is not None:
        labels = hash_labels(label for _, label in graph.nodes(data=node_label))
    return LabelledGraph(labels, edges.starts, edges.ends, np.concatenate([edge_labels, edge_labels]), graph)


def hash_labels(labels: Iterable[Any]) -> Codes:
    """The codes of labels, by their text."""
    return np.array([hash_name(str(label)) for label in labels], np.uint64)
