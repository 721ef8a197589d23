"""Step 4 of section 7.4.3: between which rooms the doors of joined functional areas are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.generation.cut_potentials import CutPotentials, Neighborhood, describe_neighborhood
from pianta.generation.functional_graph import is_planar
from pianta.generation.gram_rows import GraphBatch, References
from pianta.generation.metropolis_hastings import accept
from pianta.generation.type_model import TypeFloor

Pair = tuple[int, int]

PLANAR_TRIES = 20


@dataclass(eq=False)
class Candidates:
    """Pairs of rooms that a door could join, their neighbourhoods, and Λ Λ Υ of each."""

    pairs: list[Pair] = field(default_factory=list)
    neighborhoods: list[Neighborhood] = field(default_factory=list)
    weights: list[float] = field(default_factory=list)

    def draw(self, potentials: CutPotentials, uniform: float) -> Pair:
        """A pair by P_conn.

        Pairs with a common neighbour together are as likely as cuts of the model have one. By degrees and labels alone
        the doors of three areas would meet in their largest corridors, and those of two in one room, where the doors of
        real floors keep apart.
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
    """Ĝ of one chain of step 4: the rooms of its functional areas, and a door or more for each edge of Ĥ.

    labels: of rooms 0 … areas: the rooms of each. doors: by edge of Ĥ, the pairs of rooms that it joins. known_ends: by
    edge of Ĥ, the room at one end of each of its doors, where that is known.
    """

    def __init__(self, areas: Sequence[nx.Graph]) -> None:
        self.labels: list[str] = []
        self.neighbors: list[set[int]] = []
        self.areas: list[range] = []
        self.doors: dict[Pair, list[Pair]] = {}
        self.known_ends: dict[Pair, list[int]] = {}
        for area in areas:
            first = len(self.labels)
            places = {node: first + place for place, node in enumerate(area)}
            self.areas.append(range(first, first + len(area)))
            self.labels += [label for _, label in area.nodes(data="label")]
            self.neighbors += [{places[near] for near in area[node]} for node in area]

    def keep_doors(self, floor: TypeFloor) -> None:
        """Join the first areas, which are those of a floor, by its doors, which never move."""
        rooms = {
            node: self.areas[place][rank]
            for place, area in enumerate(floor.area_graphs)
            for rank, node in enumerate(area)
        }
        for cuts in floor.cuts.values():
            for one, other in cuts:
                self.join(rooms[one], rooms[other])

    def join(self, one: int, other: int) -> None:
        """Add a door."""
        self.neighbors[one].add(other)
        self.neighbors[other].add(one)

    def part(self, one: int, other: int) -> None:
        """Remove a door."""
        self.neighbors[one].discard(other)
        self.neighbors[other].discard(one)

    def list_candidates(self, edge: Pair, potentials: CutPotentials, *, place: int = 0) -> Candidates:
        """S_û of a door of an edge, by its place among its doors: the pairs of rooms of two areas that it may join.

        No door joins them, and the model's cuts have their labels; where they have none of such labels, all pairs.
        """
        found = Candidates()
        ones = self.known_ends[edge][place : place + 1] if edge in self.known_ends else self.areas[edge[0]]
        for anything in (False, True):
            for one in ones:
                for other in self.areas[edge[1]]:
                    frequency = 1.0 if anything else potentials.measure_frequency(self.labels[one], self.labels[other])
                    if not frequency or other in self.neighbors[one]:
                        continue
                    # Λ: rooms with more doors get more; one without any has one when it is joined.
                    degrees = max(len(self.neighbors[one]), 1) * max(len(self.neighbors[other]), 1)
                    around = describe_neighborhood(self.labels, self.neighbors, one, other)
                    found.pairs.append((one, other))
                    found.neighborhoods.append(around)
                    found.weights.append(frequency * degrees)
            if found.pairs:
                break
        return found

    def is_planar(self) -> bool:
        """Whether its graph is; areas that no door joins yet are parts of it."""
        return is_planar(self.list_doors(), len(self.labels), parts=len(self.areas))

    def list_doors(self) -> list[Pair]:
        """All pairs of rooms that a door joins, sorted."""
        return [(one, other) for one, near in enumerate(self.neighbors) for other in sorted(near) if one < other]

    def to_graph(self) -> nx.Graph:
        """The building as it is now."""
        graph = nx.Graph()
        graph.add_nodes_from((room, {"label": label}) for room, label in enumerate(self.labels))
        graph.add_edges_from(self.list_doors())
        return graph


