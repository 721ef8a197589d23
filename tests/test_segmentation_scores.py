"""Coverage of label images, with answers worked out by hand, and the true rooms of the survey."""

from dataclasses import astuple
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from shapely import Polygon, box

from pianta.errors import FloorError
from pianta.evaluation.coverage import Scores, score_layout
from pianta.evaluation.segmentation import drop_small_rooms, keep_rooms_at, label_rest, match_rooms, score_labels
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta_bench.data.survey_truth import label_free_rooms, label_patches, read_survey_truth

label_images = arrays(np.uint16, (6, 7), elements=st.integers(0, 5))
masks = arrays(np.bool_, (6, 7))


def image(*rows: str) -> np.ndarray:
    return np.array([[int(pixel) for pixel in row] for row in rows], np.uint16)


def test_ids_need_not_agree():
    assert score_labels(image("1102"), image("5503")) == Scores(1, 1, 1, 1, 1, 1, reconstructed=2, true=2)


def test_split_room():
    """The found rooms of 3 and 1 pixels lie in the true room of 4."""
    scores = score_labels(image("1112"), image("1111"))
    assert scores == Scores(1.0, 0.75, 1.0, 0.75, mean_iou=0.75, f1=2 / 3, reconstructed=2, true=1)


def test_pixels_without_a_room_count_against_the_rooms():
    """Room 1 has 4 pixels, 2 of them in the true room, whose third pixel is in no room."""
    scores = score_labels(image("11110"), image("00999"))
    assert scores == Scores(2 / 4, 2 / 3, 2 / 4, 2 / 3, mean_iou=2 / 5, f1=0.0, reconstructed=1, true=1)


def test_only_counted_pixels_count():
    """Without the wall in the middle nothing is wrong; room 7 lies in the wall alone and does not exist."""
    labels, truth, counted = image("11722"), image("11022"), image("11011") == 1
    assert score_labels(labels, truth, counted=counted) == Scores(1, 1, 1, 1, 1, 1, reconstructed=2, true=2)
    assert score_labels(labels, truth) == Scores(0.8, 1, 2 / 3, 1, mean_iou=1, f1=0.8, reconstructed=3, true=2)


def test_label_below_one_is_no_room():
    """Watersheds are -1."""
    assert score_labels(np.array([[1, -1, 2]]), image("102")).reconstructed == 2


@pytest.mark.parametrize(("labels", "truth", "share"), [("00", "11", 0), ("11", "00", 0), ("00", "00", 1)])
def test_empty_sides(labels, truth, share):
    result, true = int(labels != "00"), int(truth != "00")
    assert astuple(score_labels(image(labels), image(truth))) == (*[share] * 6, result, true)


def test_rooms_up_to_a_quarter_of_a_square_metre_are_dropped():
    """Pixels are 0.25 m²; ids stay, and labels below one are no rooms."""
    small = drop_small_rooms(np.array([[2, 2, 7, 5], [-1, -1, 0, 5]]), resolution=0.5)
    assert small.tolist() == [[2, 2, 0, 5], [0, 0, 0, 5]]
    assert drop_small_rooms(image("00"), resolution=0.5).tolist() == [[0, 0]]


def test_the_rest_is_one_more_room_of_the_counted_pixels():
    rest = label_rest(image("1030", "0000"), counted=image("1101", "0100") == 1)
    assert rest.tolist() == [[1, 4, 3, 4], [0, 4, 0, 0]]


def test_the_rest_of_nothing_is_a_room():
    assert label_rest(image("00"), counted=image("10") == 1).tolist() == [[1, 0]]


def test_rooms_where_the_truth_is_unknown_are_left_out():
    """Room 1 only touches true room 4, 2 and 3 share it, 5 swallows true room 6, and 7 is elsewhere."""
    labels = image("1112233", "5555577")
    truth = image("0044444", "0000660")
    assert keep_rooms_at(labels, truth).tolist() == image("0002233", "5555500").tolist()
    assert not keep_rooms_at(labels, image("0000000", "0000000")).any()
    assert not keep_rooms_at(image("00"), image("11")).any()


