"""What rooms are for: models of rooms on buildings that were left out of their training."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from math import sqrt
from pathlib import Path
from statistics import median
from types import MappingProxyType

from pianta.evaluation.semantics import semantic_accuracy
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io.maps import read_map
from pianta.labels import LabelConvention, LabelSet
from pianta.layout.reconstruct import reconstruct
from pianta.plot.figure import save_figure
from pianta.plot.floor import draw_floor
from pianta.rooms.completion import LABELS
from pianta.rooms.model import RoomModel
from pianta.worlds.simulated_readings import simulate_reading
from pianta_bench.data.annotated_floors import (
    AnnotatedFloor,
    read_annotated_floors,
    read_buildings_of_files,
    read_drawing,
    set_building_type,
)
from pianta_bench.data.folders import SLAM_FOLDER, SLAM_RESOLUTION, SLAM_TRUTH, find_data, list_maps
from pianta_bench.harness.folds import list_folds
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Figures, Item, Results, Track
from pianta_bench.harness.timing import measure_time
from pianta_bench.places.evaluated import (
    BACKWARD,
    FORWARD,
    LAYOUTS,
    OFFICES,
    SCHOOLS,
    TRUE_LAYOUTS,
    EvaluatedFloor,
)
from pianta_bench.places.models import (
    PIANTA,
    Classifiers,
    DescribedFloor,
    PreparedFloor,
    check_convention,
    list_examples,
    train_room_model,
    true_labels,
)

PARTS: Mapping[str, str] = MappingProxyType({"school": SCHOOLS, "office": OFFICES})  # by building type
SIMULATED, COST = "simulated", "cost"
WRONG_ROOMS = "wrong rooms, %"
MAPS_TYPE = "school"  # building type of the maps
# Metrics of the part COST: processor seconds, and what they belong to.
TRAIN_ANNOTATED, TRAIN_ALL = "training, drawn floors only", "training, simulated maps too"
READ, LABEL, LABEL_PER_READ = "reading the map", "labelling its floor", "labelling per reading"
FLOORS, ROOMS, MAP_ROOMS = "floors", "rooms", "map rooms"
TIMED_ROOMS = 60  # labelling is timed on the map with about so many reconstructed rooms
RUNS = 3  # of reading and labelling, of whose times the median is taken


@dataclass(frozen=True)
class MapItem:
    """A map of a floor. drawn_area: m² of the rooms of the annotated floor of that name, None if there is none."""

    item: str
    building: str
    drawn_area: float | None

    def read(self, data: Path) -> tuple[GridMap, Floor]:
        """The map, and its true floor."""
        folder = data / SLAM_FOLDER
        grid = read_map(folder / f"{self.item}.png", resolution=SLAM_RESOLUTION)
        return grid, set_building_type(read_drawing(folder / f"{self.item}{SLAM_TRUTH}", grid=grid), MAPS_TYPE)

    def compare_scales(self, truth: Floor) -> float:
        """Lengths of the annotated floor in those of the map of the same floor; 1 if there is none."""
        return 1.0 if self.drawn_area is None else sqrt(self.drawn_area / _measure_rooms(truth))


@dataclass(frozen=True, eq=False)
class Fold:
    """Floors that models are trained on, and the floors and maps of other buildings. names: of these buildings."""

    names: str
    training: Sequence[PreparedFloor]
    floors: Sequence[PreparedFloor]
    maps: Sequence[MapItem]


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

    Records of floors and maps: wrong rooms in %, by model, label set and, for maps, the way to pair rooms. If
    manifest.json of the data has several floors of one building, they are left out together. A floor that fails has no
    records.
    convention: EXPERIMENTS or FIGURE, by which labels become R/C and F/C/E/S.
    seed: of all trees, and of simulated maps, where the index of the floor is added.
    jobs: number of processes, None for one for each core; figures do not depend on it.
    pictures: folder for NAME.png of each map, with predicted labels, and NAME_true.png.
    track: wraps the steps, to show progress.
    Raises OptionError for another convention, DataError if there are no buildings of a type, or no maps.
    """
    labels = check_convention(convention)
    folder = find_data(data)
    floors, failed = read_annotated_floors(folder)
    maps = _list_map_items(folder, floors)
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    results = Results(options={"convention": str(labels), "seed": seed})
    results.items += [Item(PARTS[name], row.item, row.failure) for name, rows in failed.items() for row in rows]

    preparing = {
        f"{floor.kind}/{floor.item}, simulated": partial(_prepare, floor, convention=labels, seed=seed + number)
        for number, floor in enumerate(floors)
    }
    prepared = []
    for partial_results, floor in run_steps(preparing, jobs=jobs, track=track):
        results.extend(partial_results)
        prepared.append(floor)

    folds = _make_folds(prepared, maps)
    evaluate = partial(_evaluate_fold, data=folder, convention=labels, seed=seed, pictures=pictures)
    evaluating = {f"without {fold.names}": partial(evaluate, fold) for fold in folds}
    evaluated: list[EvaluatedFloor] = []
    for partial_results, of_fold in run_steps(evaluating, jobs=jobs, track=track):
        results.extend(partial_results)
        evaluated += of_fold
    results.objects |= {"floors": evaluated, "convention": labels}
    results.details["rooms"] = [floor.as_json() for floor in evaluated]
    _measure_cost(results, prepared, folder, seed=seed)
    return results


