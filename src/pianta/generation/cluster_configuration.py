"""Steps 1 and 3 of section 7.4.3: the number of areas of each cluster in a building, and the areas themselves.

A building has slots for the areas of each cluster, enough for any floor of the model; the cluster configuration is
the number of filled slots of each cluster. Step 3 fills a slot with a random area of its cluster. Here a slot gets its
area as soon as step 1 fills it, which gives the same distribution and lets step 1 follow constraints on rooms.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Protocol

import numpy as np
from scipy.special import gammaln, logsumexp, softmax

from pianta._types import Floats, Indices, Mask
from pianta.errors import ModelError
from pianta.generation.constraints import Constraints
from pianta.generation.functional_areas import Segmentation
from pianta.generation.metropolis_hastings import accept, choose, draw_uniforms
from pianta.generation.type_model import Counts, TypeFloor, TypeModel

# An empty slot.
EMPTY = -1
# x of DensityCost: P(number of areas of a cluster is drawn from all floors, not from the similar one). Chosen by hand.
P_ANY_FLOOR = 0.2
# The same for a building that has to be similar to one floor.
P_ANY_FLOOR_IF_SIMILAR = 0.05
# s of DensityCost: standard deviation of ln(rooms of the building / rooms of the floor). Chosen by hand.
SIZE_DEVIATION = 0.15
# Frequency of numbers of areas that no floor has, so that they stay possible. Chosen by hand.
MIN_FREQUENCY = 1e-4
# α of the cost of the thesis, for 50 floors (method-notes.md).
PUBLISHED_ALPHA = MappingProxyType({Segmentation.CORR: 0.0625, Segmentation.NCUT: 0.0575})
PUBLISHED_FLOORS = 50
# Random numbers of a move.
DRAWS = 4
# Cost of each room that violates a constraint. Chosen by hand.
VIOLATION_COST = 2.0
# Cost of a building with fixed areas only, larger than any other.
FIXED_ONLY_COST = 1e9
# Chains stop after this many times their sweeps if constraints are not met. Chosen by hand.
MAX_SWEEPS_FACTOR = 10


@dataclass(frozen=True, eq=False)
class Slots:
    """The slots of a building.

    areas: the number of slots of each cluster, shape (clusters,). fixed_areas: by cluster, the areas that always fill
    its first slots; their numbers follow those of the model's areas.
    """

    model: TypeModel
    areas: Counts
    fixed_areas: tuple[tuple[int, ...], ...]

    @cached_property
    def clusters(self) -> Indices:
        """The cluster of each slot, shape (slots,)."""
        return np.repeat(np.arange(len(self.areas)), self.areas)

    @cached_property
    def ranks(self) -> Indices:
        """The index of each slot among those of its cluster, shape (slots,)."""
        return np.arange(len(self.clusters)) - np.repeat(np.cumsum(self.areas) - self.areas, self.areas)

    @cached_property
    def fixed(self) -> Indices:
        """The fixed area of each slot, shape (slots,), or EMPTY."""
        filled = np.full(len(self.clusters), EMPTY, np.intp)
        for cluster, areas in enumerate(self.fixed_areas):
            filled[np.flatnonzero(self.clusters == cluster)[: len(areas)]] = areas
        return filled

    @cached_property
    def members(self) -> tuple[Indices, Indices]:
        """The model's areas by cluster, padded, shape (clusters, size of the largest), and the size of each cluster."""
        sizes = np.bincount(self.model.clusters, minlength=len(self.areas))
        table = np.zeros((len(sizes), int(sizes.max())), np.intp)
        for cluster, size in enumerate(sizes):
            table[cluster, :size] = np.flatnonzero(self.model.clusters == cluster)
        return table, sizes

    def bound_rooms(self, label_counts: Counts) -> tuple[Counts, Counts]:
        """The minimum and maximum rooms with each label in filled slots, shape (labels,) each.

        label_counts: rooms of each label in each area, fixed ones included, shape (areas, labels).
        """
        fixed_counts = label_counts[self.fixed[self.fixed != EMPTY]].sum(axis=0)
        free = np.bincount(self.clusters[self.fixed == EMPTY], minlength=len(self.areas))
        model_counts = label_counts[: len(self.model.clusters)]
        largest = [model_counts[self.model.clusters == cluster].max(axis=0) for cluster in range(len(self.areas))]
        # At least one area is not fixed.
        return fixed_counts + model_counts.min(axis=0), fixed_counts + free @ np.array(largest)

    def count_areas(self, filled: Indices) -> Counts:
        """Cluster configurations, shape (n, clusters), of filled slots, shape (n, slots)."""
        counts = np.zeros((len(self.areas), len(filled)), np.int64)
        np.add.at(counts, self.clusters, (filled != EMPTY).T)
        return counts.T

    def fill(self, configurations: Counts, draws: Floats) -> Indices:
        """Fill slots by configurations, shape (n, slots): each with its fixed area or a random area of its cluster."""
        table, sizes = self.members
        chosen = table[self.clusters, choose(draws, sizes[self.clusters])]
        filled = np.where(self.ranks < configurations[:, self.clusters], chosen, EMPTY)
        return np.where(self.fixed == EMPTY, filled, self.fixed)


