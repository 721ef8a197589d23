"""Lessons of the real maps whose rooms are annotated, for the last fit of the network of map regions.

    python training/annotated_lessons.py ANNOTATED [--data DIR]

One file for each map of the sets clutter, vacuum, survey and furniture, as map_lessons.py writes them; its name begins
with the building, so that fit_map_regions.py can leave whole buildings out. Annotations have rooms only: where a cell
is surely floor it has that class, elsewhere it has UNKNOWN_CLASS, and only its room counts.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np
from lesson_files import FINE_CELLS, UNKNOWN_CLASS, Lesson, write_lesson

from pianta._types import LabelImage
from pianta.layout._label_images import grow_mask
from pianta.layout._working_grid import to_working_grid
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.evidence import FLOOR, FURNITURE, OFFSETS, Evidence, align_shares
from pianta.layout.structure.reconstruct import remove_noise
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import TrueMap, choose_sets

SETS = ("clutter", "vacuum", "survey", "furniture")
# The buildings that are left out together where figures are reported (benchmarks/score_left_out_buildings.py): each
# group has maps of several sets, chosen by hand.
FOLDS = (
    ("freiburg79", "d9_1093_huge", "officea", "officei"),
    ("freiburg101", "home1058", "labc", "officeb"),
    ("g4s", "converted_3790", "S5_FW2020_with_segments", "officec", "labf"),
    ("umicfirstfloor", "misc_monastery_with_cutoff", "nlb", "officed", "officef"),
)
# Cells nearer than this to another room may be in a door; cells (chosen by hand).
DOOR_REACH = 4
# Cells beyond the annotated rooms and free cells; cells (chosen by hand).
BORDER_CELLS = 12


def to_lesson(true: TrueMap) -> Lesson:
    """The map as the network sees it, its true rooms, and FLOOR where that is certain."""
    working = to_working_grid(true.grid, true.grid.free, resolution=StructureParameters().working_resolution)
    working, occupied = remove_noise(working)
    free = working.free
    shares, matrix = align_shares(free, occupied, resolution=working.resolution)
    size = shares.shape[1:]
    empty = Evidence(np.zeros((FURNITURE + 1, *size)), np.zeros((len(OFFSETS), *size)), matrix, free.shape)
    rooms = _widen_labels(empty.sample(working.sample(true.spaces.astype(np.int32))))
    near_others = np.zeros(size, bool)
    for room in np.unique(rooms[rooms > 0]):
        near_others |= grow_mask(rooms == room, DOOR_REACH) & (rooms != room)
    is_floor = (shares[0] > 0.99) & (rooms > 0) & ~near_others
    lesson = {
        "free": (shares[0] * FINE_CELLS).astype(np.float16),
        "occupied": (shares[1] * FINE_CELLS).astype(np.float16),
        "classes": np.where(is_floor, FLOOR, UNKNOWN_CLASS).astype(np.uint8),
        "rooms": rooms.astype(np.uint16),
        "counts": np.ones(size, bool),
    }
    rows, cols = np.nonzero((shares[0] > 0) | (rooms > 0))
    window = tuple(slice(max(i.min() - BORDER_CELLS, 0), i.max() + BORDER_CELLS + 1) for i in (rows, cols))
    return {name: image[window] for name, image in lesson.items()}


def _widen_labels(rooms: LabelImage) -> LabelImage:
    """Labels without the holes of single cells in a room that furniture leaves in annotations of free cells."""
    closed = rooms.copy()
    for room in np.unique(rooms[rooms > 0]):
        filled = cv2.morphologyEx((rooms == room).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)) > 0
        closed[filled & (rooms == 0)] = room
    return closed


def main() -> None:
    """Write a lesson for each annotated map."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--data", type=Path)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    data = find_data(options.data)
    for mapset, items in choose_sets(SETS, data).items():
        for item in items:
            lesson = to_lesson(mapset.read(data / mapset.folder, item))
            write_lesson(options.folder / f"{mapset.building_of(data, item)}__{mapset.name}_{item}.npz", lesson)


if __name__ == "__main__":
    main()
