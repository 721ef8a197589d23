"""`pianta bench prediction` on tiny schools and offices, and scores of predictions that are made by hand."""

import json
from collections.abc import Mapping
from io import StringIO
from pathlib import Path
from statistics import fmean

import networkx as nx
import numpy as np
import pytest
from rich.console import Console

from pianta.errors import DataError
from pianta.generation.type_model import TypeModel
from pianta.labels import SCHOOL, LabelSet
from pianta.prediction.explored_part import hide_rooms, read_explored_part
from pianta.prediction.prediction import Prediction
from pianta.prediction.unexplored_part import SampledFloor
from pianta_bench.harness.comparison import ComparisonTable, show_comparisons
from pianta_bench.prediction.figures import choose_floors, save_prediction_pictures
from pianta_bench.prediction.file import save_prediction
from pianta_bench.prediction.measure import PredictionBench, TypeOfFloors, list_others, measure_prediction, read_floors
from pianta_bench.prediction.rivals import BLIND, KNOWN, LOCAL, Rivals
from pianta_bench.prediction.scores import (
    MEAN,
    ORACLE,
    PREDICTED,
    SAMPLE,
    TYPICAL,
    DoorGuess,
    JudgedFloor,
    JudgedStage,
    judge_stage,
    merge_labels,
)
from pianta_bench.prediction.tables import (
    ALL,
    HALF,
    measure_gain,
    summarise,
    tabulate_bars,
    tabulate_doors,
    tabulate_labels,
    tabulate_prediction,
    tabulate_reliability,
    tabulate_time,
    wrap_names,
)
from tests.command_line import list_files, run_pianta
from tests.generated_types import WINGS, join_wings, small_model
from tests.tiny_data import write_school, write_schools

pytestmark = pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")

