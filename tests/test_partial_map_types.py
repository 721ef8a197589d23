"""Building types of parts of floors, by logistic regression and a forest, and the file of their model."""

from dataclasses import replace
from math import exp

import numpy as np
import pytest

from pianta.building_types.map_types import MIN_TYPE_PROBABILITY, OTHER, MapExamples, name_map_features
from pianta.building_types.partial_map_type_file import (
    DEFAULT_PARTIAL_MODEL,
    read_default_partial_map_type_model,
    read_partial_map_type_model,
    save_partial_map_type_model,
)
from pianta.building_types.partial_map_types import (
    MAX_DEVIATION,
    OTHER_WEIGHT,
    PartialMapTypeModel,
    Regression,
    compute_weights,
    predict_left_out_parts,
    train_partial_map_types,
)
from pianta.errors import LabelError, ModelError
from pianta.rooms.model_archive import pack_archive

MAX_PARTIAL_BYTES = 1_500_000
FEATURES = len(name_map_features())
CLASSES = ("office", OTHER, "school")


def make_examples(buildings: int = 12) -> MapExamples:
    """Three parts of each building; ten features are larger in schools, ten others in offices."""
    types = tuple(CLASSES[number // 3 % 3] for number in range(3 * buildings))
    features = np.random.default_rng(0).normal(0, 1, (3 * buildings, FEATURES))
    features[:, :10] += 5 * np.array([name == "school" for name in types])[:, None]
    features[:, 10:20] += 5 * np.array([name == "office" for name in types])[:, None]
    names = tuple(f"b{number // 3}" for number in range(3 * buildings))
    return MapExamples(features, types, names, ("drawn", "mapped", "mapped") * buildings)


@pytest.fixture(scope="module")
def model() -> PartialMapTypeModel:
    return train_partial_map_types(make_examples())


def make_regression(weight: float) -> Regression:
    """Of a single feature, which counts for schools; its mean is 2 and its spread 0.5."""
    weights = np.array([[0.0], [0.0], [weight]])
    return Regression(np.array([2.0]), np.array([0.5]), weights, np.zeros(3))


def test_probabilities_of_the_regression_by_hand():
    # (3 - 2) / 0.5 = 2, and the scores are 0, 0 and 2 · 1.5 = 3
    (chances,) = make_regression(1.5).predict(np.array([[3.0]]))
    assert chances == pytest.approx(np.array([1, 1, exp(3)]) / (2 + exp(3)))


def test_features_far_from_all_of_the_training_count_as_its_border():
    features = 2 + 0.5 * np.array([[MAX_DEVIATION], [2 * MAX_DEVIATION], [100.0]])
    border, far, farther = make_regression(1.0).predict(features)
    np.testing.assert_array_equal(border, far)
    np.testing.assert_array_equal(border, farther)


def test_the_prediction_is_the_geometric_mean_of_both(model):
    features = make_examples().features[:4]
    by_regression, by_forest = model.regression.predict(features), model.forest.predict(features)
    # Temperatures of 0.8 and 0.5; no probability counts less than 0.01
    both = np.maximum(by_regression, 0.01) ** (0.5 / 0.8) * np.maximum(by_forest, 0.01) ** (0.5 / 0.5)
    assert model.predict_chances(features) == pytest.approx(both / both.sum(axis=1, keepdims=True))
    assert model.predict_description(features[0]).neither == pytest.approx(model.predict_chances(features)[0, 1])


def test_all_sources_count_the_same_and_in_each_all_its_types_and_buildings():
    sources = ("drawn",) * 4 + ("mapped",) * 2
    types = ("school", "school", "school", "office", "office", "office")
    buildings = ("a", "a", "b", "c", "d", "e")
    examples = MapExamples(np.zeros((6, FEATURES)), types, buildings, sources)
    # drawn: schools half of it, of which a has two rows; offices the other half. mapped: offices alone
    expected = np.array([1 / 8, 1 / 8, 1 / 4, 1 / 2, 1 / 2, 1 / 2])
    assert compute_weights(examples) == pytest.approx(expected * 6 / 2)


def test_other_counts_twice():
    examples = MapExamples(np.zeros((2, FEATURES)), ("school", OTHER), ("a", "b"), ("made", "made"))
    assert OTHER_WEIGHT == 2
    assert compute_weights(examples) == pytest.approx([2 / 3, 4 / 3])
    # A source without it counts less: 1 of 1 + 1.5
    sources = MapExamples(
        np.zeros((3, FEATURES)), ("school", OTHER, "school"), ("a", "b", "c"), ("made", "made", "drawn")
    )
    assert compute_weights(sources) == pytest.approx(np.array([0.5, 1, 1]) * 3 / 2.5)


def test_types_that_differ_are_recognised_in_buildings_that_were_left_out():
    examples = make_examples(buildings=30)
    chances = predict_left_out_parts(examples)
    assert chances.sum(axis=1) == pytest.approx(np.ones(90))
    assert np.mean(chances.argmax(axis=1) == examples.truth) > 0.95


def test_a_building_is_left_out(model):
    without = model.leave_out("b0")
    assert "b0" not in without.examples.buildings
    assert len(without.examples.types) == 33
    assert not np.allclose(without.regression.weights, model.regression.weights)


def test_a_feature_that_never_varies_does_not_count():
    examples = make_examples()
    features = examples.features.copy()
    features[:, 7] = 4.0
    features[::2, 7] += 1e-15
    trained = train_partial_map_types(replace(examples, features=features))
    assert trained.regression.weights[:, 7] == pytest.approx(np.zeros(3))


def test_two_types_are_too_few():
    examples = make_examples()
    with pytest.raises(LabelError, match="parts are of 2 types, give 3, of which one may be 'other'"):
        train_partial_map_types(examples.select(examples.truth > 0))


def test_a_model_of_other_types_than_its_weights_is_refused(model):
    with pytest.raises(ModelError, match="not over the 2 types"):
        replace(model, classes=CLASSES[:2])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"mean": np.zeros(3)}, "have other shapes"),
        ({"biases": np.array([0.0, np.nan, 0.0])}, "not a number up to 1e"),
        ({"weights": np.full((3, 1), 1e300)}, "not a number up to 1e"),
        ({"spread": np.zeros(1)}, "spread of a feature is below 1e-06"),
        ({"spread": np.full(1, 1e-300)}, "spread of a feature is below 1e-06"),
    ],
)
def test_weights_that_cannot_be_right_are_refused(change, message):
    with pytest.raises(ModelError, match=message):
        replace(make_regression(1.0), **change)


