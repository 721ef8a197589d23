"""`pianta explore` as a user runs it."""

import csv
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from pianta.exploration.steps import read_exploration
from pianta.generation.type_model import learn_type
from pianta.generation.type_model_file import save_type_model
from pianta.io.floors import read_floor, save_floor
from pianta.io.maps import read_npz_map
from pianta.io.ros_maps import save_ros_map
from pianta.labels import SCHEMAS
from tests.command_line import list_files, run_pianta
from tests.explored_worlds import two_room_world, two_rooms
from tests.typed_floors import make_office, make_school


@pytest.fixture
def floor_file(tmp_path):
    path = tmp_path / "floor.geojson"
    save_floor(two_rooms(), path)
    return path


@pytest.fixture(scope="module")
def school_file(tmp_path_factory):
    """A school of nine rooms."""
    path = tmp_path_factory.mktemp("school") / "school.geojson"
    save_floor(make_school(4, width=6), path)
    return path


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """The model of three other schools."""
    path = tmp_path_factory.mktemp("model") / "model.json"
    floors = [make_school(rooms, source=f"school {'abcdef'[rooms]}.xml") for rooms in (3, 4, 5)]
    save_type_model(learn_type([floor.graph() for floor in floors], SCHEMAS["school"]), path)
    return path


def read_table(path: Path) -> list[dict[str, str]]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.slow
def test_a_floor_is_explored_and_table_picture_and_animation_are_written(tmp_path, floor_file):
    arguments = "-o", tmp_path / "out", "--start", "2,3.5", "--steps", "3"
    code, out, err = run_pianta("explore", floor_file, *arguments)
    assert (code, err) == (0, "")
    first, second, last = out.splitlines()
    assert first.startswith("1 robot, nearest: 100.0 % of 27 m² seen in ")
    assert first.endswith(": done")
    assert second.startswith("50 % after 0 m, 90 % after ")
    assert last == f"in {tmp_path / 'out'}: area.csv, picture.png, exploration.gif, exploration.json, step-*"
    steps = {f"step-00{number}.{suffix}" for number in (1, 2, 3) for suffix in ("npz", "geojson")}
    pictures = {"area.csv", "picture.png", "exploration.gif"}
    assert list_files(tmp_path / "out").keys() == {*pictures, "exploration.json", *steps}
    rows = read_table(tmp_path / "out" / "area.csv")
    assert rows[0].keys() == {"distance_m", "area_m2", "share", "time_s"}
    assert rows[0]["distance_m"] == "0.00"
    assert float(rows[-1]["share"]) > 0.99
    with Image.open(tmp_path / "out" / "exploration.gif") as image:
        assert len(list(ImageSequence.Iterator(image))) > 1


