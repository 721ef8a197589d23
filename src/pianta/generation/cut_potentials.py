"""Φ(n, n'): how likely a door joins two rooms of different functional areas (thesis, section 7.4.3, step 4).

The potentials look at the cuts that segmentation made: a good door is one that would be cut again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.generation.type_model import TypeModel

# A room's label, and those of its neighbours but for the other room's and for common ones.
Star: TypeAlias = tuple[str, tuple[str, ...]]
# N_1 of an edge: the stars of its two ends, in order, and the labels of their common neighbours.
Neighborhood: TypeAlias = tuple[Star, Star, tuple[str, ...]]

SIGMA = 0.5
ITERATIONS = 5
# Ξ looks at so many of the cuts at most, evenly over the floors, and remembers so many neighbourhoods.
MAX_CUTS, MAX_KNOWN = 2000, 100_000


class CutPotentials:
    """Ξ and Υ of a model's cuts; Λ is the degree of a room, the number that it is divided by being the same for all.

    closed: the share of cuts that close a triangle: their ends have a common neighbour. None where that is not to
    count, as in print.
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
        # Υ: how many of the cuts are between rooms of these labels.
        total = pairs.total()
        self._frequencies = {pair: count / total for pair, count in pairs.items()}
        neighborhoods = neighborhoods[:: -(-len(neighborhoods) // MAX_CUTS) or 1]
        # One half that does, and one that does not, are counted besides.
        closed = (sum(bool(common) for *_, common in neighborhoods) + 1 / 2) / (len(neighborhoods) + 1)
        self.closed = closed if closing else None
        # Ξ: how near a neighbourhood is to those of the cuts, as near as these are to each other.
        self._kernel = WeisfeilerLehman(iterations=ITERATIONS).fit(map(build_neighborhood, neighborhoods))
        self._known: dict[Neighborhood, float] = {}
        self._typical, self._scale = np.zeros(0), 0.0
        if neighborhoods:
            distances = np.sqrt(np.maximum(2 - 2 * self._kernel.compare(), 0))
            self._typical = distances.mean(axis=0)
            self._scale = float(self._weigh(distances).sum())

    def measure_frequency(self, one: str, other: str) -> float:
        """Υ: the share of cuts that are between two labels."""
        return self._frequencies.get(_order(one, other), 0.0)

    def measure_resemblance(self, neighborhoods: Iterable[Neighborhood]) -> Mapping[Neighborhood, float]:
        """Ξ of neighbourhoods, and of all that were asked for before; all are as good where the model has no cuts."""
        asked = [*neighborhoods]
        new = [wanted for wanted in dict.fromkeys(asked) if wanted not in self._known]
        if len(self._known) + len(new) > MAX_KNOWN:
            self._known.clear()
            new = [*dict.fromkeys(asked)]
        if not self._scale:
            self._known.update(dict.fromkeys(new, 1.0))
            return self._known
        if new:
            similarity = self._kernel.compare(map(build_neighborhood, new))
            weights = self._weigh(np.sqrt(np.maximum(2 - 2 * similarity, 0)))
            self._known.update(zip(new, (weights.sum(axis=1) / self._scale).tolist(), strict=True))
        return self._known

    def _weigh(self, distances: Floats) -> Floats:
        weights: Floats = np.exp(-((distances - self._typical) ** 2) / (2 * SIGMA**2))
        return weights


def describe_neighborhood(labels: Sequence[str], neighbors: Sequence[set[int]], one: int, other: int) -> Neighborhood:
    """N_1 of the edge between two nodes, which need not be there: they, their neighbours, and the edges at either.

    labels, neighbors: of all nodes.
    """
    of_one, of_other = neighbors[one] - {other}, neighbors[other] - {one}
    common = of_one & of_other
    first, second = sorted(
        (labels[node], tuple(sorted(labels[near] for near in around - common)))
        for node, around in ((one, of_one), (other, of_other))
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
