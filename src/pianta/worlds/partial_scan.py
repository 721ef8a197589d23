"""The map that a robot has made of a building before it has seen all of it."""

from __future__ import annotations

from math import ceil, pi

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from shapely import LineString, Point, Polygon

from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.gridmap import UNKNOWN, GridMap

# Angle between two beams, rad, and their step, in cells.
BEAMS, STEP_PX = 1440, 0.5
# The echo of a beam shows the cells beside it too.
ECHO_PX = 1
# Metres from one look to the next, and how many of the doors that it knows last a robot chooses from.
STRIDE, NEAREST = 2.0, 4


def explore_in_part(
    floor: Floor, grid: GridMap, *, share: float, reach: float, entered: float = 0.5, seed: int = 0
) -> GridMap:
    """The map, unknown wherever a lidar has not seen it from the places that a robot went to.

    The robot walks from room to room through the doors, always to one that it knows and has not been at, and stops when
    it has been at a share of the doors. At each it looks around, and enters the room with some chance.

    floor: with its doors, in the frame of the grid. share, entered: 0 … 1. reach: of the lidar, metres.
    Raises OptionError for a share or a reach without meaning.
    """
    if not (0 <= share <= 1 and 0 <= entered <= 1 and reach > 0):
        raise OptionError(f"share is {share}, entered {entered} and reach {reach}, give 0 … 1, 0 … 1 and metres")
    seen = np.zeros(grid.shape, bool)
    for place in walk_rooms(floor, share=share, entered=entered, seed=seed):
        seen |= see_cells(grid, place, reach=reach)
    return GridMap(np.where(seen, grid.cells, UNKNOWN), grid.resolution, grid.origin)


def walk_rooms(floor: Floor, *, share: float, entered: float, seed: int) -> list[Point]:
    """Places, metres, where a robot looks around: in its first room, on its way to doors, and in rooms behind them."""
    rng = np.random.default_rng(seed)
    rooms = {room.id: room.polygon for room in floor.rooms}
    graph = nx.MultiGraph()
    graph.add_nodes_from(rooms)
    graph.add_edges_from((*door.rooms, {"line": door.line}) for door in floor.doors if not door.is_entrance)
    start = int(rng.choice(list(rooms)))
    # Where the robot was when it came to know each room
    stations = {start: _find_middle(rooms[start])}
    places, passed = [stations[start]], set()
    reachable = graph.subgraph(nx.node_connected_component(graph, start)).number_of_edges()
    for _ in range(round(share * reachable)):
        ahead = [edge for edge in graph.edges(stations, keys=True) if _name_edge(*edge) not in passed]
        # What it came to know last is nearest
        first, second, key = ahead[int(rng.integers(max(0, len(ahead) - NEAREST), len(ahead)))]
        passed.add(_name_edge(first, second, key))
        door = graph.edges[first, second, key]["line"].interpolate(0.5, normalized=True)
        places += _walk_straight(stations[first], door)
        if second not in stations:
            goes_in = rng.random() < entered
            stations[second] = _find_middle(rooms[second]) if goes_in else door
            places += _walk_straight(door, stations[second]) if goes_in else []
    return places


def see_cells(grid: GridMap, place: Point, *, reach: float) -> NDArray[np.bool_]:
    """Cells, shape (H, W), that a lidar at a place, metres, sees within its reach; an echo shows what is beside it."""
    row, col = grid.map_to_pixel(place.x, place.y)
    distances = np.arange(0, reach / grid.resolution, STEP_PX)
    angles = (np.arange(BEAMS) * 2 * pi / BEAMS)[:, None]
    rows = np.floor(row + distances * np.sin(angles)).astype(int).clip(0, grid.shape[0] - 1)
    cols = np.floor(col + distances * np.cos(angles)).astype(int).clip(0, grid.shape[1] - 1)
    stopped = np.cumsum(~grid.free[rows, cols], axis=1)
    passed = stopped == 0
    seen = np.zeros(grid.shape, bool)
    seen[rows[passed], cols[passed]] = True
    echoes = grid.occupied[rows, cols] & (stopped == 1)
    wall = np.zeros(grid.shape, bool)
    for down in range(-ECHO_PX, ECHO_PX + 1):
        for right in range(-ECHO_PX, ECHO_PX + 1):
            beside = (rows[echoes] + down).clip(0, grid.shape[0] - 1), (cols[echoes] + right).clip(0, grid.shape[1] - 1)
            wall[beside] = True
    return np.asarray(seen | (wall & grid.occupied))


def _walk_straight(start: Point, end: Point) -> list[Point]:
    way = LineString([start, end])
    return [way.interpolate(share, normalized=True) for share in np.linspace(0, 1, ceil(way.length / STRIDE) + 1)[1:]]


def _name_edge(first: int, second: int, key: int) -> tuple[int, int, int]:
    return min(first, second), max(first, second), key


def _find_middle(room: Polygon) -> Point:
    return room.centroid if room.contains(room.centroid) else room.representative_point()
