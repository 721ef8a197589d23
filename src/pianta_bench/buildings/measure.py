"""Reasoning on the building structure: Table 6.1 as a whole, with whole buildings left out (thesis, section 6.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import product
from pathlib import Path
from time import process_time

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.labels import LabelConvention, LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.buildings.floors import BuildingFloor, Failed, read_building_floors, read_type_folders
from pianta_bench.buildings.models import (
    COLUMNS,
    KLOG,
    compare_floors,
    judge_buildings_by_pianta,
    judge_buildings_by_relations,
    judge_buildings_by_trees,
    judge_places_by_pianta,
    judge_places_by_relations,
    judge_places_by_trees,
    list_folds,
    list_types,
)
from pianta_bench.places.models import PIANTA

# Section 6.2 takes 500; a fifth of them takes a fifth of the time.
TREES = 100
# What is left out of the training: the building, or only the floor, as in the thesis.
BUILDING, FLOOR = "building", "floor"
PLACES, BUILDINGS, FLOORS = "places", "buildings", "buildings, one floor left out"
TASK_OF = {BUILDING: BUILDINGS, FLOOR: FLOORS}


@dataclass(eq=False)
class BuildingsBench:
    """What was measured.

    floors: those that were judged. failed: those that could not be, and why.
    places: by model and label set, of each floor its rooms' scores, shape (rooms, labels); empty for floors of folders.
    types: by what was left out, model and label set, the floors' scores, shape (floors, types).
    typical: by what was left out and label set, whether pianta's model finds a floor like those that it knows.
    seconds: of the processor, by task and model. The highest score decides.
    """

    split: LabelConvention
    seed: int
    trees: int
    floors: Sequence[BuildingFloor]
    failed: Failed
    of_thesis: bool
    places: dict[tuple[str, LabelSet], list[Floats]] = field(default_factory=dict)
    types: dict[tuple[str, str, LabelSet], Floats] = field(default_factory=dict)
    typical: dict[tuple[str, LabelSet], NDArray[np.bool_]] = field(default_factory=dict)
    seconds: dict[tuple[str, str], float] = field(default_factory=dict)

    @property
    def building_types(self) -> list[str]:
        """The types, in the order of their scores."""
        return list_types(self.floors)

    def places_of(self, kind: str) -> list[int]:
        """The places of the floors of a type."""
        return [place for place, floor in enumerate(self.floors) if floor.drawn.kind == kind]

    @contextmanager
    def timed(self, task: str, model: str) -> Iterator[None]:
        """Add the processor time of what is done within to that of a model's task."""
        start = process_time()
        yield
        self.seconds[task, model] = self.seconds.get((task, model), 0.0) + process_time() - start


def measure_buildings(
    data: Path,
    *,
    split: LabelConvention = LabelConvention.EXPERIMENTS,
    trees: int = TREES,
    seed: int = 0,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> BuildingsBench:
    """Classify the places and the buildings of data/buildings by models that have not seen the building.

    A floor that fails does not count; Row.failure has the reason. Where manifest.json of the data says that floors are
    of one building, they are left out together.
    split: EXPERIMENTS or FIGURE, by which labels become R/C and F/C/E/S. trees: of each forest of Extra-Trees.
    track: wraps the steps, to show progress. Raises what read_building_floors raises.
    """
    floors, failed = read_building_floors(data, split=split)
    bench = BuildingsBench(split, seed, trees, floors, failed, of_thesis=True)
    return _measure(bench, track)


def measure_building_types(
    folders: Sequence[Path],
    *,
    split: LabelConvention = LabelConvention.EXPERIMENTS,
    trees: int = TREES,
    seed: int = 0,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> BuildingsBench:
    """Classify the buildings of folders, each of one building type, as section 6.2.2 does with three types of MIT.

    Options as of measure_buildings. Raises what read_type_folders raises.
    """
    floors, failed = read_type_folders(folders, split=split)
    bench = BuildingsBench(split, seed, trees, floors, failed, of_thesis=False)
    return _measure(bench, track)


def _measure(bench: BuildingsBench, track: Callable[[Sequence[str]], Iterable[str]]) -> BuildingsBench:
    for floor in bench.floors:
        # Read and computed before anything is timed, for all models alike.
        _ = floor.drawn.features, floor.told
    steps: dict[str, Callable[[], None]] = {}
    if bench.of_thesis:
        for kind in bench.building_types:
            steps[f"places, {kind}s, Ex-T"] = partial(_judge_places_by_trees, bench, kind)
            steps[f"places, {kind}s, {KLOG}"] = partial(_judge_places_by_relations, bench, kind)
        for building in dict.fromkeys(floor.drawn.building for floor in bench.floors):
            steps[f"places, {PIANTA} without {building}"] = partial(_judge_places_by_pianta, bench, building)
    for model in (*COLUMNS, KLOG, PIANTA):
        steps[f"buildings, {model}"] = partial(_judge_buildings, bench, model)
    for step in track([*steps]):
        steps[step]()
    return bench


def _judge_places_by_trees(bench: BuildingsBench, kind: str) -> None:
    places = bench.places_of(kind)
    floors = [bench.floors[place] for place in places]
    for model, label_set in product(COLUMNS, LABELS):
        with bench.timed(PLACES, model):
            judged = judge_places_by_trees(floors, label_set, model=model, trees=bench.trees, seed=bench.seed)
        _keep_places(bench, places, model, label_set, judged)


def _judge_places_by_relations(bench: BuildingsBench, kind: str) -> None:
    places = bench.places_of(kind)
    with bench.timed(PLACES, KLOG):
        judged = judge_places_by_relations([bench.floors[place] for place in places])
    for label_set, of_floors in judged.items():
        _keep_places(bench, places, KLOG, label_set, of_floors)


def _judge_places_by_pianta(bench: BuildingsBench, building: str) -> None:
    with bench.timed(PLACES, PIANTA):
        judged = dict(judge_places_by_pianta(bench.floors, building, split=bench.split, seed=bench.seed))
    for place, scores in judged.items():
        for label_set, of_rooms in scores.items():
            _keep_places(bench, [place], PIANTA, label_set, [of_rooms])


def _keep_places(
    bench: BuildingsBench, places: Sequence[int], model: str, label_set: LabelSet, judged: Sequence[Floats]
) -> None:
    of_floors = bench.places.setdefault((model, label_set), [np.zeros((0, 0))] * len(bench.floors))
    for place, scores in zip(places, judged, strict=True):
        of_floors[place] = scores


def _judge_buildings(bench: BuildingsBench, model: str) -> None:
    folds = {BUILDING: list_folds([floor.drawn.building for floor in bench.floors])}
    if bench.of_thesis:
        folds[FLOOR] = list_folds([str(place) for place in range(len(bench.floors))])
    for label_set in LABELS:
        compare = compare_floors(bench.floors, label_set)
        for left_out, of_task in folds.items():
            key = left_out, model, label_set
            with bench.timed(TASK_OF[left_out], model):
                if model in COLUMNS:
                    bench.types[key] = judge_buildings_by_trees(
                        bench.floors, of_task, label_set, model=model, trees=bench.trees, seed=bench.seed
                    )
                elif model == KLOG:
                    bench.types[key] = judge_buildings_by_relations(bench.floors, of_task, compare)
                else:
                    bench.types[key], typical = judge_buildings_by_pianta(bench.floors, of_task, label_set)
                    bench.typical[left_out, label_set] = typical
