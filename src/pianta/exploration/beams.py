"""The cells of a grid that straight beams cross, in order (Amanatides and Woo, 1987).

numba, of the extra `pianta[sim]`, compiles the loop over cells. Without numba Python runs the same loop: the results
are equal, and a run takes 5 to 10 times as long.
"""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from math import floor, inf
from typing import Any, NamedTuple

import numpy as np

from pianta._types import Floats, Indices, Mask


class Crossings(NamedTuple):
    """The crossed cells of all beams, those of a beam after each other, shape (n,) each.

    beams: index of the beam. cells: index in the flattened grid. entries, exits: distance along the beam at which it
    enters and leaves the cell, cells.
    """

    beams: Indices
    cells: Indices
    entries: Floats
    exits: Floats


def cross_cells(stops: Mask, origin: tuple[float, float], beams: Floats, limits: Floats) -> Crossings:
    """List the cells that beams cross up to their limits, the border of the grid, or their first stop.

    stops: shape (H, W), cells that no beam enters. origin: continuous row, col. beams: unit vectors row, col, shape
    (N, 2). limits: cells, shape (N,).
    """
    cells, entries, counts = _walk_beams(stops, origin, beams, limits)
    crossed = np.arange(cells.shape[1]) < counts[:, None]
    return Crossings(np.nonzero(crossed)[0], cells[crossed], entries[:, :-1][crossed], entries[:, 1:][crossed])


def measure_ranges(stops: Mask, origin: tuple[float, float], beams: Floats, reach: float) -> Floats:
    """Measure how far each beam gets, cells, shape (N,): to its first stop or the border; inf beyond the reach.

    Arguments as for `cross_cells`.
    """
    _, entries, counts = _walk_beams(stops, origin, beams, np.full(len(beams), reach))
    ends: Floats = entries[np.arange(len(beams)), counts]
    return np.where(ends < reach, ends, inf)


@cache
def has_numba() -> bool:
    """Whether numba, of the extra pianta[sim], is installed."""
    return find_spec("numba") is not None


def _walk_beams(
    stops: Mask, origin: tuple[float, float], beams: Floats, limits: Floats
) -> tuple[Indices, Floats, Indices]:
    """Cells and entries of each beam, shape (N, most) and (N, most + 1), and how many of its cells are set."""
    walk = _compile_loop() if has_numba() else _loop_over_cells
    # A beam leaves a cell through a row or a column, of which its length crosses 1.42 a cell at most.
    most = int(min(1.42 * limits.max(initial=0) + 3, sum(stops.shape)))
    # Beams almost parallel to an axis need infinitely far to the next cell across it.
    with np.errstate(over="ignore"):
        walked: tuple[Indices, Floats, Indices] = walk(stops, float(origin[0]), float(origin[1]), beams, limits, most)
    return walked


@cache
def _compile_loop() -> Any:  # noqa: ANN401 - a dispatcher of numba, which has no types
    """Compile the loop; the machine code is cached on disk for other processes."""
    from numba import njit

    return njit(cache=True, nogil=True)(_loop_over_cells)


def _loop_over_cells(  # noqa: PLR0917 - numba takes no keywords
    stops: Mask, row0: float, col0: float, beams: Floats, limits: Floats, most: int
) -> tuple[Indices, Floats, Indices]:
    """Cells, shape (N, most), entries, shape (N, most + 1), and count of cells of each beam; numba can compile it.

    row0, col0: the origin, in cells. most: number of cells that no beam exceeds. The others as for `cross_cells`.
    """
    height, width = stops.shape
    cells = np.empty((len(beams), most), np.int64)
    entries = np.empty((len(beams), most + 1))
    counts = np.zeros(len(beams), np.int64)
    for beam in range(len(beams)):
        down, right = beams[beam, 0], beams[beam, 1]
        row, col = floor(row0), floor(col0)
        next_row = (row + (down > 0) - row0) / down if down != 0 else inf
        next_col = (col + (right > 0) - col0) / right if right != 0 else inf
        entry, count = 0.0, 0
        while entry < limits[beam] and 0 <= row < height and 0 <= col < width and not stops[row, col]:
            cells[beam, count], entries[beam, count] = row * width + col, entry
            count += 1
            if next_row < next_col:
                entry = next_row
                next_row += abs(1 / down)
                row += 1 if down > 0 else -1
            else:
                entry = next_col
                next_col += abs(1 / right)
                col += 1 if right > 0 else -1
        entries[beam, count], counts[beam] = entry, count
    return cells, entries, counts
