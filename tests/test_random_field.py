"""Belief propagation and the random field over rooms."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta._types import Floats
from pianta.rooms.random_field import Edges, Neighbourhood, RandomField, fit_random_field, propagate_beliefs

NO_EDGES = np.zeros((0, 2), int)


def enumerate_marginals(unary: Floats, pairs: Edges, pairwise: Floats) -> Floats:
    """Marginals by summing over all labellings."""
    count, labels = unary.shape
    marginals = np.zeros((count, labels))
    for labelling in product(range(labels), repeat=count):
        energy = sum(unary[i, label] for i, label in enumerate(labelling))
        energy += sum(
            table[labelling[one], labelling[other]] for (one, other), table in zip(pairs, pairwise, strict=True)
        )
        for i, label in enumerate(labelling):
            marginals[i, label] += np.exp(energy)
    return np.asarray(marginals / marginals.sum(axis=1, keepdims=True))


def test_two_rooms_by_hand():
    # Weights 3:1 and 1:1; the pair doubles when labels differ: 3·1, 3·2, 1·2, 1·1 of 12.
    unary = np.log([[3.0, 1.0], [1.0, 1.0]])
    pairwise = np.log([[[1.0, 2.0], [2.0, 1.0]]])
    marginals = propagate_beliefs(unary, np.array([[0, 1]]), pairwise)
    assert marginals == pytest.approx(np.array([[9 / 12, 3 / 12], [5 / 12, 7 / 12]]), abs=1e-5)


@pytest.mark.slow
@given(st.integers(0, 10_000))
def test_exact_on_trees(seed):
    rng = np.random.default_rng(seed)
    unary = rng.normal(0, 2, (5, 3))
    pairs = np.array([[rng.integers(child), child] for child in range(1, 5)])
    pairwise = rng.normal(0, 1, (4, 3, 3))
    expected = enumerate_marginals(unary, pairs, pairwise)
    assert propagate_beliefs(unary, pairs, pairwise) == pytest.approx(expected, abs=1e-4)


def test_close_on_a_loop():
    rng = np.random.default_rng(3)
    unary, pairs = rng.normal(0, 1, (4, 2)), np.array([[0, 1], [1, 2], [2, 3], [0, 3]])
    pairwise = rng.normal(0, 0.5, (4, 2, 2))
    assert propagate_beliefs(unary, pairs, pairwise) == pytest.approx(
        enumerate_marginals(unary, pairs, pairwise), abs=0.05
    )


def test_rooms_without_neighbours_keep_their_probabilities():
    probabilities = np.array([[0.7, 0.2, 0.06, 0.04], [0.1, 0.1, 0.1, 0.7]])
    field = RandomField(np.zeros((4, 4)), np.zeros((4, 4)), door_strength=1.0, alike_strength=1.0)
    near = Neighbourhood(NO_EDGES, NO_EDGES, np.zeros(0))
    assert field.compute_marginals(probabilities, near) == pytest.approx(probabilities)


def test_no_rooms():
    near = Neighbourhood(NO_EDGES, NO_EDGES, np.zeros(0))
    assert RandomField(np.zeros((4, 4)), np.zeros((4, 4))).compute_marginals(np.zeros((0, 4)), near).shape == (0, 4)


def test_fit_learns_what_doors_join():
    """Rooms of which the classifier knows nothing, but that a door always joins a room of label 0 to one of label 1."""
    count = 200
    truth = np.tile([0, 1], count // 2)
    probabilities = np.full((count, 2), 0.5)
    probabilities[::2] = (0.9, 0.1)
    doors = np.arange(count).reshape(-1, 2)
    field = fit_random_field(probabilities, truth, Neighbourhood(doors, NO_EDGES, np.zeros(0)), np.ones(count))
    marginals = field.compute_marginals(probabilities, Neighbourhood(doors, NO_EDGES, np.zeros(0)))
    assert field.doors[0, 1] > 0 > field.doors[0, 0]
    assert (marginals.argmax(axis=1) == truth).all()


def test_fit_tempers_a_classifier_that_is_too_confident():
    """It says 0.99 and is right in seven cases of ten."""
    truth = np.tile([0] * 7 + [1] * 3, 40)
    probabilities = np.tile([0.99, 0.01], (len(truth), 1))
    near = Neighbourhood(NO_EDGES, NO_EDGES, np.zeros(0))
    field = fit_random_field(probabilities, truth, near, np.ones(len(truth)))
    assert field.temperature > 2
    assert field.compute_marginals(probabilities, near)[0, 0] < 0.85


def test_fit_weighs_rooms_and_pairs():
    """Doors between labels 0 and 1 count 3, those between equal labels 1: as if there were three of the former."""
    truth = np.array([0, 1, 0, 0, 1, 1])
    probabilities = np.array([[0.8, 0.2], [0.3, 0.7], [0.6, 0.4], [0.9, 0.1], [0.2, 0.8], [0.6, 0.4]])
    pairs = np.arange(6).reshape(-1, 2)
    weighted = fit_random_field(
        probabilities, truth, Neighbourhood(pairs, NO_EDGES, np.zeros(0)), np.array([3.0, 3.0, 1.0, 1.0, 1.0, 1.0])
    )
    repeated = np.array([0, 1, 0, 1, 0, 1, 2, 3, 4, 5])
    doors = np.arange(10).reshape(-1, 2)
    counted = fit_random_field(
        probabilities[repeated], truth[repeated], Neighbourhood(doors, NO_EDGES, np.zeros(0)), np.ones(10)
    )
    # Of 1 + 3 meetings either way, and 1 + 2 of each label with itself.
    assert weighted.doors == pytest.approx(np.log(np.array([[3, 4], [4, 3]]) / 14 * 4))
    assert weighted.doors == pytest.approx(counted.doors)
    assert weighted.temperature == pytest.approx(counted.temperature, abs=0.05)
    assert weighted.door_strength == pytest.approx(counted.door_strength, abs=0.05)
