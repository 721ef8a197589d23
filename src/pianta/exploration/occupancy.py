"""The occupancy grid that robots build from their scans: log odds of each cell (Moravec and Elfes, 1985)."""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.exploration.beams import cross_cells
from pianta.exploration.lidar import Lidar, Pose, aim_beams
from pianta.exploration.world import World
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap

# Log odds; chosen by hand. A hit raises the cell in which a beam ends, a miss lowers the cells that it crosses.
HIT_LOG_ODDS = np.float32(0.9)
MISS_LOG_ODDS = np.float32(0.5)
MAX_LOG_ODDS = np.float32(4.0)
# A range ends on the face of an obstacle; the obstacle is this far behind, in cells, whatever the noise.
DEPTH_PX = 0.3


class OccupancyGrid:
    """The map of a world that all robots share.

    cells: shape (H, W), int8; -1 unknown, 0 free, 100 occupied. Changes with every scan.
    log_odds: shape (H, W), float32; 0 if unknown.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self.cells: NDArray[np.int8] = np.full(world.blocked.shape, UNKNOWN, np.int8)
        self.log_odds: NDArray[np.float32] = np.zeros(world.blocked.shape, np.float32)
        self._no_stops = np.zeros(world.blocked.shape, bool)

    def add_scan(self, pose: Pose, lidar: Lidar, ranges: Floats) -> None:
        """Add a scan. Each cell counts once: as hit if any beam ends in it, else as free if any beam crosses it.

        ranges: shape (beams,), metres; inf without an echo within the lidar's reach.
        """
        resolution = self._world.resolution
        origin = self._world.pixel(pose.x, pose.y)
        beams = aim_beams(self._world, lidar.angles(pose.heading))
        reach, ranges = lidar.reach / resolution, ranges / resolution
        echo = ranges < reach
        hits = self._list_cells(origin + beams[echo] * (ranges[echo, None] + DEPTH_PX))
        # A beam does not cross the cell in which it ends, even if noise moved its end before the face.
        ends = np.where(echo, ranges + DEPTH_PX, inf)
        crossings = cross_cells(self._no_stops, origin, beams, np.minimum(ranges, reach))
        crossed = np.zeros(self.cells.size, bool)
        crossed[crossings.cells[crossings.exits <= ends[crossings.beams]]] = True
        crossed[hits] = False
        self._update(hits, HIT_LOG_ODDS)
        self._update(np.flatnonzero(crossed), -MISS_LOG_ODDS)

    def _list_cells(self, points: Floats) -> NDArray[np.intp]:
        """Indices of the cells of points, row, col, shape (N, 2), that are inside the grid."""
        height, width = self.cells.shape
        rows, cols = np.floor(points).astype(int).T
        inside = (rows >= 0) & (rows < height) & (cols >= 0) & (cols < width)
        return np.unique(rows[inside] * width + cols[inside])

    def _update(self, indices: NDArray[np.intp], change: np.float32) -> None:
        """Change the log odds of cells, within their limits."""
        log_odds = np.clip(self.log_odds.ravel()[indices] + change, -MAX_LOG_ODDS, MAX_LOG_ODDS)
        self.log_odds.ravel()[indices] = log_odds
        self.cells.ravel()[indices] = np.where(log_odds <= 0, FREE, OCCUPIED)

    def to_grid_map(self) -> GridMap:
        """The grid map as it is now."""
        return GridMap(self.cells.copy(), self._world.resolution, self._world.origin)
