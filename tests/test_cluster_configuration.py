"""Step 1: its chains have the exact distribution, with any constraints and fixed rooms."""

from collections import Counter
from dataclasses import replace
from functools import partial
from itertools import product
from math import comb, exp, log, prod

import numpy as np
import pytest

from pianta._types import Indices
from pianta.errors import ModelError
from pianta.generation.cluster_configuration import (
    DRAWS,
    EMPTY,
    MIN_FREQUENCY,
    P_ANY_FLOOR,
    P_ANY_FLOOR_IF_SIMILAR,
    SIZE_DEVIATION,
    VIOLATION_COST,
    AreaChains,
    DensityCost,
    DistanceCost,
    Slots,
    sample_areas,
)
from pianta.generation.constraints import Constraints
from pianta.generation.functional_areas import Segmentation
from pianta.generation.metropolis_hastings import BLOCK
from pianta.generation.type_model import Counts, TypeModel, count_labels
from tests.generated_types import SCHOOL, build_floor

CHAINS, MOVES, JUMPS = 4000, 600, 150
# Configurations (2, 1), (1, 0), (0, 2) and (1, 1): two slots of each cluster.
FLOORS = (
    build_floor(("CCC", "CC", "AA"), ((0, 1), (1, 2)), (0, 0, 1)),
    build_floor(("CCCC",), (), (0,)),
    build_floor(("AA", "A"), ((0, 1),), (1, 1)),
    build_floor(("CC", "AAA"), ((0, 1),), (0, 1)),
)
CONFIGURATIONS = [(2, 1), (1, 0), (0, 2), (1, 1)]
MODEL = TypeModel(SCHOOL, Segmentation.CORR, FLOORS)
FIXED = build_floor(("CCCCC",), (), (0,))


def make_slots(*, areas=(2, 2), fixed_areas=()) -> Slots:
    return Slots(MODEL, np.array(areas), (tuple(fixed_areas), ()))


def count_rooms(*fixed_areas) -> Counts:
    return count_labels([*MODEL.areas, *(area for floor in fixed_areas for area in floor.area_graphs)], SCHOOL)


def run(slots, cost, *, constraints=None, label_counts=None, jumps=0) -> AreaChains:
    """Chains that all start at the first floor, after their moves, or after `jumps` jumps."""
    starts = slots.fill(np.full((CHAINS, 2), CONFIGURATIONS[0]), np.zeros((CHAINS, len(slots.clusters))))
    counts = count_rooms() if label_counts is None else label_counts
    chains = AreaChains(slots, cost, starts, constraints=constraints or Constraints(), label_counts=counts)
    random = np.random.default_rng(1)
    running = np.ones(CHAINS, bool)
    for _ in range(0 if jumps else MOVES):
        chains.move(random.random((CHAINS, DRAWS)), running)
    for _ in range(jumps):
        chains.jump(random.random((CHAINS, chains.jump_draws)), running)
    return chains


def assert_distribution(chains, weights) -> None:
    """The frequencies of configurations and violations of constraints are proportional to the weights."""
    result = np.column_stack([chains.slots.count_areas(chains.filled), chains.violations])
    counts = Counter(map(tuple, result.tolist()))
    assert counts.keys() <= weights.keys()
    total = sum(weights.values())
    differences = [abs(counts[key] / len(result) - weight / total) for key, weight in weights.items()]
    assert max(differences) < 0.025


def density_weight(filled, rooms, *, near=FLOORS, exchange=P_ANY_FLOOR) -> float:
    """e^-Γ1 by the formula in the docstring of DensityCost; filled: whether each slot is filled."""
    values = count_filled(filled)
    weight = 0.0
    for floor in near:
        size = log(rooms / len(floor.graph))
        part = exp(-(size**2) / (2 * SIZE_DEVIATION**2))
        for cluster, value in enumerate(values):
            frequency = np.mean([configuration[cluster] == value for configuration in CONFIGURATIONS]) + MIN_FREQUENCY
            part *= (1 - exchange) * (floor.clusters.count(cluster) == value) + exchange * frequency
        weight += part
    return weight


