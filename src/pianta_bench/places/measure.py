"""What rooms are for: Tables 6.1 (places) and 5.2 to 5.4, calibration and cost, with whole buildings left out."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from math import sqrt
from pathlib import Path
from statistics import median
from time import process_time
from typing import TypeVar

from pianta.evaluation.semantics import semantic_accuracy
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io.maps import read_map
from pianta.labels import LabelConvention, LabelSet
from pianta.layout.reconstruct import reconstruct
from pianta.plot.figure import save_figure
from pianta.plot.floor import draw_floor
from pianta.rooms.completion import LABELS
from pianta.worlds.simulated_readings import simulate_and_reconstruct
from pianta_bench.data.annotated_floors import (
    AnnotatedFloor,
    read_annotated_floors,
    read_buildings_of_files,
    read_drawing,
    set_building_type,
)
from pianta_bench.data.folders import SLAM_FOLDER, SLAM_RESOLUTION, SLAM_TRUTH, list_maps
from pianta_bench.harness.comparison import save_comparisons
from pianta_bench.harness.table import Figures, Row, measure_row
from pianta_bench.places.evaluated_floor import LAYOUTS, OFFICES, SCHOOLS, TRUE_LAYOUTS, JudgedFloor
from pianta_bench.places.models import PIANTA, Judges, train_judges, train_on, true_labels
from pianta_bench.places.tables import Cost, PlacesBench, tabulate_places

PART_OF_KIND = {"school": SCHOOLS, "office": OFFICES}
SIMULATED = "simulated"
# Of the buildings on the maps.
MAPS_KIND = "school"
# Of the floor that labelling is timed on, and how often both are.
TIMED_ROOMS, RUNS = 60, 3


def measure_places(
    data: Path,
    *,
    split: LabelConvention = LabelConvention.EXPERIMENTS,
    seed: int = 0,
    pictures: Path | None = None,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> PlacesBench:
    """Label the floors of data/buildings and the maps of data/slam by models that have not seen their building.

    A floor that fails does not count; Row.failure has the reason. Where manifest.json of the data says that floors
    are of one building, they are left out together.
    split: EXPERIMENTS or FIGURE, by which labels become R/C and F/C/E/S.
    seed: of all trees, and of simulated maps, where the number of the floor is added.
    pictures: an existing folder for NAME.png of each map, the labels given, and NAME_true.png.
    track: wraps the steps, to show progress.
    Raises DataError when there are no buildings of a type, or no maps.
    """
    run = _start(data, split=split, seed=seed, pictures=pictures)
    steps: dict[str, Callable[[], None]] = {
        f"{floor.kind}/{floor.item}, simulated": partial(run.simulate, number)
        for number, floor in enumerate(run.floors)
    }
    buildings = sorted({floor.building for floor in run.floors} | set(run.maps.values()))
    steps |= {f"without {building}": partial(run.leave_out, building) for building in buildings}
    steps["cost"] = run.measure_cost
    for step in track([*steps]):
        steps[step]()
    return PlacesBench(split, seed, run.judged, run.items, run.cost)


@dataclass(eq=False)
class _Run:
    """A bench under way. maps: the building of each map. simulated: by `kind/item`."""

    data: Path
    split: LabelConvention
    seed: int
    pictures: Path | None
    floors: list[AnnotatedFloor]
    maps: dict[str, str]
    items: dict[str, list[Row]]
    simulated: dict[str, Floor] = field(default_factory=dict)
    judged: list[JudgedFloor] = field(default_factory=list)
    cost: Cost | None = None

    def simulate(self, number: int) -> None:
        """Read a simulated map of a floor."""
        floor = self.floors[number]

        def measure(_: str) -> Iterator[Figures]:
            reading = simulate_and_reconstruct(floor.floor, seed=self.seed + number)
            self.simulated[f"{floor.kind}/{floor.item}"] = reading
            yield {"rooms": len(reading.rooms), "true": len(floor.floor.rooms)}

        self.items[SIMULATED].append(measure_row(floor.item, measure, columns=()))

    def leave_out(self, building: str) -> None:
        """Train without a building, and judge its floors, drawn and reconstructed."""
        others = [floor for floor in self.floors if floor.building != building]
        kind = building.split("/", maxsplit=1)[0]

        @cache
        def train() -> Judges:
            return train_judges(others, self.simulated, kind=kind, split=self.split, seed=self.seed)

        for floor in self.floors:
            if floor.building == building:
                judge = partial(self._judge_drawn, floor, train)
                self.items[PART_OF_KIND[kind]].append(measure_row(floor.item, judge, columns=()))
        for item, of_map in self.maps.items():
            if of_map == building:
                judge = partial(self._judge_map, building, train)
                self.items[LAYOUTS].append(measure_row(item, judge, columns=()))

    def _judge_drawn(self, floor: AnnotatedFloor, train: Callable[[], Judges], _: str) -> Iterator[Figures]:
        opinions = train().judge(floor.unlabelled)
        part = PART_OF_KIND[floor.kind]
        judged = JudgedFloor(part, floor.item, floor.building, floor.unlabelled, floor.floor, opinions, self.split)
        yield _describe_errors(judged)
        self.judged.append(judged)

    def _judge_map(self, building: str, train: Callable[[], Judges], item: str) -> Iterator[Figures]:
        grid, true = self._read_map(item)
        judges = train()
        found = reconstruct(replace(grid, source=item))
        on_truth = AnnotatedFloor(item, MAPS_KIND, building, true).unlabelled
        factor = self._compare_scales(item, true)
        judged = []
        for part, floor in ((LAYOUTS, found), (TRUE_LAYOUTS, on_truth)):
            opinions = judges.judge(floor) | judges.judge_rescaled(floor, factor)
            judged.append(JudgedFloor(part, item, building, floor, true, opinions, self.split))
        yield {**_describe_errors(judged[0]), "rooms": len(found.rooms), "true": len(true.rooms), "scale": factor}
        if self.pictures:
            save_figure(draw_floor(judges.places[PIANTA].label(found), grid), self.pictures / f"{item}.png")
            save_figure(draw_floor(_show_functions(true, self.split), grid), self.pictures / f"{item}_true.png")
        self.judged += judged

    def _read_map(self, item: str) -> tuple[GridMap, Floor]:
        folder = self.data / SLAM_FOLDER
        grid = read_map(folder / f"{item}.png", resolution=SLAM_RESOLUTION)
        return grid, set_building_type(read_drawing(folder / f"{item}{SLAM_TRUTH}", grid=grid), MAPS_KIND)

    def _compare_scales(self, item: str, true: Floor) -> float:
        """Lengths of the drawing in those of the map of the same floor; 1 where there is no drawing."""
        area = sum(room.polygon.area for room in true.rooms)
        drawn = (floor.floor for floor in self.floors if (floor.kind, floor.item) == (MAPS_KIND, item))
        areas = [sum(room.polygon.area for room in floor.rooms) for floor in drawn]
        return float(sqrt(areas[0] / area)) if areas else 1.0

    def measure_cost(self) -> None:
        """Time training, and reading and labelling of the map whose number of rooms found is next to TIMED_ROOMS.

        It is labelled by a model of drawn floors, as the one that comes with pianta is.
        """
        layouts = [floor for floor in self.judged if floor.part == LAYOUTS]
        if not layouts:
            return
        layout = min(layouts, key=lambda floor: abs(len(floor.found.rooms) - TIMED_ROOMS))
        train = partial(train_on, self.floors, split=self.split, seed=self.seed)
        grid, _ = self._read_map(layout.item)
        train_drawn, model = _time(train)
        train_all, _ = _time(partial(train, [*self.simulated.values()]))
        read = median(_time(partial(reconstruct, grid))[0] for _ in range(RUNS))
        label = median(_time(partial(model.label, layout.found))[0] for _ in range(RUNS))
        rooms = sum(len(floor.floor.rooms) for floor in self.floors)
        self.cost = Cost(
            len(self.floors), rooms, train_drawn, train_all, layout.item, len(layout.found.rooms), read, label
        )


def save_places(bench: PlacesBench, path: Path) -> None:
    """Write every cell of the tables, every figure of every floor, and every judged room, as JSON.

    Raises PiantaError when the file cannot be written.
    """
    more = {"split": bench.split, "seed": bench.seed, "rooms": [floor.as_json() for floor in bench.judged]}
    save_comparisons("places", tabulate_places(bench), bench.items, path, more=more)


def _start(data: Path, *, split: LabelConvention, seed: int, pictures: Path | None) -> _Run:
    floors, failed = read_annotated_floors(data)
    buildings = read_buildings_of_files(data)
    maps = {
        item: f"{MAPS_KIND}/{buildings.get(f'{SLAM_FOLDER}/{item}.png', item)}"
        for item in list_maps(data / SLAM_FOLDER, SLAM_TRUTH)
    }
    items = {part: [*failed[kind]] for kind, part in PART_OF_KIND.items()} | {SIMULATED: [], LAYOUTS: []}
    return _Run(data, split, seed, pictures, floors, maps, items)


def _describe_errors(judged: JudgedFloor) -> dict[str, float | None]:
    """Wrong rooms, %, by model, label set and, for a reconstructed floor, way of counting."""
    ways = {", FC": False, ", BC": True} if judged.part == LAYOUTS else {"": False}
    return {
        f"{model}, {label_set}{way}": 100 - 100 * semantic_accuracy(judged.pair(model, label_set, backward=backward))
        for model in judged.opinions
        for label_set in LABELS
        for way, backward in ways.items()
    }


def _show_functions(true: Floor, split: LabelConvention) -> Floor:
    """The floor with labels in F/C/E/S."""
    functions = true_labels(true, LabelSet.F_C_E_S, split=split)
    rooms = [replace(room, label=label) for room, label in zip(true.rooms, functions, strict=True)]
    return replace(true, rooms=tuple(rooms), building_type={})


Made = TypeVar("Made")


def _time(make: Callable[[], Made]) -> tuple[float, Made]:
    """Processor time, s, and what was made."""
    start = process_time()
    made = make()
    return process_time() - start, made
