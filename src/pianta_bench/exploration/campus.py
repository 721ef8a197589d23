"""Campus floors, maps without labels, as buildings to explore: their cells, and where robots start."""

from __future__ import annotations

from math import ceil, isclose
from pathlib import Path

import numpy as np

from pianta.errors import DataError, OptionError, PiantaError
from pianta.exploration.starts import Point, find_starts
from pianta.exploration.world import World, reachable_cells
from pianta.floor import Floor
from pianta.gridmap import FREE, OCCUPIED, GridMap
from pianta.io._files import one_line_reason
from pianta.io.maps import read_map
from pianta_bench.data.folders import list_maps
from pianta_bench.data.map_sets import RESOLUTION
from pianta_bench.exploration import CAMPUS
from pianta_bench.exploration.buildings import BuildingSet, ExploredBuilding

# Of the files with the true rooms, which have no labels.
TRUTH_ENDING = "_rooms.png"
# Campus floors have no entrances; a robot starts at this many points at most. Chosen by hand.
MAX_STARTS = 3
RADIUS = 0.2  # of the robot, m
# The points do not depend on --seed, so that runs with other noise start at the same ones.
START_SEED = 0


def read_campus(data: Path) -> BuildingSet:
    """The maps data/kth/NAME.png for which there is a NAME_rooms.png; raises DataError if none can be read."""
    folder = data / CAMPUS
    buildings: list[ExploredBuilding] = []
    failures: dict[str, str] = {}
    for name in list_maps(folder, TRUTH_ENDING):
        try:
            grid = read_map(folder / f"{name}.png", resolution=RESOLUTION)
            if not grid.free.any():
                raise DataError("the map has no free cell, give one with white floors")
        except (PiantaError, OSError) as error:
            failures[name] = one_line_reason(error)
        else:
            buildings.append(ExploredBuilding(CAMPUS, name, Floor(()), grid=grid))
    if not buildings:
        name, reason = next(iter(failures.items()))
        raise DataError(f"no map of {CAMPUS} can be read, the first: {name}, {reason}")
    return BuildingSet(tuple(buildings), failures)


def count_joined(resolution: float) -> int:
    """The number of cells of a campus map on a side of one of this size, m; raises OptionError if they do not fit."""
    side = round(resolution / RESOLUTION)
    if side < 1 or not isclose(side * RESOLUTION, resolution):
        raise OptionError(
            f"resolution is {resolution}, give a multiple of {RESOLUTION} m, the cells of the maps of {CAMPUS}"
        )
    return side


def join_cells(grid: GridMap, side: int) -> GridMap:
    """The map in cells of side × side of its own, free if all of these are, so that no wall opens; else occupied."""
    height, width = grid.shape
    rows, cols = ceil(height / side), ceil(width / side)
    free = np.zeros((rows * side, cols * side), bool)
    free[:height, :width] = grid.free
    joined = free.reshape(rows, side, cols, side).all(axis=(1, 3))
    x, y, yaw = grid.origin
    origin = x, y - (rows * side - height) * grid.resolution, yaw
    return GridMap(np.where(joined, FREE, OCCUPIED), side * grid.resolution, origin, grid.source)


def choose_starts(world: World, count: int = MAX_STARTS) -> list[Point]:
    """The widest point of the largest area that the robot can drive in, and random ones of it; x, y, m."""
    widest = find_starts(world, radius=RADIUS)[0]
    cells = np.argwhere(reachable_cells(world, [world.cell(*widest)], radius=RADIUS))
    chosen = cells[np.random.default_rng(START_SEED).integers(len(cells), size=count - 1)].tolist()
    return [widest, *(world.point((row, col)) for row, col in chosen)]
