"""The explored part of a floor as a graph, and the exploration by corridors of section 8.3.

A node is a room. An unknown room behind an unopened door has the `label` None and `partial` true. A known room whose
doors are not all known is `partial` as well: a corridor that is discovered but not explored.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import networkx as nx
from pydantic_core import from_json

from pianta.errors import GraphError, LabelError
from pianta.generation.type_model import MAX_ROOMS, size_attribute
from pianta.graphs.labelled_graphs import name_some
from pianta.graphs.metrics import find_corridors
from pianta.labels import RC, LabelConvention, LabelSchema, LabelSet, standard_name

# Labels of the rooms where exploration starts, in the order of section 8.3.
START_LABELS = ("ENTRANCE", "ELEVATOR", "STAIRS")
# The limits for partial rooms were chosen by hand. The label of a room with a smaller observed share is ignored.
MIN_OBSERVED_SHARE = 0.5
# The label of a partial room of unknown share with a smaller probability is ignored.
MIN_LABEL_PROBABILITY = 0.4
# A corridor with this observed share is taken as complete: on maps of robots, most of what is left are corners and
# niches. Chosen on maps of eleven schools (docs/methods/mapping.md).
COMPLETE_SHARE = 0.8
# Smaller differences of areas are of rounding, m².
LEAST_AREA = 0.01
# A partial room counts as a corridor if all labels of corridors together have this probability.
MIN_CORRIDOR_PROBABILITY = 0.5


@dataclass(frozen=True, eq=False)
class ExploredPart:
    """The explored part of a floor, made by `read_explored_part`.

    graph: nodes 0 … n - 1 with `label`, `room`, their original name, and optionally `area`, m². corridors: the nodes of
    the class CORRIDOR. open: corridors whose doors are not all known. doors: unknown room behind an unopened door ->
    the room with the door.
    """

    source: str
    graph: nx.Graph
    corridors: frozenset[int]
    open: tuple[int, ...]
    doors: Mapping[int, int]

    @cached_property
    def closed(self) -> tuple[int, ...]:
        """Known rooms with all of their doors."""
        return tuple(node for node in self.graph if node not in self.open and node not in self.doors)

    @cached_property
    def known_graph(self) -> nx.Graph:
        """The graph without unknown rooms."""
        graph: nx.Graph = self.graph.subgraph([node for node in self.graph if node not in self.doors]).copy()
        return graph

    @property
    def open_ends(self) -> int:
        """Number of open corridors and unopened doors."""
        return len(self.open) + len(self.doors)


def read_explored_part(graph: nx.Graph, schema: LabelSchema) -> ExploredPart:
    """Build the explored part of a floor from the graph of a partial map, or from a graph with unknown rooms.

    graph: as of `Floor.graph`; a room that is not `partial` has all of its doors. A partial corridor is open until four
    fifths of its predicted area are observed; a partial room for which other labels are more probable than all those of
    corridors does not count as one. Another partial room is unknown if it has no label, if less than half of its
    predicted area is observed, or if that is not predicted and its label is improbable; each of its doors then leads to
    an unknown room of its own. Other partial rooms are known, without further doors.
    Raises LabelError for rooms without a label that are not partial and for labels outside the schema, GraphError if no
    room is known and for more than 1000 rooms.
    """
    if len(graph) > MAX_ROOMS:
        raise GraphError(f"it has {len(graph)} rooms, give parts of {MAX_ROOMS} at most")
    joined = nx.Graph(graph)
    joined.remove_edges_from([*nx.selfloop_edges(joined)])
    labels = {node: _standardise(label) for node, label in joined.nodes(data="label")}
    is_partial = {node: bool(partial) for node, partial in joined.nodes(data="partial", default=False)}
    if unlabelled := [node for node in joined if labels[node] is None and not is_partial[node]]:
        raise LabelError(f"rooms {name_some(unlabelled)} have no label and are not partial, label them")
    named = nx.Graph()
    named.add_nodes_from((node, {"label": label}) for node, label in labels.items() if label is not None)
    corridors = {
        node
        for node in find_corridors(named, schema, convention=LabelConvention.GRAPHS)
        if not is_partial[node] or _is_probable_corridor(joined.nodes[node], schema)
    }
    unknown = {
        node
        for node in joined
        if is_partial[node] and node not in corridors and _is_label_unreliable(labels[node], joined.nodes[node])
    }
    is_open = {node: is_partial[node] and node in corridors and not _is_complete(joined.nodes[node]) for node in joined}
    rooms = [node for node in joined if node not in unknown and (joined.degree(node) or is_partial[node])]
    if not rooms:
        raise GraphError("no room of it is known and has a door, explore more of it")
    return _number_rooms(joined, rooms, unknown, labels, corridors=corridors, is_open=is_open)


def explore_by_corridors(
    graph: nx.Graph, corridors: Collection[Hashable], *, corridors_first: bool = False
) -> list[nx.Graph]:
    """The explored part of a floor after each corridor, explored breadth first (section 8.3, steps 1 to 5).

    graph: connected, a `label` at each node. The robot starts as in `find_start` and moves to the nearest discovered
    corridor. A corridor is explored together with its rooms: all of their doors are known, and behind each door to
    another room is an unknown room, named by the two rooms of the door, `"3-7"`. Corridors at an explored one are
    discovered: their label is known, their doors are not. If no corridor is discovered, the robot explores the nearest
    unknown room.
    corridors_first: before each of these parts comes the one in which the robot has seen the doors of the corridor, and
    no room behind them yet, as on the maps of robots.
    """
    here = find_start(graph, corridors)
    explored, discovered = {here}, {node for node in graph[here] if node in corridors}
    stages: list[nx.Graph] = []
    is_first = here in corridors
    while True:
        if not is_first:
            observed = explored | discovered | {near for node in explored for near in graph[node]}
            hops = nx.single_source_shortest_path_length(graph.subgraph(observed), here)
            unexplored = [node for node in hops if node not in explored]
            targets = [node for node in unexplored if node in discovered] or unexplored
            if not targets:
                return stages
            here = min(targets, key=lambda node: (hops[node], node))
        is_first = False
        explored.add(here)
        discovered |= {near for near in graph[here] if near in corridors}
        discovered -= explored
        if here in corridors:
            if corridors_first:
                stages.append(hide_rooms(graph, explored, discovered))
            explored.update(node for node in graph[here] if node not in corridors)
            stages.append(hide_rooms(graph, explored, discovered))


def find_start(graph: nx.Graph, corridors: Collection[Hashable]) -> Any:  # noqa: ANN401 - a node of any type
    """The first room of exploration: an ENTRANCE, else ELEVATOR or STAIRS, else the corridor with most doors."""
    labels = dict(graph.nodes(data="label"))
    starts = [node for label in START_LABELS for node in graph if labels[node] == label]
    return starts[0] if starts else max([node for node in graph if node in corridors] or graph, key=graph.degree)


def hide_rooms(graph: nx.Graph, explored: Collection[Hashable], discovered: Collection[Hashable] = ()) -> nx.Graph:
    """The explored part of a floor with some explored rooms, and some discovered ones, whose labels are known.

    Each door of an explored room to any other room leads to an unknown room of its own.
    """
    part = nx.Graph(source=graph.graph.get("source", ""))
    for node, attributes in graph.nodes(data=True):
        if node in explored or node in discovered:
            part.add_node(node, **attributes | {"partial": node not in explored})
    for one, other in graph.edges:
        for node, near in ((one, other), (other, one)):
            if node in explored and near in part:
                part.add_edge(node, near)
            elif node in explored:
                part.add_node(f"{node}-{near}", label=None, partial=True)
                part.add_edge(node, f"{node}-{near}")
    return part


def _standardise(label: object) -> str | None:
    if label is None:
        return None
    if not isinstance(label, str):
        raise LabelError(f"the label {label!r} of a room is no text, label it")
    return standard_name(label)


def _is_label_unreliable(label: str | None, attributes: Mapping[str, Any]) -> bool:
    """Whether too little of a partial room is observed for its label to be used."""
    if label is None:
        return True
    areas = _find_areas(attributes)
    if areas is not None:
        return areas[0] < MIN_OBSERVED_SHARE * areas[1]
    return _find_probabilities(label, attributes).get(label, 1.0) < MIN_LABEL_PROBABILITY


def _is_probable_corridor(attributes: Mapping[str, Any], schema: LabelSchema) -> bool:
    """Whether a room with the label of a corridor is one, by the probabilities of all such labels."""
    probabilities = _find_probabilities(_standardise(attributes["label"]), attributes)
    in_schema = {label: value for label, value in probabilities.items() if label in schema.by_name}
    labels = schema.map_labels(in_schema, LabelSet.R_C, convention=LabelConvention.GRAPHS)
    total = sum(value for value, label in zip(in_schema.values(), labels, strict=True) if label == RC.CORRIDOR)
    return not in_schema or total >= MIN_CORRIDOR_PROBABILITY


def _is_complete(attributes: Mapping[str, Any]) -> bool:
    """Whether most of a corridor was observed; if nothing is predicted beyond the observed part, that is unknown."""
    areas = _find_areas(attributes)
    if areas is None:
        return False
    observed, predicted = areas
    return predicted - observed > LEAST_AREA and observed >= COMPLETE_SHARE * predicted


def _find_areas(attributes: Mapping[str, Any]) -> tuple[float, float] | None:
    """The observed and the predicted area of a room, m²; None if one is unknown."""
    observed, predicted = size_attribute(attributes), size_attribute({"area": attributes.get("predicted_area")})
    return (observed["area"], predicted["area"]) if observed and predicted else None


def _find_probabilities(label: str | None, attributes: Mapping[str, Any]) -> dict[str, float]:
    """The probabilities of the finest label set that has a label; those from GraphML are JSON text."""
    label_sets = attributes.get("label_probabilities")
    if isinstance(label_sets, str):
        try:
            label_sets = from_json(label_sets)
        except (ValueError, TypeError):
            return {}
    sets = [*label_sets.values()] if isinstance(label_sets, Mapping) else []
    label_values = [
        {str(name): value for name, value in probabilities.items() if _is_probability(value)}
        for probabilities in sets
        if isinstance(probabilities, Mapping)
    ]
    return next((probabilities for probabilities in reversed(label_values) if label in probabilities), {})


def _is_probability(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value <= 1


def _number_rooms(
    graph: nx.Graph,
    rooms: Collection[Hashable],
    unknown: Collection[Hashable],
    labels: Mapping[Any, str | None],
    *,
    corridors: Collection[Hashable],
    is_open: Mapping[Any, bool],
) -> ExploredPart:
    """The explored part with nodes 0 … n - 1: known rooms first, then an unknown room for each door to one."""
    numbers = {node: number for number, node in enumerate(rooms)}
    numbered = nx.Graph()
    numbered.add_nodes_from(
        (number, {"label": labels[node], "room": node} | size_attribute(graph.nodes[node]))
        for node, number in numbers.items()
    )
    doors = {}
    for node, number in numbers.items():
        numbered.add_edges_from((number, numbers[near]) for near in graph[node] if near in numbers)
        for near in graph[node]:
            if near in unknown:
                door = len(numbered)
                numbered.add_node(door, label=None, room=near)
                numbered.add_edge(number, door)
                doors[door] = number
    open_corridors = tuple(numbers[node] for node in rooms if is_open[node])
    known_corridors = frozenset(numbers[node] for node in corridors if node in numbers)
    return ExploredPart(str(graph.graph.get("source", "")), numbered, known_corridors, open_corridors, doors)
