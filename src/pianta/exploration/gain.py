"""How much of the unknown a lidar may see from a place: all that no known obstacle hides."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, inf, pi

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.exploration.kernels import choose_kernel
from pianta.exploration.lidar import BeamWalk
from pianta.gridmap import OCCUPIED, UNKNOWN

# Beams are this far apart at the end of their reach, cells; between them, the area is interpolated.
SPREAD_PX = 4.0


def measure_gains(
    known: NDArray[np.int8], targets: Sequence[tuple[int, int]], *, reach: float, resolution: float
) -> Floats:
    """Unknown area, m², shape (targets,), in sight of the middle of each target cell.

    known: shape (H, W); -1 unknown, 0 free, 100 occupied. Beams end at occupied cells, their reach, and the grid's end.
    reach, resolution: metres.
    """
    reach_px = reach / resolution
    count = max(ceil(2 * pi * reach_px / SPREAD_PX), 8)
    angles = 2 * pi * (np.arange(count) + 0.5) / count
    beams = np.column_stack([np.sin(angles), np.cos(angles)])
    measure = choose_kernel(sum_beams, sum_beams_together)
    squares = measure(known, np.array(targets, np.int64).reshape(-1, 2), beams, reach_px)
    # A beam stands for a sector of a circle.
    return np.asarray(squares.sum(axis=1) * (pi / count) * resolution**2)


def sum_beams(known: NDArray[np.int8], targets: NDArray[np.int64], beams: Floats, reach: float) -> Floats:
    """Sums of leaving² - entering² of unknown cells, shape (targets, beams), cells²; for numba."""
    height, width = known.shape
    sums = np.zeros((len(targets), len(beams)))
    for target in range(len(targets)):
        row0, col0 = targets[target, 0] + 0.5, targets[target, 1] + 0.5
        for beam in range(len(beams)):
            down, right = beams[beam, 0], beams[beam, 1]
            row, col = floor(row0), floor(col0)
            next_row = (row + (down > 0) - row0) / down if down != 0 else inf
            next_col = (col + (right > 0) - col0) / right if right != 0 else inf
            way = 0.0
            while way < reach and 0 <= row < height and 0 <= col < width and known[row, col] != OCCUPIED:
                leaving = min(next_row, next_col, reach)
                if known[row, col] == UNKNOWN:
                    sums[target, beam] += leaving * leaving - way * way
                way = leaving
                if next_row < next_col:
                    next_row += abs(1 / down)
                    row += 1 if down > 0 else -1
                else:
                    next_col += abs(1 / right)
                    col += 1 if right > 0 else -1
    return sums


def sum_beams_together(known: NDArray[np.int8], targets: NDArray[np.int64], beams: Floats, reach: float) -> Floats:
    """Sums of leaving² - entering² of unknown cells, shape (targets, beams), cells²; for numpy."""
    return np.array([_sum_of_target(known, target, beams, reach) for target in targets]).reshape(-1, len(beams))


def _sum_of_target(known: NDArray[np.int8], target: NDArray[np.int64], beams: Floats, reach: float) -> Floats:
    sums = np.zeros(len(beams))
    walk, going = BeamWalk(target[0] + 0.5, target[1] + 0.5, beams), np.arange(len(beams))
    while going.size:
        rows, cols = walk.rows[going], walk.cols[going]
        inside = (rows >= 0) & (rows < known.shape[0]) & (cols >= 0) & (cols < known.shape[1])
        going = going[inside & (walk.way[going] < reach)]
        values = known[walk.rows[going], walk.cols[going]]
        going, values = going[values != OCCUPIED], values[values != OCCUPIED]
        leaving, way = np.minimum(walk.leaves_at(going), reach), walk.way[going]
        sums[going] += np.where(values == UNKNOWN, leaving * leaving - way * way, 0)
        walk.step(going)
    return sums
