"""`pianta bench types` as a user runs it, and its tables."""

import json

import numpy as np
import pytest
from PIL import Image

from pianta import __version__
from pianta_bench.types.figures import PICTURES
from pianta_bench.types.measure import describe_labels, measure, size_bounds
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
    """The folder of the saved files, and the output of the command."""
    folder = tmp_path_factory.mktemp("measured")
    outputs = "--json", folder / "new" / "types.json", "--pictures", folder / "pictures"
    return folder, run_pianta("bench", "types", "--data", tiny, "--seed", 3, *outputs)


def test_characteristics_by_hand():
    geometry = np.array([[10.0, 1, 2], [20, 3, 4], [30, 1, 1], [50, 1, 1]])
    rooms = RoomSet("School", geometry, np.zeros((4, 5)), np.array([*"CCSH"]), np.array([""] * 4), {})
    figures = describe_labels(rooms)

    def pick(label: str, *metrics: str) -> tuple[float | None, ...]:
        return tuple(figures[label, metric] for metric in metrics)

    geometry_names = "area", "doorways", "axes ratio"
    assert pick("C", "rooms", "share", *geometry_names) == (2, 0.5, 15, 2, 3)
    assert pick("C", "area sd", "doorways sd", "axes ratio sd") == pytest.approx((50**0.5, 2**0.5, 2**0.5))
    assert pick("H", *geometry_names) == (50, 1, 1)
    assert pick("H", "area sd", "doorways sd", "axes ratio sd") == (None, None, None)
    assert pick("S", "share") == (0.25,)
    assert pick("M", "rooms", *geometry_names) == (0, None, None, None)


def test_size_bounds_are_halfway_between_the_published_areas():
    assert size_bounds("Office") == pytest.approx(((4.5 + 18.5) / 2, (18.5 + 31.3) / 2))


@pytest.mark.slow
def test_the_file_holds_what_is_printed(measured):
    folder, (code, out, err) = measured
    file, pictures = folder / "new" / "types.json", folder / "pictures"
    assert (code, err) == (0, "")
    content = json.loads(file.read_text())
    assert (content["pianta"], content["bench"], content["options"]) == (__version__, "types", {"seed": 3})
    assert [(each["name"], each["rooms"], each["buildings"]) for each in content["sets"]] == [
        ("School", 28, 2),
        ("Office", 28, 2),
        ("S+O", 56, 4),
    ]
    assert content["sets"][0]["mapping"]["M"] == {"CLASSROOM": 12}
    rows = [" ".join(line.replace(" ± ", "±").split()) for line in out.splitlines()]
    accuracies: dict[tuple[str, ...], dict[str, list[float]]] = {}
    for record in content["records"]:
        if record["metric"] == "accuracy":
            key = record["part"], record["features"], record["folds_of"], record["sizes"]
            accuracies.setdefault(key, {}).setdefault(record["algorithm"], []).append(record["value"])
    # Three sets, by two representations and two divisions by name, and once by area.
    assert len(accuracies) == 3 * (2 * 2 + 1)
    for (part, features, divided, _), folds in accuracies.items():
        cells = [f"{100 * np.mean(each):.1f}±{100 * np.std(each, ddof=1):.1f}" for each in folds.values()]
        mean = np.mean([np.mean(each) for each in folds.values()])
        printed = [row for row in rows if row.startswith(f"{part}, {features}, {divided} ")]
        assert all(any(cell in row.split() for row in printed) for cell in [*cells, f"{100 * mean:.1f}"]), printed
    transfers = [record for record in content["records"] if record["metric"] == "transfer"]
    assert [*dict.fromkeys((record["part"], record["features"], record["sizes"]) for record in transfers)] == [
        ("School, Office", "a, d, rt", "by name"),
        ("School, Office", "with neighbours", "by name"),
        ("Office, School", "a, d, rt", "by name"),
        ("Office, School", "with neighbours", "by name"),
        ("School, Office", "with neighbours", "by area"),
        ("Office, School", "with neighbours", "by area"),
    ]
    figures = {(r["part"], r.get("features"), r["metric"]): r["value"] for r in content["records"]}
    for part, features, _ in [key for key in figures if key[2] == "bend"]:
        clusters, outliers = figures[part, features, "clusters"], figures[part, features, "outliers"]
        start = f"{part}, {features} {clusters} {100 * outliers:.1f} "
        assert any(line.startswith(start) for line in rows), start
    assert list_files(pictures).keys() == PICTURES.keys()
    for name in PICTURES:
        with Image.open(pictures / name) as image:
            assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 5


