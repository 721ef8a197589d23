"""Lessons of the network of partial shapes: python training/partial_lessons.py LESSONS [--data DIR].

A file for each map of partial_maps.py, which begins with its source and its building: what the network sees of each
partial room, its true shape, and how much of that was explored. A lesson that is there is kept.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np
import shapely
from lesson_files import write_lesson
from partial_maps import Job, add_data_option, list_jobs

from pianta.errors import PiantaError
from pianta.layout._label_images import SNAP_DISTANCE
from pianta.layout.partial.scene import FloorIndex, ObservedCells, build_scene, find_main_direction, make_view
from pianta.layout.partial.shape_network import draw_patch, shrink_mask
from pianta.layout.reconstruct import find_rooms
from pianta_bench.data.folders import find_data
from pianta_bench.partial.maps import PartialMap
from pianta_bench.partial.measure import measure_unseen


def make_lesson(partial_map: PartialMap) -> dict[str, np.ndarray]:
    """layers, shape (N, 11, 80, 80), truth, shape (N, 80, 80), and the shares of the true rooms, (N,)."""
    floor = find_rooms(partial_map.grid, method="structure")
    index, cells = FloorIndex.from_floor(floor), ObservedCells.from_grid(partial_map.grid)
    true = np.array(partial_map.rooms, dtype=object)
    lesson: dict[str, list] = {"layers": [], "truth": [], "seen_share": [], "unseen_share": []}
    for room in floor.rooms:
        shared = shapely.area(shapely.intersection(true, room.polygon, grid_size=SNAP_DISTANCE))
        if not room.partial or not shared.any():
            continue
        best = true[int(shared.argmax())]
        scene = build_scene(index, room, cells, make_view(room, find_main_direction(index, room), partial_map.grid))
        layers, matrix = draw_patch(scene)
        lesson["layers"].append(layers)
        lesson["truth"].append(shrink_mask(scene.view.draw([best]), matrix).astype(np.uint8))
        lesson["seen_share"].append(shared.max() / best.area)
        lesson["unseen_share"].append(measure_unseen(best, partial_map.grid))
    return {name: np.array(values) for name, values in lesson.items()}


def write_lesson_of(job: Job, data: Path, folder: Path) -> None:
    """Write the lesson of a map, unless it is there, or the map cannot be made or shows no room."""
    file = folder / f"{job.name}.npz"
    if not file.exists():
        try:
            write_lesson(file, make_lesson(job.read(data)))
        except PiantaError as error:
            sys.stderr.write(f"{job.name}: {error}\n")


def main() -> None:
    """Write all lessons."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    add_data_option(parser)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    data = find_data(options.data)
    for job in list_jobs(data):
        write_lesson_of(job, data, options.folder)


if __name__ == "__main__":
    main()
