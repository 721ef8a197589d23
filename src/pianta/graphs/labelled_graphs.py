"""LabelledGraph: the nodes, edges and labels of a networkx graph as arrays, as graph kernels want them."""

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

# Nodes or edges that a fault names; a graph without any labels is said in few words.
MAX_NAMED = 5


@dataclass(frozen=True, eq=False)
class LabelledNodes:
    """An undirected graph of n nodes and m edges, of any number of parts.

    labels: codes of the nodes' labels, shape (n,); zeros where they do not count.
    starts, ends: places of nodes, shape (2m,): each edge from both of its ends.
    edge_labels: codes of the edges' labels, shape (2m,); zeros where they do not count.
    """

    labels: Codes
    starts: Indices
    ends: Indices
    edge_labels: Codes

    def __len__(self) -> int:
        return len(self.labels)

    @cached_property
    def edges(self) -> Adjacency:
        """Its edges without their labels."""
        return Adjacency(len(self), self.starts, self.ends)


@dataclass(frozen=True, eq=False)
class LabelledGraph(LabelledNodes):
    """A networkx graph as arrays; graph: where it comes from, whose nodes are in the same order."""

    graph: nx.Graph

    @cached_property
    def distances(self) -> Floats:
        """Edges on shortest paths, shape (n, n), infinite where there is none."""
        return distances(self.graph)


def read_labelled_graphs(
    graphs: Iterable[nx.Graph], *, node_label: str | None, edge_label: str | None = None
) -> list[LabelledGraph]:
    """The graphs as arrays; a label may be anything that its text tells from others.

    node_label, edge_label: names of attributes; all are alike where no name is given.
    Raises GraphError that lists the nodes and edges without a label, and what is no simple undirected graph.
    """
    if isinstance(graphs, nx.Graph):
        raise GraphError("graphs is one graph, give a list of graphs")
    graphs = list(graphs)
    found = (_find_faults(graph, number, node_label, edge_label) for number, graph in enumerate(graphs))
    if faults := [fault for of_graph in found for fault in of_graph]:
        raise GraphError(join_faults(faults))
    return [_read(graph, node_label, edge_label) for graph in graphs]


def name_some(items: Sequence[object]) -> str:
    """The first few of nodes or edges, for a message."""
    return ", ".join(map(short_repr, items[:MAX_NAMED])) + (", …" if len(items) > MAX_NAMED else "")


def _find_faults(graph: object, number: int, node_label: str | None, edge_label: str | None) -> list[str]:
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
    edges = to_arrays(graph)
    of_edges = np.zeros(len(edges.starts) // 2, np.uint64)
    if edge_label is not None:
        of_edges = hash_labels(label for *_, label in graph.edges(data=edge_label))
    labels = np.zeros(len(graph), np.uint64)
    if node_label is not None:
        labels = hash_labels(label for _, label in graph.nodes(data=node_label))
    return LabelledGraph(labels, edges.starts, edges.ends, np.concatenate([of_edges, of_edges]), graph)


def hash_labels(labels: Iterable[Any]) -> Codes:
    """The codes of the texts of labels."""
    return np.array([hash_name(str(label)) for label in labels], np.uint64)
