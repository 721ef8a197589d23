"""A plan to clean a floor: the rooms in a tour, and in each the path that sweeps it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import networkx as nx
import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.errors import FloorError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.navigation.free_space import FreeSpace, find_free_space
from pianta.navigation.positions import Cell, locate_doors, locate_rooms
from pianta.navigation.robot import ROBOT_RADIUS
from pianta.navigation.route_graph import join_positions
from pianta.navigation.sweep import (
    SweepArea,
    connect_points,
    dilate,
    find_swept_cells,
    measure_length,
    sweep_once,
    sweep_room,
)

LEAST_SAVED = 1e-9  # metres, of an exchange of steps of the tour


@dataclass(frozen=True)
class Coverage:
    """How much of a floor paths sweep.

    Attributes
    ----------
    coverage
        Share of the floor that the robot's disc can sweep from positions where it fits.
    overlap
        Length of the paths times the robot's width over the swept area, minus 1: what is swept again.
    length
        Metres of the paths, without the ways from room to room.
    """

    coverage: float
    overlap: float
    length: float


@dataclass(frozen=True, eq=False)
class CleaningPlan:
    """The rooms of a floor in the order in which a robot cleans them.

    Attributes
    ----------
    rooms
        The ids of the rooms that the robot reaches, a tour that ends near its start.
    paths
        Room id -> the corners x, y of the path that sweeps it, metres, shape (N, 2).
    ways
        Room id -> the corners of the way to the start of its path from the end of the one before, shape (M, 2); of the
        first room from that of the last.
    swept
        How much the paths sweep.
    left_out
        The ids of the rooms that the robot does not reach.
    """

    rooms: tuple[int, ...]
    paths: Mapping[int, Floats]
    ways: Mapping[int, Floats]
    swept: Coverage
    left_out: tuple[int, ...]


def plan_cleaning(floor: Floor, grid: GridMap, *, robot_radius: float = ROBOT_RADIUS) -> CleaningPlan:
    """Plan how a round robot cleans a floor: a tour of the rooms, and a path in each that sweeps it around obstacles.

    Parameters
    ----------
    floor
        Its rooms and doors.
    grid
        Its map; occupied cells are obstacles, and the robot drives on free cells only.
    robot_radius
        Metres; it cleans what is below it.

    Returns
    -------
    CleaningPlan
        The order, the paths, and how much they sweep.

    Raises
    ------
    FloorError
        The robot fits nowhere.

    References
    ----------
    H. Choset, Coverage of known spaces: the boustrophedon cellular decomposition, Autonomous Robots 9, 2000.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> plan = pianta.plan_cleaning(floor, grid)
    >>> len(plan.rooms), plan.swept.coverage > 0.95
    (19, True)
    """
    space = find_free_space(floor, grid, robot_radius)
    doors = locate_doors(space, floor)
    cells = locate_rooms(space, floor, doors)
    graph = join_positions(space, floor, cells, doors)
    order = _order_rooms(graph, [*cells])
    if not order:
        raise FloorError(f"a robot of {robot_radius} m radius fits nowhere, give a smaller robot_radius")
    areas = {room: _cut_area(space, room, cells[room]) for room in order}
    paths = {}
    for room, area in areas.items():
        row, col = cells[room]
        paths[room] = sweep_room(area, (row - area.corner[0], col - area.corner[1])) + np.array(area.corner)
    return CleaningPlan(
        tuple(order),
        {room: space.to_map(path) for room, path in paths.items()},
        _find_ways(areas, graph, cells, paths),
        _measure_coverage(space, areas, [*paths.values()]),
        tuple(room.id for room in floor if room.id not in paths),
    )


def measure_plain_sweep(
    floor: Floor, grid: GridMap, rooms: Iterable[int], *, robot_radius: float = ROBOT_RADIUS
) -> Coverage:
    """How much a sweep in one pass sweeps, to compare with: lanes a robot's width apart, one after the other.

    Parameters
    ----------
    floor, grid, robot_radius
        As for `plan_cleaning`.
    rooms
        The ids of the rooms that are swept, `rooms` of a plan.

    Returns
    -------
    Coverage
        Of these rooms.

    Examples
    --------
    >>> import pianta
    >>> from pianta.navigation.cleaning import measure_plain_sweep
    >>> floor, grid = pianta.make_world("home")
    >>> plan = pianta.plan_cleaning(floor, grid)
    >>> measure_plain_sweep(floor, grid, plan.rooms).coverage < plan.swept.coverage
    True
    """
    space = find_free_space(floor, grid, robot_radius)
    cells = locate_rooms(space, floor, locate_doors(space, floor))
    areas = {room: _cut_area(space, room, cells[room]) for room in rooms}
    paths = [sweep_once(area) + np.array(area.corner) for area in areas.values()]
    return _measure_coverage(space, areas, paths)


def _order_rooms(graph: nx.DiGraph, rooms: list[int]) -> list[int]:
    """A short tour of the rooms of the largest connected part of the route graph: Christofides', improved by 2-opt."""
    parts = [[room for room in rooms if room in part] for part in nx.weakly_connected_components(graph)]
    reached = max(parts, key=len, default=[])
    if len(reached) < 3:
        return reached
    costs = _measure_ways(graph, reached)
    complete = nx.from_numpy_array(costs)
    tours = [nx.approximation.greedy_tsp(complete), nx.approximation.christofides(complete)]
    improved = [improve_tour(costs, np.array(tour[:-1])) for tour in tours]
    tour = min(improved, key=lambda tour: float(costs[tour, np.roll(tour, -1)].sum()))
    first = int((tour == 0).argmax())
    return [reached[number] for number in np.roll(tour, -first).tolist()]


