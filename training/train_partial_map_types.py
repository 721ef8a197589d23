"""Train the model of the building types of maps of which a robot has seen a part, which comes with pianta.

    python training/train_partial_map_types.py READINGS [--data DIR] [--jobs N]

A robot explores drawn floors, simulated maps of made floors, and the maps of TRAINING_SETS, and its map is read at the
first decision from each of SHARES on. Descriptions of the readings are kept in the folder READINGS, a file for each
run, and are made only if they are missing: about half an hour of one core, the training itself a minute. Empty the
folder when the method of reading maps has changed.
"""

from __future__ import annotations

import argparse
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from simulated_floors import FIRST_SEED, MADE_FLOORS, MADE_TYPES
from train_map_types import TRAINING_SETS

from pianta._types import Floats
from pianta.building_types.growing_map_types import COMPLETE_EXPONENT
from pianta.building_types.map_type_file import read_default_map_type_model
from pianta.building_types.map_types import (
    FOLDS,
    MIN_TYPE_PROBABILITY,
    OTHER,
    TEMPERATURE,
    MapExamples,
    describe_map,
    name_map_features,
    soften,
    train_map_types,
)
from pianta.building_types.partial_map_type_file import DEFAULT_PARTIAL_MODEL, save_partial_map_type_model
from pianta.building_types.partial_map_types import (
    compute_weights,
    predict_left_out_parts,
    train_partial_map_types,
)
from pianta.errors import PiantaError
from pianta.evaluation.folds import leave_buildings_out
from pianta.exploration.classical_policies import InformationGain
from pianta.exploration.explore import explore
from pianta.exploration.frontiers import Frontier
from pianta.exploration.policy_input import PolicyInput
from pianta.exploration.starts import Point, find_starts
from pianta.exploration.world import World, build_world, reachable_cells, read_world
from pianta.gridmap import FREE, GridMap
from pianta.io._files import atomic_file
from pianta.layout.reconstruct import reconstruct
from pianta.rooms.features import describe_rooms
from pianta.worlds.floors import make_floor
from pianta.worlds.scan import simulate_map
from pianta.worlds.simulated_readings import draw_map_options
from pianta_bench.data.annotated_floors import read_annotated_floors
from pianta_bench.data.folders import find_data
from pianta_bench.data.typed_maps import list_typed_maps, name_training_building
from pianta_bench.exploration.campus import RADIUS, choose_starts, join_cells

# All values were chosen by hand. Free cells that were seen, over those that the middle of the robot can reach; as a
# robot also sees cells beside walls, 0.8 is 0.6 to 0.75 of all that it can see.
SHARES = (0.12, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8)
# Runs end at this share of all that can be seen.
STOP = 0.97
# Of the worlds, metres per cell; those of coarser maps stay as they are.
RESOLUTION = 0.1
# Runs on each real map: from the widest point of its largest area, and from a random one.
MAP_RUNS = 2
# Where the floors come from; in each source all types count the same, but "neither" twice.
DRAWN_SOURCE = "drawn"
MADE_SOURCE = "made"
MAPPED_SOURCE = "mapped"
# Of equal width, for calibration.
BINS = 10
# Readings with fewer rooms are left out: they are alike in all buildings.
MIN_ROOMS = 2


@dataclass(frozen=True, eq=False)
class Run:
    """A run of a robot: its name, the type and the building of its world, the world, and which start it has."""

    name: str
    building_type: str
    building: str
    open: Callable[[], World]
    start: int = 0

    @property
    def set_name(self) -> str:
        """The set of the data, or the maker of floors, that it is of."""
        return "_".join(self.name.split("_")[: 2 if self.source == MADE_SOURCE else 1])

    @property
    def source(self) -> str:
        """DRAWN_SOURCE, MADE_SOURCE or MAPPED_SOURCE."""
        return next((each for each in (DRAWN_SOURCE, MADE_SOURCE) if self.name.startswith(each)), MAPPED_SOURCE)


