"""Relations of rooms that need not be near each other: on one line of the building, mirror images (thesis, chapter 9).

Neither depends on scale, turn, shift or the order of the rooms: lengths are shares of the floor's own unit, which is
6.5 m in the median school or office.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.floor import Floor
from pianta.rooms._outlines import Geometries, draw_outlines, measure_unit
from pianta.rooms._shapes import fit_rectangles
from pianta.rooms._surroundings import find_alike

# Radians. A wall of a metre, drawn or mapped with an error of 0.05 m, is turned by no more.
SAME_DIRECTION = np.radians(3)
# 1 m, as long as a door is wide; shorter edges are niches, and say little about their direction.
LEAST_WALL = 0.15
# 0.2 m, a thick wall: outlines meet in the middle of a wall, whose faces have a line each on the map of a robot.
SAME_LINE = 0.03
# 0.3 m, and twice as much for a room: each of two rooms is some cells off where it belongs.
SAME_AXIS, SAME_PLACE = 0.05, 0.1
# Mirrored, a room shares so much of its union with the other; two rooms of a row that are half a metre off do.
LEAST_OVERLAP = 0.7
# An axis is one of the building when so much of its area is mirrored onto rooms.
LEAST_MIRRORED = 0.5
# So many axes are compared, those with most votes; those that mirror as much but for a share are all the building's.
CANDIDATES = 8
SAME_SHARE = 0.01
BLOCK = 1000

Pairs = list[tuple[int, int]]


def find_aligned(floor: Floor) -> Pairs:
    """Ids of the pairs of rooms that have a wall on one representative line, the smaller id first, in order.

    The lines are the floor's walls (section 3.1). A drawn floor has none: there, long edges of two rooms are on one
    line when they are parallel, and as far across the common direction of the edges near theirs.
    """
    if not floor.rooms:
        return []
    unit = measure_unit(floor)
    walls = _list_edges(draw_outlines(floor, unit), LEAST_WALL * unit)
    on_line = _share_lines(walls, floor, SAME_LINE * unit) if floor.walls else _lie_in_line(walls, SAME_LINE * unit)
    return _list_pairs(on_line, floor)


def find_symmetric(floor: Floor) -> Pairs:
    """Ids of the pairs of rooms that are mirror images in an axis of the building, the smaller id first, in order.

    Axes lie along and across the main direction of the walls, where the midpoints of most rooms that are alike lie. Of
    either direction they are those that mirror most area, and at least half of the building's, onto rooms. A room is
    the image of another when it and the mirrored other share 0.7 of their union.
    """
    if not floor.rooms:
        return []
    unit = measure_unit(floor)
    outlines = draw_outlines(floor, unit)
    edges = _list_edges(outlines, LEAST_WALL * unit)
    upright = _turn(outlines, -_find_main_direction(edges))
    alike = find_alike(upright, fit_rectangles(upright)) | np.eye(len(outlines), dtype=bool)
    symmetric = _mirror_rooms(upright, alike, unit) | _mirror_rooms(_turn(upright, np.pi / 2), alike, unit)
    return _list_pairs(symmetric, floor)


@dataclass(frozen=True, eq=False)
class _Edges:
    """m edges of the outlines of n rooms.

    middles: metres, shape (m, 2). angles: modulo π, shape (m,). lengths: metres, shape (m,). rooms: rows, shape (m,).
    """

    middles: Floats
    angles: Floats
    lengths: Floats
    rooms: NDArray[np.intp]
    n: int

    def blocks(self) -> list[NDArray[np.intp]]:
        """Places of all edges in parts, so that a part may be compared with all without filling the memory."""
        count = len(self.angles)
        return np.array_split(np.arange(count), count // BLOCK + 1) if count else []


def _list_edges(outlines: Geometries, least: float) -> _Edges:
    corners, rooms = shapely.get_coordinates(outlines, return_index=True)
    along, start = np.diff(corners, axis=0), corners[:-1]
    lengths = np.hypot(*along.T)
    kept = (rooms[1:] == rooms[:-1]) & (lengths >= least)
    angles = np.arctan2(along[:, 1], along[:, 0]) % np.pi
    middles = start + along / 2
    return _Edges(middles[kept], angles[kept], lengths[kept], rooms[:-1][kept], len(outlines))


def _lie_in_line(edges: _Edges, reach: float) -> NDArray[np.bool_]:
    """Which rooms have edges on one line, shape (n, n).

    Over the length of a building the direction of one edge tells nothing, so that it is that of all edges near it.
    """
    angles, _ = _average_directions(edges, np.pi)
    normals = np.column_stack([-np.sin(angles), np.cos(angles)])
    offsets = edges.middles - edges.middles.mean(axis=0)
    own = (normals * offsets).sum(axis=1)
    on_line = np.zeros((edges.n, edges.n), bool)
    for block in edges.blocks():
        near = np.abs(_turn_between(edges.angles[block, None], edges.angles, np.pi)) <= SAME_DIRECTION
        across = np.abs(normals[block] @ offsets.T - own[block, None]) <= reach
        one, other = (near & across).nonzero()
        on_line[edges.rooms[block][one], edges.rooms[other]] = True
    return on_line


def _share_lines(edges: _Edges, floor: Floor, reach: float) -> NDArray[np.bool_]:
    """Which rooms have edges on one of the floor's walls, shape (n, n)."""
    ends = np.array([shapely.get_coordinates(wall)[[0, -1]] for wall in floor.walls])
    along = ends[:, 1] - ends[:, 0]
    angles = np.arctan2(along[:, 1], along[:, 0])
    normals = np.column_stack([-np.sin(angles), np.cos(angles)])
    across = np.abs(((edges.middles[:, None] - ends[:, 0]) * normals).sum(axis=2))
    parallel = np.abs(_turn_between(edges.angles[:, None], angles, np.pi)) <= SAME_DIRECTION
    edge, line = (parallel & (across <= reach)).nonzero()
    has_wall = np.zeros((edges.n, len(ends)), bool)
    has_wall[edges.rooms[edge], line] = True
    return np.asarray(has_wall.astype(int) @ has_wall.T.astype(int) > 0)


