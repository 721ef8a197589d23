"""Readings of simulated, furnished maps of drawn and made floors, as training data of rooms and building types.

    python training/simulated_floors.py READINGS [--data DIR]

A reading is a floor in READINGS/ITEM_N.geojson, with its true labels and building type; one that is there already is
kept, so that an interrupted run goes on. Made floors have the types of MADE_TYPES: "other" is no type of building, but
stands for places that are neither schools nor offices. It takes about ten minutes of one core.
The shares and numbers of this module were chosen by hand.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from pianta.errors import PiantaError
from pianta.floor import Floor
from pianta.io.floors import read_floor, save_floor
from pianta.worlds.floors import make_floor
from pianta.worlds.simulated_readings import simulate_and_reconstruct
from pianta_bench.data.annotated_floors import read_annotated_floors
from pianta_bench.data.folders import find_data

# Maps of each drawn floor, by its type: there are three times as many schools.
DRAWN_MAPS = {"school": 3, "office": 6}
# Building type of each maker of pianta.worlds, and the number of floors that it makes.
MADE_TYPES = {"home": "other", "ward": "other", "depot": "other", "office": "office", "open_plan": "office"}
MADE_FLOORS = {"home": 24, "ward": 16, "depot": 14, "office": 20, "open_plan": 10}
# First seed of the made floors; those of the lessons of map_lessons.py are random, and far larger.
FIRST_SEED = 1000


@dataclass(frozen=True, eq=False)
class Example:
    """A floor to be mapped: its name, building, and whether it has walls between its rooms."""

    name: str
    building: str
    floor: Floor
    seed: int
    walls_are_drawn: bool


@dataclass(frozen=True, eq=False)
class SimulatedFloor:
    """A reading with true labels; item: the drawn floor or the made one. building: as of read_annotated_floors."""

    item: str
    building: str
    floor: Floor


def list_examples(data: Path) -> Iterator[Example]:
    """All floors to be mapped, first one map of each."""
    floors, _ = read_annotated_floors(data)
    made_floors = [(maker, number) for maker, count in MADE_FLOORS.items() for number in range(count)]
    for turn in range(max(DRAWN_MAPS.values())):
        for index, each in enumerate(floors):
            if turn < DRAWN_MAPS[each.kind]:
                yield Example(
                    f"{each.item}_{turn}", each.building, each.floor, 100 * turn + index, walls_are_drawn=False
                )
        if turn == 0:
            for maker, number in made_floors:
                seed = FIRST_SEED + number
                floor = replace(make_floor(maker, seed=seed), building_type={MADE_TYPES[maker]: 1.0})
                yield Example(f"made_{maker}_{number}", f"made/{maker}_{number}", floor, seed, walls_are_drawn=True)


def read_simulated_floors(data: Path, folder: Path) -> list[SimulatedFloor]:
    """The readings in a folder; those that are missing are made, except of maps that show no room."""
    folder.mkdir(parents=True, exist_ok=True)
    readings = []
    for example in list_examples(data):
        file = folder / f"{example.name}.geojson"
        if not file.is_file():
            try:
                reading = simulate_and_reconstruct(
                    example.floor, seed=example.seed, furnished=True, walls_are_drawn=example.walls_are_drawn
                )
            except PiantaError:
                continue
            if not reading.rooms:
                continue
            # Walls and furniture are no features, and would make large files.
            save_floor(replace(reading, walls=(), furniture=()), file)
        readings.append(SimulatedFloor(example.name, example.building, read_floor(file)))
    return readings


def main() -> None:
    """Make the readings that are missing in a folder."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("readings", type=Path)
    parser.add_argument("--data", type=Path)
    arguments = parser.parse_args()
    readings = read_simulated_floors(find_data(arguments.data), arguments.readings)
    print(f"{len(readings)} readings in {arguments.readings}")


if __name__ == "__main__":
    main()
