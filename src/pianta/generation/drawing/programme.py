"""The programme of a building: its rooms, with the areas that they need and how much they need windows."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import networkx as nx
import numpy as np

from pianta.generation.drawing.blocks import CELL
from pianta.generation.drawing.gaps import GROWTH
from pianta.generation.drawing.room_sizes import sample_areas, sample_corridor_aspects
from pianta.generation.drawing.site import Site
from pianta.generation.room_shapes import OPENING
from pianta.generation.type_model import TypeModel
from pianta.graphs.metrics import find_corridors

DOOR_WIDTHS = (0.7, 2.0)  # narrowest and widest door, m
USUAL_DOOR = 0.9  # m, of types whose doors are not known
LEAST_WINDOW = 2.0  # m of outer wall, with which a room has windows


@dataclass(frozen=True, eq=False)
class Programme:
    """What is drawn.

    graph: connected; nodes are integers. corridors: nodes. areas: of each room, in cells. window_needs: of each room,
    0 to 1. door_widths: of which each door has one, m. opening_share: of the doors between two corridors, how many
    are openings. site: in which the building is drawn; None for anywhere. aspects: the longer side over the shorter one
    of each corridor, those that are known.
    """

    graph: nx.Graph
    corridors: frozenset[Any]
    areas: Mapping[int, float]
    window_needs: Mapping[int, float]
    door_widths: Sequence[float]
    opening_share: float = 0.0
    site: Site | None = None
    aspects: Mapping[int, float] = field(default_factory=dict)

    def scaled(self, scale: float) -> Programme:
        """The programme with areas that are multiplied."""
        return replace(self, areas={room: scale * area for room, area in self.areas.items()})


def make_programme(graph: nx.Graph, model: TypeModel, rng: np.random.Generator, site: Site | None = None) -> Programme:
    """The programme of a graph, with areas of rooms of the type, most of them those of one floor.

    Raises ModelError with the labels of which the floors of the model have no area.
    """
    areas = sample_areas(graph, model, rng, from_one_floor=True)
    needs = find_window_needs(model)
    return Programme(
        graph,
        find_corridors(graph, model.schema),
        {room: area / CELL**2 / GROWTH for room, area in areas.items()},
        {room: needs.get(label, 0.0) for room, label in graph.nodes(data="label")},
        list_door_widths(model),
        find_opening_share(model),
        site,
        sample_corridor_aspects(graph, model, areas, rng),
    )


def list_door_widths(model: TypeModel) -> list[float]:
    """The widths of doors that people can pass and that are no gates, m."""
    least, most = DOOR_WIDTHS
    widths = [width for floor in model.floors for *_, width in floor.graph.edges(data="width") if width is not None]
    return [width for width in widths if least <= width <= most] or [USUAL_DOOR]


def find_opening_share(model: TypeModel) -> float:
    """The share of openings of what joins two corridors on the floors of a type; 0 if none is known."""
    openings: list[bool] = []
    for floor in model.floors:
        corridors = find_corridors(floor.graph, model.schema)
        between = floor.graph.subgraph(corridors).edges(data=OPENING)
        openings += [opening for *_, opening in between if opening is not None]
    return float(np.mean(openings)) if openings else 0.0


def find_window_needs(model: TypeModel) -> dict[str, float]:
    """How much rooms need windows, by label: 1 if all rooms of the type have some, 0 if half of them or fewer have."""
    lit: dict[str, list[bool]] = defaultdict(list)
    for floor in model.floors:
        for _, room in floor.graph.nodes(data=True):
            if "outer_wall" in room:
                lit[room["label"]].append(room["outer_wall"] >= LEAST_WINDOW)
    return {label: max(0.0, 2 * float(np.mean(has_windows)) - 1) for label, has_windows in sorted(lit.items())}
