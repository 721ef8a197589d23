"""Relations of rooms that may be far apart: walls on one line, and mirror images (thesis, chapter 9).

Both are invariant to scale, rotation, translation and the order of the rooms: lengths are shares of the floor's own
unit, which is 6.5 m in the median school or office.
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

# All thresholds were chosen by hand, for the reasons below.
# Radians: the largest rotation of a wall of 1 m that is drawn or mapped with an error of 0.05 m.
MAX_ANGLE = np.radians(3)
# 1 m, the width of a door: shorter edges belong to niches, and their direction is uncertain.
MIN_EDGE = 0.15
# 0.2 m, a thick wall: outlines meet in the middle of a wall, and both its faces have a line on the map of a robot.
MAX_LINE_DISTANCE = 0.03
# 0.3 m for axes and 0.65 m for centroids of rooms, which may be off by some cells.
MAX_AXIS_DISTANCE = 0.05
MAX_CENTROID_DISTANCE = 0.1
# Least IoU of a mirrored room with its image; rooms of a row that are half a metre off still have it.
MIN_IOU = 0.7
# Least share of the area of the building that an axis of it mirrors onto rooms.
MIN_MIRRORED = 0.5
# Axes that are compared, those with the most votes.
MAX_CANDIDATES = 8
# All axes whose mirrored share of the area is the largest, within this tolerance, are axes of the building.
MIRRORED_TOLERANCE = 0.01
# Edges that are compared with all others at a time, to limit the memory.
BLOCK_SIZE = 1000

Pairs = list[tuple[int, int]]


def find_aligned(floor: Floor) -> Pairs:
    """Ids of the pairs of rooms that have a wall on one representative line, the smaller id first, in order.

    The lines are the floor's walls (section 3.1). On an annotated floor, which has none, long edges of two rooms are on
    one line if they are parallel and have the same offset across the mean direction of the edges parallel to them.
    """
    if not floor.rooms:
        return []
    unit = measure_unit(floor)
    walls = _list_edges(draw_outlines(floor, unit), MIN_EDGE * unit)
    on_line = (
        _share_lines(walls, floor, MAX_LINE_DISTANCE * unit)
        if floor.walls
        else _lie_in_line(walls, MAX_LINE_DISTANCE * unit)
    )
    return _list_pairs(on_line, floor)


def find_symmetric(floor: Floor) -> Pairs:
    """Ids of the pairs of rooms that are mirror images in an axis of the building, the smaller id first, in order.

    Axes are parallel or perpendicular to the main direction of the walls, through the midpoints of most pairs of rooms
    that are alike. In each direction, the axes of the building are those that mirror most area, and at least half of
    it, onto rooms. A room is the image of another if its IoU with the mirrored other is at least 0.7.
    """
    if not floor.rooms:
        return []
    unit = measure_unit(floor)
    outlines = draw_outlines(floor, unit)
    edges = _list_edges(outlines, MIN_EDGE * unit)
    upright = _rotate(outlines, -_find_main_direction(edges))
    alike = find_alike(upright, fit_rectangles(upright)) | np.eye(len(outlines), dtype=bool)
    symmetric = _mirror_rooms(upright, alike, unit) | _mirror_rooms(_rotate(upright, np.pi / 2), alike, unit)
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
        """Indices of all edges in parts, each small enough to be compared with all edges."""
        count = len(self.angles)
        return np.array_split(np.arange(count), count // BLOCK_SIZE + 1) if count else []


def _list_edges(outlines: Geometries, min_length: float) -> _Edges:
    """The edges of the outlines of rooms, polygons without holes, that have at least min_length metres."""
    corners, rooms = shapely.get_coordinates(outlines, return_index=True)
    along, start = np.diff(corners, axis=0), corners[:-1]
    lengths = np.hypot(*along.T)
    chosen = (rooms[1:] == rooms[:-1]) & (lengths >= min_length)
    angles = np.arctan2(along[:, 1], along[:, 0]) % np.pi
    middles = start + along / 2
    return _Edges(middles[chosen], angles[chosen], lengths[chosen], rooms[:-1][chosen], len(outlines))


def _lie_in_line(edges: _Edges, reach: float) -> NDArray[np.bool_]:
    """Which rooms have edges on one line, shape (n, n).

    Over the length of a building the direction of one edge is too uncertain, so the mean of all edges near it is used.
    """
    angles, _ = _average_directions(edges, np.pi)
    normals = np.column_stack([-np.sin(angles), np.cos(angles)])
    offsets = edges.middles - edges.middles.mean(axis=0)
    own = (normals * offsets).sum(axis=1)
    on_line = np.zeros((edges.n, edges.n), bool)
    for block in edges.blocks():
        near = np.abs(_angle_between(edges.angles[block, None], edges.angles, np.pi)) <= MAX_ANGLE
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
    parallel = np.abs(_angle_between(edges.angles[:, None], angles, np.pi)) <= MAX_ANGLE
    edge, line = (parallel & (across <= reach)).nonzero()
    has_wall = np.zeros((edges.n, len(ends)), bool)
    has_wall[edges.rooms[edge], line] = True
    return np.asarray(has_wall.astype(int) @ has_wall.T.astype(int) > 0)


def _find_main_direction(edges: _Edges) -> float:
    """The direction to which the greatest length of wall is parallel or perpendicular; 0 without walls."""
    angles, lengths = _average_directions(edges, np.pi / 2)
    return float(angles[np.argmax(lengths)]) if len(angles) else 0.0


def _average_directions(edges: _Edges, period: float) -> tuple[Floats, Floats]:
    """For each edge the mean direction of all edges within MAX_ANGLE of it, modulo a period, and their total length."""
    angles, lengths = edges.angles.copy(), np.zeros(len(edges.angles))
    for block in edges.blocks():
        apart = _angle_between(edges.angles[block, None], edges.angles, period)
        near = (np.abs(apart) <= MAX_ANGLE) * edges.lengths
        lengths[block] = near.sum(axis=1)
        angles[block] += (near * apart).sum(axis=1) / lengths[block]
    return angles, lengths


def _mirror_rooms(outlines: Geometries, alike: NDArray[np.bool_], unit: float) -> NDArray[np.bool_]:
    """Which rooms are mirror images in an axis parallel to y, shape (n, n); a room may be its own image."""
    area = shapely.area(outlines)
    images = [_find_images(outlines, alike, axis, unit) for axis in _vote_for_axes(outlines, alike, unit)]
    mirrored = np.array([area[image.any(axis=1)].sum() / area.sum() for image in images])
    best = (mirrored >= MIN_MIRRORED) & (mirrored >= mirrored.max() - MIRRORED_TOLERANCE)
    symmetric = np.zeros_like(alike)
    for index in np.flatnonzero(best):
        symmetric |= images[index]
    return symmetric


def _vote_for_axes(outlines: Geometries, alike: NDArray[np.bool_], unit: float) -> list[float]:
    """The x of the axes with the most votes, weighted by area, of pairs of rooms that are alike; the best first.

    A room also forms a pair with itself: the axis of three rooms in a row runs through the second.
    """
    middles, area = shapely.get_coordinates(shapely.centroid(outlines)), shapely.area(outlines)
    level = np.abs(middles[:, None, 1] - middles[:, 1]) <= MAX_CENTROID_DISTANCE * unit
    one, other = (alike & level).nonzero()
    x, weights = (middles[one, 0] + middles[other, 0]) / 2, (area[one] + area[other]) / 2
    order = np.argsort(x)
    x, weights = x[order], weights[order]
    axes: list[float] = []
    left = np.ones(len(x), bool)
    while left.any() and len(axes) < MAX_CANDIDATES:
        reach = MAX_AXIS_DISTANCE * unit
        total = np.concatenate([[0], np.cumsum(weights * left)])
        votes = total[np.searchsorted(x, x + reach, "right")] - total[np.searchsorted(x, x - reach)]
        most = x[int(np.argmax(votes * left))]
        voters = left & (np.abs(x - most) <= reach)
        axes.append(float(np.average(x[voters], weights=weights[voters])))
        left &= np.abs(x - most) > 2 * reach
    return axes


def _find_images(outlines: Geometries, alike: NDArray[np.bool_], axis: float, unit: float) -> NDArray[np.bool_]:
    """Which rooms are mirror images in an axis parallel to y at some x, shape (n, n)."""
    mirrored = shapely.transform(outlines, lambda xy: np.column_stack([2 * axis - xy[:, 0], xy[:, 1]]))
    middles, images = (shapely.get_coordinates(shapely.centroid(shapes)) for shapes in (outlines, mirrored))
    near = np.hypot(*(images[:, None] - middles).transpose(2, 0, 1)) <= 2 * MAX_CENTROID_DISTANCE * unit
    one, other = (alike & near).nonzero()
    common = shapely.area(shapely.intersection(mirrored[one], outlines[other]))
    both = shapely.area(outlines)[one] + shapely.area(outlines)[other] - common
    is_image = np.zeros_like(alike)
    is_image[one, other] = common >= MIN_IOU * both
    return is_image


def _rotate(outlines: Geometries, angle: float) -> Geometries:
    """Outlines rotated about the origin, counter-clockwise."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.asarray(shapely.transform(outlines, lambda xy: xy @ np.array([[cos, sin], [-sin, cos]])), dtype=object)


def _angle_between(start: Floats, end: Floats, period: float) -> Floats:
    """The difference of two angles, within half a period of 0."""
    return np.asarray((end - start + period / 2) % period - period / 2)


def _list_pairs(related: NDArray[np.bool_], floor: Floor) -> Pairs:
    ids = [room.id for room in floor.rooms]
    pairs = ((ids[one], ids[other]) for one, other in zip(*related.nonzero(), strict=True))
    return sorted({(min(pair), max(pair)) for pair in pairs if pair[0] != pair[1]})
