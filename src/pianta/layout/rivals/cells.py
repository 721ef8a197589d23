"""Cells between critical lines, and the rules that merge them into rooms (the survey of Bormann et al., ICRA 2016)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from math import inf

import numpy as np

from pianta.layout.rivals.patches import Labels

# What is not free, and what is beyond the edge of the map.
WALL = 0


@dataclass(frozen=True, kw_only=True)
class MergeRule:
    """When a cell is merged into a neighbour; of several neighbours the one with the longest common border is taken.

    area: the cell is no larger than this, m².
    neighbours: it has at most so many.
    wall: at most this share of its perimeter is wall.
    shared: more than this share of its perimeter is common border.
    shared_back: and more than this share of the neighbour's perimeter.
    """

    area: float = inf
    neighbours: float = inf
    wall: float = 1.0
    shared: float = 0.0
    shared_back: float = 0.0


@dataclass(frozen=True, eq=False)
class Cells:
    """How large cells are, and how much border they share; both change as cells are merged.

    area: m² of each cell, 0 for a cell that was merged into another.
    border: for each cell its neighbours, WALL among them, and the number of cell sides shared with each.
    """

    area: list[float]
    border: list[dict[int, float]]

    def merge(self, cell: int, into: int) -> None:
        """Make one cell of two."""
        self.area[into] += self.area[cell]
        self.area[cell] = 0.0
        for neighbour, sides in self.border[cell].items():
            del self.border[neighbour][cell]
            if neighbour != into:
                self.border[into][neighbour] = self.border[into].get(neighbour, 0) + sides
                self.border[neighbour][into] = self.border[neighbour].get(into, 0) + sides
        self.border[cell].clear()

    def find_partner(self, cell: int, rule: MergeRule) -> int | None:
        """The neighbour that a rule merges a cell into, if any."""
        border = self.border[cell]
        perimeter = sum(border.values())
        neighbours = sorted(border.keys() - {WALL})
        closed = border.get(WALL, 0) > rule.wall * perimeter
        if closed or self.area[cell] > rule.area or len(neighbours) > rule.neighbours:
            return None
        fitting = [
            other
            for other in neighbours
            if border[other] > rule.shared * perimeter
            and border[other] > rule.shared_back * sum(self.border[other].values())
        ]
        return max(fitting, key=lambda other: border[other], default=None)


def measure_cells(labels: Labels, resolution: float) -> Cells:
    """Areas and common borders of the cells of a label image, shape (H, W)."""
    count = int(labels.max()) + 1
    around = np.pad(labels, 1).astype(np.int64)
    steps = ((around[:-1], around[1:]), (around[:, :-1], around[:, 1:]))
    pairs = np.concatenate([(here * count + there)[here != there] for here, there in steps])
    border: list[dict[int, float]] = [{} for _ in range(count)]
    for pair, sides in zip(*(part.tolist() for part in np.unique(pairs, return_counts=True)), strict=True):
        for cell, other in (divmod(pair, count), divmod(pair, count)[::-1]):
            border[cell][other] = border[cell].get(other, 0) + sides
    area = np.bincount(labels.ravel(), minlength=count) * resolution**2
    return Cells(area.tolist(), border)


def merge_cells(labels: Labels, resolution: float, rules: Iterable[MergeRule]) -> Labels:
    """Rooms, shape (H, W), 1 … N: cells that a rule merges get one label; the rules are applied one after the other."""
    cells = measure_cells(labels, resolution)
    into = np.arange(len(cells.area))
    for rule in rules:
        for cell, other in _apply_rule(cells, rule):
            into[into == cell] = other
    rooms = np.unique(into)
    return np.searchsorted(rooms, into).astype(np.int32)[labels]


def _apply_rule(cells: Cells, rule: MergeRule) -> list[tuple[int, int]]:
    """Merge the smallest cell that the rule fits, again and again; the pairs, in order."""
    merged = []
    queue = [(area, cell) for cell, area in enumerate(cells.area) if area > 0 and cell != WALL]
    heapify(queue)
    while queue:
        area, cell = heappop(queue)
        # A cell that has changed since is in the queue again.
        partner = cells.find_partner(cell, rule) if area == cells.area[cell] else None
        if partner is None:
            continue
        cells.merge(cell, partner)
        merged.append((cell, partner))
        for changed in (partner, *cells.border[partner].keys() - {WALL}):
            heappush(queue, (cells.area[changed], changed))
    return merged
