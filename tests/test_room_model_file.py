"""Model files of rooms: round trip, and files from untrusted sources."""

import io
import json
import tracemalloc
import zipfile
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from numpy.typing import NDArray

from pianta.errors import ModelError, PiantaError
from pianta.gridmap import GridMap
from pianta.io.maps import save_npz_map
from pianta.rooms.features import CONTEXT_FEATURES
from pianta.rooms.model_file import (
    DEFAULT_MODEL,
    HEADER,
    read_default_room_model,
    read_room_model,
    save_room_model,
)
from pianta.worlds.floors import make_floor
from tests.labelled_floors import labelled_floors, small_model
from tests.mutation import mutated, refused_in_one_line

LAB = {"name": "LAB", "function": "FUNCTIONAL", "general": "B", "color": "#2267f2"}
MAX_DEFAULT_BYTES = 300_000


@pytest.fixture(scope="module")
def model_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "places.npz"
    save_room_model(small_model(), path)
    return path


def rewrite(
    model_file: Path,
    path: Path,
    *,
    header: Mapping[str, Any] = MappingProxyType({}),
    arrays: Mapping[str, NDArray[Any]] = MappingProxyType({}),
    members: Mapping[str, bytes] = MappingProxyType({}),
    leave_out: tuple[str, ...] = (),
) -> Path:
    """A copy of a model file with another header, other arrays, or other members."""
    with zipfile.ZipFile(model_file) as old:
        content = {name: old.read(name) for name in old.namelist()}
    content[HEADER] = json.dumps(json.loads(content[HEADER]) | header).encode()
    for name, array in arrays.items():
        stream = io.BytesIO()
        np.save(stream, array)
        content[f"{name}.npy"] = stream.getvalue()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as new:
        for name, data in {**content, **members}.items():
            if name not in leave_out:
                new.writestr(name, data)
    return path


def array_of(model_file: Path, name: str) -> NDArray[Any]:
    with np.load(model_file) as archive:
        return np.asarray(archive[name])


def refuse(path: Path, match: str) -> None:
    with pytest.raises(ModelError, match=match) as caught:
        read_room_model(path)
    assert "\n" not in str(caught.value)
    assert path.name in str(caught.value)


def test_round_trip(model_file):
    read, floor = read_room_model(model_file), labelled_floors()[0]
    for predicted, predicted_before in zip(
        read.passes(floor).values(), small_model().passes(floor).values(), strict=True
    ):
        assert (predicted == predicted_before).all()
    assert read.label(floor) == small_model().label(floor)
    assert read.training == small_model().training
    assert read.schemas == small_model().schemas