class Watcher:
    """Goes where most unknown area is in sight, and keeps the map at the first decision from each of SHARES on."""

    def __init__(self, area: float) -> None:
        self.policy, self.area, self.shares = InformationGain(), area, [*SHARES]
        self.maps: list[GridMap] = []

    def choose(self, inputs: PolicyInput) -> list[Frontier | None]:
        """Choose as the policy."""
        share = np.count_nonzero(inputs.cells == FREE) * inputs.resolution**2 / self.area
        passed = [each for each in self.shares if each <= share]
        if passed:
            self.maps.append(GridMap(inputs.cells.copy(), inputs.resolution, inputs.origin))
            self.shares = self.shares[len(passed) :]
        return self.policy.choose(inputs)


def list_runs(data: Path) -> Iterator[Run]:
    """All runs; buildings as of read_annotated_floors."""
    for each in list_typed_maps(data):
        if each.part in TRAINING_SETS:
            for start in range(MAP_RUNS):
                name = f"{each.part}_{each.item}_{start}"
                yield Run(name, each.building_type, each.building, partial(_open_map, each.read), start)
    floors, _ = read_annotated_floors(data)
    for floor in floors:
        name = f"{DRAWN_SOURCE}_" + floor.item.replace("/", "-")
        yield Run(name, floor.kind, floor.building, partial(build_world, floor.floor, resolution=RESOLUTION))
    for maker, count in MADE_FLOORS.items():
        for number in range(count):
            item = f"{maker}_{number}"
            yield Run(f"{MADE_SOURCE}_{item}", MADE_TYPES[maker], f"made/{item}", partial(_make_world, maker, number))


def describe_readings(run: Run, folder: Path) -> tuple[Floats, Floats]:
    """Features of the readings of a run, shape (n, features), and their shares of complete rooms, shape (n,).

    They are read from the folder if they are there.
    """
    file = folder / f"{run.name}.npz"
    if not file.is_file():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            rows = np.array([*_read_maps(run)]).reshape(-1, 1 + len(name_map_features()))
        with atomic_file(file) as temporary, temporary.open("wb") as stream:
            np.savez(stream, features=rows[:, 1:], complete=rows[:, 0])
    with np.load(file) as arrays:
        return arrays["features"], arrays["complete"]


def _read_maps(run: Run) -> Iterator[Floats]:
    """The share of complete rooms, and the features, of each reading."""
    world = run.open()
    start: Point = choose_starts(world)[run.start] if run.start else find_starts(world)[0]
    reached = reachable_cells(world, [world.cell(*start)], radius=RADIUS)
    watcher = Watcher(np.count_nonzero(reached) * world.resolution**2)
    explore(world, watcher, starts=[start], seed=0, stop=STOP)
    for grid in watcher.maps:
        try:
            floor = reconstruct(grid, predict_partial=False)
        except PiantaError:
            continue
        if len(floor) >= MIN_ROOMS:
            complete = np.mean([not room.partial for room in floor])
            yield np.array([complete, *describe_map(describe_rooms(floor))])


def _open_map(read: Callable[[], GridMap]) -> World:
    return _as_world(read())


def _make_world(maker: str, number: int) -> World:
    floor = make_floor(maker, seed=FIRST_SEED + number)
    # Entrances lead out of the map
    inner = replace(floor, doors=tuple(door for door in floor.doors if door.joins_rooms))
    options = draw_map_options(np.random.default_rng(number))
    return _as_world(simulate_map(inner, seed=FIRST_SEED + number, **options))


def _as_world(grid: GridMap) -> World:
    """The world of a map in cells of RESOLUTION or a little less."""
    return read_world(join_cells(grid, max(1, int(RESOLUTION / grid.resolution + 1e-6))))


