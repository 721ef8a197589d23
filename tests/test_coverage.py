"""Coverage of polygons, with answers worked out by hand."""

from dataclasses import astuple

import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import Polygon, box

from pianta.evaluation.coverage import (
    Scores,
    backward_coverage,
    forward_coverage,
    score_layout,
)

FLOOR = box(0, 0, 4, 1)
HALVES = [box(0, 0, 2, 1), box(2, 0, 4, 1)]
PERFECT = (1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
NOTHING = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
BOW_TIE = Polygon([(0, 0), (2, 2), (2, 0), (0, 2)])
SLIVER = Polygon([(0, 0), (1, 0), (2, 0)])

rooms = st.lists(
    st.builds(
        lambda x, y, width, height: box(x, y, x + width, y + height),
        *[st.integers(0, 20)] * 2,
        *[st.integers(1, 9)] * 2,
    ),
    max_size=6,
)


def test_same_rooms_score_one():
    assert score_layout(HALVES, HALVES[::-1]) == Scores(*PERFECT, reconstructed=2, true=2)


def test_split_room_lowers_backward_accuracy_only():
    """Each half lies in the room; the room lies half in each half, and neither half has an IoU above 0.5."""
    assert score_layout(HALVES, [FLOOR]) == Scores(1.0, 0.5, 1.0, 0.5, mean_iou=0.5, f1=0.0, reconstructed=2, true=1)


def test_merged_rooms_lower_forward_accuracy_only():
    assert score_layout([FLOOR], HALVES) == Scores(0.5, 1.0, 0.5, 1.0, mean_iou=0.5, f1=0.0, reconstructed=1, true=2)


def test_accuracy_weighs_by_area_and_precision_does_not():
    """A room of 9 m², two thirds of it true, and one of 1 m² that is all true; the truth reaches no further."""
    reconstructed = [box(0, 0, 3, 3), box(5, 0, 6, 1)]
    truth = [box(0, 0, 3, 2), box(5, 0, 6, 1)]
    assert score_layout(reconstructed, truth).a_fc == pytest.approx(7 / 10)
    assert score_layout(reconstructed, truth).precision == pytest.approx((2 / 3 + 1) / 2)
    assert score_layout(reconstructed, truth).a_bc == pytest.approx(1)
    assert score_layout(reconstructed, truth).recall == pytest.approx(1)
    scores = score_layout(reconstructed, truth)
    assert scores.mean_iou == pytest.approx((2 / 3 + 1) / 2)
    assert scores.f1 == 1


def test_room_that_overlaps_nothing_counts_zero():
    """Touching is no overlap."""
    reconstructed = [HALVES[0], box(4, 0, 6, 1)]
    assert forward_coverage(reconstructed, [FLOOR]) == [0, None]
    assert score_layout(reconstructed, [FLOOR]) == Scores(
        0.5, 0.5, 0.5, 0.5, mean_iou=0.5, f1=0.0, reconstructed=2, true=1
    )


def test_coverage_names_the_room_that_overlaps_most():
    reconstructed = [box(0, 0, 3, 1), box(3, 0, 4, 1), box(9, 9, 10, 10)]
    assert forward_coverage(reconstructed, HALVES) == [0, 1, None]
    assert backward_coverage(reconstructed, HALVES) == [0, 0]
    assert backward_coverage(reconstructed[1:], HALVES) == [None, 0]


@pytest.mark.parametrize(
    ("reconstructed", "truth", "shares"), [([], [FLOOR], NOTHING), ([FLOOR], [], NOTHING), ([], [], PERFECT)]
)
def test_empty_sides(reconstructed, truth, shares):
    assert astuple(score_layout(reconstructed, truth)) == (*shares, len(reconstructed), len(truth))
    assert forward_coverage(reconstructed, truth) == [None] * len(reconstructed)
    assert backward_coverage(reconstructed, truth) == [None] * len(truth)


def test_invalid_polygons_are_repaired():
    """The bow tie becomes its two triangles of 1 m² each, in a square of 4 m²."""
    scores = score_layout([BOW_TIE], [box(0, 0, 2, 2)])
    assert scores == Scores(1.0, 0.5, 1.0, 0.5, mean_iou=0.5, f1=0.0, reconstructed=1, true=1)


def test_spikes_are_repaired():
    spiked = Polygon([(0, 0), (4, 0), (4, 1), (2, 1), (2, 9), (2, 1), (0, 1)])
    assert not spiked.is_valid
    assert score_layout([spiked], HALVES) == score_layout([FLOOR], HALVES)


@given(corners=st.lists(st.tuples(st.integers(0, 4), st.integers(0, 4)), min_size=3, max_size=8))
def test_any_outline_can_be_scored(corners):
    scores = score_layout([Polygon(corners)], HALVES)
    assert all(0 <= share <= 1 for share in astuple(scores)[:6])


@pytest.mark.parametrize("nothing", [Polygon(), SLIVER])
def test_room_without_area_counts_zero(nothing):
    assert score_layout([FLOOR, nothing], [FLOOR]).precision == 0.5
    assert score_layout([FLOOR], [FLOOR, nothing]).recall == 0.5
    assert score_layout([nothing], [nothing]) == Scores(*NOTHING, reconstructed=1, true=1)


@pytest.mark.slow
@given(reconstructed=rooms, truth=rooms)
def test_shares_lie_between_zero_and_one_and_mirror(reconstructed, truth):
    scores, mirrored = score_layout(reconstructed, truth), score_layout(truth, reconstructed)
    assert all(0 <= share <= 1 for share in astuple(scores)[:6])
    assert (scores.a_fc, scores.precision, scores.reconstructed) == (mirrored.a_bc, mirrored.recall, mirrored.true)
    assert scores.f1 == mirrored.f1


@pytest.mark.slow
@given(reconstructed=rooms, truth=rooms, random=st.randoms())
def test_order_does_not_matter(reconstructed, truth, random):
    shuffled = random.sample(reconstructed, len(reconstructed))
    assert astuple(score_layout(shuffled, truth)) == pytest.approx(astuple(score_layout(reconstructed, truth)))
