"""The occupancy grid that a robot builds of its scans: log odds of each cell, after Moravec and Elfes (1985)."""

from __future__ import annotations

from math import floor, inf

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.exploration.kernels import choose_kernel
from pianta.exploration.lidar import BeamWalk, Lidar, Pose, aim_beams
from pianta.exploration.world import World
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap

# Log odds that a beam's end adds to its cell and its way takes from the cells before, and where they are cut off.
HIT, MISS, MOST = np.float32(0.9), np.float32(0.5), np.float32(4.0)
# A range ends on the face of an obstacle; this far behind, in cells, is the obstacle, whatever the noise.
DEPTH_PX = 0.3


class OccupancyGrid:
    """What robots know of a world, in its frame.

    cells: shape (H, W), int8; -1 unknown, 0 free, 100 occupied. Changes with every scan.
    log_odds: shape (H, W), float32; 0 where unknown.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self.cells: NDArray[np.int8] = np.full(world.blocked.shape, UNKNOWN, np.int8)
        self.log_odds: NDArray[np.float32] = np.zeros(world.blocked.shape, np.float32)
        self._scan_of_cell = np.zeros(world.blocked.shape, np.int32)
        self._scans = 0

    def add_scan(self, pose: Pose, lidar: Lidar, ranges: Floats) -> None:
        """Take in a scan: each cell counts once, as hit where any beam ends in it, else as free where any crosses it.

        ranges: shape (beams,), metres; inf where there was no echo within the lidar's reach.
        """
        self._scans += 1
        resolution = self._world.resolution
        row, col = self._world.place(pose.x, pose.y)
        beams = aim_beams(self._world, lidar.angles(pose.heading))
        reach, ranges = lidar.reach / resolution, ranges / resolution
        echo = ranges < reach
        self._hit_cells([row, col] + beams[echo] * (ranges[echo, None] + DEPTH_PX))
        # The cell that a beam ends in is not crossed, though noise may have drawn it before the face.
        ends = np.where(echo, ranges + DEPTH_PX, inf)
        clear = choose_kernel(clear_ways, clear_ways_together)
        limits = np.minimum(ranges, reach)
        clear(self.log_odds, self.cells, self._scan_of_cell, self._scans, (row, col), beams, limits, ends)

    def _hit_cells(self, ends: Floats) -> None:
        """Raise the odds of the cells in which beams end; row, col, shape (N, 2)."""
        rows, cols = np.floor(ends).astype(int).T
        inside = (rows >= 0) & (rows < self.cells.shape[0]) & (cols >= 0) & (cols < self.cells.shape[1])
        # A cell that occurs twice gets the same value twice.
        hit = rows[inside], cols[inside]
        self._scan_of_cell[hit] = self._scans
        self.log_odds[hit] = np.minimum(self.log_odds[hit] + HIT, MOST)
        self.cells[hit] = np.where(self.log_odds[hit] <= 0, FREE, OCCUPIED)

    def to_grid_map(self) -> GridMap:
        """The grid map as it is now."""
        return GridMap(self.cells.copy(), self._world.resolution, self._world.origin)


def clear_ways(  # noqa: PLR0917 - numba takes no keywords
    log_odds: NDArray[np.float32],
    cells: NDArray[np.int8],
    scan_of_cell: NDArray[np.int32],
    scan: int,
    place: tuple[float, float],
    beams: Floats,
    limits: Floats,
    ends: Floats,
) -> None:
    """Lower the odds of cells that beams cross, in place, each once a scan, beam after beam; for numba.

    limits: how far beams are followed; ends: behind the faces that they meet, in cells, shape (N,).
    """
    height, width = cells.shape
    for beam in range(len(beams)):
        down, right = beams[beam, 0], beams[beam, 1]
        row, col = floor(place[0]), floor(place[1])
        next_row = (row + (down > 0) - place[0]) / down if down != 0 else inf
        next_col = (col + (right > 0) - place[1]) / right if right != 0 else inf
        way = 0.0
        while way < limits[beam] and 0 <= row < height and 0 <= col < width:
            leaving = min(next_row, next_col)
            if leaving > ends[beam]:
                break
            if scan_of_cell[row, col] != scan:
                scan_of_cell[row, col] = scan
                log_odds[row, col] = max(log_odds[row, col] - MISS, -MOST)
                cells[row, col] = FREE if log_odds[row, col] <= 0 else OCCUPIED
            way = leaving
            if next_row < next_col:
                next_row += abs(1 / down)
                row += 1 if down > 0 else -1
            else:
                next_col += abs(1 / right)
                col += 1 if right > 0 else -1


def clear_ways_together(  # noqa: PLR0917 - as clear_ways
    log_odds: NDArray[np.float32],
    cells: NDArray[np.int8],
    scan_of_cell: NDArray[np.int32],
    scan: int,
    place: tuple[float, float],
    beams: Floats,
    limits: Floats,
    ends: Floats,
) -> None:
    """The same for all beams a cell further at a time; for numpy."""
    crossed = np.zeros(cells.shape, bool)
    walk, going = BeamWalk(*place, beams), np.arange(len(beams))
    while going.size:
        rows, cols = walk.rows[going], walk.cols[going]
        inside = (rows >= 0) & (rows < cells.shape[0]) & (cols >= 0) & (cols < cells.shape[1])
        going = going[inside & (walk.way[going] < limits[going]) & (walk.leaves_at(going) <= ends[going])]
        crossed[walk.rows[going], walk.cols[going]] = True
        walk.step(going)
    crossed &= scan_of_cell != scan
    scan_of_cell[crossed] = scan
    log_odds[crossed] = np.maximum(log_odds[crossed] - MISS, -MOST)
    cells[crossed] = np.where(log_odds[crossed] <= 0, FREE, OCCUPIED)
