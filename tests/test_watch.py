"""The map of a running robot: by DDS on the loopback, and what is done with it."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from threading import Event, Thread
from time import monotonic, sleep
from typing import Any

import numpy as np
import pytest

import pianta
from pianta.errors import MapError, OptionError, PiantaError
from pianta.ros.map_watcher import MapWatcher
from tests.command_line import run_pianta

ROOT = Path(__file__).parents[1]
DEADLINE = 60.0  # seconds; discovery takes less than one


@pytest.fixture(scope="module")
def grids():
    """A third, two thirds and all of the corridor world."""
    grid = pianta.make_world("corridor")[1]
    parts = []
    for share in (0.35, 0.7, 1.0):
        cells = np.full(grid.shape, -1)
        width = int(grid.shape[1] * share)
        cells[:, :width] = grid.cells[:, :width]
        parts.append(pianta.GridMap(cells, grid.resolution, grid.origin))
    return parts


class TestMapWatcher:
    def test_it_reads_again_when_the_map_has_changed(self, grids, tmp_path):
        watcher = MapWatcher.make(tmp_path, "/map", labels=False, predict_partial=False)
        first = watcher.update(grids[0])
        assert first is not None
        assert first.folder == tmp_path
        written = (tmp_path / "floor.geojson").stat().st_mtime_ns
        equal = pianta.GridMap(grids[0].cells.copy(), grids[0].resolution, grids[0].origin)
        assert watcher.update(equal) is None
        assert (tmp_path / "floor.geojson").stat().st_mtime_ns == written
        second = watcher.update(grids[2])
        assert second is not None
        assert pianta.read_floor(tmp_path / "floor.geojson") == second.floor
        assert check_ids(first.floor, second.floor) >= 3

    def test_ids_stay_when_it_starts_again(self, grids, tmp_path):
        first = MapWatcher.make(tmp_path, "/map", labels=False, predict_partial=False).update(grids[1])
        again = MapWatcher.make(tmp_path, "/map", labels=False, predict_partial=False).update(grids[2])
        assert first is not None
        assert again is not None
        assert check_ids(first.floor, again.floor) >= 5

    def test_corrections_stay(self, grids, tmp_path):
        watcher = MapWatcher.make(tmp_path, "/map", labels=False, predict_partial=False)
        first = watcher.update(grids[0])
        assert first is not None
        room = next(room for room in first.floor if not room.partial)
        assert run_pianta("correct", tmp_path, "--name", room.id, "Archive").code == 0
        second = watcher.update(grids[1])
        assert second is not None
        assert second.floor[room.id].name == "Archive"

    def test_a_map_without_rooms_is_an_error_and_the_next_is_read(self, grids, tmp_path):
        watcher = MapWatcher.make(tmp_path, "/map", labels=False, predict_partial=False)
        with pytest.raises(PiantaError, match="map '/map': "):
            watcher.update(pianta.GridMap(np.full((50, 50), -1), 0.05))
        assert watcher.update(grids[0]) is not None


def check_ids(earlier: pianta.Floor, later: pianta.Floor) -> int:
    """How many rooms that were seen whole are in the later floor, by their ids; each must be."""
    rooms = [room for room in earlier if not room.partial]
    for room in rooms:
        other = later[room.id].polygon
        assert room.polygon.intersection(other).area > 0.9 * min(room.polygon.area, other.area)
    return len(rooms)


class TestOptions:
    @pytest.mark.parametrize(
        ("options", "fault"),
        [
            ({"topic": "/a b"}, "topic is '/a b'"),
            ({"topic": "/map'/>"}, "give a name such as /map"),
            ({"interface": "eth0'/><x a='"}, "give a name such as eth0"),
            ({"domain": 233}, "give 0 to 232"),
        ],
    )
    def test_impossible_ones(self, options, fault):
        from pianta.ros.dds_topics import iterate_topic

        with pytest.raises(OptionError, match=fault):
            iterate_topic(**{"topic": "/map", **options})

    def test_without_cyclonedds(self, monkeypatch):
        from pianta.ros import dds_topics

        monkeypatch.setattr(dds_topics, "find_spec", lambda _: None)
        with pytest.raises(OptionError, match=r"install it with: pip install 'pianta\[dds\]'"):
            dds_topics.iterate_topic("/map")


@pytest.mark.slow
class TestDds:
    @pytest.fixture(autouse=True)
    def _needs_cyclonedds(self):
        pytest.importorskip("cyclonedds")

    def test_maps_arrive_byte_for_byte(self, grids):
        from pianta.ros.dds_topics import iterate_topic
        from tests.dds_publisher import make_message, make_writer

        maps = iterate_topic("/robot/map", domain=61)
        writer = make_writer(61, "/robot/map")
        for grid in grids:
            writer.write(make_message(grid))
            arrived = next(each for each in maps if each is not None)
            assert isinstance(arrived, pianta.GridMap)
            assert arrived.cells.tobytes() == grid.cells.tobytes()
            assert (arrived.resolution, arrived.origin) == (grid.resolution, grid.origin)

    def test_a_damaged_map_does_not_end_it(self, grids):
        from pianta.ros.dds_topics import iterate_topic
        from tests.dds_publisher import make_message, make_writer

        maps = iterate_topic("/map", domain=62)
        writer = make_writer(62, "/map")
        message = make_message(grids[0])
        message.info.width += 1
        writer.write(message)
        error = next(each for each in maps if each is not None)
        assert isinstance(error, MapError)
        assert "the message is damaged" in str(error)
        writer.write(make_message(grids[0]))
        assert isinstance(next(each for each in maps if each is not None), pianta.GridMap)

    def test_nothing_is_awaited_without_end(self):
        from pianta.ros.dds_topics import iterate_topic

        assert next(iterate_topic("/map", domain=63)) is None

    def test_command_reads_what_changes(self, grids, tmp_path, monkeypatch):
        """The publisher is a thread of this process; it publishes the first map twice."""
        from pianta.ros.dds_topics import iterate_topic
        from tests.dds_publisher import make_message, make_writer

        # The thread must not be the first in the domain, whose settings are those of the command
        started, finished, subscribe = Event(), Event(), iterate_topic

        def subscribe_first(topic, **options):
            maps = subscribe(topic, **options)
            started.set()
            return until_deadline(maps)

        monkeypatch.setattr("pianta.cli.watch.iterate_topic", subscribe_first)

        def publish() -> None:
            started.wait(DEADLINE)
            writer = make_writer(64, "/map")
            writer.write(make_message(grids[0]))
            end = monotonic() + DEADLINE
            while not floor.exists() and monotonic() < end:
                sleep(0.05)
            writer.write(make_message(grids[0]))
            sleep(0.5)
            writer.write(make_message(grids[2]))
            finished.wait(DEADLINE)  # a writer that is gone takes its last map with it

        floor = tmp_path / "building" / "floor.geojson"
        thread = Thread(target=publish, daemon=True)
        thread.start()
        result = run_pianta("watch", "-o", tmp_path / "building", "--domain", 64, "--count", 2, "--no-labels")
        finished.set()
        thread.join(DEADLINE)
        assert result.code == 0
        first, second = result.out.splitlines()
        assert "rooms" in first
        assert "kept their ids" in second

    def test_a_map_that_was_published_before(self, grids, tmp_path, monkeypatch):
        """The publisher is another process; the map is latched."""
        from pianta.ros.dds_topics import iterate_topic

        monkeypatch.setattr(
            "pianta.cli.watch.iterate_topic", lambda *names, **options: until_deadline(iterate_topic(*names, **options))
        )
        grids[0].save(tmp_path / "map.npz")
        command = [sys.executable, "-m", "tests.dds_publisher", "65", "/map", str(tmp_path / "map.npz")]
        environment = {**os.environ, "PYTHONPATH": f"{ROOT / 'src'}{os.pathsep}{ROOT}"}
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, cwd=ROOT, env=environment, text=True
        ) as publisher:
            assert publisher.stdout is not None
            assert publisher.stdin is not None
            assert publisher.stdout.readline() == "published\n"
            result = run_pianta("watch", "-o", tmp_path / "building", "--domain", 65, "--count", 1, "--no-labels")
            publisher.stdin.close()
        assert result.code == 0
        assert (tmp_path / "building" / "floor.geojson").exists()


def until_deadline(maps: Iterator[Any]) -> Iterator[Any]:
    """The maps; a test that waits in vain fails."""
    end = monotonic() + DEADLINE
    for grid in maps:
        assert monotonic() < end, "no map has arrived"
        yield grid
