"""A floor against the true floor, as a function and as `pianta score`."""

import json
from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest
from shapely import LineString, box

import pianta
from pianta.evaluation.floor_scores import match_floors
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.layout.frames import Motion
from pianta.layout.room_ids import move_floor
from tests.command_line import run_pianta
from tests.tiny_data import OUTLINES, SIZE, write_building

# Two rooms of 4 m x 3 m north of a corridor of 8 m x 2 m; walls have no thickness.
RESOLUTION = 0.05  # metres per cell of a map
TRUTH = Floor(
    (Room(1, box(0, 2, 4, 5), "OFFICE"), Room(2, box(4, 2, 8, 5), "KITCHEN"), Room(3, box(0, 0, 8, 2), "CORRIDOR")),
    (Door((1, 3), LineString([(1, 2), (2, 2)]), 1.0), Door((2, 3), LineString([(6, 2), (7, 2)]), 1.0)),
    building_type={"office": 1.0},
)
# Both rooms are one, and the door of the second is 2 m west of its place.
MERGED = Floor(
    (Room(1, box(0, 2, 8, 5), "OFFICE"), Room(2, box(0, 0, 8, 2), "CORRIDOR")),
    (Door((1, 2), LineString([(1, 2), (2, 2)]), 1.0), Door((1, 2), LineString([(4, 2), (5, 2)]), 1.0)),
)


def test_scores_of_rooms_that_were_merged():
    scores = pianta.score_floor(MERGED, TRUTH)
    # The largest overlaps are 12 + 16 of 40 m² of both floors, 12 + 12 + 16 of 40 m² from the truth; no IoU of the
    # merged room is above 12 / 24
    assert [scores.coverage.a_fc, scores.coverage.a_bc] == pytest.approx([28 / 40, 1])
    assert scores.coverage.mean_iou == pytest.approx((0.5 + 0.5 + 1) / 3)
    assert dict(scores.matches) == {2: 3}
    assert (scores.rooms.precision, scores.rooms.recall, scores.rooms.f1) == pytest.approx((1 / 2, 1 / 3, 2 / 5))
    assert (scores.doors.true, scores.doors.detected, scores.doors.correct) == (2, 2, 1)
    assert (scores.pairs.true, scores.pairs.detected, scores.pairs.correct) == (2, 1, 1)
    assert (scores.edges.true, scores.edges.detected, scores.edges.correct) == (2, 1, 0)
    # OFFICE and CORRIDOR of the floor are right, KITCHEN of the truth is not
    assert [scores.labels_forward, scores.labels_backward] == pytest.approx([1, 2 / 3])
    assert scores.as_json()["building_type"] is False


def test_a_floor_agrees_with_itself():
    scores = pianta.score_floor(TRUTH, TRUTH)
    parts = [scores.rooms.f1, scores.doors.f1, scores.pairs.f1, scores.edges.f1, scores.coverage.f1]
    assert parts == [1.0] * 5
    assert [scores.labels_forward, scores.labels_backward] == [1, 1]
    assert scores.building_type


def test_labels_are_compared_in_the_coarse_set_of_the_truth():
    coarse = {1: "ROOM", 2: "ROOM", 3: "CORRIDOR"}
    truth = replace(TRUTH, rooms=tuple(replace(room, label=coarse[room.id]) for room in TRUTH))
    predicted = {1: "FUNCTIONAL", 2: "CONNECTION", 3: "CONNECTION"}
    r_c = {1: "ROOM", 2: "CORRIDOR", 3: "CORRIDOR"}
    rooms = (replace(room, label=predicted[room.id], labels={"R/C": r_c[room.id]}) for room in TRUTH)
    scores = pianta.score_floor(replace(TRUTH, rooms=tuple(rooms)), truth)
    assert [scores.labels_forward, scores.labels_backward] == pytest.approx([2 / 3, 2 / 3])


def test_a_truth_without_labels_scores_none():
    bare = replace(TRUTH, rooms=tuple(replace(room, label=None) for room in TRUTH), building_type={})
    scores = pianta.score_floor(TRUTH, bare)
    assert (scores.labels_forward, scores.labels_backward, scores.building_type) == (None, None, None)


