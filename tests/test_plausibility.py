"""Implausible maps: a clear word for what is no building, has a wrong resolution, or inverted greys."""

import warnings
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from shapely import LineString, box

import pianta
from pianta.errors import MapError, MapWarning
from pianta.floor import Door, Floor, Room, scale_floor
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.reading._plausibility import (
    describe_implausible_floor,
    describe_implausible_map,
    describe_implausible_reading,
    describe_narrow_map,
)
from pianta.worlds.scan import simulate_map
from tests.drawn_maps import carve


def draw_map(size: float, resolution: float = 0.05) -> np.ndarray:
    """Free cells in a frame of walls."""
    count = round(size / resolution)
    cells = np.full((count, count), FREE, np.int8)
    cells[[0, -1]] = cells[:, [0, -1]] = OCCUPIED
    return cells


def draw_suite() -> GridMap:
    """Two rooms of 4 m with walls of 0.1 m, a door of 0.9 m between them, and unknown space around."""
    rooms = carve((124, 206), (20, 100, 20, 100), (20, 100, 102, 182), (50, 68, 100, 102))
    walls = carve((124, 206), (18, 102, 18, 184)) & ~rooms
    return GridMap(np.where(rooms, FREE, np.where(walls, OCCUPIED, UNKNOWN)).astype(np.int8), 0.05)


def scatter(density: float, block: int) -> GridMap:
    """Random blocks of block × block cells in a hall of 20 m."""
    cells = draw_map(20.0)
    count = len(cells) // block
    occupied = np.random.default_rng(0).random((count, count)) < density
    blocks = np.kron(occupied, np.ones((block, block), bool))
    cells[: len(blocks), : len(blocks)][blocks] = OCCUPIED
    return GridMap(cells, 0.05)


def grow_cave(seed: int) -> GridMap:
    """A cave by a cellular automaton, at 0.1 m: a random cell becomes what most of its 9 neighbours are, six times."""
    cells = (np.random.default_rng(seed).random((150, 150)) < 0.42).astype(np.uint8)
    for _ in range(6):
        cells = (cv2.filter2D(cells, -1, np.ones((3, 3)), borderType=cv2.BORDER_CONSTANT) >= 5).astype(np.uint8)
    cells[[0, -1]] = cells[:, [0, -1]] = 1
    return GridMap(np.kron(cells, np.ones((2, 2), np.uint8)).astype(np.int8) * OCCUPIED, 0.1)


def draw_meadow() -> GridMap:
    """Free space of 20 m without walls, with three trees."""
    cells = np.full((600, 600), UNKNOWN, np.int8)
    rows, cols = np.indices(cells.shape)
    cells[np.hypot(rows - 300, cols - 300) < 200] = FREE
    for row, col in ((250, 250), (330, 280), (300, 380)):
        cells[row : row + 6, col : col + 6] = OCCUPIED
    return GridMap(cells, 0.05)


def invert(grid: GridMap) -> GridMap:
    """The map as a wrong negate reads it: white is occupied, black is free, and so is no grey."""
    return GridMap(np.where(grid.occupied, FREE, OCCUPIED).astype(np.int8), grid.resolution)


def without_unknown(grid: GridMap) -> GridMap:
    """Walls alone: all other cells are free, also those outside, in a wide margin."""
    cells = np.where(grid.occupied, OCCUPIED, FREE).astype(np.int8)
    return GridMap(np.pad(cells, 40), grid.resolution)


@pytest.mark.parametrize(
    ("grid", "fragment"),
    [
        (scatter(0.1, 1), "obstacle course"),
        (scatter(0.2, 1), "obstacle course"),
        (scatter(0.1, 4), "obstacle course"),
        (draw_meadow(), "has no wall, as outdoors"),
        (invert(draw_suite()), "inverted; change negate"),
    ],
    ids=["one-in-ten", "one-in-five", "blocks", "meadow", "inverted"],
)
def test_a_map_that_shows_no_building_is_implausible(grid, fragment):
    (message,) = describe_implausible_map(grid)
    assert fragment in message


