"""Whether simulated offices are distinguished from real ones, and how typical floors are of real offices alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from pianta.errors import DataError
from pianta.floor import Floor
from pianta.labels import SCHEMAS, LabelSet
from pianta.realism.model import MAX_ATYPICAL, MIN_BUILDINGS, MIN_UNREALISTIC_BUILDINGS, Realism, RealismModel
from pianta.rooms.completion import LABELS, fill_missing_labels, map_labels_upwards
from pianta_bench.data.annotated_floors import AnnotatedFloor, read_annotated_buildings, set_building_type
from pianta_bench.data.folders import find_data
from pianta_bench.harness.records import Item, Results, Track
from pianta_bench.places.models import CENTRAL, LOCAL, PIANTA, TREES
from pianta_bench.realism.models import GAUSSIAN, KLOG, SCORERS, describe_annotated, score_left_out
from pianta_bench.realism.views import view_floor

OFFICES = "offices"
WORLDS = "worlds"
SCHOOLS = "schools"
# By part: the folder of data/buildings, and the building type whose labels its rooms have.
SOURCES = MappingProxyType(
    {OFFICES: ("office", "office"), WORLDS: ("robocup", "office"), SCHOOLS: ("school", "school")}
)
COMPARED = (OFFICES, WORLDS)
TWO = f"{PIANTA}, two classes"
ONE = f"{PIANTA}, one class"
MODELS = (LOCAL, CENTRAL, KLOG, GAUSSIAN, TWO, ONE)
# A floor is called realistic from this score on, by ONE only above it. KLOG gives decision values, the others shares.
THRESHOLDS: Mapping[str, float] = MappingProxyType(
    {LOCAL: 0.5, CENTRAL: 0.5, KLOG: 0.0, GAUSSIAN: 0.5, TWO: 0.5, ONE: MAX_ATYPICAL}
)
# Least buildings of a part: those that a model needs, and the one that is left out.
MIN_PART_BUILDINGS: Mapping[str, int] = MappingProxyType(
    {OFFICES: MIN_BUILDINGS + 1, WORLDS: MIN_UNREALISTIC_BUILDINGS + 1}
)


@dataclass(frozen=True, eq=False)
class AssessedFloor:
    """A floor, and its assessment by models that were not trained on its building.

    annotated: with labels in R/C and F/C/E/S. part: OFFICES, WORLDS or SCHOOLS.
    scores: by model and label set; realistic floors have higher ones. SCHOOLS have only those of ONE.
    realism: by label set. views: the same by view (see `view_floor`) and label set.
    """

    annotated: AnnotatedFloor
    part: str
    scores: dict[tuple[str, LabelSet], float] = field(default_factory=dict)
    realism: dict[LabelSet, Realism] = field(default_factory=dict)
    views: dict[tuple[str, LabelSet], Realism] = field(default_factory=dict)


def measure(data: Path | None = None, *, seed: int = 0, trees: int = TREES, track: Track = iter) -> Results:
    """Assess the floors of data/buildings/office and data/buildings/robocup, each without its building.

    The schools of the data, when there are any, are assessed by the offices alone.
    A floor that cannot be read or has unknown labels does not count. seed, trees: of Extra-Trees. track: wraps the
    names of models and label sets, to show progress.
    Raises DataError for fewer buildings than MIN_PART_BUILDINGS.
    """
    folder = find_data(data)
    results = Results({"seed": seed, "trees": trees})
    floors: list[AssessedFloor] = []
    for part in SOURCES:
        read, failed = _read_part(folder, part)
        floors += [AssessedFloor(floor, part) for floor in read]
        results.items += [Item(part, floor.item) for floor in read] + failed
    for part in COMPARED:
        _check_buildings(part, [floor.annotated for floor in floors if floor.part == part])
    _assess_all(floors, seed, trees, track)
    for floor in floors:
        results.add(floor.part, floor.annotated.item, dict(floor.scores), names=("model", "label_set"), metric="score")
        likeness = {label_set: realism.likeness for label_set, realism in floor.realism.items()}
        results.add(floor.part, floor.annotated.item, likeness, names=("label_set",), metric="likeness")
    results.details["floors"] = [
        {"part": floor.part, "item": floor.annotated.item, "label_set": str(label_set), **realism.as_json()}
        for floor in floors
        for label_set, realism in floor.realism.items()
    ]
    results.objects["floors"] = floors
    return results


def is_realistic(model: str, score: float) -> bool:
    """Whether a score means a realistic floor; 0.5 of two classes does, as in `Realism.verdict`."""
    return score > THRESHOLDS[model] if model == ONE else score >= THRESHOLDS[model]


def _check_buildings(part: str, floors: Sequence[AnnotatedFloor]) -> None:
    """Raise DataError if the floors of a part are of too few buildings."""
    count = len({floor.building for floor in floors})
    if count < MIN_PART_BUILDINGS[part]:
        raise DataError(
            f"{len(floors)} {part} of {count} building{'s' * (count != 1)} could be read, "
            f"give {MIN_PART_BUILDINGS[part]} buildings at least"
        )


def _read_part(data: Path, part: str) -> tuple[list[AnnotatedFloor], list[Item]]:
    """The floors of a part with labels in both sets, and those that failed; no schools if there is no folder."""
    folder, building_type = SOURCES[part]

    def give_labels(annotated: AnnotatedFloor) -> AnnotatedFloor:
        floor = map_labels_upwards(set_building_type(annotated.floor, building_type), SCHEMAS[building_type])
        return replace(annotated, floor=replace(floor, source=annotated.item))

    if part not in COMPARED and not (data / "buildings" / folder).is_dir():
        return [], []
    floors, failed = read_annotated_buildings(data, folder, give_labels)
    return floors, [Item(part, row.item, row.failure) for row in failed]


def _assess_all(floors: Sequence[AssessedFloor], seed: int, trees: int, track: Track) -> None:
    """Add the scores of all models, and the assessments of pianta's model, to the floors."""
    compared = [floor for floor in floors if floor.part in COMPARED]
    annotated = [floor.annotated for floor in compared]
    real = np.array([floor.part == OFFICES for floor in compared])
    trials = [(model, label_set) for label_set in LABELS for model in (*SCORERS, PIANTA)]
    tracked = iter(track(["maps", *(f"{model}, {label_set}" for model, label_set in trials)]))
    next(tracked)
    views = [view_floor(floor, seed=seed) for floor in annotated]
    for (model, label_set), _ in zip(trials, tracked, strict=True):
        if model in SCORERS:
            scores = score_left_out(model, annotated, real, label_set, seed=seed, trees=trees)
            for floor, score in zip(compared, scores, strict=True):
                floor.scores[model, label_set] = score
            continue
        _assess_left_out(floors, views, label_set)
        for floor in floors:
            realism = floor.realism[label_set]
            floor.scores[ONE, label_set] = realism.typicality
            if realism.probability is not None:
                floor.scores[TWO, label_set] = realism.probability