FLOORS = {"ash": "KKKW-KKC-LLW", "elm": "KKKC-KKW", "fir": "LLW-KKKK-KKS-KK", "oak": "KKKW-LLS-KKC"}


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four schools, one of two floors and one in two parts, and as many offices."""
    data = tmp_path_factory.mktemp("data")
    for kind, label in (("school", "CLASSROOM"), ("office", "OFFICE")):
        folder = data / "buildings" / kind
        folder.mkdir(parents=True)
        for name, wings in FLOORS.items():
            text = write_school(wings.split("-"))
            for school_label in ("CLASSROOM", "LAB", "LIBRARY"):
                text = text.replace(school_label, label) if kind == "office" else text
            (folder / f"{name}.xml").write_text(text)
    write = data / "buildings" / "school"
    (write / "elm2.xml").write_text(write_school(["KKK", "KKW"]))
    (write / "strange.xml").write_text("<building/>")
    return data


@pytest.fixture(scope="module")
def measured(tiny) -> PredictionBench:
    return measure_prediction(tiny, count=8)


def make_prediction(name: str, explored: set[int], discovered: set[int], *samples: nx.Graph) -> Prediction:
    """A prediction whose samples begin with the rooms of the explored part, in order, those behind doors next."""
    graph = join_wings(*WINGS[name], source=name)
    part = read_explored_part(hide_rooms(graph, explored, discovered), SCHOOL)
    known = {node: node for node in part.known_graph}
    return Prediction(
        part, tuple(SampledFloor(sample, known, {door: door for door in part.doors}) for sample in samples), SCHOOL, {}
    )


def judge(prediction: Prediction, name: str) -> JudgedStage:
    return judge_stage(join_wings(*WINGS[name], source=name), prediction, Rivals(small_model()), corridors=1)


# School a: corridor 0 with four classrooms and a bathroom, corridor 6 with two offices and a closet.
TRUE = join_wings(*WINGS["a"], source="a")
EXPLORED = {0, 1, 2, 3, 4, 5}


def test_a_perfect_prediction():
    stage = judge(make_prediction("a", EXPLORED, {6}, TRUE, TRUE), "a")
    figures = stage.figures
    assert (stage.known, stage.unseen, stage.interval, stage.guesses) == (7, 3, True, [])
    for who in (PREDICTED, MEAN, SAMPLE):
        assert figures[f"labels, {who}"] == pytest.approx(0, abs=1e-5)
    for measure in ("WL", "NSPDK", "edits", "rooms", "corridors"):
        assert figures[f"{measure}, {PREDICTED}"] == 0
    assert figures[f"edits, {TYPICAL}"] == 0
    assert (figures[f"labels, {ORACLE}"] or 0) > 0
    # The unseen are of other labels than the known: 1 bit but for what the closet is not.
    assert figures[f"labels, {KNOWN}"] == 1
    assert 0 < (figures[f"labels, {BLIND}"] or 0) < 1


def test_a_wrong_prediction():
    """A sample with a gym at corridor 6 for all rooms there, and a corridor more."""
    wrong = TRUE.subgraph(range(7)).copy()
    wrong.add_nodes_from([(7, {"label": "GYM"}), (8, {"label": "CORRIDOR"})])
    wrong.add_edges_from([(6, 7), (6, 8)])
    stage = judge(make_prediction("a", EXPLORED, {6}, wrong), "a")
    figures = stage.figures
    assert not stage.interval
    assert figures[f"labels, {PREDICTED}"] == pytest.approx(1, abs=1e-6)
    # Both are all SERVICE and ENTRANCE … or not: the gym is FUNCTIONAL, the corridor CONNECTION.
    assert figures[f"F/C/E/S, {PREDICTED}"] == pytest.approx(1, abs=1e-6)
    # All unseen rooms are ROOM, half of the predicted ones.
    assert figures[f"R/C, {PREDICTED}"] == pytest.approx(0.3113, abs=1e-3)
    assert (figures[f"rooms, {PREDICTED}"], figures[f"corridors, {PREDICTED}"]) == (-1, 1)
    assert figures[f"edits, {PREDICTED}"] == 2
    assert (figures[f"WL, {PREDICTED}"] or 0) > 0


def test_rivals_count_rooms():
    """Known: 7 rooms, 2 corridors of which one is explored; the model's floors have 10, 14, 14, 19, 10, 16, 11, 12."""
    rivals = Rivals(small_model())
    part = make_prediction("a", EXPLORED, {6}).explored
    sizes = [len(graph.graph) for graph in small_model().floors]
    corridors = [len(wings) for wings, _ in WINGS.values()]
    assert rivals.count_rooms(part) == {BLIND: (fmean(sizes), fmean(corridors)), KNOWN: (14, 4), LOCAL: (8, 2)}
    large = join_wings(("C" * 30, "G"), ((0, 1),), source="large")
    part = read_explored_part(hide_rooms(large, {*range(31)}, {31}), SCHOOL)
    assert rivals.count_rooms(part)[BLIND] == (32, fmean(corridors))


def test_rivals_guess_labels():
    rivals = Rivals(small_model())
    assert rivals.neighbours["CLASSROOM"] == "CORRIDOR"
    assert rivals.neighbours["CORRIDOR"] == "CLASSROOM"
    assert "LAB" not in rivals.neighbours
    part = make_prediction("a", {0, 1, 2}, set()).explored
    assert [*rivals.guess_ends(part).values()] == ["CLASSROOM"] * 4
    columns = [*SCHOOL.by_name]
    shares = rivals.share_labels(part)
    assert dict(zip(columns, shares[LOCAL], strict=True))["CLASSROOM"] == 1
    known = dict(zip(columns, shares[KNOWN], strict=True))
    assert (known["CORRIDOR"], known["CLASSROOM"]) == (pytest.approx(1 / 3), pytest.approx(2 / 3))
    assert shares[BLIND].sum() == pytest.approx(1)
    # A label that no other floor has says nothing, so local is blind.
    graph = nx.path_graph(2)
    nx.set_node_attributes(graph, {0: {"label": "LAB"}, 1: {"label": None, "partial": True}})
    part = read_explored_part(graph, SCHOOL)
    assert rivals.guess_ends(part) == {}
    np.testing.assert_array_equal(rivals.share_labels(part)[LOCAL], shares[BLIND])


