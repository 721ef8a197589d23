"""The functional areas of a floor that is explored in part: known ones, and those that steps 1 and 3 put beside them.

Rooms are named by their nodes in the explored part where they are in it, unknown ones behind doors included; what is
sampled beside them has names of its own. So a corridor that is open is the same node as that of its area.
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
    """The areas of one floor, the known ones first, and which of their doors lead to others.

    areas: with `label` at each node. clusters: of each, as text. kept: how many are known. doors: for each known area
    the unknown rooms that are in new ones.
    """

    areas: list[nx.Graph]
    clusters: list[str]
    kept: int
    explored: ExploredPart
    doors: dict[int, list[int]] = field(default_factory=dict)

    def start(self, generator: np.random.Generator) -> nx.Graph:
        """A functional graph to start step 2 from; edges with known doors are `known`, and have no other `cuts`."""
        graph = nx.Graph()
        graph.add_nodes_from((place, {"label": cluster}) for place, cluster in enumerate(self.clusters))
        graph.add_edges_from(self._list_known_edges(), known=True, cuts=0)
        new = [*range(self.kept, len(self.areas))]
        for area, doors in self.doors.items():
            free = [place for place in new if not graph.has_edge(area, place)]
            targets = generator.permutation(len(free))[: len(doors)].tolist()
            graph.add_edges_from((area, free[target]) for target in targets)
        # Each other area is joined to one that leads to what is known; so are parts that no known door joins.
        parts = [nx.node_connected_component(graph, area) for area in [*range(self.kept), *new]]
        reached: set[int] = next((part for part in parts if part.intersection(new)), set())
        for place in new:
            if place not in reached:
                inside = sorted(reached.intersection(new))
                graph.add_edge(place, inside[int(generator.integers(len(inside)))])
                reached |= nx.node_connected_component(graph, place)
        return graph

    def build(
        self, functional: nx.Graph, counts: Sequence[int], generator: np.random.Generator
    ) -> tuple[ConnectedBuilding, dict[tuple[int, int], list[int]]]:
        """The building before step 4: its areas, joined by known doors; and the unknown rooms behind doors of edges.

        functional: gets the number of its doors, `cuts`, at each edge. counts: to draw it from where it is not known.
        """
        building = ConnectedBuilding(self.areas)
        places = self.number_rooms()
        for one, other in self.explored.known.edges:
            building.join(places[one], places[other])
        opened: dict[tuple[int, int], list[int]] = {}
        for area, doors in self.doors.items():
            beyond = sorted(place for place in functional[area] if place >= self.kept)
            if not beyond:
                continue
            # Each edge of the area has one of its doors at least.
            first = [place for place in beyond if "cuts" not in functional.edges[area, place]]
            drawn = generator.integers(len(beyond), size=len(doors)).tolist()
            targets = [*first, *(beyond[place] for place in drawn)][: len(doors)]
            order = generator.permutation(len(doors)).tolist()
            for place, target in zip(order, targets, strict=True):
                opened.setdefault((area, target), []).append(doors[place])
        for edge, doors in opened.items():
            functional.edges[edge]["cuts"] = len(doors)
            building.known_ends[edge] = [places[self.explored.doors[door]] for door in doors]
        draw_door_counts(functional, counts, generator)
        return building, opened

    def number_rooms(self) -> dict[Hashable, int]:
        """The number of each room of the building by its name."""
        return {node: number for number, node in enumerate(node for area in self.areas for node in area)}

    def _list_known_edges(self) -> list[tuple[int, int]]:
        area_of = {node: place for place, area in enumerate(self.areas) for node in area}
        pairs = {
            (min(area_of[one], area_of[other]), max(area_of[one], area_of[other]))
            for one, other in self.explored.known.edges
        }
        return sorted(pair for pair in pairs if pair[0] != pair[1])


def segment_known_rooms(explored: ExploredPart) -> list[Area]:
    """The known rooms in functional areas by `corr`, without open corridors; what is nothing else is none."""
    known = explored.known
    areas = [
        area - {*explored.open}
        for part in sorted(map(sorted, nx.connected_components(known)))
        for area in segment_by_corridors(known.subgraph(part), explored.corridors.intersection(part))
    ]
    return [area for area in areas if area]


def plan_areas(
    explored: ExploredPart,
    known: Sequence[Area],
    clusters: Sequence[str],
    *,
    chosen: Sequence[NewArea],
    branches: Mapping[int, nx.Graph | None],
    generator: np.random.Generator,
) -> AreaPlan:
    """The areas of a floor: known ones with what is behind their doors, and the chosen ones.

    clusters: of the known areas. branches: for each unopened door the rooms behind it that are in the same area, None
    where it leads to another. Each open corridor becomes that of a chosen area, of one with the same label where there
    is one; when there are too few, it is an area of its own, without rooms.
    """
    areas = []
    doors: dict[int, list[int]] = {}
    for place, area in enumerate(known):
        graph = nx.Graph(explored.graph.subgraph(sorted(area)))
        for door in (door for door, near in explored.doors.items() if near in area):
            branch = branches[door]
            if branch is None:
                doors.setdefault(place, []).append(door)
            else:
                _add_branch(graph, explored.doors[door], door, branch)
        areas.append(graph)
    new = _take_new_areas(explored, chosen, branches, generator)
    return AreaPlan(
        [*areas, *(graph for graph, _ in new)],
        [*clusters, *(cluster for _, cluster in new)],
        len(areas),
        explored,
        doors,
    )


def _take_new_areas(
    explored: ExploredPart,
    chosen: Sequence[NewArea],
    branches: Mapping[int, nx.Graph | None],
    generator: np.random.Generator,
) -> list[tuple[nx.Graph, str]]:
    """The chosen areas, with open corridors in the place of theirs, and their clusters."""
    left = [*range(len(chosen))]
    corridor_of: dict[int, int] = {}
    bare = []
    for corridor in explored.open:
        label = explored.graph.nodes[corridor]["label"]
        same = [place for place in left if chosen[place].graph.nodes[chosen[place].hub]["label"] == label]
        if not left:
            bare.append(corridor)
            continue
        corridor_of[(same or left)[0]] = corridor
        left.remove((same or left)[0])
    found = [
        (
            _name_rooms(explored, area, place, corridor=corridor_of.get(place), branches=branches, generator=generator),
            area.cluster,
        )
        for place, area in enumerate(chosen)
    ]
    for corridor in bare:
        graph = nx.Graph()
        graph.add_node(corridor, **explored.graph.nodes[corridor])
        found.append((_add_doors(graph, explored, corridor, branches=branches, generator=generator), ""))
    return found


def _name_rooms(
    explored: ExploredPart,
    area: NewArea,
    place: int,
    *,
    corridor: int | None,
    branches: Mapping[int, nx.Graph | None],
    generator: np.random.Generator,
) -> nx.Graph:
    """A new area with names for its rooms; what is known of its corridor is not sampled again."""
    names: dict[int, Hashable] = {node: (place, node) for node in area.graph}
    if corridor is None:
        return nx.relabel_nodes(area.graph, names)
    names[area.hub] = corridor
    graph = nx.relabel_nodes(area.graph, names)
    graph.nodes[corridor].update(label=explored.graph.nodes[corridor]["label"])
    # Of an open corridor a part may be seen.
    if "area" in explored.graph.nodes[corridor]:
        seen = explored.graph.nodes[corridor]["area"]
        graph.nodes[corridor]["area"] = max(seen, graph.nodes[corridor].get("area", seen))
    for near in explored.known[corridor]:
        label = explored.graph.nodes[near]["label"]
        alike = [node for node in graph[corridor] if graph.nodes[node]["label"] == label and graph.degree(node) == 1]
        if near not in explored.corridors and alike:
            graph.remove_node(alike[0])
    rooms = [node for node in graph[corridor] if isinstance(node, tuple)]
    return _add_doors(graph, explored, corridor, rooms=rooms, branches=branches, generator=generator)


def _add_doors(
    graph: nx.Graph,
    explored: ExploredPart,
    corridor: int,
    *,
    rooms: Sequence[Hashable] = (),
    branches: Mapping[int, nx.Graph | None],
    generator: np.random.Generator,
) -> nx.Graph:
    """The area of an open corridor whose unopened doors lead to its rooms, as far as there are any."""
    doors = [door for door, near in explored.doors.items() if near == corridor]
    order = [rooms[place] for place in generator.permutation(len(rooms)).tolist()]
    graph = nx.relabel_nodes(graph, dict(zip(order, doors, strict=False)))
    for door in doors[len(order) :]:
        _add_branch(graph, corridor, door, branches[door] or nx.Graph())
    return graph


def _add_branch(graph: nx.Graph, near: Hashable, door: int, branch: nx.Graph) -> None:
    """Add the rooms behind a door, the first of which becomes the unknown one; none where the branch is empty."""
    if not len(branch):
        return
    first = next(iter(branch))
    named = nx.relabel_nodes(branch, {node: door if node == first else (near, door, node) for node in branch})
    graph.add_nodes_from(named.nodes(data=True))
    graph.add_edges_from([*named.edges, (near, door)])
