"""What lay behind the open ends of the floors of a model, each explored by corridors as section 8.3 has it.

How many functional areas a floor still has, and which, is told by how it goes on: by the corridors that are discovered
and not explored, and the doors that nobody has opened. What the thesis bounds from below, the areas of each cluster, is
here drawn from floors of the model that were explored as far.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.errors import ModelError, OptionError
from pianta.evaluation.prediction import measure_divergence
from pianta.generation.functional_areas import Area, Segmentation
from pianta.generation.type_model import TypeFloor, TypeModel, take_area
from pianta.graphs.metrics import find_corridors
from pianta.labels import LabelConvention, LabelSchema
from pianta.prediction.explored_part import ExploredPart, explore_by_corridors, read_explored_part

# Width of the kernel over logarithms of the numbers of open corridors and of doors.
OPENNESS_WIDTH = 0.5
# Width of the kernel over divergences of label distributions, bits.
LABEL_WIDTH = 0.2


@dataclass(frozen=True, eq=False)
class Stage:
    """A floor of the model, explored in part.

    floor: its place in the model. open, doors: its open corridors and unopened doors. labels: how often each label of
    the schema is known. areas: the places on the floor of functional areas whose corridor is unexplored.
    """

    floor: int
    open: int
    doors: int
    labels: Floats
    areas: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class DoorExample:
    """What was behind an unopened door of a room.

    near: the label of that room. branch: the rooms behind it when they belong to the area of an explored corridor, the
    first node the one at the door; None where the door led to another area.
    """

    floor: int
    near: str
    branch: nx.Graph | None


class OpenEnds:
    """Stages of all floors of a model, and what their doors led to.

    Raises OptionError for a model by `ncut`: it takes areas with corridors to say whether they are explored (8.3);
    ModelError where no floor has a corridor.
    """

    def __init__(self, model: TypeModel) -> None:
        if model.segmentation is not Segmentation.CORR:
            raise OptionError(f"the model has areas by {model.segmentation}, prediction takes one by corr; train it so")
        self.model = model
        self.stages: list[Stage] = []
        self.examples: list[DoorExample] = []
        for number, floor in enumerate(model.floors):
            self._explore(number, floor)
        if not self.stages:
            raise ModelError("no floor of the model has a corridor, train it on floors with corridors")

    @cached_property
    def by_label(self) -> Mapping[str, list[list[DoorExample]]]:
        """The examples by the label of the room whose door it is, those of a floor together."""
        found: dict[str, dict[int, list[DoorExample]]] = {}
        for example in self.examples:
            found.setdefault(example.near, {}).setdefault(example.floor, []).append(example)
        return {label: [*of_floors.values()] for label, of_floors in found.items()}

    def weigh_stages(self, explored: ExploredPart) -> Floats:
        """How much like a stage the explored part of a floor is, shape (stages,), the sum 1; floors count alike."""
        labels = count_known_labels(explored, self.model.schema)
        rows = np.array([stage.labels for stage in self.stages])
        divergence = measure_divergence(rows / rows.sum(axis=1, keepdims=True), labels / labels.sum())
        openness = np.log1p([[stage.open, stage.doors] for stage in self.stages])
        apart = openness - np.log1p([len(explored.open), len(explored.doors)])
        of_floor = Counter(stage.floor for stage in self.stages)
        exponents = -(apart**2).sum(axis=1) / (2 * OPENNESS_WIDTH**2) - divergence / LABEL_WIDTH
        weights = np.exp(exponents - exponents.max()) / [of_floor[stage.floor] for stage in self.stages]
        normalised: Floats = weights / weights.sum()
        return normalised

    def _explore(self, number: int, floor: TypeFloor) -> None:
        schema = self.model.schema
        corridors = find_corridors(floor.graph, schema, convention=LabelConvention.GRAPHS)
        area_of = {node: place for place, area in enumerate(floor.areas) for node in area}
        hubs = [find_hub(floor.graph, area, corridors) for area in floor.areas]
        opened: set[str] = set()
        for stage in explore_by_corridors(floor.graph, corridors):
            explored = read_explored_part(stage, schema)
            closed = {explored.graph.nodes[node]["room"] for node in explored.closed}
            areas = tuple(place for place, hub in enumerate(hubs) if hub not in closed)
            self.stages.append(
                Stage(
                    number,
                    len(explored.open),
                    len(explored.doors),
                    count_known_labels(explored, schema),
                    areas,
                )
            )
            # A door that stays closed for several stages is one example.
            for name in [name for name in stage if isinstance(name, str) and name not in opened]:
                opened.add(name)
                near, far = map(int, name.split("-"))
                is_other = area_of[far] in areas
                branch = None if is_other else take_branch(floor.graph, floor.areas[area_of[far]] - closed, far)
                self.examples.append(DoorExample(number, floor.graph.nodes[near]["label"], branch))


def find_hub(graph: nx.Graph, area: Area, corridors: Collection[Hashable]) -> int:
    """The node with most doors of an area, a corridor where it has one."""
    return max(sorted(area), key=lambda node: (node in corridors, graph.degree(node)))


def take_branch(graph: nx.Graph, rooms: Area, first: int) -> nx.Graph:
    """The part of a graph that is joined to a node within some rooms, that node first."""
    part = nx.node_connected_component(graph.subgraph(rooms), first)
    found = take_area(graph, frozenset(part))
    branch = nx.Graph()
    branch.add_node(first, **found.nodes[first])
    branch.add_nodes_from(found.nodes(data=True))
    branch.add_edges_from(found.edges)
    return branch


def count_known_labels(explored: ExploredPart, schema: LabelSchema) -> Floats:
    """How many known rooms of each label of a schema there are, shape (labels,)."""
    counts = Counter(label for _, label in explored.known.nodes(data="label"))
    return np.array([counts[label] for label in schema.by_name], float)
