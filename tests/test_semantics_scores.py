"""Semantic accuracy, confusion and calibration, against answers by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import Polygon, box

from pianta.evaluation.semantics import (
    LabelPair,
    count_confusion,
    measure_reliability,
    pair_backward,
    pair_forward,
    semantic_accuracy,
)

# A corridor above two rooms, 10 m × 2 m and twice 5 m × 4 m.
TRUTH = [box(0, 4, 10, 6), box(0, 0, 5, 4), box(5, 0, 10, 4)]
TRUE_LABELS = ["C", "F", "S"]


def score(rooms: list[Polygon], labels: list[str]) -> tuple[float, float]:
    """SemanticAccuracy_FC and SemanticAccuracy_BC against the truth (eqs. 5.1 and 5.2)."""
    ways = pair_forward, pair_backward
    forward, backward = (semantic_accuracy(pair(rooms, labels, TRUTH, TRUE_LABELS)) for pair in ways)
    return forward, backward


def test_a_layout_that_is_the_truth_is_predicted_by_its_labels_alone():
    assert score(TRUTH, TRUE_LABELS) == (1, 1)
    assert score(TRUTH, ["C", "S", "S"]) == (2 / 3, 2 / 3)


def test_a_corridor_in_parts_is_right_when_all_parts_are():
    """The example of section 5.3: over-segmentation alone does not change the scores."""
    parts = [box(0, 4, 3, 6), box(3, 4, 6, 6), box(6, 4, 10, 6), *TRUTH[1:]]
    assert score(parts, ["C", "C", "C", "F", "S"]) == (1, 1)
    # The largest part is BC of the corridor.
    assert score(parts, ["C", "C", "F", "F", "S"]) == (4 / 5, 2 / 3)
    assert score(parts, ["F", "F", "C", "F", "S"]) == (3 / 5, 1)


def test_rooms_in_one_can_be_right_for_one_of_them():
    merged = [TRUTH[0], box(0, 0, 10, 4)]
    # FC of the merged room is the larger of its true rooms, here the first of two equal ones.
    assert score(merged, ["C", "F"]) == (1, 2 / 3)


def test_what_overlaps_nothing_is_wrong():
    result = [TRUTH[0], box(20, 0, 25, 4)]
    assert score(result, ["C", "F"]) == (1 / 2, 1 / 3)
    assert pair_forward(result, ["C", "F"], TRUTH, TRUE_LABELS) == [LabelPair("C", "C"), LabelPair("F", None)]
    backward = pair_backward(result, ["C", "F"], TRUTH, TRUE_LABELS)
    assert backward == [LabelPair("C", "C"), LabelPair(None, "F"), LabelPair(None, "S")]
    assert not LabelPair(None, None).agree


def test_without_rooms():
    assert score([], []) == (1, 0)
    assert pair_forward(TRUTH, TRUE_LABELS, [], []) == [LabelPair(label, None) for label in TRUE_LABELS]
    assert pair_backward(TRUTH, TRUE_LABELS, [], []) == []


@pytest.mark.parametrize("labels", [["C"], ["C", "F", "S", "S"]])
def test_each_room_needs_a_label(labels: list[str]):
    for pair in (pair_forward, pair_backward):
        with pytest.raises(ValueError, match=r"3 rooms have|zip"):
            pair(TRUTH, labels, TRUTH, TRUE_LABELS)
        with pytest.raises(ValueError, match=r"3 rooms have|zip"):
            pair(TRUTH, TRUE_LABELS, TRUTH, labels)


def test_confusion_in_per_cent_of_the_true_label():
    pairs = [("F", "F"), ("F", "F"), ("S", "F"), (None, "F"), ("F", "C"), ("C", None)]
    result = count_confusion([LabelPair(*pair) for pair in pairs], "FCS")
    np.testing.assert_array_equal(result, [[50, 0, 25, 25], [100, 0, 0, 0], [np.nan] * 4])
    with pytest.raises(ValueError, match="not in list"):
        count_confusion([LabelPair("E", "F")], "FCS")


def test_calibration_by_hand():
    # Four rooms near 0.75, three right; two near 0.95, one right: 4/6 of 0.02 and 2/6 of 0.45.
    confident = np.array([0.72, 0.72, 0.74, 0.74, 0.94, 0.96])
    probabilities = np.column_stack([confident, 1 - confident])
    curve = measure_reliability(probabilities, np.array([0, 0, 0, 1, 0, 1]))
    assert curve.counts.tolist() == [0, 0, 0, 0, 0, 0, 0, 4, 0, 2]
    np.testing.assert_allclose(curve.confidence[[7, 9]], [0.73, 0.95])
    np.testing.assert_allclose(curve.accuracy[[7, 9]], [0.75, 0.5])
    assert np.isnan(curve.accuracy[8])
    assert curve.error == pytest.approx((4 * 0.02 + 2 * 0.45) / 6)


def test_bins_hold_their_upper_edges():
    curve = measure_reliability(np.array([[0.5, 0.5], [1.0, 0.0], [0.0, 1.0]]), np.array([0, 0, 0]), bins=2)
    assert curve.edges.tolist() == [0, 0.5, 1]
    assert curve.counts.tolist() == [1, 2]
    assert curve.accuracy.tolist() == [1, 0.5]


def test_no_rooms_have_no_calibration():
    curve = measure_reliability(np.zeros((0, 4)), np.zeros(0, int))
    assert curve.counts.tolist() == [0] * 10
    assert np.isnan(curve.error)


@given(st.lists(st.tuples(st.floats(0.5, 1), st.booleans()), min_size=1, max_size=30))
def test_the_error_is_at_least_the_mean_distance(rooms: list[tuple[float, bool]]):
    """Bins can only add up distances: the error is at least |accuracy - mean confidence|, and at most 1."""
    confident, right = np.array([confident for confident, _ in rooms]), np.array([right for _, right in rooms])
    # argmax takes the first of two equal columns.
    curve = measure_reliability(np.column_stack([confident, 1 - confident]), np.where(right, 0, 1))
    assert curve.counts.sum() == len(rooms)
    assert abs(confident.mean() - right.mean()) - 1e-9 <= curve.error <= 1
