"""Metropolis-Hastings: acceptance, random numbers of chains, and how convergence is measured."""

from itertools import islice
from math import exp, inf, sqrt

import numpy as np
import pytest

from pianta.generation.metropolis_hastings import accept, choose, draw_uniforms, measure_convergence


def generators(*seeds) -> list[np.random.Generator]:
    return [np.random.default_rng(seed) for seed in seeds]


def test_the_stationary_distribution_is_boltzmann():
    costs = np.array([0.0, 1.0, 2.5])
    random = np.random.default_rng(0)
    states = np.zeros(20_000, int)
    for _ in range(60):
        proposed = (states + random.integers(1, 3, len(states))) % 3
        moved = accept(costs[states], costs[proposed], random.random(len(states)))
        states = np.where(moved, proposed, states)
    expected = np.exp(-costs) / np.exp(-costs).sum()
    np.testing.assert_allclose(np.bincount(states, minlength=3) / len(states), expected, atol=0.015)


def test_accepted_with_the_printed_probability():
    costs, proposed = np.array([1.0, 1.0, 1.0, 1.0]), np.array([3.0, 3.0, 1.0, 0.5])
    draws = np.array([exp(-2) - 1e-6, exp(-2) + 1e-6, 0.999999, 0.999999])
    assert accept(costs, proposed, draws).tolist() == [True, False, True, True]


def test_infinite_costs_are_never_accepted():
    assert not accept(np.zeros(2), np.array([inf, inf]), np.array([0.0, 0.5])).any()


def test_costs_that_differ_by_rounding_are_the_same():
    assert accept(np.array([1.0]), np.array([1 + 1e-12]), np.array([np.nextafter(1, 0)])).all()


def test_random_numbers_do_not_depend_on_other_chains():
    beside = np.array([*islice(draw_uniforms(generators(1, 2, 3), 4), 600)])
    alone = np.array([*islice(draw_uniforms(generators(2), 4), 600)])
    np.testing.assert_array_equal(beside[:, 1], alone[:, 0])
    assert beside.shape == (600, 3, 4)
    assert len(np.unique(beside)) == beside.size


def test_all_choices_are_as_likely():
    draws = np.linspace(0, 1, 3000, endpoint=False)
    chosen = choose(draws, np.full(3000, 3))
    assert np.bincount(chosen).tolist() == [1000, 1000, 1000]
    assert choose(np.array([np.nextafter(1, 0)]), np.array([7])).tolist() == [6]
    assert choose(np.array([0.5]), np.array([0])).tolist() == [0]


def test_convergence_by_hand():
    # Means 2 and 4, variance 1 within each; B = 3 * 2, W = 1: sqrt(2 / 3 + 6 / 3 / 1).
    assert measure_convergence(np.array([[1.0, 2.0, 3.0], [3.0, 4.0, 5.0]])) == pytest.approx(sqrt(2 / 3 + 2))


def test_chains_of_white_noise_have_mixed():
    noise = np.random.default_rng(0).normal(size=(4, 5000))
    assert measure_convergence(noise) == pytest.approx(1, abs=0.005)


def test_chains_apart_have_not():
    noise = np.random.default_rng(0).normal(size=(4, 5000))
    assert measure_convergence(noise + 5 * np.arange(4)[:, None]) > 2


def test_chains_that_stand_still():
    assert measure_convergence(np.ones((3, 10))) == 1
    assert measure_convergence(np.ones((3, 10)) * [[1], [1], [2]]) == inf
