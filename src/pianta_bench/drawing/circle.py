"""The closed circle: a drawn floor is scanned by a simulated robot, read again, and compared with itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import networkx as nx

from pianta.evaluation.floor_scores import score_floor
from pianta.floor import Floor
from pianta.generation.type_model import TypeModel
from pianta.labels import LabelSchema
from pianta.layout.reconstruct import reconstruct
from pianta.navigation.robot import ROBOT_RADIUS
from pianta.rooms.completion import map_labels_upwards
from pianta.rooms.label import label_rooms
from pianta.worlds.furnish import furnish_for_robot
from pianta.worlds.scan import simulate_map
from pianta_bench.harness.records import Figures

EMPTY = "empty"
SOME = "some furniture"
IN_USE = "in use, noise"
# By scan: furniture and noise of the map, as of `simulate_map`. IN_USE is furnished by labels, as `generate --worlds`.
SCANS: Mapping[str, tuple[float, float]] = MappingProxyType({EMPTY: (0.0, 0.0), SOME: (0.3, 0.0), IN_USE: (1.0, 0.3)})
ROOMS, DOORS = "rooms F1", "doors F1"
SAME, SAME_LABELLED = "same graph", "same graph with R/C"
R_C = "R/C"


def scan_and_read(floor: Floor, scan: str, schema: LabelSchema, *, seed: int) -> Figures:
    """F1 of rooms and doors, and whether the graph is isomorphic to that of the floor, without and with labels R/C.

    scan: of SCANS. seed: of furniture and noise.
    """
    furniture, noise = SCANS[scan]
    if scan == IN_USE:
        floor = furnish_for_robot(floor, furniture=furniture, radius=ROBOT_RADIUS, seed=seed)
        furniture = 0.0
    grid = simulate_map(floor, furniture=furniture, noise=noise, seed=seed)
    again = label_rooms(reconstruct(grid))
    scores = score_floor(again, floor)
    return {
        ROOMS: scores.rooms.f1,
        DOORS: scores.doors.f1,
        SAME: nx.is_isomorphic(again.graph(), floor.graph()),
        SAME_LABELLED: nx.is_isomorphic(
            build_labelled_graph(again),
            build_labelled_graph(map_labels_upwards(floor, schema)),
            node_match=lambda one, other: one["label"] == other["label"],
        ),
    }


def build_labelled_graph(floor: Floor) -> nx.Graph:
    """The topological graph with labels of R/C."""
    graph = floor.graph()
    nx.set_node_attributes(graph, {room.id: room.labels[R_C] for room in floor}, "label")
    return graph


def leave_geometry_out(model: TypeModel, sources: frozenset[str]) -> TypeModel:
    """The model without the floors of these sources, whose areas are then unknown; all that `draw_plan` needs."""
    return replace(model, floors=tuple(floor for floor in model.floors if floor.source not in sources))
