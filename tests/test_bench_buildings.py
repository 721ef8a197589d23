"""`pianta bench buildings` on tiny buildings whose types and rooms are easy to distinguish, and on folders of them."""

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pianta.errors import DataError, LabelError, OptionError
from pianta.io.label_schemas import save_label_schema
from pianta.labels import FCES, SCHEMAS, GeneralLabel, Label, LabelConvention, LabelSchema, LabelSet
from pianta.relational.kernels import RoomKernel
from pianta.rooms.completion import LABELS
from pianta.rooms.features import RoomContext
from pianta.rooms.training import TrainingFloor
from pianta_bench.buildings.floors import BuildingFloor, read_building_floors, read_type_folders
from pianta_bench.buildings.measure import list_errors
from pianta_bench.buildings.measure import measure as measure_all
from pianta_bench.buildings.models import (
    KLOG,
    MODELS,
    FloorScores,
    classify_floors_by_pianta,
    classify_floors_by_relations,
    classify_floors_by_trees,
    classify_rooms_by_relations,
    classify_rooms_by_trees,
    compare_by_fold,
    compare_floors,
)
from pianta_bench.buildings.scores import BUILDING, FLOOR, Scores
from pianta_bench.buildings.tables import tabulate
from pianta_bench.harness.folds import list_folds
from pianta_bench.harness.records import Results
from pianta_bench.harness.tables import Cell
from pianta_bench.places import models as place_models
from pianta_bench.places.models import CENTRAL, LOCAL, PIANTA
from tests.command_line import list_files, run_pianta
from tests.tiny_types import write_labelled, write_types

R_C, F_C_E_S = LabelSet.R_C, LabelSet.F_C_E_S


class StandIn:
    """Predicts SERVICE with 0.7 for every room."""

    def predict_functions(self, context: RoomContext) -> dict[str, Any]:
        return {"random field": np.tile((0.1, 0.1, 0.1, 0.7), (len(context.features), 1))}


