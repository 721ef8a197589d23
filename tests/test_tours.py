"""The order in which places of different worth are visited."""

from itertools import pairwise, permutations
from math import inf

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike

from pianta.exploration.routes import measure_distances_between
from pianta.exploration.tours import choose_first_target
from tests.explored_worlds import draw_cells


def first_on_line(robot: float, positions: ArrayLike, worths: ArrayLike, lengths: ArrayLike | None = None) -> int:
    """The first of places on a line, metres, that a robot on it visits."""
    here = np.array(positions, float)
    within = np.zeros(len(here)) if lengths is None else np.array(lengths, float)
    return choose_first_target(abs(here - robot), abs(here[:, None] - here), np.array(worths, float), within)


def cost_of(order, distances, between, worths, lengths) -> float:
    """What waits on a tour: the worth of each place over the way until half of it has been seen."""
    way, cost = 0.0, 0.0
    steps = [distances[order[0]], *(between[one, other] for one, other in pairwise(order))]
    for index, step in zip(order, steps, strict=True):
        cost += worths[index] * (way + step + lengths[index] / 2)
        way += step + lengths[index]
    return cost


def test_of_three_places_on_a_line_the_robot_goes_where_less_waits():
    # To the left first: 1 + 4 + 6 m are waited; to the right first: 2 + 4 + 7 m.
    assert first_on_line(0, [-1, 2, 4], [1, 1, 1]) == 0
    # With five at the right end: 1 + 4 + 5 · 6 against 2 + 5 · 4 + 9.
    assert first_on_line(0, [-1, 2, 4], [1, 1, 5]) == 1


def test_worth_pulls():
    assert first_on_line(0, [-2, 3], [1, 1]) == 0
    assert first_on_line(0, [-2, 3], [1, 2]) == 1


def test_what_takes_long_waits():
    assert first_on_line(0, [-2, 3], [1, 1], [0, 0]) == 0
    assert first_on_line(0, [-2, 3], [1, 1], [8, 0]) == 1


def test_a_single_place_is_the_first():
    assert first_on_line(0, [7], [1]) == 0


def test_places_without_a_way_between_them_leave_the_nearer_one():
    apart = np.array([[0, inf], [inf, 0]])
    assert choose_first_target(np.array([3.0, 2.0]), apart, np.ones(2), np.zeros(2)) == 1


figures = st.integers(0, 40).map(float)


@st.composite
def tours(draw):
    count = draw(st.integers(1, 5))
    ways = np.array(draw(st.lists(figures, min_size=count * count, max_size=count * count))).reshape(count, count)
    worths = draw(st.lists(st.integers(1, 30).map(float), min_size=count, max_size=count))
    distances, lengths = (np.array(draw(st.lists(figures, min_size=count, max_size=count))) for _ in range(2))
    return distances, np.triu(ways, 1) + np.triu(ways, 1).T, np.array(worths), lengths


@pytest.mark.slow
@given(tours())
def test_the_first_of_few_places_is_that_of_the_best_of_all_orders(tour):
    costs: dict[int, float] = {}
    for order in permutations(range(len(tour[0]))):
        costs[order[0]] = min(costs.get(order[0], inf), cost_of(order, *tour))
    assert costs[choose_first_target(*tour)] == pytest.approx(min(costs.values()))


def test_ways_between_places_lead_around_walls():
    passable = (
        draw_cells("""
        ......
        ......
        ####..
        ####..
        ......
        ......
        """)
        == 0
    )
    result = measure_distances_between(passable, np.array([(0, 0), (5, 0), (0, 5)]), resolution=0.5)
    # Coarse cells of 1 m: two steps right, two down and two back.
    assert result == pytest.approx(np.array([[0, 6, 2], [6, 0, 4], [2, 4, 0]]))
    parted = draw_cells("""
        ..####..
        ..####..
        """)
    assert measure_distances_between(parted == 0, np.array([(0, 0), (0, 7)]), resolution=0.5)[0, 1] == inf


def test_a_target_in_a_cell_that_is_barred_is_reached_and_odd_sides_count():
    passable = np.array([[1, 1, 1, 1, 0]], bool)
    assert measure_distances_between(passable, np.array([(0, 0), (0, 4)]), resolution=1.0)[0, 1] == 4
