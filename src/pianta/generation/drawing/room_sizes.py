"""Areas of rooms by label, from the floors of a building type."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from math import sqrt

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.errors import ModelError
from pianta.generation.type_model import TypeModel
from pianta.graphs.labelled_graphs import name_some
from pianta.graphs.metrics import find_corridors
from pianta.worlds.wall_axes import INNER_WALL

SIMILAR = 15  # corridors of the type with about as much wall of rooms, of which one has its area chosen
PASSES = 3  # over the corridors, as the area of each depends on those of its neighbours
SIMILAR_DOORS = 15  # corridors of the type with a similar number of doors
SIMILAR_AREAS = 5  # of these, of which one has its aspect chosen
OWN_SHARE = 0.75  # of the rooms of a building whose areas are those of one floor; chosen by hand


def sample_areas(
    graph: nx.Graph, model: TypeModel, rng: np.random.Generator, *, from_one_floor: bool = False
) -> dict[int, float]:
    """An area for each room, m² between the axes of its walls: that of a room of the type with the same label.

    Of corridors it is one at which there is about as much wall of rooms. from_one_floor: whether most other rooms have
    areas of one floor, as the rooms of a building with one label are similar.
    Raises ModelError with the labels of which the floors of the model have no area.
    """
    labels = dict(graph.nodes(data="label"))
    tables = _list_areas(model, set(labels.values()))
    corridors = find_corridors(graph, model.schema)
    own = _choose_floors(tables, [*labels.values()], rng) if from_one_floor else {}
    areas = {}
    for node, label in labels.items():
        table = own[label] if own and node not in corridors and rng.random() < OWN_SHARE else tables[label]
        areas[node] = float(rng.choice(table[:, 0]))
    for node in PASSES * [node for node in graph if node in corridors]:
        table = tables[labels[node]]
        difference = abs(table[:, 1] - measure_wall(graph, node, areas))
        areas[node] = float(rng.choice(table[np.argsort(difference, kind="stable")[:SIMILAR], 0]))
    # A room measures less than the space between the axes of its walls
    return {node: (sqrt(area) + INNER_WALL) ** 2 for node, area in areas.items()}


def measure_wall(graph: nx.Graph, room: int, areas: Mapping[int, float]) -> float:
    """The sides of squares as large as the rooms behind the doors of a room, m; areas: m², of those that are known."""
    return sum(sqrt(areas[each]) for each in graph[room] if each in areas)


def sample_corridor_aspects(
    graph: nx.Graph, model: TypeModel, areas: Mapping[int, float], rng: np.random.Generator
) -> dict[int, float]:
    """The longer side over the shorter one of each corridor: that of one of the type with the same label.

    Of those with a similar number of doors it is one with a similar area. areas: of the rooms, m². Empty for a model
    without aspects.
    """
    shapes: dict[str, list[tuple[float, float, float]]] = defaultdict(list)
    for floor in model.floors:
        for node, room in floor.graph.nodes(data=True):
            if "area" in room and "aspect" in room:
                shapes[room["label"]].append((floor.graph.degree[node], room["area"], room["aspect"]))
    corridors, aspects = find_corridors(graph, model.schema), {}
    for node, label in graph.nodes(data="label"):
        if node not in corridors or not shapes[label]:
            continue
        table = np.array(shapes[label])
        for column, value, count in ((0, graph.degree[node], SIMILAR_DOORS), (1, areas[node], SIMILAR_AREAS)):
            difference = abs(table[:, column] - value)
            table = table[np.argsort(difference, kind="stable")[:count]]
        aspects[node] = float(rng.choice(table[:, 2]))
    return aspects


def _list_areas(model: TypeModel, labels: set[str]) -> dict[str, NDArray[np.float64]]:
    """Area, wall (`measure_wall`) and number of the floor of each room of the type with one of the labels, by label."""
    sizes: dict[str, list[tuple[float, float, int]]] = defaultdict(list)
    for number, floor in enumerate(model.floors):
        areas = {node: room["area"] for node, room in floor.graph.nodes(data=True) if "area" in room}
        for node, area in areas.items():
            sizes[floor.graph.nodes[node]["label"]].append((area, measure_wall(floor.graph, node, areas), number))
    if missing := sorted(labels - sizes.keys()):
        remedy = "train it on floors with outlines, or leave out these rooms with --at-most"
        raise ModelError(f"the model has no areas of rooms {name_some(missing)}, {remedy}")
    return {label: np.array(sizes[label]) for label in sorted(labels)}


def _choose_floors(
    tables: Mapping[str, NDArray[np.float64]], labels: Sequence[str], rng: np.random.Generator
) -> dict[str, NDArray[np.float64]]:
    """The areas of the rooms of one floor, by label; of another floor for labels that it does not have.

    labels: of the rooms of the building. A floor with many rooms of a label that is frequent in it is probable, so that
    all buildings together have rooms as large as those of the type; by the square of how frequent it is, as most rooms
    with areas of one floor have such a label.
    """
    names, counts = np.unique(labels, return_counts=True)
    frequent = str(rng.choice(names, p=counts**2 / (counts**2).sum()))
    floor = rng.choice(tables[frequent][:, 2])
    chosen = {}
    for label, table in tables.items():
        is_own = table[:, 2] == floor
        chosen[label] = table[is_own if is_own.any() else table[:, 2] == rng.choice(table[:, 2])]
    return chosen
