"""The two error rates by hand, and which of them the figures of the thesis can be."""

from itertools import product

import pytest

from pianta_bench.harness.error_rates import ALL_FLOORS, CLASS_MEAN, measure_error_rates
from pianta_bench.harness.tables import read_published

SCHOOLS, OFFICES, WORLDS = 30, 20, 6


def test_by_hand():
    classes = ["school"] * 4 + ["office"] * 2 + ["school"]
    wrong = [True, False, False, False, True, False, False]
    rates = measure_error_rates(classes, wrong)
    # Two of seven floors; one of five schools, one of two offices.
    assert rates[ALL_FLOORS] == pytest.approx(100 * 2 / 7)
    assert rates[CLASS_MEAN] == pytest.approx(100 * (1 / 5 + 1 / 2) / 2)


def test_three_classes():
    rates = measure_error_rates(["a", "b", "b", "c", "c", "c"], [True, True, False, False, False, True])
    assert rates[ALL_FLOORS] == 50
    assert rates[CLASS_MEAN] == pytest.approx(100 * (1 + 1 / 2 + 1 / 3) / 3)


def test_no_floors():
    assert measure_error_rates([], []) == {ALL_FLOORS: None, CLASS_MEAN: None}


def list_possible(first: int, second: int) -> dict[str, set[str]]:
    """All figures that two classes of these numbers of floors can have, by statistic, as the thesis prints them."""
    figures: dict[str, set[str]] = {ALL_FLOORS: set(), CLASS_MEAN: set()}
    for wrong in product(range(first + 1), range(second + 1)):
        classes = ["first"] * first + ["second"] * second
        is_wrong = [number < wrong[0] for number in range(first)] + [number < wrong[1] for number in range(second)]
        for name, rate in measure_error_rates(classes, is_wrong).items():
            figures[name].add(f"{rate:.2f}")
    return figures


@pytest.mark.parametrize(
    ("file", "first", "second"),
    [("table_6_1_buildings.csv", SCHOOLS, OFFICES), ("table_8_2.csv", WORLDS, OFFICES)],
)
def test_printed_figures_are_of_every_statistic_that_they_can_be(file, first, second):
    possible = list_possible(first, second)
    published = [(record["statistic"], f"{float(record['mean']):.2f}") for record in read_published(file)]
    for figure in {figure for _, figure in published}:
        assert {statistic for statistic, other in published if other == figure} == {
            statistic for statistic, figures in possible.items() if figure in figures
        }, figure
