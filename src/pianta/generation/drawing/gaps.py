"""Gaps between rooms are closed: rooms grow to the next room, and to the facade beside them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.ndimage import find_objects

from pianta.generation.drawing.blocks import NO_ROOM, Cells

# All chosen by hand, on the graphs of real schools.
WIDEST_GAP = 14  # cells
DEEPEST_STEP = 8  # cells, of a facade that becomes straight
MIN_TOUCHED = 0.2  # of the side that grows, which meets another room
MAX_GROWTH = 0.5  # of the area of a room
PASSES = 2
GROWTH = 1.08  # of a building by rows, arms and gaps; corridors, which grow most, are as much smaller before


def close_gaps(cells: Cells, rooms: Iterable[int]) -> None:
    """Let rooms grow by whole sides, so that they remain as they were in shape.

    cells: the room of each cell, changed in place.
    """
    counts = np.bincount(cells[cells >= 0])
    for _ in range(PASSES):
        boxes = find_objects(np.maximum(cells + 1, 0))
        for room in rooms:
            around = cells[_widen(boxes[room])]
            for turn in range(4):
                _grow_up(np.rot90(around, turn), room, (1 + MAX_GROWTH) * counts[room])


def _widen(box: tuple[slice, slice]) -> tuple[slice, slice]:
    """A bounding box with all cells around it that decide how a room grows."""
    rows, columns = (slice(max(0, side.start - WIDEST_GAP - 2), side.stop + WIDEST_GAP + 2) for side in box)
    return rows, columns


def _grow_up(cells: Cells, room: int, most: float) -> None:
    """Let a room grow to lower rows. most: cells of the room after that."""
    rows, columns = np.nonzero(cells == room)
    top = int(rows.min())
    side = np.sort(columns[rows == top])
    first, last = int(side[0]), int(side[-1]) + 1
    # A side of two parts cannot grow as a whole, and one at the margin has nothing before it
    if last - first != len(side) or top == 0 or first == 0 or last == cells.shape[1]:
        return
    start = max(0, top - WIDEST_GAP - 1)
    ahead = (cells[start:top, first:last] != NO_ROOM)[::-1]
    depth = _count_free(ahead.any(axis=1))
    if depth == len(ahead) or ahead[depth].mean() < MIN_TOUCHED:
        beside = (cells[start:top, [first - 1, last]] == NO_ROOM)[::-1]
        step = max(_count_free(beside[:, 0]), _count_free(beside[:, 1]))
        depth = min(depth, step) if step <= DEEPEST_STEP else 0
    if depth and len(rows) + depth * len(side) <= most:
        cells[top - depth : top, first:last] = room


def _count_free(is_taken: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> int:
    """How many are free before the first one that is taken."""
    return int(np.argmax(is_taken)) if is_taken.any() else len(is_taken)
