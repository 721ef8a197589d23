"""Iterations until chains mix: checked for each step, and doubled at most twice if its chains do not mix."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pianta._types import Floats
from pianta.generation import train
from pianta.generation.buildings import BuildingSampler
from pianta.generation.functional_areas import Segmentation
from pianta.generation.train import CHAINS, TARGETS, count_mixing_iterations, train_type
from pianta.generation.type_model import Mixing, ModelMixing, TypeModel
from tests.generated_types import SCHOOL, build_floor, make_schools, make_wing, small_model

QUICK = replace(small_model(), sweeps=8, edge_moves=40, door_moves=10)
Runner = Callable[[BuildingSampler, int], Floats]


def make_runner(apart: Callable[[int], float], requested: list[int]) -> Runner:
    """A step whose chains are as far apart as it says for their iterations; of three targets, one has always mixed."""

    def run(sampler: BuildingSampler, seed: int) -> Floats:
        iterations = sampler.model.sweeps
        assert sampler.model.edge_moves == sampler.model.door_moves == iterations
        requested.append(iterations)
        noise = np.random.default_rng(seed).normal(size=(3, CHAINS, iterations))
        noise[1:] += apart(iterations) * np.arange(CHAINS)[:, None]
        return noise

    return run


def use_runners(monkeypatch: pytest.MonkeyPatch, runner: Runner) -> None:
    for name in ("_run_sweeps", "_run_edge_moves", "_run_door_moves"):
        monkeypatch.setattr(train, name, runner)


def test_chains_that_have_mixed_stay(monkeypatch):
    requested: list[int] = []
    use_runners(monkeypatch, make_runner(lambda _: 0.0, requested))
    result = count_mixing_iterations(replace(QUICK, sweeps=200, edge_moves=300, door_moves=400))
    assert requested == [200, 300, 400]
    assert [step.iterations for step in (result.sweeps, result.edge_moves, result.door_moves)] == requested
    assert result.sweeps.convergence == pytest.approx(1, abs=0.03)


def test_chains_that_mix_late_take_more(monkeypatch):
    requested: list[int] = []
    use_runners(monkeypatch, make_runner(lambda iterations: 5.0 * (iterations < 400), requested))
    result = count_mixing_iterations(replace(QUICK, sweeps=200, edge_moves=400, door_moves=100))
    assert requested == [200, 400, 400, 100, 200, 400]
    assert [step.iterations for step in (result.sweeps, result.edge_moves, result.door_moves)] == [400, 400, 400]


def test_chains_that_never_mix_take_four_times_as_many(monkeypatch):
    requested: list[int] = []
    use_runners(monkeypatch, make_runner(lambda _: 5.0, requested))
    result = count_mixing_iterations(replace(QUICK, sweeps=100, edge_moves=50, door_moves=30))
    assert [step.iterations for step in (result.sweeps, result.edge_moves, result.door_moves)] == [400, 200, 120]
    assert result.door_moves.convergence > 2


def test_one_target_that_has_not_mixed_is_enough(monkeypatch):
    requested: list[int] = []

    def run(sampler: BuildingSampler, seed: int) -> Floats:
        requested.append(sampler.model.sweeps)
        noise = np.random.default_rng(seed).normal(size=(3, CHAINS, sampler.model.sweeps))
        noise[2] += 5 * np.arange(CHAINS)[:, None]
        return noise

    use_runners(monkeypatch, run)
    result = count_mixing_iterations(replace(QUICK, sweeps=200, edge_moves=200, door_moves=200))
    assert requested == [200, 400, 800] * 3
    first, second, third = result.sweeps.targets
    assert max(first, second) < 1.1 < third == result.sweeps.convergence
    assert not result.sweeps.has_mixed


def test_only_the_second_half_counts(monkeypatch):
    def run(sampler: BuildingSampler, seed: int) -> Floats:
        noise = np.random.default_rng(seed).normal(size=(2, CHAINS, sampler.model.sweeps))
        noise[:, :, : sampler.model.sweeps // 2] += 100 * np.arange(CHAINS)[:, None]
        return noise

    use_runners(monkeypatch, run)
    assert count_mixing_iterations(replace(QUICK, sweeps=200)).sweeps.iterations == 200


def test_traces_of_the_steps():
    sampler = BuildingSampler(QUICK)
    sweeps = train._run_sweeps(sampler, 0)
    edges = train._run_edge_moves(sampler, 0)
    doors = train._run_door_moves(sampler, 0)
    assert (sweeps.shape, edges.shape, doors.shape) == (
        (1, CHAINS * TARGETS, 8),
        (TARGETS, CHAINS, 40),
        (TARGETS, CHAINS, 10),
    )
    assert all(np.isfinite(traces).all() for traces in (sweeps, edges, doors))
    # Chains of a target start apart, unless it has two areas, which are joined in one way.
    assert any(len(set(target_traces[:, 0])) > 1 for target_traces in edges)


@pytest.mark.slow
@pytest.mark.parametrize("segmentation", Segmentation)
def test_chains_of_the_small_schools(segmentation):
    result = count_mixing_iterations(
        replace(small_model(segmentation), sweeps=40, edge_moves=300, door_moves=60), seed=1
    )
    assert result.sweeps.convergence < 1.1
    assert result.sweeps.iterations == 40
    assert result.edge_moves.iterations in (300, 600, 1200)
    assert result.door_moves.iterations in (60, 120, 240)


def test_the_same_seed_finds_the_same():
    assert count_mixing_iterations(QUICK, seed=4) == count_mixing_iterations(QUICK, seed=4)


def test_floors_of_one_area_have_nothing_to_join():
    model = TypeModel(
        SCHOOL, Segmentation.CORR, (build_floor(("CC",), (), (0,)), build_floor(("AA",), (), (0,))), 5, 20, 10
    )
    result = count_mixing_iterations(model)
    assert (result.edge_moves, result.door_moves) == (Mixing(20), Mixing(10))


def test_a_type_is_trained_with_what_was_found(monkeypatch):
    monkeypatch.setattr(
        train,
        "count_mixing_iterations",
        lambda model, *, seed, track: ModelMixing(Mixing(seed, (1.0,)), Mixing(8, (1.0, 1.2)), Mixing(9, (1.3,))),
    )
    model = train_type(make_schools(), schema=SCHOOL, areas="ncut", seed=7)
    result = model.mixing
    assert result is not None
    assert (model.sweeps, model.edge_moves, model.door_moves) == (7, 8, 9)
    assert result.edge_moves == Mixing(8, (1.0, 1.2))
    assert result.sweeps.has_mixed
    assert not result.edge_moves.has_mixed
    assert (model.segmentation, len(model.floors)) == (Segmentation.NCUT, 8)


@pytest.mark.slow
def test_two_floors():
    model = train_type([make_wing("C"), make_wing("AAA")], schema=SCHOOL)
    result = model.mixing
    assert result is not None
    assert model.sweeps == result.sweeps.iterations >= 300
