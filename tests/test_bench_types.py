"""`pianta bench types` as a user runs it, and its tables."""

import json
from collections.abc import Iterator, Sequence
from functools import partial

import numpy as np
import pytest
from PIL import Image
from sklearn.neural_network import MLPClassifier

from pianta import __version__
from pianta.errors import DataError, OptionError
from pianta_bench.types.figures import PICTURES
from pianta_bench.types.measure import describe_labels, measure, size_bounds
from pianta_bench.types.room_sets import RoomSet, read_room_sets
from tests.command_line import list_files, run_pianta
from tests.tiny_types import write_types


@pytest.fixture(scope="module", autouse=True)
def _rough_perceptrons() -> Iterator[None]:
    """Perceptrons that end sooner: these tests are about tables, and fitting takes most of their time."""
    rough = partial(MLPClassifier, tol=0.01)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pianta_bench.types.classifiers.MLPClassifier", rough)
        yield


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


# m: an office of 4 m by 5 m with a door, a corridor beside it of 12 m by 2 m; file and floor in metres.
MIT_FLOOR = """<?xml version="1.0"?><MITquest><floor name="FLOORCONTOUR">{}</floor></MITquest>"""


def write_mit_floor(offices: int, *, size: float) -> str:
    """MIT XML in feet: a corridor of 20 by 6 ft a room, with offices of size by 10 ft above, each with a door."""
    spaces = []
    for number in range(offices):
        left = 20 * number
        corners = [(left, 6), (left + size, 6), (left + size, 16), (left, 16)]
        to_corridor = '<portal class="horizontal" type="explicit" target="C"><edge index="0" param="0.5"/></portal>'
        spaces.append(_write_mit_space(f"O{number}", "OFF", corners, to_corridor))
    hall = [(0, 0), (20 * offices, 0), (20 * offices, 6), (0, 6)]
    spaces.append(_write_mit_space("C", "CORR", hall, ""))
    return MIT_FLOOR.format("".join(spaces))


def _write_mit_space(name: str, label: str, corners: Sequence[tuple[float, float]], portals: str) -> str:
    points = "".join(f'<point x="{700_000 + x}" y="{500_000 + y}"/>' for x, y in [*corners, corners[0]])
    return f'<space name="{name}" type="{label}"><contour>{points}</contour>{portals}</space>'


@pytest.fixture(scope="module")
def campus(tmp_path_factory):
    """Two floors of building 1, one of building 2: 5 + 5 + 6 offices and a corridor each."""
    folder = tmp_path_factory.mktemp("mit")
    for name, offices, size in (("1_0", 5, 10), ("1_1", 5, 10), ("2_0", 6, 12)):
        (folder / f"{name}.xml").write_text(write_mit_floor(offices, size=size))
    return folder


FOOT = 1200 / 3937


@pytest.fixture
def no_data(tmp_path, monkeypatch):
    monkeypatch.setenv("PIANTA_DATA", str(tmp_path / "missing"))


@pytest.mark.usefixtures("no_data")
def test_rows_of_table_4_2_of_mit_by_hand(campus):
    results = measure(mit=campus)
    figures = {(r["label"], r["metric"]): r["value"] for r in results.records if "label" in r}
    # 10 offices of 10 ft by 10 ft, 6 of 12 ft by 10 ft, and corridors of 100, 100 and 120 ft by 6 ft.
    assert figures["OFF", "rooms"] == 16
    assert figures["OFF", "share"] == 16 / 19
    assert figures["OFF", "area"] == pytest.approx((10 * 100 + 6 * 120) / 16 * FOOT**2, rel=1e-6)
    assert figures["OFF", "doorways"] == 1
    assert figures["OFF", "axes ratio"] == pytest.approx((10 + 6 * 1.2) / 16)
    assert figures["CORR", "doorways"] == pytest.approx(16 / 3)
    assert figures["CORR", "axes ratio"] == pytest.approx((100 / 6 + 100 / 6 + 20) / 3)
    campus_details = results.details["campus"]
    assert (campus_details["rooms"], campus_details["buildings"]) == (19, 2)
    assert campus_details["labels"] == {"CORR": 3, "OFF": 16}
    assert campus_details["frequent"] == ["OFF", "CORR"]
    # With the areas in m² and ε 3 all offices, 9.3 and 11.1 m², are one cluster; three corridors are too few for one.
    clusters = {r["metric"]: r["value"] for r in results.select(part="MIT", features="a (m²), d, rt")}
    assert (clusters["clusters"], clusters["outliers"], clusters["corridors_in_outliers"]) == (1, 3 / 19, 1)
    assert (clusters["homogeneity"], clusters["completeness"]) == pytest.approx((1, 1))


