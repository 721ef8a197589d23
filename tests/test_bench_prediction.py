"""`pianta bench prediction` on tiny schools and offices, and scores of predictions that are made by hand."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from statistics import fmean
from typing import Any

import networkx as nx
import numpy as np
import pytest

from pianta.errors import DataError
from pianta.generation.type_model import TypeModel, learn_type
from pianta.labels import SCHOOL, LabelSet
from pianta.prediction.explored_part import hide_rooms, read_explored_part
from pianta.prediction.prediction import Prediction
from pianta.prediction.unexplored_part import SampledFloor
from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.report import save_results
from pianta_bench.harness.tables import Cell, FilledTable
from pianta_bench.prediction.baselines import BLIND, KNOWN_CORRIDORS, KNOWN_PART, LOCAL, SIMILAR, Baselines
from pianta_bench.prediction.door_tables import ALL, HALF
from pianta_bench.prediction.figures import choose_floors, save_figures
from pianta_bench.prediction.measure import list_others, measure, read_floors
from pianta_bench.prediction.scores import (
    MEAN,
    ORACLE,
    PREDICTED,
    PRINTED,
    SAMPLE,
    TYPICAL,
    Scores,
    describe_stage,
    merge_labels,
    predict_doors,
    score_prediction,
)
from pianta_bench.prediction.tables import derive_floors, measure_gain, tabulate, tabulate_type, wrap_names
from tests.bench_results import show_lines
from tests.command_line import list_files, run_pianta
from tests.generated_types import WINGS, join_wings, make_wing, small_model
from tests.tiny_data import write_school, write_schools

pytestmark = pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")

FLOORS = {"ash": "KKKW-KKC-LLW", "elm": "KKKC-KKW", "fir": "LLW-KKKK-KKS-KK", "oak": "KKKW-LLS-KKC"}


def learn_briefly(*arguments: Any, **options: Any) -> TypeModel:
    """A model with chains too short to mix: these tests are about figures, and chains take most of their time."""
    return replace(learn_type(*arguments, **options), sweeps=20, edge_moves=100, door_moves=10)


@pytest.fixture(scope="module", autouse=True)
def _short_chains() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        for name in ("measure", "figures"):
            patch.setattr(f"pianta_bench.prediction.{name}.learn_type", learn_briefly)
        yield


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four schools, one of two floors and one in two parts, and as many offices."""
    data = tmp_path_factory.mktemp("data")
    for building_type, label in (("school", "CLASSROOM"), ("office", "OFFICE")):
        folder = data / "buildings" / building_type
        folder.mkdir(parents=True)
        for name, wings in FLOORS.items():
            text = write_school(wings.split("-"))
            for school_label in ("CLASSROOM", "LAB", "LIBRARY"):
                text = text.replace(school_label, label) if building_type == "office" else text
            (folder / f"{name}.xml").write_text(text)
    write = data / "buildings" / "school"
    (write / "elm2.xml").write_text(write_school(["KKK", "KKW"]))
    elms = [{"path": f"buildings/school/{name}.xml", "building": "elm"} for name in ("elm", "elm2")]
    (data / "manifest.json").write_text(json.dumps(elms))
    (write / "broken.xml").write_text("<building/>")
    return data


@pytest.fixture(scope="module")
def measured(tiny) -> Results:
    return measure(tiny, count=4, seed=2)


def make_prediction(name: str, explored: set[int], discovered: set[int], *samples: nx.Graph) -> Prediction:
    """A prediction whose samples begin with the rooms of the explored part, in order, those behind doors next."""
    graph = join_wings(*WINGS[name], source=name)
    part = read_explored_part(hide_rooms(graph, explored, discovered), SCHOOL)
    rooms, doors = {node: node for node in part.known_graph}, {door: door for door in part.doors}
    return Prediction(part, tuple(SampledFloor(sample, rooms, doors) for sample in samples), SCHOOL, {})


def score(prediction: Prediction) -> Scores:
    return score_prediction(TRUE, prediction, Baselines(small_model()))


# School a: corridor 0 with four classrooms and a bathroom, corridor 6 with two offices and a closet.
TRUE = join_wings(*WINGS["a"], source="a")
EXPLORED = {0, 1, 2, 3, 4, 5}


