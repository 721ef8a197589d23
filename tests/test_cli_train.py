"""`pianta train places` and the labels of `pianta read`, as a user runs them."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pianta.floor import Floor
from pianta.io.buildings.read import name_sources
from pianta.io.floors import read_floor, save_floor
from pianta.io.graphs import read_graph
from pianta.io.ros_maps import save_ros_map
from pianta.labels import SCHOOL
from pianta.rooms.model_file import read_room_model, save_room_model
from pianta.rooms.training import building_name
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.scan import simulate_map
from tests.command_line import list_files, run_pianta
from tests.labelled_floors import labelled_floors, small_model
from tests.test_bench_graphs import STRAY, write_comb

HOSPITAL = """
format: pianta labels
version: "1.0"
building_type: hospital
labels:
  - {name: WARD, function: FUNCTIONAL}
  - {name: CORRIDOR, function: CONNECTION}
  - {name: STAIRS, function: ENTRANCE}
  - {name: STORE, function: SERVICE}
"""


@pytest.fixture(scope="module")
def buildings(tmp_path_factory):
    """A folder of labelled floors."""
    folder = tmp_path_factory.mktemp("buildings")
    for floor in labelled_floors():
        save_floor(floor, folder / floor.source.replace(".xml", ".geojson"))
    return folder


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    path = tmp_path_factory.mktemp("model") / "small.npz"
    save_room_model(small_model(), path)
    return path


@pytest.fixture(scope="module")
def small_map(tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "map.yaml"
    save_ros_map(simulate_map(make_corridor_floor(seed=3)), path)
    return path


@pytest.mark.slow
def test_train_on_a_folder(buildings, tmp_path):
    code, out, err = run_pianta("train", "places", buildings, "-o", tmp_path / "m.npz")
    assert (code, err) == (0, "")
    assert "trained on 6 floors: 148 rooms of type school" in out
    assert "wrong labels on buildings left out:" in out
    assert read_room_model(tmp_path / "m.npz").building_types == ("school",)
    assert list(tmp_path.iterdir()) == [tmp_path / "m.npz"]


def test_a_stray_room_costs_neither_its_building_nor_the_training(tmp_path):
    """The second of three drawings has a room of two points; its other rooms train."""
    for number in range(3):
        path = tmp_path / f"{'abc'[number]}.xml"
        write_comb(path, *["CLASSROOM", "LAB", "CLOSET"][: number + 1], "STAIRS")
        stray = STRAY if number == 1 else ""
        text = path.read_text().replace("SMALL SERVICE", "CLOSET")
        path.write_text(text.replace("</spaces>", f"{stray}</spaces>"))
    code, out, err = run_pianta("train", "places", tmp_path, "-o", tmp_path / "m.npz")
    assert code == 0
    assert "trained on 3 floors" in out
    lost, small = err.splitlines()
    assert "b.xml' is read without some of its rooms: room 6 (STAIRS) has an outline without area" in lost
    assert small == (
        "warning: 2 of 3 buildings have small defects, 2 that stay (rooms that overlap, are tiny, or have no door); "
        "--list-defects prints them"
    )


def test_defects_of_drawings_are_one_line_or_all(tmp_path):
    """Three drawings, each with a store room without a door; all schools, so that there are no types to learn."""
    for name in "abc":
        write_comb(tmp_path / f"{name}.xml", "CLASSROOM", "CLOSET")
    command = ("train", "buildings", tmp_path, "-o", tmp_path / "types.json")
    counted, listed = (run_pianta(*command, *options) for options in ((), ("--list-defects",)))
    *warnings_, error = counted.err.splitlines()
    assert len(warnings_) == 1
    assert warnings_[0].startswith("warning: 3 of 3 buildings have small defects, 3 that stay")
    *warnings_, other_error = listed.err.splitlines()
    assert error == other_error
    assert [line.partition(".xml' ")[2] for line in warnings_] == [
        "has defects that stay: no door leads to room 4 (SMALL SERVICE)"
    ] * 3


@pytest.mark.slow
def test_train_with_a_schema_and_simulated_maps(buildings, tmp_path):
    (tmp_path / "hospital.yaml").write_text(HOSPITAL)
    rename = {"CLASSROOM": "WARD", "CLOSET": "STORE"}
    for floor in labelled_floors()[:3]:
        rooms = tuple(replace(room, label=rename.get(str(room.label), room.label)) for room in floor.rooms)
        unnamed = replace(floor, rooms=rooms, building_type={})
        save_floor(unnamed, tmp_path / floor.source.replace(".xml", ".geojson"))
    files = sorted(tmp_path.glob("*.geojson"))
    options = ("--labels", tmp_path / "hospital.yaml", "--type", "Hospital", "--simulate", 1)
    code, out, err = run_pianta("train", "places", *files, *options, "-o", tmp_path / "m.npz")
    assert (code, err) == (0, "")
    assert "3 floors, and 3 simulated maps of them" in out
    assert read_room_model(tmp_path / "m.npz").building_types == ("hospital",)


def test_unknown_labels_are_listed_and_nothing_is_written(buildings, tmp_path):
    unusual = labelled_floors()[0]
    rooms = tuple(replace(room, label=f"POOL {room.id % 2}") for room in unusual.rooms)
    save_floor(replace(unusual, rooms=rooms), tmp_path / "unusual.geojson")
    code, out, err = run_pianta("train", "places", buildings, tmp_path / "unusual.geojson", "-o", tmp_path / "m.npz")
    assert (code, out) == (2, "")
    assert "'POOL 0', 'POOL 1'" in err
    assert err.count("\n") == 1
    assert not (tmp_path / "m.npz").exists()


@pytest.mark.parametrize("verb", ["places", "buildings", "type"])
def test_no_folder_is_left_of_a_training_that_fails(verb, tmp_path):
    unusual = labelled_floors()[0]
    rooms = tuple(replace(room, label="POOL") for room in unusual.rooms)
    save_floor(replace(unusual, rooms=rooms), tmp_path / "unusual.geojson")
    outcome = run_pianta("train", verb, tmp_path / "unusual.geojson", "-o", tmp_path / "new" / "folder" / "m.npz")
    assert outcome.code == 2
    assert not (tmp_path / "new").exists()


@pytest.mark.slow
def test_a_building_that_cannot_be_read_does_not_stop_the_others(buildings, tmp_path):
    (tmp_path / "bad.xml").write_text("<svg/>")
    code, out, err = run_pianta("train", "places", buildings, tmp_path / "bad.xml", "-o", tmp_path / "m.npz")
    assert code == 1
    assert "bad.xml" in err
    assert "trained on 6 floors" in out


def save_as(floor: Floor, path: Path, **changed: Any) -> None:
    path.parent.mkdir(exist_ok=True)
    save_floor(replace(floor, **changed), path)


@pytest.mark.slow
def test_floors_are_named_by_their_files(tmp_path):
    for floor, name in zip(labelled_floors(), ("St. Anna 1", "St. Anna 2", "b1-1", "b1-2", "b2", "c"), strict=True):
        save_as(floor, tmp_path / "maps" / f"{name}.geojson")
    assert run_pianta("train", "places", tmp_path / "maps", "-o", tmp_path / "m.npz", "-q")[0] == 0
    names = ("St. Anna 1", "St. Anna 2", "b1-1", "b1-2", "b2", "c")
    assert read_room_model(tmp_path / "m.npz").training.floors == tuple(f"{name}.geojson" for name in names)


@pytest.mark.slow
def test_all_names_include_their_folder_if_one_name_repeats(tmp_path):
    """Otherwise one of a/1 and a/2, floors of one building, could be in the training while the other is left out."""
    paths = ("a/house1", "a/house2", "b/house1", "c/x", "c/y", "c/z")
    for floor, path in zip(labelled_floors(), paths, strict=True):
        save_as(floor, tmp_path / f"{path}.geojson")
    folders = [tmp_path / name for name in "abc"]
    assert run_pianta("train", "places", *folders, "-o", tmp_path / "m.npz", "-q")[0] == 0
    sources = read_room_model(tmp_path / "m.npz").training.floors
    assert sources == tuple(f"{path}.geojson" for path in paths)
    assert [building_name(source) for source in sources[:3]] == ["a/house", "a/house", "b/house"]


@pytest.mark.parametrize(
    ("files", "names"),
    [
        (["a/x.xml", "a/y.xml"], ["x.xml", "y.xml"]),
        (["a/x.xml", "b/x.xml", "b/y.xml"], ["a/x.xml", "b/x.xml", "b/y.xml"]),
        (["a/c/x.xml", "b/c/x.xml", "b/c/y.xml"], ["a/c/x.xml", "b/c/x.xml", "b/c/y.xml"]),
        (["a/x.xml", "a/x.geojson"], ["x.xml", "x.geojson"]),
        ([], []),
    ],
)
def test_names_of_files(files, names):
    assert name_sources(files) == names


@pytest.mark.slow
def test_types_in_any_case(buildings, tmp_path):
    for number, floor in enumerate(labelled_floors()[:2]):
        save_as(floor, tmp_path / f"{'ab'[number]}.geojson", building_type={})
    options = ("--type", " SCHOOL ", "-o", tmp_path / "m.npz", "-q")
    assert run_pianta("train", "places", tmp_path / "a.geojson", tmp_path / "b.geojson", *options) == (0, "", "")
    assert read_room_model(tmp_path / "m.npz").building_types == ("school",)


def test_a_type_without_a_name(buildings, tmp_path):
    code, out, err = run_pianta("train", "places", buildings, "--type", " ", "-o", tmp_path / "m.npz")
    assert (code, out) == (2, "")
    assert "--type" in err


def test_faults_are_printed_once_and_before_simulation(tmp_path, monkeypatch):
    first, *others = labelled_floors()[:3]
    bare = (replace(first.rooms[0], label=None), *first.rooms[1:])
    save_as(first, tmp_path / "a.geojson", rooms=bare)
    for number, floor in enumerate(others):
        save_as(floor, tmp_path / f"b{number}.geojson")
    monkeypatch.setattr("pianta.worlds.simulated_readings.simulate_and_reconstruct", None)
    code, out, err = run_pianta("train", "places", tmp_path, "--simulate", 2, "-o", tmp_path / "m.npz")
    assert (code, out) == (2, "")
    assert err.count("a.geojson") == 1


def test_one_file_that_cannot_be_read_is_an_error_in_one_line(tmp_path):
    (tmp_path / "bad.xml").write_text("<svg/>")
    code, out, err = run_pianta("train", "places", tmp_path / "bad.xml", "-o", tmp_path / "m.npz")
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert "bad.xml" in err


def test_several_files_that_cannot_be_read(tmp_path):
    for name in "ab":
        (tmp_path / f"{name}.xml").write_text("<svg/>")
    code, out, err = run_pianta("train", "places", tmp_path, "-o", tmp_path / "m.npz")
    assert (code, out) == (2, "")
    assert err.count("\n") == 3
    assert "buildings" in err


@pytest.mark.parametrize("arguments", [("nowhere",), ("nowhere.xml",)])
def test_missing_buildings_are_refused(arguments, tmp_path):
    code, out, err = run_pianta("train", "places", *arguments, "-o", tmp_path / "m.npz")
    assert (code, out) == (2, "")
    assert "nowhere" in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_model_file_that_is_a_folder(buildings, tmp_path):
    code, _, err = run_pianta("train", "places", buildings, "-o", tmp_path)
    assert code == 2
    assert "folder" in err


@pytest.mark.parametrize("name", ["m.skops", "m", "m.npz.zip"])
def test_a_model_file_of_another_name(buildings, tmp_path, name):
    code, out, err = run_pianta("train", "places", buildings, "-o", tmp_path / "new" / name)
    assert (code, out) == (2, "")
    assert "does not end in .npz" in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_read_labels_rooms_in_all_outputs(small_map, tmp_path):
    code, out, err = run_pianta("read", small_map, "-o", tmp_path / "out", "--type", " School ")
    assert (code, err) == (0, "")
    floor = read_floor(tmp_path / "out" / "floor.geojson")
    assert floor.building_type == {"school": 1.0}
    nodes = read_graph(tmp_path / "out" / "graph.json").nodes
    for room in floor.rooms:
        assert room.label in SCHOOL.by_name
        assert room.labels["school"] == room.label
        assert sum(room.label_probabilities["F/C/E/S"].values()) == pytest.approx(1)
        assert nodes[room.id]["labels"] == room.labels
        assert nodes[room.id]["label_probabilities"]["R/C"] == room.label_probabilities["R/C"]
    assert "CORRIDOR" in out
    properties = json.loads((tmp_path / "out" / "floor.geojson").read_text())["features"][0]["properties"]
    assert {"label", "labels", "label_probabilities"} <= properties.keys()


@pytest.mark.slow
def test_read_without_a_type_labels_functions(small_map, tmp_path):
    assert run_pianta("read", small_map, "-o", tmp_path, "--quiet") == (0, "", "")
    floor = read_floor(tmp_path / "floor.geojson")
    assert {room.label for room in floor.rooms} <= {"FUNCTIONAL", "CONNECTION", "ENTRANCE", "SERVICE"}
    assert {*map(tuple, (room.labels for room in floor.rooms))} == {("R/C", "F/C/E/S")}


@pytest.mark.slow
def test_read_without_labels(small_map, tmp_path):
    assert run_pianta("read", small_map, "-o", tmp_path, "--quiet", "--no-labels") == (0, "", "")
    assert {room.label for room in read_floor(tmp_path / "floor.geojson").rooms} == {None}


@pytest.mark.slow
def test_read_with_a_model_of_the_user(small_map, model, tmp_path):
    options = ("--model", model, "--type", "school", "--quiet")
    assert run_pianta("read", small_map, "-o", tmp_path, *options) == (0, "", "")
    floor = read_floor(tmp_path / "floor.geojson")
    assert {room.label for room in floor.rooms} <= {"CLASSROOM", "CLOSET", "CORRIDOR", "STAIRS"}


@pytest.mark.parametrize(
    ("options", "fragment"),
    [
        (("--type", ""), "--type"),
        (("--type", "castle"), "castle"),
        (("--model", "nowhere.npz"), "nowhere.npz"),
        (("--no-labels", "--type", "school"), "--no-labels"),
    ],
)
def test_options_without_meaning_are_refused(small_map, tmp_path, options, fragment):
    code, out, err = run_pianta("read", small_map, "-o", tmp_path / "out", *options)
    assert (code, out) == (2, "")
    assert fragment in err
    assert not list_files(tmp_path / "out")


def test_a_file_that_is_no_model(small_map, tmp_path):
    (tmp_path / "m.npz").write_text("no model")
    code, _, err = run_pianta("read", small_map, "-o", tmp_path / "out", "--model", tmp_path / "m.npz")
    assert code == 2
    assert " model " in err
    assert err.count("\n") == 1
