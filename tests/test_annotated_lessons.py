"""Lessons of annotated real maps: their rooms, and floor where that is certain."""

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from pianta import GridMap
from pianta.layout.structure.evidence import FLOOR
from pianta_bench.data.map_sets import TrueMap

pytest.importorskip("numba", reason="pianta[sim] is not installed")
sys.path.append(str(Path(__file__).parents[1] / "training"))
annotated = import_module("annotated_lessons")
files = import_module("lesson_files")

# Side of a room, and thickness of the wall between the two rooms; cells of 0.1 m.
SIDE = 40
WALL = 2


def make_map() -> TrueMap:
    """Two rooms of 4 × 4 m side by side, the wall between them without a door, and a wall of 0.2 m around both."""
    shape = (SIDE + 2 * WALL, 2 * SIDE + 3 * WALL)
    rooms = np.zeros(shape, np.int32)
    rooms[WALL:-WALL, WALL : WALL + SIDE] = 1
    rooms[WALL:-WALL, 2 * WALL + SIDE : -WALL] = 2
    grid = GridMap(np.where(rooms > 0, 0, 100), resolution=0.1)
    return TrueMap(grid, rooms, rooms, grid.free)


def test_a_lesson_has_the_rooms_and_certain_floor():
    lesson = annotated.to_lesson(make_map())
    rooms, classes = lesson["rooms"], lesson["classes"]
    assert sorted(np.bincount(rooms.ravel())[1:].tolist()) == [SIDE**2, SIDE**2]
    assert set(np.unique(classes)) == {FLOOR, files.UNKNOWN_CLASS}
    assert (rooms[classes == FLOOR] > 0).all()
    # The wall is 2 cells thick: the first 4 − 2 cells beside it may be in a door.
    unsure = (rooms == 1) & (classes != FLOOR)
    assert unsure.sum() == (annotated.DOOR_REACH - WALL) * SIDE
    assert lesson["free"].max() == lesson["occupied"].max() == files.FINE_CELLS


def test_files_are_read_as_they_were_written(tmp_path):
    lesson = annotated.to_lesson(make_map())
    files.write_lesson(tmp_path / "a.npz", lesson)
    again = files.read_lesson(tmp_path / "a.npz")
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]
    assert all(np.array_equal(lesson[name], again[name]) for name in lesson)


def test_each_building_is_in_one_fold():
    buildings = [building for fold in annotated.FOLDS for building in fold]
    assert len(buildings) == len(set(buildings)) == 18