def test_a_perfect_prediction():
    prediction = make_prediction("a", EXPLORED, {6}, TRUE, TRUE)
    baselines = Baselines(small_model())
    stage = describe_stage(TRUE, prediction, baselines)
    assert (stage["known rooms"], stage["unseen rooms"], stage["interval holds"]) == (7, 3, 1)
    assert predict_doors(TRUE, prediction, baselines) == []
    scores = score(prediction)
    for predictor in (PREDICTED, MEAN, SAMPLE):
        assert scores["labels", predictor] == pytest.approx(0, abs=1e-5)
    for metric in ("WL", "NSPDK", "edits", "rooms, error", "corridors, error", "rooms, bias", "corridors, bias"):
        assert scores[metric, PREDICTED] == 0
    assert scores["edits", TYPICAL] == 0
    assert (scores["labels", ORACLE] or 0) > 0
    # The unseen rooms have other labels than the known ones: 1 bit, were it not for the closet.
    assert scores["labels", KNOWN_PART] == 1
    assert 0 < (scores["labels", BLIND] or 0) < 1


def test_a_wrong_prediction():
    """A sample with a gym at corridor 6 for all rooms there, and a corridor more."""
    wrong = TRUE.subgraph(range(7)).copy()
    wrong.add_nodes_from([(7, {"label": "GYM"}), (8, {"label": "CORRIDOR"})])
    wrong.add_edges_from([(6, 7), (6, 8)])
    prediction = make_prediction("a", EXPLORED, {6}, wrong)
    assert not describe_stage(TRUE, prediction, Baselines(small_model()))["interval holds"]
    scores = score(prediction)
    assert scores["labels", PREDICTED] == pytest.approx(1, abs=1e-6)
    # Both are all SERVICE and ENTRANCE … or not: the gym is FUNCTIONAL, the corridor CONNECTION.
    assert scores["F/C/E/S", PREDICTED] == pytest.approx(1, abs=1e-6)
    # All unseen rooms are ROOM, half of the predicted ones.
    assert scores["R/C", PREDICTED] == pytest.approx(0.3113, abs=1e-3)
    assert (scores["rooms, bias", PREDICTED], scores["corridors, bias", PREDICTED]) == (-1, 1)
    assert (scores["rooms, error", PREDICTED], scores["corridors, error", PREDICTED]) == (1, 1)
    assert scores["edits", PREDICTED] == 2
    assert (scores["WL", PREDICTED] or 0) > 0


def test_baselines_count_rooms():
    """Known: 7 rooms, 2 corridors of which one is explored; the model's floors have 10, 14, 14, 19, 10, 16, 11, 12.

    Schools a, b, c, e, f, g and h have 1, 2, 2, 1, 2, 2 and 1 open corridors with 3, 4 + 3, 3 + 2, 3, 4 + 3, 3 + 2 and
    4 rooms. Of d, two open corridors with 5 and 2 rooms lead to the third, with 3 rooms: 46 in all behind 14.
    """
    baselines = Baselines(small_model())
    part = make_prediction("a", EXPLORED, {6}).explored
    sizes = [len(graph.graph) for graph in small_model().floors]
    corridors = [len(wings) for wings, _ in WINGS.values()]
    counts = baselines.count_rooms(part)
    assert (counts[BLIND], counts[KNOWN_PART]) == ((fmean(sizes), fmean(corridors)), (14, 4))
    assert counts[LOCAL] == pytest.approx((7 + 46 / 14, 2 + 2 / 14))
    large = join_wings(("C" * 30, "G"), ((0, 1),), source="large")
    part = read_explored_part(hide_rooms(large, {*range(31)}, {31}), SCHOOL)
    assert baselines.count_rooms(part)[BLIND] == (32, fmean(corridors))


def test_what_is_left_at_similar_stages():
    """School a twice: after corridor 0 two offices and a closet are left, after corridor 6 nothing."""
    baselines = Baselines(learn_type([join_wings(*WINGS["a"], source=name) for name in "xy"], SCHOOL))
    part = make_prediction("a", EXPLORED, {6}).explored
    first = sum(
        weight
        for weight, stage in zip(baselines.ends.stage_weights(part), baselines.ends.stages, strict=True)
        if stage.open
    )
    assert 0.5 < first < 1
    assert baselines.count_rooms(part)[SIMILAR] == pytest.approx((7 + 3 * first, 2))
    shares = dict(zip(SCHOOL.by_name, baselines.predict_shares(part)[SIMILAR], strict=True))
    assert shares["SMALL ADMINISTRATIVE"] == pytest.approx(2 / 3, abs=1e-6)
    assert shares["CLOSET"] == pytest.approx(1 / 3, abs=1e-6)