def test_rivals_draw_skeletons():
    rivals = Rivals(small_model())
    part = make_prediction("d", {0, 1, 2, 3, 4, 5}, {6, 16}).explored
    (twice,), (local,) = (rivals.draw_skeletons(part)[rival] for rival in (KNOWN, LOCAL))
    # Corridor 0 between two open ones, twice, joined at both.
    assert nx.is_isomorphic(twice, nx.cycle_graph(6))
    assert nx.is_isomorphic(local, nx.path_graph(3))
    # A classroom with an unopened door leads to a corridor, that is next to no known one.
    graph = join_wings(*WINGS["a"], source="a")
    graph.add_edge(1, 9)
    part = read_explored_part(hide_rooms(graph, {*range(6)}, {6}), SCHOOL)
    (local,) = rivals.draw_skeletons(part)[LOCAL]
    assert sorted(dict(local.degree).values()) == [0, 1, 1]
    # Nothing is repeated where no corridor is open.
    part = read_explored_part(hide_rooms(graph, {*range(1, 6), 0}), SCHOOL)
    (twice,) = rivals.draw_skeletons(part)[KNOWN]
    assert nx.is_isomorphic(twice, nx.empty_graph(1))


def test_medoid():
    """Six of the eight skeletons are paths, of two or three corridors."""
    assert nx.is_isomorphic(Rivals(small_model()).medoid, nx.path_graph(2)) or nx.is_isomorphic(
        Rivals(small_model()).medoid, nx.path_graph(3)
    )


def test_coarser_labels():
    merge = merge_labels(SCHOOL, LabelSet.R_C)
    assert merge.shape == (len(SCHOOL.labels), 2)
    assert (merge.sum(axis=1) == 1).all()
    corridors = [label.name for label, row in zip(SCHOOL.labels, merge, strict=True) if row[1]]
    assert corridors == ["CORRIDOR", "LOBBY", "HALL", "ENTRANCE"]


def make_stage(
    number: int, figures: Mapping[str, float | None], *guesses: DoorGuess, seconds: float = 1.0
) -> JudgedStage:
    return JudgedStage(number, 1, 1, figures, guesses, True, False, seconds)


def make_type(*floors: tuple[JudgedStage, ...], rooms: int = 40) -> TypeOfFloors:
    """Floors of their stages, the last of which is that with half of the corridors."""
    judged = [
        JudgedFloor(f"floor {number}", rooms, 4, stages, stages[-1] if stages else None)
        for number, stages in enumerate(floors)
    ]
    return TypeOfFloors(SCHOOL, {}, (), judged, [1.0] * len(floors), [2.0] * len(floors))


def test_figures_over_floors():
    key = "labels, predicted"
    of = make_type(
        (make_stage(1, {key: 1.0}), make_stage(2, {key: 3.0})),
        (make_stage(1, {key: 8.0}),),
        (make_stage(1, {key: None}),),
        (),
    )
    half, every = summarise(of, key, HALF), summarise(of, key, ALL)
    assert (half.mean, half.count) == (5.5, 2)
    # The mean of the stages of a floor first.
    assert (every.mean, every.count) == (5.0, 2)
    negative = make_type((make_stage(1, {key: -2.0}), make_stage(2, {key: 4.0})))
    assert summarise(negative, key, ALL, by=abs).mean == 3
    assert summarise(negative, key, ALL).mean == 1


def test_bars():
    def stage(ours: float, blind: float) -> JudgedStage:
        names = [
            f"{measure}, {who}"
            for measure in ("labels", "WL", "NSPDK", "edits")
            for who in (TYPICAL, "medoid", KNOWN, LOCAL)
        ]
        figures = dict.fromkeys(
            [*names, *(f"{m}, {w}" for m in ("WL", "NSPDK", "edits") for w in (PREDICTED, BLIND))], 1.0
        )
        return make_stage(1, figures | {"labels, predicted": ours, "labels, blind": blind, "labels, oracle": 0.3})

    of = make_type((stage(0.1, 0.2),), (stage(0.3, 0.3),), (stage(0.5, 0.4),), (stage(0.1, 0.5),))
    table = tabulate_bars(of, "school")
    rows = {row.name: [cell.mean for cell in row.cells] for row in table.rows}
    assert rows["labels, predicted: better in"][0] == 50
    assert rows["labels, predicted: mean lower by"][0] == pytest.approx(100 * (1 - 1.0 / 1.4))
    assert "Labels below the blind average in 2 of 4; not in:" in table.notes
    assert "  floor 1, floor 2" in table.notes
    assert "The oracle's labels, not to be had: lower by 14.3 %, below in 2 of 4." in table.notes
    assert measure_gain({}) is None