def test_without_a_folder_nothing_is_written(tmp_path, floor_file, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = list_files(tmp_path)
    code, out, err = run_pianta("explore", floor_file.parent, "--policy", "gain")
    assert (code, err) == (0, "")
    assert out.startswith("1 robot, gain: ")
    assert list_files(tmp_path) == before


@pytest.mark.slow
def test_several_robots_have_a_column_each(tmp_path, floor_file):
    options = "--robots 2 --start 2,3.5 --start 6,1 --animation none --steps 0"
    code, out, _ = run_pianta("explore", floor_file, "-o", tmp_path / "out", *options.split())
    assert code == 0
    assert out.startswith("2 robots, nearest: ")
    assert list_files(tmp_path / "out").keys() == {"area.csv", "picture.png"}
    for row in read_table(tmp_path / "out" / "area.csv"):
        together = float(row["robot_1_m"]) + float(row["robot_2_m"])
        assert float(row["distance_m"]) == pytest.approx(together, abs=0.02)


def test_steps_have_the_map_and_the_floor_of_their_time(tmp_path, floor_file):
    options = "--start 2,3.5 --animation none --steps 3"
    code, _, err = run_pianta("explore", floor_file, "-o", tmp_path / "out", *options.split())
    assert (code, err) == (0, "")
    saved = read_exploration(tmp_path / "out" / "exploration.json")
    rows = read_table(tmp_path / "out" / "area.csv")
    assert (saved.world, saved.policy, saved.outcome) == (str(floor_file), "nearest", "done")
    assert [step.name for step in saved.steps] == ["step-001", "step-002", "step-003"]
    assert (saved.steps[0].distance, saved.steps[-1].scan) == (0, len(rows) - 1)
    free = []
    for step in saved.steps:
        # The scan is the row of the table; each robot has a pose for each of its scans until then.
        assert sum(step.pose_counts) == step.scan + 1
        assert step.distance == pytest.approx(float(rows[step.scan]["distance_m"]), abs=0.01)
        assert step.share == pytest.approx(float(rows[step.scan]["share"]), abs=0.001)
        free.append(np.count_nonzero(read_npz_map(tmp_path / "out" / f"{step.name}.npz").free))
        read_floor(tmp_path / "out" / f"{step.name}.geojson")
    assert free[0] < free[1] < free[2]
    assert [len(track) for track in saved.tracks] == saved.steps[-1].pose_counts
    # The last map is of the whole floor of three rooms, two of which are as wide as they are long.
    assert len(read_floor(tmp_path / "out" / "step-003.geojson")) >= 2


def test_other_steps_in_the_folder_are_refused(tmp_path, floor_file):
    out = tmp_path / "out"
    out.mkdir()
    (out / "step-009.npz").touch()
    code, _, err = run_pianta("explore", floor_file, "-o", out, "--animation", "none", "--steps", "3")
    assert (code, "step-009" in err) == (2, True)
    assert list_files(out).keys() == {"step-009.npz"}


def test_a_room_is_found(floor_file):
    code, out, _ = run_pianta("explore", floor_file, "--find", "stairs", "--start", "2,3.5")
    assert code == 0
    assert "found STAIRS" in out.splitlines()[0]
    assert out.splitlines()[-1] == "STAIRS is room 2"


def test_a_room_is_found_on_the_map_that_the_robots_read(tmp_path):
    code, out, err = run_pianta("explore", "corridor", "--perception", "map", "--find", "corridor")
    assert (code, err) == (0, "")
    assert out.splitlines()[0].endswith(": found CORRIDOR")
    assert re.fullmatch(r"CORRIDOR is room \d+ of the robots' map \(\d+ %\), which is right", out.splitlines()[-2])
    code, out, err = run_pianta("explore", "corridor", "--perception", "map", "--find", "kitchen")
    assert (code, err) == (0, "")
    message = r"no room is surely KITCHEN, the likeliest is room \d+ of the robots' map \([1-4]?\d %\)"
    assert re.fullmatch(message, out.splitlines()[-2])
    code, out, err = run_pianta("explore", "corridor", "--perception", "map", "--find", "bridge")
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert "BRIDGE" in err


def test_perception_without_a_search_is_for_policies_that_predict():
    code, out, err = run_pianta("explore", "corridor", "--perception", "map")
    assert (code, out) == (2, "")
    assert "policy nearest does not use --perception" in err


@pytest.mark.slow
def test_a_school_is_explored_by_the_expectations_of_a_model(school_file, model):
    arguments = "explore", school_file, "--policy", "predicted", "--start", "1,1.5"
    code, out, err = run_pianta(*arguments, "--model", model)
    assert (code, err) == (0, "")
    assert out.startswith("1 robot, predicted: 100.0 % of ")
    assert out.splitlines()[0].endswith(": done")
    without = run_pianta(*arguments)
    assert (without.code, without.err) == (0, "")
    assert without.out.startswith("1 robot, predicted: ")
    assert without.out != out


def test_the_run_ends_by_the_expectations_of_a_model(school_file, model):
    options = "--policy", "predicted", "--model", model, "--start", "1,1.5"
    code, out, _ = run_pianta("explore", school_file, *options, "--enough", "0.6")
    assert code == 0
    assert out.splitlines()[0].endswith(": stopped by the policy")


def test_a_room_is_searched_by_the_expectations_of_a_model(school_file, model):
    options = "--policy", "predicted", "--model", model, "--start", "1,1.5"
    code, out, _ = run_pianta("explore", school_file, *options, "--find", "closet")
    assert code == 0
    assert "found CLOSET" in out.splitlines()[0]
    assert out.splitlines()[-1] == "CLOSET is room 9"


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (["--model", "MODEL"], "--model"),
        (
            ["--policy", "gain", "--model", "MODEL", "--enough", "0.9"],
            "--enough",
        ),
        (["--policy", "predicted", "--enough", "0.9"], "--enough"),
        (["--policy", "predicted", "--model", "MODEL", "--enough", "1.5"], "1.5"),
        (["--policy", "predicted", "--model", "nowhere.json"], "nowhere.json"),
        (["--policy", "best", "--model", "MODEL"], "best"),
    ],
)
def test_options_of_a_model_without_meaning_are_refused_in_one_line(school_file, model, arguments, fragment):
    filled = [model if argument == "MODEL" else argument for argument in arguments]
    code, out, err = run_pianta("explore", school_file, *filled)
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert fragment in err
    assert len(err.splitlines()) == 1


def test_a_model_of_another_building_type_is_one_line(tmp_path, model):
    path = tmp_path / "office.geojson"
    save_floor(make_office(2), path)
    code, _, err = run_pianta("explore", path, "--policy", "predicted", "--model", model)
    assert code == 2
    (line,) = err.splitlines()
    assert line.startswith("error: ")
    assert all(word in line for word in (str(path), "office", "school"))


def test_a_map_without_rooms_needs_no_model(tmp_path, model):
    path = tmp_path / "map.yaml"
    save_ros_map(two_room_world().grid, path)
    code, _, err = run_pianta("explore", path, "--policy", "predicted", "--model", model)
    assert (code, len(err.splitlines())) == (2, 1)
    assert "--model" in err


