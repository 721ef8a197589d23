"""What was behind the open ends of the floors of a model, each explored by corridors as in section 8.3.

The open ends, discovered corridors and unopened doors, predict how many functional areas are left on a floor, and of
which clusters. The thesis only has lower bounds of the areas of each cluster; here they are drawn from floors of the
model at a similar stage of exploration.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Hashable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.errors import ModelError, OptionError
from pianta.evaluation.prediction import measure_divergence
from pianta.generation.functional_areas import Area, Segmentation
from pianta.generation.type_model import TypeFloor, TypeModel, area_subgraph
from pianta.graphs.metrics import find_corridors
from pianta.labels import LabelConvention, LabelSchema
from pianta.prediction.explored_part import ExploredPart, explore_by_corridors, read_explored_part

# Width of the kernel over logarithms of the weights of open corridors and of the number of doors. Chosen by hand.
OPENNESS_WIDTH = 0.5
# Open corridors of all labels together weigh as much as this many of one label. Chosen by hand.
PRIOR_CORRIDORS = 2.0
# An open corridor counts as explored if at least this share of those with its label had nothing behind. Chosen by hand.
DEAD_END_SHARE = 0.75
# Width of the kernel over divergences of label distributions, bits. Chosen by hand.
LABEL_WIDTH = 0.2


@dataclass(frozen=True, eq=False)
class Stage:
    """A floor of the model, explored in part.

    floor: its index in the model. open: the labels of its open corridors. doors: number of unopened doors. labels:
    number of known rooms of each label of the schema. areas: indices of the functional areas whose corridor is
    unexplored.
    """

    floor: int
    open: tuple[str, ...]
    doors: int
    labels: Floats
    areas: tuple[int, ...]


@dataclass(frozen=True)
class CorridorExample:
    """What was behind an open corridor when it was discovered.

    label: of the corridor. rooms: number of unknown rooms directly behind it. corridors: how many of these are
    corridors.
    """

    label: str
    rooms: int
    corridors: int


@dataclass(frozen=True, eq=False)
class DoorExample:
    """What was behind an unopened door of a room.

    near: the label of that room. branch: the rooms behind the door, the one at the door first, if they belong to the
    area of an explored corridor; None if the door leads to another area. far: the label of the room behind the door.
    area: of the room with the door, m², None if unknown. labels: number of known rooms of each label of the schema when
    the door was first seen.
    """

    floor: int
    near: str
    branch: nx.Graph | None
    far: str
    area: float | None
    labels: Floats


class OpenEnds:
    """Stages of all floors of a model, and what was behind their doors.

    Raises OptionError for a model by `ncut`, because only areas around corridors are either explored or not (8.3), and
    ModelError if no floor has a corridor.
    """

    def __init__(self, model: TypeModel) -> None:
        if model.segmentation is not Segmentation.CORR:
            raise OptionError(
                f"the model has areas by {model.segmentation}, prediction needs areas by corr; train it with these"
            )
        self.model = model
        self.stages: list[Stage] = []
        self.examples: list[DoorExample] = []
        self.corridors: list[CorridorExample] = []
        for number, floor in enumerate(model.floors):
            self._explore(number, floor)
        if not self.stages:
            raise ModelError("no floor of the model has a corridor, train it on floors with corridors")

    @cached_property
    def by_label(self) -> Mapping[str, list[list[DoorExample]]]:
        """The examples by the label of the room with the door, grouped by floor."""
        groups: dict[str, dict[int, list[DoorExample]]] = {}
        for example in self.examples:
            groups.setdefault(example.near, {}).setdefault(example.floor, []).append(example)
        return {label: [*by_floor.values()] for label, by_floor in groups.items()}

    def stage_weights(self, explored: ExploredPart) -> Floats:
        """Similarity of an explored part to each stage, shape (stages,), sum 1; each floor counts the same."""
        labels = count_labels_of_part(explored, self.model.schema)
        rows = np.array([stage.labels for stage in self.stages])
        divergence = measure_divergence(rows / rows.sum(axis=1, keepdims=True), labels / labels.sum())
        openness = np.log1p([[self.weigh_corridors(stage.open), stage.doors] for stage in self.stages])
        open_labels = [explored.graph.nodes[corridor]["label"] for corridor in explored.open]
        gaps = openness - np.log1p([self.weigh_corridors(open_labels), len(explored.doors)])
        stages_of_floor = Counter(stage.floor for stage in self.stages)
        exponents = -(gaps**2).sum(axis=1) / (2 * OPENNESS_WIDTH**2) - divergence / LABEL_WIDTH
        weights = np.exp(exponents - exponents.max()) / [stages_of_floor[stage.floor] for stage in self.stages]
        normalised: Floats = weights / weights.sum()
        return normalised

    def weigh_corridors(self, labels: Iterable[str]) -> float:
        """The number of open corridors with these labels, each weighted by how many corridors are behind its like.

        The weight is relative to the mean of all labels: an ENTRANCE, which seldom leads on, counts less than a HALL.
        """
        every = float(np.mean([example.corridors for example in self.corridors] or [0.0]))
        if not every:
            return float(len([*labels]))
        weights = 0.0
        for label in labels:
            own = self._by_corridor_label.get(label, [])
            total = sum(example.corridors for example in own)
            weights += (total / every + PRIOR_CORRIDORS) / (len(own) + PRIOR_CORRIDORS)
        return weights

    def is_dead_end(self, label: str) -> bool:
        """Whether nothing is expected behind an open corridor with this label, as behind most ENTRANCEs."""
        own = self._by_corridor_label.get(label, [])
        # One example of each kind as prior (Laplace).
        return (sum(not example.rooms for example in own) + 1) / (len(own) + 2) >= DEAD_END_SHARE

    @cached_property
    def _by_corridor_label(self) -> Mapping[str, list[CorridorExample]]:
        groups: dict[str, list[CorridorExample]] = {}
        for example in self.corridors:
            groups.setdefault(example.label, []).append(example)
        return groups

    def _explore(self, number: int, floor: TypeFloor) -> None:
        """Add the stages of a floor, explored by corridors, and the examples of its doors; number: of the floor."""
        schema = self.model.schema
        corridors = find_corridors(floor.graph, schema, convention=LabelConvention.GRAPHS)
        area_of = {node: index for index, area in enumerate(floor.areas) for node in area}
        hubs = [find_hub(floor.graph, area, corridors) for area in floor.areas]
        opened: set[str] = set()
        discovered: set[Hashable] = set()
        for stage in explore_by_corridors(floor.graph, corridors):
            explored = read_explored_part(stage, schema)
            closed = {explored.graph.nodes[node]["room"] for node in explored.closed}
            areas = tuple(index for index, hub in enumerate(hubs) if hub not in closed)
            labels = count_labels_of_part(explored, schema)
            open_labels = tuple(explored.graph.nodes[corridor]["label"] for corridor in explored.open)
            self.stages.append(Stage(number, open_labels, len(explored.doors), labels, areas))
            self._add_corridors(floor.graph, explored, corridors, discovered)
            # A door that is unopened in several stages is one example.
            for name in [name for name in stage if isinstance(name, str) and name not in opened]:
                opened.add(name)
                near, far = map(int, name.split("-"))
                is_other = area_of[far] in areas
                branch = None if is_other else extract_branch(floor.graph, floor.areas[area_of[far]] - closed, far)
                room, behind = floor.graph.nodes[near], floor.graph.nodes[far]["label"]
                self.examples.append(DoorExample(number, room["label"], branch, behind, room.get("area"), labels))

    def _add_corridors(
        self, graph: nx.Graph, explored: ExploredPart, corridors: Collection[Hashable], discovered: set[Hashable]
    ) -> None:
        """Add the open corridors of a stage as examples; discovered: those of earlier stages, gets these."""
        names = dict(explored.graph.nodes(data="room"))
        known = {names[node] for node in explored.known_graph}
        for room in (names[corridor] for corridor in explored.open):
            if room not in discovered:
                discovered.add(room)
                behind = [near for near in graph[room] if near not in known]
                onward = sum(near in corridors for near in behind)
                self.corridors.append(CorridorExample(graph.nodes[room]["label"], len(behind), onward))


def find_hub(graph: nx.Graph, area: Area, corridors: Collection[Hashable]) -> int:
    """The node of an area with most doors; a corridor if it has one."""
    return max(sorted(area), key=lambda node: (node in corridors, graph.degree(node)))


def extract_branch(graph: nx.Graph, rooms: Area, first: int) -> nx.Graph:
    """The subgraph of the rooms that are connected to a node through these rooms, that node first."""
    part = area_subgraph(graph, frozenset(nx.node_connected_component(graph.subgraph(rooms), first)))
    branch = nx.Graph()
    branch.add_node(first, **part.nodes[first])
    branch.add_nodes_from(part.nodes(data=True))
    branch.add_edges_from(part.edges)
    return branch


def count_labels_of_part(explored: ExploredPart, schema: LabelSchema) -> Floats:
    """Number of known rooms of each label of a schema, shape (labels,)."""
    counts = Counter(label for _, label in explored.known_graph.nodes(data="label"))
    return np.array([counts[label] for label in schema.by_name], float)
