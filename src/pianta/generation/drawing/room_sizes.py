"""Areas of rooms by label, from the floors of a building type."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from math import sqrt
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.errors import ModelError
from pianta.generation.type_model import TypeModel
from pianta.graphs.labelled_graphs import name_some
from pianta.graphs.metrics import find_corridors
from pianta.worlds.wall_axes import INNER_WALL

SIMILAR = 15  # corridors of the type of which one with a similar number of doors has its area chosen
SIMILAR_AREAS = 5  # of these corridors, of which one has its aspect chosen
OWN_SHARE = 0.75  # of the rooms of a building whose areas are those of one floor; chosen by hand


def sample_areas(
    graph: nx.Graph, model: TypeModel, rng: np.random.Generator, *, from_one_floor: bool = False
) -> dict[int, float]:
    """An area for each room, m² between the axes of its walls: that of a room of the type with the same label.

    Of corridors it is one with a similar number of doors. from_one_floor: whether most other rooms have areas of one
    floor, as the rooms of a building with one label are similar; then corridors with more wall beside them are larger.
    Raises ModelError with the labels of which the floors of the model have no area.
    """
    labels = dict(graph.nodes(data="label"))
    tables = _list_areas(model, set(labels.values()))
    corridors = find_corridors(graph, model.schema)
    own = _choose_floors(tables, [*labels.values()], rng) if from_one_floor else {}
    areas = {}
    for node, label in labels.items():
        table = tables[label]
        if node in corridors:
            difference = abs(table[:, 1] - graph.degree[node])
            table = table[np.argsort(difference, kind="stable")[:SIMILAR]]
        elif own and rng.random() < OWN_SHARE:
            table = own[label]
        # A room measures less than the space between the axes of its walls
        areas[node] = (sqrt(float(rng.choice(table[:, 0]))) + INNER_WALL) ** 2
    return _match_corridors(graph, areas, corridors) if from_one_floor else areas


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
        for column, value, count in ((0, graph.degree[node], SIMILAR), (1, areas[node], SIMILAR_AREAS)):
            difference = abs(table[:, column] - value)
            table = table[np.argsort(difference, kind="stable")[:count]]
        aspects[node] = float(rng.choice(table[:, 2]))
    return aspects


def _list_areas(model: TypeModel, labels: set[str]) -> dict[str, NDArray[np.float64]]:
    """Area, number of doors and number of the floor of each room of the type with one of the labels, by label."""
    sizes: dict[str, list[tuple[float, int, int]]] = defaultdict(list)
    for number, floor in enumerate(model.floors):
        for node, room in floor.graph.nodes(data=True):
            if "area" in room:
                sizes[room["label"]].append((room["area"], floor.graph.degree[node], number))
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


def _match_corridors(graph: nx.Graph, areas: dict[int, float], corridors: frozenset[Any]) -> dict[int, float]:
    """The areas, of which corridors with one label exchange theirs: the more wall beside it, the larger a corridor."""
    matched = dict(areas)
    for label in sorted({graph.nodes[node]["label"] for node in corridors}):
        alike = [node for node in graph if node in corridors and graph.nodes[node]["label"] == label]
        walls = {node: sum(sqrt(areas[room]) for room in graph[node]) for node in alike}
        alike.sort(key=walls.__getitem__)
        matched |= dict(zip(alike, sorted(areas[node] for node in alike), strict=True))
    return matched
