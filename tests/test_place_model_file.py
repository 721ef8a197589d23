"""Model files: round trip, and what strangers may send."""

import io
import json
import zipfile
from copy import copy
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sklearn.ensemble import ExtraTreesClassifier
from sklearn.tree import DecisionTreeClassifier, ExtraTreeClassifier
from skops.io import dumps

from pianta.errors import ModelError, PiantaError
from pianta.rooms.model import PlaceModel
from pianta.rooms.model_file import (
    DEFAULT_MODEL,
    HEADER,
    read_default_place_model,
    read_place_model,
    save_place_model,
)
from pianta.worlds.floors import make_floor
from tests.labelled_floors import labelled_floors, small_model

LAB = {"name": "LAB", "function": "FUNCTIONAL", "general": "B", "color": "#2267f2"}
MAX_DEFAULT_BYTES = 3 * 2**20


@pytest.fixture(scope="module")
def model_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "places.skops"
    save_place_model(small_model(), path)
    return path


def rewrite(
    model_file: Path, path: Path, *, header: Any = None, trees: Any = None, leave_out: tuple[str, ...] = ()
) -> Path:
    """A copy of a model file with another header, or other trees."""
    content = io.BytesIO(dumps(trees)) if trees is not None else io.BytesIO(model_file.read_bytes())
    with zipfile.ZipFile(model_file) as old, zipfile.ZipFile(content) as source, zipfile.ZipFile(path, "w") as new:
        for name in source.namelist():
            if name != HEADER:
                new.writestr(name, source.read(name))
        told = json.loads(old.read(HEADER)) | (header or {})
        if HEADER not in leave_out:
            new.writestr(HEADER, json.dumps(told))
    return path


def refuse(path: Path, match: str) -> None:
    with pytest.raises(ModelError, match=match) as caught:
        read_place_model(path)
    assert "\n" not in str(caught.value)
    assert path.name in str(caught.value)


@pytest.mark.slow
def test_round_trip(model_file):
    read, floor = read_place_model(model_file), labelled_floors()[0]
    for said, said_before in zip(read.passes(floor).values(), small_model().passes(floor).values(), strict=True):
        assert (said == said_before).all()
    assert read.label(floor) == small_model().label(floor)
    assert read.training == small_model().training
    assert read.schemas == small_model().schemas


def test_no_pickle_inside(model_file):
    with zipfile.ZipFile(model_file) as archive:
        assert {name.rpartition(".")[2] for name in archive.namelist()} == {"json", "npy"}
        arrays = [name for name in archive.namelist() if name.endswith(".npy")]
        for name in arrays:
            np.load(io.BytesIO(archive.read(name)), allow_pickle=False)


@pytest.mark.parametrize("content", [b"no model", b"PK\x03\x04 damaged", b"\x80\x04K\x01."])
def test_files_that_are_no_model(tmp_path, content):
    (tmp_path / "m.skops").write_bytes(content)
    refuse(tmp_path / "m.skops", "no model of pianta")


def test_empty_and_missing_files_and_folders(tmp_path):
    (tmp_path / "empty.skops").write_bytes(b"")
    refuse(tmp_path / "empty.skops", "is empty")
    refuse(tmp_path / "missing.skops", "does not exist")
    refuse(tmp_path, "is a folder")


def test_an_archive_of_something_else(model_file, tmp_path):
    refuse(rewrite(model_file, tmp_path / "m.skops", leave_out=(HEADER,)), "no model of pianta")


def test_a_newer_version(model_file, tmp_path):
    refuse(rewrite(model_file, tmp_path / "m.skops", header={"version": "2.0"}), "version 2.0.*update pianta")


@pytest.mark.slow
def test_a_newer_minor_version_is_read(model_file, tmp_path):
    path = rewrite(model_file, tmp_path / "m.skops", header={"version": "1.7", "novelty": True})
    assert read_place_model(path).training == small_model().training


@pytest.mark.slow
@pytest.mark.parametrize(
    ("header", "match"),
    [
        ({"format": "pianta floor"}, "format"),
        ({"version": "one"}, "version"),
        ({"features": ["area"]}, "other features"),
        ({"schemas": {"school": []}}, "no label"),
        ({"schemas": {}}, "do not fit"),
        ({"field": {}}, "field"),
        ({"training": {}}, "training.floors: Field required"),
        ({"schemas": {"school": [{"name": "LAB", "function": "POOL"}]}}, r"schemas.school\[0\].function"),
        ({"schemas": {"school": [LAB | {"color": "red"}]}}, r"schemas.school\[0\]: the colour 'red' is none"),
        ({"schemas": {"school": [LAB, LAB]}}, "has labels twice: LAB"),
    ],
)
def test_headers_that_make_no_sense(model_file, tmp_path, header, match):
    refuse(rewrite(model_file, tmp_path / "m.skops", header=header), match)


def test_an_infinite_field_is_refused(model_file, tmp_path):
    with zipfile.ZipFile(model_file) as archive:
        field = json.loads(archive.read(HEADER))["field"]
    refuse(rewrite(model_file, tmp_path / "m.skops", header={"field": field | {"temperature": 1e999}}), "temperature")


def test_untrusted_types_are_named_and_not_loaded(model_file, tmp_path):
    tripped = tmp_path / "tripped"

    class Stranger:
        value = 0

        def __setstate__(self, state):
            tripped.touch()

    Stranger.__qualname__ = "Stranger"
    globals()["Stranger"] = Stranger
    stranger = Stranger()
    stranger.value = 1
    path = rewrite(model_file, tmp_path / "m.skops", trees={"first": stranger, "second": 0, "names": {}})
    refuse(path, "types that are not trusted.*Stranger")
    assert not tripped.exists()


