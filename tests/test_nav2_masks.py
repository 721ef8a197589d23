"""Masks for Nav2's filters, as its map server reads them, and poses in rooms and at doors."""

import json
from math import cos, hypot, pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from PIL import Image
from shapely import LineString, box

import pianta
from pianta.errors import OptionError
from pianta.navigation.free_space import find_free_space
from pianta.navigation.waypoints import find_approaches, find_room_poses
from tests.test_nav2_route import FLOOR, GRID, NAME


def read_raw(path: Path) -> tuple[dict[str, Any], NDArray[np.int_]]:
    """The cells of a mask, row 0 at the top, by the rules of mode raw: grey 0 … 100 is the value, above is unknown."""
    keys = yaml.safe_load(path.read_text())
    assert keys["mode"] == "raw"
    assert keys["origin"][2] == 0
    grey = np.array(Image.open(path.parent / keys["image"])).astype(int)
    return keys, np.where(grey <= 100, grey, -1)


@pytest.mark.parametrize("word", ["3", "office", NAME])
def test_keepout_mask(tmp_path, word):
    assert pianta.convert(FLOOR, tmp_path / "mask", to="nav2-keepout", grid=GRID, rooms=[word]) == ["forbidden: room 3"]
    keys, cells = read_raw(tmp_path / "mask" / "keepout.yaml")
    # Room 3 is 40 x 30 cells from col 1, row 1 on
    expected = np.zeros((32, 83), int)
    expected[1:31, 1:41] = 100
    assert (cells == expected).all()
    assert (keys["resolution"], keys["origin"]) == (0.1, [-0.1, -0.1, 0.0])


def test_speed_mask_has_no_unknown_cell(tmp_path):
    assert pianta.convert(FLOOR, tmp_path / "mask", to="nav2-speed", grid=GRID, speed=37) == ["37 %: rooms 3, 7"]
    _, cells = read_raw(tmp_path / "mask" / "speed.yaml")
    assert cells.min() == 0
    assert (cells == 37).sum() == 2 * 40 * 30
    assert sorted({*cells.ravel().tolist()}) == [0, 37]


@pytest.mark.parametrize(
    ("to", "options", "words"),
    [
        ("nav2-keepout", {}, "give rooms"),
        ("nav2-keepout", {"rooms": ("offices",)}, "give one such as office"),
        ("nav2-keepout", {"rooms": ("12", "3")}, "'12'"),
        ("nav2-speed", {"speed": 33.3}, "whole per cent"),
        ("nav2-speed", {"speed": 0.5}, "whole per cent"),
        ("nav2-route", {"speed": 20}, "takes no speed"),
        ("nav2-keepout", {"rooms": ("3",), "robot_radius": 0.3}, "takes no robot_radius"),
    ],
)
def test_wrong_options_are_refused(tmp_path, to, options, words):
    with pytest.raises(OptionError, match=words):
        pianta.convert(FLOOR, tmp_path / "out", to=to, grid=GRID, **options)
    assert not (tmp_path / "out").exists()


def test_a_map_with_yaw_gets_a_mask_without(tmp_path):
    """Turned by a quarter: 83 x 32 cells cover the same metres."""
    turned = pianta.GridMap(np.rot90(GRID.cells, -1), 0.1, (-0.1, 3.1, -pi / 2))
    notes = pianta.convert(FLOOR, tmp_path / "m", to="nav2-keepout", grid=turned, rooms=["3"])
    assert notes[1:] == ["the map has a yaw, which Nav2's filters refuse: the mask has a grid of its own"]
    keys, cells = read_raw(tmp_path / "m" / "keepout.yaml")
    assert keys["origin"] == pytest.approx([-0.1, -0.1, 0])
    mask = pianta.read_map(tmp_path / "m" / "keepout.yaml")
    for x, y, value in ((2, 1.5, 100), (6, 1.5, 0), (4.05, 1.5, 0)):
        row, col = (int(index) for index in mask.map_to_pixel(x, y))
        assert cells[row, col] == value
    assert (cells == 100).sum() == 40 * 30


@pytest.mark.parametrize("suffix", ["yaml", "json"])
def test_waypoints(tmp_path, suffix):
    file = tmp_path / f"waypoints.{suffix}"
    assert pianta.convert(FLOOR, file, to="waypoints", grid=GRID) == []
    content = (json.loads if suffix == "json" else yaml.safe_load)(file.read_text(encoding="utf-8"))
    assert [*content["waypoints"]] == ["room3", "room7"]
    first = content["waypoints"]["room3"]
    assert (first["name"], first["label"]) == (NAME, "OFFICE")
    # In the middle of 4 m x 3 m, looking along x to the door at (4.05, 1.5)
    assert hypot(first["x"] - 2, first["y"] - 1.5) < 0.4
    assert abs(first["yaw"]) < 0.2
    assert first["pose"] == [first["x"], first["y"], 0]
    assert first["orientation"][0] == pytest.approx(cos(first["yaw"] / 2), abs=1e-3)
    # Half a metre and the radius before the door, on both sides
    assert [(door["door"], door["room"]) for door in content["doors"]] == [(0, 3), (0, 7)]
    west, east = content["doors"]
    assert (west["x"], west["y"]) == pytest.approx((4.05 - 0.72, 1.5), abs=0.1)
    assert (east["x"], east["y"]) == pytest.approx((4.05 + 0.72, 1.5), abs=0.1)
    assert west["yaw"] == pytest.approx(0, abs=0.1)
    assert abs(east["yaw"]) == pytest.approx(pi, abs=0.1)


@pytest.mark.parametrize("world", ["corridor", "home", "office"])
def test_poses_are_where_the_robot_fits(world):
    floor, grid = pianta.make_world(world, seed=4, furniture=0.6)
    space = find_free_space(floor, grid, 0.3)
    poses = find_room_poses(floor, grid, robot_radius=0.3)
    assert len(poses) >= 0.9 * len(floor)
    for room, pose in poses.items():
        assert floor.room_at(pose.x, pose.y) == floor[room]
    approaches = find_approaches(floor, grid, robot_radius=0.3)
    assert len(approaches) >= len(floor.doors)
    for pose in [*poses.values(), *(each.pose for each in approaches)]:
        row, col = (int(index) for index in grid.map_to_pixel(pose.x, pose.y))
        assert space.open[row, col]


def test_the_place_is_not_under_the_table():
    """A table of 2 m x 1 m in the middle of a room of 4 m x 3 m: the centroid is on it."""
    cells = GRID.cells.copy()
    cells[11:21, 11:31] = 100
    poses = find_room_poses(FLOOR, pianta.GridMap(cells, 0.1, GRID.origin))
    assert not box(1, 1, 3, 2).buffer(0.22).contains(LineString([(poses[3].x, poses[3].y)] * 2).centroid)