def main() -> None:
    """Train, save, and print how good the model is on readings whose building was left out."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("readings", type=Path)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--jobs", type=int, default=1)
    arguments = parser.parse_args()
    arguments.readings.mkdir(parents=True, exist_ok=True)
    runs = [*list_runs(find_data(arguments.data))]
    described = Parallel(n_jobs=arguments.jobs)(delayed(describe_readings)(run, arguments.readings) for run in runs)
    features, complete = (np.concatenate(values) for values in zip(*described, strict=True))
    own = [run for run, (_, shares) in zip(runs, described, strict=True) for _ in shares]
    examples = MapExamples(
        features,
        tuple(run.building_type for run in own),
        tuple(name_training_building(run.building) for run in own),
        tuple(run.source for run in own),
    )
    save_partial_map_type_model(train_partial_map_types(examples), DEFAULT_PARTIAL_MODEL)
    print_figures(examples, complete, own)


def print_figures(examples: MapExamples, complete: Floats, runs: Sequence[Run]) -> None:
    """Print how good both models and their mixture are, with the building left out.

    complete: shares of rooms. runs: of each reading.
    """
    weight = (1 - complete**COMPLETE_EXPONENT)[:, None]
    by_floors = soften(predict_by_floors(examples), TEMPERATURE)
    by_parts = predict_left_out_parts(examples)
    mixed = by_floors ** (1 - weight) * by_parts**weight
    predictions = {"floors": by_floors, "parts": by_parts, "mixed": mixed / mixed.sum(axis=1, keepdims=True)}
    groups = np.array([f"{run.set_name}, {run.building_type}" for run in runs])
    print("type given and right, given and wrong, %, and logarithmic loss")
    for group, count in Counter(groups.tolist()).items():
        chosen = groups == group
        names = {run.name for run, is_in in zip(runs, chosen, strict=True) if is_in}
        text = [f"{group}: {count} readings of {len(names)} runs"]
        for name, chances in predictions.items():
            best = chances.argmax(axis=1)
            is_given = (chances.max(axis=1) >= MIN_TYPE_PROBABILITY) & (best != examples.classes.index(OTHER))
            right, wrong = (100 * (is_given & (same == (best == examples.truth)))[chosen].mean() for same in (1, 0))
            text.append(f"{name} {right:.0f} {wrong:.0f} {measure_losses(examples, chances)[chosen].mean():.2f}")
        print(", ".join(text))
    print("with the weights of the training: logarithmic loss; mean belief, right, and calibration error, %")
    for source in (None, *dict.fromkeys(examples.sources)):
        text = [source or "all"]
        for name, chances in predictions.items():
            weights = compute_weights(examples) * [source in {None, each} for each in examples.sources]
            loss = np.average(measure_losses(examples, chances), weights=weights)
            text.append(
                f"{name} {loss:.3f} " + " ".join(f"{each:.1f}" for each in calibrate(examples, chances, weights))
            )
        print(", ".join(text))
    print(
        f"{len(groups)} readings of {len({run.name for run in runs})} runs in {len(set(examples.buildings))} buildings"
    )


def measure_losses(examples: MapExamples, chances: Floats) -> Floats:
    """The logarithmic loss of each reading, shape (n,)."""
    return np.asarray(-np.log(chances[np.arange(len(chances)), examples.truth]))


def calibrate(examples: MapExamples, chances: Floats, weights: Floats) -> tuple[float, float, float]:
    """The mean probability of the likeliest answers, the share that is right, and the calibration error, all in %."""
    beliefs, is_right = chances.max(axis=1), chances.argmax(axis=1) == examples.truth
    shares = weights / weights.sum()
    bins = np.minimum((BINS * beliefs).astype(int), BINS - 1)
    differences = np.bincount(bins, shares * (beliefs - is_right))
    return 100 * shares @ beliefs, 100 * shares @ is_right, 100 * np.abs(differences).sum()


def predict_by_floors(examples: MapExamples) -> Floats:
    """Votes of forests of whole floors without the building, shape (n, classes)."""
    floors = read_default_map_type_model().examples
    votes = np.zeros((len(examples.types), len(floors.classes)))
    for _, held_out in leave_buildings_out(examples.buildings, parts=FOLDS):
        buildings = {examples.buildings[row] for row in held_out.tolist()}
        others = floors.select(np.array([building not in buildings for building in floors.buildings]))
        votes[held_out] = train_map_types(others).forest.predict(examples.features[held_out])
    return votes


if __name__ == "__main__":
    main()
