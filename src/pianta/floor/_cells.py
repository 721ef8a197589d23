"""The cells of a grid map that a polygon covers."""

from __future__ import annotations

import numpy as np
from shapely import Polygon, get_coordinates

from pianta._types import Floats, Mask
from pianta.gridmap import GridMap


def cells_of_polygon(polygon: Polygon, grid: GridMap) -> tuple[slice, slice, Mask]:
    """The cells whose centres are in a polygon: a window of rows and columns, and the mask in it.

    Even-odd scan conversion: each ring edge toggles the cells to the right of its crossing with a row of cell centres,
    so polygons that share an edge never share a cell.
    """
    starts, ends = _ring_edges(polygon, grid)
    height, width = grid.shape
    corners = np.vstack([starts, ends])
    top, left = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    bottom, right = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, (height, width))
    if bottom <= top or right <= left:
        return slice(0, 0), slice(0, 0), np.zeros((0, 0), bool)
    toggles = np.zeros((bottom - top, right - left + 1), np.int32)
    for edge in zip(starts.tolist(), ends.tolist(), strict=True):
        # From top to bottom, so that a common edge of two polygons crosses the same cells in both.
        (row0, col0), (row1, col1) = sorted(edge)
        first, last = np.ceil(np.clip((row0, row1), top, bottom)).astype(int)
        if first == last:
            continue
        rows = np.arange(first, last)
        crossings = col0 + (rows - row0) * (col1 - col0) / (row1 - row0)
        cols = np.clip(np.ceil(crossings), left, right).astype(int)
        toggles[rows - top, cols - left] += 1
    inside = np.cumsum(toggles, axis=1)[:, :-1] % 2 == 1
    return slice(top, bottom), slice(left, right), inside


def _ring_edges(polygon: Polygon, grid: GridMap) -> tuple[Floats, Floats]:
    """Starts and ends, shape (N, 2), of all ring edges as row, col where cell centres are integers."""
    starts, ends = [], []
    for ring in (polygon.exterior, *polygon.interiors):
        xy = get_coordinates(ring)
        pixels = np.column_stack(grid.map_to_pixel(xy[:, 0], xy[:, 1])) - 0.5
        starts.append(pixels[:-1])
        ends.append(pixels[1:])
    return np.concatenate(starts), np.concatenate(ends)
