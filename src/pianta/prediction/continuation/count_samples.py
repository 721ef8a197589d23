"""Counts over the samples of a prediction: where they have free space and walls."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.generation.drawing.blocks import CELL, Cells, Contact
from pianta.prediction.continuation.drawn_floor import PASSAGE
from pianta.prediction.continuation.free_probability import describe_cells, find_free_probability
from pianta.prediction.continuation.ground import PARTS, Ground, average_cells, cover, refine
from pianta.prediction.continuation.known_part import KnownPart
from pianta.prediction.continuation.shares import ShareGrid, Shares

HALF_WALL = 1  # fine cells of a wall on each side of its axis
WALL = 0.1  # m around known rooms that count as their walls
PASSAGE_PARTS = round(PASSAGE / CELL * PARTS)  # fine cells along a predicted door


@dataclass(eq=False)
class SampleCounts:
    """In how many samples each fine cell of a ground is free, and wall.

    known_free: fine cells of known rooms. known_walls: of their walls. samples: counted ones.
    """

    ground: Ground
    known_free: Mask
    known_walls: Mask
    free: NDArray[np.int32] = field(init=False)
    wall: NDArray[np.int32] = field(init=False)
    samples: int = 0

    def __post_init__(self) -> None:
        self.free, self.wall = np.zeros(self.known_free.shape, np.int32), np.zeros(self.known_free.shape, np.int32)

    @classmethod
    def make(cls, ground: Ground, known_part: KnownPart) -> SampleCounts:
        """Without samples."""
        fine = refine(ground.frame)
        doors = [door.line for door in known_part.floor.doors if door.joins_rooms]
        passages = [line.buffer(1.5 * WALL, cap_style="flat") for line in (*doors, *known_part.ends.values())]
        free = cover(known_part.outlines, fine) | cover(passages, fine)
        return cls(ground, free, cover([outline.buffer(WALL) for outline in known_part.closed], fine) & ~free)

    @property
    def known_cells(self) -> Mask:
        """Fine cells of the known part and its walls."""
        return self.known_free | self.known_walls

    def add(self, cells: Cells, contacts: Iterable[Contact]) -> None:
        """Count a sample; cells: with its rooms, none at their edge. contacts: walls with a door in the middle."""
        window = _find_window(cells >= 0)
        fine = np.repeat(np.repeat(cells[window], PARTS, axis=0), PARTS, axis=1)
        inside = fine >= 0
        border = np.zeros(fine.shape, bool)
        for one, other in ((np.s_[1:], np.s_[:-1]), (np.s_[:, 1:], np.s_[:, :-1])):
            differ = (fine[one] != fine[other]) & (inside[one] | inside[other])
            border[one] |= differ
            border[other] |= differ
        target = tuple(slice(each.start * PARTS, each.stop * PARTS) for each in window)
        for contact in contacts:
            border[_find_passage(contact, *window)] = False
        self.wall[target] += border
        self.free[target] += inside & ~border
        self.samples += 1

    def average(self) -> tuple[Floats, Floats]:
        """The share of samples in which the unknown part of each cell is free, and the share that is unknown."""
        unknown = ~self.known_cells
        share = average_cells(unknown)
        return average_cells(self.free * unknown) / np.maximum(share, 1 / PARTS**2) / self.samples, share

    def to_grid(self) -> ShareGrid:
        """The shares; those of the known part are 0 or 1."""
        free_share, unknown = self.average()
        features = describe_cells(free_share, unknown, self.ground.openings, cell=CELL)
        coarse = find_free_probability(features).astype(np.float32)
        probability = np.repeat(np.repeat(coarse, PARTS, axis=0), PARTS, axis=1)
        free: Shares = np.divide(self.free, self.samples, dtype=np.float32)
        wall: Shares = np.divide(self.wall, self.samples, dtype=np.float32)
        for values in (free, probability):
            values[self.known_free], values[self.known_walls] = 1, 0
        wall[self.known_free], wall[self.known_walls] = 0, 1
        outside: Shares = (1 - free - wall).clip(0, 1)
        fine = refine(self.ground.frame)
        return ShareGrid(free, wall, outside, probability, self.known_cells, fine.resolution, fine.origin)


def _find_window(inside: Mask) -> tuple[slice, slice]:
    """The rows and columns of rooms, and one more on each side."""
    ranges = [np.flatnonzero(inside.any(axis=axis)) for axis in (1, 0)]
    if not len(ranges[0]):
        return slice(0, 0), slice(0, 0)
    rows, columns = (slice(int(used[0]) - 1, int(used[-1]) + 2) for used in ranges)
    return rows, columns


def _find_passage(contact: Contact, rows: slice, columns: slice) -> tuple[slice, slice]:
    """The fine cells of the door in the middle of a wall, in a window."""
    row, column = contact.row - rows.start, contact.column - columns.start
    start, across = (column, row) if contact.is_level else (row, column)
    first = start * PARTS + (contact.length * PARTS - PASSAGE_PARTS) // 2
    along = slice(first, first + PASSAGE_PARTS)
    through = slice((across + 1) * PARTS - HALF_WALL, (across + 1) * PARTS + HALF_WALL)
    return (through, along) if contact.is_level else (along, through)