def distance_weight(filled, rooms=0) -> float:
    """e^-Γ1 of the printed cost; filled: whether each slot is filled."""
    slots = [[value > rank for value in configuration for rank in range(2)] for configuration in CONFIGURATIONS]
    distances = [sum(a != b for a, b in zip(filled, floor_slots, strict=True)) for floor_slots in slots]
    return exp(-0.0625 * 50 / 4 * sum(distances))


def count_filled(filled) -> tuple[int, int]:
    """Areas of both clusters; the last two slots are of the second."""
    return sum(filled[:-2]), sum(filled[-2:])


def enumerate_all(
    weight_of, *, label_counts=None, first=2, fixed_areas=(), constraints=None, ways=True
) -> Counter[tuple[int, ...]]:
    """The exact weight of each configuration and number of violations, over all ways to fill the slots with areas.

    first: slots of the first cluster; there are two of the second.
    """
    counts = np.vstack([count_rooms() if label_counts is None else label_counts, 0 * count_rooms()[:1]])
    areas = [[EMPTY, *np.flatnonzero(MODEL.clusters == cluster).tolist()] for cluster in range(2)]
    slots = [*[areas[0]] * first, areas[1], areas[1]]
    for position, area in enumerate(fixed_areas):
        slots[position] = [area]
    weights: Counter[tuple[int, ...]] = Counter()
    for areas_of_slots in product(*slots):
        filled = [area != EMPTY for area in areas_of_slots]
        if not any(filled):
            continue
        rooms = counts[list(areas_of_slots)].sum(axis=0)
        violations = int((constraints or Constraints()).count_violations(rooms[None], [*SCHOOL.by_name])[0])
        # Step 3: all areas of a cluster are equally likely; all ways to fill equally many slots are one configuration.
        choices = prod(len(slots[position]) - 1 for position in range(len(fixed_areas), len(slots)) if filled[position])
        if ways:
            one, other = count_filled(filled)
            choices *= comb(first - len(fixed_areas), one - len(fixed_areas)) * comb(2, other)
        weights[*count_filled(filled), violations] += (
            weight_of(filled, rooms.sum()) / choices * exp(-VIOLATION_COST * violations)
        )
    return weights


@pytest.mark.slow
@pytest.mark.parametrize("jumps", [0, JUMPS])
def test_density_by_enumeration(jumps):
    slots = make_slots()
    assert_distribution(run(slots, DensityCost(slots), jumps=jumps), enumerate_all(density_weight))


@pytest.mark.slow
@pytest.mark.parametrize("jumps", [0, JUMPS])
def test_density_near_one_floor(jumps):
    slots, near = make_slots(), FLOORS[3]
    weights = enumerate_all(partial(density_weight, near=[near], exchange=P_ANY_FLOOR_IF_SIMILAR))
    assert_distribution(run(slots, DensityCost(slots, similar_to=near), jumps=jumps), weights)
    assert weights[1, 1, 0] / sum(weights.values()) > 0.6


@pytest.mark.slow
@pytest.mark.parametrize("jumps", [0, JUMPS])
def test_density_beside_fixed_areas(jumps):
    number = len(MODEL.areas)
    slots = make_slots(areas=(3, 2), fixed_areas=[number])
    chains = run(slots, DensityCost(slots), label_counts=count_rooms(FIXED), jumps=jumps)
    assert (chains.filled[:, 0] == number).all()
    assert (chains.filled[:, 1:] != number).all()
    exact = enumerate_all(density_weight, label_counts=count_rooms(FIXED), first=3, fixed_areas=[number])
    # The fixed area is never the whole building.
    del exact[1, 0, 0]
    assert_distribution(chains, exact)


@pytest.mark.slow
def test_printed_distance_by_enumeration():
    slots = make_slots()
    assert_distribution(run(slots, DistanceCost(slots)), enumerate_all(distance_weight, ways=False))


