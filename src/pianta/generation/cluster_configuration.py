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
from numpy.typing import NDArray
from scipy.special import gammaln, logsumexp

from pianta.errors import ModelError
from pianta.generation.functional_areas import Segmentation
from pianta.generation.metropolis_hastings import Flags, Floats, accept, choose, draw_uniforms
from pianta.generation.type_model import Counts, TypeModel
from pianta.generation.wishes import Wishes

Indices = NDArray[np.intp]

EMPTY = -1
# A component of a configuration is as on another floor so often.
EXCHANGE, EXCHANGE_OF_LIKE = 0.2, 0.05
# Keeps numbers of areas possible that no floor has.
LEAST_FREQUENCY = 1e-4
# Of the printed cost, for as many floors.
PRINTED_ALPHA, PRINTED_FLOORS = MappingProxyType({Segmentation.CORR: 0.0625, Segmentation.NCUT: 0.0575}), 50
# Random numbers of a move.
DRAWS = 4
# What a room too few or too many costs.
MISS_COST = 2.0
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
        return of_kept, of_kept + free @ np.array(largest)

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

    def cost(self, parts: Floats) -> Floats:
        """Γ1, shape (n,), but for a constant."""


class DensityCost:
    """Γ1 = -ln of how dense the configurations of the model's floors G lie around one.

    The density is the mean over floors of Π_i ((1 - x) [v_i = v_i^G] + x p_i(v_i)), where p_i says how often floors
    have v_i areas of cluster i, and x = 0.2. The sum of distances to all floors, in print, is least at a middle that
    most clusters are missing from. This keeps how often floors have how many areas of a cluster, and which clusters go
    together, as eq. 7.2 asks for.
    like: the configuration, shape (clusters,), that alone is near, in the place of the model's, and x = 0.05.
    """

    def __init__(self, slots: Slots, *, like: Counts | None = None) -> None:
        configurations = slots.model.configurations
        near = configurations if like is None else like[None]
        values = np.arange(slots.areas.max() + 1)
        frequencies = (configurations[:, :, None] == values).mean(axis=0) + LEAST_FREQUENCY
        exchange = EXCHANGE if like is None else EXCHANGE_OF_LIKE
        densities = np.log((1 - exchange) * (near[:, :, None] == values) + exchange * frequencies)
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

    def cost(self, parts: Floats) -> Floats:
        """See ConfigurationCost."""
        costs: Floats = -logsumexp(parts, axis=1)
        return costs


class DistanceCost:
    """Γ1 = α Σ_G d(V, V^G) of section 7.4.3: d is the Hamming distance of the slots, a floor's areas in the first ones.

    α is 0.0625 (`corr`) or 0.0575 (`ncut`) for 50 floors, and the larger the fewer there are.
    """

    def __init__(self, slots: Slots) -> None:
        model = slots.model
        used = (slots.ranks < model.configurations[:, slots.clusters]).mean(axis=0)
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

    def cost(self, parts: Floats) -> Floats:
        """See ConfigurationCost."""
        return parts[:, 0]


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
        # Where nothing is, there are no rooms: EMPTY is the last row.
        self._label_counts = np.vstack([label_counts, np.zeros(label_counts.shape[1], np.int64)])
        self._counts = slots.count_areas(filled)
        self._parts = cost.start(slots, filled)
        self._rooms = self._label_counts[filled].sum(axis=1)
        self.misses = self._count_misses(self._rooms)
        self.costs = cost.cost(self._parts) + MISS_COST * self.misses

    def move(self, uniforms: Floats, running: Flags) -> None:
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
        misses = self._count_misses(rooms)
        costs = self.cost.cost(parts) + MISS_COST * misses
        costs[self._counts.sum(axis=1) + after - before == 0] = np.inf
        moved = running & accept(self.costs, costs, uniforms[:, 3])
        self.filled[moved, chosen[moved]], self._counts[moved, clusters[moved]] = new[moved], after[moved]
        self._parts[moved], self._rooms[moved] = parts[moved], rooms[moved]
        self.misses[moved], self.costs[moved] = misses[moved], costs[moved]

    def _count_misses(self, rooms: Counts) -> Counts:
        return self.wishes.count_misses(rooms, [*self.slots.model.schema.by_name])


def sample_areas(
    chains: AreaChains, generators: Sequence[np.random.Generator], *, traces: list[Floats] | None = None
) -> Indices:
    """Run the chains: what then fills the slots of each building, shape (n, slots), EMPTY where nothing does.

    A sweep has as many moves as there are slots to fill. Where there are wishes, a chain goes on after its sweeps until
    it meets them. traces: gets the costs after each sweep.
    Raises ModelError when wishes are not met after ten times the sweeps.
    """
    slots = chains.slots
    draws = draw_uniforms(generators, DRAWS)
    running = np.ones(len(chains.filled), bool)
    for sweep in range(PATIENCE * slots.model.sweeps):
        if sweep >= slots.model.sweeps:
            running &= chains.misses > 0
            if not running.any():
                return chains.filled
        for _ in range(int((slots.fixed == EMPTY).sum())):
            chains.move(next(draws), running)
        if traces is not None:
            traces.append(chains.costs.copy())
    if not chains.misses.any():
        return chains.filled
    nearest = int(chains.misses[chains.misses > 0].min())
    raise ModelError(
        f"no building with all that is wished for was found in {PATIENCE * slots.model.sweeps} sweeps, the nearest "
        f"misses it by {nearest} room{'s' * (nearest != 1)}; wish for less"
    )
