"""Measure what an update of a mapper costs on floors of 50 to 62 rooms in cells of 0.05 m, beside a whole reading.

Run: OMP_NUM_THREADS=1 python benchmarks/time_updates.py [--data DIR] [--count N] [--seed S] [--json FILE]

A model of all schools of the data generates buildings, which are drawn, furnished and scanned. Their maps are revealed
in steps of 4 m of way from a free cell, then distorted by up to 0.8 m from left to right, as by a loop closure, and
read until nothing waits. Time is that of the processor. Rooms F1 compares the last floor with a whole reading, and
after the distortion with a whole reading of the distorted map.
"""

from __future__ import annotations

import argparse
import json
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import cv2
import numpy as np
from skimage.graph import MCP_Geometric

import pianta
from pianta import GridMap, Mapper
from pianta.floor import Floor
from pianta.worlds.scan import simulate_map
from pianta_bench.data.folders import find_data

TYPE = "school"
COUNT = 4  # buildings
ROOMS = (50, 62)
FURNITURE, NOISE = 0.5, 0.2  # of the scan
FIRST, STEP = 6.0, 4.0  # m of way that is seen at first, and more at each update
RIM = 0.2  # m beyond the free cells that are seen: their walls
MOTION = 0.8  # m by which the right end of the map moves
LIMIT = 1.0  # s


def main() -> None:
    """Print the figures of each building, and those of all updates."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    files = sorted((find_data(options.data) / "buildings" / TYPE).glob("*.xml"))
    model = pianta.train_type([pianta.read_building(file) for file in files])
    graphs = pianta.generate(model, options.count, rooms=ROOMS, seed=options.seed)
    rows = []
    for number, graph in enumerate(graphs):
        floor = pianta.draw_plan(graph, model, seed=number).floor
        rows.append(measure(floor, seed=number))
        print(f"building {number + 1}", " ".join(f"{key}={value}" for key, value in rows[-1].items()), flush=True)
    for part in ("growing", "closure"):
        seconds = np.concatenate([row[f"{part}, s"] for row in rows])
        above = np.count_nonzero(seconds > LIMIT)
        print(f"{part}: {len(seconds)} updates, {seconds.mean():.2f} ± {seconds.std():.2f} s, at most", end=" ")
        print(f"{seconds.max():.2f}, {above} above {LIMIT:g} s")
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


def measure(floor: Floor, *, seed: int) -> dict[str, Any]:
    """The seconds of all updates on the map of a floor, and how the floors compare with those of whole readings."""
    grid = simulate_map(floor, furniture=FURNITURE, noise=NOISE, seed=seed)
    # What is imported and read from files once is not of an update
    Mapper().update(pianta.make_world("corridor")[1])
    mapper, growing, closure = Mapper(), [], []
    for part in reveal(grid):
        last = part
        growing.append(time_update(mapper, part))
    while mapper.state is not None and mapper.state.as_read is not None:
        growing.append(time_update(mapper, last))
    start = process_time()
    reading = Mapper().update(last).floor
    seconds = process_time() - start
    scores = pianta.score_floor(mapper.floor, reading)
    before = {room.id for room in mapper.floor}
    moved = distort(last)
    closure.append(time_update(mapper, moved))
    while mapper.state is not None and mapper.state.as_read is not None:
        closure.append(time_update(mapper, moved))
    moved_scores = pianta.score_floor(mapper.floor, pianta.reconstruct(moved))
    return {
        "rooms": len(floor),
        "whole, s": round(seconds, 2),
        "growing, s": [round(value, 2) for value in growing],
        "rooms F1": round(scores.rooms.f1, 3),
        "closure, s": [round(value, 2) for value in closure],
        "rooms F1, closure": round(moved_scores.rooms.f1, 3),
        "ids that stay": len(before & {room.id for room in mapper.floor}) / len(before),
    }


def time_update(mapper: Mapper, grid: GridMap) -> float:
    """Seconds of the processor of an update."""
    start = process_time()
    mapper.update(grid)
    return process_time() - start


def reveal(grid: GridMap) -> Iterator[GridMap]:
    """Maps of a robot that has seen all free cells up to a length of way, and their walls."""
    free = np.argwhere(grid.free)
    costs = np.where(grid.free, 1.0, -1.0)
    distances, _ = MCP_Geometric(costs).find_costs([tuple(free[len(free) // 3])])
    distances *= grid.resolution
    farthest = distances[np.isfinite(distances)].max()
    side = 2 * round(RIM / grid.resolution) + 1
    for reach in np.arange(FIRST, farthest + STEP, STEP):
        is_seen = cv2.dilate((distances <= reach).astype(np.uint8), np.ones((side, side), np.uint8)) > 0
        yield replace(grid, cells=np.where(is_seen, grid.cells, -1))


def distort(grid: GridMap) -> GridMap:
    """The map with columns moved down, the more the farther they are to the right."""
    cells, width = grid.cells.copy(), grid.shape[1]
    for col in range(width):
        cells[:, col] = np.roll(cells[:, col], round(col / width * MOTION / grid.resolution))
    return replace(grid, cells=cells)


if __name__ == "__main__":
    main()
