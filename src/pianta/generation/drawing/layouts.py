"""Layouts of a graph without arms: many at random, the best ones improved by local search."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.generation.drawing.blocks import CELL, Block, paint_cells
from pianta.generation.drawing.choices import Choices, Edge, sample_choices
from pianta.generation.drawing.losses import find_missing_doors, measure_form, measure_gaps
from pianta.generation.drawing.strips import TreeLayout

# All chosen by hand, on generated schools.
TREES = 36  # layouts at random
IMPROVED = 2  # of them, the best ones, that are improved
MARGIN_CELLS = 10  # around a layout, for arms
CHANGES = 180  # that each of these tries


@dataclass(frozen=True, eq=False)
class Layout:
    """A spanning tree of a graph as blocks.

    block: of all rooms. loss: the less, the better. missing: edges of the graph without a wall for their door.
    """

    choices: Choices
    block: Block
    loss: float
    missing: tuple[Edge, ...]


def find_layouts(
    graph: nx.Graph, corridors: frozenset[Any], areas: dict[int, float], rng: np.random.Generator
) -> list[Layout]:
    """Layouts of a graph, the best first. areas: of each room, m²."""
    search = _LayoutSearch(graph, corridors, {node: area / CELL**2 for node, area in areas.items()}, rng)
    layouts = sorted((search.sample(number) for number in range(TREES)), key=lambda layout: layout.loss)
    improved = [search.improve(layout) for layout in layouts[:IMPROVED]]
    return sorted([*improved, *layouts], key=lambda layout: layout.loss)


@dataclass(eq=False)
class _LayoutSearch:
    """areas: of each room, in cells."""

    graph: nx.Graph
    corridors: frozenset[Any]
    areas: dict[int, float]
    rng: np.random.Generator
    roots: list[int] = field(init=False)
    weights: NDArray[np.float64] = field(init=False)
    swapped: list[Edge] = field(init=False)

    def __post_init__(self) -> None:
        self.roots = [node for node in self.graph if node in self.corridors] or [*self.graph]
        # Central rooms with many doors are good beginnings
        closeness = nx.closeness_centrality(self.graph)
        weights = np.array([closeness[node] ** 4 * (1 + self.graph.degree[node]) for node in self.roots])
        self.weights = weights / weights.sum()
        bridges = {frozenset(edge) for edge in nx.bridges(self.graph)}
        self.swapped = [edge for edge in self.graph.edges if frozenset(edge) not in bridges]

    def sample(self, number: int) -> Layout:
        """A layout at random; each third one with alleys."""
        root = int(self.rng.choice(self.roots, p=self.weights))
        return self._draw(sample_choices(self.graph, root, alleys=number % 3 == 1, rng=self.rng))

    def improve(self, layout: Layout) -> Layout:
        """A layout after changes of which each made it better."""
        rooms = [node for node in self.graph if self.graph.degree[node] > 1] or [*self.graph]
        for _ in range(CHANGES):
            changed = self._draw(layout.choices.change(self.roots, self.swapped, rooms, self.rng))
            if changed.loss < layout.loss:
                layout = changed
        return layout

    def _draw(self, choices: Choices) -> Layout:
        block = TreeLayout(self.graph, self.areas, self.corridors, choices).draw()
        cells = paint_cells(block, MARGIN_CELLS)
        missing = find_missing_doors(cells, self.graph)
        loss = measure_form(block, cells, self.corridors) + measure_gaps(cells, missing, self.corridors)
        return Layout(choices, block, loss, missing)
