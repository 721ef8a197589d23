"""Arms of rooms through free space or along walls, for doors between rooms that do not touch."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from math import inf

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from pianta.generation.drawing.blocks import NARROWEST, NO_ROOM, Cells

Mask = NDArray[np.bool_]

TURN = 10.0  # cells that a turn costs: arms are straight where they can be
LIMITS = (20.0, 60.0, inf)  # cells of a way, with turns, up to which it is searched for, one after the other
THEFT = 2.0  # cells that a cell of another room costs besides; chosen by hand


def find_widest_arm(cells: Cells, room: int, goal: int, widest: int, *, through: Collection[int] = ()) -> Mask | None:
    """The cells of an arm by which a room touches another one, as wide as there is space; None without a way.

    widest: cells of its width, at most. Where the width of a corridor changes, it looks like two rooms. through: rooms
    at whose walls the arm may take cells, from no other room.
    """
    if not _find_ways(cells, room, goal, NARROWEST, through)[0].any():
        return None
    arms = (find_arm(cells, room, goal, width, through=through) for width in range(widest, NARROWEST - 1, -1))
    return next(arm for arm in arms if arm is not None)


def find_arm(cells: Cells, room: int, goal: int, width: int, *, through: Collection[int] = ()) -> Mask | None:
    """The cells of an arm of a width by which a room touches another one; None without a way.

    It is the shortest one, where a turn and what is taken from rooms count as longer ways. through: as of
    `find_widest_arm`.
    """
    free, starts, ends = _find_ways(cells, room, goal, width, through)
    if not free.any():
        return None
    theft = _measure_theft(cells, width)
    least = _measure_steps(starts[0] | starts[1]) + _measure_steps(ends[0] | ends[1])
    # Most arms are short; of a short one all squares are near both rooms, which spares most of the building
    for limit in LIMITS:
        if squares := _find_way(free & (least <= limit), starts, ends, theft, limit=limit):
            arm = np.zeros(cells.shape, bool)
            for row, column in squares:
                arm[row : row + width, column : column + width] = True
            return arm
    return None


def _find_way(
    free: Mask, starts: Sequence[Mask], ends: Sequence[Mask], theft: NDArray[np.float64], *, limit: float
) -> list[tuple[int, int]]:
    """The squares of the shortest way that is not longer than a limit, by their first corners; empty without one.

    free: the squares. starts, ends: of ways along x and along y. theft: what each square costs besides.
    """
    count = int(free.sum())
    numbers = np.full(free.shape, -1)
    numbers[free] = np.arange(count)
    # States: a free square, the first `count` of arms along x, the others along y; arms leave walls at right angles
    first, last = (
        np.concatenate([numbers[sides[0] & free], numbers[sides[1] & free] + count]) for sides in (starts, ends)
    )
    if not (first.size and last.size):
        return []
    distances, before, _ = dijkstra(
        _join_squares(numbers, count, theft),
        directed=False,
        indices=first,
        return_predecessors=True,
        min_only=True,
        limit=limit,
    )
    state = int(last[np.argmin(distances[last])])
    squares, corners = [], np.argwhere(free)
    while state >= 0 and np.isfinite(distances[state]):
        row, column = corners[state % count]
        squares.append((int(row), int(column)))
        state = int(before[state])
    return squares


def _measure_steps(mask: Mask) -> NDArray[np.float32]:
    """How many cells each cell is away from a mask, along rows and columns."""
    return np.asarray(cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L1, 3), np.float32)


def _find_ways(
    cells: Cells, room: int, goal: int, width: int, through: Collection[int]
) -> tuple[Mask, list[Mask], list[Mask]]:
    """The connected parts of the free squares that join two rooms, their starts and their ends, each of two masks."""
    is_open = cells == NO_ROOM
    if through:
        is_open |= np.isin(cells, [*through]) & _find_rims(cells, width)
    free = _erode(is_open, width, width)
    starts, ends = ([*_find_sides(cells == each, free, width)] for each in (room, goal))
    count, parts = cv2.connectedComponents(free.astype(np.uint8), connectivity=4)
    is_way = np.zeros(count, bool)
    is_way[np.intersect1d(*(parts[np.logical_or(*sides)] for sides in (starts, ends)))] = True
    ways = is_way[parts]
    return ways, [side & ways for side in starts], [side & ways for side in ends]


def _find_rims(cells: Cells, width: int) -> Mask:
    """The cells of rooms that are less than a width from their walls."""
    kernel = np.ones((2 * width + 1, 2 * width + 1), np.uint8)
    values = cells.astype(np.float32)
    return np.asarray(cv2.erode(values, kernel) != cv2.dilate(values, kernel))


def _measure_theft(cells: Cells, width: int) -> NDArray[np.float64]:
    """What each square of a width costs, by its first corner, for the share of its cells that lie in rooms."""
    share = cv2.blur(
        (cells != NO_ROOM).astype(np.float64), (width, width), anchor=(0, 0), borderType=cv2.BORDER_CONSTANT
    )
    return THEFT * np.asarray(share)


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


def _join_squares(numbers: NDArray[np.int64], count: int, theft: NDArray[np.float64]) -> coo_array:
    """The graph of the states: squares side by side, and turns. theft: what each square costs besides."""

    def list_edges() -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]]:
        for first, second, costs, offset in (
            (numbers[:, :-1], numbers[:, 1:], theft[:, :-1] + theft[:, 1:], 0),
            (numbers[:-1], numbers[1:], theft[:-1] + theft[1:], count),
        ):
            both = (first >= 0) & (second >= 0)
            yield first[both] + offset, second[both] + offset, 1.0 + costs[both] / 2
        yield np.arange(count), np.arange(count) + count, np.full(count, TURN)

    rows, columns, weights = map(np.concatenate, zip(*list_edges(), strict=True))
    return coo_array((weights, (rows, columns)), shape=(2 * count, 2 * count)).tocsr()
