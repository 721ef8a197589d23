"""`pianta world` as a user runs it."""

import re
import runpy
import shlex
from dataclasses import replace

import pytest

from pianta.io.floors import read_floor
from pianta.io.maps import read_map
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta.worlds.furnish import furnish
from pianta.worlds.scan import make_sample, simulate_map
from tests.command_line import list_files, run_pianta


def test_the_sample_is_written_with_its_truth(tmp_path):
    code, out, err = run_pianta("world", "sample", "-o", tmp_path)
    assert (code, err) == (0, "")
    assert out.startswith("20 rooms, ")
    assert list_files(tmp_path).keys() == {"map.yaml", "map.png", "truth.geojson"}
    floor, grid = make_sample()
    assert read_floor(tmp_path / "truth.geojson") == floor
    written = read_map(tmp_path / "map.yaml")
    assert (written.cells == grid.cells).all()
    assert (written.resolution, written.origin) == (grid.resolution, grid.origin)


@pytest.mark.slow
@pytest.mark.parametrize("floor_type", FLOOR_MAKERS)
def test_every_type_is_made_with_defaults(tmp_path, floor_type):
    assert run_pianta("world", floor_type, "-o", tmp_path).code == 0
    assert read_floor(tmp_path / "truth.geojson") == make_floor(floor_type, seed=0)


def test_options_reach_the_world(tmp_path):
    options = "--seed 7 --glass-spray --noise 0.5 --furniture 0.3 --resolution 0.1 --yaw 0.2"
    assert run_pianta("world", "hall", "-o", tmp_path, *options.split()).code == 0
    grid = simulate_map(
        make_floor("hall", seed=7), seed=7, glass_spray=True, noise=0.5, furniture=0.3, resolution=0.1, yaw=0.2
    )
    written = read_map(tmp_path / "map.yaml")
    assert (written.cells == grid.cells).all()
    assert (written.resolution, written.origin) == (grid.resolution, grid.origin)


def test_a_labelled_floor_is_furnished_by_its_labels(tmp_path):
    options = ("--furniture", "1", "--dense-furniture", "--door-leaves", "--seed", "3")
    assert run_pianta("world", "home", "-o", tmp_path, *options).code == 0
    floor = make_floor("home", seed=3)
    truth = read_floor(tmp_path / "truth.geojson")
    assert truth == furnish(floor, furniture=1, dense_furniture=True, seed=3)
    assert replace(truth, furniture=()) == floor
    assert truth.furniture
    expected = simulate_map(floor, furniture=1, dense_furniture=True, door_leaves=True, seed=3)
    assert (read_map(tmp_path / "map.yaml").cells == expected.cells).all()


@pytest.mark.slow
def test_the_next_command_works_as_printed(tmp_path):
    _, out, _ = run_pianta("world", "corridor", "-o", tmp_path / "my world")
    program, *arguments = shlex.split(out.splitlines()[-1].removeprefix("next: "))
    assert program == "pianta"
    assert run_pianta(*arguments).code == 0
    assert "my world/read/floor.geojson" in list_files(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (["castle"], "castle"),
        (["sample", "--noise", "0.1"], "sample"),
        (["sample", "--seed", "0"], "sample"),
        (["sample", "--glass-spray"], "sample"),
        (
            ["l", "--noise", "nan", "--resolution", "0"],
            "resolution.*noise",
        ),
    ],
)
def test_an_option_without_meaning_is_one_line_and_writes_nothing(tmp_path, arguments, fragment):
    code, out, err = run_pianta("world", *arguments, "-o", tmp_path / "out")
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert re.search(fragment, err)
    assert len(err.splitlines()) == 1
    assert not list(tmp_path.iterdir())


def test_a_failure_in_the_middle_leaves_nothing(tmp_path, monkeypatch):
    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pianta.cli.world.save_floor", fail)
    code, _, err = run_pianta("world", "sample", "-o", tmp_path / "out")
    assert (code, err.count("\n")) == (2, 1)
    assert err.startswith("error: ")
    assert str(tmp_path / "out") in err
    assert "No space left" in err
    assert not list(tmp_path.iterdir())


def test_the_package_runs_as_the_command(monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["pianta", "world", "--help"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_module("pianta", run_name="__main__")
    assert ended.value.code == 0
    assert "--noise" in capsys.readouterr().out


def test_quiet_prints_nothing(tmp_path):
    assert [*run_pianta("world", "corridor", "-o", tmp_path / "world", "-q")] == [0, "", ""]
    assert (tmp_path / "world" / "map.yaml").exists()
