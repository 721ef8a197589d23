"""Score possible doors on simulated maps whose shut doors are known, and count them on real maps.

Run: OMP_NUM_THREADS=1 python benchmarks/score_possible_doors.py [--choose] [--maps] [--data DIR]

The worlds have leaves at their doors, furniture and noise. Where the seed is odd, the rooms that no open door leads to
were not seen, as by a robot that opens no door. A possible door is right if its middle is at most half the width of
the door from the middle of a shut one, one to one; doors between two rooms that were not seen do not count.
Precision and recall of the thresholds in use are measured on SCORED_SEEDS. --choose prints a table of thresholds on
CHOOSING_SEEDS instead. --maps counts possible doors on the maps of `robotmaps`, `clutter` and `vacuum`.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import NamedTuple

import networkx as nx
import numpy as np
import shapely

import pianta
from pianta.evaluation.coverage import count_matches
from pianta.evaluation.doors import DetectionScores
from pianta.floor import Door, Floor, cells_of_polygon
from pianta.gridmap import UNKNOWN, GridMap
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.possible_doors import THRESHOLDS, Thresholds
from pianta.layout.structure.reconstruct import Division, divide_floor, find_doors, list_possible_doors
from pianta.worlds.floors import make_floor
from pianta.worlds.scan import list_shut_doors, simulate_map
from pianta_bench.data.folders import find_data

WORLDS = ("corridor", "l", "ring", "hall", "home", "office", "ward", "open_plan")
CHOOSING_SEEDS = range(100, 110)
SCORED_SEEDS = range(200, 210)
# By the remainder of the seed.
NOISE = (0.0, 0.2, 0.4)
FURNITURE = (0.3, 0.6)
# Faces of the walls of unseen rooms are unknown too; metres.
FACE_DEPTH = 0.07
CELL_PROBABILITIES = (0.4, 0.5, 0.55, 0.6)
INNER_PROBABILITIES = (0.55, 0.6, 0.65, 0.7)
PARAMETERS = StructureParameters()


class World(NamedTuple):
    """A division of a simulated map, its open doors that were found, and the shut ones with a room that was seen.

    inner: shut doors between two rooms. outer: those between a room and one that was not seen.
    """

    division: Division
    doors: list[Door]
    inner: list[Door]
    outer: list[Door]


def main() -> None:
    """Print the scores, or a table of thresholds, or numbers on real maps."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--choose", action="store_true")
    parser.add_argument("--maps", action="store_true")
    parser.add_argument("--data", type=Path)
    options = parser.parse_args()
    if options.maps:
        count_on_maps(find_data(options.data))
        return
    worlds = [*make_worlds(CHOOSING_SEEDS if options.choose else SCORED_SEEDS)]
    if options.choose:
        for cell, inner in product(CELL_PROBABILITIES, INNER_PROBABILITIES):
            print_scores(worlds, Thresholds(cell, inner, inner))
    else:
        print_scores(worlds, THRESHOLDS)


def make_worlds(seeds: Iterable[int]) -> Iterator[World]:
    """A world of each name and seed."""
    for name, seed in product(WORLDS, seeds):
        floor, shut = make_floor(name, seed=seed), set(list_shut_doors(make_floor(name, seed=seed), seed=seed))
        grid = simulate_map(
            floor,
            seed=seed,
            noise=NOISE[seed % len(NOISE)],
            furniture=FURNITURE[seed % len(FURNITURE)],
            dense_furniture=seed % 2 == 0,
            door_leaves=True,
        )
        unseen = find_unreached_rooms(floor, shut) if seed % 2 else set()
        division = divide_floor(hide_rooms(floor, grid, unseen), PARAMETERS)
        shut_doors = [floor.doors[index] for index in sorted(shut)]
        inner = [door for door in shut_doors if unseen.isdisjoint(door.room_ids)]
        outer = [door for door in shut_doors if len(unseen.intersection(door.room_ids)) == 1]
        yield World(division, find_doors(division, list_rooms(division), PARAMETERS), inner, outer)


