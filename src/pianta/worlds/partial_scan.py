"""The map of a robot that has explored a part of a building."""

from __future__ import annotations

from math import ceil, pi

import networkx as nx
import numpy as np
from shapely import LineString, Point, Polygon

from pianta._types import Mask
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import UNKNOWN, GridMap
from pianta.layout._label_images import grow_mask

# The constants were chosen by hand.
# Beams of a scan, evenly over 360°: 0.25° apart.
BEAMS = 1440
# Distance between the samples along a beam; cells.
STEP_PX = 0.5
# An echo shows occupied cells up to this many rows and columns away from it; cells.
ECHO_PX = 1
# Distance from one scan to the next; metres.
SCAN_SPACING = 2.0
# The robot chooses from this number of the doors that it has detected last.
DOOR_CHOICES = 4


def simulate_partial_map(
    floor: Floor, grid: GridMap, *, share: float, reach: float, entered: float = 0.5, seed: int = 0
) -> GridMap:
    """The map, with all cells unknown that a lidar has not observed from the viewpoints of a robot.

    The robot drives through the floor, always to a door that it has detected and not visited, and stops when it has
    visited a share of the doors. It takes a scan at each, and enters the room behind it with a probability.

    floor: with its doors, in the frame of the grid. share: of the doors, 0 … 1. entered: probability, 0 … 1. reach: of
    the lidar, metres. Raises OptionError for values out of range.
    """
    if not (0 <= share <= 1 and 0 <= entered <= 1 and reach > 0):
        raise OptionError(f"share is {share}, entered {entered} and reach {reach}, give 0 … 1, 0 … 1 and metres")
    observed = np.zeros(grid.shape, bool)
    for viewpoint in choose_viewpoints(floor, share=share, entered=entered, seed=seed):
        observed |= find_visible_cells(grid, viewpoint, reach=reach)
    return GridMap(np.where(observed, grid.cells, UNKNOWN), grid.resolution, grid.origin)


def choose_viewpoints(floor: Floor, *, share: float, entered: float, seed: int) -> list[Point]:
    """Points, metres, where a robot takes a scan: in its first room, on its way to doors, and in rooms behind them."""
    rng = np.random.default_rng(seed)
    rooms = {room.id: room.polygon for room in floor.rooms}
    graph = nx.MultiGraph()
    graph.add_nodes_from(rooms)
    graph.add_edges_from((*door.rooms, {"line": door.line}) for door in floor.doors if door.joins_rooms)
    start = int(rng.choice(list(rooms)))
    # The position of the robot when it detected each room
    stations = {start: _find_middle(rooms[start])}
    viewpoints, visited = [stations[start]], set()
    reachable = graph.subgraph(nx.node_connected_component(graph, start)).number_of_edges()
    for _ in range(round(share * reachable)):
        ahead = [edge for edge in graph.edges(stations, keys=True) if _edge_key(*edge) not in visited]
        # The doors detected last are nearest
        first, second, key = ahead[int(rng.integers(max(0, len(ahead) - DOOR_CHOICES), len(ahead)))]
        visited.add(_edge_key(first, second, key))
        door = graph.edges[first, second, key]["line"].interpolate(0.5, normalized=True)
        viewpoints += _list_viewpoints(stations[first], door)
        if second not in stations:
            enters = rng.random() < entered
            stations[second] = _find_middle(rooms[second]) if enters else door
            viewpoints += _list_viewpoints(door, stations[second]) if enters else []
    return viewpoints


def find_visible_cells(grid: GridMap, viewpoint: Point, *, reach: float) -> Mask:
    """Cells, shape (H, W), that a lidar detects within its reach, metres, and occupied cells beside its echoes."""
    row, col = grid.map_to_pixel(viewpoint.x, viewpoint.y)
    distances = np.arange(0, reach / grid.resolution, STEP_PX)
    angles = (np.arange(BEAMS) * 2 * pi / BEAMS)[:, None]
    rows = np.floor(row + distances * np.sin(angles)).astype(int).clip(0, grid.shape[0] - 1)
    cols = np.floor(col + distances * np.cos(angles)).astype(int).clip(0, grid.shape[1] - 1)
    stopped = np.cumsum(~grid.free[rows, cols], axis=1)
    visible, echoes = np.zeros(grid.shape, bool), np.zeros(grid.shape, bool)
    visible[rows[stopped == 0], cols[stopped == 0]] = True
    is_echo = grid.occupied[rows, cols] & (stopped == 1)
    echoes[rows[is_echo], cols[is_echo]] = True
    return np.asarray(visible | (grow_mask(echoes, ECHO_PX) & grid.occupied))


def _list_viewpoints(start: Point, end: Point) -> list[Point]:
    """Points on a straight line, at most SCAN_SPACING apart, without the start."""
    line = LineString([start, end])
    count = ceil(line.length / SCAN_SPACING)
    return [line.interpolate(share, normalized=True) for share in np.linspace(0, 1, count + 1)[1:]]


def _edge_key(first: int, second: int, key: int) -> tuple[int, int, int]:
    return min(first, second), max(first, second), key


def _find_middle(room: Polygon) -> Point:
    return room.centroid if room.contains(room.centroid) else room.representative_point()
