"""`pianta patterns` as a user runs it."""

import json

import pytest
from PIL import Image

from pianta.floor import Floor
from pianta.io.floors import save_floor
from tests.command_line import list_files, run_pianta
from tests.test_model_floor_plan import MEDIUM, SMALL, WIDE, make_wing


@pytest.fixture
def wing(tmp_path):
    save_floor(make_wing([SMALL, MEDIUM, WIDE] * 2), tmp_path / "wing.geojson")
    return tmp_path / "wing.geojson"


def test_a_floor(wing, tmp_path):
    code, out, err = run_pianta("patterns", wing, "-o", tmp_path / "out", "--shuffles", 0)
    assert (code, err) == (0, "")
    assert out.splitlines() == [
        "wing.geojson: 86 % of 7 rooms are in a pattern, 43 % follow from the others",
        "  A: 3 rooms (1, 2, 3) in a row, 2 times: moved (4, 5, 6)",
    ]
    assert set(list_files(tmp_path / "out")) == {"wing.json", "wing.png"}
    with Image.open(tmp_path / "out" / "wing.png") as picture:
        assert max(picture.size) >= 1600
    content = json.loads((tmp_path / "out" / "wing.json").read_text())
    assert (content["floors"], content["saved"], content["chance"]) == (["wing.geojson"], 3 / 7, None)
    (pattern,) = content["patterns"]
    assert [each["rooms"] for each in pattern["occurrences"]] == [[1, 2, 3], [4, 5, 6]]
    assert pattern["occurrences"][1]["motion"]["shift"] == [14.5, 0.0]


def test_many_occurrences_are_counted(tmp_path):
    """Nine times the same three rooms: the first, six others with their rooms, and two more."""
    save_floor(make_wing([SMALL, MEDIUM, WIDE] * 9), tmp_path / "long.geojson")
    code, out, _ = run_pianta("patterns", tmp_path / "long.geojson", "--shuffles", 0)
    assert code == 0
    assert "(19, 20, 21), and 2 more" in out


def test_chance_is_printed_beside(wing):
    code, out, _ = run_pianta("patterns", wing, "--shuffles", 3)
    assert code == 0
    assert "43 % follow from the others (shuffled " in out


def test_storeys(wing, tmp_path):
    upper = tmp_path / "upper.geojson"
    save_floor(make_wing([SMALL, MEDIUM, WIDE]), upper)
    code, out, err = run_pianta("patterns", wing, upper, "--storeys", "-o", tmp_path / "out", "--shuffles", 0)
    assert (code, err) == (0, "")
    assert (
        "  A: 3 rooms (1, 2, 3) of wing.geojson in a row, 3 times: "
        "moved on wing.geojson (4, 5, 6), moved on upper.geojson (1, 2, 3)" in out
    )
    assert set(list_files(tmp_path / "out")) == {"upper.png", "wing.json", "wing.png"}


def test_storeys_need_two_floors(wing):
    code, _, err = run_pianta("patterns", wing, "--storeys")
    assert code == 2
    assert err.startswith("error: --storeys needs two floors")


def test_a_floor_that_cannot_be_read_does_not_stop_the_others(wing, tmp_path):
    (tmp_path / "broken.geojson").write_text("{")
    code, out, err = run_pianta("patterns", wing, tmp_path / "broken.geojson", "--shuffles", 0)
    assert code == 1
    assert out.startswith("wing.geojson: ")
    assert len(err.splitlines()) == 1
    code, out, err = run_pianta("patterns", tmp_path / "broken.geojson")
    assert (code, out, len(err.splitlines())) == (2, "", 1)


def test_a_floor_without_rooms(wing, tmp_path):
    save_floor(Floor(()), tmp_path / "empty.geojson")
    code, _, err = run_pianta("patterns", tmp_path / "empty.geojson")
    assert (code, err.strip()) == (2, "error: the floor has no rooms, give one with rooms")
    code, out, err = run_pianta("patterns", wing, tmp_path / "empty.geojson", "--shuffles", 0)
    assert code == 1
    assert err.strip() == "error: empty.geojson: the floor has no rooms, give one with rooms"
    assert out.startswith("wing.geojson: ")


def test_a_link_to_itself_is_refused_in_one_line_and_does_not_stop_the_others(wing, tmp_path):
    loop = tmp_path / "loop.xml"
    loop.symlink_to(loop.name)
    code, out, err = run_pianta("patterns", loop)
    assert (code, out, len(err.splitlines())) == (2, "", 1)
    assert "cannot be opened: Too many levels of symbolic links" in err
    code, out, err = run_pianta("patterns", loop, wing, "--shuffles", 0)
    assert (code, len(err.splitlines())) == (1, 1)
    assert out.startswith("wing.geojson: 86 %")


def test_the_name_of_a_file_is_not_obeyed_by_the_terminal(wing):
    hostile = wing.rename(wing.with_name("a\x1b[31m\nb.geojson"))
    assert run_pianta("patterns", hostile, "--shuffles", 0).out.startswith(r"a\x1b[31m\nb.geojson: 86 %")
