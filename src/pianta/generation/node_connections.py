"""Step 4 of section 7.4.3: the rooms of the doors between functional areas."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.generation.cut_potentials import CutPotentials, Neighborhood, describe_neighborhood
from pianta.generation.door_costs import DoorCosts
from pianta.generation.functional_graph import is_planar
from pianta.generation.hopper_gram import HopperReferences
from pianta.generation.incremental_gram import ReferenceGraphs
from pianta.generation.metropolis_hastings import accept
from pianta.generation.type_model import TypeFloor

Pair = tuple[int, int]

# Draws of a door before it is given up because the graph is not planar with it. Chosen by hand.
PLANAR_TRIES = 20
NO_DOOR_COSTS = DoorCosts()


@dataclass(eq=False)
class Candidates:
    """Pairs of rooms for a new door, with the neighbourhood and Λ Λ Υ of each."""

    pairs: list[Pair] = field(default_factory=list)
    neighborhoods: list[Neighborhood] = field(default_factory=list)
    weights: list[float] = field(default_factory=list)

    def draw(self, potentials: CutPotentials, uniform: float) -> Pair:
        """Draw a pair by P_conn.

        The total probability of pairs with a common neighbour is the share of such cuts of the model. By degrees and
        labels alone, too many doors would meet in the same rooms.
        """
        resemblance = potentials.measure_resemblance(self.neighborhoods)
        weights = np.array(self.weights) * [resemblance[around] for around in self.neighborhoods]
        closing = np.array([bool(common) for *_, common in self.neighborhoods])
        if potentials.closed is not None and closing.any() and not closing.all():
            weights[closing] *= potentials.closed / weights[closing].sum()
            weights[~closing] *= (1 - potentials.closed) / weights[~closing].sum()
        bounds = np.cumsum(weights)
        return self.pairs[int(np.searchsorted(bounds, uniform * bounds[-1], side="right").clip(0, len(bounds) - 1))]


class ConnectedBuilding:
    """Ĝ of one chain of step 4: the rooms of its functional areas, and at least one door for each edge of Ĥ.

    labels: of rooms 0 … n - 1. areas: the rooms of each. doors: edge of Ĥ -> the pairs of rooms of its doors.
    known_ends: edge of Ĥ -> the room at the known end of each of its doors, if known.
    """

    def __init__(self, areas: Sequence[nx.Graph]) -> None:
        self.labels: list[str] = []
        self.neighbors: list[set[int]] = []
        self.areas: list[range] = []
        self.doors: dict[Pair, list[Pair]] = {}
        self.known_ends: dict[Pair, list[int]] = {}
        for area in areas:
            first = len(self.labels)
            numbers = {node: first + rank for rank, node in enumerate(area)}
            self.areas.append(range(first, first + len(area)))
            self.labels += [label for _, label in area.nodes(data="label")]
            self.neighbors += [{numbers[near] for near in area[node]} for node in area]

    def add_fixed_doors(self, floor: TypeFloor) -> None:
        """Add the doors of a floor, whose areas are the first ones; they never move."""
        rooms = {
            node: self.areas[index][rank]
            for index, area in enumerate(floor.area_graphs)
            for rank, node in enumerate(area)
        }
        for cuts in floor.cuts.values():
            for one, other in cuts:
                self.connect(rooms[one], rooms[other])

    def connect(self, one: int, other: int) -> None:
        """Add a door between two rooms."""
        self.neighbors[one].add(other)
        self.neighbors[other].add(one)

    def disconnect(self, one: int, other: int) -> None:
        """Remove the door between two rooms."""
        self.neighbors[one].discard(other)
        self.neighbors[other].discard(one)

    def list_candidates(self, edge: Pair, potentials: CutPotentials, *, index: int = 0) -> Candidates:
        """S_û of a door of an edge, by its index: the pairs of rooms of two areas without a door.

        Only pairs with the labels of a cut of the model; without such pairs, all pairs.
        """
        candidates = Candidates()
        ones = self.known_ends[edge][index : index + 1] if edge in self.known_ends else self.areas[edge[0]]
        for any_labels in (False, True):
            for one in ones:
                for other in self.areas[edge[1]]:
                    frequency = (
                        1.0 if any_labels else potentials.measure_frequency(self.labels[one], self.labels[other])
                    )
                    if not frequency or other in self.neighbors[one]:
                        continue
                    # Λ: the degree; a room without doors has 1, its degree with the new door.
                    degrees = max(len(self.neighbors[one]), 1) * max(len(self.neighbors[other]), 1)
                    around = describe_neighborhood(self.labels, self.neighbors, one, other)
                    candidates.pairs.append((one, other))
                    candidates.neighborhoods.append(around)
                    candidates.weights.append(frequency * degrees)
            if candidates.pairs:
                break
        return candidates

    def is_planar(self) -> bool:
        """Whether its graph is planar; there are at most as many components as areas."""
        return is_planar(self.list_doors(), len(self.labels), parts=len(self.areas))

    def list_doors(self) -> list[Pair]:
        """The doors as pairs of room numbers, the smaller one first; sorted."""
        return [(one, other) for one, near in enumerate(self.neighbors) for other in sorted(near) if one < other]

    def to_graph(self) -> nx.Graph:
        """The graph of the building: rooms with their `label` as nodes, doors as edges."""
        graph = nx.Graph()
        graph.add_nodes_from((room, {"label": label}) for room, label in enumerate(self.labels))
        graph.add_edges_from(self.list_doors())
        return graph


@dataclass(frozen=True, eq=False)
class _Move:
    """One door of an edge of Ĥ, to be replaced."""

    chain: int
    edge: Pair
    index: int
    old: Pair
    candidates: Candidates


class NodeConnections:
    """The chains of step 4: n buildings, whose doors move one by one.

    references: the graphs of the model. functional_graphs: Ĥ of each building, its edges with their number of doors,
    `cuts`. generators: one for each building. n_fixed: number of fixed areas, the first ones, which have their doors.
    door_costs: added to α Γ4.
    """

    def __init__(
        self,
        references: ReferenceGraphs | HopperReferences,
        buildings: Sequence[ConnectedBuilding],
        functional_graphs: Sequence[nx.Graph],
        potentials: CutPotentials,
        generators: Sequence[np.random.Generator],
        *,
        n_fixed: int = 0,
        door_costs: DoorCosts = NO_DOOR_COSTS,
    ) -> None:
        self.buildings, self.potentials, self.generators = buildings, potentials, generators
        self._door_costs = door_costs
        for building, functional, generator in zip(buildings, functional_graphs, generators, strict=True):
            # Sorted, because the order of edges in a graph varies.
            for edge in sorted((min(edge), max(edge)) for edge in functional.edges):
                if edge[1] >= n_fixed:
                    self._draw_start(building, edge, functional.edges[edge]["cuts"], generator)
        # Buildings that start non-planar may stay so.
        self._non_planar = {chain for chain, building in enumerate(buildings) if not building.is_planar()}
        self.batch = references.start([building.to_graph() for building in buildings])
        self.costs = self._measure_costs()

    def move(self) -> None:
        """T4 on each chain: a random door moves to a pair of rooms drawn by P_conn."""
        moves = [move for chain in range(len(self.buildings)) if (move := self._choose_door(chain)) is not None]
        # Cached for all chains at once, which is faster.
        self.potentials.measure_resemblance(around for move in moves for around in move.candidates.neighborhoods)
        uniforms = {move.chain: self.generators[move.chain].random(2) for move in moves}
        proposed = {
            move: move.candidates.draw(self.potentials, float(uniforms[move.chain][0]))
            for move in moves
            if move.candidates.pairs
        }
        self._change(proposed, forward=True)
        for move, new in proposed.items():
            self.buildings[move.chain].disconnect(*move.old)
            self.buildings[move.chain].connect(*new)
        costs = self._measure_costs()
        draws = np.zeros(len(costs))
        for chain, uniform in uniforms.items():
            draws[chain] = uniform[1]
        accepted = accept(self.costs, costs, draws)
        refused = {}
        for move, new in proposed.items():
            building = self.buildings[move.chain]
            planar = building.is_planar()
            if accepted[move.chain] and (planar or move.chain in self._non_planar):
                if planar:
                    self._non_planar.discard(move.chain)
                building.doors[move.edge][move.index] = new
                self.costs[move.chain] = costs[move.chain]
                continue
            building.disconnect(*new)
            building.connect(*move.old)
            refused[move] = new
        self._change(refused, forward=False)

    def _measure_costs(self) -> Floats:
        """α Γ4 of each building, with the costs of its doors."""
        doors = [self._door_costs.measure(building.labels, building.neighbors) for building in self.buildings]
        costs: Floats = self.batch.measure_costs() + np.array(doors)
        return costs

    def _draw_start(self, building: ConnectedBuilding, edge: Pair, count: int, generator: np.random.Generator) -> None:
        """Draw `count` doors for an edge of Ĥ by P_conn; redraw a door if the graph is not planar with it.

        A door that stays non-planar is omitted, except an only door and a door with a known end.
        """
        doors: list[Pair] = []
        for _ in range(count):
            candidates = building.list_candidates(edge, self.potentials, index=len(doors))
            if not candidates.pairs:
                break
            for _ in range(PLANAR_TRIES):
                pair = candidates.draw(self.potentials, float(generator.random()))
                building.connect(*pair)
                if building.is_planar():
                    doors.append(pair)
                    break
                building.disconnect(*pair)
            else:
                if not doors or edge in building.known_ends:
                    building.connect(*pair)
                    doors.append(pair)
        if doors:
            building.doors[edge] = doors

    def _choose_door(self, chain: int) -> _Move | None:
        """A random door of a building, with its candidates; None if it has no door that may move."""
        building, generator = self.buildings[chain], self.generators[chain]
        edges = list(building.doors)
        if not edges:
            return None
        edge = edges[int(generator.integers(len(edges)))]
        index = int(generator.integers(len(building.doors[edge])))
        old = building.doors[edge][index]
        building.disconnect(*old)
        candidates = building.list_candidates(edge, self.potentials, index=index)
        building.connect(*old)
        return _Move(chain, edge, index, old, candidates)

    def _change(self, moves: Mapping[_Move, Pair], *, forward: bool) -> None:
        """Replace the old doors by the new ones in the batch, or the reverse."""
        moves = {move: new for move, new in moves.items() if new != move.old}
        chains = np.array([move.chain for move in moves], np.intp)
        old = np.array([move.old for move in moves], np.intp).reshape(-1, 2)
        new = np.array([*moves.values()], np.intp).reshape(-1, 2)
        self.batch.change_edges(
            np.concatenate([chains, chains]),
            *np.concatenate([old, new]).T,
            present=np.repeat([not forward, forward], len(chains)),
        )


def connect_areas(chains: NodeConnections, *, moves: int, traces: list[Floats] | None = None) -> list[nx.Graph]:
    """Run the chains for a number of moves; return the buildings, their rooms in the order of the areas.

    traces: receives the costs after each move.
    """
    for _ in range(moves):
        chains.move()
        if traces is not None:
            traces.append(chains.costs.copy())
    return [building.to_graph() for building in chains.buildings]