def add_back_rooms(wing: str, *back_rooms: tuple[int, str], source: str) -> nx.Graph:
    """A corridor, 0, with rooms 1, 2, …; each back room is behind the room with this number."""
    graph = make_wing(wing)
    for room, label in back_rooms:
        graph.add_edge(room, len(graph))
        graph.nodes[len(graph) - 1]["label"] = label
    graph.graph["source"] = source
    return graph


def test_baselines_predict_doors():
    """Behind classrooms two closets and a bathroom, behind gyms two bathrooms, behind an office one of each."""
    one = add_back_rooms("CCG", (1, "CLOSET"), (2, "CLOSET"), (3, "BATHROOM"), source="one")
    other = add_back_rooms("CGA", (1, "BATHROOM"), (2, "BATHROOM"), (3, "CLOSET"), (3, "BATHROOM"), source="other")
    baselines = Baselines(learn_type([one, other], SCHOOL))
    graph = nx.path_graph(2)
    predicted, expected = {}, {}
    for label in ("CLASSROOM", "GYM", "SMALL ADMINISTRATIVE", "LIBRARY"):
        nx.set_node_attributes(graph, {0: {"label": label}, 1: {"label": None, "partial": True}})
        part = read_explored_part(graph, SCHOOL)
        ((predicted[label],), (rooms,)) = (
            [*values.values()] for values in (baselines.predict_doors(part), baselines.expect_behind(part))
        )
        columns = [*SCHOOL.by_name]
        expected[label] = rooms[columns.index("CLOSET")], rooms[columns.index("BATHROOM")]
    # Of the office's labels, equally frequent, bathrooms are more frequent behind any door; so they are for libraries.
    assert predicted == {
        "CLASSROOM": ("CLOSET", "BATHROOM"),
        "GYM": ("BATHROOM", "BATHROOM"),
        "SMALL ADMINISTRATIVE": ("BATHROOM", "BATHROOM"),
        "LIBRARY": ("BATHROOM", "BATHROOM"),
    }
    assert expected["CLASSROOM"] == pytest.approx((2 / 3, 1 / 3))
    assert expected["GYM"] == (0, 1)
    assert expected["SMALL ADMINISTRATIVE"] == (0.5, 0.5)
    assert expected["LIBRARY"] == pytest.approx((3 / 7, 4 / 7))
    assert dict(zip(columns, baselines.predict_shares(part)[LOCAL], strict=True))["BATHROOM"] == pytest.approx(4 / 7)


def test_baselines_predict_shares():
    baselines = Baselines(small_model())
    part = make_prediction("a", {0, 1, 2}, set()).explored
    # No other floor has an unopened door.
    assert {*baselines.predict_doors(part).values()} == {(None, None)}
    shares = baselines.predict_shares(part)
    known_shares = dict(zip(SCHOOL.by_name, shares[KNOWN_PART], strict=True))
    assert (known_shares["CORRIDOR"], known_shares["CLASSROOM"]) == (pytest.approx(1 / 3), pytest.approx(2 / 3))
    assert shares[BLIND].sum() == pytest.approx(1)
    # Nothing was directly behind such doors, so local is blind.
    np.testing.assert_array_equal(shares[LOCAL], shares[BLIND])


def test_baselines_predict_skeletons():
    baselines = Baselines(small_model())
    part = make_prediction("d", {0, 1, 2, 3, 4, 5}, {6, 16}).explored
    predicted = baselines.predict_skeletons(part)
    (twice,), (local,), (explored,) = (predicted[baseline] for baseline in (KNOWN_PART, LOCAL, KNOWN_CORRIDORS))
    # Corridor 0 between two open ones, twice, joined at both; one corridor is behind seven open ones.
    assert nx.is_isomorphic(twice, nx.cycle_graph(6))
    assert nx.is_isomorphic(local, nx.path_graph(3))
    assert nx.is_isomorphic(explored, nx.path_graph(3))
    # A classroom with an unopened door leads to a corridor, as every second one, that is next to no known one.
    back_rooms = [add_back_rooms("CC", (1, "CORRIDOR"), (2, "CLOSET"), source=name) for name in "xy"]
    for graph in back_rooms:
        graph.add_edge(3, 5)
        graph.nodes[5]["label"] = "GYM"
    graph = join_wings(*WINGS["a"], source="a")
    graph.add_edge(1, 9)
    part = read_explored_part(hide_rooms(graph, {*range(6)}, {6}), SCHOOL)
    (local,) = Baselines(learn_type(back_rooms, SCHOOL)).predict_skeletons(part)[LOCAL]
    assert sorted(dict(local.degree).values()) == [0, 1, 1]
    # Nothing is repeated where no corridor is open.
    part = read_explored_part(hide_rooms(graph, {*range(1, 6), 0}), SCHOOL)
    (twice,) = baselines.predict_skeletons(part)[KNOWN_PART]
    assert nx.is_isomorphic(twice, nx.empty_graph(1))


