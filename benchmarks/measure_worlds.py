"""Measure the worlds that `pianta generate --scan` makes: ways of a robot, furniture, time and sizes of files.

Run: OMP_NUM_THREADS=1 python benchmarks/measure_worlds.py [--data DIR] [--count N] [--seed S] [--json FILE]

A model of all schools of the data generates buildings, which are drawn, furnished and scanned as the command does it,
with its options as they are by default. A robot gets into a room if the cells at which it fits join this room, by 8
neighbours, with where it has most space, on the true map. Furniture without ways is that of which no piece was taken
out. Time is that of the processor for a world with its scan, from the floor on.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path
from statistics import fmean, pstdev
from time import process_time

import pianta
from pianta.batch.generate_batch import draw_plans
from pianta.batch.world_folders import FURNITURE, WorldOptions, save_world
from pianta.errors import BuildingWarning
from pianta.floor import Floor
from pianta.generation.buildings import find_building_seed
from pianta.io.floors import read_floor
from pianta.navigation.robot import ROBOT_RADIUS
from pianta.worlds.furnish import furnish
from pianta_bench.data.folders import find_data
from pianta_bench.drawing.circle import count_reached_rooms

TYPE = "school"
COUNT = 24  # buildings
SEED = 2  # that of the figures in docs/methods/generation.md
MEGABYTE = 1e6  # bytes
NAME = "building"

Figures = dict[str, float]


def main() -> None:
    """Print the figures of the worlds."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    warnings.simplefilter("ignore", BuildingWarning)
    files = sorted((find_data(options.data) / "buildings" / TYPE).glob("*.xml"))
    model = pianta.train_type([pianta.read_building(file) for file in files])
    buildings = pianta.generate(model, options.count, seed=options.seed)
    rows = []
    for number, plan in enumerate(draw_plans(buildings, model, seed=options.seed)):
        if plan is None:
            print(f"building {number + 1} could not be drawn")
            continue
        rows.append(measure_world(plan.floor, seed=find_building_seed(options.seed, number)))
        print(f"building {number + 1}", " ".join(f"{key}={value:g}" for key, value in rows[-1].items()), flush=True)
    print_summary(rows)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


def measure_world(floor: Floor, *, seed: int) -> Figures:
    """The figures of the world of a drawn floor."""
    with tempfile.TemporaryDirectory() as folder:
        start = process_time()
        save_world(floor, NAME, Path(folder), WorldOptions(scan=True), seed=seed)
        seconds = process_time() - start
        world = Path(folder) / NAME
        truth = read_floor(world / "truth.geojson")
        sizes = {file: (world / file).stat().st_size / MEGABYTE for file in ("world.sdf", "truth.geojson")}
    # Before pieces on the ways of robots are taken out
    full = furnish(floor, furniture=FURNITURE, dense_furniture=True, seed=seed)
    return {
        "rooms": len(floor),
        "reached": count_reached_rooms(truth),
        "reached without ways": count_reached_rooms(full),
        "parts": len(full.furniture),
        "parts taken out": len(full.furniture) - len(truth.furniture),
        "seconds": seconds,
        **sizes,
    }


def print_summary(rows: Sequence[Figures]) -> None:
    """Print the sums and means of worlds."""
    sums = {key: sum(row[key] for row in rows) for key in rows[0]}
    spread = {key: describe_values([row[key] for row in rows]) for key in rows[0]}
    print(f"{len(rows)} buildings, rooms: {spread['rooms']}")
    print(
        f"rooms that a robot of radius {ROBOT_RADIUS} m does not get into: {sums['rooms'] - sums['reached']:g} of "
        f"{sums['rooms']:g}; with all furniture {sums['rooms'] - sums['reached without ways']:g}"
    )
    share = sums["parts taken out"] / sums["parts"]
    print(f"parts of furniture taken out: {sums['parts taken out']:g} of {sums['parts']:g} ({share:.1%})")
    print(f"processor time for a world with its scan, s: {spread['seconds']}")
    for file in ("world.sdf", "truth.geojson"):
        print(f"{file}, MB: {spread[file]}")


def describe_values(values: Sequence[float]) -> str:
    """Mean, standard deviation, minimum and maximum.

    >>> describe_values([1.0, 3.0])
    '2.0 ± 1.0, 1.0 to 3.0'
    """
    return f"{fmean(values):.1f} ± {pstdev(values):.1f}, {min(values):.1f} to {max(values):.1f}"


if __name__ == "__main__":
    main()
