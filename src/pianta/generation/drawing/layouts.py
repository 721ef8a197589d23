"""Layouts of a graph without arms: many at random, the best ones improved by local search."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from pianta.generation.drawing.blocks import MARGIN_CELLS, Block, paint_cells
from pianta.generation.drawing.choices import Edge, sample_choices
from pianta.generation.drawing.losses import find_missing_doors, measure_form, measure_gaps, measure_outside
from pianta.generation.drawing.programme import Programme
from pianta.generation.drawing.strips import TreeLayout

# All chosen by hand, on generated schools.
TREES = 36  # layouts at random
IMPROVED = 2  # of them, the best ones, that are improved
CHANGES = 240  # that each of these tries


@dataclass(frozen=True, eq=False)
class Layout:
    """A spanning tree of a graph as blocks.

    tree: that is drawn. block: of all rooms. loss: the less, the better. missing: edges of the graph without a wall for
    their door.
    """

    tree: TreeLayout
    block: Block
    loss: float
    missing: tuple[Edge, ...]


def find_layouts(programme: Programme, rng: np.random.Generator) -> list[Layout]:
    """Layouts of a building, the best first."""
    search = _LayoutSearch(programme, rng)
    layouts = sorted((search.sample(number) for number in range(TREES)), key=lambda layout: layout.loss)
    improved = [search.improve(layout) for layout in layouts[:IMPROVED]]
    return sorted([*improved, *layouts], key=lambda layout: layout.loss)


@dataclass(eq=False)
class _LayoutSearch:
    programme: Programme
    rng: np.random.Generator
    roots: list[int] = field(init=False)
    weights: NDArray[np.float64] = field(init=False)
    swapped: list[Edge] = field(init=False)

    def __post_init__(self) -> None:
        graph = self.programme.graph
        self.roots = [node for node in graph if node in self.programme.corridors] or [*graph]
        # Central rooms with many doors are good beginnings
        closeness = nx.closeness_centrality(graph)
        weights = np.array([closeness[node] ** 4 * (1 + graph.degree[node]) for node in self.roots])
        self.weights = weights / weights.sum()
        bridges = {frozenset(edge) for edge in nx.bridges(graph)}
        self.swapped = [edge for edge in graph.edges if frozenset(edge) not in bridges]

    def sample(self, number: int) -> Layout:
        """A layout at random; each third one with alleys."""
        programme = self.programme
        root = int(self.rng.choice(self.roots, p=self.weights))
        choices = sample_choices(programme.graph, root, alleys=number % 3 == 1, rng=self.rng)
        return self._draw(TreeLayout(programme.graph, programme.areas, programme.corridors, choices, programme.aspects))

    def improve(self, layout: Layout) -> Layout:
        """A layout after changes of which each made it better."""
        graph = self.programme.graph
        rooms = [node for node in graph if graph.degree[node] > 1] or [*graph]
        for _ in range(CHANGES):
            choices = layout.tree.choices.change(self.roots, self.swapped, rooms, self.rng)
            changed = self._draw(layout.tree.change(choices), below=layout.loss)
            if changed.loss < layout.loss:
                layout = changed
        return layout

    def _draw(self, tree: TreeLayout, *, below: float = inf) -> Layout:
        """The layout of a tree. below: once a part of its loss is not, the rest is not measured."""
        programme, block = self.programme, tree.draw()
        cells = paint_cells(block, MARGIN_CELLS)
        missing = find_missing_doors(cells, programme.graph)
        loss = measure_form(cells, programme)
        if programme.site is not None:
            loss += measure_outside(cells, programme.site)
        loss += measure_gaps(cells, missing, programme.corridors, below=below - loss)
        return Layout(tree, block, loss, missing)