def find_unreached_rooms(floor: Floor, shut: set[int]) -> set[int]:
    """Ids of the rooms that no open door joins to most of the floor."""
    graph = nx.Graph()
    graph.add_nodes_from(room.id for room in floor.rooms)
    graph.add_edges_from(door.rooms for index, door in enumerate(floor.doors) if index not in shut)
    return set(graph) - max(nx.connected_components(graph), key=len)


def hide_rooms(floor: Floor, grid: GridMap, rooms: set[int]) -> GridMap:
    """The map on which these rooms were not seen."""
    cells = grid.cells.copy()
    for room in rooms:
        rows, cols, inside = cells_of_polygon(floor[room].polygon.buffer(FACE_DEPTH, join_style="mitre"), grid)
        cells[rows, cols][inside] = UNKNOWN
    return GridMap(cells, grid.resolution, grid.origin)


def list_rooms(division: Division) -> list[int]:
    """The labels of a division."""
    return [label for label in np.unique(division.labels).tolist() if label]


def print_scores(worlds: list[World], thresholds: Thresholds) -> None:
    """Print precision and recall of both kinds of possible doors, pooled over the worlds."""
    doors_of_worlds = [
        list_possible_doors(world.division, list_rooms(world.division), world.doors, thresholds) for world in worlds
    ]
    print(f"cell {thresholds.cell:.2f}, inner {thresholds.inner:.2f}, outer {thresholds.outer:.2f}", end="")
    for sides, is_outer in (("between rooms", False), ("to the unseen", True)):
        chosen = [[door for door in doors if door.is_entrance == is_outer] for doors in doors_of_worlds]
        true = [world.outer if is_outer else world.inner for world in worlds]
        # The rooms on both sides may be one on the map, or one of them outside
        right = sum(map(count_right, chosen, (world.inner + world.outer for world in worlds)))
        scores = DetectionScores(sum(map(len, true)), sum(map(len, chosen)), right)
        counts = f"{scores.correct} of {scores.detected} right, {scores.true} true"
        print(f" | {sides}: {counts}, P {scores.precision:.2f} R {scores.recall:.2f} F1 {scores.f1:.2f}", end="")
    print(flush=True)


def count_right(doors: list[Door], true: list[Door]) -> int:
    """How many doors match a true one, one to one, within half its width."""
    distances = [[find_middle(door).distance(find_middle(other)) for other in true] for door in doors]
    reaches = [door.width / 2 for door in true]
    return count_matches(np.reshape(distances, (len(doors), len(true))) <= reaches)


def find_middle(door: Door) -> shapely.Point:
    """The middle of a door."""
    return door.line.interpolate(0.5, normalized=True)


def count_on_maps(data: Path) -> None:
    """Print the numbers of rooms, doors and possible doors on each real map, and their sums."""
    print(f"{'map':45}{'rooms':>8}{'doors':>8}{'possible':>10}{'of them to the unseen':>24}")
    for name, pattern in (("robotmaps", "*/*.yaml"), ("vacuum", "*.yaml"), ("clutter", "*_gt.png")):
        total = np.zeros(4, int)
        for file in sorted((data / name).glob(pattern)):
            grid = read_map(file)
            floor = pianta.reconstruct(grid, predict_partial=False)
            entrances = sum(door.is_entrance for door in floor.possible_doors)
            counts = len(floor), len(floor.doors), len(floor.possible_doors), entrances
            print_row(f"{name}/{file.stem.removesuffix('_gt')}", counts)
            total += counts
        print_row(f"{name}, all", total.tolist())


def read_map(file: Path) -> GridMap:
    """The map of a YAML, or of an image of the true rooms; cells of 0.05 m."""
    if file.suffix == ".yaml":
        return pianta.read_map(file)
    return pianta.read_map(file.with_stem(file.stem.removesuffix("_gt")), resolution=0.05)


def print_row(name: str, counts: Sequence[int]) -> None:
    """Print a row of the table of real maps."""
    rooms, doors, possible, entrances = counts
    print(f"{name:45}{rooms:8}{doors:8}{possible:10}{entrances:24}", flush=True)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main()
