"""Compare the ways of `pianta evacuate` with shortest paths on a grid: python benchmarks/compare_ways.py.

Drawn schools of the data; the grid has cells of 0.1 m and walls of 0.1 m, and steps to eight neighbours.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator

import numpy as np

from pianta.errors import BuildingWarning
from pianta.evacuation.evacuate import evacuate
from pianta.exploration.routes import measure_distances
from pianta.exploration.world import build_world
from pianta.floor import Floor
from pianta_bench.data.annotated_floors import read_drawing
from pianta_bench.data.folders import find_data, list_maps

WALL = 0.1  # metres; thinner than in reality, as outlines are drawn in the middle of walls


def main() -> None:
    """Print the quantiles of the lengths on the grid, as shares of those of `evacuate`."""
    warnings.simplefilter("ignore", BuildingWarning)
    folder = find_data() / "buildings" / "school"
    names = list_maps(folder, ".xml")
    shares = np.array([share for name in names for share in compare_floor(read_drawing(folder / f"{name}.xml"))])
    low, first, middle, last, high = np.percentile(shares, (0, 1, 50, 99, 100))
    print(f"{len(names)} schools, {len(shares)} rooms: median {middle:.3f}, 98 % of them {first:.3f} to {last:.3f}")
    print(f"least {low:.3f}, most {high:.3f}")


def compare_floor(floor: Floor) -> Iterator[float]:
    """The length on the grid per that of `evacuate`, from the middle of each room that has a way on both."""
    evacuation = evacuate(floor)
    world = build_world(floor, wall=WALL)
    sources = np.argwhere(np.isin(world.room_of_cell, evacuation.exit_rooms))
    distances = measure_distances(
        world.free, [(row, col) for row, col in sources.tolist()], resolution=world.resolution
    )
    for way in evacuation.ways:
        if len(way.line):
            on_grid = distances[world.cell(*way.line[0].tolist())]
            if np.isfinite(on_grid):
                yield float(on_grid / way.distance)


if __name__ == "__main__":
    main()