def _measure_ways(graph: nx.DiGraph, rooms: list[int]) -> Floats:
    """The costs of the cheapest ways between all rooms, shape (N, N)."""
    from scipy.sparse.csgraph import dijkstra

    numbers = {node: number for number, node in enumerate(graph)}
    chosen = [numbers[room] for room in rooms]
    matrix = nx.to_scipy_sparse_array(graph, weight="cost")
    costs: Floats = dijkstra(matrix, indices=chosen)[:, chosen]
    return np.minimum(costs, costs.T)


def improve_tour(costs: Floats, tour: Indices) -> Indices:
    """A closed tour without two steps that are better exchanged for two others (2-opt): the best exchange each time.

    costs: between all places, symmetric, shape (N, N). tour: the places in their order, shape (N,).
    """
    while True:
        following = np.roll(tour, -1)
        steps = costs[tour, following]
        saved = np.triu(np.add.outer(steps, steps) - costs[np.ix_(tour, tour)] - costs[np.ix_(following, following)], 1)
        first, second = np.unravel_index(int(saved.argmax()), saved.shape)
        if saved[first, second] <= LEAST_SAVED:
            return tour
        tour = tour.copy()
        tour[first + 1 : second + 1] = tour[first + 1 : second + 1][::-1]


def _cut_area(space: FreeSpace, room: int, cell: Cell) -> SweepArea:
    """The open cells of a room that are joined with a cell of it on the floor, in a window."""
    part = (space.rooms == room) & (space.parts == space.parts[cell])
    rows, cols = np.flatnonzero(part.any(axis=1)), np.flatnonzero(part.any(axis=0))
    # The disc of the robot is in the window too
    reach = int(space.radius / space.grid.resolution) + 2
    top, left = max(rows[0] - reach, 0), max(cols[0] - reach, 0)
    return SweepArea(space, part[top : rows[-1] + reach + 1, left : cols[-1] + reach + 1], (int(top), int(left)))


def _find_goal(space: FreeSpace, areas: Mapping[int, SweepArea]) -> Mask:
    """The cells that the robot can sweep from its open cells in these rooms, shape (H, W)."""
    is_inside = np.zeros(space.open.shape, bool)
    for area in areas.values():
        (top, left), (height, width) = area.corner, area.part.shape
        is_inside[top : top + height, left : left + width] |= area.part
    return dilate(is_inside, space.radius / space.grid.resolution)


def _measure_coverage(space: FreeSpace, areas: Mapping[int, SweepArea], paths: list[Indices]) -> Coverage:
    goal = _find_goal(space, areas)
    swept = find_swept_cells(paths, goal.shape, space.radius / space.grid.resolution)
    length = sum(map(measure_length, paths)) * space.grid.resolution
    area = float(np.count_nonzero(swept)) * space.grid.resolution**2
    return Coverage(float((swept & goal).sum() / goal.sum()), length * 2 * space.radius / area - 1, length)


def _find_ways(
    areas: Mapping[int, SweepArea], graph: nx.DiGraph, cells: Mapping[int, Cell], paths: Mapping[int, Indices]
) -> dict[int, Floats]:
    """The ways between the paths of rooms, over the route graph; areas: in the order of the tour."""
    order = [*areas]
    ways = {}
    for before, room in zip([order[-1], *order[:-1]], order, strict=True):
        nodes = nx.shortest_path(graph, before, room, weight="cost")
        positions = [[graph.nodes[node]["x"], graph.nodes[node]["y"]] for node in nodes]
        leave = _join_cells(areas[before], paths[before][-1], cells[before])
        arrive = _join_cells(areas[room], paths[room][0], cells[room])[::-1]
        ways[room] = np.concatenate([leave[:-1], positions, arrive[1:]])
    return ways


def _join_cells(area: SweepArea, start: Indices, end: Cell) -> Floats:
    """The corners of a way between two cells of the map, x and y."""
    top, left = area.corner
    path = connect_points(area, [(int(start[0]) - top, int(start[1]) - left), (end[0] - top, end[1] - left)])
    return area.space.to_map(path + np.array(area.corner))
