"""New functional areas for a building: the parts of its areas are exchanged, and parts are added and removed.

Step 3 of section 7.4.3 takes areas of real floors as they are. A set of buildings then consists of few areas, and each
building mixes areas of floors that have little in common. Here an area is a hub with branches (sub-areas): the branches
of a new area are drawn from those of all areas of its building.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.generation.constraints import Constraints
from pianta.generation.type_model import Counts, TypeModel, count_labels
from pianta.graphs.metrics import find_corridors
from pianta.labels import FCES, LabelSchema

# New areas of a building are drawn this often until they meet the constraints, else it keeps areas of real floors.
# Chosen by hand.
TRIES = 50
# P(a branch of an area is removed), and the expected number of branches added for each of its branches: the numbers of
# rooms of a building then vary by some 12 %. Chosen by hand on halves of the schools.
P_REMOVED = 0.35
# Branches that an area keeps. Of 1 and 2 that with which more drawn buildings are read as they are.
FEWEST_BRANCHES = 2
# Number of new buildings that meet the constraints, of which the one with labels farthest from any floor is made.
# Of 1, 2 and 4 the least with which the buildings of a model of all schools are nearly as far from its floors, by edits
# of the graph, as these are from each other.
CANDIDATES = 2


@dataclass(frozen=True)
class Branch:
    """Rooms that are connected without the hub of their area.

    labels: of rooms 0 … n - 1. doors: between them. hub_rooms: those with a door to the hub.
    """

    labels: tuple[str, ...]
    doors: tuple[tuple[int, int], ...]
    hub_rooms: tuple[int, ...]


@dataclass(frozen=True)
class AreaParts:
    """A functional area.

    hub: the label of its hub, the room with most doors. is_corridor: whether that is a CORRIDOR.
    """

    hub: str
    is_corridor: bool
    branches: tuple[Branch, ...]


def split_area(area: nx.Graph, schema: LabelSchema) -> AreaParts:
    """The parts of an area: a connected graph with a `label` at each node."""
    hub = max(area, key=area.degree)
    branches = []
    for part in nx.connected_components(area.subgraph(node for node in area if node != hub)):
        rooms = [node for node in area if node in part]
        numbers = {node: number for number, node in enumerate(rooms)}
        labels = tuple(area.nodes[node]["label"] for node in rooms)
        doors = tuple((numbers[one], numbers[other]) for one, other in area.edges if {one, other} <= part)
        branches.append(Branch(labels, doors, tuple(numbers[node] for node in rooms if area.has_edge(node, hub))))
    # Components come in the order of sets, which varies.
    branches.sort(key=lambda branch: (branch.labels, branch.doors, branch.hub_rooms))
    return AreaParts(area.nodes[hub]["label"], hub in find_corridors(area, schema), tuple(branches))


def build_area(parts: AreaParts) -> nx.Graph:
    """The area with these parts; node 0 is the hub."""
    area = nx.Graph()
    area.add_node(0, label=parts.hub)
    for branch in parts.branches:
        first = len(area)
        area.add_nodes_from((first + room, {"label": label}) for room, label in enumerate(branch.labels))
        area.add_edges_from((first + one, first + other) for one, other in branch.doors)
        area.add_edges_from((0, first + room) for room in branch.hub_rooms)
    return area


def recombine_areas(
    areas: Sequence[AreaParts],
    generator: np.random.Generator,
    *,
    others: Sequence[AreaParts] = (),
    most: Mapping[str, int] = MappingProxyType({}),
) -> list[AreaParts]:
    """New areas with the hubs of given ones.

    Each branch of an area is replaced by a random one of all areas with the same kind of hub, removed with probability
    P_REMOVED, and as many are added on average; two stay at least, if there are two. Rooms of one building thus stay
    together: those of different floors have little in common, and a classifier separates buildings of a mixture of them
    from real ones.
    others: areas of the building that stay as they are, and whose branches are drawn as well. most: the most branches
    of an area, by the label of its hub, if known.
    """
    pools = {
        is_corridor: [
            branch for area in (*areas, *others) if area.is_corridor == is_corridor for branch in area.branches
        ]
        for is_corridor in (False, True)
    }
    new = []
    for area in areas:
        n_kept = int((generator.random(len(area.branches)) >= P_REMOVED).sum())
        # With fewer, its hub would be a dead end or lead to one room, as corridors seldom do.
        least = min(FEWEST_BRANCHES, len(area.branches))
        count = max(least, n_kept + int(generator.poisson(P_REMOVED * len(area.branches))))
        count = min(count, most.get(area.hub, count))
        pool = pools[area.is_corridor]
        branches = tuple(pool[index] for index in generator.integers(len(pool), size=count)) if pool else ()
        new.append(AreaParts(area.hub, area.is_corridor, branches))
    return new


@dataclass(frozen=True, eq=False)
class AreaRecombiner:
    """Makes new areas for buildings of a model.

    A new building has no more rooms of a label than any floor of the model, such as gyms, and shares of functions
    between those of its floors; or it exceeds these limits by no more than its chosen areas do.
    areas: those of the model, then n_fixed fixed ones, which stay as they are. limits: constraints on each building.
    mixes_floors: whether the areas of a building remain those of different floors.
    """

    model: TypeModel
    areas: Sequence[nx.Graph]
    n_fixed: int
    limits: Constraints
    mixes_floors: bool = False

    def renew(self, chosen: Sequence[int], shares: Floats, generator: np.random.Generator) -> list[nx.Graph]:
        """The new areas of a building, the most novel of some; the chosen ones if none meet the constraints as well.

        chosen: the fixed areas, then others, as indices of `areas`. shares: the probability that the building follows
        a floor of the model, shape (floors,).
        """
        real = [self.areas[area] for area in chosen]
        fixed, free = chosen[: self.n_fixed], chosen[self.n_fixed :]
        others = [self._parts[area] for area in fixed]
        allowed = self._measure_violations(real)
        candidates: list[tuple[float, list[nx.Graph]]] = []
        for _ in range(TRIES):
            own = free
            if not self.mixes_floors:
                own = self._use_floor(free, int(generator.choice(len(shares), p=shares)), generator)
            new = recombine_areas(
                [self._parts[area] for area in own], generator, others=others, most=self._most_branches
            )
            result = [*real[: self.n_fixed], *map(build_area, new)]
            if (self._measure_violations(result) <= allowed).all():
                candidates.append((self._measure_novelty(result), result))
                if len(candidates) == CANDIDATES:
                    break
        return max(candidates, key=lambda each: each[0])[1] if candidates else real

    @cached_property
    def _parts(self) -> tuple[AreaParts, ...]:
        """The parts of each of `areas`."""
        return tuple(split_area(area, self.model.schema) for area in self.areas)

    @cached_property
    def _most_branches(self) -> dict[str, int]:
        """The most branches of a hub of the areas, by the label of the hub."""
        most: dict[str, int] = {}
        for area in self._parts:
            most[area.hub] = max(most.get(area.hub, 0), len(area.branches))
        return most

    @cached_property
    def _floor_areas(self) -> list[dict[int, list[int]]]:
        """By floor of the model, its areas of each cluster."""
        floors: list[dict[int, list[int]]] = []
        first = 0
        for floor in self.model.floors:
            floors.append({})
            for area, cluster in enumerate(floor.clusters, first):
                floors[-1].setdefault(cluster, []).append(area)
            first += len(floor.clusters)
        return floors

    def _use_floor(self, areas: Sequence[int], floor: int, generator: np.random.Generator) -> list[int]:
        """Replace areas of the model by those of a floor in the same cluster, each of these at most once."""
        unused = {cluster: generator.permutation(own).tolist() for cluster, own in self._floor_areas[floor].items()}
        clusters = [int(self.model.clusters[area]) for area in areas]
        return [
            unused[cluster].pop() if unused.get(cluster) else area
            for area, cluster in zip(areas, clusters, strict=True)
        ]

    @cached_property
    def _most(self) -> Counts:
        """The most rooms of each label on any floor of the model, shape (labels,)."""
        most: Counts = self._counts.max(axis=0)
        return most

    @cached_property
    def _counts(self) -> Counts:
        """Rooms of each label on each floor of the model, shape (floors, labels)."""
        counts: Counts = count_labels([floor.graph for floor in self.model.floors], self.model.schema)
        return counts

    def _measure_novelty(self, areas: Sequence[nx.Graph]) -> float:
        """How far the shares of the labels in a building are from those of the nearest floor of the model, 0 … 1.

        It is the total variation, which does not depend on the number of rooms.
        """
        own = count_labels(areas, self.model.schema).sum(axis=0)
        shares = self._counts / self._counts.sum(axis=1, keepdims=True)
        return float(np.abs(own / own.sum() - shares).sum(axis=1).min() / 2)

    def _measure_violations(self, areas: Sequence[nx.Graph]) -> Floats:
        """How far a building violates each limit, shape (3,).

        Rooms too many or too few by the constraints, rooms of labels that no floor has so often, and by how much the
        shares of functions (F/C/E/S) are below or above those of all floors.
        """
        counts = count_labels(areas, self.model.schema).sum(axis=0, keepdims=True)
        violations = self.limits.count_violations(counts, [*self.model.schema.by_name])
        shares = self._share_functions(counts)[0]
        least, most = self._function_bounds
        excess = np.maximum(0, np.maximum(least - shares, shares - most)).sum()
        return np.array([violations[0], np.maximum(counts[0] - self._most, 0).sum(), excess])

    @cached_property
    def _function_bounds(self) -> tuple[Floats, Floats]:
        """The least and the greatest share of each function on the floors of the model, each of shape (functions,)."""
        shares = self._share_functions(self._counts)
        return shares.min(axis=0), shares.max(axis=0)

    def _share_functions(self, counts: Counts) -> Floats:
        """The shares of functions in the rooms of buildings, shape (buildings, functions). counts: of their labels."""
        shares: Floats = counts @ self._functions / counts.sum(axis=1, keepdims=True)
        return shares

    @cached_property
    def _functions(self) -> Floats:
        """1 for the function of each label, else 0, shape (labels, functions)."""
        functions = [label.function_in() for label in self.model.schema.labels]
        return np.array([[each == function for each in FCES] for function in functions], float)
