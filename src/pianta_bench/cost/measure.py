"""How the cost of a method grows, and of its stages: one floor against sixteen of them on one map."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from statistics import median

import numpy as np

from pianta.gridmap import UNKNOWN, GridMap
from pianta.layout.reconstruct import DEFAULT_METHOD, METHODS, check_method
from pianta.worlds.floors import make_ring_floor
from pianta.worlds.scan import simulate_map
from pianta_bench.cost.stages import profile_reading
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.layout.timing import time_reconstruction

SIDE_CELLS = 1000  # cells along each side of the map of one floor
TILES = 4  # floors along each side of the large map
UNSEEN = 0.15  # of each floor whose reading is split into stages: rooms at its end are partial
SMALL_RUNS = 3  # runs on one floor; their median counts


def measure(
    *, methods: Sequence[str] | None = None, side: int = SIDE_CELLS, tiles: int = TILES, track: Track = iter
) -> Results:
    """Costs of methods on a generated floor of side × side cells, and on tiles × tiles copies of it, unknown between.

    Each map is read in a process of its own, so that its peak memory can be measured.
    methods: of METHODS, all unless given. track: wraps what is measured, to show progress.
    Raises OptionError for the name of no method.
    """
    methods = tuple(dict.fromkeys(methods or METHODS))
    for method in methods:
        check_method(method)
    results = Results({"methods": methods, "tiles": tiles * tiles})
    jobs = [(method, count) for method in methods for count in (1, tiles)]
    tracked = track([f"{count * count} floors, {method}" for method, count in jobs])
    for (method, count), _ in zip(jobs, tracked, strict=True):
        floors = count * count
        measure_one = partial(_measure_apart, method, side, count)
        results.measure("cost", f"{floors} floors, {method}", measure_one, method=method, floors=floors)
    if DEFAULT_METHOD in methods:
        for count, name in zip(
            (1, tiles), track([f"stages, {count * count} floors" for count in (1, tiles)]), strict=True
        ):
            profile = partial(_profile_apart, side, count)
            results.measure("stages", name, profile, names=("stage",), metric="seconds", floors=count * count)
    return results


def tile_floor(side: int, tiles: int, *, unseen: float = 0.0) -> GridMap:
    """A generated floor with a ring corridor and furniture, tiles × tiles times, each in side × side cells.

    unseen: the share of the rows of each floor, the last ones, that the robot has not seen.
    """
    length = side * 0.05 - 13
    grid = simulate_map(make_ring_floor(length=length, width=length), furniture=0.3)
    cells = np.full((side, side), UNKNOWN, np.int8)
    rows, cols = grid.shape
    cells[:rows, :cols] = grid.cells
    cells[round((1 - unseen) * rows) :] = UNKNOWN
    return GridMap(np.tile(cells, (tiles, tiles)), grid.resolution)


def _measure_apart(method: str, side: int, tiles: int) -> Iterator[Figures]:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        yield pool.submit(measure_cost, method, side, tiles).result()


def _profile_apart(side: int, tiles: int) -> Iterator[Figures]:
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        yield pool.submit(profile_reading, tile_floor(side, tiles, unseen=UNSEEN)).result()


def measure_cost(method: str, side: int, tiles: int) -> Figures:
    """Cells and rooms of a map, and seconds, exact distance transforms and peak MB of a method on it."""
    import resource

    grid = tile_floor(side, tiles)
    runs = [time_reconstruction(grid, method=method) for _ in range(SMALL_RUNS if tiles == 1 else 1)]
    seconds, transforms = (median(time[key] or 0.0 for _, time in runs) for key in ("seconds", "transforms"))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1e6 if sys.platform == "darwin" else 1e3)
    rooms = len(runs[0][0].rooms)
    return {"cells": grid.cells.size, "rooms": rooms, "seconds": seconds, "transforms": transforms, "megabytes": peak}
