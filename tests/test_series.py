"""All maps of a bag, as the map of a building that grows."""

import numpy as np
import pytest

import pianta
from pianta.errors import MapError, OptionError
from tests.command_line import run_pianta

pytest.importorskip("rosbags")

import itertools

from tests.bag_files import GRID_TYPE, ROS2, make_grid_of_map, write_bag


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """The corridor world as a robot sees it from left to right: nothing, a third, the same, two thirds, all."""
    grid = pianta.make_world("corridor")[1]
    messages = []
    for share in (0.0, 0.35, 0.35, 0.7, 1.0):
        cells = np.full(grid.shape, -1)
        width = int(grid.shape[1] * share)
        cells[:, :width] = grid.cells[:, :width]
        part = pianta.GridMap(cells, grid.resolution, grid.origin)
        messages.append(("/map", GRID_TYPE, make_grid_of_map(ROS2, part)))
    return write_bag(tmp_path_factory.mktemp("bags") / "run", messages)


@pytest.mark.slow
def test_rooms_keep_their_ids(bag, tmp_path):
    first, *readings = pianta.read_series(bag, out=tmp_path, labels=False, predict_partial=False)
    # Nothing is seen in the first map, and the third is equal to the second
    assert isinstance(first, pianta.Failure)
    assert "map 1 of " in str(first.error)
    assert [reading.folder for reading in readings if isinstance(reading, pianta.Reading)] == [
        tmp_path / name for name in ("002", "003", "004")
    ]
    floors = [pianta.read_floor(tmp_path / name / "floor.geojson") for name in ("002", "003", "004")]
    for earlier, later in itertools.pairwise(floors):
        assert len(later) > len(earlier)
        # A room that lies in a larger map too has the id that it had
        whole_rooms = [room for room in earlier if not room.partial]
        assert len(whole_rooms) >= 3
        for room in whole_rooms:
            other = later[room.id].polygon
            assert room.polygon.intersection(other).area > 0.9 * min(room.polygon.area, other.area)


@pytest.mark.slow
def test_command(bag, tmp_path):
    result = run_pianta("read", bag, "-o", tmp_path / "series", "--message", "all", "--no-labels", "--no-predictions")
    assert result.code == 0
    assert result.out.splitlines()[-1] == "3 of 4 maps read"
    assert sorted(path.name for path in (tmp_path / "series").iterdir()) == ["002", "003", "004"]


def test_a_file_that_is_no_bag(tmp_path):
    pianta.make_world("corridor")[1].save(tmp_path / "map.yaml")
    with pytest.raises(MapError, match="is no bag, and has no series of maps"):
        pianta.read_series(tmp_path / "map.yaml")


def test_one_message_is_no_series(bag):
    with pytest.raises(OptionError, match="message= is for one map of a bag"):
        pianta.read_series(bag, message=1)


@pytest.mark.parametrize("flag", [["--explain"], ["--clean", "clean.yaml"], ["--storey", "ground"]])
def test_flags_of_one_map(bag, tmp_path, flag):
    result = run_pianta("read", bag, "-o", tmp_path, "--message", "all", *flag)
    assert result.code == 2
    assert f"--message all is a series of maps, leave out {flag[0]}" in result.err


def test_several_bags(bag, tmp_path):
    result = run_pianta("read", bag, bag, "-o", tmp_path, "--message", "all")
    assert result.code == 2
    assert "is for one bag and 2 files are given" in result.err


@pytest.mark.parametrize("message", ["first", "-1", "1.5", ""])
def test_messages_of_the_command(bag, tmp_path, message):
    result = run_pianta("read", bag, "-o", tmp_path, f"--message={message}")
    assert result.code == 2
    assert "give last, all, or a number from 1" in result.err
