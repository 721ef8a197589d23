"""Areas of rooms by label, from the floors of a building type."""

from __future__ import annotations

from collections import defaultdict
from math import sqrt

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.errors import ModelError
from pianta.generation.type_model import TypeModel
from pianta.graphs.labelled_graphs import name_some
from pianta.graphs.metrics import find_corridors
from pianta.worlds.wall_axes import INNER_WALL

SIMILAR = 15  # corridors of the type of which one with a similar number of doors has its area chosen


def sample_areas(graph: nx.Graph, model: TypeModel, rng: np.random.Generator) -> dict[int, float]:
    """An area for each room, m² between the axes of its walls: that of a room of the type with the same label.

    Of corridors it is one with a similar number of doors.
    Raises ModelError with the labels of which the floors of the model have no area.
    """
    sizes: dict[str, list[tuple[float, int]]] = defaultdict(list)
    for floor in model.floors:
        for node, room in floor.graph.nodes(data=True):
            if "area" in room:
                sizes[room["label"]].append((room["area"], floor.graph.degree[node]))
    labels = dict(graph.nodes(data="label"))
    if missing := sorted({label for label in labels.values() if label not in sizes}):
        remedy = "train it on floors with outlines, or leave out these rooms with --at-most"
        raise ModelError(f"the model has no areas of rooms {name_some(missing)}, {remedy}")
    corridors = find_corridors(graph, model.schema)
    areas = {}
    for node, label in labels.items():
        table: NDArray[np.float64] = np.array(sizes[label])
        if node in corridors:
            difference = abs(table[:, 1] - graph.degree[node])
            table = table[np.argsort(difference, kind="stable")[:SIMILAR]]
        # A room measures less than the space between the axes of its walls
        areas[node] = (sqrt(float(rng.choice(table[:, 0]))) + INNER_WALL) ** 2
    return areas
