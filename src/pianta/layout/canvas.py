"""Canvas: the free space of a grid map at the working resolution and in a pose of its own."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta.errors import MapError
from pianta.gridmap import GridMap

# Cells around the building, so that every edge of free space has a cell outside.
MARGIN_PX = 4

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Canvas:
    """The free space of a grid map, cropped, resampled by a whole factor, and turned into its canonical pose.

    The probabilistic Hough transform visits edges in an order that depends on the pose of the map. In the canonical
    pose (wider than high, skewed towards the first row and column) the same building gives the same rooms when its
    map is mirrored, turned by 90°, padded, or drawn with smaller cells.

    free: shape (H, W).
    resolution: metres per cell.
    to_grid: shape (3, 3), canvas (row, col, 1) to grid (row, col, 1), continuous pixel coordinates.
    grid: the map it was made of.

    Metres of the canvas are x = col · resolution and y = row · resolution.
    """

    free: Mask
    resolution: float
    to_grid: NDArray[np.float64]
    grid: GridMap

    def to_map(self, geometry: shapely.Geometry) -> shapely.Geometry:
        """Geometry in metres of the canvas, moved into the map frame."""

        def transform(xy: NDArray[np.float64]) -> NDArray[np.float64]:
            canvas = np.stack([xy[:, 1] / self.resolution, xy[:, 0] / self.resolution, np.ones(len(xy))])
            row, col, _ = self.to_grid @ canvas
            return np.column_stack(self.grid.pixel_to_map(row, col))

        return shapely.transform(geometry, transform)


def draw_canvas(grid: GridMap, free: Mask, *, resolution: float) -> Canvas:
    """Canvas of the free cells of a grid map, with cells of about the given size in metres.

    Cells finer than that are joined, and a joined cell is free when all its parts are, so that no wall is lost.
    Coarser ones are repeated. Raises MapError when no cell is free.
    """
    if not free.any():
        raise MapError("the map has no free cell, so there is no room to find; check its thresholds and negate")
    row_span, col_span = (np.flatnonzero(free.any(axis=axis))[[0, -1]] for axis in (1, 0))
    window = free[row_span[0] : row_span[1] + 1, col_span[0] : col_span[1] + 1]
    # The pose comes first, so that the same cells are joined in every pose of the map.
    cells, pose = _turn_to_canonical_pose(window)
    joined = max(1, round(resolution / grid.resolution))
    repeated = max(1, round(grid.resolution / resolution))
    cells = _join_cells(cells, joined) if joined > 1 else cells
    cells = cells.repeat(repeated, axis=0).repeat(repeated, axis=1) if repeated > 1 else cells
    step = joined / repeated
    to_grid = _shift(row_span[0], col_span[0]) @ pose @ np.diag([step, step, 1.0]) @ _shift(-MARGIN_PX, -MARGIN_PX)
    return Canvas(np.pad(cells, MARGIN_PX), grid.resolution * step, to_grid, grid)


def _join_cells(cells: Mask, factor: int) -> Mask:
    """Blocks of factor × factor cells as one cell each, free when the whole block is."""
    rows, cols = (-(-size // factor) * factor for size in cells.shape)
    padded = np.pad(cells, ((0, rows - cells.shape[0]), (0, cols - cells.shape[1])), mode="edge")
    return np.asarray(padded.reshape(rows // factor, factor, cols // factor, factor).all(axis=(1, 3)))


def _turn_to_canonical_pose(cells: Mask) -> tuple[Mask, NDArray[np.float64]]:
    """The cells wider than high and skewed towards the first row and column; and the matrix that turns them back."""
    row_spread, row_skew = _central_moments(cells.sum(axis=1))
    col_spread, col_skew = _central_moments(cells.sum(axis=0))
    height, width = cells.shape
    back = np.eye(3)
    if row_skew < 0:
        cells, back = cells[::-1], back @ np.array([[-1, 0, height], [0, 1, 0], [0, 0, 1]])
    if col_skew < 0:
        cells, back = cells[:, ::-1], back @ np.array([[1, 0, 0], [0, -1, width], [0, 0, 1]])
    if row_spread > col_spread:
        cells, back = cells.T, back @ np.array([[0, 1, 0], [1, 0, 0], [0, 0, 1]])
    return np.ascontiguousarray(cells), back


def _central_moments(counts: NDArray[np.integer]) -> tuple[float, float]:
    """Second and third central moment of a histogram over 0 … N - 1, the same in both reading directions."""
    position = np.arange(len(counts)) - (len(counts) - 1) / 2
    offset = position - (counts * position).sum() / counts.sum()
    return float((counts * offset**2).sum()), float((counts * offset**3).sum())


def _shift(row: float, col: float) -> NDArray[np.float64]:
    return np.array([[1.0, 0.0, row], [0.0, 1.0, col], [0.0, 0.0, 1.0]])
