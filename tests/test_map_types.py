"""Building types of floors that were read from maps, by their rooms alone."""

from dataclasses import replace
from math import exp, log
from typing import Any

import numpy as np
import pytest
from shapely import LineString, affinity, box

import pianta
from pianta.building_types.classify import classify_building, predict_map_type
from pianta.building_types.map_type_file import (
    DEFAULT_MODEL,
    read_default_map_type_model,
    read_map_type_model,
    save_map_type_model,
)
from pianta.building_types.map_types import (
    FLOOR_FEATURES,
    MIN_TYPE_PROBABILITY,
    OTHER,
    MapExamples,
    MapTypePrediction,
    describe_map,
    name_map_features,
    predict_left_out,
    soften,
    train_map_types,
)
from pianta.errors import LabelError, ModelError
from pianta.floor import Door, Floor, Room
from pianta.reading._labelling import describe_type
from pianta.rooms.features import CONTEXT_FEATURES, describe_rooms

# Three rooms of 12, 12 and 6 m² in a row, with doors between them.
ROW = Floor(
    rooms=(Room(1, box(0, 0, 4, 3)), Room(2, box(4, 0, 8, 3)), Room(3, box(8, 0, 10, 3))),
    doors=(Door((1, 2), LineString([(4, 1), (4, 2)]), 1.0), Door((2, 3), LineString([(8, 1), (8, 2)]), 1.0)),
)
MAX_DEFAULT_BYTES = 400_000


def make_examples(seed: int = 0) -> MapExamples:
    """30 floors of 15 buildings; all features are around -2 for offices, 0 for others and 2 for schools."""
    rng = np.random.default_rng(seed)
    types = ("office", OTHER, "school") * 10
    features = rng.normal(0, 0.2, (30, len(name_map_features())))
    features += np.array([{"office": -2, OTHER: 0, "school": 2}[name] for name in types])[:, None]
    return MapExamples(features, types, tuple(f"b{i // 2}" for i in range(30)), tuple(f"f{i}" for i in range(30)))


@pytest.fixture(scope="module")
def model():
    return train_map_types(make_examples())


def test_features_of_the_floor_by_hand():
    features = dict(zip(name_map_features(), describe_map(describe_rooms(ROW)), strict=True))
    assert len(features) == 2 * len(CONTEXT_FEATURES) + len(FLOOR_FEATURES)
    assert features["rooms"] == pytest.approx(log(3))
    assert features["largest_share"] == pytest.approx(log(0.4))
    assert features["concentration"] == pytest.approx(log(0.16 + 0.16 + 0.04))
    assert features["share_of_largest_rooms"] == pytest.approx(1)
    assert features["median_to_mean_area"] == pytest.approx(log(1.2))
    assert features["mean degree"] == pytest.approx(4 / 3)
    assert features["mean degree by area"] == pytest.approx(0.4 * 1 + 0.4 * 2 + 0.2 * 1)


def test_features_do_not_depend_on_scale_turn_and_order():
    def change(shape: Any) -> Any:
        return affinity.rotate(affinity.scale(shape, 3, 3, origin=(0, 0)), 30, origin=(0, 0))

    doors = [replace(door, line=change(door.line), width=3 * door.width) for door in ROW.doors]
    changed = Floor(tuple(replace(room, polygon=change(room.polygon)) for room in ROW.rooms[::-1]), tuple(doors))
    expected, changed_features = (describe_map(describe_rooms(floor)) for floor in (ROW, changed))
    np.testing.assert_allclose(changed_features, expected, atol=1e-6)


def test_types_and_buildings_count_the_same():
    examples = MapExamples(np.zeros((4, 1)), ("office", "school", "school", "school"), ("a", "b", "b", "c"), ("",) * 4)
    # Half for each type, half of that for each school: 1/2, 1/8, 1/8, 1/4, times four floors.
    np.testing.assert_allclose(examples.weigh(), [2, 0.5, 0.5, 1])


def test_soft_probabilities_by_hand():
    np.testing.assert_allclose(soften(np.array([[0.8, 0.2, 0.0]]), 1), [[0.8 / 1.01, 0.2 / 1.01, 0.01 / 1.01]])
    softer = soften(np.array([[0.8, 0.2]]), 2)[0]
    assert softer[0] / softer[1] == pytest.approx(exp(log(4) / 2))


