"""What is random in a layout, kept apart from it, so that one thing can be changed and the rest stays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import networkx as nx
import numpy as np

Edge = tuple[int, int]

# Edges of a spanning tree: corridors lead to corridors and rooms, so that most rooms are ends. What is random chooses
# between edges that would do, seldom one between two rooms: the door of one of them to a corridor then needs an arm,
# which is a corridor's, and one between the rooms would be a room's. Chosen by hand.
EDGE_WEIGHTS = (2.4, 2.0, 1.0)  # by the number of corridors at the edge
RANDOM_WEIGHT = 0.9
# Share of the changes that change the tree, and of the others that change the root. Chosen by hand.
TREE_CHANGES = 0.25
ROOT_CHANGES = 0.1
MOST_SEEDS = 2**31


@dataclass(frozen=True)
class Choices:
    """The choices of a layout.

    root: the corridor at which it begins. alleys: whether there is space for corridors beside blocks. weights: of the
    edges of the graph, 0 to 1; lower ones are in the spanning tree. seeds: of what is random at each room.
    """

    root: int
    alleys: bool
    weights: Mapping[Edge, float]
    seeds: Mapping[int, int]

    def find_tree(self, graph: nx.Graph, corridors: frozenset[Any]) -> nx.Graph:
        """The spanning tree."""
        weighted = nx.Graph()
        weighted.add_nodes_from(graph)
        for one, other in graph.edges:
            weighted.add_edge(one, other, weight=compute_edge_weight((one, other), corridors, self.weights[one, other]))
        return nx.minimum_spanning_tree(weighted)

    def have_same_tree(self, other: Choices) -> bool:
        """Whether only what is random at rooms differs from other choices."""
        return (self.root, self.alleys, self.weights) == (other.root, other.alleys, other.weights)

    def make_rng(self, room: int) -> np.random.Generator:
        """The random numbers of a room, the same at each call."""
        return np.random.default_rng(self.seeds[room])

    def change(
        self, roots: Sequence[int], swapped: Sequence[Edge], changeable: Sequence[int], rng: np.random.Generator
    ) -> Choices:
        """Choices that differ in one thing: the weight of an edge of `swapped`, the root, or the seed of a room."""
        if len(swapped) and rng.random() < TREE_CHANGES:
            edge = swapped[int(rng.integers(len(swapped)))]
            return replace(self, weights={**self.weights, edge: float(rng.random())})
        if rng.random() < ROOT_CHANGES:
            return replace(self, root=int(rng.choice(roots)), alleys=bool(rng.integers(2)))
        room = changeable[int(rng.integers(len(changeable)))]
        return replace(self, seeds={**self.seeds, room: int(rng.integers(MOST_SEEDS))})


def compute_edge_weight(edge: Edge, corridors: frozenset[Any], chance: float) -> float:
    """The weight of an edge for a spanning tree; chance: 0 to 1."""
    return EDGE_WEIGHTS[sum(node in corridors for node in edge)] + RANDOM_WEIGHT * chance


def sample_choices(graph: nx.Graph, root: int, *, alleys: bool, rng: np.random.Generator) -> Choices:
    """Random choices for a root."""
    weights = dict(zip(graph.edges, rng.random(graph.number_of_edges()).tolist(), strict=True))
    seeds = dict(zip(graph, rng.integers(MOST_SEEDS, size=len(graph)).tolist(), strict=True))
    return Choices(root, alleys, weights, seeds)