def test_the_same_model_gives_the_same_bytes(model_file, tmp_path):
    save_room_model(read_room_model(model_file), tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == model_file.read_bytes()


def test_the_default_model_is_written_again_with_the_same_bytes(tmp_path):
    save_room_model(read_default_room_model(), tmp_path / "again.npz")
    with zipfile.ZipFile(tmp_path / "again.npz") as again, zipfile.ZipFile(DEFAULT_MODEL) as shipped:
        assert again.namelist() == shipped.namelist()
        assert all(again.read(name) == shipped.read(name) for name in shipped.namelist())


def test_no_pickle_inside(model_file):
    with zipfile.ZipFile(model_file) as archive:
        assert {name.rpartition(".")[2] for name in archive.namelist()} == {"json", "npy"}
        arrays = [name for name in archive.namelist() if name.endswith(".npy")]
        for name in arrays:
            np.load(io.BytesIO(archive.read(name)), allow_pickle=False)


@pytest.mark.parametrize("content", [b"no model", b"PK\x03\x04 damaged", b"\x80\x04K\x01."])
def test_files_that_are_no_model(tmp_path, content):
    (tmp_path / "m.npz").write_bytes(content)
    refuse(tmp_path / "m.npz", "no model of rooms")


def test_empty_and_missing_files_and_folders(tmp_path):
    (tmp_path / "empty.npz").write_bytes(b"")
    refuse(tmp_path / "empty.npz", "is empty")
    refuse(tmp_path / "missing.npz", "does not exist")
    refuse(tmp_path, "is a folder")


def test_an_archive_of_something_else(model_file, tmp_path):
    refuse(rewrite(model_file, tmp_path / "m.npz", leave_out=(HEADER,)), "no model of rooms")


def test_a_newer_version(model_file, tmp_path):
    refuse(rewrite(model_file, tmp_path / "m.npz", header={"version": "3.0"}), "version 3.0.*2.x; update pianta")


def test_a_newer_minor_version_is_read(model_file, tmp_path):
    path = rewrite(model_file, tmp_path / "m.npz", header={"version": "2.7", "novelty": True})
    assert read_room_model(path).training == small_model().training


@pytest.mark.parametrize(
    ("header", "match"),
    [
        ({"format": "pianta floor"}, "format"),
        ({"version": "one"}, "version"),
        ({"features": ["area"]}, "other features"),
        ({"schemas": {"school": []}}, "no label"),
        ({"schemas": {"school": [LAB]}}, "over other features or labels"),
        ({"schemas": {"school": [LAB], "castle": [LAB]}}, "other features or labels"),
        ({"field": {}}, "field"),
        ({"training": {}}, "training.floors: Field required"),
        ({"schemas": {"school": [{"name": "LAB", "function": "POOL"}]}}, r"schemas.school\[0\].function"),
        ({"schemas": {"school": [LAB | {"color": "red"}]}}, r"schemas.school\[0\]: the colour 'red' is invalid"),
        ({"schemas": {"school": [LAB, LAB]}}, "has labels twice: LAB"),
    ],
)
def test_invalid_headers_are_refused(model_file, tmp_path, header, match):
    refuse(rewrite(model_file, tmp_path / "m.npz", header=header), match)


def test_an_infinite_field_is_refused(model_file, tmp_path):
    with zipfile.ZipFile(model_file) as archive:
        field = json.loads(archive.read(HEADER))["field"]
    refuse(rewrite(model_file, tmp_path / "m.npz", header={"field": field | {"temperature": 1e999}}), "temperature")


def test_thresholds_that_are_not_numbers(model_file, tmp_path):
    thresholds = array_of(model_file, "first.thresholds").copy()
    thresholds[0] = np.nan
    path = rewrite(model_file, tmp_path / "m.npz", arrays={"first.thresholds": thresholds})
    refuse(path, "trees are damaged: .*not finite.*train it again with `pianta train places`")


def test_a_tree_that_leads_back(model_file, tmp_path):
    """The last inner node becomes a leaf, and the last leaf an inner node, whose children would precede it."""
    features = array_of(model_file, "first.features").copy()
    features[np.flatnonzero(features >= 0)[-1]], features[-1] = -1, 0
    path = rewrite(model_file, tmp_path / "m.npz", arrays={"first.features": features})
    refuse(path, "trees are damaged: .*does not lead downwards")


def test_a_tree_whose_children_are_missing(model_file, tmp_path):
    features = array_of(model_file, "second.features").copy()
    features[-1] = 0
    refuse(rewrite(model_file, tmp_path / "m.npz", arrays={"second.features": features}), "trees are damaged: .*leaves")


@pytest.mark.parametrize("feature", [len(CONTEXT_FEATURES), 30_000])
def test_a_feature_that_rooms_do_not_have(model_file, tmp_path, feature):
    features = array_of(model_file, "first.features").copy()
    features[0] = feature
    path = rewrite(model_file, tmp_path / "m.npz", arrays={"first.features": features})
    refuse(path, "over other features or labels")


def test_labels_that_the_header_does_not_have(model_file, tmp_path):
    votes = array_of(model_file, "names.0.votes")
    wider = np.hstack([votes, np.zeros((len(votes), 1))])
    refuse(rewrite(model_file, tmp_path / "m.npz", arrays={"names.0.votes": wider}), "over other features or labels")


@pytest.mark.parametrize(
    ("array", "match"),
    [
        (np.zeros(4, np.int64), "int64 of shape .*, give int16 with 1 axis"),
        (np.zeros(4, ">i2"), ">i2 of shape"),
        (np.zeros((2, 2), np.int16), "give int16 with 1 axis"),
        (np.array(7, np.int16), "give int16 with 1 axis"),
        (np.zeros(4, "U5"), "<U5"),
        (np.zeros(4, [("a", "<i2")]), "give int16"),
    ],
)
def test_arrays_of_another_kind(model_file, tmp_path, array, match):
    refuse(rewrite(model_file, tmp_path / "m.npz", arrays={"first.features": array}), f"trees are damaged: .*{match}")


def test_an_array_by_columns(model_file, tmp_path):
    votes = np.asfortranarray(array_of(model_file, "first.votes"))
    refuse(rewrite(model_file, tmp_path / "m.npz", arrays={"first.votes": votes}), "trees are damaged: .*by rows")


class Tripwire:
    """An object that creates a file when it is unpickled."""

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self) -> tuple[Any, ...]:
        return Path.touch, (self.trace,)


