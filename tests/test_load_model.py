"""`pianta.load_model`: any model file, distinguished by its content."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pianta
from pianta.building_types.model import BuildingTypeModel
from pianta.errors import ModelError
from pianta.generation.type_model import TypeModel
from pianta.rooms.model import RoomModel
from pianta.rooms.model_file import DEFAULT_MODEL
from tests.generated_types import small_model
from tests.typed_floors import typed_model


def test_a_model_of_one_type(tmp_path):
    small_model().save(tmp_path / "school.json")
    model = pianta.load_model(tmp_path / "school.json")
    assert isinstance(model, TypeModel)
    assert str(model) == str(small_model())
    assert (model.configurations == small_model().configurations).all()


def test_a_model_of_building_types(tmp_path):
    typed_model().save(tmp_path / "types.json")
    model = pianta.load_model(str(tmp_path / "types.json"))
    assert isinstance(model, BuildingTypeModel)
    assert model.building_types == typed_model().building_types == ("house", "office", "school")


def test_the_model_of_rooms_that_comes_with_pianta():
    model = pianta.load_model(DEFAULT_MODEL)
    assert isinstance(model, RoomModel)
    assert model.building_types == ("office", "school")


def test_the_name_of_the_file_does_not_matter(tmp_path):
    small_model().save(tmp_path / "rooms.npz")
    assert isinstance(pianta.load_model(tmp_path / "rooms.npz"), TypeModel)


CONTENTS: dict[str, bytes] = {
    "text": b"a model",
    "list": b"[1, 2]",
    "number": b"3",
    "other format": b'{"format": "pianta floor", "version": "2.2"}',
    "no format": b"{}",
    "deep": b"[" * 100_000,
    "bytes": bytes(range(256)),
    "cut zip": b"PK\x03\x04 and no more",
}


@pytest.mark.parametrize("name", CONTENTS)
def test_what_is_no_model(tmp_path, name):
    (tmp_path / "model.json").write_bytes(CONTENTS[name])
    refuse(tmp_path / "model.json", "it is no model of pianta, make one with `pianta train`")


def test_an_archive_that_is_no_model(tmp_path):
    np.savez(tmp_path / "map.npz", cells=np.zeros((2, 2), np.int8))
    refuse(tmp_path / "map.npz", "cannot read the model")


@pytest.mark.parametrize(
    ("name", "fragment"), [("", "is a folder, give a file"), ("nowhere.json", "does not exist"), ("empty", "is empty")]
)
def test_what_is_no_file(tmp_path, name, fragment):
    (tmp_path / "empty").touch()
    refuse(tmp_path / name, fragment)


def test_a_model_of_a_newer_pianta(tmp_path):
    small_model().save(tmp_path / "school.json")
    content = json.loads((tmp_path / "school.json").read_text())
    (tmp_path / "school.json").write_text(json.dumps(content | {"version": "99.0"}))
    refuse(tmp_path / "school.json", "99.0")


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
@given(st.binary(max_size=200))
def test_garbage_is_refused_in_one_line(tmp_path, content):
    (tmp_path / "model").write_bytes(content)
    refuse(tmp_path / "model", "")


def refuse(path: Path, fragment: str) -> None:
    with pytest.raises(ModelError) as caught:
        pianta.load_model(path)
    assert fragment in str(caught.value)
    assert "\n" not in str(caught.value)
