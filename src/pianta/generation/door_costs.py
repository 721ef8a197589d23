"""Costs of what real floors seldom have: dead ends, rooms with many doors, and rooms as ways between corridors."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from math import log

import networkx as nx

from pianta.generation.type_model import TypeModel
from pianta.graphs.metrics import find_corridors


@dataclass(frozen=True)
class DoorCosts:
    """Costs of a building that are added to α Γ4; none by default.

    All are log odds on the floors of the model, with half a case of each kind as prior, where they are positive.

    dead_ends: of a room with one door, by its label. most_doors: by label, the most doors of such a room of the model,
    and the cost of each door more. parted: of each group of corridors but one, as only rooms join them. corridors: the
    labels of corridors.
    """

    dead_ends: Mapping[str, float] = field(default_factory=dict)
    most_doors: Mapping[str, tuple[int, float]] = field(default_factory=dict)
    parted: float = 0.0
    corridors: frozenset[str] = frozenset()

    def measure(self, labels: Sequence[str], neighbors: Sequence[Collection[int]]) -> float:
        """The costs of a building. labels: of its rooms. neighbors: the rooms behind the doors of each."""
        cost = 0.0
        for label, near in zip(labels, neighbors, strict=True):
            if len(near) == 1:
                cost += self.dead_ends.get(label, 0.0)
            most, excess = self.most_doors.get(label, (len(near), 0.0))
            cost += excess * max(0, len(near) - most)
        if self.parted:
            cost += self.parted * max(0, self._count_corridor_groups(labels, neighbors) - 1)
        return cost

    def _count_corridor_groups(self, labels: Sequence[str], neighbors: Sequence[Collection[int]]) -> int:
        """The number of groups of corridors that are joined by doors between corridors.

        Counted at each move of a door, for which making a graph of networkx would take too long.
        """
        left = {room for room, label in enumerate(labels) if label in self.corridors}
        groups = 0
        while left:
            groups += 1
            reached = [left.pop()]
            while reached:
                new = left.intersection(neighbors[reached.pop()])
                left -= new
                reached += new
        return groups


def learn_door_costs(model: TypeModel) -> DoorCosts:
    """The costs by the floors of a model."""
    doors: dict[str, list[int]] = defaultdict(list)
    labels: set[str] = set()
    joined, parted = 0, 0
    for floor in model.floors:
        for node, label in floor.graph.nodes(data="label"):
            doors[label].append(floor.graph.degree(node))
        corridors = floor.graph.subgraph(find_corridors(floor.graph, model.schema))
        labels |= {label for _, label in corridors.nodes(data="label")}
        groups = nx.number_connected_components(corridors)
        parted += max(0, groups - 1)
        joined += len(corridors) - groups
    dead_ends = {label: _log_odds(sum(each > 1 for each in own), own.count(1)) for label, own in doors.items()}
    return DoorCosts(
        {label: cost for label, cost in dead_ends.items() if cost > 0},
        {label: (max(own), _log_odds(len(own), 0)) for label, own in doors.items()},
        max(0.0, _log_odds(joined, parted)),
        frozenset(labels),
    )


def _log_odds(cases: int, others: int) -> float:
    return log((cases + 1 / 2) / (others + 1 / 2))
