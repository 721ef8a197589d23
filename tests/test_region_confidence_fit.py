"""The script that fits the probabilities of rooms and doors: simulated maps, and models of made measures."""

import json
import sys
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from shapely import LineString, box

import pianta
from pianta.layout.structure.confidence import DOOR_MEASURES, ROOM_MEASURES, read_confidence_model

pytest.importorskip("numba", reason="pianta[sim] is not installed")
sys.path.append(str(Path(__file__).parents[1] / "training"))
script = import_module("fit_region_confidence")
lessons = import_module("map_lessons")

FLOOR_OF_TWO = pianta.Floor(
    (pianta.Room(1, box(0, 0, 4, 5)), pianta.Room(2, box(4, 0, 8, 5))),
    (pianta.Door((1, 2), LineString([(4, 2), (4, 3)]), 1.0),),
    source="two rooms",
)


def make_regions(building: str, rng: np.random.Generator) -> Any:
    """50 rooms that are right if the first measure is above 0, and as many doors, right if the last room is."""
    measures = rng.normal(0, 1, (50, len(ROOM_MEASURES)))
    rooms = [pianta.Room(number, box(number, 0, number + 1, 1)) for number in range(1, 51)]
    doors = [pianta.Door((number, None), LineString([(0, 0), (0, 1)]), 1.0) for number in range(1, 51)]
    door_measures = rng.normal(0, 1, (50, len(DOOR_MEASURES) - 1))
    is_right = measures[:, 0] > 0
    return script.ReadRegions(building, rooms, measures, is_right, doors, door_measures, is_right)


@pytest.fixture
def maps():
    rng = np.random.default_rng(0)
    return [make_regions(f"building {number}", rng) for number in range(8)]


def test_a_joined_cell_is_occupied_if_any_part_is():
    unknown, free, occupied = 0, script.FREE_CELL, script.OCCUPIED_CELL
    cells = np.array([[free, unknown, occupied, free, free], [unknown, unknown, free, free, free]], np.uint8)
    assert script._join_cells(cells).tolist() == [[free, occupied]]


def test_weights_follow_the_measure_that_decides(maps):
    model = script.fit_model(maps)
    assert model.rooms.weights[0] > 5 * np.abs(model.rooms.weights[1:]).max()
    # Of doors it is that of their rooms
    assert model.doors.weights[-1] > 5 * np.abs(model.doors.weights[:-1]).max()


def test_each_building_is_left_out_once(maps):
    assert {regions.fold for regions in maps} <= set(range(script.FOLDS))
    left_out = script.measure_left_out(maps)
    assert left_out["rooms"]["count"] == left_out["doors"]["count"] == 400
    assert left_out["rooms"]["ranking"] > 95
    same = [replace(regions, building="one") for regions in maps]
    assert len({regions.fold for regions in same}) == 1


def test_the_file_is_read_as_it_was_written(maps, tmp_path):
    model = script.fit_model(maps)
    script.write_model(model, {"rooms": {"error": 1.0}}, tmp_path / "model.json")
    read = read_confidence_model(tmp_path / "model.json")
    for part, other in ((model.rooms, read.rooms), (model.doors, read.doors)):
        arrays, read_arrays = ([each.means, each.spreads, each.weights] for each in (part, other))
        assert np.allclose(arrays, read_arrays, rtol=0, atol=1e-4)
        assert part.bias == pytest.approx(other.bias, abs=1e-4)
    content = json.loads((tmp_path / "model.json").read_text(encoding="utf-8"))
    assert content["on_buildings_left_out"] == {"rooms": {"error": 1.0}}


@pytest.mark.slow
def test_a_simulated_map_has_its_rooms_and_door(tmp_path, monkeypatch):
    """The door of the truth is between the rooms, however the floor was turned and moved."""
    monkeypatch.setattr(lessons, "draw_floor", lambda *_: (FLOOR_OF_TWO, 1.0))
    monkeypatch.setattr(script, "list_annotated_floors", lambda _: [FLOOR_OF_TWO])
    paths = script.make_maps(tmp_path, 3, tmp_path, seed=0)
    assert paths == script.make_maps(tmp_path, 3, tmp_path, seed=0)
    for path in paths:
        true_map = script.read_map(path)
        assert true_map.building == "two rooms"
        assert true_map.rooms.shape == true_map.grid.shape
        assert set(np.unique(true_map.rooms)) == {0, 1, 2}
        (door,) = true_map.doors
        between = np.mean([np.argwhere(true_map.rooms == number).mean(axis=0) for number in (1, 2)], axis=0)
        pixel = np.array(true_map.grid.map_to_pixel(*np.mean(door.line.coords, axis=0)))
        assert np.linalg.norm(pixel - between) < 1.2 / true_map.grid.resolution
