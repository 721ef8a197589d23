"""Model files of building types: round trip, and files from untrusted sources."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pianta.building_types.description import describe_building, name_features
from pianta.building_types.model import train_building_types
from pianta.building_types.model_file import (
    DEFAULT_MODEL,
    MAX_ROOMS,
    read_building_type_model,
    read_default_building_type_model,
    save_building_type_model,
)
from pianta.errors import ModelError, PiantaError
from pianta.io.buildings.read import read_building
from pianta.labels import SCHEMAS, LabelSet
from pianta.rooms.completion import LABELS, map_labels_upwards
from tests.mutation import mutated, refused_in_one_line
from tests.typed_floors import ALL_SCHEMAS, typed_floors, typed_model

MAX_DEFAULT_BYTES = 100_000


@pytest.fixture(scope="module")
def model_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "types.json"
    save_building_type_model(typed_model(), path)
    return path


def refuse(path: Path, match: str) -> None:
    with pytest.raises(ModelError, match=match) as caught:
        read_building_type_model(path)
    assert "\n" not in str(caught.value)
    assert path.name in str(caught.value)


def rewrite(model_file: Path, path: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    """A copy of a model file whose content is changed."""
    content = json.loads(model_file.read_text())
    change(content)
    path.write_text(json.dumps(content))
    return path


@pytest.mark.slow
@pytest.mark.parametrize("label_set", [LabelSet.R_C, LabelSet.F_C_E_S])
def test_round_trip(tmp_path, label_set):
    model = train_building_types(typed_floors(), schemas=ALL_SCHEMAS, label_set=label_set)
    save_building_type_model(model, tmp_path / "m.json")
    read = read_building_type_model(tmp_path / "m.json")
    assert (read.types, read.buildings, read.label_set) == (model.types, model.buildings, label_set)
    for one, other in zip(read.training_floors, model.training_floors, strict=True):
        assert (one.features == other.features).all()
        assert replace(one, features=other.features).__dict__ == other.__dict__
        assert read.predict_description(other) == model.predict_description(other)


def test_the_same_model_gives_the_same_bytes(model_file, tmp_path):
    save_building_type_model(read_building_type_model(model_file), tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == model_file.read_bytes()


def test_a_line_for_each_floor(model_file):
    lines = model_file.read_text().splitlines()
    assert [json.loads(line.rstrip(","))["source"] for line in lines if line.startswith('{"')] == [
        floor.source for floor in typed_floors()
    ]


def test_it_replaces_an_older_file(tmp_path):
    (tmp_path / "m.json").write_text("older")
    save_building_type_model(typed_model(), tmp_path / "m.json")
    assert read_building_type_model(tmp_path / "m.json").types == typed_model().types
    assert [file.name for file in tmp_path.iterdir()] == ["m.json"]


def test_writing_into_a_folder_that_is_missing(tmp_path):
    with pytest.raises(PiantaError, match="cannot write"):
        save_building_type_model(typed_model(), tmp_path / "missing" / "m.json")
    assert list(tmp_path.iterdir()) == []


def test_a_model_that_could_not_be_read_is_not_written(tmp_path):
    model = typed_model()
    large = replace(model.training_floors[0], labels=("SERVICE",) * (MAX_ROOMS + 1))
    with pytest.raises(ModelError, match=r"cannot be saved: labels: .*at most 1000") as caught:
        save_building_type_model(
            replace(model, training_floors=(large, *model.training_floors[1:])), tmp_path / "m.json"
        )
    assert "\n" not in str(caught.value)
    with pytest.raises(ModelError, match="cannot be saved: 1 building type is given"):
        save_building_type_model(replace(model, types=("school",) * len(model.types)), tmp_path / "m.json")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("content", [b"no model", b"PK\x03\x04", b"{", b"[]", b"7", b"\xff\xfe{}", b"null", b'{"a":'])
def test_files_that_are_no_model(tmp_path, content):
    (tmp_path / "m.json").write_bytes(content)
    refuse(tmp_path / "m.json", "no model of building types")


def test_empty_and_missing_files_and_folders(tmp_path):
    (tmp_path / "empty.json").write_bytes(b"")
    refuse(tmp_path / "empty.json", "is empty")
    refuse(tmp_path / "missing.json", "does not exist")
    refuse(tmp_path, "is a folder")


def test_a_truncated_file(model_file, tmp_path):
    content = model_file.read_bytes()
    (tmp_path / "m.json").write_bytes(content[: len(content) // 2])
    refuse(tmp_path / "m.json", "no model of building types")


def test_a_file_that_is_too_large(model_file, tmp_path, monkeypatch):
    monkeypatch.setattr("pianta.building_types.model_file.MAX_FILE_BYTES", 1000)
    refuse(model_file, "the limit is 1000")


def test_floors_of_too_many_rooms_together(model_file, monkeypatch):
    monkeypatch.setattr("pianta.building_types.model_file.MAX_PAIRS", 1000)
    refuse(model_file, "more than 1000 pairs of rooms")


def test_a_newer_minor_version_is_read(model_file, tmp_path):
    path = rewrite(model_file, tmp_path / "m.json", lambda content: content.update(version="2.9", novelty=True))
    assert read_building_type_model(path).types == typed_model().types


def make_older(content: dict[str, Any]) -> None:
    """Changes the content to version 1, which has floors and no fitted values."""
    del content["learnt"]
    content["version"] = "1.0"


def test_a_file_of_an_older_version_is_fitted_again(model_file, tmp_path):
    model = read_building_type_model(rewrite(model_file, tmp_path / "m.json", make_older))
    assert model.stored_fit is None
    for training in typed_model().training_floors[::4]:
        assert model.predict_description(training) == typed_model().predict_description(training)
    save_building_type_model(model, tmp_path / "new.json")
    assert (tmp_path / "new.json").read_bytes() == model_file.read_bytes()


def test_fitted_values_are_read_from_the_file(model_file, monkeypatch):
    monkeypatch.setattr("pianta.building_types.model.fit_type_svm", None)
    monkeypatch.setattr("pianta.building_types.model.fit_typicality", None)
    predicted = read_building_type_model(model_file).predict_description(typed_model().training_floors[0])
    assert predicted == typed_model().predict_description(typed_model().training_floors[0])


def test_a_model_without_a_building_is_fitted_again(model_file):
    model = read_building_type_model(model_file).leave_out(np.array([0, 1]))
    others = typed_model().leave_out(np.array([0, 1]))
    assert model.stored_fit is None
    assert model.predict_description(typed_model().training_floors[0]) == others.predict_description(
        typed_model().training_floors[0]
    )


FLOORS = len(typed_floors())


@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"weights": [[0.0, 0.0]] * (FLOORS - 1)}, f"weights are not {FLOORS} × 2"),
        ({"weights": [[0.0]] * FLOORS}, f"weights are not {FLOORS} × 2"),
        ({"weights": [[0.0, 0.0]] * (FLOORS - 1) + [[0.0]]}, "weights are not"),
        ({"weights": []}, "weights are not"),
        ({"weights": [[1e999, 0.0]] * FLOORS}, "finite"),
        ({"weights": [[1e7, 0.0]] * FLOORS}, "less than or equal"),
        ({"weights": [["1", 0.0]] * FLOORS}, "valid number"),
        ({"weights": [0.0] * FLOORS}, r"learnt.weights\[0\]"),
        ({"intercepts": [0.0]}, "intercepts are not 3"),
        ({"slopes": [[0.0] * 3]}, "slopes are not 3 × 3"),
        ({"offsets": [0.0] * 2}, "offsets are not 3"),
        ({"offsets": None}, "learnt.offsets"),
        ({"likenesses": [0.0]}, f"likenesses are not {FLOORS}"),
        ({"likenesses": [1.0] + [0.0] * (FLOORS - 1)}, "likenesses do not ascend"),
    ],
)
def test_impossible_fitted_values_are_refused(model_file, tmp_path, changed, match):
    refuse(rewrite(model_file, tmp_path / "m.json", lambda content: content["learnt"].update(changed)), match)


def test_a_file_without_fitted_values(model_file, tmp_path):
    refuse(rewrite(model_file, tmp_path / "m.json", lambda content: content.pop("learnt")), "learnt: Field required")


def test_types_in_any_case(model_file, tmp_path):
    path = rewrite(model_file, tmp_path / "m.json", lambda content: content["floors"][0].update(type=" School "))
    assert read_building_type_model(path).types == typed_model().types


@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"format": "pianta floor"}, "no model of building types"),
        ({"version": "3.0", "floors": 7}, "version 3.0, this pianta reads 2.x; update pianta"),
        ({"version": "one"}, "version"),
        ({"version": 1.0}, "version"),
        ({"label_set": "general"}, "label_set"),
        ({"label_set": "R/C"}, "other features"),
        ({"features": ["area"]}, "other features"),
        ({"features": None}, "features"),
        ({"floors": []}, "0 building types are given"),
        ({"floors": [1]}, r"floors\[0\]"),
        ({"floors": None}, "floors"),
    ],
)
def test_invalid_contents_are_refused(model_file, tmp_path, changed, match):
    refuse(rewrite(model_file, tmp_path / "m.json", lambda content: content.update(changed)), match)


ROOMS = len(typed_model().training_floors[0].labels)
NUMBERS = len(name_features(LabelSet.F_C_E_S))


@pytest.mark.parametrize(
    ("changed", "match"),
    [
        ({"source": "x" * 1001}, r"floors\[0\].source"),
        ({"type": ""}, "the name is empty"),
        ({"type": 7}, r"floors\[0\].type"),
        ({"building": None}, "building"),
        ({"features": [0.0]}, "has 1 features of 25"),
        ({"features": [1e999] * NUMBERS}, "finite"),
        ({"features": [1e7] * NUMBERS}, "less than or equal"),
        ({"features": ["1"] * NUMBERS}, "valid number"),
        ({"features": [True] * NUMBERS}, "valid number"),
        ({"labels": ["POOL"] * ROOMS}, "not of F/C/E/S: 'POOL'"),
        ({"labels": ["ROOM"] * ROOMS}, "not of F/C/E/S: 'ROOM'"),
        ({"labels": ["SERVICE"]}, "not of the same rooms"),
        ({"labels": [], "sizes": [], "sides": [], "doors": []}, "at least 1 item"),
        ({"labels": ["SERVICE"] * (MAX_ROOMS + 1)}, "at most 1000 items"),
        ({"sizes": [0.0]}, "not of the same rooms"),
        ({"sizes": [-1e999] * ROOMS}, "finite"),
        ({"sides": [3] * ROOMS}, "less than or equal to 2"),
        ({"sides": [0.5] * ROOMS}, "valid integer"),
        ({"doors": [[0, ROOMS]]}, f"not pairs of its {ROOMS} rooms"),
        ({"doors": [[1, 0]]}, "not pairs"),
        ({"doors": [[1, 1]]}, "not pairs"),
        ({"doors": [[-1, 1]]}, "not pairs"),
        ({"doors": [[0, 1], [0, 1]]}, "not pairs"),
        ({"doors": [[0, 1, 2]]}, "doors"),
        ({"doors": [[0, 10**400]]}, "doors"),
    ],
)
def test_impossible_floors_are_refused(model_file, tmp_path, changed, match):
    refuse(rewrite(model_file, tmp_path / "m.json", lambda content: content["floors"][0].update(changed)), match)


def test_too_few_buildings_of_a_type(model_file, tmp_path):
    path = rewrite(model_file, tmp_path / "m.json", lambda content: content["floors"][0].update(type="castle"))
    refuse(path, "castle has 1 building")


def test_deeply_nested_content(tmp_path):
    (tmp_path / "m.json").write_text('{"format": ' + "[" * 100_000)
    refuse(tmp_path / "m.json", "no model of building types")


@pytest.mark.slow
@given(mutated(DEFAULT_MODEL.read_bytes()))
@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damaged_files_are_refused_or_read(tmp_path, content):
    path = tmp_path / "m.json"
    path.write_bytes(content)
    with refused_in_one_line():
        read_building_type_model(path)


@pytest.mark.slow
@given(
    st.lists(st.lists(st.floats(-1e6, 1e6), min_size=NUMBERS, max_size=NUMBERS), min_size=6, max_size=6),
    st.lists(st.integers(1, 4), min_size=6, max_size=6),
    st.randoms(use_true_random=False),
)
@settings(max_examples=30, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_model_that_was_read_can_predict(tmp_path, features, rooms, random):
    """Also with extreme numbers in the file."""
    floors = [
        {
            "source": f"{index}",
            "type": "abc"[index % 3],
            "building": f"{index}",
            "features": numbers,
            "labels": [random.choice(LABELS[LabelSet.F_C_E_S]) for _ in range(count)],
            "sizes": [random.uniform(-1e6, 1e6) for _ in range(count)],
            "sides": [random.randrange(3) for _ in range(count)],
            "doors": [[one, other] for other in range(count) for one in range(other) if random.random() < 0.5],
        }
        for index, (numbers, count) in enumerate(zip(features, rooms, strict=True))
    ]
    names = list(name_features(LabelSet.F_C_E_S))
    content = {"format": "pianta buildings", "version": "1.0", "label_set": "F/C/E/S", "features": names}
    (tmp_path / "m.json").write_text(json.dumps(content | {"floors": floors}))
    model = read_building_type_model(tmp_path / "m.json")
    for training in typed_model().training_floors[::5]:
        verdict = model.predict_description(training)
        assert sum(verdict.probabilities.values()) == pytest.approx(1)
        assert 0 <= verdict.typicality <= 1


def test_the_model_that_comes_with_pianta():
    assert DEFAULT_MODEL.stat().st_size <= MAX_DEFAULT_BYTES
    model = read_default_building_type_model()
    assert model is read_default_building_type_model()
    assert model.building_types == ("office", "school")
    assert model.label_set is LabelSet.F_C_E_S
    assert (len(model.training_floors), len(set(model.buildings))) == (43, 35)
    assert [model.types.count(building_type) for building_type in model.building_types] == [11, 32]


@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_the_model_that_comes_with_pianta_is_of_the_data(data):
    model = read_default_building_type_model()
    for index in (0, 20, 40):
        training, building_type = model.training_floors[index], model.types[index]
        floor = map_labels_upwards(
            read_building(data / "buildings" / building_type / training.source), SCHEMAS[building_type]
        )
        predicted = describe_building(floor, model.label_set)
        assert predicted.features == pytest.approx(training.features, abs=1e-3)
        assert (predicted.labels, predicted.sides, predicted.doors) == (training.labels, training.sides, training.doors)
