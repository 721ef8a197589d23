"""Features of a room among the others of its floor: size, repetition, façade, walls (as invariant as _shapes)."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.rooms._outlines import QUIET_BUFFERS, Geometries
from pianta.rooms._shapes import MISSING, REL_TOLERANCE, Rectangles

# All thresholds were chosen on the 43 annotated schools and offices (docs/methods/places.md).
# Largest difference of the logarithms of areas and lengths of rooms that are alike; of areas of wall neighbours.
MAX_LOG_DIFFERENCE = 0.12
MAX_LOG_DIFFERENCE_NEIGHBOURS = 0.15
# Lengths as shares of the unit of a floor (6.5 m in the median school or office).
# Rooms are dilated by JOIN_DISTANCE so that they join, and gaps between them closed by CLOSING_DISTANCE.
JOIN_DISTANCE = 0.067
CLOSING_DISTANCE = 0.1
# Distance to the outline of the floor within which an outline, or a side of a rectangle, is at the façade.
FACADE_DISTANCE = 0.083
FACADE_SIDE_DISTANCE = 0.133
# Distance within which two rooms share a wall, and the shortest wall that counts.
WALL_DISTANCE = 0.12
MIN_WALL = 0.16
# A side of a room is a façade if more than this share of it is at the façade.
MIN_FACADE_SHARE = 0.6
# Number of rooms that a room's size is compared with.
NEAREST_ROOMS = 6
# Rooms that are compared at once with all others, for less memory.
COMPARED_AT_ONCE = 500
# Rooms whose logarithms of areas differ by less have the same rank.
RANK_TOLERANCE = 0.02


def find_alike(outlines: Geometries, rectangles: Rectangles) -> NDArray[np.bool_]:
    """Which rooms have nearly the same area and length, shape (n, n); False on the diagonal."""
    log_area, log_length = np.log(shapely.area(outlines)), np.log(rectangles.length)
    alike = (_differences(log_area) < MAX_LOG_DIFFERENCE) & (_differences(log_length) < MAX_LOG_DIFFERENCE)
    np.fill_diagonal(alike, val=False)
    return np.asarray(alike)


@QUIET_BUFFERS
def share_walls(outlines: Geometries, unit: float) -> Floats:
    """Lengths of wall that rooms (rows) share with others (columns), over their perimeters, shape (n, n)."""
    n = len(outlines)
    reach = WALL_DISTANCE * unit
    one, other = shapely.STRtree(outlines).query(outlines, predicate="dwithin", distance=reach)
    one, other = one[one != other], other[one != other]
    around = shapely.buffer(outlines, reach, join_style="mitre")
    length = np.zeros((n, n))
    length[one, other] = shapely.length(shapely.intersection(shapely.get_exterior_ring(outlines)[one], around[other]))
    length[length < MIN_WALL * unit] = 0
    # A corner may be near several rooms and count several times, so that the sum may exceed the perimeter.
    return np.asarray(length / np.maximum(shapely.length(outlines), length.sum(axis=1))[:, None])


def measure_sizes(outlines: Geometries, rectangles: Rectangles, alike: NDArray[np.bool_]) -> dict[str, Floats]:
    """Features of the sizes of n rooms by name, each of shape (n,): relative to the floor and to other rooms.

    Sizes are logarithms of areas. alike: of `find_alike`, shape (n, n).
    """
    area, n = shapely.area(outlines), len(outlines)
    log_area = np.log(area)
    differences = log_area[None] - log_area[:, None]
    groups = alike | np.eye(n, dtype=bool)
    largest = int(np.argmax(groups @ area))
    return {
        "size_to_median": log_area - np.median(log_area),
        "size_rank": ((differences < -RANK_TOLERANCE).mean(axis=1) + (differences < RANK_TOLERANCE).mean(axis=1)) / 2,
        "length_to_floor": rectangles.length / np.sqrt(area.sum()),
        "share_of_floor": area / area.sum(),
        "size_to_commonest": log_area - log_area[groups[largest]].mean(),
        "alike": alike.sum(axis=1).astype(float),
        "alike_share": alike.mean(axis=1),
        "size_to_nearest": _compare_with_nearest(outlines, log_area),
    }


@QUIET_BUFFERS
def measure_facades(outlines: Geometries, rectangles: Rectangles, unit: float) -> dict[str, Floats]:
    """Features of the façade of n rooms by name, each of shape (n,).

    They are the share of the outline at the façade, the number of sides there, and the distance from the middle of the
    floor. unit: the unit of the floor, m.
    """
    joined = shapely.union_all(shapely.buffer(outlines, JOIN_DISTANCE * unit, join_style="mitre"))
    hull = joined.buffer(CLOSING_DISTANCE * unit, join_style="mitre").buffer(
        -(JOIN_DISTANCE + CLOSING_DISTANCE) * unit, join_style="mitre"
    )
    rings = shapely.get_exterior_ring(outlines)
    near = _measure_within(rings, _draw_band(hull, FACADE_DISTANCE * unit))
    corners = rectangles.corners
    sides = shapely.linestrings(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2))
    at_facade = _measure_within(sides.ravel(), _draw_band(hull, FACADE_SIDE_DISTANCE * unit)).reshape(sides.shape)
    away = shapely.distance(shapely.centroid(outlines), joined.centroid)
    return {
        "facade": near / shapely.length(rings),
        "facade_sides": (at_facade > MIN_FACADE_SHARE * rectangles.sides).sum(axis=1).astype(float),
        "to_centre": away / np.sqrt(joined.area),
    }


def _draw_band(hull: shapely.Geometry, width: float) -> shapely.Geometry:
    """The surroundings of an outline up to a distance, m."""
    band = hull.boundary.buffer(width, join_style="mitre")
    # Mitres at corners of less than some degrees can cross each other
    return band if band.is_valid else shapely.make_valid(band, method="structure", keep_collapsed=False)


def _measure_within(lines: Geometries, band: shapely.Geometry) -> Floats:
    """The length of each line inside a band, shape (n,). Each meets few parts of the band of a campus."""
    parts = shapely.get_parts(band)
    line, part = shapely.STRtree(parts).query(lines, predicate="intersects")
    lengths = shapely.length(shapely.intersection(lines[line], parts[part]))
    return np.asarray(np.bincount(line, lengths, minlength=len(lines)), float)


def measure_walls(walls: Floats, outlines: Geometries) -> dict[str, Floats]:
    """Features of the rooms behind the walls of n rooms by name, each of shape (n,): their number and relative sizes.

    walls: of `share_walls`, shape (n, n).
    """
    log_area = np.log(shapely.area(outlines))
    behind = walls > 0
    larger = log_area[None] - log_area[:, None]
    mean = (walls * larger).sum(axis=1) / np.maximum(walls.sum(axis=1), REL_TOLERANCE)
    any_behind = behind.any(axis=1)
    return {
        "wall_neighbours": behind.sum(axis=1).astype(float),
        "wall_neighbours_alike": (behind & (np.abs(larger) < MAX_LOG_DIFFERENCE_NEIGHBOURS)).sum(axis=1).astype(float),
        "wall_size_mean": np.where(any_behind, mean, MISSING),
        "wall_size_max": np.where(any_behind, np.where(behind, larger, -np.inf).max(axis=1), MISSING),
        "wall_size_min": np.where(any_behind, np.where(behind, larger, np.inf).min(axis=1), MISSING),
    }


def _compare_with_nearest(outlines: Geometries, log_area: Floats) -> Floats:
    """Log of the area over the median of the NEAREST_ROOMS rooms (more if some are equally far); 0 for a lone room."""
    if len(outlines) == 1:
        return np.zeros(1)
    centroids = shapely.get_coordinates(shapely.centroid(outlines))
    compared = [
        _compare_some_with_nearest(range(first, min(first + COMPARED_AT_ONCE, len(outlines))), centroids, log_area)
        for first in range(0, len(outlines), COMPARED_AT_ONCE)
    ]
    return np.concatenate(compared)


def _compare_some_with_nearest(rooms: range, centroids: Floats, log_area: Floats) -> Floats:
    """The same for some of the rooms, in memory that grows with their number times that of all rooms."""
    distances = np.hypot(*(centroids[rooms, None] - centroids).transpose(2, 0, 1))
    distances[range(len(rooms)), rooms] = np.inf
    farthest = np.sort(distances, axis=1)[:, min(NEAREST_ROOMS, len(centroids) - 1) - 1]
    near = distances <= farthest[:, None] * (1 + REL_TOLERANCE)
    in_order = np.sort(np.where(near, log_area[None], np.inf), axis=1)
    count, rows = near.sum(axis=1), np.arange(len(rooms))
    middle = (in_order[rows, (count - 1) // 2] + in_order[rows, count // 2]) / 2
    return np.asarray(log_area[rooms] - middle)


def _differences(values: Floats) -> Floats:
    """Absolute differences of all pairs of values, shape (n, n)."""
    return np.asarray(np.abs(values[:, None] - values))
