"""Maps from rosbags, which rosbags itself has written."""

import bz2
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pianta
from pianta.errors import MapError, MapWarning, OptionError

pytest.importorskip("rosbags")

import lz4.frame  # type: ignore[import-untyped]
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import Writer

from pianta.gridmap import GridMap
from pianta.io import _bag_limits
from pianta.io.bags import UPDATE_TYPE, iterate_bag
from tests.bag_files import GRID_TYPE, ROS1, ROS2, make_grid, make_grid_of_map, make_header, make_update, write_bag
from tests.command_line import run_pianta

# Two rows of three cells, the lower one first.
CELLS = [[0, 100, -1], [50, 0, 0]]


def types_of(name: str) -> Any:
    return ROS1 if name.endswith(".bag") else ROS2


def read_or_fail(path: Path) -> str:
    """What is wrong with a bag; another exception than ours fails the test."""
    try:
        return repr(pianta.read_map(path, max_cells=1000))
    except (MapError, OptionError) as error:
        return str(error)


def write_grids(folder: Path, *grids: Any, name="run", topic="/map", storage="mcap") -> Path:
    messages = [(topic, GRID_TYPE, make_grid(types_of(name), cells)) for cells in grids]
    return write_bag(folder / name, messages, storage=storage)


@pytest.mark.parametrize(("name", "storage"), [("run.bag", ""), ("run", "mcap"), ("run", "sqlite3")])
class TestRoundTrip:
    def test_cells_are_equal_byte_for_byte(self, tmp_path, name, storage):
        grid = pianta.make_world("corridor")[1]
        message = make_grid_of_map(types_of(name), grid)
        path = write_bag(tmp_path / name, [("/map", GRID_TYPE, message)], storage=storage)
        read = pianta.read_map(path)
        assert read.cells.tobytes() == grid.cells.tobytes()
        assert (read.resolution, read.origin) == (grid.resolution, grid.origin)
        # And back: the message of the map that was read is the message that was written
        assert make_grid_of_map(types_of(name), read).data.tobytes() == message.data.tobytes()

    def test_row_0_of_a_message_is_the_bottom(self, tmp_path, name, storage):
        grid = pianta.read_map(write_grids(tmp_path, CELLS, name=name, storage=storage))
        assert grid.cells.tolist() == [[50, 0, 0], [0, 100, -1]]
        assert (grid.resolution, grid.origin, grid.source) == (0.05, (0, 0, 0), name)


class TestMessages:
    @pytest.mark.parametrize(("message", "value"), [("last", 3), (1, 1), (2, 2), (3, 3)])
    def test_the_last_or_the_nth(self, tmp_path, message, value):
        path = write_grids(tmp_path, [[1]], [[2]], [[3]])
        assert pianta.read_map(path, message=message).cells.tolist() == [[value]]

    def test_all_without_repetitions(self, tmp_path):
        path = write_grids(tmp_path, [[1]], [[1]], [[2, 2]], [[1]])
        assert [grid.cells.tolist() for grid in iterate_bag(path) if isinstance(grid, GridMap)] == [
            [[1]],
            [[2, 2]],
            [[1]],
        ]

    def test_a_number_beyond_the_last(self, tmp_path):
        path = write_grids(tmp_path, [[1]], [[2]])
        with pytest.raises(MapError, match=r"has 2 maps, not 3; give message= up to 2$"):
            pianta.read_map(path, message=3)

    @pytest.mark.parametrize("message", [0, -1, "first", 1.5, True])
    def test_no_message(self, tmp_path, message):
        with pytest.raises(OptionError, match="give 'last' or a number from 1"):
            pianta.read_map(tmp_path, message=message)

    @pytest.mark.parametrize("file", ["run_0.mcap", "run.mcap"])
    def test_a_bare_file(self, tmp_path, file):
        write_grids(tmp_path, CELLS)
        (path,) = (tmp_path / "run").glob("*.mcap")
        path = path.rename(tmp_path / file)
        assert pianta.read_map(path).shape == (2, 3)


