"""The explored part of a floor as a graph, and the exploration by corridors of section 8.3.

A node is a room. `label` is None for the room behind a door that nobody has opened; `partial` is true for it, and for a
room that is known while its doors are not all: a corridor that has been discovered and not explored.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import networkx as nx
from pydantic_core import from_json

from pianta.errors import GraphError, LabelError
from pianta.generation.type_model import MAX_ROOMS, take_size
from pianta.graphs.labelled_graphs import name_some
from pianta.graphs.metrics import find_corridors
from pianta.labels import LabelConvention, LabelSchema, standard_name

# Where people come in, in the order of section 8.3.
STARTS = ("ENTRANCE", "ELEVATOR", "STAIRS")
# What a robot says of a room of which it has seen less, or of which it is less sure, is no label; but of one that was
# seen so well it is as good as of others.
LEAST_SEEN, LEAST_PROBABILITY, WELL_SEEN = 0.5, 0.4, 0.75


@dataclass(frozen=True, eq=False)
class ExploredPart:
    """The explored part of a floor, as `read_explored_part` makes it.

    graph: nodes 0 … n - 1 with `label`, `room`, their name before, and maybe `area`, m². corridors: the nodes that are
    CORRIDOR. closed: known rooms all of whose doors are known. open: corridors whose doors are not all known. doors:
    unknown rooms, each behind a door that nobody has opened, by their only neighbours.
    """

    source: str
    graph: nx.Graph
    corridors: frozenset[int]
    open: tuple[int, ...]
    doors: Mapping[int, int]

    @cached_property
    def closed(self) -> tuple[int, ...]:
        """Rooms that are known with all of their doors."""
        return tuple(node for node in self.graph if node not in self.open and node not in self.doors)

    @cached_property
    def known(self) -> nx.Graph:
        """The graph without unknown rooms."""
        known: nx.Graph = self.graph.subgraph([node for node in self.graph if node not in self.doors]).copy()
        return known

    @property
    def open_ends(self) -> int:
        """Where the floor may go on: open corridors and doors."""
        return len(self.open) + len(self.doors)


def read_explored_part(graph: nx.Graph, schema: LabelSchema) -> ExploredPart:
    """The explored part of a floor from its graph, that of a reading of a partial map or one with unknown rooms.

    graph: as `Floor.graph` gives it; without `partial` all doors of a room are known. A corridor that is partial is
    open. Another partial room counts as unknown if it has no label, if less than half of its predicted area is seen, or
    if less than three quarters are and its label is improbable; if it has several doors, each of them leads to an
    unknown room of its own. Other partial rooms count as known: of their own doors nothing is known.
    Raises LabelError for other rooms without a label and for labels that the schema does not have, GraphError where no
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
    corridors = find_corridors(named, schema, convention=LabelConvention.GRAPHS)
    unknown = {
        node
        for node in joined
        if is_partial[node] and node not in corridors and _is_glimpsed(labels[node], joined.nodes[node])
    }
    rooms = [node for node in joined if node not in unknown and (joined.degree(node) or is_partial[node])]
    if not rooms:
        raise GraphError("no room of it is known and has a door, explore more of it")
    return _number_rooms(joined, rooms, unknown, labels, corridors=corridors, is_partial=is_partial)


def explore_by_corridors(graph: nx.Graph, corridors: Collection[Hashable]) -> list[nx.Graph]:
    """What a robot knows of a floor after each corridor that it explores, breadth first (section 8.3, steps 1 to 5).

    graph: connected, with a `label` each. It starts at the first ENTRANCE, else ELEVATOR or STAIRS, else in the
    corridor with most doors, and moves to the nearest corridor that it has discovered. A corridor is explored with the
    rooms at it: all doors of these are known, and behind each that leads elsewhere is an unknown room, named by the two
    that the door joins, `"3-7"`. Corridors at an explored one are discovered: they open into it, so that their label is
    known, and their doors are not. Where no corridor is discovered, the nearest unknown room is explored.
    """
    here = find_start(graph, corridors)
    explored, discovered = {here}, {node for node in graph[here] if node in corridors}
    stages: list[nx.Graph] = []
    is_first = here in corridors
    while True:
        if not is_first:
            seen = explored | discovered | {near for node in explored for near in graph[node]}
            hops = nx.single_source_shortest_path_length(graph.subgraph(seen), here)
            unexplored = [node for node in hops if node not in explored]
            targets = [node for node in unexplored if node in discovered] or unexplored
            if not targets:
                return stages
            here = min(targets, key=lambda node: (hops[node], node))
        is_first = False
        explored.add(here)
        at_corridor = [node for node in graph[here] if node not in corridors] if here in corridors else []
        explored.update(at_corridor)
        discovered |= {near for near in graph[here] if near in corridors}
        discovered -= explored
        if here in corridors:
            stages.append(hide_rooms(graph, explored, discovered))


