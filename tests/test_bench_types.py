"""`pianta bench types` as a user runs it, and what it sums up."""

import json

import numpy as np
import pytest
from PIL import Image

from pianta import __version__
from pianta_bench.types.figures import PICTURES
from pianta_bench.types.measure import bounds_of_sizes, characterise, measure_types
from pianta_bench.types.room_sets import RoomSet, read_room_sets
from tests.command_line import list_files, run_pianta
from tests.tiny_types import write_types


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    write_types(folder, "school", "office")
    return folder


@pytest.fixture(scope="module")
def measured(tiny, tmp_path_factory):
    """The folder of what is saved, and what the command says."""
    folder = tmp_path_factory.mktemp("measured")
    outputs = "--json", folder / "new" / "types.json", "--pictures", folder / "pictures"
    return folder, run_pianta("bench", "types", "--data", tiny, "--seed", 3, *outputs)


def test_characteristics_by_hand():
    geometry = np.array([[10.0, 1, 2], [20, 3, 4], [30, 1, 1], [50, 1, 1]])
    rooms = RoomSet("School", geometry, np.zeros((4, 5)), np.array([*"CCSH"]), np.array([""] * 4), {})
    corridor, hall, small, medium, _ = characterise(rooms)
    assert (corridor.rooms, corridor.share, corridor.means) == (2, 0.5, (15, 2, 3))
    assert corridor.sds == pytest.approx((50**0.5, 2**0.5, 2**0.5))
    assert (hall.means, hall.sds) == ((50, 1, 1), (None, None, None))
    assert (small.share, medium.rooms, medium.means) == (0.25, 0, (None, None, None))


def test_bounds_of_sizes_are_halfway_between_the_printed_areas():
    assert bounds_of_sizes("Office") == pytest.approx(((4.5 + 18.5) / 2, (18.5 + 31.3) / 2))


@pytest.mark.slow
def test_json_holds_what_is_printed(measured):
    folder, (code, out, err) = measured
    file, pictures = folder / "new" / "types.json", folder / "pictures"
    assert (code, err) == (0, "")
    content = json.loads(file.read_text())
    assert (content["pianta"], content["bench"], content["seed"]) == (__version__, "types", 3)
    assert [(each["name"], each["rooms"], each["buildings"]) for each in content["sets"]] == [
        ("School", 28, 2),
        ("Office", 28, 2),
        ("S+O", 56, 4),
    ]
    assert content["sets"][0]["mapping"]["M"] == {"CLASSROOM": 12}
    rows = [line.split() for line in out.splitlines()]
    for each in content["classifiers"]:
        means = [f"{100 * np.mean(folds):.1f}" for folds in each["accuracies"].values()]
        numbers = [*means, f"{100 * each['mean']:.1f}", f"{100 * each['sd_of_algorithms']:.1f}"]
        assert [each["set"], *each["features"].split(), each["folds_of"], *numbers] in [
            row[: 3 + len(each["features"].split()) + 5] for row in rows
        ]
    assert [(each["train"], each["test"], each["sizes"]) for each in content["transfers"]] == [
        *[("School", "Office", "by name")] * 2,
        *[("Office", "School", "by name")] * 2,
        ("School", "Office", "by area"),
        ("Office", "School", "by area"),
    ]
    for each in content["clusters"]:
        start = [each["set"], *each["features"].split(), str(each["clusters"]), f"{100 * each['outliers']:.1f}"]
        assert start in [row[: len(start)] for row in rows]
    assert list_files(pictures).keys() == PICTURES.keys()
    for name in PICTURES:
        with Image.open(pictures / name) as image:
            assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 5


@pytest.mark.slow
def test_one_type_has_no_union_and_no_transfer(tmp_path):
    write_types(tmp_path, "office")
    code, out, err = run_pianta("bench", "types", "--data", tmp_path)
    assert (code, err) == (0, "")
    assert "learnt on a type" not in out
    assert "S+O" not in out


@pytest.mark.slow
def test_houses_stand_beside_what_the_thesis_prints_of_them(tmp_path):
    write_types(tmp_path / "data", "house", "school")
    code, out, err = run_pianta("bench", "types", "--data", tmp_path / "data", "--pictures", tmp_path / "pictures")
    assert (code, err) == (0, "")
    rows = [line.split() for line in out.splitlines()]
    ends = {(row[0], row[-1]) for row in rows if row}
    assert {("House", "87.8±4.9"), ("School", "88.3±4.8")} <= ends
    assert {row[-1] for row in rows if row[:2] == ["House,", "School"] and "neighbours" in row} == {"40.0"}
    assert {row[-1] for row in rows if row[:2] == ["School,", "House"] and "neighbours" in row} == {"52.7"}
    assert any(row[0] == "C" and "(23.9)" in row for row in rows if row)
    assert max(map(len, out.splitlines())) <= 80


def test_a_floor_that_fails_is_told_and_the_others_are_measured(tmp_path):
    write_types(tmp_path, "office", buildings=3)
    (tmp_path / "buildings" / "office" / "office1.xml").write_text("<building")
    outputs = "--json", tmp_path / "types.json", "--pictures", tmp_path / "pictures"
    code, out, err = run_pianta("bench", "types", "--data", tmp_path, *outputs)
    assert (code, err) == (1, "")
    assert {*list_files(tmp_path / "pictures")} <= {*PICTURES}
    assert "office1 failed (offices), not counted: " in " ".join(out.split())
    content = json.loads((tmp_path / "types.json").read_text())
    assert [(each["type"], each["item"]) for each in content["failures"]] == [("office", "office1")]
    assert "is no XML" in content["failures"][0]["failure"]
    assert content["sets"][0]["buildings"] == 2
    assert content["seed"] == 0


@pytest.mark.slow
def test_a_seed_gives_the_same_twice(tiny, measured, tmp_path):
    assert run_pianta("bench", "types", "--data", tiny, "--seed", 3, "--json", tmp_path / "again.json").code == 0
    first = (measured[0] / "new" / "types.json").read_text()
    assert first == (tmp_path / "again.json").read_text()
    assert json.loads(first)["seed"] == 3


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["--data", "none"], "'none'"),
        (["--data", "."], "buildings"),
        (["--json", "folder"], "folder"),
        (["--pictures", "file"], "'file'"),
    ],
)
def test_an_option_without_meaning_is_one_line(tiny, tmp_path, monkeypatch, options, told):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    monkeypatch.chdir(tmp_path)
    code, out, err = run_pianta("bench", "types", *([] if "--data" in options else ["--data", tiny]), *options)
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert told in line


@pytest.mark.slow
def test_real_schools_and_offices(data):
    """Rooms and labels that the data hold; the expected shares were counted from the files' label elements."""
    (school, office, union), failed = read_room_sets(data)
    assert failed == {"school": (), "office": ()}
    assert (len(school.labels), len(office.labels), len(union.labels)) == (1175, 535, 1710)
    assert (len({*school.buildings}), len({*office.buildings})) == (24, 11)
    assert school.names["M", "CLASSROOM"] == 278
    assert office.names["M", "OFFICE"] == 147
    assert (school.labels == "C").sum() == 156
    # Doors behind which rooms are, and doors, are the same where there are no entrances.
    assert (union.neighbours.sum(axis=1) == union.geometry[:, 1]).all()


@pytest.mark.slow
def test_every_classification_is_tracked(tmp_path):
    write_types(tmp_path, "office")
    names: list[str] = []

    def track(items):
        names.extend(items)
        return iter(items)

    measure_types(tmp_path, track=track)
    # Two features, two divisions, and once by area.
    assert len(names) == 2 * 2 + 1
