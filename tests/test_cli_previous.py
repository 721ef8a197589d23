"""`pianta read --previous` as a user runs it."""

import re
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from rich.console import Console
from shapely import LineString, box

from pianta.cli.reading_text import tabulate_rooms
from pianta.cli.terminal import describe_floor
from pianta.floor import Door, Floor, Room
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io.floors import read_floor, save_floor
from pianta.io.ros_maps import save_ros_map
from pianta.reading._reader import describe_ids
from pianta.worlds.floors import make_corridor_floor
from pianta.worlds.scan import simulate_map
from tests.command_line import list_files, run_pianta


@pytest.fixture(scope="module")
def grid() -> GridMap:
    """A corridor with ten rooms."""
    return simulate_map(make_corridor_floor(length=20, room_width=(3, 5), seed=2))


@pytest.fixture(scope="module")
def map_yaml(grid: GridMap, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("map") / "map.yaml"
    save_ros_map(grid, path)
    return path


@pytest.fixture(scope="module")
def older(map_yaml: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of an older result, in which the rooms have ids from 101 on and a room that is gone had 300."""
    out = tmp_path_factory.mktemp("older")
    assert run_pianta("read", map_yaml, "-o", out, "--quiet").code == 0
    floor = read_floor(out / "floor.geojson")
    rooms = tuple(replace(room, id=100 + room.id, label="LAB") for room in floor.rooms)
    save_floor(replace(floor, rooms=rooms, doors=(), last_id=300), out / "floor.geojson")
    return out


def ids_of(path: Path) -> list[int]:
    return [room.id for room in read_floor(path / "floor.geojson").rooms]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["", "floor.geojson"])
def test_rooms_keep_their_ids_in_all_outputs(map_yaml, older, tmp_path, name):
    code, out, err = run_pianta("read", map_yaml, "--previous", older / name, "-o", tmp_path)
    assert (code, err) == (0, "")
    count = len(ids_of(older))
    assert count > 4
    assert out.splitlines()[-2] == f"{count} rooms kept their ids, 0 are new, 0 are gone"
    floor = read_floor(tmp_path / "floor.geojson")
    assert [room.id for room in floor.rooms] == ids_of(older)
    assert floor.last_id == 300
    assert {room.label for room in floor.rooms} == {"LAB"}
    assert floor.doors
    with Image.open(tmp_path / "rooms.png") as image:
        assert set(np.unique(np.asarray(image))) == {0, *ids_of(older)}


@pytest.mark.slow
def test_the_previous_floor_may_lie_in_the_output_folder(map_yaml, older, tmp_path):
    (tmp_path / "floor.geojson").write_bytes((older / "floor.geojson").read_bytes())
    assert run_pianta("read", map_yaml, "--previous", tmp_path, "-o", tmp_path, "-q") == (0, "", "")
    assert ids_of(tmp_path) == ids_of(older)
    before = list_files(tmp_path)
    run_pianta("read", map_yaml, "--previous", tmp_path, "-o", tmp_path, "-q")
    assert list_files(tmp_path) == before


@pytest.mark.slow
def test_ids_stay_on_an_image_that_has_grown_to_all_sides(grid, older, tmp_path):
    """Without a map.yaml the origin is the lower left corner of the image, so every room lies elsewhere now."""
    grown = np.pad(grid.cells, ((30, 75), (110, 12)), constant_values=UNKNOWN)
    for name, cells in (("small", grid.cells), ("grown", grown)):
        greys = np.select([cells == 0, cells == 100], [254, 0], 205).astype(np.uint8)
        Image.fromarray(greys).save(tmp_path / f"{name}.png")
    plain = ["--resolution", "0.05", "-q"]
    assert run_pianta("read", tmp_path / "small.png", *plain, "--previous", older, "-o", tmp_path / "a").code == 0
    outcome = run_pianta("read", tmp_path / "grown.png", *plain, "--previous", tmp_path / "a", "-o", tmp_path / "b")
    assert outcome == (0, "", "")
    assert ids_of(tmp_path / "a") == ids_of(tmp_path / "b") == ids_of(older)


@pytest.mark.slow
def test_rooms_behind_a_wall_that_is_gone_are_printed(map_yaml, older, tmp_path):
    floor = read_floor(older / "floor.geojson")
    (tmp_path / "in").mkdir()
    extra = Room(200, box(100, 100, 101, 101))
    save_floor(replace(floor, rooms=(*floor.rooms[1:], extra)), tmp_path / "in" / "floor.geojson")
    out = run_pianta("read", map_yaml, "--previous", tmp_path / "in", "-o", tmp_path / "out").out
    summary = f"{len(floor.rooms) - 1} rooms kept their ids, 1 is new, 1 is gone (200)"
    assert out.splitlines()[-2] == summary
    assert ids_of(tmp_path / "out") == [301, *ids_of(older)[1:]]


@pytest.mark.slow
def test_another_building_is_warned_of(map_yaml, tmp_path):
    save_floor(Floor((Room(5, box(500, 500, 503, 503)),)), tmp_path / "floor.geojson")
    code, out, err = run_pianta("read", map_yaml, "--previous", tmp_path, "-o", tmp_path / "out")
    assert code == 0
    assert err.startswith("warning: ")
    assert str(map_yaml) in err
    assert "--previous" in err
    assert len(err.splitlines()) == 1
    assert re.fullmatch(r"0 rooms kept their ids, \d+ are new, 1 is gone \(5\)", out.splitlines()[-2])
    assert min(ids_of(tmp_path / "out")) == 6


def test_one_floor_is_not_the_previous_one_of_several_maps(map_yaml, older, tmp_path):
    code, out, err = run_pianta("read", map_yaml, map_yaml, "--previous", older, "-o", tmp_path / "out")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("error: ")
    assert "--previous" in err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("content", "fragment"),
    [(None, "exist"), ("", "empty"), ("{", "floor.geojson"), ("[]", "floor.geojson")],
)
@pytest.mark.parametrize("name", ["", "floor.geojson"])
def test_a_bad_previous_floor_is_one_line_and_writes_nothing(map_yaml, tmp_path, content, fragment, name):
    (tmp_path / "in").mkdir()
    if content is not None:
        (tmp_path / "in" / "floor.geojson").write_text(content)
    code, out, err = run_pianta("read", map_yaml, "--previous", tmp_path / "in" / name, "-o", tmp_path / "out")
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert line.startswith("error: ")
    assert fragment in line
    assert [path.name for path in tmp_path.iterdir()] == ["in"]


@pytest.mark.parametrize(
    ("ids", "old_ids", "line"),
    [
        ([1], [1], "1 room kept its id, 0 are new, 0 are gone"),
        ([1, 2, 9], [1, 2, 7], "2 rooms kept their ids, 1 is new, 1 is gone (7)"),
        ([9], [2, 1], "0 rooms kept their ids, 1 is new, 2 are gone (1 2)"),
        ([20, 21], range(1, 13), "0 rooms kept their ids, 2 are new, 12 are gone (1 2 3 4 5 6 7 8 9 10 …)"),
    ],
)
def test_changes_of_the_ids_are_described_in_a_line(ids, old_ids, line):
    floor, previous = (Floor(tuple(Room(room_id, box(0, 0, 1, 1)) for room_id in each)) for each in (ids, old_ids))
    assert describe_ids(floor, previous) == line


def test_entrances_are_counted_apart_from_doors():
    line = LineString([(0, 0), (0, 1)])
    doors = Door((1, 2), line, 1), Door((2, None), line, 1), Door((2, None), line, 1, "opening")
    floor = Floor((Room(1, box(0, 0, 4, 3)), Room(2, box(4, 0, 5, 3))), doors)
    console = Console(file=StringIO(), width=80)
    console.print(tabulate_rooms(floor))
    assert isinstance(console.file, StringIO)
    rows = [line.split() for line in console.file.getvalue().splitlines()]
    assert ["room", "area", "m²", "doors", "entrances", "neighbours"] in rows
    assert ["1", "12.0", "1", "2"] in rows
    assert ["2", "3.0", "1", "2", "1"] in rows
    assert describe_floor(floor) == "2 rooms, 1 door, 2 entrances, 15.0 m²"
    assert describe_floor(Floor(floor.rooms, doors[:2])) == "2 rooms, 1 door, 1 entrance, 15.0 m²"
    shut = Floor(floor.rooms, doors[:1], possible_doors=doors[:2])
    assert describe_floor(shut) == "2 rooms, 1 door, 2 possible doors, 15.0 m²"
