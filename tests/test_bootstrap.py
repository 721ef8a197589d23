"""Intervals by the bootstrap."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import OptionError
from pianta.evaluation.bootstrap import Interval, bootstrap_mean, bootstrap_ratio

METRES = st.lists(st.floats(0.5, 100), min_size=1, max_size=8)


def test_of_two_values_a_quarter_of_the_means_is_either():
    """Draws of 0 and 1: the mean is 0 in a quarter of them, 1 in a quarter, else 0.5."""
    assert bootstrap_mean([0, 1], seed=0) == Interval(0.5, 0, 1, 2)
    assert bootstrap_mean([0, 1], seed=0, share=0.4) == Interval(0.5, 0.5, 0.5, 2)


def test_the_interval_is_that_of_the_normal_distribution():
    """For many values: 1.96 standard errors on both sides, here of a fair coin."""
    result = bootstrap_mean([0.0, 1.0] * 200, seed=1)
    assert result is not None
    assert (result.low, result.high) == pytest.approx((0.5 - 1.96 * 0.025, 0.5 + 1.96 * 0.025), abs=0.003)


def test_pairs_are_drawn_together():
    """Each value is twice its other: so is every sum."""
    result = bootstrap_ratio([2, 20, 8], [1, 10, 4], seed=0)
    assert result == Interval(2, 2, 2, 3)
    unlike = bootstrap_ratio([1, 30], [10, 10], seed=0)
    assert unlike == Interval(pytest.approx(1.55), pytest.approx(0.1), pytest.approx(3), 2)  # type: ignore[arg-type]


@given(METRES, st.integers(0, 99))
def test_the_interval_is_among_the_values_and_is_repeated(values, seed):
    result = bootstrap_mean(values, seed=seed, repeats=50)
    assert result is not None
    assert min(values) - 1e-9 <= result.low <= result.high <= max(values) + 1e-9
    assert result == bootstrap_mean(values, seed=seed, repeats=50)


def test_nothing_has_no_interval():
    assert bootstrap_mean([], seed=0) is None


@pytest.mark.parametrize(
    ("values", "others", "options", "message"),
    [
        ([1.0], [0.0], {}, "values"),
        ([1.0], [1.0, 2.0], {}, "others"),
        ([float("inf")], [1.0], {}, "finite"),
        ([1.0], [1.0], {"repeats": 0}, "repeats"),
        ([1.0], [1.0], {"share": 1.0}, "share"),
    ],
)
def test_values_without_meaning(values, others, options, message):
    with pytest.raises(OptionError, match=message):
        bootstrap_ratio(values, others, seed=0, **options)
