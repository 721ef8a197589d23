"""How much unknown area a lidar may observe from a cell: all that no mapped obstacle hides."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, pi

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.exploration.beams import cross_cells
from pianta.gridmap import OCCUPIED, UNKNOWN

# Distance between beams at the end of their reach, cells; chosen by hand: the area between beams is interpolated.
BEAM_GAP_PX = 4.0
MIN_BEAMS = 8


def measure_gains(
    cells: NDArray[np.int8], targets: Sequence[tuple[int, int]], *, reach: float, resolution: float
) -> Floats:
    """Measure the unknown area, m², shape (targets,), in sight of the middle of each target cell.

    cells: shape (H, W); -1 unknown, 0 free, 100 occupied. Beams end at occupied cells, their reach, and the grid's
    border. reach, resolution: metres.
    """
    reach_px = reach / resolution
    count = max(ceil(2 * pi * reach_px / BEAM_GAP_PX), MIN_BEAMS)
    angles = 2 * pi * (np.arange(count) + 0.5) / count
    beams = np.column_stack([np.sin(angles), np.cos(angles)])
    stops, unknown, limits = cells == OCCUPIED, (cells == UNKNOWN).ravel(), np.full(count, reach_px)
    squares = np.zeros((len(targets), count))
    for number, (row, col) in enumerate(targets):
        crossings = cross_cells(stops, (row + 0.5, col + 0.5), beams, limits)
        exits = np.minimum(crossings.exits, reach_px)
        rings = np.where(unknown[crossings.cells], exits * exits - crossings.entries * crossings.entries, 0)
        squares[number] = np.bincount(crossings.beams, rings, minlength=count)
    # Each beam stands for a sector of a circle.
    return np.asarray(squares.sum(axis=1) * (pi / count) * resolution**2)