def test_objects_are_not_unpickled(model_file, tmp_path):
    objects = np.array([Tripwire(tmp_path / "tripped")], object)
    path = rewrite(model_file, tmp_path / "m.npz", arrays={"first.features": objects})
    refuse(path, "trees are damaged: .*object")
    assert not (tmp_path / "tripped").exists()


def head(text: bytes, version: bytes = b"\x01\x00") -> bytes:
    size = len(text).to_bytes(2 if version == b"\x01\x00" else 4, "little")
    return b"\x93NUMPY" + version + size + text


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no array",
        head(b"{'descr': '<i2', 'fortran_order': False, 'shape': (999999999999,), }"),
        head(b"{'descr': '<i2', 'fortran_order': False, 'shape': (-4,), }") + b"12345678",
        head(b"{'descr': '<i2', 'fortran_order': False, 'shape': (True,), }"),
        head(b"{'descr': '<i2', 'fortran_order': False, 'shape': (0, 1" + b"0" * 400 + b"), }"),
        head(b"{'descr': '<i2', 'fortran_order': False, 'shape': (4,), }") + b"123456789",
        head(b"{'descr': '|O', 'fortran_order': False, 'shape': (1,), }") + b"cos\nabort\n.",
        head(b"(" * 60_000),
        head(b" " * 60_000),
        head(b"{'descr': '<i2'", b"\x02\x00"),
        head(b"", b"\x09\x00"),
        b"\x93NUMPY\x02\x00\xff\xff\xff\xff{",
    ],
)
def test_invalid_headers_of_arrays_are_refused(model_file, tmp_path, content):
    path = rewrite(model_file, tmp_path / "m.npz", members={"first.features.npy": content})
    refuse(path, "trees are damaged: 'first.features' ")


def test_a_member_that_is_missing(model_file, tmp_path):
    path = rewrite(model_file, tmp_path / "m.npz", leave_out=("names.0.votes.npy",))
    refuse(path, "trees are damaged: 'names.0.votes.npy' is missing; train it again")


def test_a_member_that_is_damaged(model_file, tmp_path):
    content = bytearray(model_file.read_bytes())
    with zipfile.ZipFile(model_file) as archive:
        index = archive.getinfo("first.thresholds.npy").header_offset + 300
    content[index : index + 20] = bytes(20)
    (tmp_path / "m.npz").write_bytes(content)
    refuse(tmp_path / "m.npz", "trees are damaged: 'first.thresholds.npy' is damaged")


@pytest.mark.parametrize("share", [0.01, 0.5, 0.99])
def test_a_truncated_file(model_file, tmp_path, share):
    content = model_file.read_bytes()
    (tmp_path / "m.npz").write_bytes(content[: int(len(content) * share)])
    refuse(tmp_path / "m.npz", "no model of rooms")


@given(mutated(DEFAULT_MODEL.read_bytes()))
@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damaged_files_are_refused_or_read(tmp_path, content):
    (tmp_path / "m.npz").write_bytes(content)
    with refused_in_one_line():
        read_room_model(tmp_path / "m.npz")


@pytest.mark.parametrize("content", ["map", "arrays"])
def test_a_foreign_npz(tmp_path, content):
    if content == "map":
        save_npz_map(GridMap(np.zeros((4, 4), np.int8), 0.05), tmp_path / "m.npz")
    else:
        np.savez(tmp_path / "m.npz", first=np.zeros(3))
    refuse(tmp_path / "m.npz", "no model of rooms, .*`pianta train places`")