def stand_in_for_training(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Replaces training; the names of the training files of each model."""
    trained: list[list[str]] = []

    def train(floors: Sequence[TrainingFloor], **_: object) -> StandIn:
        trained.append([floor.source for floor in floors])
        return StandIn()

    monkeypatch.setattr(place_models, "train_on_prepared", train)
    return trained


@pytest.fixture
def trainings(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """A stand-in for training; the names of the training files of each model."""
    return stand_in_for_training(monkeypatch)


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    return write_tiny(tmp_path)


def write_tiny(folder: Path) -> Path:
    """Four schools, the first two of one building, and three offices."""
    data = folder / "data"
    write_types(data, "school", buildings=4)
    write_types(data, "office", buildings=3)
    paths = "buildings/school/school0.xml", "buildings/school/school1.xml"
    (data / "manifest.json").write_text(json.dumps([{"path": path, "building": "plans"} for path in paths]))
    return data


def cells_of(results: Results, table: int) -> dict[str, list[Cell]]:
    return {name: [*cells.values()] for name, cells in tabulate(results)[table].rows.items()}


def scores_of(results: Results) -> Scores:
    scores = results.objects["scores"]
    assert isinstance(scores, Scores)
    return scores


def measure(data: Path, **options: Any) -> Results:
    """Measures in this process, because other processes do not have the stand-ins."""
    return measure_all(data, trees=10, jobs=1, **options)


def measure_types(folders: Sequence[Path]) -> Results:
    return measure_all(types=folders, trees=5, jobs=1)


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, list[list[str]]]:
    """The results on the tiny data, and the names of the training files of each model; tests must not change them."""
    with pytest.MonkeyPatch.context() as monkeypatch:
        trained = stand_in_for_training(monkeypatch)
        return measure(write_tiny(tmp_path_factory.mktemp("tiny"))), trained


@pytest.mark.slow
def test_no_model_is_trained_on_the_building_it_classifies(measured):
    _, trainings = measured
    names = [*(f"school{n}.xml" for n in range(4)), *(f"office{n}.xml" for n in range(3))]
    left_out = [*([name] for name in names[4:]), names[:2], *([name] for name in names[2:4])]
    assert trainings == [[name for name in names if name not in out] for out in left_out]


@pytest.fixture
def floors(tiny: Path) -> list[BuildingFloor]:
    return read_building_floors(tiny, convention=LabelConvention.EXPERIMENTS)[0]


def with_wrong_labels(floor: BuildingFloor) -> BuildingFloor:
    """Each room has the next label of its label set instead of its own."""
    labels = {
        label_set: tuple(names[(names.index(label) + 1) % len(names)] for label in floor.labels[label_set])
        for label_set, names in LABELS.items()
    }
    return replace(floor, labels=labels)


def with_wrong_measures(floor: BuildingFloor) -> BuildingFloor:
    """The sizes of the rooms lie between those of the other floors, where the edges of the bins are."""
    facts = tuple(
        replace(fact, arguments=(fact.arguments[0], 5.0 + index / 1000)) if fact.relation == "area" else fact
        for index, fact in enumerate(floor.facts.facts)
    )
    return replace(floor, facts=replace(floor.facts, facts=facts))


def with_wrong_type(floor: BuildingFloor) -> BuildingFloor:
    return replace(
        floor, annotated=replace(floor.annotated, kind="office" if floor.annotated.kind == "school" else "school")
    )


def folds_of(floors: Sequence[BuildingFloor]) -> Any:
    return list_folds([floor.annotated.building for floor in floors])


@pytest.mark.slow
def test_trees_are_not_trained_on_the_building(floors):
    """Wrong labels and types of the held-out floors do not change their predictions."""
    classify_rooms = partial(classify_rooms_by_trees, model=LOCAL, trees=10, seed=0)
    classify_types = partial(classify_floors_by_trees, label_set=R_C, model=LOCAL, trees=10, seed=0)
    labels, types = classify_rooms(floors)[F_C_E_S], classify_types(floors, folds_of(floors)).values
    for held_out in ([0, 1], [2], [5]):
        wrong_labels, wrong_types = (
            [make(floor) if index in held_out else floor for index, floor in enumerate(floors)]
            for make in (with_wrong_labels, with_wrong_type)
        )
        for index in held_out:
            np.testing.assert_array_equal(classify_rooms(wrong_labels)[F_C_E_S][index], labels[index])
        np.testing.assert_array_equal(classify_types(wrong_types, folds_of(floors)).values[held_out], types[held_out])


@pytest.mark.slow
def test_pianta_is_not_trained_on_the_building(floors):
    """Wrong types and descriptions of the held-out floors do not change the predictions for their buildings."""
    predicted, typical = classify_floors_by_pianta(floors, folds_of(floors), R_C)
    for held_out in ([0, 1], [2], [5]):
        wrong = [with_wrong_type(floor) if index in held_out else floor for index, floor in enumerate(floors)]
        predicted_again, typical_again = classify_floors_by_pianta(wrong, folds_of(floors), R_C)
        np.testing.assert_array_equal(predicted_again[held_out], predicted[held_out])
        assert typical is not None
        assert typical_again is not None
        np.testing.assert_array_equal(typical_again[held_out], typical[held_out])
    # school0 and school1 are one building: the description of school1 must not influence school0.
    wrong = [floors[0], replace(floors[1], descriptions=floors[6].descriptions), *floors[2:]]
    predicted_again, _ = classify_floors_by_pianta(wrong, folds_of(floors), R_C)
    np.testing.assert_array_equal(predicted_again[0], predicted[0])
    assert not np.array_equal(predicted_again[2], predicted[2]), "the other floors are trained on it"


@pytest.mark.slow
def test_the_relational_kernel_is_not_trained_on_the_building(floors, monkeypatch):
    """Labels of a floor, and measures that would move the bins, do not change the predictions for its building."""
    schools = floors[:4]
    bins: list[list[str]] = []
    fit = RoomKernel.fit

    def spy(kernel: Any, training: Any, *, binned: Any) -> Any:
        bins.append([each.name for each in binned])
        return fit(kernel, training, binned=binned)

    monkeypatch.setattr(RoomKernel, "fit", spy)
    predicted = classify_rooms_by_relations(schools)
    # plans, school2 and school3 are one fold each.
    assert bins == [["school2", "school3"], ["school0", "school1", "school3"], ["school0", "school1", "school2"]]
    assert [[values.shape for values in predicted[each]] for each in (R_C, F_C_E_S)] == [[(14, 2)] * 4, [(14, 4)] * 4]
    # school0 and school1 are one building: school1 must not influence school0.
    predicted_again = classify_rooms_by_relations(
        [with_wrong_labels(schools[0]), with_wrong_measures(with_wrong_labels(schools[1])), *schools[2:]]
    )
    for label_set in (R_C, F_C_E_S):
        np.testing.assert_array_equal(predicted_again[label_set][0], predicted[label_set][0])
        assert not np.array_equal(predicted_again[label_set][2], predicted[label_set][2]), (
            "the other floors are trained on it"
        )


@pytest.mark.slow
def test_the_kernel_of_floors_is_not_trained_on_the_building(floors):
    """The same for building types, also with a wrong type."""

    def predict(training: Sequence[BuildingFloor]) -> Any:
        return classify_floors_by_relations(training, folds_of(training), compare_floors(training, R_C)).values

    predicted = predict(floors)
    wrong = with_wrong_type(with_wrong_measures(with_wrong_labels(floors[1])))
    predicted_again = predict([with_wrong_type(floors[0]), wrong, *floors[2:]])
    np.testing.assert_array_equal(predicted_again[0], predicted[0])
    assert not np.array_equal(predicted_again[2], predicted[2]), "the other floors are trained on it"


def test_folds_of_many_buildings():
    training_sets: list[list[int]] = []

    def compare(others: Any) -> Any:
        training_sets.append(others.tolist())
        return np.zeros((0, 0))

    buildings = ["a", "b", "c", "d", "e", "f", "a"]
    gram_of_building = compare_by_fold(buildings, compare)
    for name in buildings:
        gram_of_building(name)
    # Three folds, each compared once: a and d, b and e, c and f.
    assert training_sets == [[1, 2, 4, 5], [0, 2, 3, 5, 6], [0, 1, 3, 4, 6]]


@pytest.mark.slow
def test_table_6_1_by_hand(measured):
    results, _ = measured
    cells = cells_of(results, 0)
    assert [*cells] == [*MODELS]
    # A school has CORRIDOR, HALL, 6 CLASSROOMs and 6 CLOSETs; an office LOBBY, 6 OFFICEs, 6 WASHROOMs, CORRIDOR.
    assert [cell.mean for cell in cells[PIANTA][:4]] == pytest.approx([100 * 2 / 14, 100 * 8 / 14] * 2)
    types = cells_of(results, 1)
    assert [cell.count for cell in (*cells[PIANTA], *types[PIANTA])] == [56, 56, 42, 42, 7, 7, 7, 7]
    published = [[cell.published_mean for cell in (*cells[model], *types[model])] for model in MODELS]
    assert published == [
        [3.74, 35.56, 7.21, 36.15, 40, 40, None, 5],
        [2.44, 33.42, 5.12, 32.80, 30, 30, None, 5],
        [6.82, 46.89, 7.73, 44.92, 8, None, 8, None],
        [None] * 8,
    ]
    # Rooms of one label are nearly of one size, and rooms of different types are not: these models make no error.
    for model in (LOCAL, CENTRAL):
        assert [cell.mean for cell in types[model]] == [0, 0, 0, 0]
    assert [cell.mean for cell in cells[LOCAL][:2]] == [0, 0]
    # The kernel hardly measures how large a HALL is.
    wrong = [cell.mean for cell in cells[KLOG][:2]]
    assert all(mean is not None and mean <= 100 * most / 14 for mean, most in zip(wrong, (2, 6), strict=True))
    one_floor_out = cells_of(results, 2)
    assert [cell.published_mean for cell in one_floor_out[KLOG]] == [8, None, 8, None]
    assert [cell.sd for cell in cells_of(results, 3)[PIANTA]] == pytest.approx([0] * 4)


@pytest.mark.slow
def test_wrong_floors_are_named(measured):
    measured_scores = scores_of(measured[0])
    floor_scores = np.zeros((7, 2))
    floor_scores[:, measured_scores.building_types.index("school")] = 1
    scores = replace(
        measured_scores,
        types={**measured_scores.types, (BUILDING, KLOG, R_C): FloorScores(floor_scores, np.ones(7, bool))},
    )
    results = Results(options=measured[0].options, objects={**measured[0].objects, "scores": scores})
    list_errors(results, scores)
    assert scores.wrong_floors(BUILDING, KLOG, R_C).tolist() == [False] * 4 + [True] * 3
    table = tabulate(results)[1]
    # Three of seven floors; none of four schools and three of three offices.
    assert [cell.mean for cell in cells_of(results, 1)[KLOG][:2]] == pytest.approx([300 / 7, 50])
    assert "Wrong, kLog-style, R/C: office0, office1, office2." in table.notes
    assert "Wrong, Ex-T, R/C: none." in table.notes
    wrong_type = {"model": KLOG, "labels": R_C, "metric": "wrong type", "left_out": "building"}
    assert results.values(item="office1", **wrong_type) == [1]
    assert results.values(item="school1", **wrong_type) == [0]
    wrong_rooms = results.values(item="school1", model=PIANTA, labels=F_C_E_S, metric="wrong rooms, %")
    assert wrong_rooms == pytest.approx([800 / 14])


@pytest.mark.slow
def test_votes_of_rooms(tiny):
    """A floor has the type that is predicted for most of its rooms."""
    floors, _ = read_building_floors(tiny, convention=LabelConvention.EXPERIMENTS)
    folds = list_folds([floor.annotated.building for floor in floors])
    votes = classify_floors_by_trees(floors, folds, R_C, model=CENTRAL, trees=10, seed=0).values
    np.testing.assert_allclose(votes.sum(axis=1), 1)
    np.testing.assert_allclose(votes * 14, np.round(votes * 14), atol=1e-9)
    assert (votes[:4, 1] > 0.5).all()


@pytest.mark.slow
def test_gram_matrices_of_floors_depend_on_the_labels(tiny):
    floors, _ = read_building_floors(tiny, convention=LabelConvention.EXPERIMENTS)
    grams = [compare_floors(floors, label_set)("office/office0") for label_set in (R_C, F_C_E_S)]
    assert [gram.shape for gram in grams] == [(7, 7)] * 2
    np.testing.assert_allclose(np.diag(grams[0]), 1)
    assert not np.allclose(grams[0], grams[1])
    assert len(floors[0].labelled_facts[R_C].facts) == len(floors[0].facts.facts) + 14
    assert not floors[0].facts.facts_of("label")
    assert not floors[0].labelled_facts[R_C].facts_of("buildingtype")


@pytest.mark.slow
def test_curves(measured):
    curves = {(part, model, name): curve for part, model, name, curve in scores_of(measured[0]).measure_curves()}
    assert {part for part, _, _ in curves} == {"S", "O", "S+O"}
    # Every room has the same score.
    roc, precision_recall = (curves["S", PIANTA, name] for name in ("ROC", "PR"))
    assert roc.area == 0.5
    assert [precision_recall.area, precision_recall.chance] == pytest.approx([1 / 7, 1 / 7])
    assert curves["S+O", LOCAL, "PR"].chance == pytest.approx(3 / 7)
    assert curves["S+O", LOCAL, "ROC"].area == 1


@pytest.mark.slow
def test_the_convention_changes_functions_of_labels(tiny, trainings):
    (tiny / "buildings" / "school" / "school3.xml").write_text(
        write_labelled("school", stretch=1).replace("CLOSET", "GYM")
    )
    labels = {}
    for convention in (LabelConvention.EXPERIMENTS, LabelConvention.FIGURE):
        floors, _ = read_building_floors(tiny, convention=convention)
        labels[convention] = floors[3].labels[F_C_E_S]
    assert labels[LabelConvention.EXPERIMENTS].count(FCES.FUNCTIONAL) == 12
    assert labels[LabelConvention.FIGURE].count(FCES.FUNCTIONAL) == 6


def test_command(tiny, trainings, tmp_path):
    (tiny / "buildings" / "office" / "broken.xml").write_text("<building/>")
    file, pictures = tmp_path / "new" / "buildings.json", tmp_path / "pictures"
    options = "--trees", 5, "--seed", 3, "--jobs", 1, "--json", file, "--pictures", pictures
    outcome = run_pianta("bench", "buildings", "--data", tiny, *options)
    assert (outcome.code, outcome.err) == (1, "")
    assert "broken failed (offices): " in outcome.out
    assert "Ex-T: 5 trees (thesis: 500)" in outcome.out
    assert {*list_files(pictures)} == {"places.png", "buildings.png"}
    content = json.loads(file.read_text())
    assert (content["bench"], content["options"]) == (
        "buildings",
        {"convention": "experiments", "trees": 5, "seed": 3},
    )
    assert {cell["row"] for cell in content["tables"][-1]["cells"]} == {*MODELS, "Ex-T and kLog-style"}
    floor = next(floor for floor in content["floors"] if floor["item"] == "school1")
    assert (floor["building"], floor["type"], len(floor["rooms"])) == ("school/plans", "school", 14)
    assert floor["true"]["R/C"].count("CORRIDOR") == 2
    prediction = next(each for each in floor["predicted"] if (each["model"], each["labels"]) == (PIANTA, "F/C/E/S"))
    assert prediction["predicted"] == ["SERVICE"] * 14
    assert {each["left_out"] for each in floor["scores"]} == {BUILDING, FLOOR}
    assert len(content["curves"]) == 3 * 4 * 2
    failed = [item for item in content["items"] if item["failure"]]
    assert [(item["part"], item["item"]) for item in failed] == [("offices", "broken")]


@pytest.mark.slow
def test_same_seed_same_figures(tiny, trainings, measured):
    one, other = scores_of(measured[0]), scores_of(measure(tiny))
    for key, scores in one.types.items():
        np.testing.assert_array_equal(scores.values, other.types[key].values)


@pytest.mark.slow
def test_figures_do_not_depend_on_the_number_of_processes(tiny):
    one, other = (measure_all(tiny, trees=3, jobs=jobs) for jobs in (1, 2))
    assert [record for record in one.records if record["part"] != "processor seconds"] == [
        record for record in other.records if record["part"] != "processor seconds"
    ]
    assert one.details == other.details


@pytest.fixture
def folders(tmp_path: Path) -> list[Path]:
    """Three schools, offices and houses, the last with a schema of their own."""
    type_folders = []
    for building_type in ("school", "office", "house"):
        folder = tmp_path / building_type
        folder.mkdir()
        for number in range(3):
            (folder / f"{building_type}{number}.xml").write_text(write_labelled(building_type, stretch=1 + number / 10))
        type_folders.append(folder)
    labels = ("C", FCES.CONNECTION, GeneralLabel.CORRIDOR), ("H", FCES.CONNECTION, GeneralLabel.HALL)
    rooms = ("M", FCES.FUNCTIONAL, GeneralLabel.MEDIUM), ("S", FCES.SERVICE, GeneralLabel.SMALL)
    schema = LabelSchema("house", tuple(Label(*label, "#aabbcc") for label in (*labels, *rooms)))
    save_label_schema(schema, type_folders[2] / "labels.yaml")
    return type_folders


@pytest.mark.slow
def test_three_types(folders, tmp_path):
    file = tmp_path / "types.json"
    arguments = [argument for folder in folders for argument in ("--types", folder)]
    outcome = run_pianta("bench", "buildings", *arguments, "--trees", 5, "--jobs", 1, "--json", file)
    assert (outcome.code, outcome.err) == (0, "")
    assert "Confusion of building types, R/C" in outcome.out
    content = json.loads(file.read_text())
    assert content["tables"][0]["title"] == "Building classification, errors"
    assert {floor["type"] for floor in content["floors"]} == {"school", "office", "house"}
    assert all(each["left_out"] == BUILDING for floor in content["floors"] for each in floor["scores"])
    confusion = {(cell["row"], cell["column"]): cell["mean"] for cell in content["tables"][1]["cells"]}
    building_types = "school", "office", "house"
    assert {
        sum(confusion[f"{model}, {building_type}", name] for name in building_types)
        for model in MODELS
        for building_type in building_types
    } == {3}
    assert confusion[f"{CENTRAL}, school", "school"] == 3


@pytest.mark.slow
def test_confusion_by_hand(folders):
    results = measure_types(folders)
    assert scores_of(results).building_types == ["house", "office", "school"]
    floor_scores = np.eye(3)[[0, 1, 2, 1, 1, 1, 0, 0, 2]]
    types = {**scores_of(results).types, (BUILDING, PIANTA, F_C_E_S): FloorScores(floor_scores, np.ones(9, bool))}
    scores = replace(scores_of(results), types=types)
    changed = Results(options=results.options, objects={"scores": scores, "is_table_6_1": False})
    list_errors(changed, scores)
    # The floors are three schools, three offices, three houses.
    rows = {name: [cell.mean for cell in cells] for name, cells in cells_of(changed, 2).items()}
    assert rows["pianta, school"] == [1, 1, 1]
    assert rows["pianta, office"] == [0, 3, 0]
    assert rows["pianta, house"] == [2, 0, 1]
    # Two of three schools and one of three houses: as many floors of each type, so both statistics are equal.
    assert [cell.mean for cell in cells_of(changed, 0)[PIANTA][2:]] == pytest.approx([300 / 9, 300 / 9])


@pytest.mark.slow
def test_labels_of_another_schema(folders):
    (folders[2] / "labels.yaml").unlink()
    with pytest.raises(DataError, match="house"):
        measure_types(folders)
    (folders[0] / "school2.xml").write_text(write_labelled("office", stretch=1))
    with pytest.raises(DataError, match=r"school2.*OFFICE"):
        measure_types(folders[:2])


@pytest.mark.slow
def test_too_few_buildings_or_types_are_refused(folders, tiny, tmp_path):
    for name in ("office1.xml", "office2.xml"):
        (folders[1] / name).unlink()
    outcome = run_pianta("bench", "buildings", "--types", folders[0], "--types", folders[1])
    assert (outcome.code, outcome.err.count("\n")) == (2, 1)
    assert outcome.err.startswith("error: office")
    with pytest.raises(DataError, match="school"):
        measure_types(folders[:1])
    with pytest.raises(OptionError, match="folder"):
        measure_types([Path("/")])
    with pytest.raises(OptionError, match="folder"):
        measure_types([tmp_path / "nothing"])
    (tiny / "buildings" / "office" / "office0.xml").unlink()
    with pytest.raises(DataError, match="office"):
        measure(tiny)


def test_types_that_cannot_be_compared_are_one_line(folders):
    """One type alone; labels of another schema; one building."""
    (folders[1] / "office2.xml").write_text(write_labelled("school", stretch=1))
    for number in (1, 2):
        (folders[2] / f"house{number}.xml").unlink()
    for chosen, message in (
        (folders[:1], "all buildings are of type 'school', give folders of two types"),
        (folders[:2], "CLASSROOM"),
        (folders[::2], "house has 1 building, give 3"),
    ):
        arguments = [argument for folder in chosen for argument in ("--types", folder)]
        outcome = run_pianta("bench", "buildings", *arguments)
        assert (outcome.code, outcome.out, outcome.err.count("\n")) == (2, "", 1)
        assert message in outcome.err


@pytest.mark.slow
def test_floors_of_one_building_stay_together(folders):
    """hall-1 and hall-2 are one building; school0 … school2 would all be one, so each becomes a building."""
    for number in (1, 2):
        (folders[1] / f"hall-{number}.xml").write_text(write_labelled("office", stretch=2 + number / 10))
    (folders[1] / "tower.xml").write_text(write_labelled("office", stretch=3))
    floors, _ = read_type_folders(folders, convention=LabelConvention.EXPERIMENTS)
    buildings = [floor.annotated.building for floor in floors]
    assert buildings[:3] == ["school/school0", "school/school1", "school/school2"]
    assert buildings[3:9] == ["office/hall"] * 2 + ["office/office"] * 3 + ["office/tower"]


@pytest.mark.slow
def test_a_subfolder_is_a_building(folders):
    """Floors with one name in two folders are of two buildings; floors with two names in one folder are of one."""
    for building in ("a", "b", "c"):
        (folders[1] / building).mkdir()
        for number, name in enumerate(("first", "ground")):
            (folders[1] / building / f"{name}.xml").write_text(write_labelled("office", stretch=2 + number / 10))
    floors, _ = read_type_folders(folders[:2], convention=LabelConvention.EXPERIMENTS)
    named = {floor.annotated.item: floor.annotated.building for floor in floors if floor.annotated.kind == "office"}
    assert named == {f"office{number}": "office/office" for number in range(3)} | {
        f"{building}/{name}": f"office/{building}" for building in "abc" for name in ("first", "ground")
    }


def test_floors_of_a_subfolder_are_not_divided(folders):
    (folders[1] / "hall").mkdir()
    for number in range(3):
        (folders[1] / f"office{number}.xml").rename(folders[1] / "hall" / f"{number}.xml")
    with pytest.raises(DataError, match="office"):
        read_type_folders(folders[:2], convention=LabelConvention.EXPERIMENTS)


@pytest.mark.slow
def test_files_may_have_their_own_type(folders):
    """An office in the folder of the schools is an office."""
    office = write_labelled("office", stretch=1.5)
    office = office.replace("<building>", "<building><building_type><main_type>OFFICE</main_type></building_type>")
    (folders[0] / "office3.xml").write_text(office)
    floors, _ = read_type_folders(folders[:2], convention=LabelConvention.EXPERIMENTS)
    assert [floor.annotated.kind for floor in floors if floor.annotated.item == "office3"] == ["office"]
    # The schema of the folder decides the type.
    save_label_schema(LabelSchema("tower", SCHEMAS["office"].labels), folders[1] / "labels.yaml")
    (folders[0] / "office3.xml").rename(folders[1] / "office3.xml")
    floors, _ = read_type_folders(folders[:2], convention=LabelConvention.EXPERIMENTS)
    assert [floor.annotated.kind for floor in floors] == ["school"] * 3 + ["tower"] * 4
    for number in range(3):
        (folders[0] / f"school{number}.xml").write_text("<building/>")
    with pytest.raises(DataError, match="school"):
        read_type_folders(folders[:2], convention=LabelConvention.EXPERIMENTS)


def test_a_bad_schema_is_refused(folders):
    (folders[2] / "labels.yaml").write_text("building_type: [")
    with pytest.raises(LabelError):
        measure_types(folders)


def test_options_without_meaning_are_refused(tiny, folders, tmp_path):
    outcome = run_pianta("bench", "buildings", "--data", tiny, "--split", "graphs")
    assert (outcome.code, outcome.err.count("\n")) == (2, 1)
    assert "graphs" in outcome.err
    outcome = run_pianta("bench", "buildings", "--types", folders[0], "--pictures", tmp_path / "p")
    assert outcome.code == 2
    assert "--types" in outcome.err


@pytest.mark.slow
def test_rooms_of_the_real_offices(data):
    """Rooms of the offices by the relational kernel, at least as good as kLog."""
    floors, failed = read_building_floors(data, convention=LabelConvention.EXPERIMENTS)
    assert failed == []
    assert len(floors) == 43
    offices = [floor for floor in floors if floor.annotated.kind == "office"]
    scores = Scores(offices)
    for label_set, decisions in classify_rooms_by_relations(offices).items():
        scores.rooms[KLOG, label_set] = dict(enumerate(decisions))
    errors = [
        np.concatenate([scores.wrong_rooms(index, KLOG, label_set) for index in range(len(offices))]).mean()
        for label_set in (R_C, F_C_E_S)
    ]
    assert errors[0] < 0.0773
    assert errors[1] < 0.4492
