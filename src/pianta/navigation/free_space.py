"""Where the middle of a round robot can be: the cells of a map farther from every obstacle than its radius.

As in Nav2's inflation layer, a cell is closed if its middle is at most the radius from the middle of an occupied cell.
The middle of the robot stays on cells that the map shows as free; unknown cells are no obstacles to its rim.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import ceil, hypot

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.floor import Floor
from pianta.gridmap import GridMap

# Cells; a straight line keeps so far from closed cells that rounded coordinates and corners of cells do no harm: 1 mm
# on cells of 5 cm. Chosen by hand.
SLACK_PX = 0.02
# Metres; cells of no room belong to the nearest one within this, such as those of doorways: the thickness of a wall.
ROOM_REACH = 0.5
# A metre beside an obstacle costs PENALTY more, and one CLEAR metres from the rim of the robot nothing more: doors are
# passed in their middle, and corners not touched. Chosen by hand: ways get a few per cent longer.
PENALTY = 1.0
CLEAR = 0.3  # metres
TINY = 1e-12  # share of a line
SAMPLES_PER_CELL = 2  # where the cost of a straight line is measured


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """The open cells of a map for a robot.

    grid: the map. radius: of the robot, metres. open: shape (H, W), where its middle can be. clearance: metres from
    the middle of each cell to that of the nearest occupied one, shape (H, W). rooms: the id of the room of each cell,
    shape (H, W), 0 outside of all.
    """

    grid: GridMap
    radius: float
    open: Mask
    clearance: Floats
    rooms: LabelImage

    @cached_property
    def parts(self) -> LabelImage:
        """The connected parts of the open cells, numbered by descending size from 1; 0 for closed cells."""
        _, parts, stats, _ = cv2.connectedComponentsWithStats(self.open.astype(np.uint8), connectivity=4)
        order = np.argsort(-stats[1:, cv2.CC_STAT_AREA], kind="stable")
        numbers = np.zeros(len(stats), np.int32)
        numbers[1 + order] = np.arange(1, len(stats))
        return np.asarray(numbers[parts])

    @cached_property
    def costs(self) -> Floats:
        """The cost of a metre in each cell, shape (H, W): 1 far from obstacles, more beside them, inf if closed."""
        near = np.clip(1 - (self.clearance - self.radius) / CLEAR, 0, 1)
        return np.asarray(np.where(self.open, 1 + PENALTY * near, np.inf))

    @cached_property
    def _closed_bytes(self) -> tuple[bytes, bytes]:
        """A byte for each cell, row by row and column by column, 1 if it is closed."""
        return (~self.open).tobytes(), (~self.open.T).tobytes()

    def measure_cost(self, start: ArrayLike, end: ArrayLike) -> float:
        """The cost of a straight line between the middles of two cells, row, col, by samples; inf if one is closed."""
        rows, cols, length = _sample_line(start, end)
        samples = self.costs.ravel().take(rows * self.open.shape[1] + cols)
        return float(samples.sum()) / len(rows) * length * self.grid.resolution

    def to_map(self, cells: ArrayLike) -> Floats:
        """The x, y of the middles of cells, metres of the map frame, shape (N, 2); cells: row, col, shape (N, 2)."""
        rows, cols = np.reshape(np.asarray(cells, float), (-1, 2)).T
        return np.column_stack(self.grid.pixel_to_map(rows + 0.5, cols + 0.5))

    def is_straight(self, start: ArrayLike, end: ArrayLike) -> bool:
        """Whether the robot can drive straight from the middle of a cell to that of another; cells: row, col."""
        (row, col), (last_row, last_col) = np.asarray(start, float).tolist(), np.asarray(end, float).tolist()
        height, width = self.open.shape
        if abs(last_row - row) <= abs(last_col - col):
            return _is_clear(self._closed_bytes[0], width, (row, col), (last_row, last_col))
        return _is_clear(self._closed_bytes[1], height, (col, row), (last_col, last_row))


def find_free_space(floor: Floor, grid: GridMap, radius: float) -> FreeSpace:
    """The open cells of the map of a floor, for a robot with a radius in metres."""
    free = (~grid.occupied).astype(np.uint8)
    clearance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE).astype(float) * grid.resolution
    is_open = grid.free & (clearance > radius + 1e-6 * grid.resolution)
    rooms = floor.label_image(grid).astype(np.int32)
    return FreeSpace(grid, radius, is_open, clearance, _extend_rooms(rooms, ROOM_REACH / grid.resolution))


def _is_clear(closed: bytes, width: int, start: tuple[float, float], end: tuple[float, float]) -> bool:
    """Whether a straight line between the middles of two cells, SLACK_PX wide on each side, meets no closed cell.

    closed: a byte for each cell, row by row, 1 if it is closed; searched row by row without numpy, whose calls take
    longer than the search.
    """
    (row, col), (last_row, last_col) = sorted((start, end))
    low, high = min(col, last_col) + 0.5 - SLACK_PX, max(col, last_col) + 0.5 + SLACK_PX
    slope = (last_col - col) / (last_row - row) if last_row > row else 0.0
    aside = SLACK_PX * hypot(1, slope)
    enter = col + 0.5
    for line in range(int(row), int(last_row) + 1):
        leave = col + 0.5 + (line + 0.5 - row) * slope if line < last_row else last_col + 0.5
        first = int(max(min(enter, leave) - aside, low))
        last = int(min(max(enter, leave) + aside, high))
        if closed.find(1, line * width + first, line * width + last + 1) >= 0:
            return False
        enter = leave
    return True


def _sample_line(start: ArrayLike, end: ArrayLike) -> tuple[Indices, Indices, float]:
    """Rows and cols of cells along the straight line between the middles of two cells, and its length in cells."""
    (row, col), (last_row, last_col) = np.asarray(start, float).tolist(), np.asarray(end, float).tolist()
    length = hypot(last_row - row, last_col - col)
    count = max(ceil(SAMPLES_PER_CELL * length), 1)
    shares = np.arange(count + 1) / count
    rows = (row + 0.5 + shares * (last_row - row)).astype(np.intp)
    cols = (col + 0.5 + shares * (last_col - col)).astype(np.intp)
    return rows, cols, length


def cross_cells(start: Floats, end: Floats) -> tuple[Indices, Floats]:
    """The cells, row, col, shape (N, 2), that a straight line crosses, and its length in each, shape (N,), in cells.

    start, end: continuous pixels, where the middle of cell [i, j] is (i + 0.5, j + 0.5).
    """
    ahead = end - start
    shares = [np.array([0.0, 1.0])]
    for low, high, first, step in zip(*np.sort([start, end], axis=0), start, ahead, strict=True):
        lines = np.arange(np.ceil(low), np.floor(high) + 1)
        shares += [(lines - first) / step] if step else []
    borders = np.sort(np.concatenate(shares))
    pieces = borders[1:] - borders[:-1]
    # At a corner two borders coincide
    is_piece = pieces > TINY
    middles = ((borders[1:] + borders[:-1]) / 2)[is_piece] if is_piece.any() else np.array([0.5])
    return np.floor(start + middles[:, None] * ahead).astype(np.intp), pieces[is_piece] * np.hypot(*ahead)


def _extend_rooms(rooms: LabelImage, reach_px: float) -> LabelImage:
    """Give cells of no room the id of the nearest room, within reach."""
    if not rooms.any():
        return rooms
    outside = (rooms == 0).astype(np.uint8)
    distances, nearest = cv2.distanceTransformWithLabels(
        outside, cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    ids = np.zeros(int(nearest.max()) + 1, np.int32)
    ids[nearest[rooms > 0]] = rooms[rooms > 0]
    return np.asarray(np.where(distances <= reach_px, ids[nearest], 0), np.int32)