@dataclass(frozen=True, eq=False)
class _Move:
    """One door of an edge of Ĥ, to be replaced by another."""

    chain: int
    edge: Pair
    place: int
    old: Pair
    candidates: Candidates


class NodeConnections:
    """The chains of step 4: n buildings, their doors moved one by one.

    references: the graphs of the model. functional_graphs: Ĥ of each building, its edges with their number of doors,
    `cuts`; the first areas, `kept` of them, are joined already. generators: one of each building.
    """

    def __init__(
        self,
        references: References,
        buildings: Sequence[ConnectedBuilding],
        functional_graphs: Sequence[nx.Graph],
        potentials: CutPotentials,
        generators: Sequence[np.random.Generator],
        *,
        kept: int = 0,
    ) -> None:
        self.buildings, self.potentials, self.generators = buildings, potentials, generators
        for building, functional, generator in zip(buildings, functional_graphs, generators, strict=True):
            # In the order of the areas, however the graph holds its edges.
            for edge in sorted((min(edge), max(edge)) for edge in functional.edges):
                if edge[1] >= kept:
                    self._draw_start(building, edge, functional.edges[edge]["cuts"], generator)
        # Where a door had to leave a graph that is not planar, or kept rooms have bridges, no other makes it worse.
        self._bridged = {chain for chain, building in enumerate(buildings) if not building.is_planar()}
        self.batch = GraphBatch(references, [building.to_graph() for building in buildings])
        self.costs = self.batch.measure_costs()

    def move(self) -> None:
        """T4 on each chain: a door, chosen at random, moves to a pair of rooms drawn by P_conn."""
        moves = [move for chain in range(len(self.buildings)) if (move := self._choose_door(chain)) is not None]
        # For all chains at once, which is quicker.
        self.potentials.measure_resemblance(around for move in moves for around in move.candidates.neighborhoods)
        uniforms = {move.chain: self.generators[move.chain].random(2) for move in moves}
        proposed = {
            move: move.candidates.draw(self.potentials, float(uniforms[move.chain][0]))
            for move in moves
            if move.candidates.pairs
        }
        self._change(proposed, forward=True)
        costs = self.batch.measure_costs()
        draws = np.zeros(len(costs))
        for chain, uniform in uniforms.items():
            draws[chain] = uniform[1]
        accepted = accept(self.costs, costs, draws)
        refused = {}
        for move, new in proposed.items():
            building = self.buildings[move.chain]
            building.part(*move.old)
            building.join(*new)
            planar = building.is_planar()
            if accepted[move.chain] and (planar or move.chain in self._bridged):
                if planar:
                    self._bridged.discard(move.chain)
                building.doors[move.edge][move.place] = new
                self.costs[move.chain] = costs[move.chain]
                continue
            building.part(*new)
            building.join(*move.old)
            refused[move] = new
        self._change(refused, forward=False)

    def _draw_start(self, building: ConnectedBuilding, edge: Pair, count: int, generator: np.random.Generator) -> None:
        """So many doors for an edge of Ĥ, drawn by P_conn, and drawn again where they leave a graph that is not planar.

        A door that never fits is not made, unless it is the only one.
        """
        doors: list[Pair] = []
        for _ in range(count):
            candidates = building.list_candidates(edge, self.potentials, place=len(doors))
            if not candidates.pairs:
                break
            for _ in range(PLANAR_TRIES):
                pair = candidates.draw(self.potentials, float(generator.random()))
                building.join(*pair)
                if building.is_planar():
                    doors.append(pair)
                    break
                building.part(*pair)
            else:
                if not doors or edge in building.known_ends:
                    building.join(*pair)
                    doors.append(pair)
        if doors:
            building.doors[edge] = doors

    def _choose_door(self, chain: int) -> _Move | None:
        """A door of a building that may move; None when it has none."""
        building, generator = self.buildings[chain], self.generators[chain]
        edges = list(building.doors)
        if not edges:
            return None
        edge = edges[int(generator.integers(len(edges)))]
        place = int(generator.integers(len(building.doors[edge])))
        old = building.doors[edge][place]
        building.part(*old)
        candidates = building.list_candidates(edge, self.potentials, place=place)
        building.join(*old)
        return _Move(chain, edge, place, old, candidates)

    def _change(self, moves: Mapping[_Move, Pair], *, forward: bool) -> None:
        """Replace the old doors by the new ones in the batch, or the other way round."""
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
    """Run the chains for so many moves: the graphs of the buildings, their rooms in the order of the areas.

    traces: gets the costs after each move.
    """
    for _ in range(moves):
        chains.move()
        if traces is not None:
            traces.append(chains.costs.copy())
    return [building.to_graph() for building in chains.buildings]
