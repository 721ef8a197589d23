"""Back-and-forth lanes over a part of the open cells: the boustrophedon decomposition of Choset (2000).

A slice goes through the part at each lane. Its pieces are lanes; a lane belongs to the cell of the decomposition of the
lane before it, unless the part divides, joins, begins or ends between them.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import TypeAlias

import numpy as np

from pianta._types import Mask

# The slice of a lane, its first and its last position along the slice, cells.
Lane: TypeAlias = tuple[int, int, int]


@dataclass(frozen=True)
class Lanes:
    """The cells of a decomposition, each a list of lanes side by side. along_rows: whether lanes are rows."""

    cells: tuple[tuple[Lane, ...], ...]
    along_rows: bool

    def locate_ends(self, lane: Lane) -> tuple[tuple[int, int], tuple[int, int]]:
        """The row and col of both ends of a lane."""
        at, first, last = lane
        return ((at, first), (at, last)) if self.along_rows else ((first, at), (last, at))


def decompose(part: Mask, spacing: float) -> Lanes:
    """The lanes of a part at most a spacing apart, in cells, along rows or columns, whichever has fewer lanes.

    part: shape (h, w).
    """
    choices = [Lanes(_join_lanes(_cut_slices(mask, spacing)), rows) for mask, rows in ((part, True), (part.T, False))]
    return min(choices, key=lambda lanes: sum(map(len, lanes.cells)))


def _cut_slices(part: Mask, spacing: float) -> list[list[Lane]]:
    """The pieces of the rows of a part at equal distances, from its first to its last row."""
    filled = np.flatnonzero(part.any(axis=1))
    count = max(ceil((filled[-1] - filled[0]) / spacing), 1) + 1
    slices = []
    for at in np.unique(np.linspace(filled[0], filled[-1], count).round().astype(int)).tolist():
        changes = np.flatnonzero(np.diff(part[at].astype(np.int8), prepend=0, append=0))
        slices.append([(at, first, end - 1) for first, end in changes.reshape(-1, 2).tolist()])
    return slices


def _join_lanes(slices: list[list[Lane]]) -> tuple[tuple[Lane, ...], ...]:
    """Lanes of neighbouring slices are in one cell if each is beside the other and beside no third."""
    cells: list[list[Lane]] = []
    open_cells: dict[Lane, list[Lane]] = {}
    for before, lanes in zip([[], *slices], slices, strict=False):
        continued = {}
        for lane in lanes:
            beside = [other for other in before if _are_beside(other, lane)]
            is_alone = len(beside) == 1 and sum(_are_beside(beside[0], other) for other in lanes) == 1
            cell = open_cells[beside[0]] if is_alone else []
            if not cell:
                cells.append(cell)
            cell.append(lane)
            continued[lane] = cell
        open_cells = continued
    return tuple(map(tuple, cells))


def _are_beside(one: Lane, other: Lane) -> bool:
    return one[1] <= other[2] and other[1] <= one[2]