def test_matching_rooms_have_more_than_half_in_common():
    """Found 2 has 3 of 4 pixels with true 9, found 3 has 2 of 3 with true 5, found 4 none; 2 of 4 are not enough."""
    assert match_rooms(image("222033300404"), image("999905500700")) == {2: 9, 3: 5}
    assert match_rooms(image("2233"), image("5550")) == {2: 5}
    assert match_rooms(image("3333"), image("0550")) == {}
    assert match_rooms(image("00"), image("00")) == {}


def test_different_shapes():
    with pytest.raises(FloorError, match=r"\(1, 2\).*\(1, 3\).*\(1, 2\)"):
        score_labels(image("11"), image("111"))


@given(labels=label_images, truth=label_images, counted=masks)
def test_shares_lie_between_zero_and_one_and_mirror(labels, truth, counted):
    scores = score_labels(labels, truth, counted=counted)
    mirrored = score_labels(truth, labels, counted=counted)
    assert all(0 <= share <= 1 for share in astuple(scores)[:6])
    assert (scores.a_fc, scores.precision, scores.reconstructed) == (mirrored.a_bc, mirrored.recall, mirrored.true)


@pytest.mark.slow
@given(labels=label_images, truth=label_images, ids=st.permutations([1, 2, 3, 4, 60000]))
def test_permuted_labels_score_the_same(labels, truth, ids):
    permuted = np.array([0, *ids], np.uint16)[labels]
    assert astuple(score_labels(permuted, truth)) == pytest.approx(astuple(score_labels(labels, truth)))


@pytest.mark.slow
@given(cuts=st.lists(st.integers(1, 19), min_size=2, max_size=6, unique=True).map(sorted), shift=st.integers(0, 5))
def test_polygons_and_pixels_agree_on_rectangles(cuts, shift):
    grid = GridMap(np.zeros((10, 20), np.int8), resolution=0.5)
    spans = list(pairwise(cuts))
    result = [box(left / 2, 0, right / 2, 4) for left, right in spans]
    truth = [box(left / 2, 1, (right + shift) / 2, 5) for left, right in spans if right + shift <= 20][::2]
    by_polygon = score_layout(result, truth)
    by_pixel = score_labels(*(label_rooms(polygons).label_image(grid) for polygons in (result, truth)))
    # Where true rooms overlap, an image can only hold one of them.
    if all(one.intersection(other).area == 0 for one in truth for other in truth if one is not other):
        assert astuple(by_pixel) == pytest.approx(astuple(by_polygon))


def label_rooms(polygons: list[Polygon]) -> Floor:
    return Floor(tuple(Room(number, polygon) for number, polygon in enumerate(polygons, start=1)))


def test_survey_rooms_are_large_white_patches():
    """Two squares of 400 px that touch by a corner, a darker one, and one of 399 px."""
    grey = np.zeros((60, 60), np.uint8)
    grey[:20, :20] = grey[20:40, 20:40] = 251
    grey[:20, 40:] = 250
    grey[40:, :20] = 255
    grey[40, 0] = 0
    labels = label_free_rooms(grey)
    assert (labels.max(), labels[0, 0] != labels[20, 20]) == (2, True)
    assert (labels > 0).sum() == 800
    assert not labels[40:, :20].any()


def test_patches_of_a_survey_truth_are_of_any_size():
    grey = np.array([[255, 250, 251], [255, 251, 0]], np.uint8)
    assert label_patches(grey).tolist() == [[1, 0, 2], [1, 1, 0]]


@pytest.mark.parametrize(("name", "rooms"), [("Freiburg101_scan", 10), ("lab_c_scan", 17), ("office_d", 25)])
def test_survey_truth_has_the_documented_rooms(data, name, rooms):
    assert read_survey_truth(data / "survey" / f"{name}_gt_segmentation.png").max() == rooms
