"""Variants of a map: with salt and pepper, and rotated."""

from __future__ import annotations

from math import ceil, cos, radians, sin

import numpy as np

from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap

# Of all cells of the map, unknown ones too; issue 22.
NOISE_SHARE = 0.01


def add_salt_and_pepper(grid: GridMap, *, seed: int, draw: int, share: float = NOISE_SHARE) -> GridMap:
    """The map with a share of its cells changed at random: half of them become occupied, half free."""
    rng = np.random.default_rng([seed, draw])
    cells = grid.cells.copy()
    chosen = rng.choice(cells.size, round(share * cells.size), replace=False)
    pepper, salt = np.array_split(chosen, 2)
    cells.flat[pepper] = OCCUPIED
    cells.flat[salt] = FREE
    return GridMap(cells, grid.resolution, grid.origin, grid.source)


def rotate_cells(grid: GridMap, degrees: float) -> GridMap:
    """The map rotated counter-clockwise about its middle: nearest cells, unknown outside, large enough for all."""
    cosine, sine = cos(radians(degrees)), sin(radians(degrees))
    rows, cols = grid.shape
    # Less than a cell's rounding error, so that quarter turns keep the number of cells.
    height = ceil(abs(rows * cosine) + abs(cols * sine) - 1e-6)
    width = ceil(abs(cols * cosine) + abs(rows * sine) - 1e-6)
    x = np.arange(width) + 0.5 - width / 2
    y = height / 2 - 0.5 - np.arange(height)[:, None]
    col = np.floor(x * cosine + y * sine + cols / 2).astype(int)
    row = np.floor(rows / 2 + x * sine - y * cosine).astype(int)
    inside = (row >= 0) & (row < rows) & (col >= 0) & (col < cols)
    cells = np.full((height, width), UNKNOWN, np.int8)
    cells[inside] = grid.cells[row[inside], col[inside]]
    return GridMap(cells, grid.resolution, source=grid.source)
