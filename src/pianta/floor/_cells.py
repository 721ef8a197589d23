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
    # From top to bottom, so that a common edge of two polygons crosses the same cells in both.
    is_down = (starts[:, 0] < ends[:, 0])[:, None]
    (row0, col0), (row1, col1) = np.where(is_down, starts, ends).T, np.where(is_down, ends, starts).T
    first, last = (np.ceil(np.clip(at, top, bottom)).astype(int) for at in (row0, row1))
    edges = np.repeat(np.arange(len(first)), last - first)
    rows = np.arange(len(edges)) - np.repeat(np.cumsum(last - first) - last, last - first)
    crossings = col0[edges] + (rows - row0[edges]) * (col1 - col0)[edges] / (row1 - row0)[edges]
    cols = np.clip(np.ceil(crossings), left, right).astype(int)
    shape = bottom - top, right - left + 1
    toggles = np.bincount((rows - top) * shape[1] + cols - left, minlength=shape[0] * shape[1]).reshape(shape)
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
