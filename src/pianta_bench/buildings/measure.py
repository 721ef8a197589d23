"""Reasoning on the building structure: Table 6.1 as a whole, with whole buildings left out (thesis, section 6.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

from pianta.errors import OptionError
from pianta.labels import LabelConvention, LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.buildings.floors import BuildingFloor, read_building_floors, read_type_folders
from pianta_bench.buildings.models import (
    KLOG,
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
from pianta_bench.places.models import COLUMNS, PIANTA, DescribedFloor, PreparedFloor, check_convention, list_examples

TREES = 100  # of each forest; 500 in section 6.2, which take five times as long
MAX_FLOOR_FOLDS = 44  # the 43 floors of the data are left out one by one, of more some together
PLACES, BUILDINGS, FLOORS = "places", "buildings", "buildings, one floor left out"
TASKS = {BUILDING: BUILDINGS, FLOOR: FLOORS}
SECONDS = "processor seconds"  # part of the records with times; their metric is the task
WRONG_ROOMS, WRONG_TYPE = "wrong rooms, %", "wrong type"

# What a step returns: task, model, seconds, and scores by their keys in Scores.rooms, .types and .typical.
Outcome = tuple[str, str, float, Mapping[str, Mapping[Any, Any]]]


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
    the data has several floors of one building, they are left out together.
    types: folders of buildings of one type each, in place of data; only the floors are classified then, as section
    6.2.2 does with three types of MIT.
    convention: EXPERIMENTS or FIGURE, by which labels become R/C and F/C/E/S. trees: of each forest of Extra-Trees.
    jobs: number of processes, None for one for each core; figures do not depend on it.
    track: wraps the steps, to show progress.
    Raises OptionError for another convention and for pictures of types, and what read_building_floors and
    read_type_folders raise.
    """
    labels = check_convention(convention)
    if types and pictures:
        raise OptionError("--pictures are of the thesis' two types, leave it out with --types")
    read = partial(read_type_folders, types) if types else partial(read_building_floors, find_data(data))
    floors, failed = read(convention=labels)
    results = Results(options={"convention": str(labels), "trees": trees, "seed": seed}, items=failed)
    scores = Scores(floors)
    steps = dict(_list_floor_steps(floors, trees, seed, one_floor=not types))
    if not types:
        steps = {**dict(_list_room_steps(floors, labels, trees, seed)), **steps}
    for outcomes in run_steps(steps, jobs=jobs, track=track):
        for task, model, seconds, step_scores in outcomes:
            results.add(SECONDS, model, {task: seconds})
            for key, by_floor in step_scores.get("rooms", {}).items():
                scores.rooms.setdefault(key, {}).update(by_floor)
            scores.types.update(step_scores.get("types", {}))
            scores.typical.update(step_scores.get("typical", {}))
    list_errors(results, scores)
    results.objects |= {"scores": scores, "of_thesis": not types}
    results.details["floors"] = scores.as_json()
    results.details["curves"] = [
        {"part": part, "model": model, "curve": name, **asdict(curve)}
        | {"x": curve.x.round(DIGITS).tolist(), "y": curve.y.round(DIGITS).tolist()}
        for part, model, name, curve in ([] if types else scores.measure_curves())
    ]
    return results


def _list_room_steps(
    floors: Sequence[BuildingFloor], convention: LabelConvention, trees: int, seed: int
) -> Iterator[tuple[str, Callable[[], list[Outcome]]]]:
    """The steps that classify rooms: by trees and relations for each type, by pianta for each fold."""
    for name in list_types(floors):
        indices = [index for index, floor in enumerate(floors) if floor.annotated.kind == name]
        of_type = [floors[index] for index in indices]
        yield f"places, {name}s, {KLOG}", partial(_score_rooms_by_relations, of_type, indices)
        for model in COLUMNS:
            step = partial(_score_rooms_by_trees, of_type, indices, model=model, trees=trees, seed=seed)
            yield f"places, {name}s, {model}", step
    prepared = [
        PreparedFloor(each, DescribedFloor.describe(each.floor), list_examples([each.floor], convention=convention))
        for each in (floor.annotated for floor in floors)
    ]
    for training, held_out in list_folds(list_buildings(floors)):
        step = partial(
            _score_rooms_by_pianta, [prepared[i] for i in training], [prepared[i] for i in held_out], held_out.tolist()
        )
        names = sorted({floors[i].annotated.building for i in held_out})
        yield f"places, {PIANTA} without {', '.join(names)}", partial(step, convention=convention, seed=seed)