def trees_of(model: PlaceModel, **changed: object) -> dict[str, object]:
    return {"first": model.first, "second": model.second, "names": dict(model.names)} | changed


@pytest.mark.slow
def test_trees_that_are_missing_or_of_another_kind(model_file, tmp_path):
    model = small_model()
    tree = DecisionTreeClassifier().fit([[0.0], [1.0]], [0, 1])
    small = ExtraTreesClassifier(2).fit([[0.0], [1.0]], [0, 1])
    for trees in ({"first": model.first}, [1, 2], trees_of(model, first=tree), trees_of(model, second=small)):
        refuse(rewrite(model_file, tmp_path / "m.skops", trees=trees), "trees are")


def break_forest(*missing: str, **changed: object) -> ExtraTreesClassifier:
    """The first forest of the small model without some of its attributes, and with others."""
    broken = copy(small_model().first)
    for name in missing:
        delattr(broken, name)
    for name, value in changed.items():
        setattr(broken, name, value)
    return broken


@pytest.mark.slow
@pytest.mark.parametrize("place", ["first", "second", "school"])
def test_an_untrained_forest(model_file, tmp_path, place):
    bare = ExtraTreesClassifier(2)
    changed = {"names": {"school": bare}} if place == "school" else {place: bare}
    refuse(rewrite(model_file, tmp_path / "m.skops", trees=trees_of(small_model(), **changed)), "trees are damaged")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("missing", "changed"),
    [
        (["classes_"], {}),
        (["estimators_"], {}),
        (["n_classes_"], {}),
        ([], {"estimators_": []}),
        ([], {"estimators_": 7}),
        ([], {"estimators_": [ExtraTreeClassifier()]}),
        ([], {"estimators_": [1, 2]}),
        ([], {"classes_": np.array([0, 1, 2, 9])}),
        ([], {"classes_": np.array([0, 1, 2, 2])}),
        ([], {"classes_": np.array([0.0, 1.0, 2.0, 3.0])}),
        ([], {"classes_": "wrong"}),
        ([], {"n_classes_": 2}),
        ([], {"n_jobs": "many"}),
    ],
)
def test_forests_that_lack_a_part_or_have_a_wrong_one(model_file, tmp_path, missing, changed):
    trees = trees_of(small_model(), first=break_forest(*missing, **changed))
    refuse(rewrite(model_file, tmp_path / "m.skops", trees=trees), "trees are damaged")


@pytest.mark.slow
def test_a_copied_forest_is_sound(model_file, tmp_path):
    path = rewrite(model_file, tmp_path / "m.skops", trees=trees_of(small_model(), first=break_forest()))
    assert read_place_model(path).label(labelled_floors()[0]) == small_model().label(labelled_floors()[0])


def test_an_archive_packed_in_a_way_that_python_does_not_know(model_file, tmp_path):
    content = bytearray(model_file.read_bytes())
    with zipfile.ZipFile(model_file) as archive:
        start = archive.getinfo(HEADER).header_offset
    entry = content.rindex(HEADER.encode()) - 46
    for place in (start + 8, entry + 10):
        content[place : place + 2] = (97).to_bytes(2, "little")
    (tmp_path / "m.skops").write_bytes(content)
    refuse(tmp_path / "m.skops", "no model of pianta")


@pytest.mark.slow
def test_trees_that_lead_nowhere(model_file, tmp_path):
    """A node beyond the last one would be read from memory that is not the tree's."""
    model = small_model()
    content = io.BytesIO(dumps(trees_of(model)))
    path = tmp_path / "m.skops"
    with zipfile.ZipFile(content) as source, zipfile.ZipFile(path, "w") as new, zipfile.ZipFile(model_file) as old:
        for name in source.namelist():
            data = source.read(name)
            if name.endswith(".npy"):
                array = np.load(io.BytesIO(data))
                if array.dtype.names and "left_child" in array.dtype.names:
                    array["left_child"][0] = 10**6
                    out = io.BytesIO()
                    np.save(out, array)
                    data = out.getvalue()
            new.writestr(name, data)
        new.writestr(HEADER, old.read(HEADER))
    refuse(path, "trees are damaged")


def test_an_archive_that_unpacks_to_too_much(tmp_path, monkeypatch, model_file):
    monkeypatch.setattr("pianta.rooms.model_file.MAX_CONTENT_BYTES", 1000)
    refuse(model_file, "unpacks to more than")


@pytest.mark.slow
def test_writing_into_a_folder_that_is_missing(tmp_path):
    with pytest.raises(PiantaError, match="cannot write"):
        save_place_model(small_model(), tmp_path / "missing" / "m.skops")
    assert list(tmp_path.iterdir()) == []


def test_the_model_that_comes_with_pianta():
    assert DEFAULT_MODEL.stat().st_size <= MAX_DEFAULT_BYTES
    model = read_default_place_model()
    assert model.building_types == ("office", "school")
    assert model.training.rooms.keys() == {"office", "school"}
    assert len(model.training.floors) > 40
    labelled = model.label(make_floor("corridor", seed=1))
    assert {room.labels["R/C"] for room in labelled.rooms} == {"ROOM", "CORRIDOR"}
