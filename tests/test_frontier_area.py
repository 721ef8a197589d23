"""How much area is behind a frontier, from what a robot measures there."""

import numpy as np
import pytest
from numpy.typing import NDArray

from pianta.exploration import frontier_area
from pianta.exploration.expectations import Beyond, RoomExpectations
from pianta.exploration.frontier_area import MEASURES, expect_areas, find_door, measure_frontiers
from tests.expected_floors import (
    CORRIDOR_DOOR,
    LIBRARY_DOOR,
    make_policy_input,
    recognised_rooms,
    school_sampler,
    sight_only_weights,
)

BEYOND = Beyond({LIBRARY_DOOR: 300.0, CORRIDOR_DOOR: 64.0, 3: 36.0}, {LIBRARY_DOOR: 1.0, CORRIDOR_DOOR: 0.25, 3: 0.5})


@pytest.fixture
def expected(monkeypatch):
    monkeypatch.setattr(RoomExpectations, "predict_beyond", lambda *_: BEYOND)
    return RoomExpectations(school_sampler())


def column(measured: NDArray[np.float64], name: str) -> list[float]:
    return [float(row[MEASURES.index(name)]) for row in measured]


def test_a_frontier_at_a_door_has_what_is_behind_it(expected):
    measured, hits = measure_frontiers(
        make_policy_input([(0.5, 5), (19, 1.5)], [[3, 4]], recognised=recognised_rooms()), expected
    )
    assert column(measured, "beyond") == pytest.approx([300**0.5, 8])
    assert column(measured, "at a door") == [1, 1]
    assert column(measured, "in a room") == [0, 0]
    assert hits.tolist() == [1, 0.25]


def test_frontiers_of_a_room_share_it_by_length(expected):
    inputs = make_policy_input(
        [(5, 5), (7, 5)], [[3, 4]], lengths=[3.0, 1.0], rooms=[3, 3], recognised=recognised_rooms()
    )
    measured, hits = measure_frontiers(inputs, expected)
    assert column(measured, "share of its end") == [0.75, 0.25]
    assert column(measured, "beyond") == pytest.approx([27**0.5, 3])
    assert hits.tolist() == [0.375, 0.125]
    assert column(measured, "in a room") == [1, 1]
    assert column(measured, "at a door") == column(measured, "entered") == [0, 0]
    # 16 m² of a classroom were seen, and all have 50 m².
    assert column(measured, "seen of the room") == [4, 4]
    assert column(measured, "rest of the room") == pytest.approx([34**0.5] * 2)
    assert column(measured, "length") == pytest.approx([3**0.5, 1])


def test_a_frontier_far_from_rooms_and_doors_has_what_is_in_sight(expected):
    measured, hits = measure_frontiers(make_policy_input([(12, 8)], [[3]], recognised=recognised_rooms()), expected)
    assert measured[0, 0] > measured[0, 1] > 0
    assert measured[0, 3:7].tolist() == [0, 0, 0, 0]
    assert hits.tolist() == [0]


def test_without_recognised_rooms_only_what_is_in_sight_is_measured(expected):
    measured, hits = measure_frontiers(make_policy_input([(19, 1.5), (12, 8)], [[3, 4]]), expected)
    assert (measured[:, :3] > 0).all()
    assert not measured[:, 3:].any()
    assert not hits.any()


def test_a_point_belongs_to_the_nearest_door_within_reach():
    observed = recognised_rooms()
    assert find_door(observed, (1, 5)) == LIBRARY_DOOR
    assert find_door(observed, (18, 1)) == CORRIDOR_DOOR
    assert find_door(observed, (10, 1)) is None


def test_the_perceptron_is_worked_by_hand(monkeypatch):
    monkeypatch.setattr(frontier_area, "_read_weights", sight_only_weights)
    measured = np.zeros((2, len(MEASURES)))
    measured[:, 0] = np.array([3, 5])
    measured[:, 6] = 9
    assert expect_areas(measured).tolist() == [9, 25]
    # The hidden neuron is at most 0, and a root below 0 is no area.
    bent = {**sight_only_weights(), "mean": np.full(10, 4.0), "spread": np.full(10, 0.5), "bias 1": np.array([-1.0])}
    monkeypatch.setattr(frontier_area, "_read_weights", lambda: bent)
    assert expect_areas(measured).tolist() == [0, 1]


def test_the_weights_that_come_with_pianta_fit_the_measures():
    measured = np.zeros((3, len(MEASURES)))
    measured[:, :3] = np.array([[0.5, 0.5, 0.7], [4, 2, 1.2], [9, 3, 2]])
    # Each is alone at its end: no frontier has a share of 0
    measured[:, MEASURES.index("share of its end")] = 1
    areas = expect_areas(measured)
    assert areas.shape == (3,)
    assert (np.diff(areas) > 0).all()
    assert (areas >= 0).all()
