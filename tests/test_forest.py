"""The forest of arrays says what scikit-learn says."""

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.ensemble import ExtraTreesClassifier

from pianta.errors import ModelError
from pianta.rooms.extra_trees import ExtraTrees, TreeParameters, grow_extra_trees
from pianta.rooms.forest import LEAF, Forest

CLASSES = 5


def hand_made() -> Forest:
    """Two trees: one asks feature 0 and then 1, the other is a leaf.

    Nodes in level order: root of the first, the leaf that is the second; then the first's left leaf and its right
    child; then the two leaves of that.
    """
    features = np.array([0, LEAF, LEAF, 1, LEAF, LEAF], np.int16)
    votes = np.array([[0.5, 0.5], [1.0, 0.0], [0.25, 0.75], [0.0, 1.0]])
    return Forest(features, np.array([2.0, -1.0], np.float32), votes)


def test_a_forest_by_hand():
    rooms = np.array([[2.0, 9.0], [2.1, -1.0], [2.1, -0.9]])
    # The second tree says 0.5 of all.
    assert hand_made().predict(rooms).tolist() == [[0.75, 0.25], [0.375, 0.625], [0.25, 0.75]]
    assert (hand_made().trees, hand_made().classes) == (2, 2)


def test_no_rooms():
    assert hand_made().predict(np.zeros((0, 2))).shape == (0, 2)


def test_a_tree_that_is_one_leaf():
    forest = Forest(np.array([LEAF], np.int16), np.zeros(0, np.float32), np.array([[0.2, 0.8]]))
    assert forest.predict(np.zeros((3, 1))).tolist() == [[0.2, 0.8]] * 3


@st.composite
def trained(draw: st.DrawFn) -> tuple[ExtraTreesClassifier, np.random.Generator]:
    """Extra-Trees on random rooms, some of them of two classes only."""
    random = np.random.default_rng(draw(st.integers(0, 10**6)))
    rooms, width = draw(st.integers(2, 80)), draw(st.integers(1, 8))
    features = random.normal(size=(rooms, width)) * 10.0 ** random.integers(-9, 9, width)
    # Features that repeat, and whole numbers, as counts of doors are.
    features[:, 0] = random.integers(0, 4, rooms)
    truth = random.choice([0, 2, 3, 4][: draw(st.integers(2, 4))], rooms)
    forest = ExtraTreesClassifier(
        draw(st.integers(1, 12)),
        min_samples_leaf=draw(st.integers(1, 4)),
        max_leaf_nodes=draw(st.sampled_from([None, 8])),
        random_state=0,
    )
    weights = random.choice([1.0, 0.3], rooms)
    return forest.fit(features, truth, weights), random


def to_extra_trees(classifier: ExtraTreesClassifier) -> ExtraTrees:
    return ExtraTrees([estimator.tree_ for estimator in classifier.estimators_], classifier.classes_)


@pytest.mark.parametrize("directly", [True, False], ids=["by the builder", "by the classifier"])
@pytest.mark.parametrize(
    ("parameters", "same"),
    [
        (TreeParameters(trees=15), {}),
        (
            TreeParameters(trees=15, feature_share=0.4, min_leaf=4),
            {"max_features": 0.4, "min_samples_leaf": 4},
        ),
        (TreeParameters(trees=15, feature_share=0.4, max_leaves=6), {"max_features": 0.4, "max_leaf_nodes": 6}),
    ],
    ids=["default", "leaves", "best first"],
)
@pytest.mark.parametrize("weighted", [True, False], ids=["weights", "no weights"])
def test_the_same_trees_as_of_the_classifier(parameters, same, weighted, directly, monkeypatch):
    if not directly:
        # As if scikit-learn had moved its builder
        monkeypatch.setitem(sys.modules, "sklearn.tree._splitter", None)
    random = np.random.default_rng(7)
    features = random.normal(size=(300, 9))
    features[:, 0] = random.integers(0, 4, 300)
    truth = random.choice([0, 2, 3], 300)
    weights = random.choice([1.0, 0.3], 300) if weighted else None
    forest = grow_extra_trees(features, truth, weights, parameters=parameters, seed=4)
    classifier = ExtraTreesClassifier(15, random_state=4, **same).fit(features, truth, weights)
    for tree, estimator in zip(forest.trees, classifier.estimators_, strict=True):
        for name in ("feature", "threshold", "value", "children_left", "children_right"):
            np.testing.assert_array_equal(getattr(tree, name), getattr(estimator.tree_, name))
    rows = random.normal(size=(50, 9))
    predicted = forest.class_probabilities(rows, CLASSES)
    np.testing.assert_array_equal(predicted[:, [0, 2, 3]], classifier.predict_proba(rows))
    assert not predicted[:, [1, 4]].any()


