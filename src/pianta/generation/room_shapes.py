"""Shapes of the rooms of a floor, as attributes of its graph: what drawn buildings have in common with real ones."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import networkx as nx
import shapely

from pianta.floor import Floor
from pianta.rooms._outlines import draw_outlines, measure_unit
from pianta.rooms._shapes import fit_rectangles
from pianta.rooms._surroundings import measure_facades

# Attributes of rooms (m², without unit, m) and of doors (m) that a model keeps, and their least and largest values.
ROOM_MEASURES = {"area": (0.01, 1e9), "aspect": (1.0, 1e6), "outer_wall": (0.0, 1e6)}
DOOR_MEASURES = {"width": (0.01, 1e6)}
# Attribute of doors that a model keeps: whether it is an opening instead of a door.
OPENING = "opening"


def describe_shapes(floor: Floor) -> nx.Graph:
    """The graph of a floor, whose rooms have two attributes more, and whose edges have one.

    `aspect`: the longer side of the smallest rectangle around a room over the shorter one. `outer_wall`: how much of
    its outline is at the façade, m. `opening`: whether two rooms are joined by an opening instead of a door.
    """
    graph = floor.graph()
    nx.set_edge_attributes(graph, values=False, name=OPENING)
    for door in floor.doors:
        if door.joins_rooms and door.kind == "opening":
            graph.edges[door.rooms][OPENING] = True
    if not floor.rooms:
        return graph
    unit = measure_unit(floor)
    outlines = draw_outlines(floor, unit)
    rectangles = fit_rectangles(outlines)
    outer_walls = measure_facades(outlines, rectangles, unit)["facade"] * shapely.length(outlines)
    aspects = rectangles.length / rectangles.width
    for room, aspect, outer_wall in zip(floor, aspects.tolist(), outer_walls.tolist(), strict=True):
        graph.nodes[room.id].update(aspect=aspect, outer_wall=outer_wall)
    return graph


def list_door_attributes(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """What a model keeps of a door: its measures, and whether it is an opening, if known."""
    opening = attributes.get(OPENING)
    return {
        **list_measures(attributes, DOOR_MEASURES),
        **({OPENING: opening} if isinstance(opening, bool) else {}),
    }


def list_measures(attributes: Mapping[str, Any], ranges: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    """The attributes that are numbers in their range; others are unknown."""
    measures = {name: attributes.get(name) for name in ranges}
    numbers = {name: value for name, value in measures.items() if isinstance(value, int | float)}
    return {
        name: float(value)
        for name, value in numbers.items()
        if not isinstance(value, bool) and ranges[name][0] <= value <= ranges[name][1]
    }
