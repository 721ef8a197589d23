"""`pianta bench places` on tiny buildings, with a model whose figures can be computed by hand."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import box

from pianta.errors import DataError, MapError
from pianta.evaluation.semantics import LabelPair
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.labels import FCES, SCHEMAS, LabelConvention, LabelSet
from pianta.layout.reconstruct import reconstruct
from pianta.rooms.extra_trees import TreeParameters
from pianta.rooms.features import RoomContext, describe_rooms
from pianta.rooms.training import TrainingFloor, prepare_floors
from pianta_bench.data.annotated_floors import AnnotatedFloor, read_annotated_floors
from pianta_bench.harness import timing
from pianta_bench.harness.records import Results
from pianta_bench.harness.tables import Cell
from pianta_bench.places import measure as places
from pianta_bench.places import models as place_models
from pianta_bench.places.evaluated import BACKWARD, LAYOUTS, THESIS_LAYOUTS, TRUE_LAYOUTS, EvaluatedFloor, measure_curve
from pianta_bench.places.models import (
    CENTRAL,
    LOCAL,
    MAPPED,
    PIANTA,
    Classifiers,
    PreparedFloor,
    list_examples,
    schemas_of,
)
from pianta_bench.places.tables import fill_confusion, tabulate
from tests.command_line import list_files, run_pianta
from tests.tiny_data import OUTLINES, write_building, write_slam
from tests.tiny_types import write_types

R_C, F_C_E_S = LabelSet.R_C, LabelSet.F_C_E_S


class StandIn:
    """Predicts FUNCTIONAL with 0.7 for every room, and after its first passes SERVICE and CONNECTION."""

    def predict_functions(self, context: RoomContext) -> dict[str, Any]:
        probabilities = {
            "first pass": (0.0, 0.0, 0.0, 1.0),
            "second pass": (0.0, 1.0, 0.0, 0.0),
            "random field": (0.7, 0.1, 0.1, 0.1),
        }
        return {step: np.tile(row, (len(context.features), 1)) for step, row in probabilities.items()}

    def label(self, floor: Floor) -> Floor:
        return replace(floor, rooms=tuple(replace(room, label="FUNCTIONAL") for room in floor.rooms))


@pytest.fixture
def trainings(monkeypatch: pytest.MonkeyPatch) -> list[tuple[list[str], list[str]]]:
    """Stand-ins for training and simulation; the names of the training files of each model."""
    trained: list[tuple[list[str], list[str]]] = []

    def train(floors: Sequence[TrainingFloor], *, schemas: object, seed: int) -> StandIn:
        annotated, simulated = ([each.source for each in floors if (each.weight == 1) == one] for one in (True, False))
        trained.append((annotated, simulated))
        return StandIn()

    def simulate(floor: Floor, *, seed: int) -> Floor:
        if floor.source == "office1.xml":
            raise MapError("the map shows no room")
        return floor

    monkeypatch.setattr(place_models, "train_on_prepared", train)
    monkeypatch.setattr(places, "simulate_and_reconstruct", simulate)
    monkeypatch.setattr(place_models, "LOCAL_TREES", TreeParameters(trees=5))
    return trained


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """Three schools, the first two of one building, with a map of the second; two offices."""
    data = tmp_path / "data"
    write_types(data, "school", buildings=3)
    write_types(data, "office")
    write_slam(data, "school1")
    label_map(data / "slam" / "school1_gt.xml", "CLASSROOM", "CORRIDOR")
    paths = "buildings/school/school0.xml", "buildings/school/school1.xml", "slam/school1.png"
    (data / "manifest.json").write_text(json.dumps([{"path": path, "building": "plans"} for path in paths]))
    return data


def label_map(path: Path, *labels: str) -> None:
    text = write_building(OUTLINES, 0.1)
    for number, label in enumerate(labels):
        space = f'<space id="{number}">'
        text = text.replace(space, f"{space}<labels><label>{label}</label></labels>")
    path.write_text(text)


def measure(data: Path) -> Results:
    """Measures in this process, because other processes do not have the stand-ins."""
    return places.measure(data, jobs=1)


def cells_of(results: Results, table: int) -> dict[str, list[Cell]]:
    return {name: [*cells.values()] for name, cells in tabulate(results)[table].rows.items()}


def error_of(results: Results, item: str, **where: Any) -> float:
    (value,) = results.values(item=item, metric="wrong rooms, %", **where)
    return value


@pytest.mark.slow
def test_no_model_is_trained_on_the_building_it_classifies(tiny, trainings):
    measure(tiny)
    schools, offices = ["school0.xml", "school1.xml", "school2.xml"], ["office0.xml", "office1.xml"]
    # Without each office, without the two floors of plans, without the third school; and all, for the cost.
    training = [
        [*schools, "office1.xml"],
        [*schools, "office0.xml"],
        ["school2.xml", *offices],
        [*schools[:2], *offices],
        [*schools, *offices],
    ]
    readable = [[name for name in names if name != "office1.xml"] for names in training]
    assert trainings == [
        pair for names, read in zip(training, readable, strict=True) for pair in ((names, []), (names, read))
    ]


@pytest.mark.slow
def test_table_6_1_by_hand(tiny, trainings):
    results = measure(tiny)
    # A school has CORRIDOR, HALL, 6 CLASSROOMs and 6 CLOSETs; an office LOBBY, 6 OFFICEs, 6 WASHROOMs, CORRIDOR.
    measured = cells_of(results, 0)[PIANTA]
    assert [cell.mean for cell in measured] == pytest.approx([100 * 2 / 14, 100 * 8 / 14] * 2)
    assert [cell.count for cell in measured] == [42, 42, 28, 28]
    assert [cell.mean for cell in cells_of(results, 0)["pianta: first pass"]] == pytest.approx([100 / 7, 400 / 7] * 2)
    assert [cell.mean for cell in cells_of(results, 0)["pianta: second pass"]] == pytest.approx([600 / 7] * 4)
    assert [cell.published_mean for cell in cells_of(results, 0)[CENTRAL]] == [2.44, 33.42, 5.12, 32.80]
    assert cells_of(results, 0)["kLog"][1] == Cell(None, published_mean=46.89, digits=2)
    # In the schools, rooms of one label are nearly of one size: the trees make no error.
    assert [cell.mean for cell in cells_of(results, 0)[LOCAL][:2]] == [0, 0]
    assert error_of(results, "school0", model=PIANTA, labels="F/C/E/S") == pytest.approx(400 / 7)


@pytest.mark.slow
def test_tables_of_a_map_by_hand(tiny, trainings):
    results = measure(tiny)
    accuracies = cells_of(results, 1)
    # Both methods find the two rooms of the map.
    for layouts in ("structure", "Algorithm 1", "true layout"):
        assert [cell.mean for cell in accuracies[f"{layouts}, pianta"]] == [50] * 4
    assert [cell.mean for cell in accuracies["structure, pianta: first pass"]] == [50, 50, 0, 0]
    assert "Algorithm 1, pianta: first pass" not in accuracies
    # The thesis' layouts are those of its Algorithm 1.
    assert [cell.published_mean for cell in accuracies[f"Algorithm 1, {CENTRAL}"]] == [97.1, 96.5, 76.1, 77.5]
    assert [cell.published_mean for cell in accuracies[f"structure, {CENTRAL}"]] == [None] * 4
    titles = [table.title for table in tabulate(results)[2:6]]
    assert [title.rsplit(", ", 1)[1] for title in titles] == ["structure", "Algorithm 1"] * 2
    for forward, backward in ((2, 4), (3, 5)):
        assert [cell.mean for cell in cells_of(results, forward)["pianta, F"]] == [100, 0, 0, 0, 0]
        assert [cell.mean for cell in cells_of(results, backward)["pianta, C"]] == [100, 0, 0, 0, 0]
    assert [cell.mean for cell in cells_of(results, 4)["pianta, E"]] == [None] * 5
    cells = cells_of(results, 5)[f"{CENTRAL}, S"][0], cells_of(results, 3)[f"{CENTRAL}, S"][0]
    assert (cells[0].published_mean, cells[1].published_sd) == (33.9, 8.1)
    assert error_of(results, "school1", part=LAYOUTS, model=PIANTA, labels="R/C", way="FC") == 50


@pytest.mark.slow
def test_calibration_and_cost(tiny, trainings, monkeypatch):
    # The times of two trainings, then of three readings and three labellings, whose medians count.
    lasting = [1, 2, *(3, 4, 9), *(0.5, 0.25, 7)]
    monkeypatch.setattr(timing, "process_time", iter([time for end in lasting for time in (0, end)]).__next__)
    results = measure(tiny)
    errors = [cell.mean for cell in cells_of(results, 6)[PIANTA]]
    errors_of_drawings = [100 * abs(0.9 - 12 / 14), 100 * abs(0.7 - 6 / 14)]
    assert errors == pytest.approx([*errors_of_drawings, *errors_of_drawings, 40, 20])
    assert results.values(part="cost", item="school1", metric=["floors", "rooms", "map rooms"]) == [5, 70, 2]
    assert [cells[0].mean for cells in cells_of(results, 7).values()] == [1, 2, 4, 0.5, 0.125]


@pytest.mark.slow
def test_annotated_floors_of_the_data(data):
    floors, failed = read_annotated_floors(data)
    assert failed == {"school": (), "office": ()}
    schools = {floor.building for floor in floors if floor.kind == "school"}
    assert (len(floors), len(schools)) == (43, 24)
    assert {floor.item for floor in floors if floor.building == "school/sabadell"} == {
        f"sabadell{n}" for n in (1, 2, 3)
    }


def test_a_room_that_overlaps_no_true_room_is_wrong_and_left_out_of_the_calibration():
    rooms = tuple(Room(number, box(20 * number, 0, 20 * number + 10, 10)) for number in (1, 2))
    labels = (replace(rooms[0], label="CLASSROOM"), replace(rooms[0], id=2, polygon=box(90, 0, 95, 5), label="CLOSET"))
    true = Floor(labels, building_type={"school": 1.0})
    by_model = {CENTRAL: {F_C_E_S: np.array([[0.6, 0.4, 0, 0], [0, 1.0, 0, 0]])}}
    by_model[PIANTA] = by_model[CENTRAL]
    floor = EvaluatedFloor(LAYOUTS, "x", "school/x", Floor(rooms), true, by_model, LabelConvention.EXPERIMENTS)
    pairs = [LabelPair("FUNCTIONAL", "FUNCTIONAL"), LabelPair("CONNECTION", None)]
    assert floor.pair_labels(PIANTA, F_C_E_S) == pairs
    assert floor.pair_labels(PIANTA, F_C_E_S, BACKWARD)[1] == LabelPair(None, "SERVICE")
    curve = measure_curve([floor], PIANTA, F_C_E_S)
    assert curve.counts.sum() == 1
    assert curve.error == pytest.approx(0.4)
    service = fill_confusion([floor], BACKWARD, LAYOUTS).rows["pianta, S"]
    assert [cell.mean for cell in service.values()] == [0, 0, 0, 0, 100]
    assert floor.as_json()["true"] == ["FUNCTIONAL", None]
    # The same rooms as a true layout are paired by order, however they overlap.
    true_layout = replace(floor, part=TRUE_LAYOUTS)
    assert true_layout.pair_labels(PIANTA, F_C_E_S)[1] == LabelPair("CONNECTION", "SERVICE")


def test_functions_by_convention():
    figure, experiments = schemas_of(LabelConvention.FIGURE), schemas_of(LabelConvention.EXPERIMENTS)
    assert figure["school"].by_name["GYM"].function_in() == FCES.SERVICE
    for building_type, schema in SCHEMAS.items():
        for label in schema.labels:
            assert experiments[building_type].by_name[label.name].function_in() == label.function_in()
            assert figure[building_type].by_name[label.name].function_in() == label.function
    four = np.array([[0.1, 0.2, 0.3, 0.4]])
    corridors = {
        split: place_models.both_sets(four, split)[R_C]
        for split in (LabelConvention.FIGURE, LabelConvention.EXPERIMENTS)
    }
    np.testing.assert_allclose(corridors[LabelConvention.FIGURE], [[0.5, 0.5]])
    np.testing.assert_allclose(corridors[LabelConvention.EXPERIMENTS], [[0.8, 0.2]])


@pytest.mark.slow
def test_real_models(tiny):
    """Extra-Trees use 9 or 11 features and floors of one type; labels absent from the training have probability 0."""
    floors, _ = read_annotated_floors(tiny)
    convention = LabelConvention.FIGURE
    prepared = [PreparedFloor.prepare(each, convention) for each in floors]
    simulated = list_examples([], [floors[1].floor], convention=convention)
    training = [replace(prepared[1], examples=prepared[1].examples + simulated), *prepared[2:]]
    classifiers = Classifiers(training, convention, seed=0)
    forests = {name: classifiers.forest(name, "school", F_C_E_S) for name in (LOCAL, CENTRAL)}
    assert {name: forest.trees[0].n_features for name, forest in forests.items()} == {LOCAL: 9, CENTRAL: 11}
    assert {len(forest.trees) for forest in forests.values()} == {500}
    assert [classifiers.room_models[name].training.simulated for name in (PIANTA, MAPPED)] == [0, 1]
    by_model = classifiers.predict("school", floors[0].features, describe_rooms(floors[0].unlabelled))
    assert [*by_model] == [
        LOCAL, CENTRAL, PIANTA, "pianta: first pass", "pianta: second pass",
        MAPPED, f"{MAPPED}: first pass", f"{MAPPED}: second pass",
    ]  # fmt: skip
    for probabilities in by_model.values():
        assert {label_set: votes.shape for label_set, votes in probabilities.items()} == {
            R_C: (14, 2),
            F_C_E_S: (14, 4),
        }
        for votes in probabilities.values():
            np.testing.assert_allclose(votes.sum(axis=1), 1)
        assert probabilities[F_C_E_S][0].argmax() == 1, "the corridor"
    np.testing.assert_array_equal(by_model[LOCAL][F_C_E_S][:, 2], 0)


@pytest.mark.slow
def test_the_scale_is_that_of_the_drawing(tiny, trainings):
    results = measure(tiny)
    truth = {floor.part: floor.truth for floor in results.objects["floors"] if floor.item == "school1"}
    areas = [sum(room.polygon.area for room in truth[part].rooms) for part in ("schools", LAYOUTS)]
    assert results.values(part=LAYOUTS, metric="scale") == pytest.approx([(areas[0] / areas[1]) ** 0.5])


def test_unlabelled_floors_have_no_labels_and_no_type():
    room = Room(1, box(0, 0, 1, 1), "OFFICE", {"R/C": "ROOM"}, {"R/C": {"ROOM": 1.0}})
    floor = AnnotatedFloor("x", "office", "office/x", Floor((room,), building_type={"office": 1.0}))
    assert floor.unlabelled == Floor((Room(1, box(0, 0, 1, 1)),))


def test_command(tiny, trainings, tmp_path):
    (tiny / "buildings" / "office" / "broken.xml").write_text("<building/>")
    label_map(tiny / "slam" / "school1_gt.xml", "CLASSROOM", "STAIRS")
    file, pictures = tmp_path / "new" / "places.json", tmp_path / "pictures"
    options = "--split", "figure", "--jobs", 1, "--json", file, "--pictures", pictures
    outcome = run_pianta("bench", "places", "--data", tiny, *options)
    assert (outcome.code, outcome.err) == (1, "")
    assert "broken failed (offices): " in outcome.out
    assert "office1 failed (simulated): the map shows no room" in outcome.out
    assert "divided as in the thesis' figure" in outcome.out
    assert {*list_files(pictures)} == {"confusion.png", "reliability.png", "school1.png", "school1_true.png"}
    content = json.loads(file.read_text())
    assert (content["bench"], content["options"]) == ("places", {"convention": "figure", "seed": 0})
    layout = next(floor for floor in content["rooms"] if floor["part"] == LAYOUTS)
    assert sorted(layout["true"]) == ["ENTRANCE", "FUNCTIONAL"]
    assert layout["probabilities"][PIANTA] == [[0.7, 0.1, 0.1, 0.1]] * 2
    # In the figure's split STAIRS are CORRIDOR, and no room is a certain corridor.
    cells = content["tables"][1]["cells"]
    assert (
        next(cell["mean"] for cell in cells if (cell["row"], cell["column"]) == ("structure, pianta", "R/C, BC")) == 50
    )


def test_a_map_that_one_method_cannot_read_counts_for_the_other(tiny, trainings, monkeypatch):
    def read(grid: GridMap, *, method: str = "structure") -> Floor:
        if method == "thesis":
            raise MapError("the map shows no wall")
        return reconstruct(grid, method=method)

    monkeypatch.setattr(places, "reconstruct", read)
    results = measure(tiny)
    assert [(item.part, item.item) for item in results.items if item.failure and item.part != "simulated"] == [
        (THESIS_LAYOUTS, "school1")
    ]
    assert {floor.part for floor in results.objects["floors"] if floor.item == "school1"} == {
        "schools",
        LAYOUTS,
        TRUE_LAYOUTS,
    }


def test_a_floor_that_cannot_be_described_does_not_stop_the_others(tiny, trainings, monkeypatch):
    def describe(floors: Sequence[Floor], schemas: Any, **options: Any) -> Iterator[TrainingFloor]:
        if any(floor.source == "school2.xml" for floor in floors):
            raise ValueError("no shape")
        return prepare_floors(floors, schemas, **options)

    folder = tiny / "buildings" / "school"
    (folder / "school3.xml").write_text((folder / "school2.xml").read_text())
    monkeypatch.setattr(place_models, "prepare_floors", describe)
    results = measure(tiny)
    assert [(item.part, item.item, item.failure) for item in results.items if item.failure] == [
        ("schools", "school2", "ValueError: no shape"),
        ("simulated", "office1", "the map shows no room"),
    ]
    assert {floor.item for floor in results.objects["floors"]} == {
        "school0",
        "school1",
        "school3",
        "office0",
        "office1",
    }


def test_an_unknown_split_is_refused(tiny):
    outcome = run_pianta("bench", "places", "--data", tiny, "--split", "graphs")
    assert (outcome.code, outcome.out) == (2, "")
    (line,) = outcome.err.splitlines()
    assert line.startswith("error: ")
    assert "graphs" in line


def test_one_building_of_a_type_is_refused(tiny, trainings):
    """Its rooms could only be labelled by models of no building."""
    (tiny / "buildings" / "school" / "school2.xml").unlink()
    outcome = run_pianta("bench", "places", "--data", tiny)
    assert (outcome.code, outcome.out, outcome.err.count("\n")) == (2, "", 1)
    assert outcome.err.startswith("error: 1 building of type school can be read, give 2")
    assert not trainings


def test_without_maps(tiny, trainings):
    for file in (tiny / "slam").iterdir():
        file.unlink()
    with pytest.raises(DataError, match=r"_gt\.xml"):
        measure(tiny)
    assert not trainings
