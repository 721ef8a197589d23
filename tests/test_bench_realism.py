"""`pianta bench realism`: on tiny offices, and tiny worlds whose rooms lie one behind the other."""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

import pytest

from pianta.errors import DataError, MapError
from pianta.floor import Floor
from pianta.labels import LabelSet
from pianta_bench.harness.error_rates import ALL_FLOORS, CLASS_MEAN, STATISTICS
from pianta_bench.harness.records import Results, select_records
from pianta_bench.harness.tables import Cell
from pianta_bench.places.models import CENTRAL, LOCAL
from pianta_bench.realism import measure as realism
from pianta_bench.realism import models as realism_models
from pianta_bench.realism import views as realism_views
from pianta_bench.realism.figures import draw_curves, draw_scores
from pianta_bench.realism.measure import OFFICES, ONE, SCHOOLS, TWO, WORLDS, AssessedFloor, measure
from pianta_bench.realism.models import GAUSSIAN, KLOG
from pianta_bench.realism.tables import derive_errors, derive_views, tabulate
from pianta_bench.realism.views import MAPPED, UNLABELLED
from tests.command_line import list_files, run_pianta
from tests.tiny_types import write_types

R_C, F_C_E_S = LabelSet.R_C, LabelSet.F_C_E_S
OFFICES_WRITTEN, WORLDS_WRITTEN = 5, 4


def write_world(rooms: int, side: float) -> str:
    """Layout XML of square offices in a row, each with a door to the next, and a corridor at the end."""
    spaces = ""
    for number in range(rooms):
        left = number * side
        corners = (left, 0), (left + side, 0), (left + side, side + number % 3), (left, side + number % 3)
        outline = "".join(f'<point x="{10 * x:.0f}" y="{10 * y:.0f}"/>' for x, y in corners)
        beside = [other for other in (number - 1, number + 1) if 0 <= other < rooms]
        portals = "".join(
            f"<portal><target><id>{number}</id><id>{other}</id></target><type>EXPLICIT</type></portal>"
            for other in beside
        )
        label = "CORRIDOR" if number == rooms - 1 else "OFFICE"
        spaces += (
            f'<space id="{number}"><labels><label>{label}</label></labels>'
            f"<bounding_polygon>{outline}</bounding_polygon><portals>{portals}</portals></space>"
        )
    return (
        "<building><scale><represented_distance><value>9</value><um>pixel</um></represented_distance>"
        "<real_distance><value>90</value><um>cm</um></real_distance></scale>"
        f"<floor><spaces>{spaces}</spaces></floor></building>"
    )


def write_data(data: Path) -> Path:
    write_types(data, "office", buildings=OFFICES_WRITTEN)
    folder = data / "buildings" / "robocup"
    folder.mkdir()
    for number in range(WORLDS_WRITTEN):
        (folder / f"world{number}.xml").write_text(write_world(8 + number, 4 + number / 2))
    return data


@pytest.fixture(scope="module")
def tiny(tmp_path_factory) -> Path:
    data = write_data(tmp_path_factory.mktemp("data"))
    write_types(data, "school", buildings=2)
    (data / "buildings" / "robocup" / "broken.xml").write_text("<building/>")
    return data


@pytest.fixture(autouse=True, scope="module")
def maps() -> Iterator[None]:
    """Stand-ins for reading a map: the drawing without labels; the first office cannot be read."""

    def read(floor: Floor, *, seed: int) -> Floor:
        if floor.source == "office0":
            raise MapError("the map shows no room")
        return floor

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(realism_views, "simulate_and_reconstruct", read)
        yield


@pytest.fixture(scope="module")
def measured(tiny) -> Results:
    return measure(tiny, trees=5)


def floors_of(results: Results, part: str) -> list[AssessedFloor]:
    return [floor for floor in results.objects["floors"] if floor.part == part]