class TestUpdates:
    def test_they_change_a_part(self, tmp_path):
        messages = [
            ("/map_updates", UPDATE_TYPE, make_update(ROS2, [[9]], 0, 0)),
            ("/map", GRID_TYPE, make_grid(ROS2, np.zeros((2, 3)))),
            ("/map_updates", UPDATE_TYPE, make_update(ROS2, [[100, -1]], 1, 0)),
            ("/map", GRID_TYPE, make_grid(ROS2, np.ones((2, 3)))),
            ("/map_updates", UPDATE_TYPE, make_update(ROS2, [[7], [8]], 0, 0)),
        ]
        path = write_bag(tmp_path / "run", messages)
        # An update before the first map changes nothing; row 0 of an update is at the bottom
        assert pianta.read_map(path, message=1).cells.tolist() == [[0, 0, 0], [0, 100, -1]]
        assert pianta.read_map(path).cells.tolist() == [[8, 1, 1], [7, 1, 1]]

    @pytest.mark.parametrize(("x", "y"), [(-1, 0), (2, 0), (0, 2)])
    def test_one_beside_the_map_is_left_out(self, tmp_path, x, y):
        messages = [
            ("/map", GRID_TYPE, make_grid(ROS2, CELLS)),
            ("/map_updates", UPDATE_TYPE, make_update(ROS2, [[9, 9]], x, y)),
        ]
        path = write_bag(tmp_path / "run", messages)
        with pytest.warns(MapWarning, match="1 update of map 1 left out"):
            assert 9 not in pianta.read_map(path).cells


class TestTopics:
    def write_two(self, folder: Path) -> Path:
        messages = [(f"/{name}", GRID_TYPE, make_grid(ROS2, [[number]])) for number, name in enumerate(("a", "b"))]
        return write_bag(folder / "run", messages)

    def test_several_are_listed(self, tmp_path):
        with pytest.raises(OptionError, match=r"has 2 topics with maps, give topic= one of /a, /b$"):
            pianta.read_map(self.write_two(tmp_path))

    @pytest.mark.parametrize("topic", ["/b", "b"])
    def test_one_is_chosen(self, tmp_path, topic):
        assert pianta.read_map(self.write_two(tmp_path), topic=topic).cells.tolist() == [[1]]

    def test_another_name(self, tmp_path):
        with pytest.raises(OptionError, match="has no map on topic '/c', give one of /a, /b"):
            pianta.read_map(self.write_two(tmp_path), topic="/c")

    def test_a_topic_without_a_message(self, tmp_path):
        with Writer(tmp_path / "run", version=9) as writer:
            writer.add_connection("/map", GRID_TYPE, typestore=ROS2)
        with pytest.raises(MapError, match="has the topic and no message of it"):
            pianta.read_map(tmp_path / "run")

    def test_none_has_a_map(self, tmp_path):
        path = write_bag(tmp_path / "run", [("/clock", "std_msgs/msg/Header", make_header(ROS2))])
        with pytest.raises(MapError, match=r"no topic with nav_msgs/OccupancyGrid; it has /clock \(std_msgs"):
            pianta.read_map(path)