def test_alpha_is_of_the_segmentation():
    slots = Slots(replace(MODEL, segmentation=Segmentation.NCUT), np.array([2, 2]), ((), ()))
    filled = np.array([[0, 1, EMPTY, EMPTY], [0, EMPTY, EMPTY, EMPTY]])
    cost = DistanceCost(slots)
    # Hamming distances 1, 1, 4, 2 and 2, 0, 3, 1.
    costs = cost.combine_terms(cost.compute_terms(slots, filled), np.array([7, 4]))
    np.testing.assert_allclose(costs, 0.0575 * 50 / 4 * np.array([8, 6]))
    # Distances to the last floor only: 2 and 1.
    cost = DistanceCost(slots, similar_to=FLOORS[3])
    costs = cost.combine_terms(cost.compute_terms(slots, filled), np.array([7, 4]))
    np.testing.assert_allclose(costs, 0.0575 * 50 * np.array([2, 1]))


@pytest.mark.slow
@pytest.mark.parametrize(
    "constraints", [Constraints(rooms=(7, 9)), Constraints(at_least={"classroom": 5}, at_most={"corridor": 2})]
)
def test_constraints_by_enumeration(constraints):
    slots = make_slots()
    exact = enumerate_all(density_weight, constraints=constraints)
    assert_distribution(run(slots, DensityCost(slots), constraints=constraints), exact)
    assert_distribution(run(slots, DensityCost(slots), constraints=constraints, jumps=JUMPS), exact)
    weights = enumerate_all(distance_weight, constraints=constraints, ways=False)
    assert_distribution(run(slots, DistanceCost(slots), constraints=constraints), weights)


@pytest.mark.slow
def test_areas_of_a_cluster_are_equally_likely():
    slots = make_slots()
    first = run(slots, DistanceCost(slots)).filled[:, 0]
    counts = Counter(first[first != EMPTY].tolist())
    assert counts.keys() == set(np.flatnonzero(MODEL.clusters == 0).tolist())
    assert max(counts.values()) / min(counts.values()) < 1.2


@pytest.mark.slow
@pytest.mark.parametrize("jumps", [0, 20])
def test_costs_and_violations_are_kept_up_to_date(jumps):
    slots, constraints = make_slots(), Constraints(rooms=(7, 9))
    chains = run(slots, DensityCost(slots), constraints=constraints, jumps=jumps)
    again = AreaChains(slots, DensityCost(slots), chains.filled, constraints=constraints, label_counts=count_rooms())
    np.testing.assert_allclose(chains.costs, again.costs, atol=1e-9)
    np.testing.assert_array_equal(chains.violations, again.violations)


def test_chains_that_do_not_run_stay():
    slots = make_slots()
    starts = slots.fill(np.array([[2, 1], [2, 1]]), np.zeros((2, 4)))
    chains = AreaChains(slots, DensityCost(slots), starts.copy(), constraints=Constraints(), label_counts=count_rooms())
    random = np.random.default_rng(0)
    for _ in range(50):
        chains.move(random.random((2, DRAWS)), np.array([True, False]))
        chains.jump(random.random((2, chains.jump_draws)), np.array([True, False]))
    np.testing.assert_array_equal(chains.filled[1], starts[1])
    assert (chains.filled[0] != starts[0]).any()


def test_slots_by_hand():
    slots = Slots(MODEL, np.array([3, 2]), ((), (7,)))
    assert slots.clusters.tolist() == [0, 0, 0, 1, 1]
    assert slots.ranks.tolist() == [0, 1, 2, 0, 1]
    assert slots.fixed.tolist() == [EMPTY, EMPTY, EMPTY, 7, EMPTY]
    # Cluster 0: the first two slots, with its first and its last area; cluster 1: only the fixed area.
    assert slots.fill(np.array([[2, 1]]), np.array([[0.0, 0.99, 0.5, 0.0, 0.0]])).tolist() == [
        [0, int(np.flatnonzero(MODEL.clusters == 0)[-1]), EMPTY, 7, EMPTY]
    ]


