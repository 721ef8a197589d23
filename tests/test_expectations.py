"""What a robot expects of a building by a model of its type."""

from dataclasses import replace

import pytest

from pianta.errors import LabelError
from pianta.exploration import expectations
from pianta.exploration.expectations import Beyond, RoomExpectations
from tests.expected_floors import CORRIDOR_DOOR, LIBRARY_DOOR, recognised_rooms, school_sampler


def test_the_rest_of_a_room_is_that_of_larger_rooms_of_its_label():
    expected = RoomExpectations(school_sampler())
    assert expected.expect_rest("CLASSROOM", 20) == pytest.approx(30)
    assert expected.expect_rest("GYM", 20) == pytest.approx(280)


def test_a_room_as_large_as_any_ends_soon():
    expected = RoomExpectations(school_sampler())
    assert expected.expect_rest("CLASSROOM", 49) == pytest.approx(0.05 * 49)
    assert expected.expect_rest("CLASSROOM", 100) == pytest.approx(5)


def test_rooms_without_a_usual_label_use_the_sizes_of_all_rooms():
    expected = RoomExpectations(school_sampler())
    # Larger than 100 m² are the gyms alone.
    for label in (None, "SAUNA"):
        assert expected.expect_rest(label, 100) == pytest.approx(200)


def test_behind_the_doors_is_what_the_model_has():
    result = RoomExpectations(school_sampler(), find="gym").predict_beyond(recognised_rooms(), [])
    assert result.area.keys() == result.hit.keys() == {LIBRARY_DOOR, CORRIDOR_DOOR}
    # Each school has a gym of 300 m², behind the library.
    assert result.hit[LIBRARY_DOOR] > 0.9
    assert result.area[LIBRARY_DOOR] > 250


def test_a_label_that_no_floor_of_the_model_has_is_nowhere():
    result = RoomExpectations(school_sampler(), find="KITCHEN").predict_beyond(recognised_rooms(), [])
    assert set(result.hit.values()) == {0}
    assert set(RoomExpectations(school_sampler()).predict_beyond(recognised_rooms(), []).hit.values()) == {0}


def test_an_open_corridor_is_an_end_of_its_own():
    result = RoomExpectations(school_sampler()).predict_beyond(recognised_rooms(), [1])
    assert 1 in result.area


def test_predictions_are_the_same_and_kept_while_nothing_new_is_seen():
    one, other = (RoomExpectations(school_sampler(), find="gym") for _ in range(2))
    first = one.predict_beyond(recognised_rooms(), [])
    assert one.predict_beyond(recognised_rooms(), []) is first
    again = other.predict_beyond(recognised_rooms(), [])
    assert (again.area, again.hit) == (first.area, first.hit)
    fewer = replace(recognised_rooms(), unopened=((2, 5),))
    assert one.predict_beyond(fewer, []).area.keys() == {LIBRARY_DOOR}


def test_nothing_is_expected_beyond_what_cannot_be_part_of_a_floor(monkeypatch):
    def refuse(*_):
        raise LabelError("unknown label")

    monkeypatch.setattr(expectations, "read_explored_part", refuse)
    result = RoomExpectations(school_sampler()).predict_beyond(recognised_rooms(), [])
    assert (result.area, result.hit) == (Beyond().area, Beyond().hit) == ({}, {})
