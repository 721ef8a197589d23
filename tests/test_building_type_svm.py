"""The machine of arrays says what SVC and LogisticRegression of scikit-learn say."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from sklearn.linear_model import LogisticRegression
from sklearn.svm import SVC

from pianta._types import Floats
from pianta.building_types.svm import CALIBRATION_COST, COST, BuildingTypeSvm, fit_type_svm
from pianta.evaluation.folds import leave_buildings_out


def compare(one: Floats, other: Floats) -> Floats:
    return np.asarray(np.exp(-((one[:, None] - other) ** 2).sum(axis=2)))


def make_floors(types: int, *, seed: int, each: int = 8) -> tuple[Floats, NDArray[np.intp], list[str]]:
    """Known floors, the types of each in no order, and the buildings, some of which have two floors."""
    random = np.random.default_rng(seed)
    truth = random.permutation(np.arange(types * each) % types)
    floors = random.normal(size=(len(truth), 3)) + truth[:, None] * 0.7
    return floors, truth, [f"{building_type}/{index // 2}" for index, building_type in enumerate(truth)]


def fit_svm(gram: Floats, truth: NDArray[np.intp]) -> SVC:
    return SVC(kernel="precomputed", C=COST, class_weight="balanced").fit(gram, truth)


# Of many types that lie over each other the calibration may need more steps; the decisions are what counts.
@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
@pytest.mark.parametrize("types", [2, 3, 4, 6])
@given(seed=st.integers(0, 10_000))
@settings(max_examples=8, deadline=None)
def test_it_decides_as_scikit_learn_does(types, seed):
    floors, truth, buildings = make_floors(types, seed=seed)
    gram, new = compare(floors, floors), compare(make_floors(types, seed=seed + 1)[0], floors)
    predicted = fit_type_svm(gram, truth, buildings).decide(new, truth)
    decided = fit_svm(gram, truth).decision_function(new).reshape(len(new), -1)
    np.testing.assert_allclose(predicted, decided, rtol=0, atol=1e-10)


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.ConvergenceWarning")
@pytest.mark.parametrize("types", [2, 3, 5])
@given(seed=st.integers(0, 10_000))
@settings(max_examples=5, deadline=None)
def test_probabilities_equal_those_of_scikit_learn(types, seed):
    floors, truth, buildings = make_floors(types, seed=seed)
    gram, new = compare(floors, floors), compare(make_floors(types, seed=seed + 1)[0], floors)
    decisions, true_types = [], []
    for others, held_out in leave_buildings_out(buildings):
        svm = fit_svm(gram[np.ix_(others, others)], truth[others])
        decisions.append(svm.decision_function(gram[np.ix_(held_out, others)]).reshape(len(held_out), -1))
        true_types.append(truth[held_out])
    scaling = LogisticRegression(C=CALIBRATION_COST).fit(np.concatenate(decisions), np.concatenate(true_types))
    confident = scaling.predict_proba(fit_svm(gram, truth).decision_function(new).reshape(len(new), -1))
    predicted = fit_type_svm(gram, truth, buildings).predict_probabilities(new, truth)
    np.testing.assert_allclose(predicted, confident, rtol=0, atol=1e-10)
    assert predicted.sum(axis=1) == pytest.approx(1)


def test_two_types_by_hand():
    """Floors of types 0, 1, 0; the second type is what is below 0 in the votes."""
    machine = BuildingTypeSvm(
        np.array([[2.0], [-1.0], [0.0]]), np.array([0.5]), np.array([[0.0, 3.0]]), np.array([0, -1.0])
    )
    gram, truth = np.array([[0.5, 0.25, 1.0]]), np.array([0, 1, 0])
    decision = -(2 * 0.5 - 0.25 + 0.5)
    assert machine.decide(gram, truth).tolist() == [[decision]]
    assert machine.predict_probabilities(gram, truth)[0, 1] == pytest.approx(1 / (1 + np.exp(-(3 * decision - 1))))


def test_three_types_by_hand():
    """A known floor of each type; votes between 0 and 1, 0 and 2, 1 and 2; a tie is for the first."""
    weights = np.array([[4.0, 1.0], [-2.0, 3.0], [-1.0, -3.0]])
    machine = BuildingTypeSvm(weights, np.array([0.0, -0.5, 0.0]), np.eye(3), np.zeros(3))
    gram, truth = np.array([[0.5, 1.0, 1.0]]), np.array([0, 1, 2])
    # 4/2 - 2 = 0 for 0; 1/2 - 1 - 1/2 = -1 for 2; 3 - 3 = 0 for 1.
    won, sums = np.array([1.0, 1.0, 1.0]), np.array([0.0 - 1.0, 0.0, 1.0])
    np.testing.assert_allclose(machine.decide(gram, truth)[0], won + sums / (3 * (np.abs(sums) + 1)))


def test_decisions_that_are_large_are_no_overflow():
    machine = BuildingTypeSvm(np.full((2, 1), 1e6), np.array([1e6]), np.array([[0.0, 1e6]]), np.array([0.0, 1e6]))
    assert machine.predict_probabilities(np.ones((1, 2)), np.array([0, 1])).tolist() == [[1.0, 0.0]]
