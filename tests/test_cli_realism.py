"""`pianta realism` as a user runs it."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.building_types import model_file as building_model_file
from pianta.building_types.description import describe_building
from pianta.building_types.model import BuildingTypeModel
from pianta.cli.realism import name_pictures
from pianta.floor import Floor
from pianta.io.floors import parse_floor, save_floor
from pianta.labels import OFFICE, LabelSet
from pianta.rooms.completion import map_labels_upwards
from tests.command_line import list_files, run_pianta
from tests.simulated_offices import make_offices, make_snake, make_worlds


@pytest.fixture(scope="module")
def offices(tmp_path_factory):
    return save_all(make_offices(), tmp_path_factory.mktemp("offices"))


@pytest.fixture(scope="module")
def worlds(tmp_path_factory):
    return save_all(make_worlds(), tmp_path_factory.mktemp("worlds"))


@pytest.fixture(scope="module")
def maze(tmp_path_factory):
    path = tmp_path_factory.mktemp("maze") / "maze.geojson"
    save_floor(make_snake(4, 4), path)
    return path


def save_all(floors: tuple[Floor, ...], folder: Path) -> Path:
    for floor in floors:
        save_floor(floor, folder / floor.source.replace(".xml", ".geojson"))
    return folder


@pytest.mark.slow
def test_one_floor(offices, maze, tmp_path):
    code, out, err = run_pianta("realism", maze, "--reference", offices, "--json", tmp_path / "new" / "m.json")
    assert (code, err) == (0, "")
    first, second, third, *reasons = out.splitlines()
    assert first == "reference: 8 floors of 8 buildings, labels R/C"
    assert second == "maze.geojson: 0.00, less typical than any of the 8 reference floors"
    assert re.fullmatch(r"  most like \w+ \w\.geojson(, \w+ \w\.geojson){2}", third)
    assert 4 <= len(reasons) <= 8
    assert any(line.startswith("  often a ROOM that leads to 2 ROOMs and no CORRIDOR: ") for line in reasons)
    content = json.loads((tmp_path / "new" / "m.json").read_text())
    assert content["label_set"] == "R/C"
    assert (len(content["reference"]), content["unrealistic"]) == (8, [])
    (floor,) = content["floors"]
    assert (floor["floor"], floor["score"], floor["probability"], floor["left_out"]) == ("maze.geojson", 0, None, False)
    listed = [f"  {off['reason']}" for off in (*floor["measures"], *floor["patterns"])]
    assert listed == reasons
    assert len(floor["measures"][0]["usual"]) == 8


@pytest.mark.slow
def test_several_floors_with_two_classes(offices, worlds, tmp_path):
    arguments = worlds, "--reference", offices, "--unrealistic", worlds, "-o", tmp_path / "pictures"
    code, out, err = run_pianta("realism", *arguments)
    assert (code, err) == (0, "")
    first, *others = out.splitlines()
    assert first == "reference: 8 floors of 8 buildings against 3 unrealistic floors, labels R/C"
    assert [line.partition(":")[0] for line in others] == [
        "grid 5x4.geojson",
        "snake 5x4.geojson",
        "snake 6x3.geojson",
    ]
    for line in others:
        assert re.search(r": 0\.[0-4]\d, not realistic, probability 0\.[0-4]\d of being so; less typical", line)
        assert line.endswith(" (its building left out of the reference)")
    pictures = {"grid 5x4.png", "snake 5x4.png", "snake 6x3.png"}
    assert {*list_files(tmp_path / "pictures")} == {*pictures, "realism.json"}


def test_a_floor_of_the_reference_is_compared_with_the_others(offices):
    code, out, _ = run_pianta("realism", offices / "l a.geojson", "--reference", offices)
    assert code == 0
    assert "of the 7 reference floors" in out
    assert "(its building left out of the reference)" in out
    assert "most like l a" not in out


@pytest.mark.slow
def test_whether_a_floor_is_in_the_reference_does_not_depend_on_its_file_name(offices, maze, tmp_path):
    shutil.copy(offices / "l a.geojson", tmp_path / "copy.geojson")
    shutil.copy(maze, tmp_path / "l a.geojson")
    code, out, _ = run_pianta("realism", tmp_path / "copy.geojson", tmp_path / "l a.geojson", "--reference", offices)
    copy, other = (line for line in out.splitlines() if line.startswith(("copy", "l a")))
    assert code == 0
    assert "of the 7 reference floors" in copy
    assert copy.endswith("(its building left out of the reference)")
    assert other == "l a.geojson: 0.00, less typical than any of the 8 reference floors"


def test_a_floor_that_fails_does_not_stop_the_others(offices, maze, tmp_path):
    broken = tmp_path / "broken.geojson"
    broken.write_text("{}")
    code, out, err = run_pianta("realism", broken, maze, "--reference", offices, "--reasons")
    assert code == 1
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert "maze.geojson: 0.00" in out
    assert "  seldom a ROOM" in out
    code, out, err = run_pianta("realism", maze, "--reference", offices, "--reference", broken)
    assert (code, err.count("\n")) == (1, 1)
    assert "maze.geojson: 0.00" in out
    code, _, err = run_pianta("realism", broken, "--reference", offices)
    assert (code, err.count("\n")) == (2, 1)


@pytest.mark.slow
def test_labels_by_pianta_are_counted(offices, maze, tmp_path):
    floor = make_snake(4, 4)
    save_floor(
        replace(floor, rooms=tuple(replace(room, label=None) for room in floor.rooms)), tmp_path / "bare.geojson"
    )
    code, out, _ = run_pianta("realism", tmp_path / "bare.geojson", "--reference", offices)
    assert code == 0
    assert "(labels of 16 of 16 rooms by pianta)" in out
    code, out, err = run_pianta("realism", maze, "--reference", offices, "--quiet")
    assert (code, out, err) == (0, "", "")


@pytest.mark.slow
def test_floors_that_come_with_pianta(maze, monkeypatch, tmp_path):
    labelled = [map_labels_upwards(label_as_office(floor), OFFICE) for floor in make_offices()]
    described = tuple(describe_building(floor, LabelSet.F_C_E_S) for floor in labelled)
    types = ("office",) * 4 + ("school",) * 4
    model = BuildingTypeModel(described, types, tuple(each.source for each in described), LabelSet.F_C_E_S)
    monkeypatch.setattr(building_model_file, "read_default_building_type_model", lambda: model)
    save_floor(label_as_office(make_snake(4, 4)), tmp_path / "maze.geojson")
    code, out, err = run_pianta("realism", tmp_path / "maze.geojson", "--type", "Office")
    assert (code, err) == (0, "")
    assert out.startswith(
        "reference: 4 floors of 4 buildings, labels F/C/E/S, of those of type Office that come with pianta\n"
        "maze.geojson: 0.00, less typical than any of the 4 reference floors\n"
    )
    code, out, _ = run_pianta("realism", tmp_path / "maze.geojson", "--labels", "f/c/e/s")
    assert out.startswith("reference: 8 floors of 8 buildings, labels F/C/E/S, of those that come with pianta\n")
    save_floor(label_as_office(make_offices()[0]), tmp_path / "corridor a.xml.geojson")
    (tmp_path / "corridor a.xml.geojson").rename(tmp_path / "corridor a.xml")
    code, out, _ = run_pianta("realism", tmp_path / "corridor a.xml")
    assert (code, "(its building left out of the reference)" in out) == (0, True)
    for arguments, fragment in (
        (("--labels", "R/C"), "F/C/E/S"),
        (("--type", "church"), "church"),
        (("--unrealistic", tmp_path), "--reference"),
    ):
        code, out, err = run_pianta("realism", maze, *arguments)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert err.startswith("error: ")
        assert fragment in err


def label_as_office(floor: Floor) -> Floor:
    rooms = (replace(room, label="OFFICE" if room.label == "ROOM" else "CORRIDOR") for room in floor.rooms)
    return replace(floor, rooms=tuple(rooms))


@pytest.mark.slow
def test_the_folder_has_the_results_with_their_shapes(offices, maze, tmp_path):
    code, _, _ = run_pianta(
        "realism", maze, "--reference", offices, "-o", tmp_path / "out", "--json", tmp_path / "m.json"
    )
    assert code == 0
    assert {file.name for file in (tmp_path / "out").iterdir()} == {"maze.png", "realism.json"}
    content = json.loads((tmp_path / "out" / "realism.json").read_text())
    shapes = content["floors"][0].pop("shapes")
    assert content == json.loads((tmp_path / "m.json").read_text())
    assert parse_floor(json.dumps(shapes).encode()).rooms


def test_options_without_meaning_are_refused(offices, maze, tmp_path):
    (tmp_path / "two").mkdir()
    save_all(make_offices()[:2], tmp_path / "two")
    (tmp_path / "file").write_text("")
    for arguments, fragment in (
        ((maze, "--reference", offices, "--labels", "rooms"), "--labels"),
        ((maze, "--reference", offices, "--type", "office"), "--type"),
        ((maze, "--reference", tmp_path / "two"), "reference"),
        ((maze, "--reference", offices, "--json", tmp_path / "two"), "JSON"),
        ((maze, "--reference", offices, "-o", tmp_path / "file"), "folder"),
        ((tmp_path / "none.xml", "--reference", offices), "none.xml"),
        ((maze, "--reference", tmp_path / "none.xml"), "reference"),
    ):
        code, _, err = run_pianta("realism", *arguments)
        assert code == 2
        line = err.splitlines()[-1]
        assert line.startswith("error: ")
        assert fragment in line


def test_names_of_pictures():
    assert name_pictures(["a.xml", "b.geojson"]) == ["a.png", "b.png"]
    assert name_pictures(["a.xml", "a.json", "c"]) == ["a.xml.png", "a.json.png", "c.png"]
    assert name_pictures(["one/floor.geojson", "two/floor.geojson"]) == ["one_floor.png", "two_floor.png"]
    assert name_pictures(["a/b.xml", "a_b.xml"]) == ["a_b.xml.png", "a_b.xml-2.png"]
    assert name_pictures(["A.xml", "a.xml", "a.json"]) == ["A.xml.png", "a.xml-2.png", "a.json.png"]
    assert name_pictures(["a.xml", "a.json", "a.xml.gz"]) == ["a.xml.png", "a.json.png", "a.xml-2.png"]


@given(st.lists(st.text("aA/._x", min_size=1, max_size=5), unique=True, max_size=8))
def test_pictures_have_different_names_on_any_disk(names):
    pictures = name_pictures(names)
    assert len({picture.casefold() for picture in pictures}) == len(names)
    assert not any("/" in picture for picture in pictures)


def test_a_file_is_realistic_or_not(offices, worlds, maze):
    arguments = "--reference", offices, "--reference", worlds / "grid 5x4.geojson", "--unrealistic", worlds
    code, out, err = run_pianta("realism", maze, *arguments)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("error: ")
    assert all(word in err for word in ("--reference", "--unrealistic", "grid 5x4.geojson"))