def _list_map_items(data: Path, floors: Sequence[AnnotatedFloor]) -> list[MapItem]:
    buildings = read_buildings_of_files(data)
    areas = {floor.item: _measure_rooms(floor.floor) for floor in floors if floor.kind == MAPS_TYPE}
    return [
        MapItem(item, f"{MAPS_TYPE}/{buildings.get(f'{SLAM_FOLDER}/{item}.png', item)}", areas.get(item))
        for item in list_maps(data / SLAM_FOLDER, SLAM_TRUTH)
    ]


def _prepare(annotated: AnnotatedFloor, *, convention: LabelConvention, seed: int) -> tuple[Results, PreparedFloor]:
    """Describe a floor, and read a simulated map of it."""
    results, described = Results(), DescribedFloor.describe(annotated.floor)
    _ = annotated.features, annotated.unlabelled  # computed once
    prepared = [PreparedFloor(annotated, described, list_examples([annotated.floor], convention=convention))]

    def simulate() -> Iterator[Figures]:
        reading = simulate_reading(annotated.floor, seed=seed)
        examples = list_examples([], [reading], convention=convention)
        prepared.append(replace(prepared[0], simulated=reading, simulated_examples=examples))
        yield {"rooms": len(reading.rooms), "true": len(annotated.floor.rooms)}

    results.measure(SIMULATED, annotated.item, simulate)
    return results, prepared[-1]


def _make_folds(floors: Sequence[PreparedFloor], maps: Sequence[MapItem]) -> Iterator[Fold]:
    """Folds of the floors and maps of all buildings."""
    buildings = [*(floor.annotated.building for floor in floors), *(item.building for item in maps)]
    for others, held_out in list_folds(buildings):
        yield Fold(
            ", ".join(sorted({buildings[i] for i in held_out})),
            [floors[i] for i in others if i < len(floors)],
            [floors[i] for i in held_out if i < len(floors)],
            [maps[i - len(floors)] for i in held_out if i >= len(floors)],
        )


