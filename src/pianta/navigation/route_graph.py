"""The route graph of a floor: positions in rooms and doors, and straight ways between them that a robot can drive."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations, pairwise
from math import ceil, dist, inf
from typing import Any

import networkx as nx
import numpy as np
import shapely

from pianta._types import Indices, Mask
from pianta.floor import Door, Floor, Room, cells_of_polygon
from pianta.gridmap import GridMap
from pianta.navigation.free_space import ROOM_REACH, FreeSpace, find_free_space
from pianta.navigation.lattice import Lattice, build_lattice, find_stride, straighten_way, trace_back
from pianta.navigation.positions import CIRCLE, Cell, locate_doors, locate_rooms
from pianta.navigation.robot import ROBOT_RADIUS
from pianta.navigation.spanner import Spanner

# A way of a room is left out if the others cost at most this many times as much. Chosen by hand.
STRETCH = 1.15
# Corners of ways are one node if they are nearer, metres: a robot finds the node nearest to it. Chosen by hand.
MERGE_DISTANCE = 0.6
# Edges are divided into pieces of at most this length, metres, so that a node is near a robot in a corridor. By hand.
MAX_EDGE = 4.0
# Metres around the line of a door in which ways may leave the room: half a door and the thickness of a wall.
DOORWAY = 0.8
# Of coordinates, as in ROS.
FRAME = "map"
DIGITS = 4  # of coordinates and costs, after the point: tenths of a millimetre, which FreeSpace.is_straight allows


def build_route_graph(floor: Floor, grid: GridMap, *, robot_radius: float = ROBOT_RADIUS) -> nx.DiGraph:
    """Build the route graph of a floor, for a round robot that drives from room to room.

    Every edge is a straight line on which the robot touches no obstacle of the map.

    Parameters
    ----------
    floor
        Its rooms and doors.
    grid
        Its map; the robot drives on free cells only.
    robot_radius
        Metres.

    Returns
    -------
    networkx.DiGraph
        Nodes have `x`, `y` (metres of the map frame) and `metadata`, a dictionary: `type` is "room", "door" or "way".
        The node of a room has its id as key, and `room`, `class` (its label), `name`, and its outline as `x_values` and
        `y_values`; that of a door `rooms`, `width` and `door`, its index; that of a way `room`. Edges, in both
        directions, have `cost` (metres) and `metadata` of the room. Rooms in which the robot fits nowhere, and doors
        that are too narrow for it, have no nodes.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> graph = pianta.build_route_graph(floor, grid, robot_radius=0.3)
    >>> graph.nodes[1]["metadata"]["class"], graph.has_node(9)
    ('CORRIDOR', True)
    """
    # 1. The open cells: free ones, farther from every obstacle than the radius.
    space = find_free_space(floor, grid, robot_radius)
    # 2. A cell of each door and each room where the robot fits.
    doors = locate_doors(space, floor)
    return join_positions(space, floor, locate_rooms(space, floor, doors), doors)


def join_positions(
    space: FreeSpace, floor: Floor, rooms: Mapping[int, Cell], doors: Sequence[Cell | None]
) -> nx.DiGraph:
    """The route graph between positions in rooms, by the id of the room, and in doors, as `build_route_graph` says."""
    ways: nx.Graph = nx.Graph()
    ways.add_nodes_from(rooms.values())
    # 3. In each room short ways between all its doors and its position, as few as STRETCH allows.
    for room in floor:
        own = [cell for cell, door in zip(doors, floor.doors, strict=True) if cell and room.id in door.room_ids]
        _join_targets(space, ways, floor, room.id, [*dict.fromkeys([*filter(None, [rooms.get(room.id)]), *own])])
    # 4. Long edges get nodes on their way.
    _divide_edges(space, ways)
    # 5. Doors through which no way leads are no nodes.
    return _describe_graph(space, floor, ways, rooms, doors)


def _join_targets(space: FreeSpace, ways: nx.Graph, floor: Floor, room: int, targets: list[Cell]) -> None:
    """Add the ways of a room between cells: the greedy spanner of the shortest ones."""
    from scipy.sparse.csgraph import dijkstra

    lattice = _build_room_lattice(space, floor, room, targets)
    numbers = [number for number in map(lattice.find_point, targets) if number >= 0]
    if len(numbers) < 2:
        return
    costs, previous = dijkstra(lattice.costs, indices=numbers, return_predecessors=True)
    rows = {number: row for row, number in enumerate(numbers)}
    spanner = Spanner()
    pairs = [(costs[rows[a], b], a, b) for a, b in combinations(numbers, 2)]
    for cost, a, b in sorted(pair for pair in pairs if pair[0] < inf):
        if spanner.measure_cost(lattice.find_cell(a), lattice.find_cell(b)) <= STRETCH * cost:
            continue
        way = trace_back(previous[rows[a]], b)
        corners = straighten_way(space, lattice.points[way], costs[rows[a], way])
        for start, end in pairwise(_merge_corners(space, spanner.graph, corners)):
            spanner.add(start, end, space.measure_cost(start, end), room)
    ways.add_edges_from(spanner.graph.edges(data=True))


def _build_room_lattice(space: FreeSpace, floor: Floor, room: int, targets: list[Cell]) -> Lattice:
    """The lattice of a room and its doorways.

    Where that does not join the targets, a lattice of all cells, and then one with the neighbouring rooms.
    """
    from scipy.sparse.csgraph import connected_components

    neighbours = {other for door in floor.doors if room in door.room_ids for other in door.room_ids}
    stride = find_stride(space.grid.resolution)
    for rooms, step in (({room}, stride), ({room}, 1), (neighbours | {room}, 1)):
        lattice = build_lattice(space, *_cut_rooms(space, floor, room, rooms), step)
        _, components = connected_components(lattice.costs, directed=False)
        numbers = [lattice.find_point(cell) for cell in targets]
        if -1 not in numbers and len({int(components[number]) for number in numbers}) <= 1:
            break
    return lattice


def _cut_rooms(space: FreeSpace, floor: Floor, room: int, rooms: set[int]) -> tuple[Mask, Cell]:
    """The open cells of rooms and of the doorways of one of them, in a window; with the row and col of its corner."""
    doorways = [door.line.buffer(DOORWAY, quad_segs=CIRCLE) for door in floor.doors if room in door.room_ids]
    bounds = shapely.box(*shapely.total_bounds([*(floor[each].polygon for each in rooms), *doorways]))
    rows, cols, _ = cells_of_polygon(bounds.buffer(ROOM_REACH, join_style="mitre"), space.grid)
    part = np.isin(space.rooms[rows, cols], [*rooms])
    for doorway in doorways:
        door_rows, door_cols, inside = cells_of_polygon(doorway, space.grid)
        part[
            door_rows.start - rows.start : door_rows.stop - rows.start,
            door_cols.start - cols.start : door_cols.stop - cols.start,
        ] |= inside
    return part & space.open[rows, cols], (rows.start, cols.start)


def _merge_corners(space: FreeSpace, graph: nx.Graph, corners: Indices) -> list[Cell]:
    """The corners of a way; inner ones move to a near node of the graph, where the way stays open."""
    merged: list[Cell] = [(int(row), int(col)) for row, col in corners]
    reach = MERGE_DISTANCE / space.grid.resolution
    for number in range(1, len(merged) - 1):
        near = min(graph, key=lambda node: dist(node, merged[number]), default=None)
        if near is None or near in merged or dist(near, merged[number]) > reach:
            continue
        if space.is_straight(merged[number - 1], near) and space.is_straight(near, merged[number + 1]):
            merged[number] = near
    return merged


def _divide_edges(space: FreeSpace, ways: nx.Graph) -> None:
    """Replace each edge that is longer than MAX_EDGE by equal pieces."""
    for start, end, data in [*ways.edges(data=True)]:
        pieces = ceil(dist(start, end) * space.grid.resolution / MAX_EDGE)
        if pieces > 1:
            ways.remove_edge(start, end)
            nx.add_path(ways, [tuple(point) for point in np.linspace(start, end, pieces + 1).tolist()], **data)


def _describe_graph(
    space: FreeSpace, floor: Floor, ways: nx.Graph, rooms: Mapping[int, Cell], doors: Sequence[Cell | None]
) -> nx.DiGraph:
    """The graph with numbered nodes and directed edges, and what they are; nodes and edges in the order of numbers."""
    described = {cell: _describe_room(floor[room]) | _list_corners(floor[room]) for room, cell in rooms.items()}
    numbers = {cell: room for room, cell in rooms.items()}
    # Of several doors at one cell the first one counts
    for index, (cell, door) in enumerate(zip(doors, floor.doors, strict=True)):
        if (
            cell is not None
            and cell in ways
            and {data["room"] for *_, data in ways.edges(cell, data=True)} >= {*door.room_ids}
        ):
            described.setdefault(cell, _describe_door(index, door))
    others = [*(cell for cell in described if cell not in numbers), *sorted(set(ways) - set(described))]
    numbers |= {cell: floor.last_id + 1 + index for index, cell in enumerate(others)}
    graph: nx.DiGraph = nx.DiGraph(frame=FRAME)
    for cell in sorted(numbers, key=lambda cell: numbers[cell]):
        ((x, y),) = space.to_map([cell]).tolist()
        near = [data["room"] for *_, data in ways.edges(cell, data=True)]
        metadata = described.get(cell) or {"type": "way", "room": near[0]}
        graph.add_node(numbers[cell], x=round(x, DIGITS), y=round(y, DIGITS), metadata=metadata)
    pairs = [(numbers[a], numbers[b], data["room"]) for a, b, data in ways.edges(data=True)]
    for start, end, room in sorted([*pairs, *((end, start, room) for start, end, room in pairs)]):
        first, last = graph.nodes[start], graph.nodes[end]
        cost = round(dist((first["x"], first["y"]), (last["x"], last["y"])), DIGITS)
        graph.add_edge(start, end, cost=cost, metadata=_describe_room(floor[room], "way"))
    return graph


def _describe_room(room: Room, node_type: str = "room") -> dict[str, Any]:
    described = {"type": node_type, "room": room.id, "class": room.label, "name": room.name}
    return {key: value for key, value in described.items() if value is not None}


def _list_corners(room: Room) -> dict[str, Any]:
    """The outline, as Nav2's graphs have regions: x and y apart, since lists in lists are refused."""
    x, y = np.round(shapely.get_coordinates(room.polygon.exterior).T, DIGITS).tolist()
    return {"x_values": x, "y_values": y}


def _describe_door(index: int, door: Door) -> dict[str, Any]:
    return {"type": "door", "door": index, "rooms": [*door.room_ids], "width": round(door.width, DIGITS)}
