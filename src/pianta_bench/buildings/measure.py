"""Reasoning on the building structure: Table 6.1, with whole buildings left out (thesis, section 6.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from itertools import product
from pathlib import Path

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.labels import LabelConvention, LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.buildings.fact_files import FACT_TASK, FactScores, list_fact_steps, read_fact_floors
from pianta_bench.buildings.floors import BuildingFloor, read_building_floors, read_type_folders
from pianta_bench.buildings.models import (
    KLOG,
    FloorScores,
    Folds,
    Outcomes,
    classify_floors_by_pianta,
    classify_floors_by_relations,
    classify_floors_by_trees,
    classify_rooms_by_pianta,
    classify_rooms_by_relations,
    classify_rooms_by_trees,
    compare_floors,
    list_buildings,
    list_types,
)
from pianta_bench.buildings.scores import BUILDING, DIGITS, FLOOR, Scores
from pianta_bench.data.folders import find_data
from pianta_bench.harness.folds import list_folds
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Item, Results, Track
from pianta_bench.harness.timing import measure_time
from pianta_bench.places.models import COLUMNS, PIANTA, PreparedFloor, check_convention

TREES = 100  # of each forest; 500 in section 6.2, which take five times as long
MAX_FLOOR_FOLDS = 44  # the 43 floors of the data are left out one by one, of more floors some are left out together
# The tasks: rooms; floors with whole buildings left out; floors with one floor left out.
ROOM_TASK = "places"
BUILDING_TASK = "buildings"
FLOOR_TASK = "buildings, one floor left out"
TASKS = {BUILDING: BUILDING_TASK, FLOOR: FLOOR_TASK}
SECONDS = "processor seconds"  # part of the records with times; their metric is the task
WRONG_ROOMS = "wrong rooms, %"
WRONG_TYPE = "wrong type"


def measure(
    data: Path | None = None,
    *,
    types: Sequence[Path] | None = None,
    convention: str = LabelConvention.EXPERIMENTS,
    trees: int = TREES,
    seed: int = 0,
    jobs: int | None = None,
    pictures: Path | None = None,
    track: Track = iter,
) -> Results:
    """Classify the rooms and the floors of data/buildings by models that were not trained on the building.

    Records of each floor: wrong rooms in %, and whether its type is wrong, by model and label set. If manifest.json of
    the data has several floors of one building, they are left out together. The floors of data/klog are classified as
    well if they are there.
    types: folders of buildings of one type each, instead of data; then only the floors are classified, as section
    6.2.2 does with three types of MIT.
    convention: EXPERIMENTS or FIGURE, by which labels become R/C and F/C/E/S. trees: of each forest of Extra-Trees.
    jobs: number of processes, None for one for each core; figures do not depend on it.
    track: wraps the steps, to show progress.
    Raises OptionError for another convention and for pictures of types, and the errors of read_building_floors,
    read_type_folders and read_fact_floors.
    """
    labels = check_convention(convention)
    if types and pictures:
        raise OptionError("--pictures are of the thesis' two types, leave it out with --types")
    read = partial(read_type_folders, types) if types else partial(read_building_floors, find_data(data))
    floors, failed = read(convention=labels)
    results = Results(options={"convention": str(labels), "trees": trees, "seed": seed}, items=failed)
    scores = Scores(floors)
    facts = FactScores([] if types else read_fact_floors(find_data(data)))
    steps = {} if types else dict(_list_room_steps(floors, labels, trees, seed))
    steps |= dict(_list_floor_steps(floors, trees, seed, one_floor=not types)) | dict(list_fact_steps(facts.floors))
    for outcomes in run_steps(steps, jobs=jobs, track=track):
        for task, model, seconds, values in outcomes:
            results.add(SECONDS, model, {task: seconds})
            for key, value in values.items():
                if task == FACT_TASK:
                    facts.types[key] = value
                elif task == ROOM_TASK:
                    scores.rooms.setdefault(key, {}).update(value)
                else:
                    scores.types[key] = value
    list_errors(results, scores)
    results.objects |= {"scores": scores, "facts": facts, "is_table_6_1": not types}
    results.details["floors"] = scores.as_json()
    results.details["fact_files"] = facts.as_json()
    results.details["curves"] = [
        {**asdict(curve), "part": part, "model": model, "curve": name, "x": x.tolist(), "y": y.tolist()}
        for part, model, name, curve in ([] if types else scores.measure_curves())
        for x, y in [(curve.x.round(DIGITS), curve.y.round(DIGITS))]
    ]
    return results


def _list_room_steps(
    floors: Sequence[BuildingFloor], convention: LabelConvention, trees: int, seed: int
) -> Iterator[tuple[str, Callable[[], Outcomes]]]:
    """The steps that classify rooms: by trees and relations for each type, by pianta for each fold."""
    for name in list_types(floors):
        indices = [index for index, floor in enumerate(floors) if floor.annotated.kind == name]
        typed_floors = [floors[index] for index in indices]
        classify = {KLOG: partial(classify_rooms_by_relations, typed_floors)}
        for model in COLUMNS:
            classify[model] = partial(classify_rooms_by_trees, typed_floors, model=model, trees=trees, seed=seed)
        yield from (
            (f"places, {name}s, {model}", partial(_score_rooms, model, indices, classify[model])) for model in classify
        )
    prepared = [PreparedFloor.prepare(floor.annotated, convention) for floor in floors]
    for others, held_out in list_folds(list_buildings(floors)):
        training, rest = ([prepared[i] for i in chosen] for chosen in (others, held_out))
        classify_rest = partial(classify_rooms_by_pianta, training, rest, convention=convention, seed=seed)
        names = ", ".join(sorted({floors[i].annotated.building for i in held_out}))
        yield f"places, {PIANTA} without {names}", partial(_score_rooms, PIANTA, held_out.tolist(), classify_rest)


def _list_floor_steps(
    floors: Sequence[BuildingFloor], trees: int, seed: int, *, one_floor: bool
) -> Iterator[tuple[str, Callable[[], Outcomes]]]:
    """The steps that classify floors, with whole buildings left out and, on demand, with one floor left out."""
    folds = {BUILDING: list_folds(list_buildings(floors))}
    if one_floor:
        folds[FLOOR] = list_folds([f"{index:06}" for index in range(len(floors))], most=MAX_FLOOR_FOLDS)
    for label_set in LABELS:
        yield f"buildings, {KLOG}, {label_set}", partial(_score_floors_by_relations, floors, folds, label_set)
    for (left_out, task_folds), label_set in product(folds.items(), LABELS):
        classify = {PIANTA: partial(classify_floors_by_pianta, floors, task_folds, label_set)}
        for model in COLUMNS:
            classify[model] = partial(
                classify_floors_by_trees, floors, task_folds, label_set, model=model, trees=trees, seed=seed
            )
        for model, classify_floors in classify.items():
            key = left_out, model, label_set
            yield f"buildings, {', '.join(key)} left out", partial(_score_floors, key, classify_floors)


def _score_rooms(
    model: str, indices: Sequence[int], classify: Callable[[], Mapping[LabelSet, Sequence[Floats]]]
) -> Outcomes:
    seconds, by_set = measure_time(classify)
    scores = {(model, label_set): dict(zip(indices, each, strict=True)) for label_set, each in by_set.items()}
    return [(ROOM_TASK, model, seconds, scores)]


def _score_floors(key: tuple[str, str, LabelSet], classify: Callable[[], FloorScores]) -> Outcomes:
    left_out, model, _ = key
    seconds, scores = measure_time(classify)
    return [(TASKS[left_out], model, seconds, {key: scores})]


def _score_floors_by_relations(
    floors: Sequence[BuildingFloor], folds: Mapping[str, Folds], label_set: LabelSet
) -> Outcomes:
    """All folds in one step, as they share the Gram matrices."""
    compare = compare_floors(floors, label_set)
    outcomes: Outcomes = []
    for left_out, task_folds in folds.items():
        classify = partial(classify_floors_by_relations, floors, task_folds, compare)
        outcomes += _score_floors((left_out, KLOG, label_set), classify)
    return outcomes


def list_errors(results: Results, scores: Scores) -> None:
    """Add the items and the records of all floors."""
    for index, floor in enumerate(scores.floors):
        part, item = f"{floor.annotated.kind}s", floor.annotated.item
        results.items.append(Item(part, item))
        for model, label_set in scores.rooms:
            share = 100 * float(scores.wrong_rooms(index, model, label_set).mean())
            results.add(part, item, {WRONG_ROOMS: share}, model=model, labels=label_set)
        for left_out, model, label_set in scores.types:
            is_wrong = float(scores.wrong_floors(left_out, model, label_set)[index])
            results.add(part, item, {WRONG_TYPE: is_wrong}, model=model, labels=label_set, left_out=left_out)