def test_round_trip(model, tmp_path):
    save_partial_map_type_model(model, tmp_path / "m.npz")
    read = read_partial_map_type_model(tmp_path / "m.npz")
    features = np.random.default_rng(1).normal(0, 2, (9, FEATURES))
    np.testing.assert_array_equal(read.predict_chances(features), model.predict_chances(features))
    assert read.examples.sources == model.examples.sources
    save_partial_map_type_model(read, tmp_path / "again.npz")
    assert (tmp_path / "m.npz").read_bytes() == (tmp_path / "again.npz").read_bytes()


def test_damaged_files_are_refused_in_one_line(model, tmp_path):
    path = tmp_path / "m.npz"
    save_partial_map_type_model(model, path)
    content = path.read_bytes()
    with np.load(path) as archive:
        text = archive["pianta.json"].decode()
        arrays = {name: archive[name] for name in archive.files if name != "pianta.json"}
    cases = {
        "is empty": b"",
        "no model": content[:-100],
        "weights are damaged": pack_archive(text, "pianta.json", arrays | {"spread": -arrays["spread"]}),
        "trees are damaged": pack_archive(text, "pianta.json", arrays | {"votes": -arrays["votes"]}),
        "weights are over other": pack_archive(
            text,
            "pianta.json",
            arrays | {"weights": arrays["weights"][:2].copy(), "biases": arrays["biases"][:2]},
        ),
        "'mean' is": pack_archive(text, "pianta.json", arrays | {"mean": arrays["mean"][None]}),
        "examples are not finite": pack_archive(
            text, "pianta.json", arrays | {"examples": arrays["examples"] * np.nan}
        ),
        "types of its header": pack_archive(text.replace('"office"', '"home"', 1), "pianta.json", arrays),
        "examples are not those": pack_archive(text, "pianta.json", arrays | {"examples": arrays["examples"][1:]}),
        "other features": pack_archive(text.replace("mean compactness", "mean x"), "pianta.json", arrays),
    }
    for message, damaged in cases.items():
        path.write_bytes(damaged)
        with pytest.raises(ModelError) as caught:
            read_partial_map_type_model(path)
        assert message in str(caught.value)
        assert "\n" not in str(caught.value)


def test_the_model_that_comes_with_pianta():
    model = read_default_partial_map_type_model()
    assert model.classes == CLASSES
    assert set(model.examples.sources) == {"drawn", "mapped", "made"}
    assert DEFAULT_PARTIAL_MODEL.stat().st_size < MAX_PARTIAL_BYTES
    # It has seen these examples
    examples = model.examples
    is_right = model.predict_chances(examples.features).argmax(axis=1) == examples.truth
    for source, name in {*zip(examples.sources, examples.types, strict=True)}:
        chosen = (np.array(examples.sources) == source) & (np.array(examples.types) == name)
        assert is_right[chosen].mean() > 0.7, (source, name)


@pytest.mark.slow
def test_parts_of_buildings_that_were_left_out():
    """The readings of maps of which a robot had seen a part, that the model of pianta was trained on."""
    examples = read_default_partial_map_type_model().examples
    chances = predict_left_out_parts(examples)
    is_right = chances.argmax(axis=1) == examples.truth
    weights = compute_weights(examples)
    for source, least in (("drawn", 0.7), ("mapped", 0.7), ("made", 0.6)):
        chosen = np.array(examples.sources) == source
        assert np.average(is_right[chosen], weights=weights[chosen]) > least
    # Neither is seldom given a type
    is_other = examples.truth == examples.classes.index(OTHER)
    is_wrong = (chances.max(axis=1) >= MIN_TYPE_PROBABILITY) & ~is_right
    assert np.average(is_wrong[is_other], weights=weights[is_other]) < 0.25
