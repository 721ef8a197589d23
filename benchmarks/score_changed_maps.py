"""Compare the rooms of maps with those of the same maps at half the resolution or rotated, method `structure`.

Run: OMP_NUM_THREADS=1 python benchmarks/score_changed_maps.py [--data DIR]

The changes are those of tests/test_invariance.py; 24 made floors without and with noise and furniture, and the survey.
Printed are the maps that keep their number of rooms, the share of rooms that keep their area within 5 %, and the
greatest change of the number of rooms.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from pianta.gridmap import GridMap
from pianta.layout.reconstruct import reconstruct
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta.worlds.scan import simulate_map
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import choose_sets

sys.path.append(str(Path(__file__).parents[1]))
from tests.test_invariance import (
    View,
    find_rooms,
    match_areas,
    polygons_of,
    view_every_second,
    view_pooled,
    view_turned,
)

SEEDS = range(20, 26)
NOISE = {"clean": (0.0, 0.0), "noise 0.3, furniture 0.2": (0.3, 0.2)}
VIEWS: dict[str, Callable[[GridMap], View]] = {
    "half the resolution, a cell is free when its parts are": view_pooled,
    "half the resolution, every other cell": view_every_second,
    "turned by 17°": view_turned,
}
# Largest change of the area of a room that keeps it.
MAX_CHANGE = 0.05


def main() -> None:
    """Print the figures of each set and change."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path)
    for name, grids in read_sets(find_data(parser.parse_args().data)):
        rooms = [polygons_of(reconstruct(grid, predict_partial=False)) for grid in grids]
        for change, view in VIEWS.items():
            others = [find_rooms(view(grid), grid, "structure") for grid in grids]
            counts = np.array([(len(one), len(other)) for one, other in zip(rooms, others, strict=True)])
            areas = np.concatenate([match_areas(one, other) for one, other in zip(rooms, others, strict=True)])
            sys.stdout.write(
                f"{name}, {change}: {(counts[:, 0] == counts[:, 1]).sum()} of {len(grids)} maps, "
                f"{(np.abs(areas - 1) <= MAX_CHANGE).mean():.0%} of the rooms, "
                f"number of rooms changed by up to {(np.abs(counts[:, 1] / counts[:, 0] - 1)).max():.0%}\n"
            )
            sys.stdout.flush()


def read_sets(data: Path) -> Iterator[tuple[str, list[GridMap]]]:
    """Names of sets of maps, and their maps."""
    for name, (noise, furniture) in NOISE.items():
        floors = [make_floor(floor_type, seed=seed) for floor_type in FLOOR_MAKERS for seed in SEEDS]
        yield name, [simulate_map(floor, noise=noise, furniture=furniture, seed=20) for floor in floors]
    ((mapset, items),) = choose_sets(("survey",), data).items()
    yield "survey", [mapset.read(data / mapset.folder, item).grid for item in items]


if __name__ == "__main__":
    main()