def _assess_left_out(
    floors: Sequence[AssessedFloor], views: Sequence[Mapping[str, Floor]], label_set: LabelSet
) -> None:
    """Add pianta's assessment of each floor and its views, by one class and by two; schools by one class only."""
    offices, worlds = ([floor.annotated for floor in floors if floor.part == part] for part in COMPARED)
    model = RealismModel(
        tuple(describe_annotated(floor, label_set) for floor in offices),
        tuple(floor.building for floor in offices),
        label_set,
        tuple(describe_annotated(floor, label_set) for floor in worlds),
        tuple(floor.building for floor in worlds),
    )
    compared = [floor for floor in floors if floor.part in COMPARED]
    for floor, floor_views in zip(compared, views, strict=True):
        others = model.leave_out(floor.annotated.building)
        floor.realism[label_set] = others.assess(floor.annotated.floor)
        for view, viewed in floor_views.items():
            floor.views[view, label_set] = others.assess(fill_missing_labels(viewed, label_set).floor)
    one_class = replace(model, unrealistic_floors=(), unrealistic_buildings=())
    for floor in floors:
        if floor.part == SCHOOLS:
            floor.realism[label_set] = one_class.assess(floor.annotated.floor)


def list_scores(results: Results, model: str, label_set: LabelSet, part: str) -> NDArray[np.float64]:
    """Scores of the floors of a part by a model; real floors have higher ones."""
    return np.array(results.values(metric="score", model=model, label_set=label_set, part=part))
