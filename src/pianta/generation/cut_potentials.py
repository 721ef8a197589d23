"""Φ(n, n'): potential of a door between two rooms of different functional areas (thesis, section 7.4.3, step 4).

The potentials are learned from the cuts of the segmentation: a good door is one that would be cut again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.generation.type_model import TypeModel

# The label of a room, and the labels of its neighbours except the other room and common neighbours.
Star: TypeAlias = tuple[str, tuple[str, ...]]
# N_1 of an edge: the stars of its two ends, in order, and the labels of their common neighbours.
Neighborhood: TypeAlias = tuple[Star, Star, tuple[str, ...]]

# Width σ of the Gaussian kernel of Ξ (thesis, section 7.4.3).
SIGMA = 0.5
# Rounds of the Weisfeiler-Lehman kernel.
ITERATIONS = 5
# Ξ uses at most this many cuts, evenly over the floors.
MAX_CUTS = 2000
# Neighbourhoods whose Ξ is cached.
MAX_CACHED = 100_000


class CutPotentials:
    """Ξ and Υ of a model's cuts; Λ is the degree of a room, without its constant divisor.

    closed: the share of cuts that close a triangle, which means that their ends have a common neighbour. None to ignore
    it, as in the thesis.
    """

    def __init__(self, model: TypeModel, *, closing: bool = True) -> None:
        from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

        neighborhoods: list[Neighborhood] = []
        pairs: Counter[tuple[str, str]] = Counter()
        for floor in model.floors:
            labels = [label for _, label in floor.graph.nodes(data="label")]
            neighbors = [set(floor.graph[node]) for node in floor.graph]
            for cuts in floor.cuts.values():
                for one, other in cuts:
                    neighborhoods.append(describe_neighborhood(labels, neighbors, one, other))
                    pairs[_order(labels[one], labels[other])] += 1
        # Υ: the share of cuts between rooms with these labels.
        total = pairs.total()
        self._frequencies = {pair: count / total for pair, count in pairs.items()}
        neighborhoods = neighborhoods[:: -(-len(neighborhoods) // MAX_CUTS) or 1]
        # With half a cut that closes a triangle and half a cut that does not as prior.
        closed = (sum(bool(common) for *_, common in neighborhoods) + 1 / 2) / (len(neighborhoods) + 1)
        self.closed = closed if closing else None
        # Ξ: similarity of a neighbourhood to those of the cuts, relative to their similarity to each other.
        self._kernel = WeisfeilerLehman(iterations=ITERATIONS).fit(map(build_neighborhood, neighborhoods))
        self._cached: dict[Neighborhood, float] = {}
        self._typical, self._scale = np.zeros(0), 0.0
        if neighborhoods:
            distances = np.sqrt(np.maximum(2 - 2 * self._kernel.compare(), 0))
            self._typical = distances.mean(axis=0)
            self._scale = float(self._weigh(distances).sum())

    def measure_frequency(self, one: str, other: str) -> float:
        """Υ: the share of cuts between two labels."""
        return self._frequencies.get(_order(one, other), 0.0)

    def measure_resemblance(self, neighborhoods: Iterable[Neighborhood]) -> Mapping[Neighborhood, float]:
        """Ξ of neighbourhoods, and of all cached ones; 1 for all if the model has no cuts."""
        distinct = dict.fromkeys(neighborhoods)
        new = [neighborhood for neighborhood in distinct if neighborhood not in self._cached]
        if len(self._cached) + len(new) > MAX_CACHED:
            self._cached.clear()
            new = [*distinct]
        if not self._scale:
            self._cached.update(dict.fromkeys(new, 1.0))
            return self._cached
        if new:
            similarity = self._kernel.compare(map(build_neighborhood, new))
            weights = self._weigh(np.sqrt(np.maximum(2 - 2 * similarity, 0)))
            self._cached.update(zip(new, (weights.sum(axis=1) / self._scale).tolist(), strict=True))
        return self._cached

    def _weigh(self, distances: Floats) -> Floats:
        weights: Floats = np.exp(-((distances - self._typical) ** 2) / (2 * SIGMA**2))
        return weights


def describe_neighborhood(labels: Sequence[str], neighbors: Sequence[set[int]], one: int, other: int) -> Neighborhood:
    """N_1 of a possible edge between two nodes: these, their neighbours, and their edges.

    labels, neighbors: of all nodes.
    """
    around = {one: neighbors[one] - {other}, other: neighbors[other] - {one}}
    common = around[one] & around[other]
    first, second = sorted(
        (labels[node], tuple(sorted(labels[near] for near in nodes - common))) for node, nodes in around.items()
    )
    return first, second, tuple(sorted(labels[near] for near in common))


def build_neighborhood(neighborhood: Neighborhood) -> nx.Graph:
    """The graph of a neighbourhood."""
    *stars, common = neighborhood
    graph = nx.Graph([(0, 1)])
    for center, (label, around) in enumerate(stars):
        graph.nodes[center]["label"] = label
        for near in around:
            node = len(graph)
            graph.add_node(node, label=near)
            graph.add_edge(center, node)
    for near in common:
        node = len(graph)
        graph.add_node(node, label=near)
        graph.add_edges_from(((0, node), (1, node)))
    return graph


def _order(one: str, other: str) -> tuple[str, str]:
    return (one, other) if one <= other else (other, one)
