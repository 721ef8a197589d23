"""A graph to which ways are added one by one, and that knows the cost of the cheapest way between all its nodes."""

from __future__ import annotations

from math import inf

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.navigation.positions import Cell


class Spanner:
    """The ways that the greedy spanner (Althöfer et al., 1993) has kept so far.

    graph: its edges have a `cost`. The costs between all nodes are kept up to date, which takes one step for an edge
    and saves a search for each pair of nodes that is asked for.
    """

    def __init__(self) -> None:
        """Without nodes."""
        self.graph: nx.Graph = nx.Graph()
        self._numbers: dict[Cell, int] = {}
        self._costs: Floats = np.zeros((0, 0))

    def measure_cost(self, start: Cell, end: Cell) -> float:
        """The cost of the cheapest way between two cells; inf if none joins them."""
        if start not in self._numbers or end not in self._numbers:
            return inf
        return float(self._costs[self._numbers[start], self._numbers[end]])

    def add(self, start: Cell, end: Cell, cost: float, room: int) -> None:
        """Add a way in a room."""
        self.graph.add_edge(start, end, cost=cost, room=room)
        one, other = self._number(start), self._number(end)
        through = np.add.outer(self._costs[one] + cost, self._costs[other])
        np.minimum(self._costs, through, out=self._costs)
        np.minimum(self._costs, through.T, out=self._costs)

    def _number(self, cell: Cell) -> int:
        if cell not in self._numbers:
            self._numbers[cell] = len(self._numbers)
            self._costs = np.pad(self._costs, (0, 1), constant_values=inf)
            self._costs[-1, -1] = 0.0
        return self._numbers[cell]
