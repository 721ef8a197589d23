"""What the relations `aligned` and `symmetric` add to the classification of rooms and of buildings.

Run: OMP_NUM_THREADS=1 python benchmarks/compare_room_relations.py [--data DIR] [--part rooms|trees|floors] ...
    [--variant "and symmetric"] ...

Models learn on the schools and offices of the data, with whole buildings left out as in `pianta bench buildings`:
the relational kernel with the facts of the relations beside those of Table 6.1, and Extra-Trees on V_n with, for each
relation, the share of the other rooms that have it to a room and whether any has. Nothing was chosen on these figures.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import fmean, stdev

import numpy as np

from pianta._types import Floats
from pianta.floor import Floor
from pianta.labels import LabelConvention, LabelSet
from pianta.relational.interpretation import ALIGNED, SYMMETRIC, Relation, interpret_floor
from pianta.relational.kernels import ROOM_RELATIONS
from pianta.rooms.completion import LABELS
from pianta_bench.buildings import models
from pianta_bench.buildings.floors import BuildingFloor, read_building_floors
from pianta_bench.data.folders import find_data
from pianta_bench.harness.folds import list_folds

VARIANTS: Mapping[str, tuple[Relation, ...]] = {
    "Table 6.1": (),
    "and aligned": (ALIGNED,),
    "and symmetric": (SYMMETRIC,),
    "and both": (ALIGNED, SYMMETRIC),
}
PARTS = ("trees", "rooms", "floors")
TREES = 100  # of each forest, as in bench buildings
SEEDS = range(3)  # of forests; their scores are averaged


@dataclass(frozen=True, eq=False)
class FeaturedFloor:
    """A floor for the forests of bench buildings; features: of its rooms, shape (rooms, features)."""

    floor: Floor
    kind: str
    building: str
    features: Floats


def add_facts(floor: BuildingFloor, relations: Sequence[Relation]) -> BuildingFloor:
    """The floor with the facts of more relations."""
    annotated = floor.annotated
    facts = interpret_floor(
        annotated.unlabelled, relations=(*ROOM_RELATIONS, *relations), label_set=None, name=annotated.item
    )
    return replace(floor, facts=facts)


def add_features(floor: BuildingFloor, relations: Sequence[Relation]) -> BuildingFloor:
    """The floor with the features of more relations behind V_n."""
    annotated = floor.annotated
    rooms = [room.id for room in annotated.floor.rooms]
    columns = [annotated.features]
    for relation in relations:
        counts = dict.fromkeys(rooms, 0)
        for pair in relation.find(annotated.unlabelled):
            for room in pair:
                counts[room] += 1
        related = np.array([counts[room] for room in rooms], float)
        columns += [(related / max(len(rooms) - 1, 1))[:, None], (related > 0)[:, None]]
    featured = FeaturedFloor(annotated.floor, annotated.kind, annotated.building, np.hstack(columns))
    return replace(floor, annotated=featured)


def count_wrong_rooms(
    floors: Sequence[BuildingFloor], scores: Mapping[LabelSet, Sequence[Floats]]
) -> dict[LabelSet, list[float]]:
    """By label set the share of wrong rooms of each floor, %."""
    wrong = {}
    for label_set, labels in LABELS.items():
        truth = [[labels.index(label) for label in floor.labels[label_set]] for floor in floors]
        wrong[label_set] = [
            100 * float(np.mean(values.argmax(axis=1) != true))
            for values, true in zip(scores[label_set], truth, strict=True)
        ]
    return wrong


def print_rooms(
    part: str,
    variants: Sequence[str],
    floors: Sequence[BuildingFloor],
    classify: Callable[[list[BuildingFloor]], Mapping[LabelSet, list[float]]],
) -> None:
    """Print a line for each type and variant: wrong rooms in %, mean ± sd over floors."""
    for building_type in models.list_types(floors):
        typed = [floor for floor in floors if floor.annotated.kind == building_type]
        for variant in variants:
            relations = VARIANTS[variant]
            start = time.process_time()
            prepare = add_facts if part == "rooms" else add_features
            wrong = classify([prepare(floor, relations) for floor in typed])
            cells = [f"{name} {fmean(values):6.2f} ± {stdev(values):5.2f}" for name, values in wrong.items()]
            seconds = f"{time.process_time() - start:.0f} s"
            print(f"{part:6} {building_type:7} {variant:14} {'   '.join(cells)}   {seconds}", flush=True)


def classify_by_trees(floors: list[BuildingFloor]) -> dict[LabelSet, list[float]]:
    """Wrong rooms of Extra-Trees on all features, the mean over SEEDS."""
    models.COLUMNS = {"all": slice(None)}
    runs = [
        count_wrong_rooms(floors, models.classify_rooms_by_trees(floors, model="all", trees=TREES, seed=seed))
        for seed in SEEDS
    ]
    return {label_set: np.mean([run[label_set] for run in runs], axis=0).tolist() for label_set in LABELS}


def classify_by_relations(floors: list[BuildingFloor]) -> dict[LabelSet, list[float]]:
    """Wrong rooms of the relational kernel."""
    return count_wrong_rooms(floors, models.classify_rooms_by_relations(floors))


def print_floors(floors: Sequence[BuildingFloor], variants: Sequence[str]) -> None:
    """Print for each variant and label set the wrong types of floors by the relational kernel."""
    types = models.list_types(floors)
    truth = np.array([types.index(floor.annotated.kind) for floor in floors])
    folds = list_folds(models.list_buildings(floors))
    for variant in variants:
        related = [add_facts(floor, VARIANTS[variant]) for floor in floors]
        for label_set in LABELS:
            compare = models.compare_floors(related, label_set)
            scores = models.classify_floors_by_relations(related, folds, compare)
            wrong = int((scores.values.argmax(axis=1) != truth).sum())
            print(f"floors {variant:14} {label_set:8} {wrong} of {len(floors)} wrong", flush=True)


def main() -> None:
    """Print all tables that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--part", action="append", choices=PARTS)
    parser.add_argument("--variant", action="append", choices=[*VARIANTS])
    arguments = parser.parse_args()
    floors, _ = read_building_floors(find_data(arguments.data), convention=LabelConvention.EXPERIMENTS)
    parts, variants = arguments.part or PARTS, arguments.variant or [*VARIANTS]
    if "trees" in parts:
        print_rooms("trees", variants, floors, classify_by_trees)
    if "rooms" in parts:
        print_rooms("rooms", variants, floors, classify_by_relations)
    if "floors" in parts:
        print_floors(floors, variants)


if __name__ == "__main__":
    main()
