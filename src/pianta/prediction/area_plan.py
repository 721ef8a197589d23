"""The functional areas of a partly explored floor: known ones, and those that steps 1 and 3 add.

A room that is in the explored part has the same name here, also an unknown room behind a door. Other sampled rooms have
names of their own. So an open corridor is the same node as the corridor of its sampled area.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field

import networkx as nx
import numpy as np

from pianta.generation.functional_areas import Area, segment_by_corridors
from pianta.generation.functional_graph import draw_door_counts
from pianta.generation.node_connections import ConnectedBuilding
from pianta.prediction.explored_part import ExploredPart


@dataclass(frozen=True, eq=False)
class NewArea:
    """An area of the model. graph: its rooms, with `label`. hub: its corridor. cluster: as text."""

    graph: nx.Graph
    hub: int
    cluster: str


@dataclass(eq=False)
class AreaPlan:
    """The areas of one floor, the known ones first, and their doors to new areas.

    areas: with `label` at each node. clusters: of each, as text. n_known: number of known areas. doors: for each known
    area the unknown rooms that are in new areas.
    """

    areas: list[nx.Graph]
    clusters: list[str]
    n_known: int
    explored: ExploredPart
    doors: dict[int, list[int]] = field(default_factory=dict)

    def start(self, generator: np.random.Generator) -> nx.Graph:
        """A functional graph from which step 2 starts; edges between known areas have `known` and no further `cuts`."""
        graph = nx.Graph()
        graph.add_nodes_from((index, {"label": cluster}) for index, cluster in enumerate(self.clusters))
        graph.add_edges_from(self._list_known_edges(), known=True, cuts=0)
        new = [*range(self.n_known, len(self.areas))]
        for area, doors in self.doors.items():
            free = [index for index in new if not graph.has_edge(area, index)]
            targets = generator.permutation(len(free))[: len(doors)].tolist()
            graph.add_edges_from((area, free[target]) for target in targets)
        # Join each remaining new area, and each remaining part of known areas, to the first part with a new area.
        parts = [nx.node_connected_component(graph, area) for area in [*range(self.n_known), *new]]
        reached: set[int] = next((part for part in parts if part.intersection(new)), set())
        for index in new:
            if index not in reached:
                inside = sorted(reached.intersection(new))
                graph.add_edge(index, inside[int(generator.integers(len(inside)))])
                reached |= nx.node_connected_component(graph, index)
        return graph

    def build(
        self, functional: nx.Graph, counts: Sequence[int], generator: np.random.Generator
    ) -> tuple[ConnectedBuilding, dict[tuple[int, int], list[int]]]:
        """The building before step 4, with the known doors; and for edges of `functional` the unknown rooms behind.

        functional: gets the number of doors, `cuts`, at each edge; drawn from `counts` if unknown.
        """
        building = ConnectedBuilding(self.areas)
        numbers = self.number_rooms()
        for one, other in self.explored.known_graph.edges:
            building.connect(numbers[one], numbers[other])
        opened: dict[tuple[int, int], list[int]] = {}
        for area, doors in self.doors.items():
            beyond = sorted(index for index in functional[area] if index >= self.n_known)
            if not beyond:
                continue
            # Each edge of the area gets at least one of its doors.
            first = [index for index in beyond if "cuts" not in functional.edges[area, index]]
            extra = generator.integers(len(beyond), size=len(doors)).tolist()
            targets = [*first, *(beyond[index] for index in extra)][: len(doors)]
            order = generator.permutation(len(doors)).tolist()
            for index, target in zip(order, targets, strict=True):
                opened.setdefault((area, target), []).append(doors[index])
        for edge, doors in opened.items():
            functional.edges[edge]["cuts"] = len(doors)
            building.known_ends[edge] = [numbers[self.explored.doors[door]] for door in doors]
        draw_door_counts(functional, counts, generator)
        return building, opened

    def number_rooms(self) -> dict[Hashable, int]:
        """The node of each room in the building, by its name."""
        return {node: number for number, node in enumerate(node for area in self.areas for node in area)}

    def _list_known_edges(self) -> list[tuple[int, int]]:
        """Pairs of areas, by index and the smaller first, between which a door joins known rooms."""
        area_of = {node: index for index, area in enumerate(self.areas) for node in area}
        pairs = {
            (min(area_of[one], area_of[other]), max(area_of[one], area_of[other]))
            for one, other in self.explored.known_graph.edges
        }
        return sorted(pair for pair in pairs if pair[0] != pair[1])


def segment_known_rooms(explored: ExploredPart) -> list[Area]:
    """Divide the known rooms, except open corridors, into functional areas by `corr`."""
    graph = explored.known_graph
    areas = [
        area - {*explored.open}
        for part in sorted(map(sorted, nx.connected_components(graph)))
        for area in segment_by_corridors(graph.subgraph(part), explored.corridors.intersection(part))
    ]
    return [area for area in areas if area]


def plan_areas(
    explored: ExploredPart,
    known_areas: Sequence[Area],
    clusters: Sequence[str],
    *,
    chosen: Sequence[NewArea],
    branches: Mapping[int, nx.Graph | None],
    generator: np.random.Generator,
) -> AreaPlan:
    """Plan the areas of a floor: the known ones with the rooms behind their doors, and the chosen ones.

    clusters: of the known areas. branches: for each unopened door the rooms behind it in the same area; None if it
    leads to another area. Each open corridor replaces the corridor of a chosen area, with the same label if possible;
    if there are too few areas, it is an area of its own, without rooms.
    """
    areas = []
    doors: dict[int, list[int]] = {}
    for index, area in enumerate(known_areas):
        graph = nx.Graph(explored.graph.subgraph(sorted(area)))
        for door in (door for door, near in explored.doors.items() if near in area):
            branch = branches[door]
            if branch is None:
                doors.setdefault(index, []).append(door)
            else:
                _add_branch(graph, explored.doors[door], door, branch)
        areas.append(graph)
    new = _place_new_areas(explored, chosen, branches, generator)
    return AreaPlan(
        [*areas, *(graph for graph, _ in new)],
        [*clusters, *(cluster for _, cluster in new)],
        len(areas),
        explored,
        doors,
    )


def _place_new_areas(
    explored: ExploredPart,
    chosen: Sequence[NewArea],
    branches: Mapping[int, nx.Graph | None],
    generator: np.random.Generator,
) -> list[tuple[nx.Graph, str]]:
    """The chosen areas with their clusters, open corridors replacing theirs, and the open corridors without area."""
    left = [*range(len(chosen))]
    corridor_of: dict[int, int] = {}
    bare = []
    for corridor in explored.open:
        label = explored.graph.nodes[corridor]["label"]
        same = [index for index in left if chosen[index].graph.nodes[chosen[index].hub]["label"] == label]
        if not left:
            bare.append(corridor)
            continue
        corridor_of[(same or left)[0]] = corridor
        left.remove((same or left)[0])
    areas = [
        (_name_rooms(explored, area, index, corridor_of.get(index), branches, generator), area.cluster)
        for index, area in enumerate(chosen)
    ]
    for corridor in bare:
        graph = nx.Graph()
        graph.add_node(corridor, **explored.graph.nodes[corridor])
        areas.append((_add_doors(graph, explored, corridor, [], branches, generator), ""))
    return areas


def _name_rooms(  # noqa: PLR0917
    explored: ExploredPart,
    area: NewArea,
    index: int,
    corridor: int | None,
    branches: Mapping[int, nx.Graph | None],
    generator: np.random.Generator,
) -> nx.Graph:
    """A new area with names for its rooms; known rooms at its open corridor replace sampled ones."""
    names: dict[int, Hashable] = {node: (index, node) for node in area.graph}
    if corridor is None:
        return nx.relabel_nodes(area.graph, names)
    names[area.hub] = corridor
    graph = nx.relabel_nodes(area.graph, names)
    graph.nodes[corridor].update(label=explored.graph.nodes[corridor]["label"])
    # An open corridor is at least as large as its observed part.
    if "area" in explored.graph.nodes[corridor]:
        observed = explored.graph.nodes[corridor]["area"]
        graph.nodes[corridor]["area"] = max(observed, graph.nodes[corridor].get("area", observed))
    for near in explored.known_graph[corridor]:
        label = explored.graph.nodes[near]["label"]
        same = [node for node in graph[corridor] if graph.nodes[node]["label"] == label and graph.degree(node) == 1]
        if near not in explored.corridors and same:
            graph.remove_node(same[0])
    rooms = [node for node in graph[corridor] if isinstance(node, tuple)]
    return _add_doors(graph, explored, corridor, rooms, branches, generator)


def _add_doors(  # noqa: PLR0917
    graph: nx.Graph,
    explored: ExploredPart,
    corridor: int,
    rooms: Sequence[Hashable],
    branches: Mapping[int, nx.Graph | None],
    generator: np.random.Generator,
) -> nx.Graph:
    """The area of an open corridor with its unopened doors: they lead to its rooms, the remaining ones to branches."""
    doors = [door for door, near in explored.doors.items() if near == corridor]
    order = [rooms[index] for index in generator.permutation(len(rooms)).tolist()]
    graph = nx.relabel_nodes(graph, dict(zip(order, doors, strict=False)))
    for door in doors[len(order) :]:
        _add_branch(graph, corridor, door, branches[door] or nx.Graph())
    return graph


def _add_branch(graph: nx.Graph, near: Hashable, door: int, branch: nx.Graph) -> None:
    """Add the rooms behind a door, if any; the first of them becomes the unknown room."""
    if not len(branch):
        return
    first = next(iter(branch))
    named = nx.relabel_nodes(branch, {node: door if node == first else (near, door, node) for node in branch})
    graph.add_nodes_from(named.nodes(data=True))
    graph.add_edges_from([*named.edges, (near, door)])