class ConfigurationCost(Protocol):
    """Γ1 of the cluster configurations of n buildings times α; it is made of terms, which are updated slot by slot."""

    def compute_terms(self, slots: Slots, filled: Indices) -> Floats:
        """Terms of the cost, shape (n, terms); filled: the area in each slot or EMPTY, shape (n, slots)."""

    def compute_changes(self, slots: Indices, before: Counts, after: Counts) -> Floats:
        """Change of the terms when one slot of each building is filled or emptied, shape (n, terms).

        slots: the index of the slot, shape (n,). before, after: number of filled slots of its cluster, shape (n,).
        """

    def combine_terms(self, terms: Floats, rooms: Counts) -> Floats:
        """Γ1 from its terms, except for a constant, shape (n,); rooms: number of rooms of each building, shape (n,)."""

    def draw_configurations(self, uniforms: Floats) -> Counts | None:
        """Draw configurations, shape (n, clusters), by e^-Γ1 without the cost of rooms; None if only chains can.

        uniforms: shape (n, 1 + 2 clusters).
        """

    def room_costs(self, terms: Floats, rooms: Counts) -> Floats:
        """The part of Γ1 that depends on the number of rooms, shape (n,)."""


class DensityCost:
    """Γ1 = -ln of the density of the configurations of the model's floors G.

    The density is the mean over floors of Π_i ((1 - x) [v_i = v_i^G] + x p_i(v_i)), where p_i(v_i) is the frequency of
    v_i areas of cluster i on floors, and x = 0.2. It preserves the number of areas of each cluster and which clusters
    occur together, as eq. 7.2 requires; the sum of distances in the thesis is smallest without most clusters. The term
    of a floor is multiplied by exp(-ln²(n / n^G) / 2 s²), where n are the rooms of the building, n^G those of the
    floor, and s = 0.15; otherwise sizes of buildings would vary more than those of floors.
    similar_to: a floor that replaces those of the model; then x = 0.05. rooms: the required minimum and maximum, to
    which n^G is clipped. examples: for each building the index of its floor, whose term is then the only one, shape
    (n,).
    """

    def __init__(
        self,
        slots: Slots,
        *,
        similar_to: TypeFloor | None = None,
        rooms: tuple[int, int] | None = None,
        examples: Indices | None = None,
    ) -> None:
        self._examples = examples
        configurations = slots.model.configurations
        floors = slots.model.floors if similar_to is None else [similar_to]
        near = np.array([slots.model.count_clusters(floor) for floor in floors])
        self._sizes = np.log(np.clip([len(floor.graph) for floor in floors], *(rooms or (1, None))))
        self._near, self._p_any = near, P_ANY_FLOOR if similar_to is None else P_ANY_FLOOR_IF_SIMILAR
        values = np.arange(slots.areas.max() + 1)
        frequencies = (configurations[:, :, None] == values).mean(axis=0) + MIN_FREQUENCY
        frequencies = np.where(values <= slots.areas[:, None], frequencies, 0)
        self._frequencies = frequencies / frequencies.sum(axis=1, keepdims=True)
        densities = (1 - self._p_any) * (near[:, :, None] == values) + self._p_any * self._frequencies
        # Numbers above those of the slots have frequency 0.
        densities = np.log(np.maximum(densities, MIN_FREQUENCY * self._p_any))
        # All ways to fill the same number of slots are one configuration.
        fixed = np.array([len(areas) for areas in slots.fixed_areas])[:, None]
        chosen = np.maximum(values - fixed, 0)
        free = np.maximum(slots.areas[:, None] - fixed, chosen)
        ways = gammaln(free + 1) - gammaln(chosen + 1) - gammaln(free - chosen + 1)
        self._densities = np.moveaxis(densities - ways, 0, 2)
        self._clusters = slots.clusters

    def compute_terms(self, slots: Slots, filled: Indices) -> Floats:
        """Logarithms of the terms of the mixture, shape (n, floors)."""
        configurations = slots.count_areas(filled)
        return self._sum_densities(configurations)

    def compute_changes(self, slots: Indices, before: Counts, after: Counts) -> Floats:
        """See ConfigurationCost."""
        clusters = self._clusters[slots]
        gains: Floats = self._densities[clusters, after] - self._densities[clusters, before]
        return gains

    def combine_terms(self, terms: Floats, rooms: Counts) -> Floats:
        """See ConfigurationCost."""
        return -self._sum_floors(self._add_sizes(terms, rooms))

    def share_floors(self, configurations: Counts, rooms: Counts) -> Floats:
        """The share of each floor in the density of each building, shape (n, floors).

        configurations: shape (n, clusters). rooms: of each building, shape (n,).
        """
        if self._examples is not None:
            return np.eye(len(self._near))[self._examples]
        shares: Floats = softmax(self._add_sizes(self._sum_densities(configurations), rooms), axis=1)
        return shares

    def _sum_densities(self, configurations: Counts) -> Floats:
        """Logarithms of the terms of the mixture, shape (n, floors)."""
        terms: Floats = self._densities[np.arange(configurations.shape[1]), configurations].sum(axis=1)
        return terms

    def _sum_floors(self, logs: Floats) -> Floats:
        """Logarithms of the sums of terms, shape (n,): of all floors, or of the floor of each building."""
        if self._examples is None:
            return np.asarray(logsumexp(logs, axis=1))
        return np.asarray(logs[np.arange(len(logs)), self._examples])

    def _add_sizes(self, terms: Floats, rooms: Counts) -> Floats:
        """Logarithms of the terms of the mixture with the factors of sizes, shape (n, floors)."""
        log_ratios = np.log(np.maximum(rooms, 1))[:, None] - self._sizes
        logs: Floats = terms - log_ratios**2 / (2 * SIZE_DEVIATION**2)
        return logs

    def draw_configurations(self, uniforms: Floats) -> Counts | None:
        """See ConfigurationCost."""
        clusters = self._near.shape[1]
        examples = self._examples
        if examples is None:
            examples = choose(uniforms[:, 0], np.full(len(uniforms), len(self._near)))
        similar = self._near[examples]
        bounds = np.cumsum(self._frequencies, axis=1)[:, :-1]
        random = (uniforms[:, 1 + clusters : 1 + 2 * clusters, None] >= bounds).sum(axis=2)
        return np.where(uniforms[:, 1 : 1 + clusters] < self._p_any, random, similar)

    def room_costs(self, terms: Floats, rooms: Counts) -> Floats:
        """See ConfigurationCost."""
        costs: Floats = self.combine_terms(terms, rooms) + self._sum_floors(terms)
        return costs


