"""The same map in another pose, frame or resolution shows the same rooms.

Turns by 90°, mirroring, padding and smaller cells give exactly the same rooms, on every map and by every method here.

At half the resolution, or turned by any angle, the pixels differ. The method `structure` still finds the same number of
rooms, and each with the same area, on synthetic maps in every pose; on real maps the number holds within a tenth.

By the method of the thesis the segments of the probabilistic Hough transform differ with the pixels. On synthetic maps
numbers of rooms and whole areas then hold, not the wall of every room. On real maps the number of rooms does not hold
at half the resolution, and not on every one at 17°: docs/methods/layout.md has the figures, and no test claims it.
"""

from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import pytest
import shapely

from pianta.floor import Floor
from pianta.gridmap import FREE, MAX_FREE, MIN_OCCUPIED, OCCUPIED, UNKNOWN, GridMap
from pianta.io.maps import read_map
from pianta.layout.reconstruct import reconstruct
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from pianta.worlds.scan import make_sample, simulate_map
from tests.drawn_maps import carve, make_grid

pytestmark = pytest.mark.slow


class View(NamedTuple):
    """A grid map made from another one, and the function from its continuous row, col to those of the other."""

    grid: GridMap
    to_source: Callable[..., tuple[np.ndarray, np.ndarray]]


def view_symmetry(grid: GridMap, turns: int, *, mirrored: bool):
    """Map turned counter-clockwise by quarters, then mirrored left to right."""
    cells = np.rot90(grid.cells, turns)
    height, width = cells.shape

    def to_source(row, col):
        col = width - col if mirrored else col
        # Turn about the middle, clockwise.
        up, right = height / 2 - row, col - width / 2
        for _ in range(turns):
            up, right = -right, up
        return grid.shape[0] / 2 - up, grid.shape[1] / 2 + right

    return View(GridMap(cells[:, ::-1] if mirrored else cells, grid.resolution), to_source)


def view_padded(grid: GridMap):
    cells = np.pad(grid.cells, ((13, 31), (57, 8)), constant_values=UNKNOWN)
    return View(GridMap(cells, grid.resolution), lambda row, col: (row - 13, col - 57))


def view_doubled(grid: GridMap):
    cells = grid.cells.repeat(2, axis=0).repeat(2, axis=1)
    return View(GridMap(cells, grid.resolution / 2), lambda row, col: (row / 2, col / 2))


def view_every_second(grid: GridMap):
    """Half resolution by leaving out cells."""
    return View(GridMap(grid.cells[::2, ::2], 2 * grid.resolution), lambda row, col: (2 * row - 0.5, 2 * col - 0.5))