@pytest.mark.slow
def test_every_floor_is_scored_by_all_models(measured):
    assert [len(floors_of(measured, part)) for part in (OFFICES, WORLDS, SCHOOLS)] == [5, 4, 2]
    models = {LOCAL, CENTRAL, KLOG, GAUSSIAN, TWO, ONE}
    for floor in floors_of(measured, OFFICES) + floors_of(measured, WORLDS):
        assert {*floor.scores} == {(model, label_set) for model in models for label_set in (R_C, F_C_E_S)}
    for floor in floors_of(measured, SCHOOLS):
        assert {*floor.scores} == {(ONE, R_C), (ONE, F_C_E_S)}
        assert floor.realism[R_C].probability is None
    # An office is compared with the other four, a world with all five.
    assert {len(floor.realism[R_C].usual) for floor in floors_of(measured, OFFICES)} == {4}
    assert {len(floor.realism[R_C].usual) for floor in floors_of(measured, WORLDS)} == {5}


@pytest.mark.slow
def test_table_8_2(measured):
    table, one_class, _, floors = tabulate(measured)
    assert [*table.columns] == [f"{labels}, {name}" for labels in ("R/C", "F/C/E/S") for name in STATISTICS]
    # 2 and 1 of 6 worlds as means over classes; no number of 26 floors is a share of 16.67 or 8.33 %.
    assert [table.rows[LOCAL][column].published_mean for column in table.columns] == [None, 16.67, None, 8.33]
    assert [table.rows[KLOG][column].published_mean for column in table.columns] == [0, 0, 0, 0]
    assert [*table.rows[TWO].values()] == [Cell(0.0, digits=2)] * 4
    assert "5 real offices and 4 simulated (thesis: 20 and 6)" in table.notes[0]
    means = {name: [cell.mean for cell in cells.values()] for name, cells in one_class.rows.items()}
    assert means["worlds less like offices than the median office"] == [1, 1]
    assert means["AUC"] == [1, 1]
    assert means["worlds: called simulated"] == [1, 1]
    assert len(floors.rows) == 9
    assert [*floors.rows][-1] == "world3"


@pytest.mark.slow
def test_views(measured):
    offices, worlds = floors_of(measured, OFFICES), floors_of(measured, WORLDS)
    assert {*offices[0].views} == {(UNLABELLED, R_C), (UNLABELLED, F_C_E_S)}
    for floor in (*offices[1:], *worlds):
        assert {*floor.views} == {(view, each) for view in (UNLABELLED, MAPPED) for each in (R_C, F_C_E_S)}
        # The stand-in for a map is the drawing.
        assert floor.views[MAPPED, R_C] == floor.views[UNLABELLED, R_C]
    errors = {
        (each["metric"], each["view"], each["label_set"]): each["value"] for each in derive_views([*offices, *worlds])
    }
    assert errors["two classes: errors", "drawn", "R/C"] == 0
    atypical = [floor.realism[R_C].is_atypical for floor in offices]
    assert errors["offices called simulated by one class", "drawn", "R/C"] == 100 * sum(atypical) / 5
    atypical = [floor.views[UNLABELLED, R_C].is_atypical for floor in worlds]
    assert errors["worlds called simulated by one class", UNLABELLED, "R/C"] == 100 * sum(atypical) / 4


def error_of(results: Results, model: str, statistic: str = ALL_FLOORS) -> float:
    fields = {"model": model, "label_set": "R/C", "statistic": statistic}
    (error,) = [each["value"] for each in select_records(derive_errors(results), fields)]
    return float(error)


@pytest.mark.slow
def test_errors_by_hand(measured, monkeypatch):
    """Two of five offices and no world are above the third score: three of nine floors are wrong."""
    scores = sorted(measured.values(metric="likeness", label_set=R_C, part=OFFICES))
    likeness = measured.select(metric="likeness", part=[OFFICES, WORLDS])
    results = Results()
    results.records += [{**record, "metric": "score", "model": ONE} for record in likeness]
    monkeypatch.setattr(realism, "THRESHOLDS", MappingProxyType({ONE: scores[2]}))
    assert error_of(results, ONE) == pytest.approx(100 * 3 / 9)
    # Three of five offices, none of four worlds.
    assert error_of(results, ONE, CLASS_MEAN) == pytest.approx(100 * (3 / 5 + 0 / 4) / 2)


