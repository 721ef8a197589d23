"""Doors against true doors, by hand-made places."""

from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, box
from shapely.affinity import translate

from pianta.evaluation.doors import DetectionScores, match_connections, match_doors, score_doors, score_edges
from pianta.floor import Door, Floor, Room

ROOMS = tuple(Room(number, box(10 * number, 0, 10 * number + 10, 10)) for number in (1, 2, 3))


def floor_of(*doors: Door) -> Floor:
    return Floor(ROOMS, doors)


def door_at(
    x: float,
    y: float = 5.0,
    *,
    width: float = 1.0,
    rooms: tuple[int, int | None] = (1, 2),
    door_kind: Literal["door", "opening"] = "door",
) -> Door:
    return Door(rooms, LineString([(x, y - width / 2), (x, y + width / 2)]), width, door_kind)


TRUTH = floor_of(door_at(20), door_at(30, rooms=(2, 3)))


def test_doors_within_half_a_width_are_right():
    result = floor_of(door_at(20.4), door_at(30, 5.6, rooms=(2, 3)))
    scores = score_doors(result, TRUTH)
    assert scores == DetectionScores(true=2, detected=2, correct=1)
    assert (scores.precision, scores.recall, scores.f1) == (0.5, 0.5, 0.5)


def test_which_doors_are_right():
    """Two doors are near the first true one, and one of them is right; the last one is 0.6 m from the second."""
    doors = door_at(20.4), door_at(20), door_at(30, 5.6, rooms=(2, 3))
    assert match_doors(doors, TRUTH.doors).tolist() in ([True, False, False], [False, True, False])
    assert match_doors(doors, TRUTH.doors, reach=0.6).tolist()[2]
    assert match_doors((), TRUTH.doors).tolist() == []
    assert match_doors(doors, ()).tolist() == [False] * 3


def test_which_doors_join_true_pairs_of_rooms():
    """At any place; not the pair of rooms 1 and 3, and no entrance."""
    doors = door_at(50), door_at(20, rooms=(1, 3)), door_at(10, rooms=(1, None)), door_at(0, rooms=(2, 3))
    assert match_connections(floor_of(*doors), TRUTH).tolist() == [True, False, False, True]
    assert match_connections(floor_of(), TRUTH).tolist() == []


def test_the_reach_can_be_given():
    result = floor_of(door_at(20.4), door_at(30, 5.6, rooms=(2, 3)))
    assert score_doors(result, TRUTH, reach=0.6).correct == 2
    assert score_doors(result, TRUTH, reach=0.1).correct == 0


def test_the_reach_is_half_the_true_width_and_not_the_found_one():
    wide = door_at(20.8, width=3.0)
    assert score_doors(floor_of(wide), floor_of(door_at(20))).correct == 0
    assert score_doors(floor_of(door_at(20.8)), floor_of(door_at(20, width=3.0))).correct == 1


def test_a_narrow_door_has_a_least_reach():
    narrow, wide = floor_of(door_at(20, width=0.6)), floor_of(door_at(20, width=2.0))
    result = floor_of(door_at(20.4))
    assert score_doors(result, narrow).correct == 0
    assert score_doors(result, narrow, least_reach=0.45).correct == 1
    assert score_doors(floor_of(door_at(20.5)), narrow, least_reach=0.45).correct == 0
    assert score_doors(floor_of(door_at(20.9)), wide, least_reach=0.45).correct == 1
    assert score_doors(result, wide, reach=0.1, least_reach=0.3).correct == 0


def test_edges_join_rooms_that_match():
    """The rooms 1, 2, 3 are the true ones 2, 3 and none."""
    result = floor_of(door_at(20), door_at(20, 7), door_at(30, rooms=(2, 3)), door_at(40, rooms=(3, None)))
    assert score_edges(result, TRUTH, {1: 2, 2: 3}) == DetectionScores(true=2, detected=2, correct=1)
    assert score_edges(result, TRUTH, {1: 1, 2: 3}) == DetectionScores(true=2, detected=2, correct=0)
    assert score_edges(result, TRUTH, {1: 1, 2: 2, 3: 3}) == DetectionScores(true=2, detected=2, correct=2)
    assert score_edges(result, TRUTH, {}) == DetectionScores(true=2, detected=2, correct=0)
    assert score_edges(floor_of(), floor_of(door_at(20, rooms=(2, None))), {}) == DetectionScores(0, 0, 0)


def test_a_true_door_is_found_once():
    result = floor_of(door_at(20, 4.9), door_at(20, 5.1), door_at(20))
    scores = score_doors(result, floor_of(door_at(20)))
    assert scores == DetectionScores(true=1, detected=3, correct=1)
    assert scores.f1 == pytest.approx(0.5)


def test_as_many_as_possible_are_matched():
    """The nearest pair first would leave the door at 5.3 without its true one."""
    result = floor_of(door_at(20, 5.3), door_at(20, 4.85))
    truth = floor_of(door_at(20, 5.0), door_at(20, 4.4))
    assert score_doors(result, truth).correct == 2


def test_the_rooms_do_not_count_and_points_are_places():
    point = Door((1, 3), LineString([(20, 5), (20, 5)]), 0.9)
    assert score_doors(floor_of(point), TRUTH).correct == 1
    assert score_doors(floor_of(door_at(20.4, door_kind="opening")), floor_of(point)).correct == 1


def test_entrances_count_only_where_the_truth_has_any():
    entrance = door_at(10, rooms=(1, None))
    result = floor_of(door_at(20), entrance)
    assert score_doors(result, floor_of(door_at(20))) == DetectionScores(true=1, detected=1, correct=1)
    assert score_doors(result, floor_of(door_at(20), door_at(40, rooms=(3, None)))) == DetectionScores(2, 2, 1)


@pytest.mark.parametrize(
    ("result", "truth", "shares"),
    [
        ((), (), (1, 1, 1)),
        ((), (door_at(20),), (0, 0, 0)),
        ((door_at(20),), (), (0, 0, 0)),
    ],
)
def test_floors_without_doors(result, truth, shares):
    scores = score_doors(floor_of(*result), floor_of(*truth))
    assert (scores.precision, scores.recall, scores.f1) == shares


indices = st.lists(st.tuples(st.integers(0, 30), st.integers(0, 30)), max_size=6)


@given(indices, st.floats(-50, 50), st.floats(-50, 50))
def test_a_floor_matches_its_own_doors_at_any_position(at, x, y):
    doors = [door_at(*index) for index in at]
    moved = [Door(door.rooms, translate(door.line, x, y), door.width) for door in doors]
    scores = score_doors(floor_of(*moved), floor_of(*reversed(moved)))
    assert scores == DetectionScores(len(at), len(at), len(at))
    assert scores.f1 == 1


@given(indices, indices)
def test_precision_is_recall_the_other_way_round(first, second):
    one, other = (floor_of(*(door_at(*index) for index in at)) for at in (first, second))
    there, back = score_doors(one, other, reach=3), score_doors(other, one, reach=3)
    assert (there.precision, there.recall, there.f1) == (back.recall, back.precision, back.f1)