def test_floors_without_rooms_match_nothing():
    assert match_floors(TRUTH, Floor(())) == {}
    assert pianta.score_floor(Floor(()), TRUTH).rooms.f1 == 0


class TestCommand:
    @pytest.fixture
    def world(self, tmp_path: Path) -> Path:
        """A floor, the same with a room too many merged, and the same in another frame."""
        floor, _ = pianta.make_world("corridor")
        (tmp_path / "truth").mkdir()
        floor.save(tmp_path / "truth" / "floor.geojson")
        floor.merge(2, 3).save(tmp_path / "merged.geojson")
        move_floor(floor, Motion(pi / 2, (5.0, -30.0))).save(tmp_path / "moved.geojson")
        return tmp_path

    def test_it_prints_a_table_and_writes_json(self, world):
        arguments = ["score", world / "merged.geojson", world / "truth", "--json", world / "scores.json"]
        code, out, err = run_pianta(*arguments)
        assert (code, err) == (0, "")
        assert ["rooms", "19", "18", "17", "94.4", "89.5", "91.9"] in [line.split() for line in out.splitlines()]
        assert "two frames" not in out
        content = json.loads((world / "scores.json").read_text(encoding="utf-8"))
        assert (content["rooms"]["correct"], content["rooms"]["true"], len(content["matches"])) == (17, 19, 17)
        assert content["labels_backward"] == pytest.approx(1)

    def test_another_frame_is_named_and_removed_on_demand(self, world):
        arguments = ["score", world / "moved.geojson", world / "truth"]
        out = run_pianta(*arguments).out
        assert "the floors have two frames: OUT would have to be moved, give --align, by a rotation of -90.0°" in out
        assert ["rooms", "19", "19", "19", "100.0", "100.0", "100.0"] not in [line.split() for line in out.splitlines()]
        out = run_pianta(*arguments, "--align").out
        assert ["rooms", "19", "19", "19", "100.0", "100.0", "100.0"] in [line.split() for line in out.splitlines()]
        assert "OUT was moved by a rotation of -90.0° and a shift of (30.00, 5.00) m" in out

    def test_a_layout_in_pixels_is_read_on_the_map_of_the_folder(self, tmp_path):
        width, height = (round(side / RESOLUTION) for side in SIZE)
        # The map frame begins 7 m east and 3 m south of the corner of the image
        grid = GridMap(np.zeros((height, width), np.int8), RESOLUTION, (-7.0, 3.0, 0.0))
        floor = Floor(tuple(Room(number, outline) for number, outline in enumerate(OUTLINES, start=1)))
        (tmp_path / "out").mkdir()
        grid.save(tmp_path / "out" / "grid.npz")
        move_floor(floor, Motion(0.0, (-7.0, 3.0))).save(tmp_path / "out" / "floor.geojson")
        (tmp_path / "truth.xml").write_text(write_building(OUTLINES, RESOLUTION), encoding="utf-8")
        lines = run_pianta("score", tmp_path / "out", tmp_path / "truth.xml").out.splitlines()
        assert ["rooms", "2", "2", "2", "100.0", "100.0", "100.0"] in [line.split() for line in lines]
        assert "area: A_FC 100.0 %, A_BC 100.0 %, mean IoU 100.0 %" in lines

    @pytest.mark.parametrize(
        ("floor", "fragment"), [("nothing", "does not exist"), ("", "floor.geojson' does not exist")]
    )
    def test_what_is_no_floor_is_one_line(self, world, floor, fragment):
        code, out, err = run_pianta("score", world / floor, world / "truth")
        assert (code, out, err.count("\n"), fragment in err) == (2, "", 1, True)

    def test_two_buildings_cannot_be_aligned(self, world):
        pianta.make_world("hall")[0].save(world / "hall.geojson")
        code, out, err = run_pianta("score", world / "hall.geojson", world / "truth", "--align")
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert "--align finds no motion between the floors" in err
