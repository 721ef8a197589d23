"""Pictures of true beside found rooms, cell by cell."""

import numpy as np

from pianta.evaluation.segmentation import match_rooms
from pianta.gridmap import GridMap
from pianta_bench.segmentation.figures import ERROR_COLOR, UNMATCHED_GREY, paint_comparison

GREY = [UNMATCHED_GREY] * 3


def paint(reconstructed: np.ndarray, truth: np.ndarray) -> tuple[list[list[list[int]]], list[list[list[int]]]]:
    grid = GridMap(np.zeros(reconstructed.shape, np.int8), 0.15)
    left, right = paint_comparison(reconstructed, truth, grid, match_rooms(reconstructed, truth))
    return left.tolist(), right.tolist()


def test_matching_rooms_have_one_colour_and_differences_are_red():
    """Reconstructed room 8 lacks one of the six columns of true room 3, and has one column more on the other side."""
    truth, reconstructed = np.zeros((2, 5, 9), np.int32)
    truth[:, 1:7], reconstructed[:, 2:8] = 3, 8
    left, right = paint(reconstructed, truth)
    assert left[2][1:7] == [left[2][1]] * 6
    assert right[2][2:7] == [left[2][1]] * 5
    assert right[2][1] == right[2][7] == list(ERROR_COLOR)
    assert left[2][0] == right[2][0] == left[2][7] == [255] * 3
    assert left[2][1] not in (GREY, list(ERROR_COLOR))


def test_rooms_without_a_match_are_grey_with_a_red_rim():
    truth, reconstructed = np.zeros((2, 9, 20), np.int32)
    truth[2:7, 2:7], reconstructed[2:7, 12:17] = 1, 1
    left, right = paint(reconstructed, truth)
    assert left[4][4] == right[4][14] == GREY
    assert left[4][2] == left[4][6] == right[2][14] == list(ERROR_COLOR)
    assert right[4][4] == left[4][14] == [255] * 3


def test_obstacles_in_a_missed_room_have_no_rim():
    truth, reconstructed = np.zeros((2, 15, 15), np.int32)
    truth[1:14, 1:14] = 1
    truth[7, 7] = 0
    left, _ = paint(reconstructed, truth)
    assert left[6][7] == left[7][6] == GREY
    assert left[7][7] == [255] * 3


def test_neighbouring_ids_differ_in_colour():
    labels = np.repeat(np.arange(1, 31, dtype=np.int32), 4)[None].repeat(4, axis=0)
    left, right = paint(labels, labels)
    assert left == right
    colors = np.array(left[2][1::4])
    assert (np.abs(np.diff(colors, axis=0)).sum(axis=1) > 40).all()
