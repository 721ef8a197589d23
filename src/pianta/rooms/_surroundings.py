"""The place of a room among the others of its floor: size, repetition, facade, walls; free of scale, turn and shift."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.rooms._outlines import QUIET_BUFFERS, Geometries
from pianta.rooms._shapes import MISSING, SAME, Rectangles

# Rooms whose areas and lengths differ by less than this (of the logarithm) are alike.
ALIKE = 0.12
WALLS_ALIKE = 0.15
# Shares of the length unit of a floor.
JOIN, CLOSE = 0.067, 0.1
FACADE_REACH, SIDE_REACH = 0.083, 0.133
WALL_REACH, LEAST_WALL = 0.12, 0.16
# Share of a side of a room that makes it a side of the building.
FACADE_SIDE = 0.6
NEAREST_ROOMS = 6
# Rooms whose areas differ by less than this (of the logarithm) rank the same.
SAME_RANK = 0.02


def find_alike(outlines: Geometries, rectangles: Rectangles) -> NDArray[np.bool_]:
    """Which rooms have nearly the same area and length, shape (n, n); no room is like itself."""
    log_area, log_length = np.log(shapely.area(outlines)), np.log(rectangles.length)
    alike = (_differences(log_area) < ALIKE) & (_differences(log_length) < ALIKE)
    np.fill_diagonal(alike, val=False)
    return np.asarray(alike)


@QUIET_BUFFERS
def share_walls(outlines: Geometries, unit: float) -> Floats:
    """Lengths of wall that rooms (rows) share with others (columns), as shares of their perimeters, shape (n, n)."""
    n = len(outlines)
    reach = WALL_REACH * unit
    one, other = shapely.STRtree(outlines).query(outlines, predicate="dwithin", distance=reach)
    one, other = one[one != other], other[one != other]
    around = shapely.buffer(outlines, reach, join_style="mitre")
    length = np.zeros((n, n))
    length[one, other] = shapely.length(shapely.intersection(shapely.get_exterior_ring(outlines)[one], around[other]))
    length[length < LEAST_WALL * unit] = 0
    # Corners are within reach of several rooms.
    return np.asarray(length / np.maximum(shapely.length(outlines), length.sum(axis=1))[:, None])


def measure_sizes(outlines: Geometries, rectangles: Rectangles, alike: NDArray[np.bool_]) -> dict[str, Floats]:
    """Size relative to the floor, and how often rooms like it occur."""
    area, n = shapely.area(outlines), len(outlines)
    log_area = np.log(area)
    below = log_area[None] - log_area[:, None]
    kin = alike | np.eye(n, dtype=bool)
    most = int(np.argmax(kin @ area))
    return {
        "size_to_median": log_area - np.median(log_area),
        "size_rank": ((below < -SAME_RANK).mean(axis=1) + (below < SAME_RANK).mean(axis=1)) / 2,
        "length_to_floor": rectangles.length / np.sqrt(area.sum()),
        "share_of_floor": area / area.sum(),
        "size_to_commonest": log_area - log_area[kin[most]].mean(),
        "alike": alike.sum(axis=1).astype(float),
        "alike_share": alike.mean(axis=1),
        "size_to_nearest": _compare_with_nearest(outlines, log_area),
    }


@QUIET_BUFFERS
def measure_facades(outlines: Geometries, rectangles: Rectangles, unit: float) -> dict[str, Floats]:
    """How much of a room is at the facade, how many of its sides, and how far it is from the middle of the floor."""
    joined = shapely.union_all(shapely.buffer(outlines, JOIN * unit, join_style="mitre"))
    hull = joined.buffer(CLOSE * unit, join_style="mitre").buffer(-(JOIN + CLOSE) * unit, join_style="mitre")
    rings = shapely.get_exterior_ring(outlines)
    near = shapely.intersection(rings, hull.boundary.buffer(FACADE_REACH * unit, join_style="mitre"))
    corners = rectangles.corners
    sides = shapely.linestrings(np.stack([corners, np.roll(corners, -1, axis=1)], axis=2))
    at_facade = shapely.length(shapely.intersection(sides, hull.boundary.buffer(SIDE_REACH * unit, join_style="mitre")))
    away = shapely.distance(shapely.centroid(outlines), joined.centroid)
    return {
        "facade": shapely.length(near) / shapely.length(rings),
        "facade_sides": (at_facade > FACADE_SIDE * rectangles.sides).sum(axis=1).astype(float),
        "to_centre": away / np.sqrt(joined.area),
    }


def measure_walls(walls: Floats, outlines: Geometries) -> dict[str, Floats]:
    """How many rooms lie behind the walls of a room, and how their sizes compare with its own."""
    log_area = np.log(shapely.area(outlines))
    behind = walls > 0
    larger = log_area[None] - log_area[:, None]
    mean = (walls * larger).sum(axis=1) / np.maximum(walls.sum(axis=1), SAME)
    any_behind = behind.any(axis=1)
    return {
        "wall_neighbours": behind.sum(axis=1).astype(float),
        "wall_neighbours_alike": (behind & (np.abs(larger) < WALLS_ALIKE)).sum(axis=1).astype(float),
        "wall_size_mean": np.where(any_behind, mean, MISSING),
        "wall_size_max": np.where(any_behind, np.where(behind, larger, -np.inf).max(axis=1), MISSING),
        "wall_size_min": np.where(any_behind, np.where(behind, larger, np.inf).min(axis=1), MISSING),
    }


def _compare_with_nearest(outlines: Geometries, log_area: Floats) -> Floats:
    """Logarithm of the area over the median of the nearest rooms, those at the same distance included; 0 if alone."""
    if len(outlines) == 1:
        return np.zeros(1)
    middles = shapely.get_coordinates(shapely.centroid(outlines))
    away = np.hypot(*(middles[:, None] - middles).transpose(2, 0, 1))
    np.fill_diagonal(away, np.inf)
    farthest = np.sort(away, axis=1)[:, min(NEAREST_ROOMS, len(outlines) - 1) - 1]
    near = away <= farthest[:, None] * (1 + SAME)
    ordered = np.sort(np.where(near, log_area[None], np.inf), axis=1)
    count, rows = near.sum(axis=1), np.arange(len(outlines))
    return np.asarray(log_area - (ordered[rows, (count - 1) // 2] + ordered[rows, count // 2]) / 2)


def _differences(values: Floats) -> Floats:
    return np.asarray(np.abs(values[:, None] - values))
