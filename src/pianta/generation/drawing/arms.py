"""Arms of rooms through free space, for doors between rooms that do not lie side by side."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from pianta.generation.drawing.blocks import NARROWEST, NO_ROOM, Cells

Mask = NDArray[np.bool_]

TURN = 10.0  # cells that a turn costs: arms are straight where they can be


def find_widest_arm(cells: Cells, room: int, goal: int, widest: int) -> Mask | None:
    """The free cells of an arm by which a room touches another one, as wide as there is space; None without a way.

    widest: cells of its width, at most. Where the width of a corridor changes, it looks like two rooms.
    """
    if not _find_ways(cells, room, goal, NARROWEST)[0].any():
        return None
    arms = (find_arm(cells, room, goal, width) for width in range(widest, NARROWEST - 1, -1))
    return next(arm for arm in arms if arm is not None)


def find_arm(cells: Cells, room: int, goal: int, width: int) -> Mask | None:
    """The free cells of the shortest arm of a width by which a room touches another one; None without a way."""
    free, starts, ends = _find_ways(cells, room, goal, width)
    if not free.any():
        return None
    count = int(free.sum())
    numbers = np.full(cells.shape, -1)
    numbers[free] = np.arange(count)
    # States: a free square, the first `count` of arms along x, the others along y; arms leave walls at right angles
    distances, before, _ = dijkstra(
        _join_squares(numbers, count),
        directed=False,
        indices=np.concatenate([numbers[starts[0]], numbers[starts[1]] + count]),
        return_predecessors=True,
        min_only=True,
    )
    last = np.concatenate([numbers[ends[0]], numbers[ends[1]] + count])
    state = int(last[np.argmin(distances[last])])
    arm = np.zeros(cells.shape, bool)
    squares = np.argwhere(free)
    while state >= 0:
        row, column = squares[state % count]
        arm[row : row + width, column : column + width] = True
        state = int(before[state])
    return arm


def _find_ways(cells: Cells, room: int, goal: int, width: int) -> tuple[Mask, list[Mask], list[Mask]]:
    """The connected parts of the free squares that join two rooms, their starts and their ends, each of two masks."""
    free = _erode(cells == NO_ROOM, width, width)
    starts, ends = ([*_find_sides(cells == each, free, width)] for each in (room, goal))
    count, parts = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    is_way = np.zeros(count, bool)
    is_way[np.intersect1d(*(parts[np.logical_or(*sides)] for sides in (starts, ends)))] = True
    ways = is_way[parts]
    return ways, [side & ways for side in starts], [side & ways for side in ends]


def _erode(mask: Mask, rows: int, columns: int) -> Mask:
    """Where a rectangle of the mask has its first corner."""
    kernel = np.ones((rows, columns), np.uint8)
    return cv2.erode(mask.astype(np.uint8), kernel, anchor=(0, 0), borderValue=0).astype(bool)


def _find_sides(room: Mask, free: Mask, width: int) -> tuple[Mask, Mask]:
    """The free squares with a whole side on a wall of a room: those left and right of it, and those below and above."""
    upright, level = _erode(room, width, 1), _erode(room, 1, width)
    beside, over = np.zeros_like(free), np.zeros_like(free)
    beside[:, :-width] |= upright[:, width:]
    beside[:, 1:] |= upright[:, :-1]
    over[:-width] |= level[width:]
    over[1:] |= level[:-1]
    return beside & free, over & free


def _join_squares(numbers: NDArray[np.int64], count: int) -> coo_array:
    """The graph of the states: squares side by side, and turns."""

    def list_edges() -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], float]]:
        for first, second, offset in (
            (numbers[:, :-1], numbers[:, 1:], 0),
            (numbers[:-1], numbers[1:], count),
        ):
            both = (first >= 0) & (second >= 0)
            yield first[both] + offset, second[both] + offset, 1.0
        yield np.arange(count), np.arange(count) + count, TURN

    rows, columns, weights = zip(*list_edges(), strict=True)
    values = np.concatenate([np.full(len(row), weight) for row, weight in zip(rows, weights, strict=True)])
    return coo_array((values, (np.concatenate(rows), np.concatenate(columns))), shape=(2 * count, 2 * count)).tocsr()