class DistanceCost:
    """Γ1 = α Σ_G d(V, V^G) of section 7.4.3: d is the Hamming distance of slots; a floor fills the first ones.

    α is 0.0625 (`corr`) or 0.0575 (`ncut`) for 50 floors, and inversely proportional to their number.
    similar_to: a floor that replaces those of the model.
    """

    def __init__(self, slots: Slots, *, similar_to: TypeFloor | None = None) -> None:
        model = slots.model
        near = model.configurations if similar_to is None else model.count_clusters(similar_to)[None]
        used = (slots.ranks < near[:, slots.clusters]).mean(axis=0)
        # Distance to floors of a filled slot, minus that of an empty one.
        self._gains = PUBLISHED_ALPHA[model.segmentation] * PUBLISHED_FLOORS * (1 - 2 * used)
        self._empty = PUBLISHED_ALPHA[model.segmentation] * PUBLISHED_FLOORS * used.sum()

    def compute_terms(self, slots: Slots, filled: Indices) -> Floats:  # noqa: ARG002 - for DensityCost
        """The cost itself, shape (n, 1)."""
        costs: Floats = self._empty + ((filled != EMPTY) * self._gains).sum(axis=1, keepdims=True)
        return costs

    def compute_changes(self, slots: Indices, before: Counts, after: Counts) -> Floats:
        """See ConfigurationCost."""
        gains: Floats = (self._gains[slots] * (after - before))[:, None]
        return gains

    def combine_terms(self, terms: Floats, rooms: Counts) -> Floats:  # noqa: ARG002 - for DensityCost
        """See ConfigurationCost."""
        return terms[:, 0]

    def draw_configurations(self, uniforms: Floats) -> Counts | None:  # noqa: ARG002 - for DensityCost
        """See ConfigurationCost."""
        return None

    def room_costs(self, terms: Floats, rooms: Counts) -> Floats:  # noqa: ARG002 - for DensityCost
        """See ConfigurationCost."""
        return np.zeros(len(rooms))


