"""A plan to clean a floor: the rooms in a tour, and in each the path that sweeps it."""

from __future__ import annotations

from collections.abc import Mapping
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
from pianta.navigation.route_graph import build_route_graph
from pianta.navigation.sweep import (
    SweepArea,
    dilate,
    find_swept_cells,
    find_way,
    measure_length,
    sweep_once,
    sweep_room,
)

SEED = 0  # of the tour


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
    plain
        The same of a sweep in one pass: lanes a robot's width apart, one after the other.
    left_out
        The ids of the rooms that the robot does not reach.
    """

    rooms: tuple[int, ...]
    paths: Mapping[int, Floats]
    ways: Mapping[int, Floats]
    swept: Coverage
    plain: Coverage
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
    cells = locate_rooms(space, floor, locate_doors(space, floor))
    graph = build_route_graph(floor, grid, robot_radius=robot_radius)
    order = _order_rooms(graph, [*cells])
    if not order:
        raise FloorError(f"a robot of {robot_radius} m radius fits nowhere, give a smaller robot_radius")
    areas = {room: _cut_area(space, room, cells[room]) for room in order}
    paths, plain_paths = {}, []
    for room, area in areas.items():
        row, col = cells[room]
        paths[room] = sweep_room(area, (row - area.corner[0], col - area.corner[1])) + np.array(area.corner)
        plain_paths.append(sweep_once(area) + np.array(area.corner))
    goal = _find_goal(space, areas)
    return CleaningPlan(
        tuple(order),
        {room: space.to_map(path) for room, path in paths.items()},
        _find_ways(space, graph, order, cells, paths),
        _measure_coverage(space, goal, [*paths.values()]),
        _measure_coverage(space, goal, plain_paths),
        tuple(room.id for room in floor if room.id not in paths),
    )


def _order_rooms(graph: nx.DiGraph, rooms: list[int]) -> list[int]:
    """A short tour of the rooms of the largest connected part of the route graph.

    The better one of a greedy tour and Christofides', both improved by threshold accepting.
    """
    parts = [[room for room in rooms if room in part] for part in nx.weakly_connected_components(graph)]
    reached = max(parts, key=len, default=[])
    if len(reached) < 3:
        return reached
    complete = nx.Graph()
    for room in reached:
        lengths = nx.single_source_dijkstra_path_length(graph, room, weight="cost")
        complete.add_weighted_edges_from((room, other, lengths[other]) for other in reached if other != room)
    starts = (nx.approximation.greedy_tsp(complete), nx.approximation.christofides(complete))
    tours = [nx.approximation.threshold_accepting_tsp(complete, [*start], seed=SEED) for start in starts]
    tour = min(tours, key=lambda rooms: nx.path_weight(complete, rooms, "weight"))[:-1]
    first = tour.index(reached[0])
    return [*tour[first:], *tour[:first]]


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


def _measure_coverage(space: FreeSpace, goal: Mask, paths: list[Indices]) -> Coverage:
    swept = find_swept_cells(paths, goal.shape, space.radius / space.grid.resolution)
    length = sum(map(measure_length, paths)) * space.grid.resolution
    area = float(np.count_nonzero(swept)) * space.grid.resolution**2
    return Coverage(float((swept & goal).sum() / goal.sum()), length * 2 * space.radius / area - 1, length)


def _find_ways(
    space: FreeSpace, graph: nx.DiGraph, order: list[int], cells: Mapping[int, Cell], paths: Mapping[int, Indices]
) -> dict[int, Floats]:
    """The ways between the paths of rooms, over the route graph."""
    everything = SweepArea(space, space.open, (0, 0))
    ways = {}
    for before, room in zip([order[-1], *order[:-1]], order, strict=True):
        nodes = nx.shortest_path(graph, before, room, weight="cost")
        positions = [[graph.nodes[node]["x"], graph.nodes[node]["y"]] for node in nodes]
        leave = find_way(everything, _as_cell(paths[before][-1]), cells[before])
        arrive = find_way(everything, cells[room], _as_cell(paths[room][0]))
        ways[room] = np.concatenate([space.to_map(leave)[:-1], positions, space.to_map(arrive)[1:]])
    return ways


def _as_cell(point: Indices) -> Cell:
    row, col = point.tolist()
    return row, col
