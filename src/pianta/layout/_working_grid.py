"""The working grid: the free space of a grid map, resampled to the working resolution and in a canonical pose."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import TypeVar

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats, Indices, Mask
from pianta.errors import MapError
from pianta.gridmap import GridMap

# Cells around the building, so that every edge of free space has a cell outside.
MARGIN_PX = 4
# Coarser cells show no doors, which are some 0.9 m wide; metres.
MAX_RESOLUTION = 0.5
# Metres; no coordinate on the earth is larger, and those of a floor are exact to less than a millimetre.
MAX_ORIGIN = 5e7
# Limit of memory: coarse cells are repeated to at most this number (0.5 km² of building at 0.05 m per cell).
MAX_REPEATED_CELLS = 200_000_000

NO_FREE_CELL = "the map has no free cell, so there is no room to find; check its thresholds and negate"
NO_ROOM = "the map shows no room, its free space is too small or too scattered; check the resolution"

Scalar = TypeVar("Scalar", bound=np.generic)
# A pose: whether rows and columns are swapped, rows are flipped, and columns are flipped.
Pose = tuple[bool, ...]


@dataclass(frozen=True, eq=False)
class WorkingGrid:
    """The free space of a grid map, cropped, resampled by an integer factor, and turned into its canonical pose.

    The probabilistic Hough transform visits edges in an order that depends on the pose of the map. In the canonical
    pose (wider than high, skewed towards the first row and column) the same building gives the same rooms when its
    map is mirrored, turned by 90°, padded, or has smaller cells.

    free: shape (H, W).
    resolution: metres per cell.
    to_grid: shape (3, 3), working grid (row, col, 1) to grid map (row, col, 1), continuous pixel coordinates.
    grid: the grid map.

    Metres of the working grid are x = col · resolution and y = row · resolution.
    """

    free: Mask
    resolution: float
    to_grid: Floats
    grid: GridMap

    def to_map(self, geometry: shapely.Geometry) -> shapely.Geometry:
        """Geometry in metres of the working grid, transformed into the map frame."""

        def transform(xy: Floats) -> Floats:
            pixels = np.stack([xy[:, 1] / self.resolution, xy[:, 0] / self.resolution, np.ones(len(xy))])
            row, col, _ = self.to_grid @ pixels
            return np.column_stack(self.grid.pixel_to_map(row, col))

        return shapely.transform(geometry, transform)

    def sample(self, cells: NDArray[Scalar]) -> NDArray[Scalar]:
        """Values of a grid map's cells at the centres of the working cells, shape (H, W); 0 beyond the map.

        cells: shape of the grid map. A centre on the corner of four cells, where an even number of cells is joined,
        takes the one below and to the right.
        """
        height, width = self.free.shape
        rows, cols = np.arange(height) + 0.5, np.arange(width) + 0.5
        swapped = self.to_grid[0, 0] == 0
        along_rows, along_cols = (cols, rows) if swapped else (rows, cols)
        row = np.floor(self.to_grid[0, int(swapped)] * along_rows + self.to_grid[0, 2]).astype(int)
        col = np.floor(self.to_grid[1, int(not swapped)] * along_cols + self.to_grid[1, 2]).astype(int)
        inside = np.outer((row >= 0) & (row < cells.shape[0]), (col >= 0) & (col < cells.shape[1]))
        values = cells[np.ix_(row.clip(0, cells.shape[0] - 1), col.clip(0, cells.shape[1] - 1))]
        values[~inside] = 0
        return np.asarray(values.T if swapped else values)


def check_shows_rooms(grid: GridMap) -> None:
    """Raise MapError for a map with too coarse cells or too far from zero, without free cells, or with no other."""
    check_resolution(grid.resolution)
    if max(map(abs, grid.origin[:2])) > MAX_ORIGIN:
        raise MapError(f"its origin, {grid.origin[:2]}, is farther than {MAX_ORIGIN:g} m from zero; check the origin")
    if not grid.free.any():
        raise MapError(NO_FREE_CELL)
    if grid.free.all():
        raise MapError("every cell of the map is free, so no wall bounds a room; check its thresholds and negate")


def check_resolution(resolution: float) -> None:
    """Raise MapError for cells, of metres, that are too coarse to show rooms."""
    if resolution > MAX_RESOLUTION:
        raise MapError(f"cells of {resolution:g} m are too coarse to show rooms; check the resolution")


def remove_clutter(free: Mask, *, size_px: float) -> Mask:
    """Free cells, shape (H, W), where groups of other cells less than size_px across, i.e. furniture, become free.

    Section 3.2 of the thesis. Groups are 8-connected; their size is the diagonal of their bounding box. Groups at the
    edge of the map stay.
    """
    # A frame joins the groups at the edge, as if the map had more unknown cells around it.
    others = np.pad(~free, 1, constant_values=True).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(others, connectivity=8)
    small = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT]) < size_px
    # The free space itself has label 0.
    small[[0, labels[0, 0]]] = False
    return np.asarray(free | small[labels[1:-1, 1:-1]])


def to_working_grid(
    grid: GridMap, free: Mask, *, resolution: float, coarsest: float | None = None, normal_pose: bool = True
) -> WorkingGrid:
    """Working grid of the free cells of a grid map, with cells of about the resolution, in metres.

    Smaller cells are joined; a joined cell is free when all its parts are, so that no wall is lost. Larger cells are
    repeated, those up to coarsest (metres; None: the resolution) stay. A map that was enlarged, so that its
    cells come in equal blocks, is taken as one of larger cells. normal_pose: False to keep the pose of the map.
    Raises MapError when no cell is free, or the cells are too small or too large to show rooms.
    """
    if not free.any():
        raise MapError(NO_FREE_CELL)
    row_span, col_span = (np.flatnonzero(free.any(axis=axis))[[0, -1]] for axis in (1, 0))
    window = free[row_span[0] : row_span[1] + 1, col_span[0] : col_span[1] + 1]
    if coarsest is not None:
        # Whole parts of blocks, so that no joined cell is in two of them
        block = _measure_blocks(grid.cells, row_span, col_span)
        parts = [grid.resolution * side for side in range(1, block + 1) if block % side == 0]
        resolution = max([resolution, *(side for side in parts if side <= coarsest * (1 + 1e-9))])
        if grid.resolution > coarsest:
            resolution = coarsest
    # The pose comes first, so that the same cells are joined in every pose of the map.
    cells, pose = _turn_to_canonical_pose(window) if normal_pose else (window, np.eye(3))
    cells, step = _resample_cells(cells, grid.resolution, resolution)
    to_grid = _shift(row_span[0], col_span[0]) @ pose @ np.diag([step, step, 1.0]) @ _shift(-MARGIN_PX, -MARGIN_PX)
    return WorkingGrid(np.pad(cells, MARGIN_PX), grid.resolution * step, to_grid, grid)


def _measure_blocks(cells: NDArray[np.int8], row_span: Indices, col_span: Indices) -> int:
    """Side of the equal square blocks in which the cells of a map come, shape (H, W); 1 if they do not.

    row_span, col_span: first and last row and column of the free space, of which the blocks are counted.
    """
    sides = [(cells[1:] != cells[:-1]).any(axis=1), (cells[:, 1:] != cells[:, :-1]).any(axis=0)]
    starts = [np.flatnonzero(side) + 1 - span[0] for side, span in zip(sides, (row_span, col_span), strict=True)]
    lengths = [span[1] + 1 - span[0] for span in (row_span, col_span)]
    return int(np.gcd.reduce(np.concatenate([*starts, lengths])))


def _resample_cells(cells: Mask, resolution: float, target: float) -> tuple[Mask, float]:
    """Cells of about the target size, from cells of the given resolution (metres); and the factor between the two."""
    check_resolution(resolution)
    if resolution > target:
        affordable = max(1, int((MAX_REPEATED_CELLS / cells.size) ** 0.5))
        repeats = min(round(resolution / target), affordable)
        return cells.repeat(repeats, axis=0).repeat(repeats, axis=1), 1 / repeats
    if target / resolution >= max(cells.shape) + 1:
        raise MapError(f"the free space is less than {target:g} m across; check the resolution of {resolution:g} m")
    factor = round(target / resolution)
    coarse = _join_cells(cells, factor)
    if not coarse.any():
        raise MapError(f"no free space is {target:g} m wide; check the resolution of {resolution:g} m")
    return coarse, float(factor)


def _join_cells(cells: Mask, factor: int) -> Mask:
    """Blocks of factor × factor cells as one cell each, free when the whole block is; the last ones may be smaller."""
    row_starts, col_starts = (np.arange(0, size, factor) for size in cells.shape)
    return np.asarray(np.logical_and.reduceat(np.logical_and.reduceat(cells, row_starts, axis=0), col_starts, axis=1))


def _turn_to_canonical_pose(cells: Mask) -> tuple[Mask, Floats]:
    """The cells wider than high and skewed towards the first row and column; and the matrix that turns them back.

    Poses with equal moments are compared cell by cell.
    """
    moments = [_central_moments(cells.sum(axis=axis)) for axis in (1, 0)]
    candidates: dict[tuple[tuple[int, int], ...], list[tuple[Mask, Floats]]] = {}
    for pose in product((False, True), repeat=3):
        swap, *flips = pose
        shape = [(spread, -skew if flip else skew) for (spread, skew), flip in zip(moments, flips, strict=True)]
        candidates.setdefault(tuple(shape if swap else shape[::-1]), []).append(_turn_cells(cells, pose))
    turned, back = max(candidates[max(candidates)], key=lambda turned: (turned[0].shape, turned[0].tobytes()))
    return np.ascontiguousarray(turned), back


def _turn_cells(cells: Mask, pose: Pose) -> tuple[Mask, Floats]:
    """The cells in a pose; and the matrix that turns them back."""
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
    """Second and third central moment of a histogram, times powers of its total; integers, so that ties are exact."""
    position, weight = 2 * np.arange(len(counts)).astype(object) - (len(counts) - 1), counts.astype(object)
    total, first, second, third = (int((weight * position**power).sum()) for power in range(4))
    return total * second - first**2, total**2 * third - 3 * total * first * second + 2 * first**3


def _shift(row: float, col: float) -> Floats:
    return np.array([[1.0, 0.0, row], [0.0, 1.0, col], [0.0, 0.0, 1.0]])
