"""Canvas: the free space of a grid map at the working resolution and in a pose of its own."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Mask
from pianta.errors import MapError
from pianta.gridmap import GridMap

# Cells around the building, so that every edge of free space has a cell outside.
MARGIN_PX = 4
# Cells coarser than this show no doors; metres.
COARSEST = 0.5
# Coarse cells are repeated to at most this number, which is half a square kilometre of building.
MAX_REPEATED_CELLS = 200_000_000

Scalar = TypeVar("Scalar", bound=np.generic)


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

    def sample(self, cells: NDArray[Scalar]) -> NDArray[Scalar]:
        """Cells at the centres of the cells of the canvas, shape (H, W) of the canvas; 0 beyond the map.

        cells: shape of the grid map. A centre between cells, where an even number is joined, is in the one below and to
        the right.
        """
        height, width = self.free.shape
        rows, cols = np.arange(height) + 0.5, np.arange(width) + 0.5
        swapped = self.to_grid[0, 0] == 0
        along_rows, along_cols = (cols, rows) if swapped else (rows, cols)
        row = np.floor(self.to_grid[0, int(swapped)] * along_rows + self.to_grid[0, 2]).astype(int)
        col = np.floor(self.to_grid[1, int(not swapped)] * along_cols + self.to_grid[1, 2]).astype(int)
        inside = np.outer((row >= 0) & (row < cells.shape[0]), (col >= 0) & (col < cells.shape[1]))
        found = cells[np.ix_(row.clip(0, cells.shape[0] - 1), col.clip(0, cells.shape[1] - 1))]
        found[~inside] = 0
        return np.asarray(found.T if swapped else found)


def draw_canvas(grid: GridMap, free: Mask, *, resolution: float) -> Canvas:
    """Canvas of the free cells of a grid map, with cells of about the given size in metres.

    Cells finer than that are joined, and a joined cell is free when all its parts are, so that no wall is lost.
    Coarser ones are repeated. Raises MapError when no cell is free, or the cells are too fine or too coarse to tell.
    """
    if not free.any():
        raise MapError("the map has no free cell, so there is no room to find; check its thresholds and negate")
    row_span, col_span = (np.flatnonzero(free.any(axis=axis))[[0, -1]] for axis in (1, 0))
    window = free[row_span[0] : row_span[1] + 1, col_span[0] : col_span[1] + 1]
    # The pose comes first, so that the same cells are joined in every pose of the map.
    cells, pose = _turn_to_canonical_pose(window)
    cells, step = _resample_cells(cells, grid.resolution, resolution)
    to_grid = _shift(row_span[0], col_span[0]) @ pose @ np.diag([step, step, 1.0]) @ _shift(-MARGIN_PX, -MARGIN_PX)
    return Canvas(np.pad(cells, MARGIN_PX), grid.resolution * step, to_grid, grid)


def _resample_cells(cells: Mask, resolution: float, wanted: float) -> tuple[Mask, float]:
    """Cells of about the wanted size, from cells of a given size (metres); and how many of the given each spans."""
    if resolution > COARSEST:
        raise MapError(f"cells of {resolution:g} m are too coarse to show rooms; check the resolution")
    if resolution > wanted:
        affordable = max(1, int((MAX_REPEATED_CELLS / cells.size) ** 0.5))
        repeated = min(round(resolution / wanted), affordable)
        return cells.repeat(repeated, axis=0).repeat(repeated, axis=1), 1 / repeated
    if wanted / resolution >= max(cells.shape) + 1:
        raise MapError(f"the free space is less than {wanted:g} m across; check the resolution of {resolution:g} m")
    joined = round(wanted / resolution)
    coarse = _join_cells(cells, joined)
    if not coarse.any():
        raise MapError(f"no free space is {wanted:g} m wide; check the resolution of {resolution:g} m")
    return coarse, float(joined)


def _join_cells(cells: Mask, factor: int) -> Mask:
    """Blocks of factor × factor cells as one cell each, free when the whole block is; the last ones may be cut."""
    row_starts, col_starts = (np.arange(0, size, factor) for size in cells.shape)
    return np.asarray(np.logical_and.reduceat(np.logical_and.reduceat(cells, row_starts, axis=0), col_starts, axis=1))


def _turn_to_canonical_pose(cells: Mask) -> tuple[Mask, NDArray[np.float64]]:
    """The cells wider than high and skewed towards the first row and column; and the matrix that turns them back.

    Where the moments leave a choice, the cells themselves decide.
    """
    moments = [_central_moments(cells.sum(axis=axis)) for axis in (1, 0)]
    candidates: dict[tuple[tuple[int, int], ...], list[tuple[Mask, NDArray[np.float64]]]] = {}
    for pose in product((False, True), repeat=3):
        swap, *flips = pose
        shape = [(spread, -skew if flip else skew) for (spread, skew), flip in zip(moments, flips, strict=True)]
        candidates.setdefault(tuple(shape if swap else shape[::-1]), []).append(_turn_cells(cells, pose))
    turned, back = max(candidates[max(candidates)], key=lambda turned: (turned[0].shape, turned[0].tobytes()))
    return np.ascontiguousarray(turned), back


def _turn_cells(cells: Mask, pose: tuple[bool, ...]) -> tuple[Mask, NDArray[np.float64]]:
    """The cells with rows flipped, columns flipped, and both swapped, as asked; and the matrix that turns them back."""
    swap, flip_rows, flip_cols = pose
    height, width = cells.shape
    back = np.eye(3)
    if flip_rows:
        cells, back = cells[::-1], back @ np.array([[-1, 0, height], [0, 1, 0], [0, 0, 1]])
    if flip_cols:
        cells, back = cells[:, ::-1], back @ np.array([[1, 0, 0], [0, -1, width], [0, 0, 1]])
    if swap:
        cells, back = cells.T, back @ np.array([[0, 1, 0], [1, 0, 0], [0, 0, 1]])
    return cells, back


def _central_moments(counts: NDArray[np.integer]) -> tuple[int, int]:
    """Second and third central moment of a histogram, times powers of its total; exact, so that ties are ties."""
    position, weight = 2 * np.arange(len(counts)).astype(object) - (len(counts) - 1), counts.astype(object)
    total, first, second, third = (int((weight * position**power).sum()) for power in range(4))
    return total * second - first**2, total**2 * third - 3 * total * first * second + 2 * first**3


def _shift(row: float, col: float) -> NDArray[np.float64]:
    return np.array([[1.0, 0.0, row], [0.0, 1.0, col], [0.0, 0.0, 1.0]])
