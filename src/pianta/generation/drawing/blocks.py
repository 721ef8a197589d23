"""Blocks of rooms on a grid of cells: a room, or a corridor with all rooms that are reached through it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import floor
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

Cells = NDArray[np.int32]

CELL = 0.5  # m, side of a cell
DOOR_CELLS = 3  # of wall that two rooms share: a door of 0.9 m and 0.3 m beside it
NARROWEST = 3  # cells, of a room
NO_ROOM = -1
MARGIN_CELLS = 10  # around a building, for arms; chosen by hand


class Rectangle(NamedTuple):
    """Part of a room, in cells."""

    room: int
    x0: int
    y0: int
    x1: int
    y1: int

    def moved(self, x: int, y: int) -> Rectangle:
        """The rectangle elsewhere."""
        return Rectangle(self.room, self.x0 + x, self.y0 + y, self.x1 + x, self.y1 + y)


@dataclass(frozen=True)
class Block:
    """Rooms that do not overlap, above the wall at y = 0 behind which the room is that leads to them.

    start, stop: where their first room, which has a door in that wall, touches it, in cells along x.
    """

    rectangles: tuple[Rectangle, ...]
    start: int
    stop: int

    @property
    def width(self) -> int:
        """Cells along x, from 0."""
        return max(each.x1 for each in self.rectangles)

    @property
    def height(self) -> int:
        """Cells along y, from 0."""
        return max(each.y1 for each in self.rectangles)

    @property
    def rooms(self) -> set[int]:
        """All its rooms."""
        return {each.room for each in self.rectangles}

    def moved(self, x: int, y: int) -> list[Rectangle]:
        """Its rectangles elsewhere."""
        return [each.moved(x, y) for each in self.rectangles]

    def mirrored(self) -> Block:
        """Left and right exchanged."""
        width = self.width
        rectangles = tuple(Rectangle(r.room, width - r.x1, r.y0, width - r.x0, r.y1) for r in self.rectangles)
        return Block(rectangles, width - self.stop, width - self.start)


def make_block(rectangles: Iterable[Rectangle], start: int, stop: int) -> Block:
    """A block of rectangles of which some lie left of x = 0; y = 0 stays where it is."""
    all_ = [*rectangles]
    left = min(each.x0 for each in all_)
    return Block(tuple(each.moved(-left, 0) for each in all_), start - left, stop - left)


def round_randomly(value: float, rng: np.random.Generator) -> int:
    """The integer above or below, such that the value is the mean."""
    return floor(value + rng.random())


def paint_cells(block: Block, margin: int) -> Cells:
    """The room of each cell, NO_ROOM outside; margin: cells around the block."""
    low = min(each.y0 for each in block.rectangles)
    cells = np.full((block.height - low + 2 * margin, block.width + 2 * margin), NO_ROOM, np.int32)
    for room, x0, y0, x1, y1 in (each.moved(margin, margin - low) for each in block.rectangles):
        cells[y0:y1, x0:x1] = room
    return cells


class Contact(NamedTuple):
    """A straight wall that two rooms share: its length in cells, and its first cell.

    is_level: whether it runs along a row, below that row; otherwise along a column, after that column.
    """

    length: int
    row: int
    column: int
    is_level: bool


def measure_contacts(cells: Cells) -> dict[tuple[int, int], int]:
    """The cells of the longest straight wall that two rooms share, by the rooms, the smaller number first."""
    return {rooms: contact.length for rooms, contact in find_contacts(cells).items()}


def measure_contact(cells: Cells, one: int, other: int) -> int:
    """The cells of the longest straight wall that two rooms share, 0 for none."""
    x, y, width, height = cv2.boundingRect((cells == one).view(np.uint8))
    around = cells[max(0, y - 1) : y + height + 1, max(0, x - 1) : x + width + 1]
    return measure_contacts(around).get((min(one, other), max(one, other)), 0)


def find_contacts(cells: Cells) -> dict[tuple[int, int], Contact]:
    """The longest straight wall that two rooms share, by the rooms, the smaller number first."""
    size = int(cells.max()) + 1
    (walls, lengths, starts), others = (_find_walls(lines, size) for lines in (cells, np.ascontiguousarray(cells.T)))
    count = len(walls)
    walls, lengths, starts = (np.append(*both) for both in zip((walls, lengths, starts), others, strict=True))
    # The longest of each pair of rooms, of equal ones the first
    order = np.lexsort((-lengths, walls))
    longest = order[np.flatnonzero(np.diff(walls[order], prepend=NO_ROOM))]
    contacts = {}
    for index in longest.tolist():
        is_level = index < count
        row, column = divmod(int(starts[index]), (cells if is_level else cells.T).shape[1])
        first = (row, column) if is_level else (column, row)
        contacts[divmod(int(walls[index]), size)] = Contact(int(lengths[index]), *first, is_level)
    return contacts


def _find_walls(lines: Cells, size: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """The straight walls between rows: their rooms as one number, their lengths, and their first cells.

    size: above all numbers of rooms. Cells are numbered as by `find_runs`.
    """
    low, high = np.minimum(lines[:-1], lines[1:]), np.maximum(lines[:-1], lines[1:])
    pairs = np.where((low >= 0) & (low != high), low.astype(np.int64) * size + high, NO_ROOM)
    starts, lengths = find_runs(pairs)
    walls = pairs.ravel()[starts]
    is_wall = walls >= 0
    return walls[is_wall], lengths[is_wall], starts[is_wall]


def find_runs(lines: NDArray[np.integer]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first cells and the lengths of the runs of equal values in rows, shape (H, W).

    A cell has the number that it has when the rows are one after the other.
    """
    is_first = np.ones(lines.shape, bool)
    is_first[:, 1:] = lines[:, 1:] != lines[:, :-1]
    starts = np.flatnonzero(is_first)
    return starts, np.diff(np.append(starts, lines.size))
