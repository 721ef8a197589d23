"""The programme of a building: its rooms, with the areas that they need and how much they need windows."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import networkx as nx
import numpy as np

from pianta.generation.drawing.blocks import CELL
from pianta.generation.drawing.choices import Edge
from pianta.generation.drawing.gaps import GROWTH
from pianta.generation.drawing.room_sizes import sample_areas, sample_corridor_aspects
from pianta.generation.drawing.site import FILLED, Site
from pianta.generation.room_shapes import OPENING
from pianta.generation.type_model import TypeModel
from pianta.graphs.metrics import find_corridors

DOOR_WIDTHS = (0.7, 2.0)  # narrowest and widest door, m
USUAL_DOOR = 0.9  # m, of types whose doors are not known
AREA_CHOICES = 12  # of areas, of which those are taken that fill a site best; chosen by hand
PRIOR_DOORS = 2.0  # between corridors with two labels, of which as many are openings as of all; chosen by hand
LEAST_WINDOW = 2.0  # m of outer wall, with which a room has windows


@dataclass(frozen=True, eq=False)
class Programme:
    """What is drawn.

    graph: connected; nodes are integers. corridors: nodes. areas: of each room, in cells. window_needs: of each room,
    0 to 1. door_widths: of which each door has one, m. opening_shares: how probable an opening is instead of a door, by
    the edges where it is. site: in which the building is drawn; None for anywhere. aspects: the longer side over the
    shorter one of each corridor, those that are known.
    """

    graph: nx.Graph
    corridors: frozenset[Any]
    areas: Mapping[int, float]
    window_needs: Mapping[int, float]
    door_widths: Sequence[float]
    opening_shares: Mapping[Edge, float] = field(default_factory=dict)
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
    corridors = find_corridors(graph, model.schema)
    return Programme(
        graph,
        corridors,
        {room: area / CELL**2 / (GROWTH if room in corridors else 1) for room, area in areas.items()},
        {room: needs.get(label, 0.0) for room, label in graph.nodes(data="label")},
        list_door_widths(model),
        find_opening_shares(graph, model),
        site,
        sample_corridor_aspects(graph, model, areas, rng),
    )


def make_site_programme(graph: nx.Graph, model: TypeModel, rng: np.random.Generator, site: Site) -> Programme:
    """Of programmes with areas of several floors, the one that fills a site best.

    Raises ModelError as `make_programme`.
    """
    programmes = [make_programme(graph, model, rng, site) for _ in range(AREA_CHOICES)]
    return min(programmes, key=lambda programme: abs(sum(programme.areas.values()) - FILLED * site.area))


def list_door_widths(model: TypeModel) -> list[float]:
    """The widths of doors that people can pass and that are no gates, m."""
    least, most = DOOR_WIDTHS
    widths = [width for floor in model.floors for *_, width in floor.graph.edges(data="width") if width is not None]
    return [width for width in widths if least <= width <= most] or [USUAL_DOOR]


def find_opening_shares(graph: nx.Graph, model: TypeModel) -> dict[Edge, float]:
    """How probable an opening is instead of a door, by the doors of a graph between two corridors.

    It is the share of openings between corridors with the labels of both on the floors of the type, with PRIOR_DOORS
    doors that are like those between all corridors. Empty if no opening is known.
    """
    openings: dict[frozenset[str], list[bool]] = defaultdict(list)
    for floor in model.floors:
        corridors = find_corridors(floor.graph, model.schema)
        for one, other, opening in floor.graph.subgraph(corridors).edges(data=OPENING):
            if opening is not None:
                openings[_name_labels(floor.graph, one, other)].append(opening)
    all_openings = [*chain.from_iterable(openings.values())]
    if not any(all_openings):
        return {}
    prior, shares = PRIOR_DOORS * float(np.mean(all_openings)), {}
    corridors = find_corridors(graph, model.schema)
    for one, other in graph.edges:
        if {one, other} <= corridors:
            own = openings[_name_labels(graph, one, other)]
            shares[one, other] = (sum(own) + prior) / (len(own) + PRIOR_DOORS)
    return shares


def _name_labels(graph: nx.Graph, one: int, other: int) -> frozenset[str]:
    return frozenset(graph.nodes[node]["label"] for node in (one, other))


def find_window_needs(model: TypeModel) -> dict[str, float]:
    """How much rooms need windows, by label: 1 if all rooms of the type have some, 0 if half of them or fewer have."""
    lit: dict[str, list[bool]] = defaultdict(list)
    for floor in model.floors:
        for _, room in floor.graph.nodes(data=True):
            if "outer_wall" in room:
                lit[room["label"]].append(room["outer_wall"] >= LEAST_WINDOW)
    return {label: max(0.0, 2 * float(np.mean(has_windows)) - 1) for label, has_windows in sorted(lit.items())}
