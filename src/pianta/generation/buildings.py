"""New buildings of a type, sampled from its model in four steps (thesis, section 7.4.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from itertools import islice
from types import MappingProxyType

import networkx as nx
import numpy as np

from pianta._types import Floats, Indices
from pianta.errors import OptionError
from pianta.generation.area_clusters import AreaKernel
from pianta.generation.cluster_configuration import (
    EMPTY,
    AreaChains,
    ConfigurationCost,
    DensityCost,
    DistanceCost,
    Slots,
    sample_areas,
)
from pianta.generation.constraints import Constraints
from pianta.generation.cut_potentials import CutPotentials
from pianta.generation.door_costs import DoorCosts, learn_door_costs
from pianta.generation.functional_graph import FunctionalGraphs, draw_door_counts, draw_start, sample_functional_graphs
from pianta.generation.hopper_gram import HopperReferences
from pianta.generation.incremental_gram import ReferenceGraphs
from pianta.generation.node_connections import ConnectedBuilding, NodeConnections, connect_areas
from pianta.generation.recombined_areas import AreaRecombiner
from pianta.generation.type_model import Counts, TypeFloor, TypeModel, count_labels

MAX_BUILDINGS = 100_000
MAX_JOBS = 256
# Buildings whose chains run side by side.
BATCH = 100
# Pairs of rooms in a batch, which limits its memory.
MAX_PAIRS = 2_000_000
# Rooms of the reference floors, times the number of these floors, which limits the memory of their features.
MAX_FEATURES = 4_000_000
STEPS = ("functional areas", "functional graphs", "doors")
# Buildings are at most this share smaller than the smallest example floor, or larger than the largest. Chosen by hand.
SIZE_MARGIN = 0.2


class Costs(StrEnum):
    """The costs of steps 1 and 4.

    DENSITY: Γ1 by the density of configurations and sizes; the numbers of doors of an edge of Ĥ, and the share of doors
    that close a triangle, are those of real floors; rooms that seldom have one door there cost more with one.
    THESIS: Γ1, one door and P_conn as in section 7.4.3.
    """

    DENSITY = "density"
    THESIS = "thesis"


# By kernel, the references of Γ2 and Γ4.
REFERENCES: Mapping[AreaKernel, type[ReferenceGraphs | HopperReferences]] = MappingProxyType(
    {AreaKernel.WEISFEILER_LEHMAN: ReferenceGraphs, AreaKernel.GRAPH_HOPPER: HopperReferences}
)


@dataclass(frozen=True, eq=False)
class BuildingSampler:
    """Samples buildings of a type; the data of the model is computed once.

    constraints: on the rooms of each building. Without limits of all rooms, SIZE_MARGIN applies where areas of the
    model allow. similar_to: a floor that replaces those of the model as example. fixed: a floor whose rooms and doors
    each building contains, besides at least one more functional area; rooms without a door are left out. costs: see
    Costs. recombines: whether areas change inside, as in `renew_areas`;
    never with the costs of the thesis. kernel: of Γ2 and Γ4.

    Raises OptionError that lists constraints that no building can meet.
    """

    model: TypeModel
    constraints: Constraints = field(default_factory=Constraints)
    similar_to: TypeFloor | None = None
    fixed: TypeFloor | None = None
    costs: Costs = Costs.DENSITY
    recombines: bool = True
    kernel: AreaKernel = AreaKernel.WEISFEILER_LEHMAN

    def __post_init__(self) -> None:
        counts = self.label_counts
        fewest, most = self.slots.bound_rooms(np.column_stack([counts, counts.sum(axis=1)]))
        self.constraints.check(fewest, most, self.model.schema)

    @cached_property
    def areas(self) -> tuple[nx.Graph, ...]:
        """The functional areas of buildings: those of the model, then the fixed ones."""
        return (*self.model.areas, *(self.fixed.area_graphs if self.fixed else ()))

    @cached_property
    def label_counts(self) -> Counts:
        """Rooms of each label of the schema in each of `areas`, shape (areas, labels)."""
        return count_labels(self.areas, self.model.schema)

    @cached_property
    def slots(self) -> Slots:
        """The slots: for each cluster the most areas of any floor, and enough for the fixed ones."""
        most = self.model.configurations.max(axis=0)
        fixed: list[tuple[int, ...]] = [() for _ in most]
        if self.similar_to:
            most = np.maximum(most, self.model.count_clusters(self.similar_to))
        if self.fixed:
            # At least one more area.
            most = np.maximum(most, self.model.count_clusters(self.fixed) + 1)
            for number, cluster in enumerate(self.fixed.clusters, len(self.model.areas)):
                fixed[cluster] += (number,)
        return Slots(self.model, most, tuple(fixed))

    @cached_property
    def functional_references(self) -> ReferenceGraphs | HopperReferences:
        """The references of Γ2: functional graphs."""
        return REFERENCES[self.kernel]([floor.functional_graph for floor in _thin(self._examples)])

    @cached_property
    def references(self) -> ReferenceGraphs | HopperReferences:
        """The references of Γ4: graphs of floors."""
        return REFERENCES[self.kernel]([floor.graph for floor in _thin(self._examples)])

    @cached_property
    def potentials(self) -> CutPotentials:
        """Φ of step 4."""
        return CutPotentials(self.model, closing=self.costs is not Costs.THESIS)

    @cached_property
    def door_costs(self) -> DoorCosts:
        """Added to α Γ4; none with the costs of the thesis."""
        return DoorCosts() if self.costs is Costs.THESIS else learn_door_costs(self.model)

    @property
    def max_rooms(self) -> int:
        """Rooms of the largest building that is likely."""
        floors = (*self.model.floors, *([self.fixed] if self.fixed else ()))
        return max(*(len(floor.graph) for floor in floors), self.constraints.rooms[1] if self.constraints.rooms else 0)

    def sample(
        self, numbers: Sequence[int], *, seed: int, track: Callable[[Sequence[str]], Iterable[str]] = iter
    ) -> list[nx.Graph]:
        """Sample the buildings with these numbers, from 0; a building depends only on its number and the seed.

        track: wraps the names of the steps, to show progress.
        Raises ModelError if constraints are not met.
        """
        generators = [np.random.default_rng((seed, number)) for number in numbers]
        steps = iter(track(name_steps(numbers)))
        # Step 1: the number of functional areas of each cluster; and step 3: the areas, which then change inside.
        next(steps)
        floors = self.choose_floors(numbers, seed)
        starts = np.array([self.model.count_clusters(self._examples[floor]) for floor in floors])
        examples = floors if self._has_own_floors else None
        chosen = self.sample_areas(starts, generators, examples=examples)
        areas = self.renew_areas(chosen, generators, examples=examples)
        # Step 2: the edges between areas.
        next(steps)
        functional_graphs = self.join_areas(chosen, generators)
        # Step 4: the doors of these edges.
        next(steps)
        buildings = self.connect_rooms(areas, functional_graphs, generators)
        next(steps, None)
        return buildings

    def choose_floors(self, numbers: Sequence[int], seed: int) -> Indices:
        """The floor that each building follows, as an index; no floor is used again before all others.

        numbers, seed: as for `sample`. With constraints, chains only start from these floors.
        """
        examples = self._examples
        orders = {
            turn: np.random.default_rng((seed, turn, len(examples))).permutation(len(examples))
            for turn in {number // len(examples) for number in numbers}
        }
        return np.array([orders[number // len(examples)][number % len(examples)] for number in numbers])

    def sample_areas(
        self,
        starts: Counts,
        generators: Sequence[np.random.Generator],
        *,
        examples: Indices | None = None,
        traces: list[Floats] | None = None,
    ) -> list[list[int]]:
        """Steps 1 and 3: the areas of each building, the fixed ones first.

        starts: the configuration from which each chain starts. examples: see DensityCost. traces: receives the costs
        after each sweep.
        """
        slots = self.slots
        cost: ConfigurationCost = (
            DistanceCost(slots, similar_to=self.similar_to)
            if self.costs is Costs.THESIS
            else self._measure_density(examples)
        )
        uniforms = np.stack([generator.random(len(slots.clusters)) for generator in generators])
        filled = slots.fill(starts, uniforms)
        chains = AreaChains(slots, cost, filled, constraints=self._limits, label_counts=self.label_counts)
        filled = sample_areas(chains, generators, needed=self.constraints, traces=traces)
        fixed = range(len(self.model.areas), len(self.areas))
        return [[*fixed, *(area for area in row if area not in fixed and area != EMPTY)] for row in filled.tolist()]

    def renew_areas(
        self,
        chosen: Sequence[Sequence[int]],
        generators: Sequence[np.random.Generator],
        *,
        examples: Indices | None = None,
    ) -> list[list[nx.Graph]]:
        """The areas of each building, changed inside: first taken from one floor where possible, then recombined.

        chosen: the areas of each building, the fixed ones first. Fixed areas stay as they are. examples: see
        DensityCost.
        """
        real = [[self.areas[area] for area in areas] for areas in chosen]
        if not self.recombines or self.costs is Costs.THESIS:
            return real
        rooms = np.array([sum(map(len, graphs)) for graphs in real])
        clusters = [*self.model.clusters.tolist(), *(self.fixed.clusters if self.fixed else ())]
        configurations = np.array(
            [np.bincount([clusters[area] for area in areas], minlength=len(self.slots.areas)) for areas in chosen]
        )
        shares = self._measure_density(examples).share_floors(configurations, rooms)
        return [
            self._recombiner.renew(areas, weights, generator)
            for areas, weights, generator in zip(chosen, shares, generators, strict=True)
        ]

    def join_areas(
        self,
        chosen: Sequence[Sequence[int]],
        generators: Sequence[np.random.Generator],
        *,
        traces: list[Floats] | None = None,
    ) -> list[nx.Graph]:
        """Step 2: Ĥ of each building, a node for each chosen area. traces: receives the costs after each move."""
        clusters = [*self.model.clusters.tolist(), *(self.fixed.clusters if self.fixed else ())]
        functional = self.fixed.functional_graph if self.fixed else None
        starts = [
            draw_start([str(clusters[area]) for area in areas], generator, fixed=functional)
            for areas, generator in zip(chosen, generators, strict=True)
        ]
        chains = FunctionalGraphs(self.functional_references, starts, n_fixed=len(functional or ()))
        graphs = sample_functional_graphs(chains, generators, moves=self.model.edge_moves, traces=traces)
        for graph, generator in zip(graphs, generators, strict=True):
            draw_door_counts(graph, [1] if self.costs is Costs.THESIS else self.model.door_counts, generator)
        return graphs

    def connect_rooms(
        self,
        areas: Sequence[Sequence[nx.Graph]],
        functional_graphs: Sequence[nx.Graph],
        generators: Sequence[np.random.Generator],
        *,
        traces: list[Floats] | None = None,
    ) -> list[nx.Graph]:
        """Step 4: the buildings, from their areas and functional graphs. traces: receives the costs after each move."""
        buildings = [ConnectedBuilding(graphs) for graphs in areas]
        if self.fixed:
            for building in buildings:
                building.add_fixed_doors(self.fixed)
        fixed = len(self.fixed.areas) if self.fixed else 0
        chains = NodeConnections(
            self.references,
            buildings,
            functional_graphs,
            self.potentials,
            generators,
            n_fixed=fixed,
            door_costs=self.door_costs,
        )
        graphs = connect_areas(chains, moves=self.model.door_moves, traces=traces)
        if self.fixed:
            rooms = [room for area in self.fixed.area_graphs for _, room in area.nodes(data="room")]
            for graph in graphs:
                nx.set_node_attributes(graph, dict(enumerate(rooms)), "room")
        return graphs

    @property
    def _has_own_floors(self) -> bool:
        """Whether each building follows one floor. With constraints the chains find the floors that can meet them."""
        return (
            self.recombines
            and self.costs is not Costs.THESIS
            and not (self.similar_to or self.fixed or self.constraints)
        )

    def _measure_density(self, examples: Indices | None) -> DensityCost:
        return DensityCost(self.slots, similar_to=self.similar_to, rooms=self.constraints.rooms, examples=examples)

    @cached_property
    def _limits(self) -> Constraints:
        """The constraints, with limits of all rooms unless the costs are those of the thesis."""
        if self.constraints.rooms or self.costs is Costs.THESIS:
            return self.constraints
        return replace(self.constraints, rooms=self._bound_size())

    @cached_property
    def _recombiner(self) -> AreaRecombiner:
        n_fixed = len(self.fixed.areas) if self.fixed else 0
        return AreaRecombiner(self.model, self.areas, n_fixed, self._limits, mixes_floors=bool(self.similar_to))

    def _bound_size(self) -> tuple[int, int]:
        """The minimum and maximum rooms of a building without constraints on them."""
        sizes = [len(floor.graph) for floor in self._examples]
        fixed = len(self.fixed.graph) if self.fixed else 0
        smallest = min(map(len, self.model.areas)) if fixed else 0
        most = max(round((1 + SIZE_MARGIN) * max(sizes)), sum(self.constraints.at_least.values()), fixed + smallest)
        return min(max(round((1 - SIZE_MARGIN) * min(sizes)), fixed), most), most

    @property
    def _examples(self) -> Sequence[TypeFloor]:
        """The floors that buildings should resemble."""
        return [self.similar_to] if self.similar_to else self.model.floors


def generate_buildings(
    model: TypeModel,
    count: int,
    *,
    seed: int = 0,
    constraints: Constraints | None = None,
    similar_to: TypeFloor | None = None,
    fixed: TypeFloor | None = None,
    costs: Costs = Costs.DENSITY,
    recombines: bool = True,
    kernel: AreaKernel = AreaKernel.WEISFEILER_LEHMAN,
    jobs: int = 1,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> list[nx.Graph]:
    """Generate buildings: graphs with nodes 0 … n - 1, each with a `label`; the first nodes are the rooms of `fixed`.

    constraints, similar_to, fixed, costs, recombines, kernel: see BuildingSampler. jobs: processes; the result does not
    depend on them.
    track: wraps the names of the steps, to show progress.

    Raises OptionError for a count, seed or jobs out of range and for constraints that no building can meet, ModelError
    for constraints that were not met.
    """
    sampler = BuildingSampler(model, constraints or Constraints(), similar_to, fixed, costs, recombines, kernel)
    return sample_buildings(sampler, count, seed=seed, jobs=jobs, track=track)


def sample_buildings(
    sampler: BuildingSampler,
    count: int,
    *,
    seed: int = 0,
    jobs: int = 1,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> list[nx.Graph]:
    """The first buildings of a sampler. Raises OptionError and ModelError as `generate_buildings`."""
    check_count(count, seed)
    if not 1 <= jobs <= MAX_JOBS:
        raise OptionError(f"jobs is {jobs}, give 1 to {MAX_JOBS}")
    if jobs == 1:
        return sample_numbers(sampler, range(count), seed=seed, track=track)
    return _sample_in_processes(sampler, split_batches(range(count), sampler.max_rooms, jobs=jobs), seed, jobs, track)


def sample_numbers(
    sampler: BuildingSampler,
    numbers: range,
    *,
    seed: int,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> list[nx.Graph]:
    """The buildings with these numbers, from 0, in this process. track: wraps the names of the steps of all."""
    batches = split_batches(numbers, sampler.max_rooms)
    steps = iter(track([name for batch in batches for name in name_steps(batch)]))

    def take(names: Sequence[str]) -> Iterable[str]:
        return islice(steps, len(names))

    buildings = [building for batch in batches for building in sampler.sample(batch, seed=seed, track=take)]
    next(steps, None)
    return buildings


def name_steps(numbers: Sequence[int]) -> list[str]:
    """Names of the steps of buildings that are sampled together, for people."""
    return [f"buildings {numbers[0] + 1} to {numbers[-1] + 1}: {step}" for step in STEPS]


def check_count(count: int, seed: int) -> None:
    """Raise OptionError for a number of buildings, or a seed, out of range."""
    if not 1 <= count <= MAX_BUILDINGS:
        raise OptionError(f"{count} buildings are wanted, give 1 to {MAX_BUILDINGS}")
    if seed < 0:
        raise OptionError(f"seed is {seed}, give 0 or more")


def find_building_seed(seed: int, number: int) -> int:
    """The seed with which a building of a run is drawn, furnished and mapped, by its number from 0."""
    return seed * MAX_BUILDINGS + number


def split_batches(numbers: range, rooms: int, *, jobs: int = 1) -> list[range]:
    """The numbers of buildings in batches whose chains run side by side, which is faster.

    rooms: of the largest building; the memory of a batch grows with their square.
    """
    size = max(1, min(BATCH, -(-len(numbers) // jobs), MAX_PAIRS // rooms**2))
    return [numbers[first : first + size] for first in range(0, len(numbers), size)]


def _thin(floors: Sequence[TypeFloor]) -> Sequence[TypeFloor]:
    """Every second floor, repeatedly, until the counts of features fit into memory."""
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
    """The buildings of all batches in order, sampled in `jobs` processes; track: wraps the names of the batches."""
    from joblib import Parallel, delayed

    names = [f"buildings {batch[0] + 1} to {batch[-1] + 1}" for batch in batches]
    run = delayed(BuildingSampler.sample)
    results = Parallel(n_jobs=jobs, return_as="generator")(run(sampler, batch, seed=seed) for batch in batches)
    return [building for _, buildings in zip(track(names), results, strict=True) for building in buildings]
