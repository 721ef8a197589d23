"""Steps 1 and 3 of section 7.4.3: how many areas of each cluster a building has, and which.

A building has slots, as many for each cluster as a floor of the model ever needed; the cluster configuration is how
many of a cluster's are filled. Step 3 fills a slot with any of the cluster's areas, all as likely. Here a slot gets its
area when step 1 fills it, which comes to the same, and lets wishes about rooms be heard while there is still a choice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Protocol

import numpy as np
from scipy.special import gammaln, logsumexp

from pianta._types import Floats, Indices, Mask
from pianta.errors import ModelError
from pianta.generation.functional_areas import Segmentation
from pianta.generation.metropolis_hastings import accept, choose, draw_uniforms
from pianta.generation.type_model import Counts, TypeFloor, TypeModel
from pianta.generation.wishes import Wishes

EMPTY = -1
# How often a configuration has as many areas of a cluster as floors in general, not as the floor that it is near.
EXCHANGE, EXCHANGE_OF_LIKE = 0.2, 0.05
# Standard deviation of the logarithm of a building's rooms about those of a floor.
SIZE_SPREAD = 0.15
# Keeps numbers of areas possible that no floor has.
LEAST_FREQUENCY = 1e-4
# Of the printed cost, for as many floors.
PRINTED_ALPHA, PRINTED_FLOORS = MappingProxyType({Segmentation.CORR: 0.0625, Segmentation.NCUT: 0.0575}), 50
# Random numbers of a move.
DRAWS = 4
# What a room too few or too many costs.
MISS_COST = 2.0
LAST_RESORT = 1e9
# After so many times the iterations of a chain, wishes are taken to be impossible.
PATIENCE = 10


@dataclass(frozen=True, eq=False)
class Slots:
    """Where areas can be, and the areas that can be there.

    areas: the number of slots of each cluster, shape (clusters,). kept: areas that fill the first slots of their
    clusters for good, by cluster; they are numbered on from the model's.
    """

    model: TypeModel
    areas: Counts
    kept: tuple[tuple[int, ...], ...]

    @cached_property
    def clusters(self) -> Indices:
        """The cluster of each slot, shape (slots,)."""
        return np.repeat(np.arange(len(self.areas)), self.areas)

    @cached_property
    def ranks(self) -> Indices:
        """The place of each slot among those of its cluster, shape (slots,)."""
        return np.arange(len(self.clusters)) - np.repeat(np.cumsum(self.areas) - self.areas, self.areas)

    @cached_property
    def fixed(self) -> Indices:
        """What fills each slot for good, shape (slots,), or EMPTY."""
        filled = np.full(len(self.clusters), EMPTY, np.intp)
        for cluster, areas in enumerate(self.kept):
            filled[np.flatnonzero(self.clusters == cluster)[: len(areas)]] = areas
        return filled

    @cached_property
    def members(self) -> tuple[Indices, Indices]:
        """Areas by cluster, shape (clusters, most of one), each row filled up, and how many there are of each."""
        sizes = np.bincount(self.model.clusters, minlength=len(self.areas))
        table = np.zeros((len(sizes), int(sizes.max())), np.intp)
        for cluster, size in enumerate(sizes):
            table[cluster, :size] = np.flatnonzero(self.model.clusters == cluster)
        return table, sizes

    def bound_rooms(self, label_counts: Counts) -> tuple[Counts, Counts]:
        """The fewest and the most rooms of each kind that filled slots can have, shape (kinds,) each.

        label_counts: rooms of each kind in each area, kept ones included, shape (areas, kinds).
        """
        of_kept = label_counts[self.fixed[self.fixed != EMPTY]].sum(axis=0)
        free = np.bincount(self.clusters[self.fixed == EMPTY], minlength=len(self.areas))
        of_model = label_counts[: len(self.model.clusters)]
        largest = [of_model[self.model.clusters == cluster].max(axis=0) for cluster in range(len(self.areas))]
        # One area at least is not kept.
        return of_kept + of_model.min(axis=0), of_kept + free @ np.array(largest)

    def count_areas(self, filled: Indices) -> Counts:
        """Cluster configurations, shape (n, clusters), of what fills the slots, shape (n, slots)."""
        counts = np.zeros((len(self.areas), len(filled)), np.int64)
        np.add.at(counts, self.clusters, (filled != EMPTY).T)
        return counts.T

    def fill(self, configurations: Counts, draws: Floats) -> Indices:
        """Slots filled as configurations say, shape (n, slots), in each the kept area or any one of its cluster."""
        table, sizes = self.members
        chosen = table[self.clusters, choose(draws, sizes[self.clusters])]
        filled = np.where(self.ranks < configurations[:, self.clusters], chosen, EMPTY)
        return np.where(self.fixed == EMPTY, filled, self.fixed)


class ConfigurationCost(Protocol):
    """Γ1 of cluster configurations, α included, brought up to date slot by slot."""

    def start(self, slots: Slots, filled: Indices) -> Floats:
        """Parts of the cost of filled slots, shape (n, parts)."""

    def gain(self, slots: Indices, before: Counts, after: Counts) -> Floats:
        """What the parts gain when one slot of each is flipped, by the areas of its cluster before and after."""

    def cost(self, parts: Floats, rooms: Counts) -> Floats:
        """Γ1, shape (n,), but for a constant, of buildings with so many rooms, shape (n,)."""

    def draw(self, uniforms: Floats) -> Counts | None:
        """Configurations, shape (n, clusters), by e^-Γ1 where rooms do not count; None when that takes a chain.

        uniforms: shape (n, 1 + 2 clusters).
        """

    def weigh_rooms(self, parts: Floats, rooms: Counts) -> Floats:
        """What of Γ1 is because of the number of rooms, shape (n,)."""


class DensityCost:
    """Γ1 = -ln of how dense the configurations of the model's floors G lie around one.

    The density is the mean over floors of Π_i ((1 - x) [v_i = v_i^G] + x p_i(v_i)), where p_i says how often floors
    have v_i areas of cluster i, and x = 0.2. The sum of distances to all floors, in print, is least at a middle that
    most clusters are missing from. This keeps how often floors have how many areas of a cluster, and which clusters go
    together, as eq. 7.2 asks for. A floor's part falls with exp(-ln²(n / n^G) / 2 s²), too, where n are the rooms of
    the building, n^G those of the floor, and s = 0.15: large areas that come together by chance would make buildings
    vary more in size than floors do.
    like: the floor that alone is near, in the place of those of the model, and x = 0.05. rooms: the fewest and the most
    that are wished for, which floors with fewer or more count as having.
    """

    def __init__(self, slots: Slots, *, like: TypeFloor | None = None, rooms: tuple[int, int] | None = None) -> None:
        configurations = slots.model.configurations
        floors = slots.model.floors if like is None else [like]
        near = np.array([slots.model.configure(floor) for floor in floors])
        self._sizes = np.log(np.clip([len(floor.graph) for floor in floors], *(rooms or (1, None))))
        self._near, self._exchange = near, EXCHANGE if like is None else EXCHANGE_OF_LIKE
        values = np.arange(slots.areas.max() + 1)
        frequencies = (configurations[:, :, None] == values).mean(axis=0) + LEAST_FREQUENCY
        frequencies = np.where(values <= slots.areas[:, None], frequencies, 0)
        self._frequencies = frequencies / frequencies.sum(axis=1, keepdims=True)
        densities = (1 - self._exchange) * (near[:, :, None] == values) + self._exchange * self._frequencies
        # No slots are there for more.
        densities = np.log(np.maximum(densities, LEAST_FREQUENCY * self._exchange))
        # All the ways to fill so many of the slots are one configuration.
        kept = np.array([len(areas) for areas in slots.kept])[:, None]
        chosen = np.maximum(values - kept, 0)
        free = np.maximum(slots.areas[:, None] - kept, chosen)
        ways = gammaln(free + 1) - gammaln(chosen + 1) - gammaln(free - chosen + 1)
        self._densities = np.moveaxis(densities - ways, 0, 2)
        self._clusters = slots.clusters

    def start(self, slots: Slots, filled: Indices) -> Floats:
        """Logarithms of the parts of the mixture, shape (n, floors)."""
        configurations = slots.count_areas(filled)
        parts: Floats = self._densities[np.arange(configurations.shape[1]), configurations].sum(axis=1)
        return parts

    def gain(self, slots: Indices, before: Counts, after: Counts) -> Floats:
        """See ConfigurationCost."""
        clusters = self._clusters[slots]
        gains: Floats = self._densities[clusters, after] - self._densities[clusters, before]
        return gains

    def cost(self, parts: Floats, rooms: Counts) -> Floats:
        """See ConfigurationCost."""
        beside = np.log(np.maximum(rooms, 1))[:, None] - self._sizes
        costs: Floats = -logsumexp(parts - beside**2 / (2 * SIZE_SPREAD**2), axis=1)
        return costs

    def draw(self, uniforms: Floats) -> Counts | None:
        """See ConfigurationCost."""
        clusters = self._near.shape[1]
        of_floor = self._near[choose(uniforms[:, 0], np.full(len(uniforms), len(self._near)))]
        bounds = np.cumsum(self._frequencies, axis=1)[:, :-1]
        of_any = (uniforms[:, 1 + clusters : 1 + 2 * clusters, None] >= bounds).sum(axis=2)
        return np.where(uniforms[:, 1 : 1 + clusters] < self._exchange, of_any, of_floor)

    def weigh_rooms(self, parts: Floats, rooms: Counts) -> Floats:
        """See ConfigurationCost."""
        weights: Floats = self.cost(parts, rooms) + logsumexp(parts, axis=1)
        return weights


class DistanceCost:
    """Γ1 = α Σ_G d(V, V^G) of section 7.4.3: d is the Hamming distance of the slots, a floor's areas in the first ones.

    α is 0.0625 (`corr`) or 0.0575 (`ncut`) for 50 floors, and the larger the fewer there are.
    like: the floor that alone counts, in the place of those of the model.
    """

    def __init__(self, slots: Slots, *, like: TypeFloor | None = None) -> None:
        model = slots.model
        near = model.configurations if like is None else model.configure(like)[None]
        used = (slots.ranks < near[:, slots.clusters]).mean(axis=0)
        # Floors that differ from a slot when it is filled, less those that differ when it is empty.
        self._gains = PRINTED_ALPHA[model.segmentation] * PRINTED_FLOORS * (1 - 2 * used)
        self._empty = PRINTED_ALPHA[model.segmentation] * PRINTED_FLOORS * used.sum()

    def start(self, slots: Slots, filled: Indices) -> Floats:  # noqa: ARG002 - the other cost looks them up
        """The cost itself, shape (n, 1)."""
        costs: Floats = self._empty + ((filled != EMPTY) * self._gains).sum(axis=1, keepdims=True)
        return costs

    def gain(self, slots: Indices, before: Counts, after: Counts) -> Floats:
        """See ConfigurationCost."""
        gains: Floats = (self._gains[slots] * (after - before))[:, None]
        return gains

    def cost(self, parts: Floats, rooms: Counts) -> Floats:  # noqa: ARG002 - the other cost looks at them
        """See ConfigurationCost."""
        return parts[:, 0]

    def draw(self, uniforms: Floats) -> Counts | None:  # noqa: ARG002 - the other cost can
        """See ConfigurationCost."""
        return None

    def weigh_rooms(self, parts: Floats, rooms: Counts) -> Floats:  # noqa: ARG002 - the other cost has rooms
        """See ConfigurationCost."""
        return np.zeros(len(rooms))


class AreaChains:
    """The chains of step 1, one for each building, side by side.

    filled: the area in each slot, shape (n, slots). wishes: what buildings must have, for `label_counts`, the rooms of
    each label in each area, kept ones included.
    """

    def __init__(
        self, slots: Slots, cost: ConfigurationCost, filled: Indices, *, wishes: Wishes, label_counts: Counts
    ) -> None:
        self.slots, self.cost, self.wishes = slots, cost, wishes
        self.filled = filled
        self._labels = [*slots.model.schema.by_name]
        # Where nothing is, there are no rooms: EMPTY is the last row.
        self._label_counts = np.vstack([label_counts, np.zeros(label_counts.shape[1], np.int64)])
        self._counts = slots.count_areas(filled)
        self._parts = cost.start(slots, filled)
        self._rooms = self._label_counts[filled].sum(axis=1)
        self.misses = self.count_misses(wishes)
        self._kept = int((slots.fixed != EMPTY).sum())
        self.costs = self._price()

    def move(self, uniforms: Floats, running: Mask) -> None:
        """Flip or exchange a slot of each running chain, shape (n,), or leave it; uniforms: shape (n, DRAWS)."""
        slots, every = self.slots, np.arange(len(self.filled))
        free = np.flatnonzero(slots.fixed == EMPTY)
        chosen = free[choose(uniforms[:, 0], np.full(len(every), len(free)))]
        clusters, old = slots.clusters[chosen], self.filled[every, chosen]
        table, sizes = slots.members
        picked = table[clusters, choose(uniforms[:, 1], sizes[clusters])]
        # T1: one component, chosen at random, becomes larger or smaller by one.
        new = np.where(old == EMPTY, picked, EMPTY)
        if self.wishes:
            # Half of the time another area of the same cluster.
            exchanges = uniforms[:, 2] < 1 / 2
            new = np.where(exchanges, np.where(old == EMPTY, EMPTY, picked), new)
        before = self._counts[every, clusters]
        after = before + (new != EMPTY) - (old != EMPTY)
        parts = self._parts + self.cost.gain(chosen, before, after)
        rooms = self._rooms + self._label_counts[new] - self._label_counts[old]
        misses = self.wishes.count_misses(rooms, self._labels)
        costs = self.cost.cost(parts, rooms.sum(axis=1)) + MISS_COST * misses
        costs[self._counts.sum(axis=1) + after - before <= self._kept] = np.inf
        moved = running & accept(self.costs, costs, uniforms[:, 3])
        self.filled[moved, chosen[moved]], self._counts[moved, clusters[moved]] = new[moved], after[moved]
        self._parts[moved], self._rooms[moved] = parts[moved], rooms[moved]
        self.misses[moved], self.costs[moved] = misses[moved], costs[moved]

    def jump(self, uniforms: Floats, running: Mask) -> None:
        """Fill all slots of each running chain anew, or leave them; uniforms: shape (n, jump_draws).

        Single steps seldom lead from what is near one floor to what is near another.
        """
        slots, clusters = self.slots, len(self.slots.areas)
        configurations = self.cost.draw(uniforms)
        if configurations is None:
            return
        filled = slots.fill(configurations, uniforms[:, 1 + 2 * clusters : -1])
        counts = slots.count_areas(filled)
        parts, rooms = self.cost.start(slots, filled), self._label_counts[filled].sum(axis=1)
        misses = self.wishes.count_misses(rooms, self._labels)
        # As configurations are drawn by e^-Γ1 but for rooms and wishes, only these decide.
        costs = self.cost.weigh_rooms(parts, rooms.sum(axis=1)) + MISS_COST * misses
        costs[(counts != configurations).any(axis=1) | (counts.sum(axis=1) <= self._kept)] = np.inf
        before = self.cost.weigh_rooms(self._parts, self._rooms.sum(axis=1)) + MISS_COST * self.misses
        before[self._counts.sum(axis=1) <= self._kept] = LAST_RESORT
        moved = running & accept(before, costs, uniforms[:, -1])
        self.filled[moved], self._counts[moved] = filled[moved], counts[moved]
        self._parts[moved], self._rooms[moved], self.misses[moved] = parts[moved], rooms[moved], misses[moved]
        self.costs = self._price()

    @property
    def jump_draws(self) -> int:
        """Random numbers of a jump."""
        return 2 + 2 * len(self.slots.areas) + len(self.slots.clusters)

    def _price(self) -> Floats:
        """What each building costs; one of nothing but kept areas costs more than any other."""
        costs = self.cost.cost(self._parts, self._rooms.sum(axis=1)) + MISS_COST * self.misses
        costs[self._counts.sum(axis=1) <= self._kept] = LAST_RESORT
        return costs

    def count_misses(self, wishes: Wishes) -> Counts:
        """How many rooms each building has too many or too few for wishes, shape (n,)."""
        return wishes.count_misses(self._rooms, self._labels)


def sample_areas(
    chains: AreaChains,
    generators: Sequence[np.random.Generator],
    *,
    needed: Wishes | None = None,
    traces: list[Floats] | None = None,
) -> Indices:
    """Run the chains: what then fills the slots of each building, shape (n, slots), EMPTY where nothing does.

    A sweep has as many moves as there are slots to fill, and a jump. Where there are wishes, a chain goes on after its
    sweeps until it meets them. needed: those of the wishes that it has to meet, all unless given. traces: gets the
    costs after each sweep.
    Raises ModelError when needed wishes are not met after ten times the sweeps.
    """
    slots = chains.slots
    draws, jumps = draw_uniforms(generators, DRAWS), draw_uniforms(generators, chains.jump_draws)
    running = np.ones(len(chains.filled), bool)
    for sweep in range(PATIENCE * slots.model.sweeps):
        if sweep >= slots.model.sweeps:
            running &= chains.misses > 0
            if not running.any():
                return chains.filled
        if sweep == slots.model.sweeps:
            # How long others go on is no matter to what a chain draws later.
            generators = [generator.spawn(1)[0] for generator in generators]
            draws, jumps = draw_uniforms(generators, DRAWS), draw_uniforms(generators, chains.jump_draws)
        for _ in range(int((slots.fixed == EMPTY).sum())):
            chains.move(next(draws), running)
        chains.jump(next(jumps), running)
        if traces is not None:
            traces.append(chains.costs.copy())
    misses = chains.count_misses(chains.wishes if needed is None else needed)
    if not misses.any():
        return chains.filled
    nearest = int(misses[misses > 0].min())
    raise ModelError(
        f"no building with all that is wished for was found in {PATIENCE * slots.model.sweeps} sweeps, the nearest "
        f"misses it by {nearest} room{'s' * (nearest != 1)}; wish for less"
    )