def test_doors():
    """Three doors; the first is asked again later, when it is guessed right."""
    wrong = DoorGuess("1-2", {"CLASSROOM": 0.75, "LAB": 0.25}, "LAB", "LAB")
    right = DoorGuess("1-2", {"LAB": 1.0}, "LAB", "LAB")
    others = DoorGuess("1-3", {"GYM": 1.0}, "GYM", "LAB"), DoorGuess("1-4", {"GYM": 0.55, "LAB": 0.45}, "GYM", None)
    of = make_type((make_stage(1, {}, wrong), make_stage(2, {}, right, *others)))
    half, every = tabulate_doors(of, "school").rows
    assert half.name == "half (3 doors)"
    assert [cell.mean for cell in half.cells[:2]] == pytest.approx([100, 100 / 3])
    assert half.cells[2].mean == pytest.approx(100 * 0.45 / 3)
    assert every.name == "all (3 doors)"
    assert every.cells[0].mean == pytest.approx(200 / 3)
    assert every.cells[2].mean == pytest.approx(100 * (0.75 + 0.45 + 0) / 3)
    # Each label: 0.75 and 0.25 of the first; 1; 0.55 and 0.45.
    assert every.cells[4].mean == pytest.approx(100 * (0.75 + 0.75 + 0 + 0.45 + 0.45) / 5)
    reliability = tabulate_reliability(of, "school")
    assert {row.name: [cell.mean for cell in row.cells] for row in reliability.rows} == {
        "50 to 60 %": [1, pytest.approx(55), 100],
        "70 to 80 %": [1, 75, 0],
        "90 to 100 %": [1, 100, 100],
    }
    nothing = tabulate_doors(make_type(()), "school").rows[0]
    assert [cell.mean for cell in nothing.cells] == [None] * 5


def test_time():
    def find(rooms: int) -> list[float | None]:
        of = make_type(
            *[(make_stage(1, {}, seconds=9.0), make_stage(2, {}, seconds=seconds)) for seconds in (1, 2, 6)],
            rooms=rooms,
        )
        return [row.cells[0].mean for row in tabulate_time(of, "school", 100).rows]

    assert find(40) == [2, 7.5, 2, 1]
    assert find(46) == [None, None, 2, 1]


def test_names_are_wrapped():
    assert wrap_names([]) == ["  none"]
    lines = wrap_names(["n" * 30] * 5)
    assert len(lines) == 3
    assert max(map(len, lines)) <= 80


def cells_of(table: ComparisonTable) -> dict[str, list[float | None]]:
    return {row.name: [cell.mean for cell in row.cells] for row in table.rows}


@pytest.mark.slow
def test_what_is_measured(measured):
    schools, offices = measured.types.values()
    assert [floor.source for floor in schools.floors] == ["ash", "elm", "elm2", "fir", "oak"]
    assert [floor.source for floor in offices.floors] == [*FLOORS]
    assert [(floor.rooms, floor.corridors) for floor in schools.floors] == [(13, 3), (9, 2), (8, 2), (16, 4), (13, 3)]
    # Of three corridors two are half, of two one; something is unseen then.
    assert [floor.half.corridors if floor.half else None for floor in schools.floors] == [2, 1, 1, 2, 2]
    assert [len(floor.stages) for floor in schools.floors] == [2, 1, 1, 3, 2]
    assert [row.item for row in schools.rows if row.failure] == ["strange"]
    assert all(row.warned for row in schools.rows if not row.failure)
    for floor in schools.floors:
        for stage in floor.stages:
            assert stage.known + stage.unseen == floor.rooms
            assert stage.unseen > 0
            edits = [figure for name, figure in stage.figures.items() if name.startswith("edits")]
            assert all((figure is not None) == (stage is floor.half) for figure in edits)


