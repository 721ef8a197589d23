"""Tables as JSON, and tables in a pipe."""

import json

import pytest
from shapely import LineString, box

import pianta
from pianta.floor import Door, Floor, Room
from tests.command_line import run_pianta

LONG = "Department of Electronics, Information and Bioengineering, seminar room on the second floor"
FLOOR = Floor(
    (
        Room(1, box(0, 2, 4, 5), "CLASSROOM", name=LONG),
        Room(2, box(4, 2, 8, 5), "OFFICE"),
        Room(3, box(0, 0, 8, 2), "CORRIDOR"),
    ),
    (
        Door((1, 3), LineString([(1, 2), (2, 2)]), 1.0),
        Door((2, 3), LineString([(6, 2), (7, 2)]), 1.0, "opening"),
        Door((3, None), LineString([(0, 0.5), (0, 1.5)]), 1.0),
    ),
)


@pytest.fixture
def path(tmp_path):
    FLOOR.save(tmp_path / "floor.geojson")
    return tmp_path / "floor.geojson"


@pytest.fixture(scope="module")
def map_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "map.yaml"
    pianta.make_world("corridor")[1].save(path)
    return path


@pytest.mark.parametrize("verb", ["score", "evacuate", "patterns"])
def test_stdout_has_the_json_alone(path, tmp_path, verb):
    arguments = [verb, path, *([path] if verb == "score" else [])]
    code, out, err = run_pianta(*arguments, "--json", "-")
    assert (code, err) == (0, "")
    on_stdout = json.loads(out)
    assert on_stdout["pianta"] == pianta.__version__
    code, out, _ = run_pianta(*arguments, "--json", tmp_path / "result.json")
    assert code == 0
    assert "{" not in out
    assert out
    assert json.loads((tmp_path / "result.json").read_text(encoding="utf-8")) == on_stdout


def test_read_lists_rooms_and_doors(map_file, tmp_path):
    code, out, _ = run_pianta("read", map_file, "-o", tmp_path / "out", "--no-labels", "--json", "-")
    assert code == 0
    (file,) = json.loads(out)["files"]
    (storey,) = file["storeys"]
    floor = pianta.read_floor(tmp_path / "out" / "floor.geojson")
    assert (file["file"], storey["folder"]) == (str(map_file), str(tmp_path / "out"))
    assert [room["id"] for room in storey["rooms"]] == [room.id for room in floor]
    assert storey["area"] == pytest.approx(sum(room["area"] for room in storey["rooms"]), abs=0.01)
    for room in storey["rooms"]:
        doors = [door for door in storey["doors"] if room["id"] in door["rooms"]]
        assert room["doors"] + room["openings"] + room["entrances"] == len(doors)
        assert {*room["neighbours"]} == {other for door in doors for other in door["rooms"]} - {room["id"], None}


def test_read_lists_the_files_that_can_be_read(map_file, tmp_path):
    bad = tmp_path / "bad.yaml"
    bad.write_text("image: none.png")
    code, out, err = run_pianta("read", map_file, bad, "-o", tmp_path / "out", "--no-labels", "--json", "-")
    assert code == 1
    assert "bad.yaml" in err
    assert [file["file"] for file in json.loads(out)["files"]] == [str(map_file)]


def test_a_table_in_a_pipe_has_a_line_for_each_room(path, capsys, monkeypatch):
    from pianta.cli.reading_text import tabulate_rooms
    from pianta.cli.terminal import print_table

    monkeypatch.delenv("COLUMNS", raising=False)
    print_table(tabulate_rooms(FLOOR))
    lines = [line for line in capsys.readouterr().out.splitlines() if line.strip()]
    assert len(lines) == 2 + 3
    assert LONG in lines[2]


def test_a_folder_as_json_file_is_refused(path, tmp_path):
    code, out, err = run_pianta("evacuate", path, "--json", tmp_path)
    assert (code, out) == (2, "")
    assert "JSON file" in err
    assert err.count("\n") == 1