@pytest.mark.parametrize(
    "grid",
    [
        draw_suite(),
        without_unknown(draw_suite()),
        GridMap(draw_map(2.0), 0.05),
        GridMap(draw_map(1.5, 0.02), 0.02),
        GridMap(np.full((5, 5), FREE, np.int8), 0.05),
        GridMap(np.full((5, 5), OCCUPIED, np.int8), 0.05),
        GridMap(np.full((5, 5), UNKNOWN, np.int8), 0.05),
    ],
    ids=["suite", "no-unknown", "arena", "small-arena", "free", "occupied", "unknown"],
)
def test_other_maps_are_not(grid):
    messages = [*describe_implausible_map(grid)]
    # Only the map that is all free has no wall.
    assert len(messages) == (grid.free.all())


@pytest.mark.parametrize("resolution", [0.02, 0.2])
@pytest.mark.parametrize("furniture", [0.0, 0.5])
def test_fine_and_coarse_maps_give_a_sensible_floor(resolution, furniture):
    """The floor of the corridor world has 19 rooms; cells of 0.2 m join some."""
    true, _ = pianta.make_world("corridor")
    grid = simulate_map(true, resolution=resolution, furniture=furniture)
    floor = pianta.reconstruct(grid, predict_partial=False)
    assert 17 <= len(floor) <= 19
    assert [*describe_implausible_reading(floor, grid)] == []


def test_a_toy_arena_is_one_room_of_its_size():
    grid = GridMap(np.pad(draw_map(2.0), 10, constant_values=UNKNOWN), 0.05)
    (room,) = pianta.reconstruct(grid).rooms
    # 40 cells of 0.05 m, of which two are walls: 1.9 m.
    assert room.polygon.area == pytest.approx(1.9**2, abs=0.2)
    assert [*describe_implausible_reading(Floor((room,)), grid)] == []


def draw_row(side: float, width: float, count: int = 6) -> tuple[Floor, GridMap]:
    """A row of square rooms with doors between neighbours, and a map around it."""
    rooms = tuple(Room(i + 1, box(side * i, 0, side * (i + 1), side)) for i in range(count))
    doors = tuple(Door((i, i + 1), LineString([(side * i, 0), (side * i, width)]), width) for i in range(1, count))
    return Floor(rooms, doors), GridMap(np.full((10, 10), UNKNOWN, np.int8), 0.01)


@pytest.mark.parametrize(
    ("side", "width", "fragments"),
    [
        # Doors of 0.9 m instead of 0.18 m are a cell of 0.05 m instead of 0.01 m.
        (0.8, 0.18, ["0.01 m per cell", "rooms of 0.64 m² and doors of 0.18 m", "it is some 0.05 m"]),
        (2.0, 0.2, ["doors of 0.2 m", "it is some 0.045 m"]),
        (40.0, 9.0, ["rooms of 1600 m² and doors of 9 m", "it is some 0.001 m"]),
    ],
)
def test_an_unlikely_resolution_is_implausible_with_the_likely_one(side, width, fragments):
    (message,) = describe_implausible_reading(*draw_row(side, width))
    assert all(fragment in message for fragment in fragments)


@pytest.mark.parametrize(("side", "width"), [(1.3, 0.4), (4.0, 0.9), (13.0, 4.0), (40.0, 1.2)])
def test_small_rooms_and_wide_gates_are_plausible(side, width):
    assert [*describe_implausible_reading(*draw_row(side, width))] == []


@pytest.mark.parametrize(("factor", "fragment"), [(0.2, "it is some 0.051 m"), (4.0, "it is some 0.051 m")])
def test_a_map_with_the_resolution_of_another_is_implausible(factor, fragment):
    """The doors of the corridor world are 0.9 m wide."""
    true, grid = pianta.make_world("corridor")
    wrong = replace(grid, resolution=0.05 * factor)
    message, *_ = describe_implausible_reading(scale_floor(true, factor, factor), wrong)
    assert fragment in message


