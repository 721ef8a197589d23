import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pianta_bench.types.rule_induction import Condition, Rule, RuleInduction


def test_a_threshold_between_two_classes_is_one_rule():
    features = np.array([[1.0, 7.0]] * 12 + [[2.0, 7.0]] * 6)
    labels = np.array(["many"] * 12 + ["few"] * 6)
    learnt = RuleInduction().fit(features, labels)
    assert learnt.rules == (Rule("few", (Condition(0, 1.5, above=True),)), Rule("many"))
    assert learnt.predict(np.array([[1.6, 0.0], [1.4, 9.0]])).tolist() == ["few", "many"]


def test_a_corner_needs_two_conditions():
    grid = np.array([[x, y] for x in range(10) for y in range(10)], float)
    corner = (grid > 6).all(axis=1)
    learnt = RuleInduction().fit(grid, np.where(corner, "corner", "rest"))
    (rule, default) = learnt.rules
    assert {(each.feature, each.threshold, each.above) for each in rule.conditions} == {(0, 6.5, True), (1, 6.5, True)}
    assert default == Rule("rest")


def test_rare_classes_come_first_and_the_commonest_is_the_default():
    features = np.repeat([1.0, 2.0, 3.0], [30, 10, 20])[:, None]
    labels = np.repeat(["common", "rare", "middling"], [30, 10, 20])
    learnt = RuleInduction().fit(features, labels)
    assert [rule.label for rule in learnt.rules] == ["rare", "middling", "common"]
    assert (learnt.predict(features) == labels).all()


def test_what_was_grown_on_noise_is_pruned_away():
    random = np.random.default_rng(5)
    features = random.random((400, 3))
    right = features[:, 0] > 0.5
    labels = np.where(right ^ (random.random(400) < 0.1), "a", "b")
    fresh = random.random((2000, 3))
    predicted = RuleInduction().fit(features, labels).predict(fresh) == "a"
    assert (predicted == (fresh[:, 0] > 0.5)).mean() > 0.9


def test_the_middle_of_neighbouring_floats_divides_them():
    low = 1.0000000000000002
    high = np.nextafter(low, 2)
    assert (low + high) / 2 == high
    features = np.repeat([low, high], 9)[:, None]
    labels = np.repeat(["a", "b"], 9)
    assert (RuleInduction().fit(features, labels).predict(features) == labels).all()


@pytest.mark.slow
@given(
    arrays(float, st.tuples(st.integers(1, 30), st.just(2)), elements=st.integers(0, 4).map(float)),
    st.randoms(use_true_random=False),
)
def test_it_ends_and_gives_labels_that_it_knows(features, random):
    labels = np.array([random.choice("abc") for _ in features])
    learnt = RuleInduction(seed=3).fit(features, labels)
    assert learnt.rules[-1].conditions == ()
    assert all(rule.conditions for rule in learnt.rules[:-1])
    given_labels = learnt.predict(features)
    assert set(given_labels) <= set(labels)
    assert (given_labels == RuleInduction(seed=3).fit(features, labels).predict(features)).all()


@pytest.mark.parametrize(("above", "covered"), [(True, [False, True]), (False, [True, False])])
def test_a_threshold_itself_is_not_above(above, covered):
    assert Condition(0, 2.0, above=above).covers(np.array([[2.0], [2.1]])).tolist() == covered
