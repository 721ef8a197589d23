"""What was behind the open ends of the floors of a model, each explored by corridors as in section 8.3.

The open ends, discovered corridors and unopened doors, predict how many functional areas are left on a floor, and of
which clusters. The thesis only has lower bounds of the areas of each cluster; here they are drawn from floors of the
model at a similar stage of exploration.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

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

# Width of the kernel over logarithms of the numbers of open corridors, doors of rooms and doors of corridors. By hand.
OPENNESS_WIDTH = 0.5
# Width of the kernel over divergences of label distributions, bits. Chosen by hand.
LABEL_WIDTH = 0.2


class EndCounts(NamedTuple):
    """Number of open corridors, of unopened doors of rooms, and of those of corridors."""

    open: int
    doors: int
    corridor_doors: int


@dataclass(frozen=True, eq=False)
class Stage:
    """A floor of the model, explored in part.

    floor: its index in the model. open, doors, corridor_doors: as of EndCounts. labels: number of known rooms of each
    label of the schema. areas: indices of the functional areas whose corridor is unexplored.
    """

    floor: int
    open: int
    doors: int
    corridor_doors: int
    labels: Floats
    areas: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class DoorExample:
    """What was behind an unopened door of a room.

    near: the label of that room. branch: the rooms behind the door, the one at the door first, if they belong to the
    area of an explored corridor; None if the door leads to another area. far: the label of the room behind the door.
    area: of the room with the door, m², None if unknown. labels: number of known rooms of each label of the schema when
    the door was first seen. is_corridor: whether the room with the door is a corridor.
    """

    floor: int
    near: str
    branch: nx.Graph | None
    far: str
    area: float | None
    labels: Floats
    is_corridor: bool = False


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
        for number, floor in enumerate(model.floors):
            self._explore(number, floor)
        if not self.stages:
            raise ModelError("no floor of the model has a corridor, train it on floors with corridors")

    @cached_property
    def at_corridors(self) -> list[DoorExample]:
        """The examples of doors of corridors; of all doors without any."""
        return [example for example in self.examples if example.is_corridor] or self.examples

    @cached_property
    def at_rooms(self) -> list[DoorExample]:
        """The examples of doors of other rooms; of all doors without any."""
        return [example for example in self.examples if not example.is_corridor] or self.examples

    @cached_property
    def by_label(self) -> Mapping[str, list[list[DoorExample]]]:
        """The examples by the label of the room with the door, grouped by floor."""
        groups: dict[str, dict[int, list[DoorExample]]] = {}
        for example in self.examples:
            groups.setdefault(example.near, {}).setdefault(example.floor, []).append(example)
        return {label: [*by_floor.values()] for label, by_floor in groups.items()}

    def stage_weights(self, explored: ExploredPart) -> Floats:
        """Similarity of an explored part to each stage, shape (stages,), sum 1; each floor counts the same."""
        labels, counts = count_labels_of_part(explored, self.model.schema), _count_open_ends(explored)
        # Where the rooms behind doors of corridors are not known, floors count as they were at this point
        is_alike = np.array([bool(stage.corridor_doors) == bool(counts.corridor_doors) for stage in self.stages])
        is_alike |= not is_alike.any()
        stages = [stage for stage, is_used in zip(self.stages, is_alike, strict=True) if is_used]
        rows = np.array([stage.labels for stage in stages])
        divergence = measure_divergence(rows / rows.sum(axis=1, keepdims=True), labels / labels.sum())
        openness = np.log1p([[stage.open, stage.doors, stage.corridor_doors] for stage in stages])
        gaps = openness - np.log1p(counts)
        exponents = -(gaps**2).sum(axis=1) / (2 * OPENNESS_WIDTH**2) - divergence / LABEL_WIDTH
        stages_of_floor = Counter(stage.floor for stage in stages)
        weights = np.exp(exponents - exponents.max()) / [stages_of_floor[stage.floor] for stage in stages]
        normalised = np.zeros(len(self.stages))
        normalised[is_alike] = weights / weights.sum()
        return normalised

    def _explore(self, number: int, floor: TypeFloor) -> None:
        """Add the stages of a floor, explored by corridors, and the examples of its doors; number: of the floor."""
        corridors = find_corridors(floor.graph, self.model.schema, convention=LabelConvention.GRAPHS)
        hubs = [find_hub(floor.graph, area, corridors) for area in floor.areas]
        opened: set[str] = set()
        for stage in explore_by_corridors(floor.graph, corridors):
            self._add_stage(number, hubs, [*stage], read_explored_part(stage, self.model.schema), opened)
        # Robots see the doors of a corridor before the rooms behind them
        for stage in explore_by_corridors(floor.graph, corridors, corridors_first=True):
            explored = read_explored_part(stage, self.model.schema)
            if _count_open_ends(explored).corridor_doors:
                self._add_stage(number, hubs, [*stage], explored, opened)

    def _add_stage(
        self, number: int, hubs: Sequence[int], names: Sequence[Hashable], explored: ExploredPart, opened: set[str]
    ) -> None:
        """Add a stage of a floor, and the examples of its doors that are not in `opened`, which gets them.

        names: of its rooms, known and unknown, in the order in which examples are added. Where rooms behind doors of
        corridors are not known, only these doors are examples.
        """
        floor = self.model.floors[number]
        closed = {explored.graph.nodes[node]["room"] for node in explored.closed}
        areas = tuple(index for index, hub in enumerate(hubs) if hub not in closed)
        area_of = {node: index for index, area in enumerate(floor.areas) for node in area}
        labels, counts = count_labels_of_part(explored, self.model.schema), _count_open_ends(explored)
        self.stages.append(Stage(number, *counts, labels, areas))
        near_of = {explored.graph.nodes[door]["room"]: room for door, room in explored.doors.items()}
        # A door that is unopened in several stages is one example
        for name in [str(name) for name in names if name in near_of and name not in opened]:
            is_corridor = near_of[name] in explored.corridors
            if is_corridor != bool(counts.corridor_doors):
                continue
            opened.add(name)
            far = int(name.split("-")[1])
            is_other = area_of[far] in areas
            branch = None if is_other else extract_branch(floor.graph, floor.areas[area_of[far]] - closed, far)
            near, behind = explored.graph.nodes[near_of[name]], floor.graph.nodes[far]["label"]
            self.examples.append(
                DoorExample(number, near["label"], branch, behind, near.get("area"), labels, is_corridor)
            )


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


def _count_open_ends(explored: ExploredPart) -> EndCounts:
    at_corridors = sum(room in explored.corridors for room in explored.doors.values())
    return EndCounts(len(explored.open), len(explored.doors) - at_corridors, at_corridors)


def count_labels_of_part(explored: ExploredPart, schema: LabelSchema) -> Floats:
    """Number of known rooms of each label of a schema, shape (labels,)."""
    counts = Counter(label for _, label in explored.known_graph.nodes(data="label"))
    return np.array([counts[label] for label in schema.by_name], float)
