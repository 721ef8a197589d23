"""Simple predictions of the unknown part of a floor, without the sampler.

All but `blind` know what the sampler knows: the known rooms, the open corridors, the unopened doors, and what was
behind those of the other floors.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass
from functools import cached_property

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.generation.type_model import TypeFloor, TypeModel, count_labels
from pianta.graphs.metrics import find_corridors
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from pianta.labels import LabelConvention, LabelSchema
from pianta.prediction.explored_part import ExploredPart, explore_by_corridors, read_explored_part
from pianta.prediction.label_distributions import find_nearest_distribution
from pianta.prediction.open_ends import OpenEnds, count_labels_of_part

BLIND = "blind"  # the average of the other floors, without the known part
KNOWN_PART = "known part"  # the known part again
LOCAL = "local"  # what was directly behind open ends of rooms with the same label
SIMILAR = "similar stages"  # what was left of other floors, explored about as far
KNOWN_CORRIDORS = "known corridors"  # the known corridors, as if there were no others
ANY_DOOR = "any door"  # what was behind unopened doors of all rooms
BASELINES = (BLIND, KNOWN_PART, LOCAL, SIMILAR, KNOWN_CORRIDORS)
# A corridor is predicted where at least this number of them is expected.
HALF_A_CORRIDOR = 0.5


@dataclass(frozen=True, eq=False)
class Behind:
    """The rooms directly behind an open end of another floor, when it was first seen.

    is_door: otherwise it is an open corridor. near: the label of the room with the door, or of the corridor.
    labels: the number of unknown rooms of each label of the schema, shape (labels,).
    """

    is_door: bool
    near: str
    labels: Floats


@dataclass(frozen=True, eq=False)
class Baselines:
    """Predictions by the other floors of a type, without the sampler. model: of these floors."""

    model: TypeModel

    @cached_property
    def ends(self) -> OpenEnds:
        """The stages of the other floors, with the weights of the sampler."""
        return OpenEnds(self.model)

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
    def behind(self) -> list[Behind]:
        """What was directly behind each open end of the other floors."""
        return [behind for floor in self.model.floors for behind in self._explore(floor)]

    @cached_property
    def blind_shares(self) -> Floats:
        """Mean shares of labels of the floors, shape (labels,)."""
        counts = count_labels([floor.graph for floor in self.model.floors], self.model.schema)
        return np.asarray((counts / counts.sum(axis=1, keepdims=True)).mean(axis=0))

    def predict_doors(self, explored: ExploredPart) -> dict[int, tuple[str | None, str | None]]:
        """For each unopened door the most frequent label behind doors of rooms with the same label, and behind any.

        Of equally frequent labels the one that is more frequent behind any door. None if the other floors have no
        unopened door.
        """
        labels = dict(explored.graph.nodes(data="label"))
        counts = {near: self._sum_behind(near) for near in {None, *(labels[room] for room in explored.doors.values())}}
        total = counts[None]
        names = [*self.model.schema.by_name]
        if not total.any():
            return dict.fromkeys(explored.doors, (None, None))
        most = names[int(total.argmax())]
        # Ties are decided by the smaller term.
        tops = {near: names[int((own + total / (total.sum() + 1)).argmax())] for near, own in counts.items()}
        return {door: (tops[labels[room]], most) for door, room in explored.doors.items()}

    def expect_behind(self, explored: ExploredPart) -> dict[int, Floats]:
        """For each open end the mean number of rooms of each label directly behind such ends, shape (labels,).

        Ends of rooms with the same label, or of all rooms if no other floor has one.
        """
        near = {end: (False, end) for end in explored.open} | {
            door: (True, room) for door, room in explored.doors.items()
        }
        expected = {}
        for end, (is_door, room) in near.items():
            label = explored.graph.nodes[room]["label"]
            ends = [behind for behind in self.behind if behind.is_door == is_door]
            rows = [behind.labels for behind in ends if behind.near == label] or [behind.labels for behind in ends]
            expected[end] = np.mean(rows, axis=0) if rows else np.zeros(len(self.model.schema.by_name))
        return expected

    def predict_shares(self, explored: ExploredPart) -> dict[str, Floats]:
        """By baseline the shares of labels of unknown rooms, shape (labels,); blind where a baseline expects none.

        SIMILAR: the distribution nearest to those of the unknown rooms of similar stages, as the sampler's.
        """
        counts = count_labels_of_part(explored, self.model.schema)
        local = sum(self.expect_behind(explored).values(), np.zeros(len(counts)))
        left, weights = self._list_left(explored)
        used = (left.sum(axis=1) > 0) & (weights > 0)
        return {
            BLIND: self.blind_shares,
            KNOWN_PART: counts / counts.sum(),
            LOCAL: local / local.sum() if local.sum() else self.blind_shares,
            SIMILAR: find_nearest_distribution(left[used] * weights[used, None]) if used.any() else self.blind_shares,
        }

    def count_rooms(self, explored: ExploredPart) -> dict[str, tuple[float, float]]:
        """By baseline the rooms, and those that are corridors, of the whole floor.

        Blind: means of the floors, at least the known rooms. Known part: the known rooms, times known corridors over
        explored ones. Local: the known rooms and those expected directly behind open ends. Similar: the known rooms and
        the mean of those left at similar stages.
        """
        rooms, corridors = len(explored.known_graph), len(explored.corridors)
        sizes = [
            (len(floor.graph), len(skeleton)) for floor, skeleton in zip(self.model.floors, self.skeletons, strict=True)
        ]
        means = np.mean(sizes, axis=0)
        times = corridors / max(corridors - len(explored.open), 1)
        local = sum(self.expect_behind(explored).values(), np.zeros(len(self.model.schema.by_name)))
        left, weights = self._list_left(explored)
        similar = weights @ left
        return {
            BLIND: (max(float(means[0]), rooms), max(float(means[1]), corridors)),
            KNOWN_PART: (rooms * times, corridors * times),
            LOCAL: (rooms + float(local.sum()), corridors + float(local @ self._are_corridors)),
            SIMILAR: (rooms + float(similar.sum()), corridors + float(similar @ self._are_corridors)),
        }

    def predict_skeletons(self, explored: ExploredPart) -> dict[str, Sequence[nx.Graph]]:
        """By baseline its skeletons of the whole floor: blind those of all floors, the others one each."""
        skeleton = corridor_subgraph(explored.known_graph, explored.corridors)
        twice = nx.disjoint_union(skeleton, skeleton) if explored.open else skeleton
        indices = {node: index for index, node in enumerate(skeleton)}
        twice = nx.Graph(twice)
        twice.add_edges_from((indices[corridor], indices[corridor] + len(skeleton)) for corridor in explored.open)
        local = nx.Graph(skeleton)
        names = [*self.model.schema.by_name]
        for end, expected in self.expect_behind(explored).items():
            corridors = expected * self._are_corridors
            if corridors.sum() < HALF_A_CORRIDOR:
                continue
            local.add_node(("beyond", end), label=names[int(corridors.argmax())])
            near = explored.doors.get(end, end)
            if near in skeleton:
                local.add_edge(near, ("beyond", end))
        return {BLIND: self.skeletons, KNOWN_PART: [twice], LOCAL: [local], KNOWN_CORRIDORS: [skeleton]}

    @cached_property
    def _are_corridors(self) -> Floats:
        """1 for each label of the schema that is a corridor, else 0, shape (labels,)."""
        labels = self.model.schema.by_name.values()
        return np.array([float(label.room_or_corridor(LabelConvention.GRAPHS) == "CORRIDOR") for label in labels])

    @cached_property
    def _left(self) -> Floats:
        """Rooms of each label that are unknown at each stage of the other floors, shape (stages, labels)."""
        totals = count_labels([floor.graph for floor in self.model.floors], self.model.schema)
        return np.array([totals[stage.floor] - stage.labels for stage in self.ends.stages])

    def _list_left(self, explored: ExploredPart) -> tuple[Floats, Floats]:
        """The unknown rooms of each stage of other floors, and the weights of the stages, those of the sampler."""
        return self._left, self.ends.stage_weights(explored)

    def _sum_behind(self, near: str | None) -> Floats:
        """Labels behind the doors of rooms with a label, or of all rooms, shape (labels,)."""
        rows = [behind.labels for behind in self.behind if behind.is_door and near in (None, behind.near)]
        return np.sum(rows, axis=0) if rows else np.zeros(len(self.model.schema.by_name))

    def _explore(self, floor: TypeFloor) -> list[Behind]:
        """Explore a floor by corridors: what is directly behind each open end, at the first stage that has it."""
        schema = self.model.schema
        corridors = find_corridors(floor.graph, schema, convention=LabelConvention.GRAPHS)
        first: dict[Hashable, Behind] = {}
        for stage in explore_by_corridors(floor.graph, corridors):
            explored = read_explored_part(stage, schema)
            names = dict(explored.graph.nodes(data="room"))
            known_rooms = {names[node] for node in explored.known_graph}
            ends = [(names[end], names[end], {*floor.graph[names[end]]} - known_rooms) for end in explored.open]
            for door, room in explored.doors.items():
                ends.append((names[door], names[room], {int(str(names[door]).split("-")[1])}))
            for name, room, behind in ends:
                (labels,) = count_labels([floor.graph.subgraph(behind)], schema).astype(float)
                label = floor.graph.nodes[room]["label"]
                first.setdefault(name, Behind(name != room, label, labels))
        return [*first.values()]


def corridor_graph(graph: nx.Graph, schema: LabelSchema) -> nx.Graph:
    """The corridors of a floor and the edges between them."""
    return corridor_subgraph(graph, find_corridors(graph, schema, convention=LabelConvention.GRAPHS))


def corridor_subgraph(graph: nx.Graph, corridors: Collection[Hashable]) -> nx.Graph:
    """The part of a graph that are corridors, in the order of the graph."""
    skeleton = nx.Graph()
    skeleton.add_nodes_from((node, {"label": label}) for node, label in graph.nodes(data="label") if node in corridors)
    skeleton.add_edges_from((one, other) for one, other in graph.edges if one in skeleton and other in skeleton)
    return skeleton