class TestHostileMessages:
    @pytest.mark.parametrize(
        ("values", "fault"),
        [
            ({"turn": (0.1, 0.0, 0.0, 0.995)}, "has roll or pitch"),
            ({"turn": (0.0, 0.0, 0.0, 5.0)}, "give a quaternion of length 1"),
            ({"turn": (0.0, 0.0, float("nan"), 1.0)}, "give a quaternion of length 1"),
            ({"position": (float("nan"), 0.0)}, "origin is"),
            ({"resolution": 0.0}, "resolution is 0.0"),
            ({"resolution": float("inf")}, "resolution is inf"),
        ],
    )
    def test_impossible_values(self, tmp_path, values, fault):
        path = write_bag(tmp_path / "run", [("/map", GRID_TYPE, make_grid(ROS2, CELLS, **values))])
        with pytest.raises(MapError, match=fault) as error:
            pianta.read_map(path)
        assert "map 1: " in str(error.value)
        assert "\n" not in str(error.value)

    @pytest.mark.parametrize(("width", "height"), [(4, 2), (0, 0), (2, 4), (2**32 - 1, 2**32 - 1)])
    def test_sizes_that_are_not_those_of_the_data(self, tmp_path, width, height):
        message = make_grid(ROS2, CELLS)
        message.info.width, message.info.height = width, height
        with pytest.raises(MapError, match=r"the message is damaged|the limit is"):
            pianta.read_map(write_bag(tmp_path / "run", [("/map", GRID_TYPE, message)]))

    @pytest.mark.parametrize("value", [101, -2])
    def test_values_out_of_range(self, tmp_path, value):
        with pytest.raises(MapError, match="give -1 to 100"):
            pianta.read_map(write_grids(tmp_path, [[0, value]]))

    def test_a_map_above_the_limit(self, tmp_path):
        with pytest.raises(MapError, match="3 × 2 = 6 cells, the limit is 5"):
            pianta.read_map(write_grids(tmp_path, CELLS), max_cells=5)

    @pytest.mark.parametrize(
        ("turn", "yaw"),
        [
            ((0, 0, 0, 0), 0),
            ((0, 0, np.sqrt(0.5), np.sqrt(0.5)), np.pi / 2),
            ((0, 0, -np.sqrt(0.5), -np.sqrt(0.5)), np.pi / 2),
            ((0, 0, np.sin(-0.5), np.cos(-0.5)), -1),
        ],
    )
    def test_yaw(self, tmp_path, turn, yaw):
        message = make_grid(ROS2, CELLS, turn=tuple(map(float, turn)))
        grid = pianta.read_map(write_bag(tmp_path / "run", [("/map", GRID_TYPE, message)]))
        assert grid.origin[2] == pytest.approx(yaw)


class TestDamagedBags:
    @pytest.mark.parametrize("name", ["run.bag", "run.mcap", "run.db3"])
    @pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.99])
    def test_one_that_was_cut_off_is_one_line(self, tmp_path, name, share):
        if name == "run.bag":
            path = write_grids(tmp_path, CELLS, CELLS, name=name)
        else:
            write_grids(tmp_path, CELLS, CELLS, storage="mcap" if name.endswith("mcap") else "sqlite3")
            (path,) = (tmp_path / "run").glob(f"*.{name[4:]}")
        path.write_bytes(path.read_bytes()[: int(path.stat().st_size * share)])
        with pytest.raises(MapError, match=r"is damaged or was cut off: .*; repair it by ") as error:
            pianta.read_map(path)
        assert "\n" not in str(error.value)

    @pytest.mark.parametrize("name", ["run.bag", "run.mcap", "run.db3"])
    def test_random_damage_is_a_fault_of_one_line_or_none(self, tmp_path, name):
        if name == "run.bag":
            path = write_grids(tmp_path, CELLS, name=name)
        else:
            write_grids(tmp_path, CELLS, storage="mcap" if name.endswith("mcap") else "sqlite3")
            (path,) = (tmp_path / "run").glob(f"*.{name[4:]}")
        content, random = path.read_bytes(), np.random.default_rng(0)
        for _ in range(100):
            damaged = bytearray(content)
            for index in random.integers(0, len(content), 5):
                damaged[index] = random.integers(0, 256)
            path.write_bytes(damaged)
            assert "\n" not in read_or_fail(path)

    def test_a_text_that_is_no_bag(self, tmp_path):
        path = tmp_path / "notes.mcap"
        path.write_text("no bag")
        with pytest.raises(MapError, match="is damaged or was cut off"):
            pianta.read_map(path)

    def test_options_of_bags_are_for_bags(self, tmp_path):
        pianta.make_world("corridor")[1].save(tmp_path / "map.yaml")
        with pytest.raises(MapError, match="is no bag, leave out topic= and message="):
            pianta.read_map(tmp_path / "map.yaml", topic="/map")

    def test_a_bag_has_its_own_resolution(self, tmp_path):
        with pytest.raises(MapError, match="has its own resolution and origin"):
            pianta.read_map(write_grids(tmp_path, CELLS), resolution=0.05)

    def test_without_rosbags(self, tmp_path, monkeypatch):
        path = write_grids(tmp_path, CELLS)
        monkeypatch.setattr("pianta.io.bags.find_spec", lambda _: None)
        with pytest.raises(OptionError, match=r"install it with: pip install 'pianta\[ros\]'"):
            pianta.read_map(path)