class AreaChains:
    """The chains of step 1, one for each building.

    filled: the area in each slot, shape (n, slots). constraints: on the rooms of buildings. label_counts: the rooms of
    each label in each area, fixed ones included.
    """

    def __init__(
        self, slots: Slots, cost: ConfigurationCost, filled: Indices, *, constraints: Constraints, label_counts: Counts
    ) -> None:
        self.slots, self.cost, self.constraints = slots, cost, constraints
        self.filled = filled
        self._labels = [*slots.model.schema.by_name]
        # The last row is for EMPTY.
        self._label_counts = np.vstack([label_counts, np.zeros(label_counts.shape[1], np.int64)])
        self._counts = slots.count_areas(filled)
        self._terms = cost.compute_terms(slots, filled)
        self._rooms = self._label_counts[filled].sum(axis=1)
        self.violations = self.count_violations(constraints)
        self._n_fixed = int((slots.fixed != EMPTY).sum())
        self.costs = self._compute_costs()

    def move(self, uniforms: Floats, running: Mask) -> None:
        """Propose to flip or exchange a slot of each running chain, shape (n,); uniforms: shape (n, DRAWS)."""
        slots, every = self.slots, np.arange(len(self.filled))
        free = np.flatnonzero(slots.fixed == EMPTY)
        chosen = free[choose(uniforms[:, 0], np.full(len(every), len(free)))]
        clusters, old = slots.clusters[chosen], self.filled[every, chosen]
        table, sizes = slots.members
        picked = table[clusters, choose(uniforms[:, 1], sizes[clusters])]
        # T1: a random component changes by one.
        new = np.where(old == EMPTY, picked, EMPTY)
        if self.constraints:
            # Half of the moves exchange the area for another one of its cluster.
            exchanges = uniforms[:, 2] < 1 / 2
            new = np.where(exchanges, np.where(old == EMPTY, EMPTY, picked), new)
        before = self._counts[every, clusters]
        after = before + (new != EMPTY) - (old != EMPTY)
        terms = self._terms + self.cost.compute_changes(chosen, before, after)
        rooms = self._rooms + self._label_counts[new] - self._label_counts[old]
        violations = self.constraints.count_violations(rooms, self._labels)
        costs = self.cost.combine_terms(terms, rooms.sum(axis=1)) + VIOLATION_COST * violations
        costs[self._counts.sum(axis=1) + after - before <= self._n_fixed] = np.inf
        moved = running & accept(self.costs, costs, uniforms[:, 3])
        self.filled[moved, chosen[moved]], self._counts[moved, clusters[moved]] = new[moved], after[moved]
        self._terms[moved], self._rooms[moved] = terms[moved], rooms[moved]
        self.violations[moved], self.costs[moved] = violations[moved], costs[moved]

    def jump(self, uniforms: Floats, running: Mask) -> None:
        """Propose to refill all slots of each running chain; uniforms: shape (n, jump_draws).

        Single moves seldom lead from the configuration of one floor to that of another.
        """
        slots, clusters = self.slots, len(self.slots.areas)
        configurations = self.cost.draw_configurations(uniforms)
        if configurations is None:
            return
        filled = slots.fill(configurations, uniforms[:, 1 + 2 * clusters : -1])
        counts = slots.count_areas(filled)
        terms, rooms = self.cost.compute_terms(slots, filled), self._label_counts[filled].sum(axis=1)
        violations = self.constraints.count_violations(rooms, self._labels)
        # Configurations are drawn by e^-Γ1 without rooms and constraints, so only these decide.
        costs = self.cost.room_costs(terms, rooms.sum(axis=1)) + VIOLATION_COST * violations
        costs[(counts != configurations).any(axis=1) | (counts.sum(axis=1) <= self._n_fixed)] = np.inf
        before = self.cost.room_costs(self._terms, self._rooms.sum(axis=1)) + VIOLATION_COST * self.violations
        before[self._counts.sum(axis=1) <= self._n_fixed] = FIXED_ONLY_COST
        moved = running & accept(before, costs, uniforms[:, -1])
        self.filled[moved], self._counts[moved] = filled[moved], counts[moved]
        self._terms[moved], self._rooms[moved], self.violations[moved] = terms[moved], rooms[moved], violations[moved]
        self.costs = self._compute_costs()

    @property
    def jump_draws(self) -> int:
        """Random numbers of a jump."""
        return 2 + 2 * len(self.slots.areas) + len(self.slots.clusters)

    def _compute_costs(self) -> Floats:
        """The cost of each building; buildings with fixed areas only cost more than any other."""
        costs = self.cost.combine_terms(self._terms, self._rooms.sum(axis=1)) + VIOLATION_COST * self.violations
        costs[self._counts.sum(axis=1) <= self._n_fixed] = FIXED_ONLY_COST
        return costs

    def count_violations(self, constraints: Constraints) -> Counts:
        """Number of rooms of each building that violate constraints, shape (n,)."""
        return constraints.count_violations(self._rooms, self._labels)