@given(trained())
@settings(max_examples=60, deadline=None)
def test_predictions_equal_those_of_scikit_learn(result):
    classifier, random = result
    rooms = random.normal(size=(40, classifier.n_features_in_)) * 10.0 ** random.integers(-9, 9)
    rooms[:, 0] = random.integers(0, 4, 40)
    predicted = Forest.from_trees(to_extra_trees(classifier), CLASSES).predict(rooms)
    np.testing.assert_allclose(predicted[:, classifier.classes_], classifier.predict_proba(rooms), rtol=0, atol=1e-12)
    assert predicted.sum(axis=1) == pytest.approx(1)
    assert not np.delete(predicted, classifier.classes_, axis=1).any()


def test_rooms_on_the_threshold_go_where_scikit_learn_sends_them():
    """A threshold that float32 does not have, and rooms on both sides of it."""
    random = np.random.default_rng(3)
    features = random.random((50, 1))
    classifier = ExtraTreesClassifier(20, random_state=1).fit(features, random.integers(0, 2, 50))
    thresholds = np.concatenate([tree.tree_.threshold for tree in classifier.estimators_]).astype(np.float32)
    near = [np.nextafter(thresholds, np.float32(end)) for end in (-np.inf, np.inf)]
    rooms = np.concatenate([thresholds, *near]).astype(np.float64)[:, None]
    predicted = Forest.from_trees(to_extra_trees(classifier), 2).predict(rooms)
    np.testing.assert_array_equal(predicted, classifier.predict_proba(rooms))


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        ({"features": [0, 0, LEAF, LEAF, LEAF, LEAF]}, None),
        ({"features": [LEAF, 0, LEAF, 1, LEAF, LEAF]}, None),
        # The first node's children would be the second and the third, which are as deep as itself.
        ({"features": [LEAF, LEAF, LEAF, LEAF, 0, 1]}, "does not lead downwards"),
        ({"features": [LEAF, LEAF, 0, LEAF, LEAF, 1]}, "does not lead downwards"),
        ({"features": [0, LEAF, LEAF, LEAF, 1, LEAF]}, "does not lead downwards"),
        ({"features": [0, LEAF, LEAF, -2, LEAF, LEAF]}, "feature -2"),
        ({"features": [0, LEAF, LEAF, LEAF, LEAF, LEAF]}, "1 inner nodes and 5 leaves"),
        ({"features": [0, 0, 1, LEAF, LEAF, LEAF]}, "3 inner nodes"),
        ({"features": []}, "make no tree"),
        ({"features": [0, 1, LEAF, LEAF]}, "make no tree"),
        ({"thresholds": [2.0, np.nan]}, "not finite"),
        ({"thresholds": [np.inf, 0.0]}, "not finite"),
        ({"thresholds": [0.0]}, "2 inner nodes and 4 leaves have 1 thresholds"),
        ({"votes": [[1.0, 0.0]] * 3}, "3 votes"),
        ({"votes": [[1.0, 0.0]] * 3 + [[0.5, 0.6]]}, "no shares"),
        ({"votes": [[1.0, 0.0]] * 3 + [[1.5, -0.5]]}, "no shares"),
        ({"votes": [[1.0, 0.0]] * 3 + [[np.nan, 1.0]]}, "no shares"),
        ({"votes": [[1.0, 0.0]] * 3 + [[np.inf, -np.inf]]}, "no shares"),
        ({"votes": [[]] * 4}, "no shares"),
    ],
)
def test_arrays_that_are_no_forest(changed, fault):
    types = {"features": np.int16, "thresholds": np.float32, "votes": np.float64}
    arrays = {name: getattr(hand_made(), name) for name in types}
    arrays |= {name: np.array(values, types[name]) for name, values in changed.items()}
    if fault is None:
        assert Forest(**arrays).predict(np.zeros((1, 2))).sum() == 1
        return
    with pytest.raises(ModelError, match=fault) as caught:
        Forest(**arrays)
    assert "\n" not in str(caught.value)


@given(st.lists(st.integers(-1, 2), min_size=1, max_size=30))
def test_whatever_is_taken_can_be_walked_through(features):
    inner = sum(feature >= 0 for feature in features)
    votes = np.ones((len(features) - inner, 1))
    try:
        forest = Forest(np.array(features, np.int16), np.zeros(inner, np.float32), votes)
    except ModelError:
        return
    assert forest.predict(np.eye(3)).tolist() == [[1.0]] * 3