def view_pooled(grid: GridMap):
    """Half resolution: a cell is an obstacle if one of its four cells is, else unknown if one of them is."""
    height, width = (-(-size // 2) for size in grid.shape)
    padding = [(0, size % 2) for size in grid.shape]
    cells = np.pad(grid.cells, padding, constant_values=UNKNOWN)
    blocks = cells.reshape(height, 2, width, 2).swapaxes(1, 2).reshape(height, width, 4)
    occupied = (blocks >= MIN_OCCUPIED).any(axis=2)
    free = ((blocks >= FREE) & (blocks <= MAX_FREE)).all(axis=2)
    pooled = np.select([occupied, free], [OCCUPIED, FREE], UNKNOWN)
    return View(GridMap(pooled, 2 * grid.resolution), lambda row, col: (2 * row, 2 * col))


def view_turned(grid: GridMap, degrees: float = 17.0):
    """Map turned about its middle, by nearest neighbours, and unknown outside the original."""
    height, width = grid.shape
    side = int(np.hypot(height, width)) + 4
    turn = np.array(cv2.getRotationMatrix2D(((width - 1) / 2, (height - 1) / 2), degrees, 1.0), float)
    turn[:, 2] += np.array([side - width, side - height]) / 2
    cells = cv2.warpAffine(
        grid.cells.astype(np.int16), turn, (side, side), flags=cv2.INTER_NEAREST, borderValue=UNKNOWN
    )
    back = cv2.invertAffineTransform(turn)

    def to_source(row, col):
        x, y = back @ np.stack([col - 0.5, row - 0.5, np.ones(len(row))])
        return y + 0.5, x + 0.5

    return View(GridMap(cells.astype(np.int8), grid.resolution), to_source)


EXACT_VIEWS: dict[str, Callable[[GridMap], View]] = {
    "turned by 90°": lambda grid: view_symmetry(grid, 1, mirrored=False),
    "turned by 180°": lambda grid: view_symmetry(grid, 2, mirrored=False),
    "turned by 270°": lambda grid: view_symmetry(grid, 3, mirrored=False),
    "mirrored left to right": lambda grid: view_symmetry(grid, 0, mirrored=True),
    "mirrored top to bottom": lambda grid: view_symmetry(grid, 2, mirrored=True),
    "padded": view_padded,
    "double resolution": view_doubled,
}
HALF_VIEWS = {"every second cell": view_every_second, "pooled": view_pooled}


def draw_symmetric_building():
    """Rooms above and below a corridor; opposite rows have equally many free cells, at other positions."""
    corridor, doors = (90, 130, 10, 400), [(87, 90, 40, 58), (87, 90, 150, 168), (87, 90, 300, 318)]
    doors += [(130, 133, 100, 118), (130, 133, 230, 248), (130, 133, 350, 368)]
    above = [(10, 87, 10, 100), (10, 87, 103, 230), (10, 87, 233, 400)]
    below = [(133, 210, 10, 200), (133, 210, 203, 290), (133, 210, 293, 400)]
    return make_grid(carve((220, 410), corridor, *doors, *above, *below))


def draw_building_cut_at_the_edge_of_the_map():
    """A hall that fills the map except a room in one corner and a piece of wall in another."""
    free = ~carve((200, 300), (100, 103, 0, 120), (0, 100, 120, 123), (0, 20, 280, 300))
    return make_grid(free | carve(free.shape, (100, 103, 60, 78)))


def map_world(floor_type: str, noise: float, seed: int = 20):
    return simulate_map(make_floor(floor_type, seed=seed), noise=noise, seed=seed)


WORLDS = {f"{floor_type} {noise}": (floor_type, noise) for floor_type in FLOOR_MAKERS for noise in (0.0, 0.2)}
MAPS: dict[str, Callable[[], GridMap]] = {
    **{name: partial(map_world, *world) for name, world in WORLDS.items()},
    "fine cells": lambda: simulate_map(make_floor("corridor", seed=1), resolution=0.025, noise=0.2, seed=1),
    "coarse cells": lambda: simulate_map(make_floor("corridor", seed=1), resolution=0.1, noise=0.2, seed=1),
    "sample": lambda: make_sample()[1],
    "symmetric": draw_symmetric_building,
    "cut": draw_building_cut_at_the_edge_of_the_map,
}
METHODS = ["structure", "thesis"]
# The first three of the survey. At 17°, they and 6 others of the 11 maps are within a tenth also with the method of
# the thesis; lab_c and lab_f are not.
SURVEY = ["Freiburg101_scan", "Freiburg79_scan", "NLB"]


@cache
def read_and_reconstruct(name: str, method: str, data: Path | None = None) -> tuple[GridMap, Floor]:
    """A map by its name, or a map of the survey, and its floor by a method."""
    grid = MAPS[name]() if data is None else read_map(data / "survey" / f"{name}.png", resolution=0.05)
    return grid, reconstruct(grid, method=method)


def find_rooms(view: View, grid: GridMap, method: str) -> np.ndarray:
    """Rooms reconstructed in a view of a grid map, in the frame of that map."""
    return move_rooms(reconstruct(view.grid, method=method), view, grid)


def move_rooms(floor: Floor, view: View, grid: GridMap) -> np.ndarray:
    """Rooms of a view in the frame of the original map."""

    def move(xy):
        row, col = view.to_source(*view.grid.map_to_pixel(*xy.T))
        return np.column_stack(grid.pixel_to_map(row, col))

    return np.array([shapely.transform(room.polygon, move) for room in floor.rooms])


def match_areas(rooms: np.ndarray, others: np.ndarray):
    """Area of each of the others, over the area of the room that it overlaps most."""
    overlaps = shapely.area(shapely.intersection(others[:, None], rooms))
    return shapely.area(others) / shapely.area(rooms[overlaps.argmax(axis=1)])


def compare_views(grid: GridMap, floor: Floor, view: View, method: str):
    """Numbers of rooms in the map and in the view, and the relative change of the area of all rooms."""
    return compare_rooms(polygons_of(floor), find_rooms(view, grid, method))


def compare_rooms(rooms: np.ndarray, others: np.ndarray):
    return len(rooms), len(others), shapely.area(others).sum() / shapely.area(rooms).sum() - 1


def polygons_of(floor: Floor):
    return np.array([room.polygon for room in floor.rooms])


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("view", EXACT_VIEWS)
@pytest.mark.parametrize("name", MAPS)
def test_rooms_and_doors_are_the_same_in_every_pose(name, view, method):
    grid, floor = read_and_reconstruct(name, method)
    viewed = check_same_rooms(grid, floor, EXACT_VIEWS[view], method)
    widths = sorted(door.width for door in viewed.doors)
    assert widths == pytest.approx(sorted(door.width for door in floor.doors))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("view", EXACT_VIEWS)
@pytest.mark.parametrize("name", SURVEY)
def test_rooms_of_real_maps_are_the_same_in_every_pose(data, name, view, method):
    check_same_rooms(*read_and_reconstruct(name, method, data), EXACT_VIEWS[view], method)


def check_same_rooms(grid: GridMap, floor: Floor, make_view: Callable[[GridMap], View], method: str) -> Floor:
    """The floor of the view, in the frame of the view."""
    view = make_view(grid)
    viewed = reconstruct(view.grid, method=method)
    rooms, others = polygons_of(floor), move_rooms(viewed, view, grid)
    assert len(others) == len(rooms)
    assert match_areas(rooms, others) == pytest.approx(np.ones(len(rooms)), abs=1e-6)
    return viewed


@pytest.mark.parametrize(("method", "alike"), [("structure", 0.95), ("thesis", 0.7)])
@pytest.mark.parametrize("floor_type", FLOOR_MAKERS)
def test_clean_maps_at_half_resolution_have_the_same_rooms(floor_type, method, alike):
    ratios = []
    for seed in (20, 21, 22):
        grid = map_world(floor_type, noise=0.0, seed=seed)
        rooms = polygons_of(reconstruct(grid, method=method))
        others = find_rooms(view_pooled(grid), grid, method)
        count, same_count, growth = compare_rooms(rooms, others)
        assert same_count == count
        assert abs(growth) < 0.05
        ratios.extend(match_areas(rooms, others))
    assert (np.abs(np.array(ratios) - 1) < 0.05).mean() >= alike


@pytest.mark.parametrize(("method", "miss"), [("structure", 0), ("thesis", 1)])
@pytest.mark.parametrize("view", HALF_VIEWS)
@pytest.mark.parametrize("name", [*WORLDS, "sample"])
def test_maps_at_half_resolution_have_the_same_number_of_rooms(name, view, method, miss):
    grid, floor = read_and_reconstruct(name, method)
    count, same_count, growth = compare_views(grid, floor, HALF_VIEWS[view](grid), method)
    assert abs(same_count - count) <= miss
    assert abs(growth) < 0.05


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("view", HALF_VIEWS)
@pytest.mark.parametrize("name", SURVEY)
def test_real_maps_at_half_resolution_have_the_same_area(data, name, view, method):
    grid, floor = read_and_reconstruct(name, method, data)
    assert abs(compare_views(grid, floor, HALF_VIEWS[view](grid), method)[2]) < 0.05


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", [*WORLDS, "sample"])
def test_maps_turned_by_17_degrees_have_the_same_rooms_within_a_tenth(name, method):
    check_turned(*read_and_reconstruct(name, method), method)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", SURVEY)
def test_real_maps_turned_by_17_degrees_have_the_same_rooms_within_a_tenth(data, name, method):
    check_turned(*read_and_reconstruct(name, method, data), method)


def check_turned(grid: GridMap, floor: Floor, method: str):
    count, same_count, growth = compare_views(grid, floor, view_turned(grid), method)
    assert abs(same_count - count) <= 0.1 * count
    assert abs(growth) < 0.1


@pytest.mark.parametrize("degrees", range(0, 90, 5))
@pytest.mark.parametrize("name", [*WORLDS, "sample"])
def test_maps_turned_by_any_angle_have_the_same_rooms(name, degrees):
    grid, floor = read_and_reconstruct(name, "structure")
    rooms, others = polygons_of(floor), find_rooms(view_turned(grid, degrees), grid, "structure")
    assert len(others) == len(rooms)
    assert match_areas(rooms, others) == pytest.approx(np.ones(len(rooms)), abs=0.05)
