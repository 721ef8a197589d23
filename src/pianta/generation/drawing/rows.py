"""Rows of blocks along the sides of a corridor, which may go beyond its ends."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from pianta.generation.drawing.blocks import DOOR_CELLS, Block

BY_SIZE = 0.5  # share of corridors whose large rooms are on one side, so that each side has a depth of its own


@dataclass(frozen=True)
class Row:
    """Blocks along a side of a corridor, in cells.

    blocks: with their positions. length: of all. before, after: by how much the row may begin before the corridor, and
    end after it, so that each room still has a wall for its door. depth: of its usual rooms.
    """

    blocks: Sequence[tuple[Block, int]]
    length: int
    before: int
    after: int
    depth: int

    def choose_start(self, length: int, *, before: bool, after: bool, rng: np.random.Generator) -> int:
        """Where the row begins along a corridor of a length: as early or as late as possible, or in the middle.

        before, after: whether there is space beyond the ends of the corridor.
        """
        first, last = -before * self.before, length + after * self.after - self.length
        middle = min(max((length - self.length) // 2, first), last)
        return (first, middle, last)[int(rng.integers(3))]


def make_row(blocks: Sequence[tuple[Block, int]], length: int, rooms: Collection[int], depth: int) -> Row:
    """A row of blocks with their positions. rooms: those with a door to the corridor."""
    fronts: dict[int, tuple[int, int]] = {}
    for block, start in blocks:
        for room, x0, y0, x1, _ in block.rectangles:
            if y0 == 0 and room in rooms:
                first, last = fronts.get(room, (length, 0))
                fronts[room] = min(first, start + x0), max(last, start + x1)
    before = min((last - DOOR_CELLS for _, last in fronts.values()), default=0)
    after = min((length - first - DOOR_CELLS for first, _ in fronts.values()), default=0)
    return Row(blocks, length, max(0, before), max(0, after), depth)


def divide_paths(
    paths: Sequence[Sequence[int]],
    measure: Callable[[int], float],
    measure_area: Callable[[int], float],
    rng: np.random.Generator,
) -> tuple[list[Sequence[int]], list[Sequence[int]]]:
    """Paths of rooms on two sides of about the same length; in half of the cases the larger rooms are on one side.

    measure: the wall that a room takes.
    """
    sides: tuple[list[Sequence[int]], list[Sequence[int]]] = ([], [])
    lengths = [sum(map(measure, path)) for path in paths]
    order = rng.permutation(len(paths)).tolist()
    if rng.random() < BY_SIZE:
        placed = 0.0
        for index in sorted(order, key=lambda index: -max(map(measure_area, paths[index]))):
            sides[int(placed + lengths[index] / 2 > sum(lengths) / 2)].append(paths[index])
            placed += lengths[index]
        return sides
    on_sides = [0.0, 0.0]
    for index in sorted(order, key=lambda index: -lengths[index]):
        shorter = int(on_sides[1] < on_sides[0])
        sides[shorter].append(paths[index])
        on_sides[shorter] += lengths[index]
    return sides
