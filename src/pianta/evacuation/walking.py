"""Shortest ways on foot: a graph of visibility within each room, joined by the doors.

A shortest way bends only at corners that point into the room, so its nodes are these corners and the doors; a door is
passed in its middle. Lengths are exact, except that outlines are simplified by up to SIMPLIFICATION.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from math import inf

import numpy as np
import shapely
from shapely import Point, Polygon
from shapely.geometry.polygon import orient

from pianta._types import Floats, Indices, Mask
from pianta.floor import Floor

SIMPLIFICATION = 0.05  # metres, the cell of a usual map: steps of outlines are no corners; chosen by hand
TOLERANCE = 1e-3  # metres; a way along a wall is in the room
# Metres between the points of a room from which ways are measured, inside and along its outline; chosen by hand.
INSIDE_STEP = 1.0
OUTLINE_STEP = 0.5
MAX_SPOTS = 600  # of a room, inside and along its outline; larger rooms have longer steps


@dataclass(frozen=True, eq=False)
class WalkingGraph:
    """The nodes and ways of a floor, and spots from which people start.

    nodes: x, y, shape (N, 2). Node 2i is the side of door i in the first of its rooms, 2i + 1 that in the other or
        outside; further nodes are corners. node_rooms: id of the room of each, 0 outside.
    starts, ends, lengths: ways within rooms, in both directions. crossings: metres from one side of each door to the
        other, shape (doors,).
    spots: x, y, shape (S, 2), room by room. spot_rooms: id of the room of each. spots_inside: which are spread over
        the floor. room_spots: the spots of each room by its id; the first is in the middle.
    sights: pairs of a spot and a node that it sees, shape (P, 2); sight_lengths: metres between them.
    """

    nodes: Floats
    node_rooms: Indices
    starts: Indices
    ends: Indices
    lengths: Floats
    crossings: Floats
    spots: Floats
    spot_rooms: Indices
    spots_inside: Mask
    room_spots: dict[int, slice]
    sights: Indices
    sight_lengths: Floats

    def find_ways(self, sources: Collection[int], shut: Collection[int] = ()) -> Ways:
        """The shortest ways from all nodes and spots to the nearest of some nodes; shut: indices of doors."""
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import dijkstra

        count = len(self.nodes)
        doors = np.setdiff1d(np.arange(len(self.crossings)), sorted(shut))
        starts = np.concatenate([self.starts, 2 * doors, 2 * doors + 1])
        ends = np.concatenate([self.ends, 2 * doors + 1, 2 * doors])
        lengths = np.concatenate([self.lengths, self.crossings[doors], self.crossings[doors]])
        graph = csr_array((lengths, (starts, ends)), shape=(count, count))
        distances, following, _ = dijkstra(graph, indices=sorted(sources), min_only=True, return_predecessors=True)
        spot_distances, first = self._reach_nodes(distances)
        return Ways(distances, following, _next_doors(following, len(self.crossings)), spot_distances, first)

    def _reach_nodes(self, distances: Floats) -> tuple[Floats, Indices]:
        """The length of the way from each spot, and its first node, -1 without a way; distances: from the nodes."""
        spots, nodes = self.sights.T
        totals = self.sight_lengths + distances[nodes]
        shortest = np.full(len(self.spots), inf)
        np.minimum.at(shortest, spots, totals)
        first = np.full(len(self.spots), -1)
        is_shortest = (totals <= shortest[spots]) & np.isfinite(totals)
        # In reverse, so that of equal ways the one to the first node stays.
        first[spots[is_shortest][::-1]] = nodes[is_shortest][::-1]
        return shortest, first


@dataclass(frozen=True, eq=False)
class Ways:
    """Shortest ways to the nearest exit.

    distances: metres from each node, inf without a way. following: the next node of each, negative at its end.
    next_doors: the near side of the next door on the way from each node; the last node when no door is left.
    spot_distances: metres from each spot. first: the first node of its way, -1 without one.
    """

    distances: Floats
    following: Indices
    next_doors: Indices
    spot_distances: Floats
    first: Indices

    def uses_door(self, door: int) -> bool:
        """Whether any of the ways leads through the door of an index; without it the others are as they are."""
        first, second = 2 * door, 2 * door + 1
        return bool(self.following[first] == second or self.following[second] == first)

    def list_nodes(self, node: int) -> list[int]:
        """The nodes of the way from one, itself included."""
        nodes = [node]
        while (node := int(self.following[node])) >= 0:
            nodes.append(node)
        return nodes

    def list_doors(self, node: int) -> list[int]:
        """The indices of the doors on the way from a node, in order."""
        doors = []
        while self.following[node := int(self.next_doors[node])] >= 0:
            doors.append(node // 2)
            node = int(self.following[node])
        return doors


def _next_doors(following: Indices, doors: int) -> Indices:
    """For each node the first on its way, itself included, from which it crosses a door, or else the last."""
    nodes = np.arange(len(following))
    is_end = following < 0
    crosses = ~is_end & (nodes < 2 * doors) & (following == nodes ^ 1)
    jumps = np.where(is_end | crosses, nodes, following)
    while not np.array_equal(further := jumps[jumps], jumps):
        jumps = further
    return np.asarray(jumps)


def build_walking_graph(floor: Floor) -> WalkingGraph:
    """The graph of the ways on a floor; door i of it has the nodes 2i and 2i + 1."""
    shapes = {room.id: _simplify(room.polygon) for room in floor.rooms}
    sides, side_rooms, crossings = _place_doors(floor, shapes)
    parts, nodes, spots = [], [*range(len(sides))], 0
    ways, sights, room_spots = [], [], {}
    for room_id, shape in shapes.items():
        own = np.flatnonzero(side_rooms == room_id)
        part = _measure_room(shape, sides[own])
        own = np.concatenate([own, len(nodes) + np.arange(len(part.corners))])
        nodes += [*range(len(nodes), len(nodes) + len(part.corners))]
        ways.append(own[part.ways])
        sights.append(np.column_stack([part.sights[:, 0] + spots, own[part.sights[:, 1]]]))
        room_spots[room_id] = slice(spots, spots + len(part.spots))
        spots += len(part.spots)
        parts.append(part)
    xy, spot_xy = np.concatenate([sides, *(part.corners for part in parts)]), np.concatenate([p.spots for p in parts])
    (starts, ends), pairs = np.concatenate(ways).T, np.concatenate(sights)
    room_ids = np.array([*shapes])
    return WalkingGraph(
        nodes=xy,
        node_rooms=np.concatenate([side_rooms, np.repeat(room_ids, [len(part.corners) for part in parts])]),
        starts=starts,
        ends=ends,
        lengths=np.hypot(*(xy[starts] - xy[ends]).T),
        crossings=crossings,
        spots=spot_xy,
        spot_rooms=np.repeat(room_ids, [len(part.spots) for part in parts]),
        spots_inside=np.concatenate([part.inside for part in parts]),
        room_spots=room_spots,
        sights=pairs,
        sight_lengths=np.hypot(*(spot_xy[pairs[:, 0]] - xy[pairs[:, 1]]).T),
    )


def _simplify(polygon: Polygon) -> Polygon:
    """The outline without steps of a few centimetres; as it is where that would not leave one polygon."""
    simple = polygon.simplify(SIMPLIFICATION)
    return simple if isinstance(simple, Polygon) and simple.area > 0 else polygon


def _place_doors(floor: Floor, shapes: dict[int, Polygon]) -> tuple[Floats, Indices, Floats]:
    """The sides of all doors, shape (2 doors, 2), the room of each, 0 outside, and the metres between them.

    A side is the point of the room that is nearest to the middle of the door; outside it is the middle.
    """
    sides, rooms, crossings = [], [], []
    for door in floor.doors:
        middle = door.line.interpolate(0.5, normalized=True)
        points = [_nearest_point(shapes[room], middle) if room is not None else middle for room in door.rooms]
        crossings.append(sum(point.distance(middle) for point in points))
        sides += [(point.x, point.y) for point in points]
        rooms += [room or 0 for room in door.rooms]
    return np.array(sides).reshape(-1, 2), np.array(rooms, int), np.array(crossings, float)


def _nearest_point(shape: Polygon, point: Point) -> Point:
    return Point(shapely.shortest_line(shape, point).coords[0])


@dataclass(frozen=True, eq=False)
class _RoomPart:
    """The corners and spots of a room, x, y; which spots are inside; the ways between nodes, and what each spot sees.

    Nodes are indices of its door sides, then of its corners. The first spot is the middle of the room.
    """

    corners: Floats
    spots: Floats
    inside: Mask
    ways: Indices
    sights: Indices


def _measure_room(shape: Polygon, sides: Floats) -> _RoomPart:
    corners = _inner_corners(shape)
    nodes = np.concatenate([sides, corners])
    spots, inside = _choose_spots(shape)
    is_way = _is_visible(shape, nodes, nodes, convex=not len(corners))
    np.fill_diagonal(is_way, val=False)
    is_sight = _is_visible(shape, spots, nodes, convex=not len(corners))
    return _RoomPart(corners, spots, inside, np.argwhere(is_way), np.argwhere(is_sight))


def _inner_corners(shape: Polygon) -> Floats:
    """The corners at which the room is wider than a half-plane, shape (N, 2): shortest ways bend only there."""
    corners = []
    for ring in (orient(shape).exterior, *orient(shape).interiors):
        xy = shapely.get_coordinates(ring)[:-1]
        into, out = xy - np.roll(xy, 1, axis=0), np.roll(xy, -1, axis=0) - xy
        # The room is on the left of its outline: a turn to the right points into it.
        turns = into[:, 0] * out[:, 1] - into[:, 1] * out[:, 0]
        corners.append(xy[turns < 0])
    return np.concatenate(corners)


def _is_visible(shape: Polygon, starts: Floats, ends: Floats, *, convex: bool) -> Mask:
    """Whether the straight line from each start to each end is in a room, shape (starts, ends)."""
    if convex or not len(starts) or not len(ends):
        return np.ones((len(starts), len(ends)), bool)
    pairs = np.stack(np.broadcast_arrays(starts[:, None], ends[None]), axis=2)
    wide = shape.buffer(TOLERANCE, join_style="mitre")
    shapely.prepare(wide)
    is_point = (pairs[:, :, 0] == pairs[:, :, 1]).all(axis=-1)
    return np.asarray(is_point | shapely.covers(wide, shapely.linestrings(pairs)))


def _choose_spots(shape: Polygon) -> tuple[Floats, Mask]:
    """The middle of a room, spots all over it and along its outline, shape (N, 2); and which are spread over it."""
    middle = shape.centroid if shape.contains(shape.centroid) else shape.representative_point()
    left, bottom, right, top = shape.bounds
    step = max(INSIDE_STEP, (shape.area / MAX_SPOTS) ** 0.5)
    # The columns and rows are in the middle of the bounds, so that equal rooms have equal spots at any position.
    xs, ys = (_place_evenly(low, high, step) for low, high in ((left, right), (bottom, top)))
    x, y = (axis.ravel() for axis in np.meshgrid(xs, ys))
    is_inside = shapely.contains_xy(shape, x, y)
    inside = np.column_stack([x, y])[is_inside]
    outline = shapely.get_coordinates(shapely.segmentize(shape, max(OUTLINE_STEP, shape.length / MAX_SPOTS)))
    spots = np.concatenate([[(middle.x, middle.y)], inside, outline])
    kinds = np.repeat([not len(inside), True, False], [1, len(inside), len(outline)])
    return spots, kinds


def _place_evenly(low: float, high: float, step: float) -> Floats:
    """Points at equal distances of about a step, half of it from both ends."""
    count = max(round((high - low) / step), 1)
    return np.asarray(low + (np.arange(count) + 0.5) * (high - low) / count)
