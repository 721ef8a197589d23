"""Graphs of rooms as the page draws them: nodes with labels and colours, at the positions of a layout."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import networkx as nx
from shapely import box

from pianta.errors import FloorError
from pianta.floor import Floor, Room
from pianta.io._files import short_repr
from pianta.io.graphs import read_graph
from pianta.labels import ALL_SCHEMAS
from pianta.plot.graphs import place_nodes
from pianta.plot.styles import style_rooms
from pianta.view.states import choose_looks

Positions: TypeAlias = Mapping[Hashable, tuple[float, float]]
# A layout of more rooms takes a minute; chosen by hand.
MAX_NODES = 600


def open_graph(file: Path) -> nx.Graph:
    """The graph in a file; raises FloorError for one that is too large to draw."""
    graph = read_graph(file)
    if len(graph) > MAX_NODES:
        raise FloorError(f"graph {short_repr(file)} has {len(graph)} rooms, the page draws {MAX_NODES} at most")
    return graph


def describe_graph(graph: nx.Graph, positions: Positions | None = None) -> dict[str, Any]:
    """The nodes and edges. positions: x, y of nodes; None for a layout, in lengths of the shortest edges."""
    xy, styles = positions or place_nodes(graph), style_nodes(graph)
    numbers = {node: number for number, node in enumerate(graph)}
    nodes = [
        {
            "id": node,
            "label": label_of(graph, node),
            "colour": styles[node].color,
            "corridor": styles[node].is_corridor,
            "position": xy[node],
            "area": area_of(graph, node),
            "room": _name_in(graph, node, "room"),
            "door": _name_in(graph, node, "door"),
        }
        for node in graph
    ]
    return {"nodes": nodes, "edges": [[numbers[one], numbers[other]] for one, other in graph.edges]}


def count_labels(graph: nx.Graph) -> dict[str, Any]:
    """The figures of a graph of a building."""
    styles = style_nodes(graph)
    areas = [area_of(graph, node) for node in graph]
    return {
        "rooms": len(graph),
        "corridors": sum(style.is_corridor for style in styles.values()),
        "doors": graph.number_of_edges(),
        "labels": len({label_of(graph, node) for node in graph} - {None}),
        "area": None if None in areas or not areas else sum(area for area in areas if area is not None),
    }


class NodeStyle(NamedTuple):
    """The colour of the function of a node's label, as on floors, and whether it is a corridor."""

    color: str
    is_corridor: bool


def style_nodes(graph: nx.Graph) -> dict[Hashable, NodeStyle]:
    """The style of each node by its label, in the schema of the graph's building type."""
    building_type = graph.graph.get("building_type")
    types = {building_type: 1.0} if isinstance(building_type, str) and building_type else {}
    rooms = tuple(Room(number, box(0, 0, 1, 1), label_of(graph, node)) for number, node in enumerate(graph, start=1))
    floor = Floor(rooms, building_type=types)
    looks, styles = choose_looks(floor), style_rooms(floor, ALL_SCHEMAS)
    return {
        node: NodeStyle(str(looks[number]["colour"]), styles[number].is_corridor)
        for number, node in enumerate(graph, start=1)
    }


def label_of(graph: nx.Graph, node: Hashable) -> str | None:
    """The label of a node; None if it has none."""
    label = graph.nodes[node].get("label")
    return label if isinstance(label, str) and label else None


def area_of(graph: nx.Graph, node: Hashable) -> float | None:
    """The area of a node, m²; None if it has none."""
    area = graph.nodes[node].get("area")
    return float(area) if isinstance(area, int | float) and not isinstance(area, bool) and area > 0 else None


def _name_in(graph: nx.Graph, node: Hashable, member: str) -> str | None:
    """The name of a known room, or of the open door of an unknown one."""
    name = graph.nodes[node].get(member)
    return str(name) if isinstance(name, int | str) else None