def _list_floor_steps(
    floors: Sequence[BuildingFloor], trees: int, seed: int, *, one_floor: bool
) -> Iterator[tuple[str, Callable[[], list[Outcome]]]]:
    """The steps that classify floors, with whole buildings left out and, on demand, with one floor left out."""
    folds = {BUILDING: list_folds(list_buildings(floors))}
    if one_floor:
        folds[FLOOR] = list_folds([f"{index:06}" for index in range(len(floors))], most=MAX_FLOOR_FOLDS)
    for label_set in LABELS:
        yield f"buildings, {KLOG}, {label_set}", partial(_score_floors_by_relations, floors, folds, label_set)
        for model, left_out in product((*COLUMNS, PIANTA), folds):
            score = partial(_score_floors, floors, folds[left_out], left_out, label_set, model)
            yield f"buildings, {model}, {label_set}, {left_out} left out", partial(score, trees=trees, seed=seed)


def _score_rooms_by_trees(
    floors: Sequence[BuildingFloor], indices: Sequence[int], *, model: str, trees: int, seed: int
) -> list[Outcome]:
    outcomes: list[Outcome] = []
    for label_set in LABELS:
        classify = partial(classify_rooms_by_trees, floors, label_set, model=model, trees=trees, seed=seed)
        seconds, probabilities = measure_time(classify)
        by_floor = dict(zip(indices, probabilities, strict=True))
        outcomes.append((PLACES, model, seconds, {"rooms": {(model, label_set): by_floor}}))
    return outcomes


def _score_rooms_by_relations(floors: Sequence[BuildingFloor], indices: Sequence[int]) -> list[Outcome]:
    seconds, decisions = measure_time(partial(classify_rooms_by_relations, floors))
    rooms = {(KLOG, label_set): dict(zip(indices, each, strict=True)) for label_set, each in decisions.items()}
    return [(PLACES, KLOG, seconds, {"rooms": rooms})]


def _score_rooms_by_pianta(
    training: Sequence[PreparedFloor],
    held_out: Sequence[PreparedFloor],
    indices: Sequence[int],
    *,
    convention: LabelConvention,
    seed: int,
) -> list[Outcome]:
    classify = partial(classify_rooms_by_pianta, training, held_out, convention=convention, seed=seed)
    seconds, by_floor = measure_time(classify)
    rooms = {
        (PIANTA, label_set): {index: each[label_set] for index, each in zip(indices, by_floor, strict=True)}
        for label_set in LABELS
    }
    return [(PLACES, PIANTA, seconds, {"rooms": rooms})]


def _score_floors_by_relations(
    floors: Sequence[BuildingFloor], folds: Mapping[str, Any], label_set: LabelSet
) -> list[Outcome]:
    """All folds in one step, as they share the Gram matrices."""
    outcomes: list[Outcome] = []
    compare = compare_floors(floors, label_set)
    for left_out, of_task in folds.items():
        seconds, decisions = measure_time(partial(classify_floors_by_relations, floors, of_task, compare))
        outcomes.append((TASKS[left_out], KLOG, seconds, {"types": {(left_out, KLOG, label_set): decisions}}))
    return outcomes


def _score_floors(
    floors: Sequence[BuildingFloor],
    folds: Any,
    left_out: str,
    label_set: LabelSet,
    model: str,
    *,
    trees: int,
    seed: int,
) -> list[Outcome]:
    scores: dict[str, Mapping[Any, Any]] = {}
    if model == PIANTA:
        seconds, (types, typical) = measure_time(partial(classify_floors_by_pianta, floors, folds, label_set))
        scores["typical"] = {(left_out, label_set): typical}
    else:
        classify = partial(classify_floors_by_trees, floors, folds, label_set, model=model, trees=trees, seed=seed)
        seconds, types = measure_time(classify)
    scores["types"] = {(left_out, model, label_set): types}
    return [(TASKS[left_out], model, seconds, scores)]


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