def test_a_folder_without_metadata_names_the_bag_in_it(tmp_path):
    path = write_grids(tmp_path, CELLS)
    (path / "metadata.yaml").unlink()
    with pytest.raises(MapError, match=r"is a folder, give '.*\.mcap'$"):
        pianta.read(path)


def test_the_command_names_its_flag(tmp_path):
    messages = [(name, GRID_TYPE, make_grid(ROS2, CELLS)) for name in ("/a", "/b")]
    result = run_pianta("read", write_bag(tmp_path / "run", messages), "-o", tmp_path / "out")
    assert (result.code, result.out) == (2, "")
    assert result.err.endswith("has 2 topics with maps, give --topic one of /a, /b\n")


class TestLimits:
    @pytest.mark.parametrize("compression", ["lz4", "zstd", "bz2"])
    def test_a_chunk_that_unpacks_to_gigabytes_is_refused(self, monkeypatch, compression):
        from rosbags.rosbag1.reader import decompressors
        from rosbags.rosbag2 import storage_mcap

        monkeypatch.setattr(_bag_limits, "MAX_CHUNK_BYTES", 1000)
        _bag_limits.limit_unpacking()
        zstd: Any = storage_mcap.__dict__["zstd"]
        packers = {"lz4": lz4.frame.compress, "zstd": zstd.compress, "bz2": bz2.compress}
        functions: Any = {**storage_mcap.DECOMPRESSORS, "bz2": decompressors["bz2"]}
        unpack = functions[compression]
        for size in (0, 1, 1000):
            packed = packers[compression](bytes(size))
            assert unpack(packed, size) == unpack(packed) == bytes(size)
        with pytest.raises(ValueError, match=r"^a chunk unpacks to more than 1000 bytes$"):
            unpack(packers[compression](bytes(1001)), 0)
        with pytest.raises(ValueError, match=r"^a chunk is cut off$"):
            unpack(packers[compression](bytes(range(200)))[:-5], 0)

    def test_a_bag_with_such_a_chunk_is_refused(self, tmp_path, monkeypatch):
        monkeypatch.setattr(_bag_limits, "MAX_CHUNK_BYTES", 1000)
        path = tmp_path / "run.bag"
        packed = Writer1(path)
        packed.set_compression(Writer1.CompressionFormat.BZ2)
        with packed as writer:
            connection = writer.add_connection("/map", GRID_TYPE, typestore=ROS1)
            writer.write(connection, 1, ROS1.serialize_ros1(make_grid(ROS1, np.zeros((100, 100))), GRID_TYPE))
        with pytest.raises(MapError, match=r"is damaged or was cut off: .*a chunk unpacks to more than 1000 bytes"):
            pianta.read_map(path)

    def test_a_long_metadata_file_is_refused(self, tmp_path):
        path = write_bag(tmp_path / "run", [("/map", GRID_TYPE, make_grid(ROS2, CELLS))])
        with (path / "metadata.yaml").open("a") as file:
            file.write("# " + "x" * _bag_limits.MAX_METADATA_BYTES)
        with pytest.raises(MapError, match=r"metadata.yaml': it has \d+ bytes, the limit is .*\.mcap or \.db3 alone$"):
            pianta.read_map(path)


def test_maps_after_a_damaged_one_are_read(tmp_path):
    grids = [make_grid(ROS2, [[1]]), make_grid(ROS2, [[2]], resolution=0.0), make_grid(ROS2, [[3]])]
    path = write_bag(tmp_path / "run", [("/map", GRID_TYPE, grid) for grid in grids])
    first, second, third = iterate_bag(path)
    assert isinstance(first, GridMap)
    assert isinstance(second, MapError)
    assert isinstance(third, GridMap)
    assert (first.cells.tolist(), third.cells.tolist()) == ([[1]], [[3]])
    assert str(second).endswith("map 2: resolution is 0.0, give positive metres per cell")
    outcome = run_pianta("read", path, "--message", "all", "-o", tmp_path / "out")
    # The cells of the other two are all occupied
    assert (outcome.code, outcome.err.count("error: ")) == (1, 3)
