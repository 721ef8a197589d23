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
from pianta_bench.harness.comparison import Cell
from pianta_bench.places.models import CENTRAL, LOCAL
from pianta_bench.realism import measure as realism
from pianta_bench.realism import models as realism_models
from pianta_bench.realism import readings as realism_readings
from pianta_bench.realism.figures import draw_curves, draw_scores
from pianta_bench.realism.measure import (
    OFFICES,
    ONE,
    SCHOOLS,
    TWO,
    WORLDS,
    RealismBench,
    measure_realism,
    tabulate_realism,
)
from pianta_bench.realism.models import GAUSSIAN, KLOG
from pianta_bench.realism.readings import MAPPED, UNLABELLED
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
    (data / "buildings" / "robocup" / "strange.xml").write_text("<building/>")
    return data


@pytest.fixture(autouse=True, scope="module")
def maps() -> Iterator[None]:
    """Stand-ins for what is read from maps: the drawing without labels; of the first office nothing."""

    def read(floor: Floor, *, seed: int) -> Floor:
        if floor.source == "office0":
            raise MapError("the map shows no room")
        return floor

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(realism_readings, "simulate_and_reconstruct", read)
        yield


@pytest.fixture(scope="module")
def measured(tiny) -> RealismBench:
    return measure_realism(tiny, trees=5)


@pytest.mark.slow
def test_everybody_is_judged_by_all_models(measured):
    assert [len(measured.of_part(part)) for part in (OFFICES, WORLDS, SCHOOLS)] == [5, 4, 2]
    models = {LOCAL, CENTRAL, KLOG, GAUSSIAN, TWO, ONE}
    for floor in measured.of_part(OFFICES) + measured.of_part(WORLDS):
        assert {*floor.scores} == {(model, label_set) for model in models for label_set in (R_C, F_C_E_S)}
    for floor in measured.of_part(SCHOOLS):
        assert {*floor.scores} == {(ONE, R_C), (ONE, F_C_E_S)}
        assert floor.realism[R_C].probability is None
    # An office is compared with the other four, a world with all five.
    assert {len(floor.realism[R_C].usual) for floor in measured.of_part(OFFICES)} == {4}
    assert {len(floor.realism[R_C].usual) for floor in measured.of_part(WORLDS)} == {5}


def test_table_8_2(measured):
    table, one_class, _, floors = tabulate_realism(measured)
    rows = {row.name: row.cells for row in table.rows}
    assert [cell.printed_mean for cell in rows[LOCAL]] == [16.67, 8.33]
    assert [cell.printed_mean for cell in rows[KLOG]] == [0, 0]
    assert rows[TWO] == (Cell(0.0), Cell(0.0))
    assert "5 real offices and 4 simulated (thesis: 20 and 6)" in table.notes[0]
    said = {row.name: [cell.mean for cell in row.cells] for row in one_class.rows}
    assert said["worlds less like offices than the median office"] == [1, 1]
    assert said["AUC"] == [1, 1]
    assert said["worlds: called simulated"] == [1, 1]
    assert len(floors.rows) == 9
    assert floors.rows[-1].name == "world3"


def test_views(measured):
    offices, worlds = measured.of_part(OFFICES), measured.of_part(WORLDS)
    assert {*offices[0].views} == {(UNLABELLED, R_C), (UNLABELLED, F_C_E_S)}
    for floor in (*offices[1:], *worlds):
        assert {*floor.views} == {(view, each) for view in (UNLABELLED, MAPPED) for each in (R_C, F_C_E_S)}
        # The stand-in of a map is the drawing.
        assert floor.views[MAPPED, R_C] == floor.views[UNLABELLED, R_C]
    cells = {row.name: [cell.mean for cell in row.cells] for row in tabulate_realism(measured)[2].rows}
    assert cells["two classes: errors"][0] == 0
    untypical = [floor.realism[R_C].is_atypical for floor in offices]
    assert cells["offices called so"][0] == 100 * sum(untypical) / 5
    untypical = [floor.views[UNLABELLED, R_C].is_atypical for floor in worlds]
    assert cells["worlds called simulated by one class"][1] == 100 * sum(untypical) / 4


