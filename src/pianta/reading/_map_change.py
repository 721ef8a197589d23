"""Where a map has changed since it was read the last time."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely import Polygon
from shapely.geometry.base import BaseGeometry

from pianta._types import Floats, Mask
from pianta.gridmap import GridMap
from pianta.layout.frames import Motion

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

# The constants were chosen by hand.
# A point has a wall if an occupied cell is within this distance; metres.
WALL_REACH = 0.15
# A point has no wall if every occupied cell is further away; more than above by the error of the motion; metres.
NO_WALL_REACH = 0.3
# A border has a new wall, or a wall that is gone, if this share of it has.
CHANGED_SHARE = 0.5
# Shorter borders are not compared; metres.
MIN_BORDER = 0.3
# Distance of the points that are compared; metres.
SPACING = 0.1


@dataclass(frozen=True)
class MapChange:
    """The map, the previous map, and the motion from the frame of that to this one."""

    grid: GridMap
    previous: GridMap
    motion: Motion

    @property
    def is_known(self) -> bool:
        """Whether both maps show walls; the grid of a plan is unknown everywhere."""
        return bool(self._walls.n and self._old_walls.n)

    def has_new_wall(self, border: BaseGeometry) -> bool:
        """Whether most of a border has a wall on this map and none on the previous one."""
        points = _sample(border)
        share = _is_near(self._walls, points, WALL_REACH) & ~_is_near(self._old_walls, points, NO_WALL_REACH)
        return bool(border.length >= MIN_BORDER and share.mean() > CHANGED_SHARE)

    def has_lost_wall(self, border: BaseGeometry) -> bool:
        """Whether most of a border has a wall on the previous map and none on this one."""
        points = _sample(border)
        share = _is_near(self._old_walls, points, WALL_REACH) & ~_is_near(self._walls, points, NO_WALL_REACH)
        return bool(border.length >= MIN_BORDER and share.mean() > CHANGED_SHARE)

    def measure_free(self, polygon: Polygon) -> float:
        """The share of the cells in an outline, free on the previous map, that are free still; 0 without any."""
        left, bottom, right, top = polygon.bounds
        x, y = np.meshgrid(np.arange(left, right, SPACING), np.arange(bottom, top, SPACING))
        inside = shapely.contains_xy(polygon, x, y)
        points = np.column_stack([x[inside], y[inside]])
        was_free = _read_cells(self.previous.free, self.previous, self.motion.revert(points))
        is_free = _read_cells(self.grid.free, self.grid, points)
        return float(is_free[was_free].mean()) if was_free.any() else 0.0

    @cached_property
    def _walls(self) -> cKDTree:
        return _index(_list_walls(self.grid))

    @cached_property
    def _old_walls(self) -> cKDTree:
        return _index(self.motion.apply(_list_walls(self.previous)))


def _index(points: Floats) -> cKDTree:
    from scipy.spatial import cKDTree

    return cKDTree(points)


def _list_walls(grid: GridMap) -> Floats:
    """The centres of the occupied cells."""
    row, col = np.nonzero(grid.occupied)
    return np.column_stack(grid.pixel_to_map(row + 0.5, col + 0.5))


def _sample(border: BaseGeometry) -> Floats:
    """Points along a border, evenly but for its corners."""
    return np.asarray(shapely.get_coordinates(shapely.segmentize(border, SPACING)))


def _is_near(walls: cKDTree, points: Floats, reach: float) -> Mask:
    distance, _ = walls.query(points, distance_upper_bound=reach)
    return np.asarray(np.isfinite(distance))


def _read_cells(cells: Mask, grid: GridMap, points: Floats) -> Mask:
    """The value of a cell at each point; False beyond the map."""
    row, col = (np.floor(each).astype(np.int64) for each in grid.map_to_pixel(*points.T))
    inside = (row >= 0) & (col >= 0) & (row < grid.shape[0]) & (col < grid.shape[1])
    values = np.zeros(len(points), bool)
    values[inside] = cells[row[inside], col[inside]]
    return values
