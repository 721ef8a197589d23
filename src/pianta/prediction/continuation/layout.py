"""The unknown rooms of a sample as cells of a grid, in free space behind the open ends of the explored part."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices, Mask
from pianta.generation.drawing.blocks import DOOR_CELLS, NARROWEST, NO_ROOM, Cells

BLOCKED = -2  # a cell where no room may be placed
RESERVED = -3  # a cell before a door, for the room behind it

# All chosen by hand, on the schools of the data.
# Widths over depths of rooms that are tried, and by how much a room may shrink where there is little space.
SHAPES = (0.6, 1.0, 1.6)
SHRINKINGS = (1.0, 0.7, 0.45, 0.25)
LONGEST = 60  # cells, side of a room that is no corridor
CORRIDOR_WIDTHS = (4, 5, 7)  # cells
CORRIDOR_SHARES = (1.0, 0.75, 0.5, 0.3, 0.15)  # of the length that a corridor should have
SHORTEST_CORRIDOR = 6  # cells
LEAST_REST = 18.0  # cells, that are added to a room of which a part is seen, if it leads to unknown rooms
BAND = 12  # cells beside a corridor, where its rooms are to be
# What a place is worth: the share of its outline at other rooms, of free bands beside it, and chance.
SNUG_WEIGHT = 1.0
BAND_WEIGHT = 1.0
NOISE = 0.35

INNER = slice(1, -1)


def fill_space(filler: SpaceFiller, partial: Mapping[int, float], parents: Mapping[int, int | None]) -> None:
    """Place all rooms for which there is space, one after the other, each at the room that leads to it.

    partial: areas, in cells, of open corridors and rooms of which a part is seen. parents: of the other rooms; None for
    one behind a known door.
    """
    children: dict[int, list[int]] = {}
    for node, parent in parents.items():
        if parent is not None:
            children.setdefault(parent, []).append(node)
    # Open corridors and rooms that are seen in part go on
    order = filler.rng.permutation(len(partial)).tolist()
    for node in sorted(([*partial][index] for index in order), key=lambda node: node not in filler.corridors):
        inside = children.get(node, [])
        rest = max(filler.areas.get(node, 0.0) - partial[node], LEAST_REST if inside else 0.0)
        if rest >= NARROWEST**2:
            filler.extend_room(node, rest, inside)
    ready = [node for node, parent in parents.items() if parent is None]
    ready += [child for node in partial for child in children.get(node, [])]
    while ready:
        # Corridors first, then large rooms
        node = max(ready, key=lambda node: (node in filler.corridors, filler.areas[node], -node))
        ready.remove(node)
        if filler.add_room(node, parents[node], filler.areas[node], children.get(node, [])):
            ready += children.get(node, [])


@dataclass(frozen=True, eq=False)
class SpaceFiller:
    """Places rectangles of rooms in free cells.

    cells: a number of the node, NO_ROOM where there is space, BLOCKED or RESERVED elsewhere; changed. areas: in cells.
    corridors: nodes. thresholds: node behind an unopened door -> cells before the door.
    """

    cells: Cells
    areas: Mapping[int, float]
    corridors: frozenset[int]
    thresholds: Mapping[int, Mask]
    rng: np.random.Generator

    def add_room(self, node: int, parent: int | None, area: float, inside: Sequence[int]) -> bool:
        """Add a rectangle to a room: before its door, or beside the room that leads to it; False without space.

        inside: the rooms that it leads to.
        """
        if parent is None:
            self.cells[self.thresholds[node] & (self.cells == RESERVED)] = NO_ROOM
            return self._add_near(self.thresholds[node], node, area, inside, covers=True)
        # Without space at the room that leads to it, a room stands at any other, and its door is given up
        is_placed = self._add_near(self.cells == parent, node, area, inside)
        return is_placed or self._add_near(self.cells >= 0, node, area, inside)

    def extend_room(self, node: int, area: float, inside: Sequence[int]) -> bool:
        """Add a rectangle to a room of which a part is seen, which needs no wall for a door; False without space."""
        return self._add_near(self.cells == node, node, area, inside, contact=1)

    def _add_near(
        self,
        near: Mask,
        node: int,
        area: float,
        inside: Sequence[int],
        contact: int = DOOR_CELLS,
        *,
        covers: bool = False,
    ) -> bool:
        """Add a rectangle that touches cells that are near with as many cells of a side, or covers all of them."""
        if not near.any():
            return False
        is_strip = node in self.corridors
        for sizes in self._list_strips(area, inside) if is_strip else self._list_rooms(area):
            crop = _crop(near, max(map(max, sizes)) + BAND + 2)
            window = _Window(_Sums.from_mask(self.cells[crop] != NO_ROOM), _Sums.from_mask(near[crop]), contact, covers)
            rated = [(window.rate(*size, is_strip=is_strip, rng=self.rng), size) for size in sizes]
            values, (rows, columns) = max(rated, key=lambda each: each[0].max())
            row, column = divmod(int(values.argmax()), values.shape[1])
            if values[row, column] > -np.inf:
                # Places begin at the second cell of the window
                self.cells[crop][row + 1 : row + 1 + rows, column + 1 : column + 1 + columns] = node
                return True
        return False

    def _list_rooms(self, area: float) -> Iterator[list[tuple[int, int]]]:
        """Sizes that are tried together, the largest first."""
        for shrinking in SHRINKINGS:
            sizes = set()
            for shape in SHAPES:
                rows = int(np.clip(round(sqrt(area * shrinking * shape)), NARROWEST, LONGEST))
                columns = int(np.clip(round(area * shrinking / rows), NARROWEST, LONGEST))
                sizes |= {(rows, columns)}
            yield sorted(sizes)

    def _list_strips(self, area: float, inside: Sequence[int]) -> Iterator[list[tuple[int, int]]]:
        frontage = sum(sqrt(self.areas[child]) if child not in self.corridors else 3.0 for child in inside) / 2
        width = int(self.rng.choice(CORRIDOR_WIDTHS))
        length = max(frontage, area / width, SHORTEST_CORRIDOR)
        if area / length > width:
            width = int(np.clip(round(area / length), NARROWEST, 9))
        for share in CORRIDOR_SHARES:
            along = max(SHORTEST_CORRIDOR, round(length * share))
            yield [(along, width), (width, along)]


@dataclass(frozen=True, eq=False)
class _Sums:
    """Sums of a mask over rectangles, by an integral image; shape: of the mask."""

    integral: NDArray[np.int32]
    shape: tuple[int, int]

    @classmethod
    def from_mask(cls, mask: Mask) -> _Sums:
        integral = np.zeros((mask.shape[0] + 1, mask.shape[1] + 1), np.int32)
        mask.cumsum(axis=0, dtype=np.int32).cumsum(axis=1, out=integral[1:, 1:])
        return cls(integral, mask.shape)

    def box(self, rows: int, columns: int) -> NDArray[np.int32]:
        """Of the rectangles of a size, by their first corner."""
        sums = self.integral
        return sums[rows:, columns:] - sums[:-rows, columns:] - sums[rows:, :-columns] + sums[:-rows, :-columns]


@dataclass(frozen=True, eq=False)
class _Window:
    """A part of the cells in which a place is looked for.

    occupied: cells that are not free. near: those that a place must touch with as many cells of a side as `contact`, or
    cover.
    """

    occupied: _Sums
    near: _Sums
    contact: int
    covers: bool

    def rate(self, rows: int, columns: int, *, is_strip: bool, rng: np.random.Generator) -> Floats:
        """What each place for a rectangle is worth, by its first corner, from the second cell; -inf for none."""
        height, width = self.occupied.shape
        if rows + 2 > height or columns + 2 > width:
            return np.full((1, 1), -np.inf)
        free = self.occupied.box(rows, columns)[INNER, INNER] == 0
        allowed = free & (self._find_covering(rows, columns) if self.covers else self._find_touching(rows, columns))
        if not allowed.any():
            return np.full((1, 1), -np.inf)
        values = NOISE * rng.random(free.shape)
        if is_strip:
            values += BAND_WEIGHT * self._measure_bands(rows, columns)
        else:
            values += SNUG_WEIGHT * self.occupied.box(rows + 2, columns + 2) / (2 * (rows + columns))
        return np.where(allowed, values, -np.inf)

    def _find_covering(self, rows: int, columns: int) -> Mask:
        covered = self.near.box(rows, columns)[INNER, INNER]
        return np.asarray(covered == self.near.integral[-1, -1])

    def _find_touching(self, rows: int, columns: int) -> Mask:
        """Whether one of the four sides touches enough cells."""
        across, down = self.near.box(1, columns), self.near.box(rows, 1)
        sides = (
            across[: -rows - 1, INNER],
            across[rows + 1 :, INNER],
            down[INNER, : -columns - 1],
            down[INNER, columns + 1 :],
        )
        return np.asarray(np.maximum.reduce(sides) >= self.contact)

    def _measure_bands(self, rows: int, columns: int) -> Floats:
        """The free share of the bands along the long sides of each place; outside the window all is occupied."""
        height, width = self.occupied.shape
        first_row, first_column = np.ogrid[1 : height - rows, 1 : width - columns]
        if rows >= columns:
            bands = [(first_row, left, rows, BAND) for left in (first_column - BAND, first_column + columns)]
        else:
            bands = [(top, first_column, BAND, columns) for top in (first_row - BAND, first_row + rows)]
        return np.asarray(sum(self._measure_free(*band) for band in bands) / 2)

    def _measure_free(self, top: Indices, left: Indices, rows: int, columns: int) -> Floats:
        """The free share of rectangles that may reach beyond the window."""
        height, width = self.occupied.shape
        low_row, high_row = np.clip(top, 0, height), np.clip(top + rows, 0, height)
        low_column, high_column = np.clip(left, 0, width), np.clip(left + columns, 0, width)
        sums = self.occupied.integral
        occupied = sums[high_row, high_column] - sums[low_row, high_column] - sums[high_row, low_column]
        occupied = occupied + sums[low_row, low_column]
        return np.asarray(((high_row - low_row) * (high_column - low_column) - occupied) / (rows * columns))


def _crop(mask: Mask, margin: int) -> tuple[slice, slice]:
    """The window around the cells of a mask."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return (
        slice(max(0, rows[0] - margin), rows[-1] + margin + 1),
        slice(max(0, columns[0] - margin), columns[-1] + margin + 1),
    )