def _find_main_direction(edges: _Edges) -> float:
    """The direction that most length of wall is along or across; 0 without walls."""
    angles, lengths = _average_directions(edges, np.pi / 2)
    return float(angles[np.argmax(lengths)]) if len(angles) else 0.0


def _average_directions(edges: _Edges, period: float) -> tuple[Floats, Floats]:
    """For each edge the mean direction of all within SAME_DIRECTION of it, modulo a period, and their length."""
    angles, lengths = edges.angles.copy(), np.zeros(len(edges.angles))
    for block in edges.blocks():
        apart = _turn_between(edges.angles[block, None], edges.angles, period)
        near = (np.abs(apart) <= SAME_DIRECTION) * edges.lengths
        lengths[block] = near.sum(axis=1)
        angles[block] += (near * apart).sum(axis=1) / lengths[block]
    return angles, lengths


def _mirror_rooms(outlines: Geometries, alike: NDArray[np.bool_], unit: float) -> NDArray[np.bool_]:
    """Which rooms are mirror images in an axis along y, shape (n, n); a room may be its own."""
    area = shapely.area(outlines)
    images = [_find_images(outlines, alike, axis, unit) for axis in _vote_for_axes(outlines, alike, unit)]
    mirrored = np.array([area[image.any(axis=1)].sum() / area.sum() for image in images])
    best = (mirrored >= LEAST_MIRRORED) & (mirrored >= mirrored.max() - SAME_SHARE)
    symmetric = np.zeros_like(alike)
    for place in np.flatnonzero(best):
        symmetric |= images[place]
    return symmetric


def _vote_for_axes(outlines: Geometries, alike: NDArray[np.bool_], unit: float) -> list[float]:
    """The x of the axes for which most area of rooms that are alike votes, the best first.

    A room votes for the axis through its own middle too: the axis of three rooms in a row is that of the second.
    """
    middles, area = shapely.get_coordinates(shapely.centroid(outlines)), shapely.area(outlines)
    level = np.abs(middles[:, None, 1] - middles[:, 1]) <= SAME_PLACE * unit
    one, other = (alike & level).nonzero()
    places, weights = (middles[one, 0] + middles[other, 0]) / 2, (area[one] + area[other]) / 2
    order = np.argsort(places)
    places, weights = places[order], weights[order]
    axes: list[float] = []
    left = np.ones(len(places), bool)
    while left.any() and len(axes) < CANDIDATES:
        reach = SAME_AXIS * unit
        total = np.concatenate([[0], np.cumsum(weights * left)])
        votes = total[np.searchsorted(places, places + reach, "right")] - total[np.searchsorted(places, places - reach)]
        most = places[int(np.argmax(votes * left))]
        voters = left & (np.abs(places - most) <= reach)
        axes.append(float(np.average(places[voters], weights=weights[voters])))
        left &= np.abs(places - most) > 2 * reach
    return axes


def _find_images(outlines: Geometries, alike: NDArray[np.bool_], axis: float, unit: float) -> NDArray[np.bool_]:
    """Which rooms are mirror images in an axis along y at some x, shape (n, n)."""
    mirrored = shapely.transform(outlines, lambda xy: np.column_stack([2 * axis - xy[:, 0], xy[:, 1]]))
    middles, images = (shapely.get_coordinates(shapely.centroid(shapes)) for shapes in (outlines, mirrored))
    near = np.hypot(*(images[:, None] - middles).transpose(2, 0, 1)) <= 2 * SAME_PLACE * unit
    one, other = (alike & near).nonzero()
    common = shapely.area(shapely.intersection(mirrored[one], outlines[other]))
    both = shapely.area(outlines)[one] + shapely.area(outlines)[other] - common
    found = np.zeros_like(alike)
    found[one, other] = common >= LEAST_OVERLAP * both
    return found


def _turn(outlines: Geometries, angle: float) -> Geometries:
    """Outlines turned about the origin, counter-clockwise."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.asarray(shapely.transform(outlines, lambda xy: xy @ np.array([[cos, sin], [-sin, cos]])), dtype=object)


def _turn_between(start: Floats, end: Floats, period: float) -> Floats:
    """The turn from one angle to another, within half a period of 0."""
    return np.asarray((end - start + period / 2) % period - period / 2)


def _list_pairs(related: NDArray[np.bool_], floor: Floor) -> Pairs:
    ids = [room.id for room in floor.rooms]
    pairs = ((ids[one], ids[other]) for one, other in zip(*related.nonzero(), strict=True))
    return sorted({(min(pair), max(pair)) for pair in pairs if pair[0] != pair[1]})
