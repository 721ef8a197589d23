"""Shortest ways between cells of a room that keep clear of obstacles, over a lattice of the open cells."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING

import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.navigation.free_space import FreeSpace

if TYPE_CHECKING:
    from scipy.sparse import csr_array

# Metres between the points of the lattice, where cells are smaller: it is found four times as fast as on cells of 5 cm.
# Chosen by hand.
STEP = 0.1
# Down, right: each pair of neighbours of the lattice once, by the number of the second one.
STEPS = ((0, 1), (1, -1), (1, 0), (1, 1))
TOLERANCE = 0.01  # share of a cost; those of steps are measured at their ends alone


@dataclass(frozen=True, eq=False)
class Lattice:
    """The points of a lattice in a part of the open cells, and the costs of steps between them.

    points: row, col, shape (N, 2). costs: of the steps, shape (N, N), sparse, in both directions; a metre far from
    obstacles costs 1. numbers: of the point at each cell, shape (H, W), -1 elsewhere; its cell [0, 0] is at `corner`.
    stride: cells between neighbouring points.
    """

    space: FreeSpace
    points: Indices
    costs: csr_array
    numbers: Indices
    corner: tuple[int, int]
    stride: int

    def find_cell(self, number: int) -> tuple[int, int]:
        """The row and col of a point."""
        row, col = self.points[number].tolist()
        return row, col

    def find_point(self, cell: tuple[int, int]) -> int:
        """The number of the point at a cell, -1 without one."""
        row, col = cell[0] - self.corner[0], cell[1] - self.corner[1]
        height, width = self.numbers.shape
        return int(self.numbers[row, col]) if 0 <= row < height and 0 <= col < width else -1


def find_stride(resolution: float) -> int:
    """Cells between neighbouring points of the lattice; resolution: metres per cell."""
    return max(round(STEP / resolution), 1)


def build_lattice(space: FreeSpace, part: Mask, corner: tuple[int, int], stride: int) -> Lattice:
    """The lattice of every stride-th cell of a part of the map; part: shape (h, w), the cells from `corner` on."""
    from scipy.sparse import csr_array

    # The same cells are points in every part of a map.
    first = tuple(-offset % stride for offset in corner)
    is_point = np.zeros_like(part)
    is_point[first[0] :: stride, first[1] :: stride] = part[first[0] :: stride, first[1] :: stride]
    points = np.argwhere(is_point)
    numbers = np.full(part.shape, -1, np.intp)
    numbers[is_point] = np.arange(len(points))
    weights = space.costs[tuple((points + corner).T)]
    # A frame of closed cells, so that all ends of steps are cells
    framed = np.pad(part, stride)
    # A point's neighbours by their numbers: the four before it, and the four after it
    neighbours, costs = np.full((len(points), 8), -1), np.zeros((len(points), 8))
    for column, (down, right) in enumerate(STEPS, start=4):
        starts = np.flatnonzero(_is_open_between(framed, points + stride, down, right, stride))
        others = numbers[tuple((points[starts] + np.array([down * stride, right * stride])).T)]
        length = stride * np.hypot(down, right) * space.grid.resolution
        neighbours[starts, column], neighbours[others, 7 - column] = others, starts
        costs[starts, column] = costs[others, 7 - column] = length * (weights[starts] + weights[others]) / 2
    is_step = neighbours >= 0
    row_ends = np.concatenate([[0], np.cumsum(is_step.sum(axis=1))])
    matrix = csr_array((costs[is_step], neighbours[is_step], row_ends), shape=(len(points), len(points)))
    return Lattice(space, points + corner, matrix, numbers, corner, stride)


def trace_back(previous: Indices, end: int) -> list[int]:
    """The points of a way to its end; previous: the one before each on the way from the start, -9999 before that."""
    numbers = [end]
    while (before := int(previous[numbers[-1]])) >= 0:
        numbers.append(before)
    return numbers[::-1]


def straighten_way(space: FreeSpace, way: Indices, reached: Floats | None = None) -> Indices:
    """The corners of a way over cells, shape (N, 2): straight lines replace pieces of it.

    way: row, col, shape (M, 2); the straight lines between its cells are open. reached: the cost of the way up to each
    of its cells, shape (M,), if straight lines may cost no more.
    """
    corners, here = [0], 0
    while here < len(way) - 1:
        # Double the stride while straight lines are as good, then halve it.
        stride, ahead = 1, here + 1
        while stride:
            further = min(ahead + stride, len(way) - 1)
            saved = inf if reached is None else (reached[further] - reached[here]) * (1 + TOLERANCE)
            if further > ahead and _is_as_good(space, way[here], way[further], saved):
                ahead, stride = further, stride * 2
            else:
                stride //= 2
        here = ahead
        corners.append(here)
    return way[corners]


def _is_as_good(space: FreeSpace, start: Indices, end: Indices, cost: float) -> bool:
    return space.is_straight(start, end) and (cost == inf or space.measure_cost(start, end) <= cost)


def _is_open_between(framed: Mask, points: Indices, down: int, right: int, stride: int) -> Mask:
    """Whether the cells of a step from each point are open; a diagonal step needs the cells on both of its sides.

    framed: open cells, with a frame as wide as the stride. points: row and col there, shape (N, 2).
    """
    width = framed.shape[1]
    cells, flat = framed.ravel(), points[:, 0] * width + points[:, 1]
    is_open = np.ones(len(points), bool)
    for done in range(stride + 1):
        straight = [(done * down, done * right)]
        beside = [((done + 1) * down, done * right), (done * down, (done + 1) * right)] if down and right else []
        for row, col in straight + (beside if done < stride else []):
            is_open &= cells.take(flat + (row * width + col))
    return is_open
