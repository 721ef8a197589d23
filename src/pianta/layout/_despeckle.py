"""Single cells of a grid map that differ from all around them: noise of the sensor or of the picture."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Mask
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap

# A gap of a single cell in a line of obstacles is closed, unless it may be a door; metres (chosen by hand).
MAX_GAP = 0.15
# A cell and its eight neighbours.
BLOCK = np.ones((3, 3), np.uint8)
# Pairs of opposite neighbours: row and col of the one; the other is point-symmetric.
OPPOSITE = ((0, 1), (1, 0), (1, 1), (1, -1))


def despeckle(grid: GridMap) -> GridMap:
    """The map where single cells without a like cell among their eight neighbours become what is around them.

    Obstacles in free space become free, those in unknown space unknown; free cells in walls become obstacles, those in
    unknown space unknown; unknown cells in free space become free. A free cell between two obstacles on opposite sides,
    a gap of a single cell in a line, becomes an obstacle. Whatever spans two cells stays.
    """
    free, occupied = grid.free, grid.occupied
    unknown = ~(free | occupied)
    near_free, near_occupied, near_unknown = (_count_neighbours(mask) for mask in (free, occupied, unknown))
    cells = grid.cells.copy()
    # Each cell is judged by the cells of the map, not by those that were changed before
    single = occupied & (near_occupied == 0)
    cells[single & (near_free > near_unknown)] = FREE
    cells[single & (near_free <= near_unknown)] = UNKNOWN
    cells[unknown & (near_unknown == 0) & (near_free > near_occupied)] = FREE
    single = free & (near_free == 0)
    cells[single & (near_occupied <= near_unknown)] = UNKNOWN
    cells[single & (near_occupied > near_unknown)] = OCCUPIED
    if grid.resolution <= MAX_GAP:
        cells[free & _lie_between(occupied)] = OCCUPIED
    return GridMap(cells, grid.resolution, grid.origin, grid.source)


def _count_neighbours(mask: Mask) -> NDArray[np.uint8]:
    """How many of the eight neighbours of each cell are in a mask, shape (H, W)."""
    cells = mask.astype(np.uint8)
    around = cv2.boxFilter(cells, cv2.CV_8U, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(around - cells)


def _lie_between(mask: Mask) -> Mask:
    """Cells with two opposite neighbours in a mask, shape (H, W)."""
    height, width = mask.shape
    framed = np.pad(mask, 1)
    between = np.zeros_like(mask)
    for down, right in OPPOSITE:
        one, other = (
            framed[1 + side * down : 1 + side * down + height, 1 + side * right : 1 + side * right + width]
            for side in (1, -1)
        )
        between |= one & other
    return between