def _evaluate_fold(
    fold: Fold, *, data: Path, convention: LabelConvention, seed: int, pictures: Path | None
) -> tuple[Results, list[EvaluatedFloor]]:
    """Train without the buildings of a fold, and classify the rooms of its floors, annotated and reconstructed."""
    results, evaluated = Results(), []
    classifiers = Classifiers(fold.training, convention, seed)

    def classify(floor: PreparedFloor) -> Iterator[Figures]:
        annotated = floor.annotated
        probabilities = classifiers.predict(floor.described, annotated.kind)
        part, item, building = PARTS[annotated.kind], annotated.item, annotated.building
        classified = EvaluatedFloor(
            part, item, building, annotated.unlabelled, annotated.floor, probabilities, convention
        )
        yield _list_errors(classified)
        evaluated.append(classified)

    def read_and_classify(map_item: MapItem) -> Iterator[Figures]:
        grid, truth = map_item.read(data)
        item, scale = map_item.item, map_item.compare_scales(truth)
        reconstructed = reconstruct(replace(grid, source=item))
        unlabelled = AnnotatedFloor(item, MAPS_TYPE, map_item.building, truth).unlabelled
        classified = []
        for part, floor in ((LAYOUTS, reconstructed), (TRUE_LAYOUTS, unlabelled)):
            probabilities = classifiers.predict(DescribedFloor.describe(floor, scale=scale), MAPS_TYPE)
            classified.append(EvaluatedFloor(part, item, map_item.building, floor, truth, probabilities, convention))
        yield _list_errors(classified[0])
        counts = {"rooms": len(reconstructed.rooms), "true": len(truth.rooms), "scale": scale}
        results.add(LAYOUTS, item, counts)
        if pictures:
            labelled = classifiers.room_models[PIANTA].label(reconstructed)
            save_figure(draw_floor(labelled, grid), pictures / f"{item}.png")
            save_figure(draw_floor(_label_functions(truth, convention), grid), pictures / f"{item}_true.png")
        evaluated.extend(classified)

    names = ("model", "labels", "way")
    for floor in fold.floors:
        annotated = floor.annotated
        measure_one = partial(classify, floor)
        results.measure(PARTS[annotated.kind], annotated.item, measure_one, names=names, metric=WRONG_ROOMS)
    for map_item in fold.maps:
        results.measure(LAYOUTS, map_item.item, partial(read_and_classify, map_item), names=names, metric=WRONG_ROOMS)
    return results, evaluated


def _list_errors(floor: EvaluatedFloor) -> Figures:
    """Wrong rooms, %, by model, label set and, for a reconstructed floor, way to pair rooms."""
    ways = (FORWARD, BACKWARD) if floor.part == LAYOUTS else (FORWARD,)
    return {
        (model, str(label_set), way if floor.part == LAYOUTS else None): 100
        - 100 * semantic_accuracy(floor.pair_labels(model, label_set, way))
        for model in floor.probabilities
        for label_set in LABELS
        for way in ways
    }


def _measure_cost(results: Results, floors: Sequence[PreparedFloor], data: Path, *, seed: int) -> None:
    """Time training on all floors, and reading and labelling of the map with about TIMED_ROOMS rooms.

    It is labelled by a model of annotated floors, as the one that comes with pianta is. Nothing without maps.
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
    seconds = {TRAIN_ANNOTATED: train_annotated, TRAIN_ALL: train_all, READ: read, LABEL: label}
    results.add(COST, layout.item, {**seconds, LABEL_PER_READ: label / read})
    rooms = sum(len(floor.rooms) for floor in annotated)
    results.add(COST, layout.item, {FLOORS: len(floors), ROOMS: rooms, MAP_ROOMS: len(layout.floor.rooms)})


def _measure_rooms(floor: Floor) -> float:
    """Area of all rooms, m²."""
    return float(sum(room.polygon.area for room in floor.rooms))


def _label_functions(truth: Floor, convention: LabelConvention) -> Floor:
    """The floor with labels in F/C/E/S."""
    labels = true_labels(truth, LabelSet.F_C_E_S, convention=convention)
    rooms = [replace(room, label=label) for room, label in zip(truth.rooms, labels, strict=True)]
    return replace(truth, rooms=tuple(rooms), building_type={})
