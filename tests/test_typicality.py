"""How typical floors are of the known ones."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.testing import assert_allclose

from pianta.building_types.description import BuildingDescription
from pianta.building_types.kernel import BuildingKernel
from pianta.building_types.typicality import Typicality, fit_typicality, measure_likeness


def test_likeness_is_the_mean_of_the_three_most_alike():
    gram = np.array([[0.1, 0.9, 0.5, 0.4], [1.0, 0.0, 0.0, 0.0]])
    assert_allclose(measure_likeness(gram), [0.6, 1 / 3])


def test_likeness_to_fewer_than_three():
    assert_allclose(measure_likeness(np.array([[0.2, 0.4]])), [0.3])


def describe(numbers: tuple[float, ...], *labels: str) -> BuildingDescription:
    """Rooms in a row, each with a door to the next."""
    doors = tuple(pairwise(range(len(labels))))
    return BuildingDescription("", np.array(numbers), labels, (0.0,) * len(labels), (1,) * len(labels), doors)


def test_floors_of_a_building_are_not_compared():
    twin = describe((0.0, 1.0), "ROOM", "CORRIDOR")
    others = [describe((n * 1.0, -n * n * 1.0), *["CORRIDOR"] * n, "ROOM") for n in (2, 3, 5)]
    apart = fit_typicality([twin, twin, *others], "abcde").likenesses
    together = fit_typicality([twin, twin, *others], "aabcd").likenesses
    assert apart.mean() > together.mean() + 0.1


def test_a_known_floor_is_compared_as_a_new_one_is():
    training = [describe((float(n), float(n * n)), *["ROOM"] * (n + 1), "CORRIDOR") for n in range(4)]
    learnt = fit_typicality(training, "abcd").likenesses
    as_new = [
        measure_likeness(BuildingKernel().fit(training[:n] + training[n + 1 :]).compare([training[n]]))
        for n in range(4)
    ]
    assert_allclose(learnt, np.sort(np.ravel(as_new)))


def test_ranks():
    training = Typicality(np.array([0.2, 0.4, 0.4, 0.8]))
    assert_allclose(training.rank(np.array([0.1, 0.2, 0.3, 0.4, 0.8, 0.9])), [0, 1 / 8, 1 / 4, 1 / 2, 7 / 8, 1])


@given(arrays(np.float64, st.integers(1, 20), elements=st.floats(0, 1)), st.floats(0, 1), st.floats(0, 1))
def test_what_is_more_alike_is_not_less_typical(likenesses, one, other):
    training = Typicality(np.sort(likenesses))
    less, more = training.rank(np.array(sorted((one, other))))
    assert 0 <= less <= more <= 1


@given(arrays(np.float64, st.integers(1, 20), elements=st.floats(0, 1)))
def test_known_floors_are_as_typical_as_the_median_on_average(likenesses):
    training = Typicality(np.sort(likenesses))
    assert_allclose(training.rank(likenesses).mean(), 0.5)