def test_types_of_new_floors(model):
    assert model.classes == ("office", OTHER, "school")
    assert model.building_types == ("office", "school")
    for name, value in (("office", -2), ("school", 2)):
        prediction = model.predict_description(np.full(len(name_map_features()), value, float))
        assert prediction.is_known
        assert prediction.likeliest == name
        assert sum(prediction.probabilities.values()) + prediction.neither == pytest.approx(1)
    neither = model.predict_description(np.zeros(len(name_map_features())))
    assert not neither.is_known
    assert neither.neither > MIN_TYPE_PROBABILITY


def test_a_building_is_left_out_with_all_its_floors():
    examples = make_examples()
    # One building is called what it is not; only a model that has seen it repeats that.
    types = tuple(
        "school" if building == "b0" else name
        for name, building in zip(examples.types, examples.buildings, strict=True)
    )
    wrong = replace(examples, types=types)
    votes = predict_left_out(wrong)
    assert wrong.classes[int(votes[0].argmax())] == "office"
    without = train_map_types(wrong).leave_out("b0")
    assert "b0" not in without.examples.buildings
    assert len(without.examples.types) == 28
    assert without.predict_description(examples.features[0]).likeliest == "office"


def test_limit_of_known_types():
    assert MapTypePrediction({"office": MIN_TYPE_PROBABILITY, "school": 0.1}, 0.35).is_known
    assert not MapTypePrediction({"office": 0.5, "school": 0.4}, 0.1).is_known


def test_round_trip(model, tmp_path):
    save_map_type_model(model, tmp_path / "m.npz")
    read = read_map_type_model(tmp_path / "m.npz")
    features = make_examples(seed=1).features
    for row in features:
        assert read.predict_description(row) == model.predict_description(row)
    assert (read.examples.types, read.examples.buildings) == (model.examples.types, model.examples.buildings)
    save_map_type_model(read, tmp_path / "again.npz")
    assert (tmp_path / "m.npz").read_bytes() == (tmp_path / "again.npz").read_bytes()

    save_map_type_model(model, tmp_path / "m.npz")
    content = (tmp_path / "m.npz").read_bytes()
    for damaged in (b"", content[:-100], content.replace(b"pianta.json", b"pianta.jsox")):
        (tmp_path / "bad.npz").write_bytes(damaged)
        with pytest.raises(ModelError) as caught:
            read_map_type_model(tmp_path / "bad.npz")
        assert "\n" not in str(caught.value)


def test_the_model_that_comes_with_pianta():
    model = read_default_map_type_model()
    assert model.classes == ("office", OTHER, "school")
    assert DEFAULT_MODEL.stat().st_size < MAX_DEFAULT_BYTES
    with pytest.raises(LabelError, match="no rooms"):
        model.predict(Floor(()))


def test_homes_and_depots_are_of_no_known_type():
    for name in ("home", "depot"):
        for seed in (3, 4):
            floor, _ = pianta.make_world(name, seed=seed)
            bare = replace(floor, rooms=tuple(Room(room.id, room.polygon) for room in floor.rooms))
            assert predict_map_type(bare).neither > MIN_TYPE_PROBABILITY / 2
            assert classify_building(bare).building_type == {}


def test_floors_with_all_labels_are_compared_by_them():
    floor, _ = pianta.make_world("corridor")
    labelled = replace(floor, rooms=tuple(replace(room, label="FUNCTIONAL") for room in floor.rooms))
    by_labels = classify_building(labelled).building_type
    assert by_labels == {} or sum(by_labels.values()) == pytest.approx(1)
    one_missing = replace(labelled, rooms=(replace(labelled.rooms[0], label=None), *labelled.rooms[1:]))
    prediction = predict_map_type(one_missing)
    expected = dict(prediction.probabilities) if prediction.is_known else {}
    assert classify_building(one_missing).building_type == expected


def test_the_line_of_the_command_names_what_is_left():
    floor = replace(ROW, building_type={"school": 0.7, "office": 0.1})
    assert describe_type(floor, ("office", "school")) == "school 0.70 (office 0.10, neither 0.20)"
    assert describe_type(floor, ("office", "school", "ward")) == "school 0.70 (office 0.10, none of these 0.20)"
    certain = replace(ROW, building_type={"school": 0.9, "office": 0.1})
    assert describe_type(certain, ("office", "school")) == "school 0.90 (office 0.10)"