def test_medoid():
    """Six of the eight skeletons are paths, of two or three corridors."""
    assert nx.is_isomorphic(Baselines(small_model()).medoid, nx.path_graph(2)) or nx.is_isomorphic(
        Baselines(small_model()).medoid, nx.path_graph(3)
    )


def test_coarser_labels():
    merge = merge_labels(SCHOOL, LabelSet.R_C)
    assert merge.shape == (len(SCHOOL.labels), 2)
    assert (merge.sum(axis=1) == 1).all()
    corridors = [label.name for label, row in zip(SCHOOL.labels, merge, strict=True) if row[1]]
    assert corridors == ["CORRIDOR", "LOBBY", "HALL", "ENTRANCE"]


Stage = dict[tuple[str, str], float | None]


def make_results(*floors: tuple[Stage, ...]) -> Results:
    """Scores of floors by stage; the last stage of a floor is that with half of the corridors."""
    results = Results({"count": 100}, details={"doors": []})
    for number, stages in enumerate(floors):
        item = f"floor {number}"
        results.add("schools", item, {"rooms": 40})
        for explored, scores in enumerate(stages, 1):
            half = explored == len(stages)
            results.add("schools", item, scores, names=("metric", "predictor"), explored=explored, half=half)
    return results


def make_door(door: str, labels: Mapping[str, float], true: str, local: str | None, explored: int) -> Record:
    fields = {"part": "schools", "item": "floor 0", "building": door, "explored": explored, "half": explored == 2}
    return {**fields, "door": door, PREDICTED: labels, "true": true, LOCAL: {} if local is None else {local: 1.0}}


def find_table(results: Results, title: str) -> FilledTable:
    """The table of schools whose title starts like this."""
    (table,) = (table for table in tabulate_type(results, "school") if table.title.startswith(title))
    return table


def list_means(table: FilledTable) -> dict[str, list[float | None]]:
    return {name: [cell.mean for cell in cells.values()] for name, cells in table.rows.items()}


def summarise(results: Results, stage: str) -> Cell:
    """The cell of a stage over floors."""
    return Cell.over(record["value"] for record in derive_floors(results.records) if record["stage"] == stage)


def test_figures_over_floors():
    key = "labels", "predicted"
    results = make_results(({key: 1.0}, {key: 3.0}), ({key: 8.0},), ({key: None},), ())
    half, every = summarise(results, HALF), summarise(results, ALL)
    assert (half.mean, half.count) == (5.5, 2)
    # The mean of the stages of a floor first.
    assert (every.mean, every.count) == (5.0, 2)
    key = "rooms, bias", "predicted"
    assert summarise(make_results(({key: -2.0}, {key: 4.0})), ALL).mean == 1
    key = "rooms, error", "predicted"
    assert summarise(make_results(({key: 2.0}, {key: 4.0})), ALL).mean == 3


def test_comparison_with_baselines():
    def stage(value: float, blind: float) -> tuple[Stage]:
        metrics, predictors = (
            ("labels", "WL", "NSPDK", "edits"),
            (PREDICTED, BLIND, TYPICAL, "medoid", KNOWN_PART, LOCAL),
        )
        scores: Stage = {(metric, predictor): 1.0 for metric in metrics for predictor in predictors}
        scores |= {("labels", PREDICTED): value, ("labels", BLIND): blind, ("labels", ORACLE): 0.3}
        return (scores,)

    results = make_results(stage(0.1, 0.2), stage(0.3, 0.3), stage(0.5, 0.4), stage(0.1, 0.5))
    better = find_table(results, "Section 8.3, schools, half of the corridors: better")
    lower = find_table(results, "Section 8.3, schools, half of the corridors: mean lower")
    assert better.rows["labels, predicted"]["blind"].mean == 50
    assert better.rows["labels, predicted"]["blind"].count == 4
    assert lower.rows["labels, predicted"]["blind"].mean == pytest.approx(100 * (1 - 1.0 / 1.4))
    assert "Labels below the blind average in 2 of 4; not in:" in better.notes
    assert "  floor 1, floor 2" in better.notes
    assert "The oracle's labels, not known in practice: lower by 14.3 %, below in 2 of 4." in better.notes
    assert measure_gain([]) is None