def find_start(graph: nx.Graph, corridors: Collection[Hashable]) -> Any:  # noqa: ANN401 - a node of any type
    """Where exploration starts: the first ENTRANCE, else ELEVATOR or STAIRS, else the corridor with most doors."""
    labels = dict(graph.nodes(data="label"))
    starts = [node for label in STARTS for node in graph if labels[node] == label]
    return starts[0] if starts else max([node for node in graph if node in corridors] or graph, key=graph.degree)


def hide_rooms(graph: nx.Graph, explored: Collection[Hashable], discovered: Collection[Hashable] = ()) -> nx.Graph:
    """What is known of a floor when some rooms are explored, and the labels of some others discovered.

    Each door of an explored room to any other leads to an unknown room of its own.
    """
    known = nx.Graph(source=graph.graph.get("source", ""))
    for node, attributes in graph.nodes(data=True):
        if node in explored or node in discovered:
            known.add_node(node, **attributes | {"partial": node not in explored})
    for one, other in graph.edges:
        for node, near in ((one, other), (other, one)):
            if node in explored and near in known:
                known.add_edge(node, near)
            elif node in explored:
                known.add_node(f"{node}-{near}", label=None, partial=True)
                known.add_edge(node, f"{node}-{near}")
    return known


def _standardise(label: object) -> str | None:
    if label is None:
        return None
    if not isinstance(label, str):
        raise LabelError(f"the label {label!r} of a room is no text, label it")
    return standard_name(label)


def _is_glimpsed(label: str | None, attributes: Mapping[str, Any]) -> bool:
    """Whether too little of a partial room is known to say what it is."""
    if label is None:
        return True
    whole, seen = take_size({"area": attributes.get("predicted_area")}), take_size(attributes)
    if whole and seen:
        share = seen["area"] / whole["area"]
        if not LEAST_SEEN <= share < WELL_SEEN:
            return share < LEAST_SEEN
    probability = _find_probability(label, attributes.get("label_probabilities"))
    return probability is not None and probability < LEAST_PROBABILITY


def _find_probability(label: str, label_sets: object) -> float | None:
    """The probability of a label in the finest of some label sets that has it; GraphML has them as a text, in JSON."""
    if isinstance(label_sets, str):
        try:
            label_sets = from_json(label_sets)
        except ValueError:
            return None
    of_sets = [*label_sets.values()] if isinstance(label_sets, Mapping) else []
    found = [of_set.get(label) for of_set in of_sets if isinstance(of_set, Mapping)]
    numbers = [float(number) for number in found if isinstance(number, int | float)]
    return numbers[-1] if numbers else None


def _number_rooms(
    graph: nx.Graph,
    rooms: Collection[Hashable],
    unknown: Collection[Hashable],
    labels: Mapping[Any, str | None],
    *,
    corridors: Collection[Hashable],
    is_partial: Mapping[Any, bool],
) -> ExploredPart:
    """The explored part with nodes 0 … n - 1, known rooms first, an unknown room for each door to one."""
    numbers = {node: number for number, node in enumerate(rooms)}
    numbered = nx.Graph()
    numbered.add_nodes_from(
        (number, {"label": labels[node], "room": node} | take_size(graph.nodes[node]))
        for node, number in numbers.items()
    )
    doors = {}
    for node, number in numbers.items():
        numbered.add_edges_from((number, numbers[near]) for near in graph[node] if near in numbers)
        for near in graph[node]:
            if near in unknown:
                place = len(numbered)
                numbered.add_node(place, label=None, room=near)
                numbered.add_edge(number, place)
                doors[place] = number
    of_open = tuple(numbers[node] for node in rooms if is_partial[node] and node in corridors)
    of_corridors = frozenset(numbers[node] for node in corridors if node in numbers)
    return ExploredPart(str(graph.graph.get("source", "")), numbered, of_corridors, of_open, doors)
