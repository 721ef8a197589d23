"""Pairs of rooms that doors join, found against true."""

import pytest
from shapely import LineString, Polygon, box

from pianta.evaluation.doors import DetectionScores, score_connections
from pianta.floor import Door, Floor, Room

# Four rooms of 4 m in a row.
ROOMS = tuple(Room(number, box(4 * number, 0, 4 * number + 4, 3)) for number in (1, 2, 3, 4))


def join(*pairs: tuple[int, int | None], rooms: tuple[Room, ...] = ROOMS) -> Floor:
    return Floor(rooms, tuple(Door(pair, LineString([(0, 1), (0, 2)]), 1.0) for pair in pairs))


def rooms_of(*polygons: Polygon) -> tuple[Room, ...]:
    return tuple(Room(number, polygon) for number, polygon in enumerate(polygons, start=1))


def test_pairs_are_counted_by_their_rooms():
    result, truth = join((1, 2), (1, 3), (3, 4)), join((1, 2), (2, 3), (3, 4), (1, 4))
    scores = score_connections(result, truth)
    assert scores == DetectionScores(true=4, detected=3, correct=2)
    assert (scores.precision, scores.recall) == pytest.approx((2 / 3, 1 / 2))


def test_several_doors_of_a_pair_count_once_and_entrances_do_not():
    result, truth = join((1, 2), (2, 1), (1, None)), join((1, 2), (3, None), (4, None))
    assert score_connections(result, truth) == DetectionScores(true=1, detected=1, correct=1)


def test_a_found_room_stands_for_the_true_room_that_it_overlaps_most():
    """Room 1 of the found ones lies on the second true room by 3 of 4 m, the ids are not those of the truth."""
    rooms = rooms_of(box(7, 0, 11, 3), box(12, 0, 16, 3), box(4, 0, 7, 3))
    result = join((1, 2), (1, 3), rooms=rooms)
    assert score_connections(result, join((1, 2), (2, 3))) == DetectionScores(true=2, detected=2, correct=2)
    assert score_connections(result, join((1, 2), (1, 3))) == DetectionScores(true=2, detected=2, correct=1)


def test_doors_inside_a_true_room_and_to_rooms_that_are_none_do_not_count():
    rooms = rooms_of(box(4, 0, 6, 3), box(6, 0, 8, 3), box(8, 0, 12, 3), box(0, 10, 4, 13))
    result = join((1, 2), (2, 3), (3, 4), (1, 4), rooms=rooms)
    assert score_connections(result, join((1, 2))) == DetectionScores(true=1, detected=1, correct=1)


def test_rooms_that_are_found_as_one_lose_their_pair():
    result = join((1, 2), rooms=rooms_of(box(4, 0, 12.5, 3), box(12.5, 0, 16, 3)))
    assert score_connections(result, join((1, 2), (2, 3))) == DetectionScores(true=2, detected=1, correct=0)


@pytest.mark.parametrize(
    ("result", "truth", "share"),
    [((), (), 1), (((1, 2),), (), 0), ((), ((1, 2),), 0), (((1, 2),), ((1, 2),), 1)],
)
def test_where_one_side_joins_no_rooms_every_share_is_0_and_where_neither_does_1(result, truth, share):
    scores = score_connections(join(*result), join(*truth))
    assert (scores.precision, scores.recall) == (share, share)


def test_floors_without_rooms_join_none():
    assert score_connections(Floor(()), Floor(())) == DetectionScores(true=0, detected=0, correct=0)
    assert score_connections(Floor(()), join((1, 2))) == DetectionScores(true=1, detected=0, correct=0)