def test_doors():
    """Three doors; the first is predicted again later, when the prediction is right."""
    results = make_results(({}, {}))
    assert list_means(find_table(results, "What is behind")) == {"half, predicted": [0], "all, predicted": [0]}
    results.details["doors"] = [
        make_door("1-2", {"CLASSROOM": 0.75, "LAB": 0.25}, "LAB", "LAB", 1),
        make_door("1-2", {"LAB": 1.0}, "LAB", "LAB", 2),
        make_door("1-3", {"GYM": 1.0}, "GYM", "LAB", 2),
        make_door("1-4", {"GYM": 0.55, "LAB": 0.45}, "GYM", None, 2),
    ]
    table = find_table(results, "What is behind")
    assert table.columns[:3] == ("doors", "right, %", "squared error")
    rows = list_means(table)
    assert rows["half, predicted"][:2] == [3, 100]
    # (1 - 0.55)² + 0.45² of one of three.
    assert rows["half, predicted"][2] == pytest.approx(2 * 0.45**2 / 3)
    assert rows["half, predicted"][3] == pytest.approx(100 * 0.45 / 3)
    assert rows["half, local"] == [3, pytest.approx(100 / 3), None, None, None, None]
    assert rows["all, predicted"][:2] == pytest.approx([3, 200 / 3])
    assert rows["all, predicted"][3] == pytest.approx(100 * (0.75 + 0.45 + 0) / 3)
    # Each label: 0.75 and 0.25 of the first; 1; 0.55 and 0.45.
    assert rows["all, predicted"][5] == pytest.approx(100 * (0.75 + 0.75 + 0 + 0.45 + 0.45) / 5)
    # Right instead of local at two of three doors, each of its own building.
    (note,) = [note for note in table.notes if "right, points, minus local" in note]
    assert "+66.7 (+0.0 to +100.0)" in note
    assert list_means(find_table(results, "Reliability")) == {
        "50 to 60 %": [1, pytest.approx(55), 100],
        "70 to 80 %": [1, 75, 0],
        "90 to 100 %": [1, 100, 100],
    }


def test_doors_of_the_printed_sampler_are_compared_only_where_all_have_its_prediction():
    results = make_results(({}, {}))
    results.details["doors"] = [
        make_door("1-2", {"LAB": 1.0}, "LAB", "LAB", 1),
        {**make_door("1-3", {"GYM": 1.0}, "GYM", "LAB", 2), PRINTED: {"GYM": 1.0}},
    ]
    rows = list_means(find_table(results, "What is behind"))
    assert rows["half, as printed"][:2] == [1, 100]
    assert rows["all, predicted"][0] == 2
    assert "all, as printed" not in rows


def test_time():
    def find(rooms: int) -> list[float | None]:
        results = Results({"count": 100}, details={"doors": []})
        for number, seconds in enumerate((1, 2, 6)):
            item = f"floor {number}"
            results.add("schools", item, {"rooms": rooms})
            once = {"model, once": 1.0, "sampler, once": 2.0}
            results.add("schools", item, once, names=("work",), metric="seconds")
            for explored, spent in enumerate((9.0, seconds), 1):
                half = explored == 2
                results.add("schools", item, {"seconds": spent}, work="prediction", explored=explored, half=half)
        return [means[0] for means in list_means(find_table(results, "Time of 100 samples")).values()]

    assert find(40) == [2, 7.5, 2, 1]
    assert find(46) == [None, None, 2, 1]


def test_names_are_wrapped():
    assert wrap_names([]) == ["  none"]
    lines = wrap_names(["n" * 30] * 5)
    assert len(lines) == 3
    assert max(map(len, lines)) <= 80


