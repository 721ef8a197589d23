"""Samples of a partly explored floor: the known part is fixed, the rest is sampled (thesis, section 8.3).

The four steps of section 7.4.3 with fixed known rooms and doors. Each unopened door leads to a room, and each open
corridor belongs to a functional area.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.generation.cut_potentials import CutPotentials
from pianta.generation.functional_areas import Area
from pianta.generation.functional_graph import FunctionalGraphs, sample_functional_graphs
from pianta.generation.incremental_gram import ReferenceGraphs
from pianta.generation.node_connections import ConnectedBuilding, NodeConnections, connect_areas
from pianta.generation.type_model import TypeModel, area_subgraph, count_labels, size_attribute
from pianta.graphs.metrics import find_corridors
from pianta.labels import LabelConvention
from pianta.prediction.area_plan import AreaPlan, NewArea, plan_areas, segment_known_rooms
from pianta.prediction.explored_part import ExploredPart
from pianta.prediction.open_ends import DoorExample, OpenEnds, find_hub
from pianta.prediction.similar_doors import SimilarDoors

# Probability that an area is of a random cluster, not of that of the similar floor. Chosen by hand.
P_RANDOM_CLUSTER = 0.2
# All doors of corridors, or of other rooms, weigh as much as this many floors with doors of the same label. By hand.
PRIOR_FLOORS = 5.0
# Moves of steps 2 and 4; fewer than without an explored part, which leaves few free edges and doors. Chosen by hand.
EDGE_MOVES = 200
DOOR_MOVES = 10


@dataclass(frozen=True, eq=False)
class SampledFloor:
    """A whole floor around an explored part.

    graph: nodes 0 … n - 1 with `label`, and `area`, m², if the model or the explored part has it. known_nodes: the node
    of each known room, by its node in the explored part. behind: the node behind each unopened door, by the unknown
    room; few samples lack one.
    """

    graph: nx.Graph
    known_nodes: dict[int, int]
    behind: dict[int, int]

    @cached_property
    def unseen(self) -> list[int]:
        """The nodes of rooms that are not known."""
        known_nodes = {*self.known_nodes.values()}
        return [node for node in self.graph if node not in known_nodes]


class FloorSampler:
    """Samples floors around explored parts; the data of the model is computed once.

    label_shares: label -> mean share of the rooms of a floor of the model. edge_moves, door_moves: of steps 2 and 4.
    closed: known rooms have no doors but those of the explored part.
    Raises OptionError for a model by `ncut`, ModelError for one without corridors.
    """

    edge_moves = EDGE_MOVES
    door_moves = DOOR_MOVES
    closed = True

    def __init__(self, model: TypeModel) -> None:
        self.model = model
        self.ends = OpenEnds(model)
        self.functional_references = ReferenceGraphs([floor.functional_graph for floor in model.floors])
        self.references = ReferenceGraphs([floor.graph for floor in model.floors])
        self.new_areas = [
            NewArea(area_subgraph(floor.graph, area), find_hub(floor.graph, area, corridors), str(cluster))
            for floor in model.floors
            for corridors in [find_corridors(floor.graph, model.schema, convention=LabelConvention.GRAPHS)]
            for area, cluster in zip(floor.areas, floor.clusters, strict=True)
        ]
        self._firsts = np.cumsum([0, *(len(floor.areas) for floor in model.floors)]).tolist()
        shares = count_labels([floor.graph for floor in model.floors], model.schema).astype(float)
        shares /= shares.sum(axis=1, keepdims=True)
        self.label_shares = dict(zip(model.schema.by_name, shares.mean(axis=0).tolist(), strict=True))

    @cached_property
    def potentials(self) -> CutPotentials:
        """Φ of step 4."""
        return CutPotentials(self.model)

    @cached_property
    def doors(self) -> SimilarDoors:
        """What was behind the doors of the model."""
        return SimilarDoors(self.ends.examples, self.model.schema)

    @property
    def door_counts(self) -> list[int]:
        """From which the number of doors of an edge between areas is drawn."""
        return self.model.door_counts

    def sample(
        self,
        explored: ExploredPart,
        numbers: Sequence[int],
        *,
        seed: int = 0,
        edge_moves: int | None = None,
        door_moves: int | None = None,
    ) -> list[SampledFloor]:
        """Sample the floors with these numbers, from 0; a floor depends only on its number and the seed.

        edge_moves, door_moves: instead of those of the sampler.
        """
        generators = [np.random.default_rng((seed, number)) for number in numbers]
        known_areas = segment_known_rooms(explored)
        areas = [area_subgraph(explored.graph, area) for area in known_areas]
        clusters = self.model.assign_clusters(areas)
        # Steps 1 and 3: the number of unexplored functional areas, their clusters, and the areas.
        plans = self.plan_floors(explored, known_areas, clusters, generators)
        # Step 2: the edges between areas; those between known areas are fixed.
        starts = [plan.start(generator) for plan, generator in zip(plans, generators, strict=True)]
        chains = FunctionalGraphs(self.functional_references, starts, n_fixed=len(known_areas), closed=self.closed)
        moves = self.edge_moves if edge_moves is None else edge_moves
        graphs = sample_functional_graphs(chains, generators, moves=moves)
        # Step 4: the doors of these edges; known doors are fixed, unopened ones at one end.
        buildings, opened = [], []
        for plan, start, graph, generator in zip(plans, starts, graphs, generators, strict=True):
            self.restore_edges(plan, graph, generator)
            graph.add_edges_from((edge for edge in start.edges if start.edges[edge].get("known")), cuts=0)
            building, doors = plan.build(graph, self.door_counts, generator)
            buildings.append(building)
            opened.append(doors)
        fixed = len(known_areas)
        connections = NodeConnections(self.references, buildings, graphs, self.potentials, generators, n_fixed=fixed)
        connect_areas(connections, moves=self.door_moves if door_moves is None else door_moves)
        return [_finish(*parts) for parts in zip(plans, buildings, opened, strict=True)]

    def plan_floors(
        self,
        explored: ExploredPart,
        known_areas: Sequence[Area],
        clusters: Sequence[int],
        generators: Sequence[np.random.Generator],
    ) -> list[AreaPlan]:
        """Steps 1 and 3 of each floor. clusters: of the known areas."""
        weights = self.ends.stage_weights(explored)
        names = [*map(str, clusters)]
        return [self._plan(explored, known_areas, names, weights, generator) for generator in generators]

    def restore_edges(self, plan: AreaPlan, graph: nx.Graph, generator: np.random.Generator) -> None:
        """Restore edges between areas that step 2 may not lose; none here, because step 2 loses none of them."""

    def _plan(
        self,
        explored: ExploredPart,
        known_areas: Sequence[Area],
        clusters: Sequence[str],
        weights: Floats,
        generator: np.random.Generator,
    ) -> AreaPlan:
        """Steps 1 and 3 of one floor: the areas of a floor at a similar stage, and the rooms behind doors."""
        number = np.searchsorted(np.cumsum(weights), generator.random()).clip(0, len(weights) - 1)
        stage = self.ends.stages[int(number)]
        chosen = [self._draw_area(self._firsts[stage.floor] + area, generator) for area in stage.areas]
        if not explored.open_ends:
            chosen = []
        leads_on = bool(chosen or explored.open)
        branches = {
            door: self._draw_branch(
                explored.graph.nodes[near]["label"],
                is_corridor=near in explored.corridors,
                leads_on=leads_on and near not in explored.open,
                generator=generator,
            )
            for door, near in explored.doors.items()
        }
        if chosen and not explored.open and None not in branches.values():
            branches[[*branches][int(generator.integers(len(branches)))]] = None
        return plan_areas(explored, known_areas, clusters, chosen=chosen, branches=branches, generator=generator)

    def _draw_area(self, area: int, generator: np.random.Generator) -> NewArea:
        """An area that replaces one of the model: of the same cluster, or sometimes of a random one."""
        clusters = self.model.clusters
        cluster = clusters[area]
        if generator.random() < P_RANDOM_CLUSTER:
            cluster = clusters[int(generator.integers(len(clusters)))]
        members = np.flatnonzero(clusters == cluster)
        return self.new_areas[int(members[int(generator.integers(len(members)))])]

    def _draw_branch(
        self, label: str, *, is_corridor: bool, leads_on: bool, generator: np.random.Generator
    ) -> nx.Graph | None:
        """The rooms of the same area behind a door of a room with this label; None for a door to another area."""
        # First a floor, then one of its doors, because doors of one floor resemble each other.
        floors = self.ends.by_label.get(label, [])
        has_label = generator.random() * (len(floors) + PRIOR_FLOORS) < len(floors)
        alike = self.ends.at_corridors if is_corridor else self.ends.at_rooms
        examples = floors[int(generator.integers(len(floors)))] if has_label else alike
        if not leads_on:
            examples = _list_closed(examples) or _list_closed(alike)
        if not examples:
            return None if leads_on else self._draw_room(generator)
        return examples[int(generator.integers(len(examples)))].branch

    def _draw_room(self, generator: np.random.Generator) -> nx.Graph:
        """A room of the model at a corridor; for a model without examples of closed doors."""
        area = self.new_areas[int(generator.integers(len(self.new_areas)))]
        rooms = [node for node in area.graph if node != area.hub] or [area.hub]
        return area_subgraph(area.graph, frozenset({rooms[int(generator.integers(len(rooms)))]}))


def _list_closed(examples: Sequence[DoorExample]) -> list[DoorExample]:
    """The doors behind which the same area continues."""
    return [example for example in examples if example.branch is not None]


def _finish(plan: AreaPlan, building: ConnectedBuilding, opened: dict[tuple[int, int], list[int]]) -> SampledFloor:
    """The sampled floor, with its known rooms and the rooms behind doors."""
    numbers, explored = plan.number_rooms(), plan.explored
    behind = {door: numbers[door] for door in explored.doors if door in numbers}
    for edge, doors in opened.items():
        pairs = building.doors.get(edge, [])
        behind |= {door: far for door, (_, far) in zip(doors, pairs, strict=False)}
    graph = building.to_graph()
    for part in plan.areas:
        sizes = {numbers[node]: size_attribute(attributes) for node, attributes in part.nodes(data=True)}
        nx.set_node_attributes(graph, sizes)
    return SampledFloor(graph, {node: numbers[node] for node in explored.known_graph}, behind)