def test_bounds_of_rooms():
    slots = make_slots(fixed_areas=[len(MODEL.areas)])
    counts = count_rooms(FIXED)
    fewest, most = slots.bound_rooms(np.column_stack([counts, counts.sum(axis=1)]))
    columns = [*SCHOOL.by_name]
    classroom, office = columns.index("CLASSROOM"), columns.index("SMALL ADMINISTRATIVE")
    # Fixed: a corridor and 5 classrooms, beside an area of 2 rooms or more. A slot of cluster 0 is free for
    # 4 more classrooms, two of cluster 1 for 3 offices each.
    assert (fewest[classroom], most[classroom]) == (5, 9)
    assert (fewest[office], most[office]) == (0, 6)
    assert (fewest[-1], most[-1]) == (6 + 2, 6 + 5 + 4 + 4)


def sample(constraints, *, seeds=range(5), sweeps=5) -> tuple[Indices, list[float]]:
    slots = Slots(replace(MODEL, sweeps=sweeps), np.array([2, 2]), ((), ()))
    starts = slots.fill(np.tile([1, 1], (len(seeds), 1)), np.full((len(seeds), 4), 0.5))
    chains = AreaChains(slots, DensityCost(slots), starts, constraints=constraints, label_counts=count_rooms())
    generators = [np.random.default_rng(seed) for seed in seeds]
    return sample_areas(chains, generators), [generator.random() for generator in generators]


def test_constraints_are_met():
    rooms = np.vstack([count_rooms(), 0 * count_rooms()[:1]]).sum(axis=1)
    filled, _ = sample(Constraints(rooms=(12, 12)), seeds=range(30))
    assert rooms[filled].sum(axis=1).tolist() == [12] * 30


def test_constraints_that_no_chain_meets():
    # The largest area has 4 classrooms.
    message = "50 sweeps"
    with pytest.raises(ModelError, match=message):
        sample(Constraints(at_least={"classroom": 5}, at_most={"corridor": 1}))


@pytest.mark.slow
def test_without_constraints_all_sweeps_run():
    slots = make_slots()
    starts = slots.fill(np.full((40, 2), CONFIGURATIONS[0]), np.zeros((40, 4)))
    chains = AreaChains(slots, DensityCost(slots), starts.copy(), constraints=Constraints(), label_counts=count_rooms())
    traces: list[np.ndarray] = []
    filled = sample_areas(chains, [np.random.default_rng(seed) for seed in range(40)], traces=traces)
    assert len(traces) == MODEL.sweeps
    assert traces[-1].shape == (40,)
    np.testing.assert_array_equal(traces[-1], chains.costs)
    assert (filled != starts).any(axis=1).mean() > 0.5


@pytest.mark.slow
def test_the_duration_of_other_chains_changes_nothing():
    # After 64 sweeps of 4 moves a block of random numbers is used up, and some chains continue.
    constraints = Constraints(rooms=(13, 13))
    together = sample(constraints, seeds=range(12), sweeps=BLOCK // 4)
    for seed in range(12):
        alone = sample(constraints, seeds=[seed], sweeps=BLOCK // 4)
        np.testing.assert_array_equal(together[0][seed], alone[0][0])
        assert together[1][seed] == alone[1][0]


@pytest.mark.slow
def test_a_building_is_never_empty():
    slots = Slots(MODEL, np.array([1, 0]), ((), ()))
    starts = slots.fill(np.array([[1, 0]] * 50), np.zeros((50, 1)))
    chains = AreaChains(slots, DensityCost(slots), starts, constraints=Constraints(), label_counts=count_rooms())
    filled = sample_areas(chains, [np.random.default_rng(seed) for seed in range(50)])
    assert (filled != EMPTY).all()


def test_every_slot_is_fixed():
    number = len(MODEL.areas)
    slots = Slots(MODEL, np.array([1, 0]), ((number,), ()))
    filled = slots.fill(np.array([[1, 0]]), np.zeros((1, 1)))
    chains = AreaChains(slots, DensityCost(slots), filled, constraints=Constraints(), label_counts=count_rooms(FIXED))
    assert sample_areas(chains, [np.random.default_rng(0)]).tolist() == [[number]]