@pytest.mark.slow
def test_what_is_measured(measured):
    graphs = measured.objects["graphs"]
    assert [*graphs["school"]] == ["ash", "elm", "elm2", "fir", "oak"]
    assert [*graphs["office"]] == [*FLOORS]
    sizes = [measured.values(part="schools", metric=metric) for metric in ("rooms", "corridors")]
    assert [*zip(*sizes, strict=True)] == [(13, 3), (9, 2), (8, 2), (16, 4), (13, 3)]
    # Of three corridors two are half, of two one; something is unseen then.
    stages = measured.select(part="schools", metric="known rooms")
    assert [stage["explored"] for stage in stages if stage["half"]] == [2, 1, 1, 2, 2]
    numbers = [sum(stage["item"] == name for stage in stages) for name in graphs["school"]]
    assert numbers == [2, 1, 1, 3, 2]
    schools = [item for item in measured.items if item.part == "schools"]
    assert [item.item for item in schools if item.failure] == ["broken"]
    assert all(item.warnings for item in schools if not item.failure)
    unseen = measured.select(part="schools", metric="unseen rooms")
    for stage, other in zip(stages, unseen, strict=True):
        assert stage["value"] + other["value"] == len(graphs["school"][stage["item"]])
        assert other["value"] > 0
    edits = measured.select(part="schools", metric="edits")
    # Two more by the printed sampler.
    assert len(edits) == 7 * len(stages) + 2 * sum(stage["half"] for stage in stages)
    assert all((record["value"] is not None) == record["half"] for record in edits)


@pytest.mark.slow
def test_no_floor_of_its_building_is_in_its_model(tiny, monkeypatch):
    graphs = read_floors(Results(), tiny, "school")
    assert [graph.graph["source"] for graph in list_others(graphs, "elm2")] == ["ash", "fir", "oak"]
    models: list[TypeModel] = []

    class Watched(Baselines):
        def __init__(self, model: TypeModel) -> None:
            models.append(model)
            super().__init__(model)

    monkeypatch.setattr("pianta_bench.prediction.measure.Baselines", Watched)
    measure(tiny, count=1)
    assert [floor.source for floor in models[1].floors] == ["ash", "fir", "oak"]
    assert len(models) == 9


@pytest.mark.slow
def test_tables(measured):
    tables = tabulate(measured)
    text = "\n".join(show_lines(tables, measured, width=100))
    assert text.count("Jensen-Shannon divergence of the labels of unseen rooms") == 2
    assert "5 of 5 schools have rooms unseen with half of their corridors explored." in text
    assert "broken failed (schools): " in text
    assert len(tables) == 18
    assert [note for table in tables for note in table.notes if len(note) > 85] == []
    rows = list_means(find_table(measured, "Jensen-Shannon"))
    assert [*rows][:3] == ["half, labels", "half, F/C/E/S", "half, R/C"]
    assert all(figure is not None and 0 <= figure <= 1 for figures in rows.values() for figure in figures)


@pytest.mark.slow
def test_too_few_floors(tmp_path):
    write_schools(tmp_path, "KKK-KK", "KKW-KK")
    with pytest.raises(DataError, match="schools"):
        measure(tmp_path)


@pytest.mark.slow
def test_pictures(measured, tmp_path):
    save_figures(measured, tmp_path)
    # Only one floor is predicted three times.
    assert choose_floors(measured, "school") == {"fir": [1, 2, 3]}
    assert {*list_files(tmp_path)} == {
        f"{building_type}_fir_{number}.png" for building_type in ("school", "office") for number in (1, 2, 3)
    }


@pytest.mark.slow
def read_figures(file: Path) -> dict[str, Any]:
    """The content of a file of results, without times."""
    content: dict[str, Any] = json.loads(file.read_text())
    content["records"] = [record for record in content["records"] if record["metric"] != "seconds"]
    content["tables"] = [table for table in content["tables"] if not table["title"].startswith("Time")]
    assert "seconds" not in json.dumps(content)
    return content


def test_the_command_gives_the_figures_of_its_seed(tiny, measured, tmp_path):
    file = tmp_path / "new" / "prediction.json"
    outcome = run_pianta("bench", "prediction", "--data", tiny, "-n", 4, "--seed", 2, "--json", file)
    assert (outcome.code, outcome.err) == (1, "")
    content = read_figures(file)
    assert (content["bench"], content["options"]) == ("prediction", {"seed": 2, "count": 4})
    save_results("prediction", tabulate(measured), measured, tmp_path / "again.json")
    assert read_figures(tmp_path / "again.json") == content
    assert {item["part"] for item in content["items"]} == {"schools", "offices"}
    assert ("ash", 1) in {(record["item"], record.get("explored")) for record in content["records"]}
    assert {door["part"] for door in content["doors"]} <= {"schools", "offices"}