@pytest.mark.usefixtures("no_data")
def test_mit_without_other_data(campus, tmp_path):
    code, out, err = run_pianta("bench", "types", "--mit", campus, "--pictures", tmp_path / "pictures")
    assert (code, err) == (0, "")
    assert "Table 4.2, rooms of each label: MIT, 19 rooms" in out
    assert "Fig. 4.4e" in out
    assert set(list_files(tmp_path / "pictures")) == {"clusters_mit.png"}
    code, _, err = run_pianta("bench", "types", "--data", tmp_path / "missing", "--mit", campus)
    assert code == 2
    assert len(err.splitlines()) == 1


@pytest.mark.usefixtures("no_data")
def test_a_floor_of_mit_that_cannot_be_read_is_listed(campus, tmp_path):
    for file in campus.iterdir():
        (tmp_path / file.name).write_text(file.read_text())
    (tmp_path / "3_0.xml").write_text("<MITquest")
    results = measure(mit=tmp_path)
    assert [(item.part, item.item) for item in results.items] == [("MIT", "3_0.xml")]
    (tmp_path / "few").mkdir()
    (tmp_path / "few" / "1_0.xml").write_text(write_mit_floor(2, size=10))
    with pytest.raises(DataError, match=r"3 rooms.*at least 6"):
        measure(mit=tmp_path / "few")
    with pytest.raises(OptionError, match="no folder"):
        measure(mit=tmp_path / "nowhere")
    with pytest.raises(OptionError, match="leave --maps out"):
        measure(mit=tmp_path, maps=True)


def write_house(number: int) -> str:
    """A HouseExpo JSON: a living room, six bedrooms, six bathrooms, a hallway, and a strip that no box covers."""
    width = 4 + number / 10
    bedrooms = [[width * n, 0, width * (n + 1), 4] for n in range(6)]
    bathrooms = [[width * n, 6, width * n + 2, 8.5] for n in range(6)]
    content = {
        "id": f"house{number}",
        "room_num": 14,
        "bbox": {"min": [0, 0], "max": [width * 6, 14]},
        "verts": [[0, 0], [width * 6, 0], [width * 6, 14], [0, 14]],
        "room_category": {
            "Bedroom": bedrooms,
            "Bathroom": bathrooms,
            "Hallway": [[0, 4, width * 6, 6]],
            "Living_Room": [[0, 9, width * 6, 14]],
        },
    }
    return json.dumps(content)


def test_houses_of_house_expo(tmp_path):
    folder = tmp_path / "houses"
    folder.mkdir()
    for number in range(3):
        (folder / f"house{number}.json").write_text(write_house(number))
    (house,), failed = read_room_sets(None, houses=folder)
    assert failed == []
    # 14 labelled rooms a house; the uncovered strip has no label and is left out.
    assert (len(house.labels), set(house.buildings)) == (3 * 14, {f"house/house{number}.json" for number in range(3)})
    assert house.names == {
        ("M", "BEDROOM"): 18,
        ("S", "BATHROOM"): 18,
        ("C", "HALLWAY"): 3,
        ("B", "LIVING ROOM"): 3,
    }
    figures = describe_labels(house)
    assert figures["M", "area"] == pytest.approx(4 * 4.1)
    assert figures["S", "area"] == pytest.approx(5)
    assert figures["C", "axes ratio"] == pytest.approx((12 + 12.3 + 12.6) / 3)
    assert figures["C", "doorways"] == 0


def test_houses_with_labels_that_their_schema_does_not_have(tmp_path):
    for number in range(3):
        text = write_house(number)
        (tmp_path / f"house{number}.json").write_text(text.replace("Bedroom", "Sauna") if number == 1 else text)
    (house,), failed = read_room_sets(None, houses=tmp_path)
    assert len(set(house.buildings)) == 2
    (item,) = failed
    assert (item.part, item.item) == ("houses", "house1.json")
    assert "SAUNA" in str(item.failure)
    with pytest.raises(OptionError, match="--houses"):
        read_room_sets(None, houses=tmp_path / "nowhere")


@pytest.mark.slow
def test_houses_beside_schools(tiny, tmp_path):
    for number in range(3):
        (tmp_path / f"house{number}.json").write_text(write_house(number))
    code, out, err = run_pianta("bench", "types", "--data", tiny, "--houses", tmp_path)
    assert (code, err) == (0, "")
    assert "Table 4.2, rooms of each label: House, 42 rooms" in out
    assert "H+S+O" in out
