"""Functional areas: a floor's graph cut into groups of neighbouring rooms (thesis, section 7.3.1).

`corr` gives each room to its nearest corridor, `ncut` divides the graph where the normalised cut is least (Shi and
Malik, 2000). What joins the areas is the functional graph.
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

# The authors stop where the normalised cut is above 0.6; parts of 5 rooms and more give the number of areas that
# section 7.3.3 prints: 206 for 50 schools as there are of ours, 207 in print.
MAX_NORMALIZED_CUT, LEAST_ROOMS = 0.6, 5
# Entries of Fiedler vectors are compared to so many decimals, so that nodes that are alike stay in their order.
DECIMALS = 9


class Segmentation(StrEnum):
    """How a graph is cut: by corridors, or where the normalised cut is least."""

    CORR = "corr"
    NCUT = "ncut"


def find_functional_areas(
    graph: nx.Graph, corridors: Collection[Hashable], *, segmentation: Segmentation
) -> tuple[Area, ...]:
    """The areas of a connected graph with whole numbers for nodes, in the order of their first nodes.

    Each is connected, and each node is in one.
    corridors: the nodes that are CORRIDOR; `ncut` does not ask what nodes are.
    """
    if segmentation is Segmentation.CORR:
        return segment_by_corridors(graph, corridors)
    return segment_by_normalized_cut(graph)


def segment_by_corridors(graph: nx.Graph, corridors: Collection[Hashable]) -> tuple[Area, ...]:
    """`corr`: each ROOM belongs to its nearest CORRIDOR; of several to that of the highest degree, then to the first.

    A CORRIDOR that is no room's nearest is no area of its own, and belongs to the nearest that is, by the same rule;
    with it the areas of the schools are as many as section 7.3.3 prints. A graph without corridors is one area.
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
    kept = [hub for hub in hubs if hub in chosen] or [max(hubs, key=graph.degree)]
    hub_of |= {hub: hub if hub in kept else find_nearest(hub, kept) for hub in hubs}
    return _gather_areas(graph, [[node for node in graph if hub_of[node] == hub] for hub in kept])


def segment_by_normalized_cut(
    graph: nx.Graph, *, max_cut: float = MAX_NORMALIZED_CUT, least: int = LEAST_ROOMS
) -> tuple[Area, ...]:
    """`ncut`: divide a graph in two where the normalised cut is least, and each part again.

    A part stays whole when that cut is above `max_cut`, or leaves fewer than `least` nodes on a side.
    """
    areas, parts = [], [list(graph)]
    while parts:
        part = parts.pop()
        divided = _divide(graph.subgraph(part), part, max_cut, least)
        if divided is None:
            areas.append(part)
            continue
        for side in divided:
            # One side of a cut may fall apart; areas are connected.
            pieces = nx.connected_components(graph.subgraph(side))
            parts.extend([node for node in graph if node in piece] for piece in pieces)
    return _gather_areas(graph, areas)


def find_cuts(graph: nx.Graph, areas: Iterable[Area]) -> dict[tuple[int, int], list[Cut]]:
    """The edges between areas, by the places of the two areas, the smaller first; nodes in the order of the areas."""
    area_of = {node: place for place, area in enumerate(areas) for node in area}
    cuts: dict[tuple[int, int], list[Cut]] = {}
    for one, other in graph.edges:
        ends = sorted((one, other), key=lambda node: area_of[node])
        first, second = area_of[ends[0]], area_of[ends[1]]
        if first != second:
            cuts.setdefault((first, second), []).append((ends[0], ends[1]))
    return cuts


def build_functional_graph(graph: nx.Graph, areas: Sequence[Area], labels: Sequence[str]) -> nx.Graph:
    """H: a node an area, by its place, with a label each; an edge where a cut joins two areas, `cuts` their number."""
    functional = nx.Graph()
    functional.add_nodes_from((place, {"label": label}) for place, label in zip(range(len(areas)), labels, strict=True))
    functional.add_edges_from((*pair, {"cuts": len(cuts)}) for pair, cuts in find_cuts(graph, areas).items())
    return functional


def _gather_areas(graph: nx.Graph, parts: Iterable[Collection[int]]) -> tuple[Area, ...]:
    places = {node: place for place, node in enumerate(graph)}
    return tuple(sorted(map(frozenset, parts), key=lambda area: min(places[node] for node in area)))


def _divide(graph: nx.Graph, nodes: Sequence[int], max_cut: float, least: int) -> tuple[list[int], list[int]] | None:
    """The two sides of the least normalised cut along the Fiedler vector; None where it is not to be cut."""
    if len(nodes) < 2 * least:
        return None
    adjacency = nx.to_numpy_array(graph, nodelist=nodes, weight=None)
    order = np.argsort(_find_fiedler_vector(adjacency), kind="stable")
    adjacency = adjacency[np.ix_(order, order)]
    degrees = adjacency.sum(axis=0)
    firsts = np.arange(1, len(nodes))
    # Cut(s_a, s_b) of the first k nodes grows by the edges of node k to later ones, less those to earlier ones.
    later = np.triu(adjacency).sum(axis=1) - np.tril(adjacency).sum(axis=1)
    cut = np.cumsum(later)[:-1]
    association = np.cumsum(degrees)[:-1]
    normalized = (cut / association + cut / (degrees.sum() - association)).round(DECIMALS)
    best = int(normalized.argmin())
    if normalized[best] > max_cut or not least <= firsts[best] <= len(nodes) - least:
        return None
    ordered = [nodes[place] for place in order]
    return ordered[: firsts[best]], ordered[firsts[best] :]


def _find_fiedler_vector(adjacency: NDArray[np.float64]) -> NDArray[np.float64]:
    """The solution of (D - W) y = λ D y with the second smallest λ, its largest entry positive."""
    roots = np.sqrt(adjacency.sum(axis=0))
    laplacian = np.eye(len(adjacency)) - adjacency / np.outer(roots, roots)
    vector = np.linalg.eigh(laplacian)[1][:, 1] / roots
    vector *= np.sign(vector[np.abs(vector).round(DECIMALS).argmax()])
    rounded: NDArray[np.float64] = vector.round(DECIMALS)
    return rounded
