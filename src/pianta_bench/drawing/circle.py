"""The closed circle: a drawn floor is scanned by a simulated robot, read again, and compared with itself."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import cv2
import networkx as nx
import numpy as np
import shapely

from pianta.evaluation.floor_scores import score_floor
from pianta.evaluation.graph_sets import find_copies
from pianta.floor import Floor
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
REACHED = "rooms reached"
SAME, SAME_LABELLED = "same graph", "same graph with R/C"
R_C = "R/C"


def scan_and_read(floor: Floor, scan: str, schema: LabelSchema, *, seed: int) -> Figures:
    """F1 of rooms and doors, and whether the graph is isomorphic to that of the floor, without and with labels R/C.

    Also the share of furnished rooms that a robot reaches, if the scan is IN_USE.
    scan: of SCANS. seed: of furniture and noise.
    """
    furniture, noise = SCANS[scan]
    reached = {}
    if scan == IN_USE:
        floor = furnish_for_robot(floor, furniture=furniture, radius=ROBOT_RADIUS, seed=seed)
        furniture, reached = 0.0, {REACHED: count_reached_rooms(floor) / len(floor)}
    grid = simulate_map(floor, furniture=furniture, noise=noise, seed=seed)
    again = label_rooms(reconstruct(grid))
    scores = score_floor(again, floor)
    return {
        **reached,
        ROOMS: scores.rooms.f1,
        DOORS: scores.doors.f1,
        SAME: have_same_graph(again, floor),
        SAME_LABELLED: have_same_graph(again, map_labels_upwards(floor, schema), labels=True),
    }


def count_reached_rooms(floor: Floor) -> int:
    """The rooms that a robot gets into on the map of a furnished floor, from where it has most space."""
    grid = simulate_map(floor, furniture=0.0, noise=0.0)
    clearance = cv2.distanceTransform(grid.free.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE) * grid.resolution
    is_passable = (clearance >= ROBOT_RADIUS).astype(np.uint8)
    if not is_passable.any():
        return 0
    _, parts, sizes, _ = cv2.connectedComponentsWithStats(is_passable, connectivity=8)
    rows, cols = np.nonzero(parts == 1 + np.argmax(sizes[1:, cv2.CC_STAT_AREA]))
    x, y = grid.pixel_to_map(rows + 0.5, cols + 0.5)
    return sum(bool(shapely.contains_xy(room.polygon, x, y).any()) for room in floor)


def have_same_graph(one: Floor, other: Floor, *, labels: bool = False) -> bool:
    """Whether the topological graphs, with `labels` those with labels of R/C, are isomorphic."""
    graphs = [floor.graph() for floor in (one, other)]
    for graph, floor in zip(graphs, (one, other), strict=True):
        nx.set_node_attributes(graph, {room.id: room.labels[R_C] if labels else "" for room in floor}, "label")
    # networkx alone tries all orders of the rooms at a corridor of which one has another label, which takes hours
    return find_copies(graphs[:1], graphs[1:])[0]