def test_a_model_of_an_older_pianta(model_file, tmp_path):
    """As skops wrote it: a header of version 1, a member schema.json, and trees as objects."""
    path = tmp_path / "old.skops"
    with zipfile.ZipFile(model_file) as old, zipfile.ZipFile(path, "w") as new:
        new.writestr("schema.json", json.dumps({"__class__": "dict", "protocol": 2}))
        for number in range(1200):
            new.writestr(f"{number}.npy", b"")
        new.writestr(HEADER, json.dumps(json.loads(old.read(HEADER)) | {"version": "1.0"}))
    refuse(path, "format version 1.0, which pianta no longer reads; train it again with `pianta train places`")


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_compression_methods_without_a_limit_are_refused(model_file, tmp_path, method):
    path = tmp_path / "m.npz"
    with zipfile.ZipFile(model_file) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            new.writestr(name, old.read(name), zipfile.ZIP_STORED if name == HEADER else method)
    refuse(path, f"packed by method {method}, pack it by deflate")


def test_a_zip_bomb_with_a_false_size_in_its_directory(model_file, tmp_path):
    """Only as many bytes as the directory states are unpacked."""
    path = rewrite(model_file, tmp_path / "m.npz", members={"first.features.npy": bytes(200 * 2**20)})
    content = path.read_bytes()
    hidden = content.replace((200 * 2**20).to_bytes(4, "little"), (1000).to_bytes(4, "little"))
    assert len(content) < 2**20
    assert hidden != content
    path.write_bytes(hidden)
    tracemalloc.start()
    refuse(path, "trees are damaged: 'first.features")
    assert tracemalloc.get_traced_memory()[1] < 20 * 2**20
    tracemalloc.stop()


def test_an_archive_with_a_compression_that_python_does_not_have(model_file, tmp_path):
    content = bytearray(model_file.read_bytes())
    with zipfile.ZipFile(model_file) as archive:
        start = archive.getinfo(HEADER).header_offset
    entry = content.rindex(HEADER.encode()) - 46
    for index in (start + 8, entry + 10):
        content[index : index + 2] = (97).to_bytes(2, "little")
    (tmp_path / "m.npz").write_bytes(content)
    refuse(tmp_path / "m.npz", "no model of rooms")


def test_an_archive_of_too_many_members(model_file, monkeypatch):
    monkeypatch.setattr("pianta.rooms.model_archive.MAX_MEMBERS", 9)
    refuse(model_file, "10 members, too many for a model; the limit is 9")


def test_an_archive_that_unpacks_to_too_much(tmp_path, monkeypatch, model_file):
    monkeypatch.setattr("pianta.rooms.model_archive.MAX_CONTENT_BYTES", 1000)
    refuse(model_file, "it unpacks to .* bytes, too many for a model; the limit is 1000")


def test_a_file_that_is_too_large(model_file, monkeypatch):
    monkeypatch.setattr("pianta.rooms.model_file.MAX_FILE_BYTES", 1000)
    refuse(model_file, "the limit is 1000")


@pytest.mark.parametrize("name", ["m.skops", "m", "m.zip"])
def test_names_that_do_not_end_in_npz(tmp_path, name):
    with pytest.raises(ModelError, match=r"does not end in \.npz, give a name that does"):
        save_room_model(small_model(), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_writing_into_a_folder_that_is_missing(tmp_path):
    with pytest.raises(PiantaError, match="cannot write"):
        save_room_model(small_model(), tmp_path / "missing" / "m.npz")
    assert list(tmp_path.iterdir()) == []


def test_the_model_that_comes_with_pianta():
    assert DEFAULT_MODEL.stat().st_size <= MAX_DEFAULT_BYTES
    model = read_default_room_model()
    assert model.building_types == ("office", "school")
    assert model.training.rooms.keys() == {"office", "school"}
    assert len(model.training.floors) > 40
    labelled = model.label(make_floor("corridor", seed=1))
    assert {room.labels["R/C"] for room in labelled.rooms} == {"ROOM", "CORRIDOR"}
