"""Simple predictions of the unknown part of a floor: the average floor, the known part again, the local neighbours."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.generation.type_model import TypeModel, count_labels
from pianta.graphs.metrics import find_corridors
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from pianta.labels import LabelConvention, LabelSchema
from pianta.prediction.explored_part import ExploredPart
from pianta.prediction.open_ends import count_labels_of_part

BLIND = "blind"  # the average of the other floors, without the known part
KNOWN_PART = "known part"  # the known part again
LOCAL = "local"  # the most frequent neighbour of the room at each open end
BASELINES = (BLIND, KNOWN_PART, LOCAL)


@dataclass(frozen=True, eq=False)
class Baselines:
    """Predictions by the other floors of a type, without the sampler. model: of these floors."""

    model: TypeModel

    @cached_property
    def skeletons(self) -> list[nx.Graph]:
        """The corridors of each floor and the edges between them."""
        return [corridor_graph(floor.graph, self.model.schema) for floor in self.model.floors]

    @cached_property
    def medoid(self) -> nx.Graph:
        """The skeleton that is most similar to the others, by the Weisfeiler-Lehman kernel."""
        similarity = WeisfeilerLehman().fit(self.skeletons).compare()
        distances = np.sqrt(np.maximum(2 - 2 * similarity, 0))
        return self.skeletons[int(distances.sum(axis=0).round(9).argmin())]

    @cached_property
    def neighbours(self) -> Mapping[str, str]:
        """By label of a room the most frequent label of its neighbours; of several the first of the schema."""
        counters: dict[str, Counter[str]] = {}
        for floor in self.model.floors:
            labels = dict(floor.graph.nodes(data="label"))
            for one, other in floor.graph.edges:
                counters.setdefault(labels[one], Counter())[labels[other]] += 1
                counters.setdefault(labels[other], Counter())[labels[one]] += 1
        names = [*self.model.schema.by_name]
        return {label: max(names, key=lambda name: counts[name]) for label, counts in counters.items()}

    @cached_property
    def blind_shares(self) -> Floats:
        """Mean shares of labels of the floors, shape (labels,)."""
        counts = count_labels([floor.graph for floor in self.model.floors], self.model.schema)
        return np.asarray((counts / counts.sum(axis=1, keepdims=True)).mean(axis=0))

    def predict_ends(self, explored: ExploredPart) -> dict[int, str]:
        """For each open end the most frequent neighbour of its room; none if no floor has the label of the room."""
        near = {end: end for end in explored.open} | dict(explored.doors)
        labels = dict(explored.graph.nodes(data="label"))
        return {end: self.neighbours[labels[room]] for end, room in near.items() if labels[room] in self.neighbours}

    def predict_shares(self, explored: ExploredPart) -> dict[str, Floats]:
        """By baseline the shares of labels of unknown rooms, shape (labels,); local is blind without a prediction."""
        counts = count_labels_of_part(explored, self.model.schema)
        neighbours = Counter(self.predict_ends(explored).values())
        local = np.array([neighbours[label] for label in self.model.schema.by_name], float)
        return {
            BLIND: self.blind_shares,
            KNOWN_PART: counts / counts.sum(),
            LOCAL: local / local.sum() if local.sum() else self.blind_shares,
        }

    def count_rooms(self, explored: ExploredPart) -> dict[str, tuple[float, float]]:
        """By baseline the rooms, and those that are corridors, of the whole floor.

        Blind: means of the floors, at least the known rooms. Known part: the known rooms, times known corridors over
        explored ones. Local: one more room for each open end.
        """
        rooms, corridors = len(explored.known_graph), len(explored.corridors)
        sizes = [
            (len(floor.graph), len(skeleton)) for floor, skeleton in zip(self.model.floors, self.skeletons, strict=True)
        ]
        means = np.mean(sizes, axis=0)
        times = corridors / max(corridors - len(explored.open), 1)
        return {
            BLIND: (max(float(means[0]), rooms), max(float(means[1]), corridors)),
            KNOWN_PART: (rooms * times, corridors * times),
            LOCAL: (rooms + explored.open_ends, corridors + len(self._list_corridor_ends(explored))),
        }

    def predict_skeletons(self, explored: ExploredPart) -> dict[str, Sequence[nx.Graph]]:
        """By baseline its skeletons of the whole floor: blind those of all floors, the others one each."""
        skeleton = corridor_subgraph(explored.known_graph, explored.corridors)
        twice = nx.disjoint_union(skeleton, skeleton) if explored.open else skeleton
        indices = {node: index for index, node in enumerate(skeleton)}
        twice = nx.Graph(twice)
        twice.add_edges_from((indices[corridor], indices[corridor] + len(skeleton)) for corridor in explored.open)
        local = nx.Graph(skeleton)
        for end, label in self._list_corridor_ends(explored).items():
            local.add_node(("beyond", end), label=label)
            near = explored.doors.get(end, end)
            if near in skeleton:
                local.add_edge(near, ("beyond", end))
        return {BLIND: self.skeletons, KNOWN_PART: [twice], LOCAL: [local]}

    def _list_corridor_ends(self, explored: ExploredPart) -> dict[int, str]:
        """The open ends at which the most frequent neighbour is a corridor, and its label."""
        labels = self.model.schema.by_name
        predicted = self.predict_ends(explored)
        return {
            end: label
            for end, label in predicted.items()
            if labels[label].room_or_corridor(LabelConvention.GRAPHS) == "CORRIDOR"
        }


def corridor_graph(graph: nx.Graph, schema: LabelSchema) -> nx.Graph:
    """The corridors of a floor and the edges between them."""
    return corridor_subgraph(graph, find_corridors(graph, schema, convention=LabelConvention.GRAPHS))


def corridor_subgraph(graph: nx.Graph, corridors: Collection[Hashable]) -> nx.Graph:
    """The part of a graph that are corridors, in the order of the graph."""
    skeleton = nx.Graph()
    skeleton.add_nodes_from((node, {"label": label}) for node, label in graph.nodes(data="label") if node in corridors)
    skeleton.add_edges_from((one, other) for one, other in graph.edges if one in skeleton and other in skeleton)
    return skeleton