def test_a_map_and_a_world_type_are_explored(tmp_path):
    save_ros_map(two_room_world().grid, tmp_path / "map.yaml")
    assert "100.0 % of 27 m²" in run_pianta("explore", tmp_path / "map.yaml").out
    code, out, _ = run_pianta("explore", "hall", "--seed", "3", "--stop", "0.3", "--drive", "differential")
    assert code == 0
    assert out.splitlines()[0].endswith(": share reached")


@pytest.mark.slow
def test_an_existing_file_has_precedence_over_a_world_type(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run_pianta("world", "hall", "-o", "ring").code == 0
    assert run_pianta("explore", "ring").out == run_pianta("explore", "hall").out


def test_a_plain_image_is_refused_with_an_existing_remedy(tmp_path):
    Image.new("L", (20, 20), 254).save(tmp_path / "map.png")
    code, out, err = run_pianta("explore", tmp_path / "map.png")
    assert (code, out) == (2, "")
    assert "map.yaml" in err


def test_labels_that_the_model_does_not_have_are_one_warning(tmp_path, model):
    rooms = [replace(room, label="SAUNA") if room.id == 2 else room for room in two_rooms().rooms]
    save_floor(replace(two_rooms(), rooms=tuple(rooms)), tmp_path / "floor.geojson")
    code, _, err = run_pianta("explore", tmp_path / "floor.geojson", "--policy", "predicted", "--model", model)
    assert (code, len(err.splitlines())) == (0, 1)
    assert "SAUNA" in err


@pytest.mark.slow
def test_the_same_command_writes_the_same_files(tmp_path, floor_file):
    for name in ("one", "two"):
        run_pianta("explore", floor_file, "-o", tmp_path / name, "--animation", "none", "--seed", "4")
    assert list_files(tmp_path / "one") == list_files(tmp_path / "two")


def test_rooms_that_cannot_be_reached_are_one_warning(tmp_path):
    save_floor(two_rooms(door=False), tmp_path / "floor.geojson")
    code, _, err = run_pianta("explore", tmp_path / "floor.geojson", "--start", "2,2")
    assert code == 0
    (line,) = err.splitlines()
    assert line.startswith("warning: ")
    assert "2 STAIRS" in line


@pytest.mark.parametrize(
    ("arguments", "fragment"),
    [
        (["--start", "4,0.5"], "4, 0.5"),
        (["--start", "here"], "--start"),
        (["--policy", "best"], "best"),
        (["--find", "gym"], "GYM"),
        (["--robots", "0"], "robots"),
        (["--reach", "-1"], "reach"),
        (["--stop", "2"], "stop"),
        (["--animation", "avi"], "avi"),
    ],
)
def test_bad_options_are_one_line_and_write_nothing(tmp_path, floor_file, arguments, fragment):
    code, out, err = run_pianta("explore", floor_file, *arguments, "-o", tmp_path / "out")
    assert (code, out) == (2, "")
    assert err.startswith("error: ")
    assert fragment in err
    assert len(err.splitlines()) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("world", "fragment"),
    [("castle", "castle"), ("", "truth.geojson")],
)
def test_an_invalid_world_is_refused_in_one_line(tmp_path, world, fragment):
    code, _, err = run_pianta("explore", world or tmp_path)
    assert code == 2
    assert fragment in err
    assert len(err.splitlines()) == 1


def test_the_help_names_all_policies():
    from pianta.cli import explore
    from pianta.exploration.policies import POLICIES, PREDICTED

    assert explore.POLICY_NAMES == POLICIES
    assert explore.PREDICTED == PREDICTED
    code, out, _ = run_pianta("explore", "--help")
    assert code == 0
    assert "pianta explore ring -o exploration" in out


def test_without_numba_one_line_explains_how_to_be_faster(floor_file, monkeypatch):
    monkeypatch.setattr("pianta.exploration.beams.has_numba", lambda: False)
    code, out, err = run_pianta("explore", floor_file)
    assert code == 0
    assert out.startswith("1 robot, nearest: ")
    (line,) = err.splitlines()
    assert "pianta[sim]" in line
    assert run_pianta("explore", floor_file, "--quiet")[1:] == ("", "")


@pytest.mark.slow
def test_what_robots_read_from_their_map_is_printed(school_file, model):
    arguments = "--policy", "predicted", "--model", model, "--perception", "map"
    code, out, err = run_pianta("explore", school_file, *arguments)
    assert (code, err) == (0, "")
    assert out.splitlines()[-1].startswith("the robots read ")
    assert " rooms, " in out.splitlines()[-1]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--perception", "eyes"), "perception is 'eyes', give perfect or map"),
        (("--perception", "map"), "policy nearest does not use --perception, give --policy predicted"),
        (
            ("--policy", "predicted", "--perception", "map"),
            "with --perception map robots compare rooms with a model, give --model",
        ),
    ],
)
def test_a_perception_that_cannot_be_used_is_refused(floor_file, arguments, message):
    assert run_pianta("explore", floor_file, *arguments) == (2, "", f"error: {message}\n")
