"""Labelling a floor and predicting its building type import nothing heavy."""

import os
import subprocess
import sys

import pytest

HEAVY = ("sklearn", "skops", "scipy", "joblib", "pandas", "rustworkx", "skimage", "cv2", "matplotlib")

LABELLING = """
from dataclasses import replace
from shapely import LineString, box
from pianta.building_types.classify import classify_building
from pianta.floor import Door, Floor, Room
from pianta.rooms.from_names import label_named_rooms
from pianta.rooms.label import label_rooms

rooms = [Room(1, box(0, 0, 40, 2)), *(Room(i + 2, box(8 * i, 2, 8 * i + 8, 9)) for i in range(5))]
doors = [Door((1, room.id), LineString([(8 * room.id - 15, 2), (8 * room.id - 14, 2)]), 1.0) for room in rooms[1:]]
floor = classify_building(label_rooms(Floor(tuple(rooms), tuple(doors))))
assert [*floor.building_type] in ([], ["school", "office"], ["office", "school"])
assert label_rooms(replace(floor, building_type={"school": 1.0})).rooms[0].labels["R/C"] == "CORRIDOR"
assert label_named_rooms(replace(floor, rooms=tuple(replace(room, name="office") for room in rooms))).rooms[1].label
"""
TRAINING = """
import pianta.building_types.model, pianta.rooms.training
import pianta.building_types.model_file, pianta.rooms.model_file
"""


@pytest.mark.parametrize("code", [LABELLING, TRAINING], ids=["labelling", "modules of training"])
def test_nothing_heavy_is_imported(code):
    script = f"import sys\n{code}\nprint('heavy:', *sorted({set(HEAVY)!r} & sys.modules.keys()))"
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, env=environment, check=False, timeout=60
    )
    assert (process.returncode, process.stdout, process.stderr) == (0, "heavy:\n", "")
