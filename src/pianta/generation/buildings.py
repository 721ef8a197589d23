"""New buildings of a type, sampled from its model in four steps (thesis, section 7.4.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.generation.cluster_configuration import (
    EMPTY,
    AreaChains,
    ConfigurationCost,
    DensityCost,
    DistanceCost,
    Slots,
    sample_areas,
)
from pianta.generation.cut_potentials import CutPotentials
from pianta.generation.functional_graph import FunctionalGraphs, draw_door_counts, draw_start, sample_functional_graphs
from pianta.generation.gram_rows import References
from pianta.generation.node_connections import ConnectedBuilding, NodeConnections, connect_areas
from pianta.generation.type_model import Counts, TypeFloor, TypeModel, count_labels
from pianta.generation.wishes import Wishes

MAX_BUILDINGS, MAX_JOBS, BATCH = 100_000, 256, 100
# Pairs of rooms in a batch; rooms of the floors that buildings are compared with, times these floors.
MAX_PAIRS, MAX_FEATURES = 2_000_000, 4_000_000
STEPS = ("functional areas", "functional graphs", "doors")
# Buildings are by this share smaller than the smallest floor that they are to be like, or larger than the largest.
BEYOND = 0.2


class Costs(StrEnum):
    """What steps 1 and 4 follow.

    DENSITY: Γ1 by how dense configurations lie; as many doors for an edge of Ĥ as real ones have, which close a
    triangle as often. THESIS: Γ1, one door and P_conn as in section 7.4.3; nothing of sizes.
    """

    DENSITY = "density"
    THESIS = "thesis"


@dataclass(frozen=True, eq=False)
class BuildingSampler:
    """Samples buildings of a type; what the model gives is worked out once.

    wishes: what each building must have. Unless they say how many rooms, it has between a fifth fewer than the smallest
    floor of the model and a fifth more than the largest, as far as areas of the model can make that. like: a floor that
    each is to be like, in the place of those of the model. kept: a floor whose rooms and doors each building has, and
    one functional area or more besides; rooms without a door are left out. costs: see Costs.

    Raises OptionError that lists wishes that no building can meet.
    """

    model: TypeModel
    wishes: Wishes = field(default_factory=Wishes)
    like: TypeFloor | None = None
    kept: TypeFloor | None = None
    costs: Costs = Costs.DENSITY

    def __post_init__(self) -> None:
        counts = self.label_counts
        fewest, most = self.slots.bound_rooms(np.column_stack([counts, counts.sum(axis=1)]))
        self.wishes.check(fewest, most, self.model.schema)

    @cached_property
    def areas(self) -> tuple[nx.Graph, ...]:
        """The functional areas that buildings can have: those of the model, and those that are kept."""
        return (*self.model.areas, *(self.kept.area_graphs if self.kept else ()))

    @cached_property
    def label_counts(self) -> Counts:
        """Rooms of each label of the schema in each of `areas`, shape (areas, labels)."""
        return count_labels(self.areas, self.model.schema)

    @cached_property
    def slots(self) -> Slots:
        """Where areas can be: of each cluster as many as a floor ever has, and room for those that are kept."""
        most = self.model.configurations.max(axis=0)
        kept: list[tuple[int, ...]] = [() for _ in most]
        if self.like:
            most = np.maximum(most, self.model.configure(self.like))
        if self.kept:
            # What is kept is never all.
            most = np.maximum(most, self.model.configure(self.kept) + 1)
            for number, cluster in enumerate(self.kept.clusters, len(self.model.areas)):
                kept[cluster] += (number,)
        return Slots(self.model, most, tuple(kept))

    @cached_property
    def functional_references(self) -> References:
        """What Γ2 compares with: functional graphs."""
        return References([floor.functional_graph for floor in _thin(self._examples)])

    @cached_property
    def references(self) -> References:
        """What Γ4 compares with: the graphs of floors."""
        return References([floor.graph for floor in _thin(self._examples)])

    @cached_property
    def potentials(self) -> CutPotentials:
        """Φ of step 4."""
        return CutPotentials(self.model, closing=self.costs is not Costs.THESIS)

    def sample(
        self, numbers: Sequence[int], *, seed: int, track: Callable[[Sequence[str]], Iterable[str]] = iter
    ) -> list[nx.Graph]:
        """The buildings of these numbers, 0 … among all of a seed; which are sampled beside it changes none.

        track: wraps the names of the steps, to show progress.
        Raises ModelError when wishes are not met.
        """
        generators = [np.random.default_rng((seed, number)) for number in numbers]
        steps = iter(track([f"buildings {numbers[0] + 1} to {numbers[-1] + 1}: {step}" for step in STEPS]))
        # Step 1: how many functional areas of each cluster; and step 3: which.
        next(steps)
        chosen = self.sample_areas(self._choose_starts(numbers, seed), generators)
        # Step 2: which of them are joined.
        next(steps)
        functional_graphs = self.join_areas(chosen, generators)
        # Step 4: by which doors.
        next(steps)
        buildings = self.connect_rooms(chosen, functional_graphs, generators)
        next(steps, None)
        return buildings

    def sample_areas(
        self, starts: Counts, generators: Sequence[np.random.Generator], *, traces: list[Floats] | None = None
    ) -> list[list[int]]:
        """Steps 1 and 3: the areas of each building, the kept ones first; chains start from the given configurations.

        traces: gets the costs after each sweep.
        """
        slots, wishes = self.slots, self.wishes
        if not wishes.rooms and self.costs is not Costs.THESIS:
            wishes = replace(wishes, rooms=self._bound_size())
        cost: ConfigurationCost = (
            DistanceCost(slots, like=self.like)
            if self.costs is Costs.THESIS
            else DensityCost(slots, like=self.like, rooms=self.wishes.rooms)
        )
        uniforms = np.stack([generator.random(len(slots.clusters)) for generator in generators])
        filled = slots.fill(starts, uniforms)
        chains = AreaChains(slots, cost, filled, wishes=wishes, label_counts=self.label_counts)
        filled = sample_areas(chains, generators, needed=self.wishes, traces=traces)
        kept = range(len(self.model.areas), len(self.areas))
        return [[*kept, *(area for area in row if area not in kept and area != EMPTY)] for row in filled.tolist()]

    def join_areas(
        self,
        chosen: Sequence[Sequence[int]],
        generators: Sequence[np.random.Generator],
        *,
        traces: list[Floats] | None = None,
    ) -> list[nx.Graph]:
        """Step 2: Ĥ of each building, its nodes the chosen areas in order. traces: gets the costs after each move."""
        clusters = [*self.model.clusters.tolist(), *(self.kept.clusters if self.kept else ())]
        functional = self.kept.functional_graph if self.kept else None
        starts = [
            draw_start([str(clusters[area]) for area in areas], generator, kept=functional)
            for areas, generator in zip(chosen, generators, strict=True)
        ]
        chains = FunctionalGraphs(self.functional_references, starts, kept=len(functional or ()))
        graphs = sample_functional_graphs(chains, generators, moves=self.model.edge_moves, traces=traces)
        for graph, generator in zip(graphs, generators, strict=True):
            draw_door_counts(graph, [1] if self.costs is Costs.THESIS else self.model.door_counts, generator)
        return graphs

    def connect_rooms(
        self,
        chosen: Sequence[Sequence[int]],
        functional_graphs: Sequence[nx.Graph],
        generators: Sequence[np.random.Generator],
        *,
        traces: list[Floats] | None = None,
    ) -> list[nx.Graph]:
        """Step 4: the buildings, from their areas and the functional graphs that join them.

        traces: gets the costs after each move.
        """
        buildings = [ConnectedBuilding([self.areas[area] for area in areas]) for areas in chosen]
        if self.kept:
            for building in buildings:
                building.keep_doors(self.kept)
        kept = len(self.kept.areas) if self.kept else 0
        chains = NodeConnections(self.references, buildings, functional_graphs, self.potentials, generators, kept=kept)
        graphs = connect_areas(chains, moves=self.model.door_moves, traces=traces)
        if self.kept:
            rooms = [room for area in self.kept.area_graphs for _, room in area.nodes(data="room")]
            for graph in graphs:
                nx.set_node_attributes(graph, dict(enumerate(rooms)), "room")
        return graphs

    def _bound_size(self) -> tuple[int, int]:
        """The fewest and the most rooms that a building has when nothing is wished for."""
        sizes = [len(floor.graph) for floor in self._examples]
        kept = len(self.kept.graph) if self.kept else 0
        smallest = min(map(len, self.model.areas)) if kept else 0
        most = max(round((1 + BEYOND) * max(sizes)), sum(self.wishes.at_least.values()), kept + smallest)
        return min(max(round((1 - BEYOND) * min(sizes)), kept), most), most

    @property
    def _examples(self) -> Sequence[TypeFloor]:
        """The floors that buildings are to be like."""
        return [self.like] if self.like else self.model.floors

    def _choose_starts(self, numbers: Sequence[int], seed: int) -> Counts:
        """The configuration of a floor for each building, each floor once before one comes again."""
        examples = self._examples
        orders = {
            turn: np.random.default_rng((seed, turn, len(examples))).permutation(len(examples))
            for turn in {number // len(examples) for number in numbers}
        }
        chosen = [orders[number // len(examples)][number % len(examples)] for number in numbers]
        return np.array([self.model.configure(examples[place]) for place in chosen])


def generate_buildings(
    model: TypeModel,
    count: int,
    *,
    seed: int = 0,
    wishes: Wishes | None = None,
    like: TypeFloor | None = None,
    kept: TypeFloor | None = None,
    costs: Costs = Costs.DENSITY,
    jobs: int = 1,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> list[nx.Graph]:
    """New buildings of a type: graphs with nodes 0 … n - 1, a `label` each; the first are the rooms of `kept`.

    wishes, like, kept, costs: see BuildingSampler. jobs: processes; the buildings are the same for any number of them.
    track: wraps the names of what is done, to show progress.

    Raises OptionError for no or too many buildings or jobs and for wishes that no building can meet, ModelError for
    wishes that were not met.
    """
    if not 1 <= count <= MAX_BUILDINGS:
        raise OptionError(f"{count} buildings are wanted, give 1 to {MAX_BUILDINGS}")
    if seed < 0:
        raise OptionError(f"seed is {seed}, give 0 or more")
    if not 1 <= jobs <= MAX_JOBS:
        raise OptionError(f"jobs is {jobs}, give 1 to {MAX_JOBS}")
    sampler = BuildingSampler(model, wishes or Wishes(), like, kept, costs)
    rooms = max(len(floor.graph) for floor in (*model.floors, *([kept] if kept else ())))
    batches = split_batches(count, max(rooms, sampler.wishes.rooms[1] if sampler.wishes.rooms else 0), jobs=jobs)
    if jobs == 1:
        return [building for batch in batches for building in sampler.sample(batch, seed=seed, track=track)]
    return _sample_in_processes(sampler, batches, seed, jobs, track)


def split_batches(count: int, rooms: int, *, jobs: int = 1) -> list[range]:
    """The numbers 0 … count - 1 in batches whose chains run side by side, which is quicker than one after the other.

    rooms: of the largest building; the memory that a batch takes grows with their square.
    """
    size = max(1, min(BATCH, -(-count // jobs), MAX_PAIRS // rooms**2))
    return [range(first, min(first + size, count)) for first in range(0, count, size)]


def _thin(floors: Sequence[TypeFloor]) -> Sequence[TypeFloor]:
    """Floors to compare with, evenly fewer where counts of their features would fill the memory."""
    while len(floors) > 1 and len(floors) * sum(len(floor.graph) for floor in floors) > MAX_FEATURES:
        floors = floors[::2]
    return floors


def _sample_in_processes(
    sampler: BuildingSampler,
    batches: Sequence[range],
    seed: int,
    jobs: int,
    track: Callable[[Sequence[str]], Iterable[str]],
) -> list[nx.Graph]:
    from joblib import Parallel, delayed

    names = [f"buildings {batch[0] + 1} to {batch[-1] + 1}" for batch in batches]
    run = delayed(BuildingSampler.sample)
    found = Parallel(n_jobs=jobs, return_as="generator")(run(sampler, batch, seed=seed) for batch in batches)
    return [building for _, of_batch in zip(track(names), found, strict=True) for building in of_batch]
