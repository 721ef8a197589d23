"""Functional areas: the graph of a floor divided into groups of neighbouring rooms (thesis, section 7.3.1).

`corr` assigns each room to its nearest corridor, `ncut` divides the graph at the smallest normalised cut (Shi and
Malik, 2000). The functional graph has a node for each area.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Sequence
from enum import StrEnum
from typing import TypeAlias

import networkx as nx
import numpy as np
from numpy.typing import NDArray

Area: TypeAlias = frozenset[int]
Cut: TypeAlias = tuple[int, int]

# Parts with a larger normalised cut are not divided (thesis, section 7.3.1).
MAX_NORMALIZED_CUT = 0.6
# Rooms of an area of `ncut`; chosen for the number of areas in section 7.3.3: 206 per 50 schools here, 207 there.
MIN_ROOMS = 5
# Decimals of Fiedler vectors and cuts, so that equivalent nodes stay in their order.
DECIMALS = 9


class Segmentation(StrEnum):
    """How a graph is divided: by corridors, or at normalised cuts."""

    CORR = "corr"
    NCUT = "ncut"


def find_functional_areas(
    graph: nx.Graph, corridors: Collection[Hashable], *, segmentation: Segmentation
) -> tuple[Area, ...]:
    """Divide a connected graph with integer nodes into connected areas, in the order of their first nodes.

    corridors: the nodes of the class CORRIDOR; `ncut` ignores them.
    """
    if segmentation is Segmentation.CORR:
        return segment_by_corridors(graph, corridors)
    return segment_by_normalized_cut(graph)


def segment_by_corridors(graph: nx.Graph, corridors: Collection[Hashable]) -> tuple[Area, ...]:
    """`corr`: each ROOM belongs to its nearest CORRIDOR; of equally near ones to that of the highest degree.

    A CORRIDOR that is not the nearest of any room belongs to the nearest one that is, by the same rule; this reproduces
    the number of areas of the schools in section 7.3.3. A graph without corridors is one area.
    """
    rooms = [node for node in graph if node not in corridors]
    hubs = [node for node in graph if node in corridors]
    if not hubs:
        return (frozenset(graph),)
    hop_counts = dict(nx.all_pairs_shortest_path_length(graph))

    def find_nearest(node: int, among: Sequence[int]) -> int:
        return min(among, key=lambda hub: (hop_counts[node][hub], -graph.degree(hub)))

    hub_of = {room: find_nearest(room, hubs) for room in rooms}
    chosen = set(hub_of.values())
    centers = [hub for hub in hubs if hub in chosen] or [max(hubs, key=graph.degree)]
    hub_of |= {hub: hub if hub in centers else find_nearest(hub, centers) for hub in hubs}
    return _sort_areas(graph, [[node for node in graph if hub_of[node] == hub] for hub in centers])


def segment_by_normalized_cut(
    graph: nx.Graph, *, max_cut: float = MAX_NORMALIZED_CUT, min_rooms: int = MIN_ROOMS
) -> tuple[Area, ...]:
    """`ncut`: divide a graph at the smallest normalised cut, and each part again.

    A part is not divided if that cut is above `max_cut`, or leaves fewer than `min_rooms` nodes on a side.
    """
    areas, parts = [], [list(graph)]
    while parts:
        part = parts.pop()
        divided = _divide(graph.subgraph(part), part, max_cut, min_rooms)
        if divided is None:
            areas.append(part)
            continue
        for side in divided:
            # A side of a cut may be in several parts, but areas are connected.
            pieces = nx.connected_components(graph.subgraph(side))
            parts.extend([node for node in graph if node in piece] for piece in pieces)
    return _sort_areas(graph, areas)


def find_cuts(graph: nx.Graph, areas: Iterable[Area]) -> dict[tuple[int, int], list[Cut]]:
    """The edges between areas, by the sorted indices of the two areas; nodes in the order of the areas."""
    area_of = {node: index for index, area in enumerate(areas) for node in area}
    cuts: dict[tuple[int, int], list[Cut]] = {}
    for one, other in graph.edges:
        ends = sorted((one, other), key=lambda node: area_of[node])
        first, second = area_of[ends[0]], area_of[ends[1]]
        if first != second:
            cuts.setdefault((first, second), []).append((ends[0], ends[1]))
    return cuts


def build_functional_graph(graph: nx.Graph, areas: Sequence[Area], labels: Sequence[str]) -> nx.Graph:
    """H: a node for each area with its label; an edge for each two areas with cuts, `cuts` their number."""
    functional = nx.Graph()
    functional.add_nodes_from((index, {"label": label}) for index, label in zip(range(len(areas)), labels, strict=True))
    functional.add_edges_from((*pair, {"cuts": len(cuts)}) for pair, cuts in find_cuts(graph, areas).items())
    return functional


def _sort_areas(graph: nx.Graph, parts: Iterable[Collection[int]]) -> tuple[Area, ...]:
    order = {node: index for index, node in enumerate(graph)}
    return tuple(sorted(map(frozenset, parts), key=lambda area: min(order[node] for node in area)))


def _divide(
    graph: nx.Graph, nodes: Sequence[int], max_cut: float, min_rooms: int
) -> tuple[list[int], list[int]] | None:
    """The two sides of the smallest normalised cut along the Fiedler vector; None if it is not to be divided."""
    if len(nodes) < 2 * min_rooms:
        return None
    adjacency = nx.to_numpy_array(graph, nodelist=nodes, weight=None)
    order = np.argsort(_find_fiedler_vector(adjacency), kind="stable")
    adjacency = adjacency[np.ix_(order, order)]
    degrees = adjacency.sum(axis=0)
    firsts = np.arange(1, len(nodes))
    # With node k on the first side, the cut gains its edges to later nodes and loses those to earlier ones.
    later = np.triu(adjacency).sum(axis=1) - np.tril(adjacency).sum(axis=1)
    cut = np.cumsum(later)[:-1]
    association = np.cumsum(degrees)[:-1]
    normalized = (cut / association + cut / (degrees.sum() - association)).round(DECIMALS)
    best = int(normalized.argmin())
    if normalized[best] > max_cut or not min_rooms <= firsts[best] <= len(nodes) - min_rooms:
        return None
    ordered = [nodes[index] for index in order]
    return ordered[: firsts[best]], ordered[firsts[best] :]


def _find_fiedler_vector(adjacency: NDArray[np.float64]) -> NDArray[np.float64]:
    """The solution of (D - W) y = λ D y with the second smallest λ, its largest entry positive."""
    roots = np.sqrt(adjacency.sum(axis=0))
    laplacian = np.eye(len(adjacency)) - adjacency / np.outer(roots, roots)
    vector = np.linalg.eigh(laplacian)[1][:, 1] / roots
    vector *= np.sign(vector[np.abs(vector).round(DECIMALS).argmax()])
    rounded: NDArray[np.float64] = vector.round(DECIMALS)
    return rounded