def test_errors_by_hand(measured, monkeypatch):
    """Of five offices two are above 0.9, of four worlds none: three of nine are wrong."""
    scores = sorted(floor.realism[R_C].likeness for floor in measured.of_part(OFFICES))
    floors = [
        realism.JudgedRealism(
            floor.drawn, floor.part, {(ONE, R_C): floor.realism[R_C].likeness}, floor.realism, floor.views
        )
        for floor in measured.floors
    ]
    monkeypatch.setattr(realism, "THRESHOLDS", MappingProxyType({ONE: scores[2]}))
    bench = RealismBench(0, 5, floors, measured.failed)
    assert realism.measure_error(bench, ONE, R_C) == pytest.approx(3 / 9)


def test_a_probability_of_one_half_is_realistic(measured):
    """As the verdict of pianta says; offices are right then, and worlds wrong."""
    floors = [
        replace(
            floor,
            scores={(TWO, R_C): 0.5},
            realism={each: replace(judged, probability=0.5) for each, judged in floor.realism.items()},
        )
        for floor in measured.floors
    ]
    bench = replace(measured, floors=floors)
    assert floors[0].realism[R_C].verdict.startswith("realistic")
    assert realism.measure_error(bench, TWO, R_C) == pytest.approx(4 / 9)
    cells = {row.name: [cell.mean for cell in row.cells] for row in realism.tabulate_views(bench).rows}
    assert cells["two classes: errors"][0] == pytest.approx(400 / 9)


@pytest.mark.slow
def test_nobody_is_scored_by_who_has_seen_it(tiny, monkeypatch):
    asked: list[tuple[set[str], set[str]]] = []

    def score(fold):
        asked.append(({floor.item for floor in fold.known}, {floor.item for floor in fold.asked}))
        assert [floor.item.startswith("office") for floor in fold.known] == fold.real.tolist()
        return [1.0 for _ in fold.asked]

    (tiny / "manifest.json").write_text(
        json.dumps([{"path": f"buildings/robocup/world{n}.xml", "building": "final"} for n in (0, 1)])
    )
    monkeypatch.setattr(realism_models, "SCORERS", {LOCAL: score})
    monkeypatch.setattr(realism, "SCORERS", {LOCAL: score})
    measure_realism(tiny)
    (tiny / "manifest.json").unlink()
    everybody = {f"office{n}" for n in range(5)} | {f"world{n}" for n in range(4)}
    assert all(known | out == everybody and not known & out for known, out in asked)
    assert sum({"world0", "world1"} == out for _, out in asked) == 2, "once for each label set"


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
        measure_realism(tmp_path)
    (tmp_path / "buildings" / "robocup").mkdir()
    (tmp_path / "buildings" / "robocup" / "world.xml").write_text(write_world(8, 4))
    with pytest.raises(DataError, match="offices"):
        measure_realism(tmp_path)


def test_floors_of_one_building_are_too_few(tmp_path):
    write_data(tmp_path)
    records = [{"path": f"buildings/robocup/world{n}.xml", "building": "final"} for n in range(4)]
    (tmp_path / "manifest.json").write_text(json.dumps(records))
    with pytest.raises(DataError, match="worlds"):
        measure_realism(tmp_path)


@pytest.mark.slow
def test_command(tiny, measured: RealismBench, tmp_path, monkeypatch):
    asked: list[tuple[Path, int]] = []

    def measure(data: Path, *, seed: int, track: object) -> RealismBench:
        asked.append((data, seed))
        return measured

    monkeypatch.setattr(realism, "measure_realism", measure)
    file, pictures = tmp_path / "new" / "realism.json", tmp_path / "pictures"
    arguments = "--data", tiny, "--seed", 3, "--json", file, "--pictures", pictures
    outcome = run_pianta("bench", "realism", *arguments)
    assert asked == [(tiny, 3)]
    assert (outcome.code, outcome.err) == (1, "")
    assert "Table 8.2, errors of validation" in outcome.out
    assert "strange failed (worlds), not counted: " in outcome.out
    assert {*list_files(pictures)} == {"curves.png", "scores.png"}
    content = json.loads(file.read_text())
    assert (content["bench"], content["trees"]) == ("realism", 5)
    assert "Ex-T: 5 trees on single rooms" in outcome.out
    assert len(content["floors"]) == 2 * 11
    assert {"part", "item", "label_set", "verdict", "measures"} <= {*content["floors"][0]}
    world = next(item for item in content["items"] if item["item"] == "world0")
    assert world["figures"]["pianta, one class, R/C"] == 0
