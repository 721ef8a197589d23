"""`pianta evacuate` as a user runs it."""

import json

import pytest
from PIL import Image
from shapely import LineString, box

import pianta
from pianta.floor import Door, Floor, Room
from tests.command_line import list_files, run_pianta

FLOOR = Floor(
    (
        Room(1, box(0, 0, 10, 6), "CLASSROOM"),
        Room(2, box(0, 6, 10, 8), "CORRIDOR"),
        Room(3, box(10, 6, 14, 8), "STAIRS"),
    ),
    (
        Door((1, 2), LineString([(2, 6), (3, 6)]), 1.0),
        Door((2, 3), LineString([(10, 6.5), (10, 7.5)]), 1.0),
        Door((1, 2), LineString([(7, 6), (8, 6)]), 1.0),
    ),
    source="school.xml",
)
ALONE = Floor((*FLOOR.rooms, Room(4, box(20, 0, 24, 3))), FLOOR.doors, source="school.xml")


@pytest.fixture
def path(tmp_path):
    FLOOR.save(tmp_path / "floor.geojson")
    return tmp_path / "floor.geojson"


def test_it_prints_ways_and_doors_and_writes_the_result(path, tmp_path):
    """60 m² of a classroom are 32 people; from its middle over the right door to the stairs."""
    code, out, err = run_pianta("evacuate", path, "-o", tmp_path / "out")
    assert (code, err) == (0, "")
    assert "3 rooms, 32 people, exits: rooms 3" in out
    assert "one way out: 2 of 3 rooms, 1 of them dead ends" in out
    assert {*list_files(tmp_path / "out")} == {"evacuation.json", "picture.png"}
    content = json.loads((tmp_path / "out" / "evacuation.json").read_text())
    classroom = content["rooms"][0]
    assert (classroom["people"], classroom["doors"], classroom["shared_doors"]) == (32, [3, 2], [2])
    assert classroom["distance"] == pytest.approx((2.5**2 + 3**2) ** 0.5 + (2.5**2 + 1) ** 0.5, abs=0.01)
    assert f"all out after {content['time']:.0f} s" in out
    with Image.open(tmp_path / "out" / "picture.png") as picture:
        assert max(picture.size) >= 1600


def test_it_takes_the_folder_of_read(path):
    assert run_pianta("evacuate", path.parent).out == run_pianta("evacuate", path).out


def test_options_reach_the_library(path):
    options = ("--exit", 1, "--people", "2=5", "--density", "stairs=0.5", "--density", "0", "--shut", 1)
    code, out, err = run_pianta("evacuate", path, *options)
    expected = pianta.evacuate(FLOOR, exits=[1], people={2: 5}, densities={"STAIRS": 0.5}, density=0, shut=[1])
    assert (code, err) == (0, "")
    assert expected.people == 5 + 4
    assert "3 rooms, 9 people, exits: rooms 1" in out
    assert f"all out after {expected.time:.0f} s" in out


def test_the_tables_fit_a_narrow_terminal(path, monkeypatch):
    """With 80 columns labels and headings are whole; a door that cuts all people off has no time of the others."""
    monkeypatch.setenv("COLUMNS", "80")
    code, out, _ = run_pianta("evacuate", path)
    assert code == 0
    assert "CLASSROOM" in out
    assert "end m" in out
    (worst,) = (line for line in out.splitlines() if line.split()[:2] == ["2", "2-3"])
    assert worst.split()[-1] == "–"


def test_a_density_for_a_label_that_no_room_has_is_a_warning(path):
    code, out, err = run_pianta("evacuate", path, "--density", "clasroom=2")
    assert (code, err.count("\n")) == (0, 1)
    assert "no room has the label CLASROOM of --density, the floor's labels are: CLASSROOM, CORRIDOR, STAIRS" in err
    assert "32 people" in out


def test_doors_are_shut_by_their_rooms(path):
    code, _, err = run_pianta("evacuate", path, "--shut", "2-1", "-q")
    assert code == 0
    assert err.startswith("warning: floor 'school.xml': 1 of 3 rooms have no way out")


def test_a_floor_in_several_parts_is_evacuated_with_a_warning(tmp_path):
    ALONE.save(tmp_path / "alone.geojson")
    code, out, err = run_pianta("evacuate", tmp_path / "alone.geojson")
    assert code == 0
    assert err.count("\n") == 1
    assert "no way out" in err
    assert "all out after" in out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--exit", 9), "--exit has the rooms 9"),
        (("--shut", 4), "--shut has the door 4, which does not exist, give a number from 1 to 3"),
        (("--shut", "1-3"), "--shut has the door 1-3"),
        (("--shut", "1-out"), "--shut has the door 1-out"),
        (("--shut", "front"), "--shut has 'front', give a whole number"),
        (("--shut", "1-2-3"), "--shut is '1-2-3'"),
        (("--shut", "out"), "--shut is 'out'"),
        (("--shut", 2), "no room has a way to an exit"),
        (("--people", "1=-3"), "--people has -3 for room 1"),
        (("--people", "8=3"), "--people has the rooms 8"),
        (("--people", "12"), "--people is '12'"),
        (("--people", "one=2"), "--people has 'one'"),
        (("--density", "-0.1"), "--density is -0.1 for all rooms"),
        (("--density", "OFFICE=many"), "--density is 'OFFICE=many'"),
        (("--density", "nan"), "--density is nan"),
    ],
)
def test_bad_options_are_one_line(path, tmp_path, options, message):
    code, out, err = run_pianta("evacuate", path, "-o", tmp_path / "out", *options)
    assert (code, out) == (2, "")
    assert message in err
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("floor", "message"),
    [
        (Floor(FLOOR.rooms[:2], FLOOR.doors[::2]), "no exit is known"),
        (Floor(FLOOR.rooms, FLOOR.doors[::2]), "no room has a way to an exit"),
        (Floor(()), "no exit is known"),
    ],
)
def test_floors_without_a_way_out_are_one_line(tmp_path, floor, message):
    floor.save(tmp_path / "floor.geojson")
    code, _, err = run_pianta("evacuate", tmp_path / "floor.geojson")
    assert code == 2
    assert message in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("content", ["", "{}", "<building/>"])
def test_what_is_no_floor_is_one_line(tmp_path, content):
    (tmp_path / "floor.geojson").write_text(content)
    for path in (tmp_path / "floor.geojson", tmp_path / "missing.xml", tmp_path / "missing"):
        code, _, err = run_pianta("evacuate", path)
        assert code == 2
        assert err.count("\n") == 1


@pytest.mark.slow
def test_a_floor_of_a_map_without_labels_has_one_density(tmp_path):
    """Read from a simulated map; rooms are exits only if the user says so."""
    assert run_pianta("world", "corridor", "-o", tmp_path / "world").code == 0
    assert run_pianta("read", tmp_path / "world" / "map.yaml", "--no-labels", "-o", tmp_path / "read").code == 0
    code, out, err = run_pianta("evacuate", tmp_path / "read", "--exit", 1)
    assert (code, err) == (0, "")
    assert "all out after" in out
