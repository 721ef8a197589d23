"""Functions of rooms: models of rooms on buildings that were left out of their training."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import sqrt
from pathlib import Path
from statistics import median
from types import MappingProxyType

from pianta.errors import DataError
from pianta.evaluation.semantics import semantic_accuracy
from pianta.floor import Floor, scale_floor
from pianta.gridmap import GridMap
from pianta.io._faults import join_faults
from pianta.io.maps import read_map
from pianta.labels import LabelConvention, LabelSet
from pianta.layout.reconstruct import reconstruct
from pianta.plot.figure import save_figure
from pianta.plot.floor import draw_floor
from pianta.rooms.completion import LABELS
from pianta.rooms.features import describe_rooms
from pianta.rooms.model import RoomModel
from pianta.rooms.thesis_features import compute_room_features
from pianta.worlds.simulated_readings import simulate_and_reconstruct
from pianta_bench.data.annotated_floors import (
    AnnotatedFloor,
    read_annotated_floors,
    read_drawing,
    set_building_type,
)
from pianta_bench.data.building_of import building_of
from pianta_bench.data.folders import SLAM_FOLDER, SLAM_RESOLUTION, SLAM_TRUTH, find_data, list_maps
from pianta_bench.harness.folds import list_folds
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Figures, Item, Results, Track
from pianta_bench.harness.timing import measure_time
from pianta_bench.places.evaluated import (
    BACKWARD,
    FORWARD,
    LAYOUTS,
    METHODS,
    OFFICES,
    SCHOOLS,
    TRUE_LAYOUTS,
    EvaluatedFloor,
)
from pianta_bench.places.models import (
    CENTRAL,
    IN_DRAWINGS_SCALE,
    PIANTA,
    Classifiers,
    PreparedFloor,
    check_convention,
    list_examples,
    train_room_model,
    true_labels,
)

PARTS: Mapping[str, str] = MappingProxyType({"school": SCHOOLS, "office": OFFICES})  # by building type
SIMULATED = "simulated"
COST = "processor s"  # part of the records with times
COUNTS = "cost"  # part of the records with the numbers of floors and rooms that were timed
WRONG_ROOMS = "wrong rooms, %"
MAPS_TYPE = "school"  # building type of the maps
MIN_BUILDINGS = 2  # of each type: one is left out, and one is trained on
TIMED_ROOMS = 60  # labelling is timed on the map whose number of reconstructed rooms is nearest to this
RUNS = 3  # of reading and labelling, of whose times the median is taken


@dataclass(frozen=True)
class MapItem:
    """A map of a floor. drawn_area: m² of the rooms of the annotated floor of the same name; None without one."""

    item: str
    building: str
    drawn_area: float | None

    def read(self, data: Path) -> tuple[GridMap, Floor]:
        """The map, and its true floor."""
        folder = data / SLAM_FOLDER
        grid = read_map(folder / f"{self.item}.png", resolution=SLAM_RESOLUTION)
        return grid, set_building_type(read_drawing(folder / f"{self.item}{SLAM_TRUTH}", grid=grid), MAPS_TYPE)


def measure(
    data: Path | None = None,
    *,
    convention: str = LabelConvention.EXPERIMENTS,
    seed: int = 0,
    jobs: int | None = None,
    pictures: Path | None = None,
    track: Track = iter,
) -> Results:
    """Label the floors of data/buildings and the maps of data/slam by models that were not trained on their building.

    Maps are reconstructed by `structure` and, for Tables 5.2 to 5.4 of the thesis, by its Algorithm 1.

    Records of floors and maps: wrong rooms in %, by model, label set and, for maps, direction of pairing. If
    manifest.json of the data has several floors of one building, they are left out together. A floor that fails has no
    records.
    convention: EXPERIMENTS or FIGURE, by which labels become R/C and F/C/E/S.
    seed: of all trees, and of simulated maps, where the index of the floor is added.
    jobs: number of processes, None for one for each core; figures do not depend on it.
    pictures: folder for NAME.png of each map, with predicted labels, and NAME_true.png.
    track: wraps the steps, to show progress.
    Raises OptionError for another convention, DataError for fewer than two buildings of a type, or no maps.
    """
    labels = check_convention(convention)
    folder = find_data(data)
    floors, failed = read_annotated_floors(folder)
    _check_buildings(floors)
    maps = _list_map_items(folder, floors)
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    results = Results(options={"convention": str(labels), "seed": seed})
    results.items += [Item(PARTS[name], row.item, row.failure) for name, rows in failed.items() for row in rows]

    preparing = {
        f"{floor.kind}/{floor.item}, simulated": partial(_prepare, floor, convention=labels, seed=seed + number)
        for number, floor in enumerate(floors)
    }
    prepared: list[PreparedFloor] = []
    for partial_results, described in run_steps(preparing, jobs=jobs, track=track):
        results.extend(partial_results)
        prepared += described

    items = [*prepared, *maps]
    buildings = [*(floor.annotated.building for floor in prepared), *(item.building for item in maps)]
    evaluate = partial(_evaluate, data=folder, convention=labels, seed=seed, pictures=pictures)
    evaluating = {
        f"without {', '.join(sorted({buildings[i] for i in held_out}))}": partial(
            evaluate, [prepared[i] for i in others if i < len(prepared)], [items[i] for i in held_out]
        )
        for others, held_out in list_folds(buildings)
    }
    evaluated: list[EvaluatedFloor] = []
    for partial_results, fold_floors in run_steps(evaluating, jobs=jobs, track=track):
        results.extend(partial_results)
        evaluated += fold_floors
    results.objects |= {"floors": evaluated, "convention": labels}
    results.details["rooms"] = [floor.as_json() for floor in evaluated]
    _measure_cost(results, prepared, folder, seed=seed)
    return results


def _check_buildings(floors: Sequence[AnnotatedFloor]) -> None:
    """Raise DataError if a type has fewer than MIN_BUILDINGS buildings."""
    counts = {name: len({floor.building for floor in floors if floor.kind == name}) for name in PARTS}
    few = [
        f"{count} building{'s' * (count != 1)} of type {name}"
        for name, count in counts.items()
        if count < MIN_BUILDINGS
    ]
    if few:
        raise DataError(
            f"{join_faults(few)} can be read, give {MIN_BUILDINGS} of each type at least, as one is left out"
        )


def _list_map_items(data: Path, floors: Sequence[AnnotatedFloor]) -> list[MapItem]:
    """All maps with their buildings, and the areas of the annotated floors of the same names, None without one."""
    areas = {floor.item: _measure_rooms(floor.floor) for floor in floors if floor.kind == MAPS_TYPE}
    return [
        MapItem(item, f"{MAPS_TYPE}/{building_of(data, f'{SLAM_FOLDER}/{item}.png')}", areas.get(item))
        for item in list_maps(data / SLAM_FOLDER, SLAM_TRUTH)
    ]


def _prepare(
    annotated: AnnotatedFloor, *, convention: LabelConvention, seed: int
) -> tuple[Results, list[PreparedFloor]]:
    """Describe a floor, and read a simulated map of it; an empty list if it cannot be described."""
    results, prepared = Results(), []

    def describe() -> Iterator[Figures]:
        prepared.append(PreparedFloor.prepare(annotated, convention))
        yield {}

    results.measure(PARTS[annotated.kind], annotated.item, describe)
    if not prepared:
        return results, prepared
    results = Results()

    def simulate() -> Iterator[Figures]:
        reading = simulate_and_reconstruct(annotated.floor, seed=seed)
        examples = prepared[0].examples + list_examples([], [reading], convention=convention)
        prepared[0] = replace(prepared[0], simulated=reading, examples=examples)
        yield {"rooms": len(reading.rooms), "true": len(annotated.floor.rooms)}

    results.measure(SIMULATED, annotated.item, simulate)
    return results, prepared


def _evaluate(
    training: Sequence[PreparedFloor],
    held_out: Sequence[PreparedFloor | MapItem],
    *,
    data: Path,
    convention: LabelConvention,
    seed: int,
    pictures: Path | None,
) -> tuple[Results, list[EvaluatedFloor]]:
    """Train on floors, and classify the rooms of other floors and of maps."""
    results, evaluated = Results(), []
    classifiers = Classifiers(training, convention, seed)

    def classify_annotated(prepared: PreparedFloor) -> Iterator[Figures]:
        annotated = prepared.annotated
        probabilities = classifiers.predict(annotated.kind, annotated.features, prepared.context)
        names = PARTS[annotated.kind], annotated.item, annotated.building
        floor = EvaluatedFloor(*names, annotated.unlabelled, annotated.floor, probabilities, convention)
        yield list_errors(floor)
        evaluated.append(floor)

    def classify_map(item: MapItem, part: str) -> Iterator[Figures]:
        grid, truth = item.read(data)
        _ = classifiers.room_models  # trained first, so that no map is read if the training fails
        floor = reconstruct(replace(grid, source=item.item), method=METHODS[part])
        # Length in the annotated floor over the same length in the map.
        scale = 1.0 if item.drawn_area is None else sqrt(item.drawn_area / _measure_rooms(truth))
        layouts = {part: floor}
        if part == LAYOUTS:
            layouts[TRUE_LAYOUTS] = AnnotatedFloor(item.item, MAPS_TYPE, item.building, truth).unlabelled
        floors = []
        for name, each in layouts.items():
            features, scaled = map(compute_room_features, (each, scale_floor(each, scale, scale)))
            probabilities = classifiers.predict(MAPS_TYPE, features, describe_rooms(each))
            probabilities[IN_DRAWINGS_SCALE] = classifiers.predict_local(CENTRAL, MAPS_TYPE, scaled)
            floors.append(EvaluatedFloor(name, item.item, item.building, each, truth, probabilities, convention))
        yield list_errors(floors[0])
        results.add(part, item.item, {"rooms": len(floor.rooms), "true": len(truth.rooms), "scale": scale})
        if pictures and part == LAYOUTS:
            labelled = classifiers.room_models[PIANTA].label(floor)
            save_figure(draw_floor(labelled, grid), pictures / f"{item.item}.png")
            save_figure(draw_floor(_label_functions(truth, convention), grid), pictures / f"{item.item}_true.png")
        evaluated.extend(floors)

    for each in held_out:
        if isinstance(each, MapItem):
            item, steps = each.item, {part: partial(classify_map, each, part) for part in METHODS}
        else:
            item, steps = each.annotated.item, {PARTS[each.annotated.kind]: partial(classify_annotated, each)}
        for part, classify_one in steps.items():
            results.measure(part, item, classify_one, names=("model", "labels", "way"), metric=WRONG_ROOMS)
    return results, evaluated


def list_errors(floor: EvaluatedFloor) -> Figures:
    """Wrong rooms, %, by model, label set and, for a reconstructed floor, direction of pairing."""
    is_reconstructed = floor.part in METHODS
    ways = (FORWARD, BACKWARD) if is_reconstructed else (FORWARD,)
    return {
        (model, str(label_set), way if is_reconstructed else None): 100
        - 100 * semantic_accuracy(floor.pair_labels(model, label_set, way))
        for model in floor.probabilities
        for label_set in LABELS
        for way in ways
    }


def _measure_cost(results: Results, floors: Sequence[PreparedFloor], data: Path, *, seed: int) -> None:
    """Time training on all floors, and reading and labelling of the map with about TIMED_ROOMS rooms.

    The model that labels it is trained on annotated floors, like the model that comes with pianta. Without maps nothing
    is timed.
    """
    layouts = [floor for floor in results.objects["floors"] if floor.part == LAYOUTS]
    if not layouts:
        return
    layout = min(layouts, key=lambda floor: abs(len(floor.floor.rooms) - TIMED_ROOMS))
    annotated = [floor.annotated.floor for floor in floors]
    simulated = [floor.simulated for floor in floors if floor.simulated]

    def train(simulated: Sequence[Floor]) -> RoomModel:
        examples = list_examples(annotated, simulated, convention=layout.convention)
        return train_room_model(examples, convention=layout.convention, seed=seed)

    grid, _ = MapItem(layout.item, layout.building, None).read(data)
    train_annotated, model = measure_time(partial(train, []))
    train_all, _ = measure_time(partial(train, simulated))
    read = median(measure_time(partial(reconstruct, grid))[0] for _ in range(RUNS))
    label = median(measure_time(partial(model.label, layout.floor))[0] for _ in range(RUNS))
    seconds = {
        "training, drawn floors only": train_annotated,
        "training, simulated maps too": train_all,
        "reading the map": read,
        "labelling its floor": label,
        "labelling per reading": label / read,
    }
    rooms = sum(len(floor.rooms) for floor in annotated)
    results.add(COST, layout.item, seconds)
    results.add(COUNTS, layout.item, {"floors": len(floors), "rooms": rooms, "map rooms": len(layout.floor.rooms)})


def _measure_rooms(floor: Floor) -> float:
    """Area of all rooms, m²."""
    return float(sum(room.polygon.area for room in floor.rooms))


def _label_functions(truth: Floor, convention: LabelConvention) -> Floor:
    """The floor with labels in F/C/E/S."""
    labels = true_labels(truth, LabelSet.F_C_E_S, convention=convention)
    rooms = [replace(room, label=label) for room, label in zip(truth.rooms, labels, strict=True)]
    return replace(truth, rooms=tuple(rooms), building_type={})
