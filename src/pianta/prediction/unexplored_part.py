"""Samples of a floor that is explored in part: what is known stays, what lies beyond is sampled (thesis, section 8.3).

The four steps of section 7.4.3, with the known rooms and doors fixed. Each unopened door leads somewhere, and each open
corridor is that of a functional area.
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
from pianta.generation.gram_rows import References
from pianta.generation.node_connections import ConnectedBuilding, NodeConnections, connect_areas
from pianta.generation.type_model import TypeModel, count_labels, take_area, take_size
from pianta.graphs.graph_hopper import GraphHopper
from pianta.graphs.metrics import find_corridors
from pianta.labels import LabelConvention
from pianta.prediction.explored_part import ExploredPart
from pianta.prediction.known_areas import AreaPlan, NewArea, plan_areas, segment_known_rooms
from pianta.prediction.open_ends import DoorExample, OpenEnds, find_hub

# How often an area is of any cluster, not of that of the floor that the explored part is like.
EXCHANGE = 0.2
# Doors of rooms of any label count as so many floors with doors of the label of the room.
PRIOR_FLOORS = 5.0
# Iterations of steps 2 and 4: what is known leaves little to move.
EDGE_MOVES, DOOR_MOVES = 200, 10


@dataclass(frozen=True, eq=False)
class SampledFloor:
    """A whole floor around an explored part.

    graph: nodes 0 … n - 1 with `label`, and `area`, m², where the model or the explored part has it. known: the node of
    each known room, by its node in the explored part. behind: the node that each unopened door leads to, by the unknown
    room; few samples lack one.
    """

    graph: nx.Graph
    known: dict[int, int]
    behind: dict[int, int]

    @cached_property
    def unseen(self) -> list[int]:
        """The nodes that are not known."""
        known = {*self.known.values()}
        return [node for node in self.graph if node not in known]


class FloorSampler:
    """Samples floors around explored parts; what the model gives is worked out once.

    label_shares: label -> share of the rooms of a floor of the model, the mean over floors.
    Raises OptionError for a model by `ncut`, ModelError for one without corridors.
    """

    def __init__(self, model: TypeModel) -> None:
        self.model = model
        self.ends = OpenEnds(model)
        self.potentials = CutPotentials(model)
        self.functional_references = References([floor.functional_graph for floor in model.floors])
        self.references = References([floor.graph for floor in model.floors])
        self.new_areas = [
            NewArea(take_area(floor.graph, area), find_hub(floor.graph, area, corridors), str(cluster))
            for floor in model.floors
            for corridors in [find_corridors(floor.graph, model.schema, convention=LabelConvention.GRAPHS)]
            for area, cluster in zip(floor.areas, floor.clusters, strict=True)
        ]
        self._firsts = np.cumsum([0, *(len(floor.areas) for floor in model.floors)]).tolist()
        shares = count_labels([floor.graph for floor in model.floors], model.schema).astype(float)
        shares /= shares.sum(axis=1, keepdims=True)
        self.label_shares = dict(zip(model.schema.by_name, shares.mean(axis=0).tolist(), strict=True))
        self._kernel = GraphHopper().fit(model.areas)
        self._gram = self._kernel.compare()

    def sample(
        self,
        explored: ExploredPart,
        numbers: Sequence[int],
        *,
        seed: int = 0,
        edge_moves: int = EDGE_MOVES,
        door_moves: int = DOOR_MOVES,
    ) -> list[SampledFloor]:
        """The floors of these numbers, 0 … among all of a seed; which are sampled beside it changes none."""
        generators = [np.random.default_rng((seed, number)) for number in numbers]
        known = segment_known_rooms(explored)
        clusters = self._recognize(explored, known)
        # Steps 1 and 3: how many functional areas are unexplored, of which clusters, and which.
        weights = self.ends.weigh_stages(explored)
        plans = [self._plan(explored, known, clusters, weights, generator) for generator in generators]
        # Step 2: which areas are joined; known ones as they are.
        starts = [plan.start(generator) for plan, generator in zip(plans, generators, strict=True)]
        chains = FunctionalGraphs(self.functional_references, starts, kept=len(known), closed=True)
        graphs = sample_functional_graphs(chains, generators, moves=edge_moves)
        # Step 4: by which doors; known ones stay, and lead from where they are.
        buildings, opened = [], []
        for plan, start, graph, generator in zip(plans, starts, graphs, generators, strict=True):
            graph.add_edges_from((edge for edge in start.edges if start.edges[edge].get("known")), cuts=0)
            building, doors = plan.build(graph, self.model.door_counts, generator)
            buildings.append(building)
            opened.append(doors)
        connections = NodeConnections(self.references, buildings, graphs, self.potentials, generators, kept=len(known))
        connect_areas(connections, moves=door_moves)
        return [_finish(*parts) for parts in zip(plans, buildings, opened, strict=True)]

    def _recognize(self, explored: ExploredPart, known: Sequence[Area]) -> list[str]:
        """The cluster of each known area, as text: that of the area of the model that it is most like."""
        rows = self._kernel.compare([take_area(explored.graph, area) for area in known])
        nearest = [int(((self._gram - row) ** 2).sum(axis=1).argmin()) for row in rows]
        return [str(self.model.clusters[place]) for place in nearest]

    def _plan(
        self,
        explored: ExploredPart,
        known: Sequence[Area],
        clusters: Sequence[str],
        weights: Floats,
        generator: np.random.Generator,
    ) -> AreaPlan:
        """Steps 1 and 3 of one floor: the areas of a floor explored as far, and where doors lead."""
        drawn = np.searchsorted(np.cumsum(weights), generator.random()).clip(0, len(weights) - 1)
        stage = self.ends.stages[int(drawn)]
        chosen = [self._draw_area(self._firsts[stage.floor] + area, generator) for area in stage.areas]
        if not explored.open_ends:
            chosen = []
        leads_on = bool(chosen or explored.open)
        branches = {
            door: self._draw_branch(
                explored.graph.nodes[near]["label"], leads_on and near not in explored.open, generator
            )
            for door, near in explored.doors.items()
        }
        if chosen and not explored.open and None not in branches.values():
            branches[[*branches][int(generator.integers(len(branches)))]] = None
        return plan_areas(explored, known, clusters, chosen=chosen, branches=branches, generator=generator)

    def _draw_area(self, area: int, generator: np.random.Generator) -> NewArea:
        """An area in the place of one of the model: of the same cluster, or now and then of any."""
        clusters = self.model.clusters
        cluster = clusters[area]
        if generator.random() < EXCHANGE:
            cluster = clusters[int(generator.integers(len(clusters)))]
        members = np.flatnonzero(clusters == cluster)
        return self.new_areas[int(members[int(generator.integers(len(members)))])]

    def _draw_branch(self, label: str, leads_on: bool, generator: np.random.Generator) -> nx.Graph | None:  # noqa: FBT001
        """What is behind a door of a room of this label: rooms of the same area, or None for another area."""
        # Doors of a floor are alike: what is likely is how many floors have it.
        floors = self.ends.by_label.get(label, [])
        is_known = generator.random() * (len(floors) + PRIOR_FLOORS) < len(floors)
        among = floors[int(generator.integers(len(floors)))] if is_known else self.ends.examples
        if not leads_on:
            among = _list_closed(among) or _list_closed(self.ends.examples)
        if not among:
            return None if leads_on else self._draw_room(generator)
        return among[int(generator.integers(len(among)))].branch

    def _draw_room(self, generator: np.random.Generator) -> nx.Graph:
        """A room of the model at a corridor, where none of its floors tells what is behind a door."""
        area = self.new_areas[int(generator.integers(len(self.new_areas)))]
        rooms = [node for node in area.graph if node != area.hub] or [area.hub]
        return take_area(area.graph, frozenset({rooms[int(generator.integers(len(rooms)))]}))


def _list_closed(examples: Sequence[DoorExample]) -> list[DoorExample]:
    """The doors behind which the same area went on."""
    return [example for example in examples if example.branch is not None]


def _finish(plan: AreaPlan, building: ConnectedBuilding, opened: dict[tuple[int, int], list[int]]) -> SampledFloor:
    """The floor, and who is who in it."""
    places, explored = plan.number_rooms(), plan.explored
    behind = {door: places[door] for door in explored.doors if door in places}
    for edge, doors in opened.items():
        pairs = building.doors.get(edge, [])
        behind |= {door: far for door, (_, far) in zip(doors, pairs, strict=False)}
    graph = building.to_graph()
    for part in plan.areas:
        sizes = {places[node]: take_size(attributes) for node, attributes in part.nodes(data=True)}
        nx.set_node_attributes(graph, sizes)
    return SampledFloor(graph, {node: places[node] for node in explored.known}, behind)