@pytest.mark.slow
def test_a_probability_of_one_half_is_realistic(measured):
    """As in the verdict of pianta: with 0.5 everywhere offices are right and worlds wrong."""
    floors = [
        replace(floor, realism={each: replace(one, probability=0.5) for each, one in floor.realism.items()})
        for floor in measured.objects["floors"]
    ]
    assert floors[0].realism[R_C].verdict.startswith("realistic")
    halves = [{**each, "value": 0.5} for each in measured.select(metric="score", model=TWO)]
    results = Results()
    results.records += halves
    assert error_of(results, TWO) == pytest.approx(100 * 4 / 9)
    assert error_of(results, TWO, CLASS_MEAN) == 50
    (error,) = [
        each["value"]
        for each in derive_views(floors)
        if (each["metric"], each["label_set"], each["view"]) == ("two classes: errors", "R/C", "drawn")
    ]
    assert error == pytest.approx(400 / 9)


@pytest.mark.slow
def test_no_floor_is_scored_by_a_model_of_its_building(tiny, monkeypatch):
    folds: list[tuple[set[str], set[str]]] = []

    def score(fold):
        folds.append(({floor.item for floor in fold.training}, {floor.item for floor in fold.tested}))
        assert [floor.item.startswith("office") for floor in fold.training] == fold.real.tolist()
        return [1.0 for _ in fold.tested]

    (tiny / "manifest.json").write_text(
        json.dumps([{"path": f"buildings/robocup/world{n}.xml", "building": "final"} for n in (0, 1)])
    )
    monkeypatch.setattr(realism_models, "SCORERS", {LOCAL: score})
    monkeypatch.setattr(realism, "SCORERS", {LOCAL: score})
    measure(tiny)
    (tiny / "manifest.json").unlink()
    names = {f"office{n}" for n in range(5)} | {f"world{n}" for n in range(4)}
    assert all(training | tested == names and not training & tested for training, tested in folds)
    assert sum({"world0", "world1"} == tested for _, tested in folds) == 2, "once for each label set"


@pytest.mark.slow
def test_pictures(measured):
    scores, curves = draw_scores(measured), draw_curves(measured)
    assert [len(ax.collections) for ax in scores.axes] == [3, 3, 2, 2]
    assert {len(ax.lines) for ax in curves.axes} == {5}
    legend = curves.axes[0].get_legend()
    assert legend is not None
    assert "pianta, two classes, area 1.000" in [text.get_text() for text in legend.get_texts()]


def test_too_few_floors(tmp_path):
    write_types(tmp_path, "office")
    with pytest.raises(DataError, match="robocup"):
        measure(tmp_path)
    (tmp_path / "buildings" / "robocup").mkdir()
    (tmp_path / "buildings" / "robocup" / "world.xml").write_text(write_world(8, 4))
    with pytest.raises(DataError, match="offices"):
        measure(tmp_path)


def test_floors_of_one_building_are_too_few(tmp_path):
    write_data(tmp_path)
    records = [{"path": f"buildings/robocup/world{n}.xml", "building": "final"} for n in range(4)]
    (tmp_path / "manifest.json").write_text(json.dumps(records))
    with pytest.raises(DataError, match="worlds"):
        measure(tmp_path)


@pytest.mark.slow
def test_command(tiny, measured: Results, tmp_path, monkeypatch):
    calls: list[tuple[Path, int]] = []

    def measure_again(data: Path, *, seed: int, track: object) -> Results:
        calls.append((data, seed))
        return measured

    monkeypatch.setattr(realism, "measure", measure_again)
    file, pictures = tmp_path / "new" / "realism.json", tmp_path / "pictures"
    arguments = "--data", tiny, "--seed", 3, "--json", file, "--pictures", pictures
    outcome = run_pianta("bench", "realism", *arguments)
    assert calls == [(tiny, 3)]
    assert (outcome.code, outcome.err) == (1, "")
    assert "Table 8.2, errors of validation" in outcome.out
    assert "broken failed (worlds): " in outcome.out
    assert {*list_files(pictures)} == {"curves.png", "scores.png"}
    content = json.loads(file.read_text())
    assert (content["bench"], content["options"]["trees"]) == ("realism", 5)
    assert "Ex-T: 5 trees on single rooms" in outcome.out
    assert len(content["floors"]) == 2 * 11
    assert {"part", "item", "label_set", "verdict", "measures"} <= {*content["floors"][0]}
    (score,) = [
        record["value"]
        for record in content["records"]
        if (record["item"], record.get("model"), record["label_set"]) == ("world0", "pianta, one class", "R/C")
    ]
    assert score == 0
