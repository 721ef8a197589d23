"""Rooms and doors counted by hand on small label images."""

import numpy as np
import pytest
from shapely import LineString

from pianta.errors import FloorError
from pianta.evaluation.room_counts import DoorCounts, RoomCounts, count_doors, count_rooms
from pianta.floor import Door

LINE = LineString([(0, 0), (1, 0)])


def image(*rows: str) -> np.ndarray:
    return np.array([[int(pixel) for pixel in row] for row in rows], np.uint16)


def count(labels: str, truth: str, *, counted: str = "", resolution: float = 1.0) -> RoomCounts:
    cells = image(counted) == 1 if counted else np.ones((1, len(labels)), bool)
    return count_rooms(image(labels), image(truth), counted=cells, resolution=resolution)


def test_the_true_rooms_are_right_and_whole():
    assert count("1122", "5577") == RoomCounts(2, 2, 2, 2, 0, 0, 0, {1: 5, 2: 7}, frozenset({1, 2}))


def test_a_room_of_iou_0_6_is_right_and_one_below_is_not():
    """3 of 5 cells; then 3 cells against 6."""
    assert count("11100", "77777").right == 1
    assert count("111000", "777777").right == 0


def test_a_further_piece_of_a_true_room_is_a_split():
    """The true room has pieces of 6, 2 and 1 cells: the first is right, with an IoU of 6/9, but not whole."""
    assert count("111111223", "777777777") == RoomCounts(1, 3, 1, 0, 2, 0, 0, {1: 7, 2: 7, 3: 7}, frozenset({1}))


def test_pieces_below_0_4_m2_are_no_split():
    """Cells of 0.3 m², so that the piece of one cell is smaller and that of two cells is not."""
    counts = count("111111223", "777777777", resolution=0.3**0.5)
    assert (counts.splits, counts.right_whole, counts.detected) == (1, 0, 3)
    assert count("11111113", "77777777", resolution=0.3**0.5).right_whole == 1


def test_a_piece_has_more_than_half_of_its_cells_in_the_true_room():
    """Room 2 has two cells in true room 7 and two in no room: it is no piece of 7, and no room."""
    assert count("11112222", "77777700") == RoomCounts(1, 2, 1, 1, 0, 0, 1, {1: 7}, frozenset({1}))


def test_true_rooms_in_one_room_are_merged():
    """Room 1 has true rooms of 6, 2 and 1 cells; it is right for the first."""
    assert count("111111111", "777777889") == RoomCounts(3, 1, 1, 1, 0, 2, 0, {1: 7}, frozenset({1}))


def test_a_room_that_is_one_piece_elsewhere_is_neither_split_nor_merged():
    """Room 1 has all of 8 and two of the five cells of 7, room 2 the other three, so that 7 is right."""
    counts = count("1111222", "8877777")
    assert (counts.splits, counts.merges, counts.right, counts.right_whole) == (0, 0, 1, 1)


def test_only_counted_cells_count():
    """Room 3 and the false end of room 1 are not counted."""
    right_ids = frozenset({1, 2})
    assert count("1111322", "5500077", counted="1100011") == RoomCounts(2, 2, 2, 2, 0, 0, 0, {1: 5, 2: 7}, right_ids)


@pytest.mark.parametrize(
    ("labels", "truth", "counts"),
    [("00", "00", (0, 0, 0)), ("11", "00", (0, 1, 1)), ("00", "11", (1, 0, 0))],
)
def test_images_without_rooms(labels, truth, counts):
    result = count(labels, truth)
    assert (result.true, result.detected, result.no_rooms) == counts
    assert (result.right, result.splits, result.merges, result.true_ids) == (0, 0, 0, {})


def test_images_of_different_shapes_are_refused():
    with pytest.raises(FloorError, match="shape"):
        count_rooms(image("11"), image("111"), counted=image("11") > 0, resolution=1)


def test_doors_within_a_true_room_and_to_nowhere():
    """Rooms 1 and 2 are pieces of true room 7, room 3 is 8, room 4 is no room."""
    pairs = [(1, 2), (1, 3), (2, 3), (3, 4), (1, None)]
    doors = [Door(pair, LINE, 1.0) for pair in pairs]
    assert count_doors(doors, {1: 7, 2: 7, 3: 8}) == DoorCounts(doors=5, within=1, nowhere=2)
    assert count_doors([], {}) == DoorCounts(0, 0, 0)
