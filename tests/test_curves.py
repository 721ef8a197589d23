"""Curves of four items, whose points and areas are reckoned by hand."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import OptionError
from pianta.evaluation.curves import measure_precision_recall, measure_roc

TRUTH = [True, False, True, False]
SCORES = [0.9, 0.8, 0.7, 0.1]


def test_roc_by_hand():
    curve = measure_roc(TRUTH, SCORES)
    np.testing.assert_allclose(curve.x, [0, 0, 0.5, 0.5, 1])
    np.testing.assert_allclose(curve.y, [0, 0.5, 0.5, 1, 1])
    assert (curve.area, curve.chance) == (0.75, 0.5)


def test_precision_recall_by_hand():
    curve = measure_precision_recall([*TRUTH, False], [*SCORES, 0.0])
    # From the highest score down: 1 of 1, 1 of 2, 2 of 3, 2 of 4, 2 of 5.
    np.testing.assert_allclose(curve.x, [0, 0.5, 0.5, 1, 1, 1])
    np.testing.assert_allclose(curve.y, [1, 1, 1 / 2, 2 / 3, 2 / 4, 2 / 5])
    assert curve.area == pytest.approx(0.5 * 1 + 0.5 * 2 / 3)
    assert curve.chance == pytest.approx(2 / 5)


def test_equal_scores_are_one_point():
    assert measure_roc(TRUTH, [1.0] * 4).x.tolist() == [0, 1]
    assert measure_roc(TRUTH, [1.0] * 4).area == 0.5
    assert measure_precision_recall(TRUTH, [1.0] * 4).area == 0.5


@pytest.mark.slow
@given(st.lists(st.tuples(st.booleans(), st.integers(-5, 5)), min_size=2, max_size=30))
def test_curves_stay_within_their_axes(items):
    truth, scores = [positive for positive, _ in items], [float(score) for _, score in items]
    if all(truth) or not any(truth):
        return
    roc, turned = measure_roc(truth, scores), measure_roc(truth, [-score for score in scores])
    assert roc.area + turned.area == pytest.approx(1)
    for curve in (roc, measure_precision_recall(truth, scores)):
        assert (np.diff(curve.x) >= 0).all()
        assert ((curve.x >= 0) & (curve.x <= 1) & (curve.y >= 0) & (curve.y <= 1)).all()
        assert 0 <= curve.area <= 1
        # A threshold's order alone counts.
    assert measure_roc(truth, [score**3 + 7 for score in scores]).area == roc.area


@pytest.mark.parametrize(
    ("truth", "scores", "message"),
    [
        ([True, True], [0.1, 0.2], "positive"),
        ([False], [0.1], "positive"),
        ([], [], "positive"),
        ([True, False], [0.1], "scores"),
        ([True, False], [0.1, float("nan")], "finite"),
    ],
)
def test_what_has_no_curve(truth, scores, message):
    for measure in (measure_roc, measure_precision_recall):
        with pytest.raises(OptionError, match=message):
            measure(truth, scores)