def sample_areas(
    chains: AreaChains,
    generators: Sequence[np.random.Generator],
    *,
    needed: Constraints | None = None,
    traces: list[Floats] | None = None,
) -> Indices:
    """Run the chains; return the area in each slot of each building, shape (n, slots), or EMPTY.

    A sweep has a move for each free slot, and a jump. After its sweeps, a chain continues until it meets the
    constraints. needed: the constraints that it must meet, by default all. traces: receives the costs after each sweep.
    Raises ModelError if needed constraints are not met after ten times the sweeps.
    """
    slots = chains.slots
    draws, jumps = draw_uniforms(generators, DRAWS), draw_uniforms(generators, chains.jump_draws)
    running = np.ones(len(chains.filled), bool)
    for sweep in range(MAX_SWEEPS_FACTOR * slots.model.sweeps):
        if sweep >= slots.model.sweeps:
            running &= chains.violations > 0
            if not running.any():
                return chains.filled
        if sweep == slots.model.sweeps:
            # New generators, so that later draws do not depend on how long other chains run.
            generators = [generator.spawn(1)[0] for generator in generators]
            draws, jumps = draw_uniforms(generators, DRAWS), draw_uniforms(generators, chains.jump_draws)
        for _ in range(int((slots.fixed == EMPTY).sum())):
            chains.move(next(draws), running)
        chains.jump(next(jumps), running)
        if traces is not None:
            traces.append(chains.costs.copy())
    violations = chains.count_violations(chains.constraints if needed is None else needed)
    if not violations.any():
        return chains.filled
    nearest = int(violations[violations > 0].min())
    raise ModelError(
        f"no building met the constraints in {MAX_SWEEPS_FACTOR * slots.model.sweeps} sweeps, the nearest one violates "
        f"them by {nearest} room{'s' * (nearest != 1)}; relax them"
    )