@pytest.mark.slow
def test_no_floor_of_its_building_is_in_its_model(tiny, monkeypatch):
    graphs, _ = read_floors(tiny, "school")
    assert [graph.graph["source"] for graph in list_others(graphs, "elm2")] == ["ash", "fir", "oak"]
    asked: list[TypeModel] = []

    class Watched(Rivals):
        def __init__(self, model: TypeModel) -> None:
            asked.append(model)
            super().__init__(model)

    monkeypatch.setattr("pianta_bench.prediction.measure.Rivals", Watched)
    measure_prediction(tiny, count=1)
    assert [floor.source for floor in asked[1].floors] == ["ash", "fir", "oak"]
    assert len(asked) == 9


def test_tables(measured):
    console = Console(file=StringIO(), width=100)
    console.print(show_comparisons(tabulate_prediction(measured), measured.items))
    assert isinstance(console.file, StringIO)
    told = console.file.getvalue()
    assert told.count("Jensen-Shannon divergence of the labels of unseen rooms") == 2
    assert "5 of 5 schools have rooms unseen with half of their corridors explored." in told
    assert "strange failed (schools), not counted: " in told
    assert len(tabulate_prediction(measured)) == 14
    notes = [note for table in tabulate_prediction(measured) for note in table.notes]
    assert [note for note in notes if len(note) > 85] == []
    rows = cells_of(tabulate_labels(measured.types["school"], "school"))
    assert [*rows][:3] == ["labels, half", "F/C/E/S, half", "R/C, half"]
    assert all(figure is not None and 0 <= figure <= 1 for figures in rows.values() for figure in figures)


def without_time(content: dict[str, object]) -> str:
    text = json.dumps(
        {
            "items": [
                item | {"figures": {key: figure for key, figure in item["figures"].items() if key != "seconds"}}
                for item in content["items"]  # type: ignore[attr-defined]
            ],
            "tables": [table for table in content["tables"] if not table["title"].startswith("Time")],  # type: ignore[attr-defined]
            "doors": [of["doors"] for of in content["types"].values()],  # type: ignore[attr-defined]
        }
    )
    assert "seconds" not in text
    return text


@pytest.mark.slow
def test_the_same_seed_gives_the_same_figures(tiny, measured, tmp_path):
    contents = []
    for place, bench in enumerate(
        (measured, measure_prediction(tiny, count=8), measure_prediction(tiny, count=8, seed=1))
    ):
        save_prediction(bench, tmp_path / f"{place}.json")
        contents.append(without_time(json.loads((tmp_path / f"{place}.json").read_text())))
    assert contents[0] == contents[1]
    assert contents[0] != contents[2]


def test_too_few_floors(tmp_path):
    write_schools(tmp_path, "KKK-KK", "KKW-KK")
    with pytest.raises(DataError, match="schools"):
        measure_prediction(tmp_path)


def test_pictures(measured, tmp_path):
    save_prediction_pictures(measured, tmp_path)
    # Only one floor is predicted three times.
    assert choose_floors(measured.types["school"]) == ["fir"]
    assert {*list_files(tmp_path)} == {
        f"{kind}_fir_{number}.png" for kind in ("school", "office") for number in (1, 2, 3)
    }


def test_command(tiny, tmp_path):
    file = tmp_path / "new" / "prediction.json"
    outcome = run_pianta("bench", "prediction", "--data", tiny, "-n", 3, "--seed", 2, "--json", file)
    assert (outcome.code, outcome.err) == (1, "")
    content = json.loads(file.read_text())
    assert (content["bench"], content["seed"], content["count"]) == ("prediction", 2, 3)
    assert {item["part"] for item in content["items"]} == {"schools", "offices", "schools, stages", "offices, stages"}
    assert "ash after 1 corridors" in [item["item"] for item in content["items"]]
