"""Rooms, labels and building type of maps that get worse, by each method and each level of a factor."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property, partial
from pathlib import Path

import numpy as np

from pianta._types import LabelImage
from pianta.building_types.map_types import MapTypeModel
from pianta.errors import MapError, OptionError
from pianta.evaluation.segmentation import drop_small_rooms, score_labels
from pianta.evaluation.semantics import LabelPair, semantic_accuracy
from pianta.floor import Floor
from pianta.labels import LabelSet
from pianta.layout.reconstruct import METHODS, check_method, reconstruct
from pianta.rooms.model import RoomModel
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.noise import DRAWN_SET, FACTOR_NAMES, WORLDS_SET
from pianta_bench.noise.factors import FACTORS, WorseMap
from pianta_bench.noise.floors import CONVENTION, NoiseFloor, list_floors
from pianta_bench.places.models import true_labels
from pianta_bench.types.maps import RIGHT, UNKNOWN, WRONG, score_type

# Methods whose rooms are labelled, and whose building type is predicted.
LABELLED = ("structure", "thesis")
ROOMS = "rooms F1"
LABELS = "labels right"
TYPES = {name: f"type {name}" for name in (RIGHT, UNKNOWN, WRONG)}
CLEAN = "clean"
# Figures of a map on which no room is found: its type is unknown.
NO_ROOMS = {LABELS: 0.0, TYPES[RIGHT]: 0.0, TYPES[UNKNOWN]: 100.0, TYPES[WRONG]: 0.0}


@dataclass(frozen=True, eq=False)
class Models:
    """Models of labels and building types without the building of a floor, trained when they are first used."""

    noise_floor: NoiseFloor
    seed: int

    @cached_property
    def rooms(self) -> RoomModel:
        """The model of labels."""
        return self.noise_floor.train_room_model(seed=self.seed)

    @cached_property
    def types(self) -> MapTypeModel:
        """The model of building types."""
        return self.noise_floor.train_type_model()


def measure(
    data: Path | None = None,
    *,
    floor_set: str = DRAWN_SET,
    floors: int = 6,
    factors: Sequence[str] | None = None,
    levels: int = 4,
    methods: Sequence[str] | None = None,
    seed: int = 0,
    jobs: int = 1,
    track: Track = iter,
) -> Results:
    """Figures in % of each floor at each level of each factor by each method, with the fields factor, level, method.

    floor_set: DRAWN_SET or WORLDS_SET. floors: how many. factors: of FACTOR_NAMES, all unless given.
    levels: how many of each factor, beside the clean map. methods: of METHODS, all unless given.
    seed: of the choice of floors, of the maps, and of the models. jobs: processes; the figures do not depend on them.
    track: wraps the floors, to show progress.
    Raises OptionError for the name of no set, factor or method, DataError if there are no floors.
    """
    if floor_set not in (DRAWN_SET, WORLDS_SET):
        raise OptionError(f"set is {floor_set!r}, give {DRAWN_SET} or {WORLDS_SET}")
    factors, methods = tuple(dict.fromkeys(factors or FACTOR_NAMES)), tuple(dict.fromkeys(methods or METHODS))
    for factor in factors:
        if factor not in FACTORS:
            raise OptionError(f"factor is {factor!r}, give one of {', '.join(FACTOR_NAMES)}")
    for method in methods:
        check_method(method)
    results = Results({"set": floor_set, "factors": factors, "levels": levels, "methods": methods, "seed": seed})
    chosen = list_floors(data, floor_set, count=floors, seed=seed)
    results.options["floors"] = [each.item for each in chosen]
    steps = {
        each.item: partial(measure_floor, each, factors, levels=levels, methods=methods, seed=seed + number)
        for number, each in enumerate(chosen)
    }
    for outcome in run_steps(steps, jobs=jobs, track=track):
        results.extend(outcome)
    return results


def measure_floor(
    each: NoiseFloor, factors: Sequence[str], *, levels: int, methods: Sequence[str], seed: int
) -> Results:
    """The figures of a floor; the clean map is measured once, and counts as a level of every factor."""
    models, results = Models(each, seed), Results()
    first = FACTORS[factors[0]]
    clean = Results()
    measure_map(clean, models, partial(first.simulate, each.floor, first.clean, seed), methods, level=CLEAN)
    results.items += clean.items
    for name in factors:
        factor = FACTORS[name]
        results.records += [{**record, "part": name, "factor": name} for record in clean.records]
        for level in factor.choose_levels(levels):
            simulate = partial(factor.simulate, each.floor, level, seed)
            measure_map(results, models, simulate, methods, level=factor.name_level(level), factor=name)
    return results


def measure_map(
    results: Results,
    models: Models,
    simulate: Callable[[], WorseMap],
    methods: Sequence[str],
    *,
    level: str,
    factor: str = CLEAN,
) -> None:
    """Add the figures of one map by each method."""
    simulate = cache(simulate)
    for method in methods:

        def measure_method(method: str = method) -> Iterator[Figures]:
            yield score_map(simulate(), method, models)

        failed = {ROOMS: 0.0} | (NO_ROOMS if method in LABELLED else {})
        fields = {"floor": models.noise_floor.item, "factor": factor, "level": level, "method": method}
        name = f"{models.noise_floor.item}, {level}, {method}"
        results.measure(factor, name, measure_method, failed=failed, **fields)


def score_map(worse: WorseMap, method: str, models: Models) -> Figures:
    """The figures of a map by a method, in %."""
    try:
        floor = reconstruct(worse.grid, method=method, predict_partial=False)
    except MapError:  # no room is found
        floor = Floor(())
    labels = floor.label_image(worse.grid).astype(np.int32) if floor.rooms else np.zeros_like(worse.truth)
    figures: dict[str, float | None] = {ROOMS: score_rooms(labels, worse)}
    if method not in LABELLED:
        return figures
    if not floor.rooms:
        return figures | NO_ROOMS
    figures[LABELS] = score_functions(models.rooms.label(floor), labels, worse.truth, models.noise_floor.floor)
    scores = score_type(models.types.predict(floor), models.noise_floor.kind)
    return figures | {TYPES[name]: 100 * scores[name] for name in TYPES}


def score_rooms(labels: LabelImage, worse: WorseMap) -> float:
    """F1 of rooms, %: the share that matches one to one with an IoU above 0.5, on the cells of the true rooms.

    Rooms of up to 0.25 m² are dropped on both sides.
    """
    rooms, truth = (
        drop_small_rooms(np.where(worse.truth > 0, image, 0), resolution=worse.grid.resolution)
        for image in (labels, worse.truth)
    )
    return 100 * score_labels(rooms, truth).f1


def score_functions(labelled: Floor, labels: LabelImage, truth: LabelImage, true_floor: Floor) -> float:
    """Semantic accuracy FC in F/C/E/S, % (section 5.3): each room against the true one that it overlaps most."""
    names = true_labels(true_floor, LabelSet.F_C_E_S, convention=CONVENTION)
    name_of = {room.id: name for room, name in zip(true_floor.rooms, names, strict=True)}
    pairs = []
    for room in labelled.rooms:
        counts = np.bincount(truth[(labels == room.id) & (truth > 0)], minlength=1)
        true = name_of[int(counts.argmax())] if counts.any() else None
        pairs.append(LabelPair(room.labels[LabelSet.F_C_E_S], true))
    return 100 * semantic_accuracy(pairs)
