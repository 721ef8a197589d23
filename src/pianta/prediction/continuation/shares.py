"""The share of samples in which each cell of a grid is free, wall or outside."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pianta._types import Indices, Mask
from pianta.gridmap import GridMap
from pianta.io._files import atomic_file

Shares = NDArray[np.float32]
Index: TypeAlias = slice | Indices

FINEST = 0.1  # m, least side of a cell of a grid of shares
ROUNDING = 1e-6  # of a block
RIM = 10  # cells around the known part and all sampled rooms, without a map


@dataclass(frozen=True, eq=False)
class ShareGrid:
    """For each cell the share of samples in which it is free, wall, or outside of the building.

    Row 0 is at the top, as in `GridMap`. With a map, the grid has its frame: its cells are whole blocks of cells of the
    map, from the same corner, and it covers the map and all sampled rooms. Without a map, its rows run along the walls.

    Attributes
    ----------
    free, wall, outside
        Shares, shape (H, W); their sum is 1. In the known part they are 0 or 1.
    free_probability
        The probability that the cell is free if it is near the building, shape (H, W): from the shares around it and
        the distances to the known part and to its open ends. Fitted to schools, on cells in the box around the building
        and 5 m more; farther away it is too high.
    observed
        Whether the cell was seen, shape (H, W).
    resolution
        Metres per cell.
    origin
        The x, y (m) and yaw (rad) of the outer corner of the lower-left cell, in the map frame.
    """

    free: Shares
    wall: Shares
    outside: Shares
    free_probability: Shares
    observed: Mask
    resolution: float
    origin: tuple[float, float, float]

    @property
    def frame(self) -> GridMap:
        """A map without obstacles on the same cells, which converts between pixels and metres."""
        return GridMap(np.zeros(self.free.shape, np.int8), self.resolution, self.origin)

    def save(self, path: str | Path) -> None:
        """Write the grid as a compressed NumPy archive with an array for each attribute.

        Parameters
        ----------
        path
            The file; an existing one is replaced.

        Raises
        ------
        PiantaError
            The file cannot be written.
        """
        with atomic_file(path) as temporary, temporary.open("wb") as stream:
            np.savez_compressed(
                stream,
                free=self.free,
                wall=self.wall,
                outside=self.outside,
                free_probability=self.free_probability,
                observed=self.observed,
                resolution=self.resolution,
                origin=self.origin,
            )


def crop_grid(grid: ShareGrid) -> ShareGrid:
    """A grid without the border where nothing is known and nothing was sampled."""
    used = grid.observed | (grid.free + grid.wall > 0)
    rows, cols = (_find_range(np.asarray(used.any(axis=axis))) for axis in (1, 0))
    x, y = grid.frame.pixel_to_map(rows.stop, cols.start)
    return _pick(grid, rows, cols, grid.resolution, (float(x), float(y), grid.origin[2]))


def move_to_map(grid: ShareGrid, observed_map: GridMap) -> ShareGrid:
    """A cropped grid on blocks of cells of a map, whose known cells replace the shares."""
    factor = max(1, ceil(FINEST / observed_map.resolution - ROUNDING))
    height, width = grid.free.shape
    corners = grid.frame.pixel_to_map([0, 0, height, height], [0, width, 0, width])
    rows, cols = observed_map.map_to_pixel(*corners)
    # Blocks are counted from the lower left corner of the map
    ends = np.array([observed_map.shape[0] - rows, cols]) / factor
    low = np.floor(ends.min(axis=1) + ROUNDING).clip(None, 0).astype(int)
    high = np.ceil(np.maximum(ends.max(axis=1), np.array(observed_map.shape) / factor) - ROUNDING).astype(int)
    shape = (int(high[0] - low[0]), int(high[1] - low[1]))
    x, y = observed_map.pixel_to_map(observed_map.shape[0] - low[0] * factor, low[1] * factor)
    frame = GridMap(
        np.zeros(shape, np.int8), observed_map.resolution * factor, (float(x), float(y), observed_map.origin[2])
    )
    centre_rows, centre_cols = np.mgrid[0 : shape[0], 0 : shape[1]] + 0.5
    row, col = (
        np.floor(part).astype(int) for part in grid.frame.map_to_pixel(*frame.pixel_to_map(centre_rows, centre_cols))
    )
    inside = (row >= 0) & (col >= 0) & (row < height) & (col < width)
    row, col = row.clip(0, height - 1), col.clip(0, width - 1)
    moved = _pick(grid, row, col, frame.resolution, frame.origin)
    for values, beyond in ((moved.free, 0), (moved.wall, 0), (moved.outside, 1), (moved.free_probability, 0)):
        values[~inside] = beyond
    moved.observed[~inside] = False
    return _overlay(moved, observed_map, factor, tuple(low.tolist()))


def _overlay(grid: ShareGrid, observed_map: GridMap, factor: int, low: tuple[int, int]) -> ShareGrid:
    """The grid with what a map knows; a block with an obstacle is wall. low: first block, from the map's corner."""
    blocks = tuple(-(-side // factor) for side in observed_map.shape)
    padding = [(blocks[0] * factor - observed_map.shape[0], 0), (0, blocks[1] * factor - observed_map.shape[1])]
    shape = (blocks[0], factor, blocks[1], factor)
    occupied, free = (
        np.pad(mask, padding).reshape(shape).any(axis=(1, 3)) for mask in (observed_map.occupied, observed_map.free)
    )
    bottom = grid.free.shape[0] + low[0]
    window = (slice(bottom - blocks[0], bottom), slice(-low[1], -low[1] + blocks[1]))
    for mask, value in ((free & ~occupied, 1), (occupied, 0)):
        for values, share in (
            (grid.free, value),
            (grid.wall, 1 - value),
            (grid.outside, 0),
            (grid.free_probability, value),
        ):
            values[window][mask] = share
        grid.observed[window][mask] = True
    return grid


def _pick(
    grid: ShareGrid, rows: Index, cols: Index, resolution: float, origin: tuple[float, float, float]
) -> ShareGrid:
    """A copy of some rows and columns."""
    free, wall, outside, probability = (
        np.asarray(layer[rows, cols], np.float32).copy()
        for layer in (grid.free, grid.wall, grid.outside, grid.free_probability)
    )
    return ShareGrid(free, wall, outside, probability, grid.observed[rows, cols].copy(), resolution, origin)


def _find_range(used: Mask) -> slice:
    """The range of the true values, with a rim."""
    indices = np.flatnonzero(used)
    return slice(max(0, int(indices[0]) - RIM), min(len(used), int(indices[-1]) + RIM + 1))