def test_free_space_that_is_too_narrow_for_a_robot_is_implausible():
    _, grid = pianta.make_world("corridor")
    wrong = replace(grid, resolution=0.01)
    (message,) = describe_narrow_map(wrong)
    assert message.startswith("its resolution of 0.01 m per cell is implausible")
    assert [*describe_narrow_map(grid)] == []
    # Rooms and doors that say so too leave no need for it.
    true, _ = pianta.make_world("corridor")
    (message,) = describe_implausible_reading(scale_floor(true, 0.2, 0.2), wrong)
    assert "rooms of" in message


def test_caves_have_more_ways_round_than_buildings():
    # Doors join the 7 pairs of neighbours of a row, and those with one room between: 13 of 8 rooms, 1.6 x 8 is 12.8.
    floor, grid = draw_row(3.0, 0.9, count=8)
    line = LineString([(0, 0), (0, 0.9)])
    doors = (*floor.doors, *(Door((i, i + 2), line, 0.9) for i in range(1, 7)))
    (message,) = describe_implausible_floor(replace(floor, doors=doors), grid)
    assert "doors join 13 pairs of its 8 rooms, as in caves and obstacle courses" in message
    # Several doors of one pair count once.
    assert [*describe_implausible_floor(replace(floor, doors=doors[:-1] * 2), grid)] == []


@pytest.mark.parametrize("seed", [0, 1])
def test_a_cave_gives_a_floor(seed):
    grid = grow_cave(seed)
    floor = pianta.reconstruct(grid)
    free = grid.free.sum() * grid.resolution**2
    assert sum(room.polygon.area for room in floor.rooms) == pytest.approx(free, rel=0.35)


def test_rooms_without_doors_are_implausible_from_twenty_on():
    floor, grid = draw_row(3.0, 0.9, count=20)
    (message,) = describe_implausible_floor(replace(floor, doors=floor.doors[:4]), grid)
    # The rooms 1 to 5 have doors.
    assert "15 of its 20 rooms have no door" in message
    fewer, _ = draw_row(3.0, 0.9, count=19)
    assert [*describe_implausible_floor(replace(fewer, doors=()), grid)] == []


def test_the_outside_is_named_on_a_map_without_unknown_cells():
    grid = without_unknown(draw_suite())
    rows, cols = grid.shape
    inside, edge = box(3, 3, 7, 7), box(0, 0, cols * 0.05, rows * 0.05)
    floor = Floor((Room(1, inside), Room(7, edge - inside.buffer(0.1))))
    (message,) = describe_implausible_floor(floor, grid)
    assert "what lies outside is read as room 7;" in message
    assert [*describe_implausible_floor(Floor((Room(1, inside),)), grid)] == []


def test_a_message_is_a_warning_that_names_the_map(tmp_path: Path):
    scatter(0.1, 1).save(tmp_path / "course.yaml")
    with pytest.warns(MapWarning, match=r"^map '[^\n]*course\.yaml': its obstacles [^\n]*$"):
        pianta.read(tmp_path / "course.yaml", labels=False)


def test_the_error_of_an_inverted_map_names_the_cause(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    def fail(grid: GridMap, **options: object) -> Floor:
        raise MapError("the map shows no room")

    monkeypatch.setattr("pianta.layout.reconstruct.reconstruct", fail)
    invert(pianta.make_world("corridor")[1]).save(tmp_path / "inverted.yaml")
    with pytest.raises(MapError, match=r"^map '[^\n]*shows no room[^\n]*greys are probably inverted[^\n]*$"):
        pianta.read(tmp_path / "inverted.yaml", labels=False)


@pytest.mark.slow
def test_real_maps_of_robots_are_plausible(data: Path):
    files = sorted((data / "robotmaps").glob("*/*.yaml"))
    if not files:
        pytest.skip("no maps of robots in the data")
    # Rooms are found in the smaller ones only, to save time.
    small = {"aws_small_house", "ecn_house", "nav2_depot", "urjc_lab"}
    for file in files:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            grid = pianta.read_map(file)
        assert [*describe_implausible_map(grid)] == []
        if file.stem in small:
            assert [*describe_implausible_reading(pianta.reconstruct(grid, predict_partial=False), grid)] == []
