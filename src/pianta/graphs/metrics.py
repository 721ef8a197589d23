"""Metrics of a building as a graph (section 5.1), by the definitions that reproduce Table 5.1."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable
from types import MappingProxyType

import networkx as nx
import numpy as np

from pianta.graphs.centrality import (
    Centrality,
    distances,
    measure_betweenness,
    measure_closeness,
    measure_eigenvector,
    measure_katz,
)
from pianta.labels import RC, LabelConvention, LabelSchema, LabelSet

CENTRALITIES: MappingProxyType[str, Callable[[nx.Graph], Centrality]] = MappingProxyType(
    {
        "betweenness": measure_betweenness,
        "closeness": measure_closeness,
        "eigenvector": measure_eigenvector,
        "katz": measure_katz,
    }
)
GRAPH_METRICS: tuple[str, ...] = (
    *("nodes", "edges", "nodes_r", "nodes_c", "path_length", "diameter", "art_points", "assortativity"),
    *(f"{name}{suffix}" for name in CENTRALITIES for suffix in ("", "_r", "_c")),
)


def measure_graph(graph: nx.Graph, corridors: Collection[Hashable]) -> dict[str, float | None]:
    """GRAPH_METRICS of a simple undirected graph with any number of components; None if undefined.

    corridors: its nodes that are CORRIDOR; all others are ROOM; `_c` and `_r` are means over these.
    Table 5.1 has isolated rooms removed (`drop_isolated`); here they count.
    Undefined are: path length without edges, the diameter of no nodes, assortativity if all ends of edges have the
    same degree, a mean over no nodes, and Katz centrality where `measure_katz` is nan.
    """
    in_corridors = np.array([node in corridors for node in graph], bool)
    measured: dict[str, float | None] = {
        "nodes": len(graph),
        "edges": graph.number_of_edges(),
        "nodes_r": int((~in_corridors).sum()),
        "nodes_c": int(in_corridors.sum()),
        **_measure_paths(graph),
        "art_points": len({*nx.articulation_points(graph)}),
        "assortativity": measure_assortativity(graph),
    }
    for name, measure in CENTRALITIES.items():
        values = np.array(list(measure(graph).values()))
        for suffix, part in (("", values), ("_r", values[~in_corridors]), ("_c", values[in_corridors])):
            measured[name + suffix] = float(part.mean()) if np.isfinite(part).all() and part.size else None
    return measured


def measure_assortativity(graph: nx.Graph) -> float | None:
    """Correlation of the degrees at the two ends of edges, from -1 to 1; None if all ends have the same degree.

    Each edge counts in both directions. According to its text the thesis considers "only ROOMS and CORRIDORS", but its
    table has the degree assortativity of all nodes.
    """
    ends = np.array([(graph.degree(first), graph.degree(second)) for first, second in graph.edges]).reshape(-1, 2)
    if not len(ends) or np.ptp(ends) == 0:
        return None
    both = np.concatenate([ends, ends[:, ::-1]])
    return float(np.corrcoef(both.T)[0, 1])


def find_corridors(
    graph: nx.Graph, schema: LabelSchema, *, convention: LabelConvention = LabelConvention.GRAPHS
) -> frozenset[Hashable]:
    """The nodes of a floor's graph whose label is a CORRIDOR.

    Raises LabelError that lists the labels that the schema lacks.
    """
    labels = schema.map_labels((label for _, label in graph.nodes(data="label")), LabelSet.R_C, convention=convention)
    return frozenset(node for node, label in zip(graph, labels, strict=True) if label == RC.CORRIDOR)


def _measure_paths(graph: nx.Graph) -> dict[str, float | None]:
    """Mean and maximum length of the shortest paths between connected nodes."""
    lengths = distances(graph)
    joined = lengths[np.isfinite(lengths) & (lengths > 0)]
    return {
        "path_length": float(joined.mean()) if joined.size else None,
        "diameter": int(joined.max(initial=0)) if len(graph) else None,
    }