@pytest.mark.slow
def test_one_type_has_no_union_and_no_transfer(tmp_path):
    write_types(tmp_path, "office")
    code, out, err = run_pianta("bench", "types", "--data", tmp_path)
    assert (code, err) == (0, "")
    assert "Table 4.4" not in out
    assert "S+O" not in out


@pytest.mark.slow
def test_published_figures_are_beside_the_measured_ones(tmp_path):
    write_types(tmp_path / "data", "house", "school")
    code, out, err = run_pianta("bench", "types", "--data", tmp_path / "data", "--pictures", tmp_path / "pictures")
    assert (code, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    rows = [line.replace(" ± ", "±").split() for line in out.splitlines()]
    assert any("87.8±4.9" in row for row in rows if row[:1] == ["House,"])
    assert any("88.3±4.8" in row for row in rows if row[:1] == ["School,"])
    assert any("40.0" in row for row in rows if row[:4] == ["House,", "School,", "with", "neighbours"])
    assert any("52.7" in row for row in rows if row[:4] == ["School,", "House,", "with", "neighbours"])
    assert any(row[0] == "C" and "23.9" in row for row in rows if row)


def test_a_floor_that_fails_is_named_and_the_others_are_measured(tmp_path):
    write_types(tmp_path, "office", buildings=3)
    (tmp_path / "buildings" / "office" / "office1.xml").write_text("<building")
    outputs = "--json", tmp_path / "types.json", "--pictures", tmp_path / "pictures"
    code, out, err = run_pianta("bench", "types", "--data", tmp_path, *outputs)
    assert (code, err) == (1, "")
    assert {*list_files(tmp_path / "pictures")} <= {*PICTURES}
    assert "office1 failed (offices): " in " ".join(out.split())
    content = json.loads((tmp_path / "types.json").read_text())
    assert [(each["part"], each["item"]) for each in content["items"]] == [("offices", "office1")]
    assert "is no XML" in content["items"][0]["failure"]
    assert content["sets"][0]["buildings"] == 2
    assert content["options"]["seed"] == 0


@pytest.mark.slow
def test_a_seed_gives_the_same_twice(tiny, measured, tmp_path):
    assert run_pianta("bench", "types", "--data", tiny, "--seed", 3, "--json", tmp_path / "again.json").code == 0
    first = (measured[0] / "new" / "types.json").read_text()
    assert first == (tmp_path / "again.json").read_text()
    assert json.loads(first)["options"]["seed"] == 3


@pytest.mark.parametrize(
    ("options", "name"),
    [
        (["--data", "none"], "'none'"),
        (["--data", "."], "buildings"),
        (["--json", "folder"], "folder"),
        (["--pictures", "file"], "'file'"),
    ],
)
def test_an_option_without_meaning_is_one_line(tiny, tmp_path, monkeypatch, options, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").touch()
    monkeypatch.chdir(tmp_path)
    code, out, err = run_pianta("bench", "types", *([] if "--data" in options else ["--data", tiny]), *options)
    assert (code, out) == (2, "")
    (line,) = err.splitlines()
    assert name in line


@pytest.mark.slow
def test_real_schools_and_offices(data):
    """Rooms and labels that the data hold; the expected shares were counted from the files' label elements."""
    (school, office, union), failed = read_room_sets(data)
    assert failed == []
    assert (len(school.labels), len(office.labels), len(union.labels)) == (1175, 535, 1710)
    assert (len({*school.buildings}), len({*office.buildings})) == (24, 11)
    assert school.names["M", "CLASSROOM"] == 278
    assert office.names["M", "OFFICE"] == 147
    assert (school.labels == "C").sum() == 156
    # Without entrances every door leads to a room.
    assert (union.neighbours.sum(axis=1) == union.geometry[:, 1]).all()


@pytest.mark.slow
def test_every_classification_is_tracked(tmp_path):
    write_types(tmp_path, "office")
    names: list[str] = []

    def track(items):
        names.extend(items)
        return iter(items)

    measure(tmp_path, track=track)
    # Two features, two divisions, and once by area.
    assert len(names) == 2 * 2 + 1
