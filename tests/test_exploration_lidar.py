"""Ranges in worlds small enough to measure by hand, and the maps made of them."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import OptionError
from pianta.exploration import kernels
from pianta.exploration.gain import measure_gains, sum_beams, sum_beams_together
from pianta.exploration.lidar import Lidar, Pose, cast_rays, scan, walk_beams, walk_beams_together
from pianta.exploration.occupancy import OccupancyGrid, clear_ways, clear_ways_together
from pianta.exploration.world import World
from tests.explored_worlds import draw_cells, draw_world, two_room_world

ROOM = """
#######
#.....#
#.....#
#...#.#
#######
"""
EAST, NORTH, WEST, SOUTH = (0, 1), (-1, 0), (0, -1), (1, 0)


@st.composite
def looks(draw):
    """Blocked cells, a place among them, and beams in all directions, the axes and diagonals among them."""
    height, width = draw(st.integers(1, 8)), draw(st.integers(1, 8))
    cells = draw(st.lists(st.sampled_from([0, 0, -1, 100]), min_size=height * width, max_size=height * width))
    row = draw(st.floats(0, height, exclude_max=True))
    col = draw(st.floats(0, width, exclude_max=True))
    angles = np.array([*draw(st.lists(st.floats(-7, 7), max_size=20)), *np.arange(8) * pi / 4])
    beams = np.vstack([np.column_stack([-np.sin(angles), np.cos(angles)]), [EAST, NORTH, WEST, SOUTH]])
    return np.array(cells, np.int8).reshape(height, width), (row, col), beams


@pytest.mark.slow
def test_ranges_along_the_axes_are_exact():
    blocked = draw_cells(ROOM) == 100
    ranges = cast_rays(blocked, (2.25, 4.5), np.array([EAST, NORTH, WEST, SOUTH], float), 100)
    assert ranges.tolist() == [1.5, 1.25, 3.5, 0.75]


def test_a_diagonal_beam_ends_on_the_face_that_it_meets():
    blocked = draw_cells(ROOM) == 100
    (length,) = cast_rays(blocked, (1.25, 1.5), np.array([[sqrt(0.5), sqrt(0.5)]]), 100)
    assert length == pytest.approx(2.5 * sqrt(2))
    (short,) = cast_rays(blocked, (1.5, 2.25), np.array([[sqrt(0.5), sqrt(0.5)]]), 100)
    assert short == pytest.approx(1.75 * sqrt(2))


def test_no_beam_slips_between_two_obstacles_that_touch_at_a_corner():
    blocked = draw_cells("...#. ..#.. .#...") == 100
    for col in (0.5, 0.25, 0.123):
        (length,) = cast_rays(blocked, (0.5, col), np.array([[sqrt(0.5), sqrt(0.5)]]), 100)
        assert length < 3


def test_beyond_the_reach_and_at_its_end_there_is_no_echo():
    blocked = draw_cells(ROOM) == 100
    east = np.array([EAST], float)
    assert cast_rays(blocked, (1.5, 1.5), east, 4.5)[0] == inf
    assert cast_rays(blocked, (1.5, 1.5), east, 4.6)[0] == 4.5


def test_the_world_ends_where_its_cells_do():
    assert cast_rays(np.zeros((1, 4), bool), (0.5, 1.5), np.array([EAST, NORTH], float), 9).tolist() == [2.5, 0.5]


def test_a_place_in_an_obstacle_sees_nothing():
    assert cast_rays(np.ones((2, 2), bool), (0.5, 0.5), np.array([EAST], float), 9).tolist() == [0]


@pytest.mark.slow
@given(looks(), st.floats(0.5, 12))
def test_compiled_ranges_are_those_of_numpy(look, reach):
    cells, (row, col), beams = look
    ours = kernels.compile_kernel(walk_beams)(cells != 0, row, col, beams, reach)
    assert np.array_equal(ours, walk_beams_together(cells != 0, row, col, beams, reach))


@pytest.mark.slow
@given(looks(), st.floats(0.5, 12), st.integers(0, 2**32 - 1))
def test_compiled_maps_are_those_of_numpy(look, reach, seed):
    cells, (row, col), beams = look
    grids = []
    for clear in (kernels.compile_kernel(clear_ways), clear_ways_together):
        known, log_odds, scan_of_cell = cells.copy(), np.zeros(cells.shape, np.float32), np.zeros(cells.shape, np.int32)
        ranges = walk_beams_together(cells != 0, row, col, beams, reach)
        for number in (1, 2, 3):
            limits, ends = np.minimum(ranges, reach), np.where(ranges < reach, ranges + 0.3, inf)
            clear(log_odds, known, scan_of_cell, number, (row, col), beams, limits, ends)
            ranges = ranges + np.random.default_rng(seed + number).normal(0, 0.5, len(beams)).clip(-ranges, None)
        grids.append((known, log_odds, scan_of_cell))
    assert all(np.array_equal(ours, theirs) for ours, theirs in zip(*grids, strict=True))


@pytest.mark.slow
@given(looks(), st.floats(0.5, 12))
def test_compiled_gains_are_those_of_numpy(look, reach):
    cells, _, beams = look
    targets = np.argwhere(cells == 0).astype(np.int64)
    ours = kernels.compile_kernel(sum_beams)(cells, targets, beams, reach)
    assert np.array_equal(ours, sum_beams_together(cells, targets, beams, reach))


def test_a_scan_in_metres_turns_with_the_heading_and_the_frame():
    lidar, rng = Lidar(beams=4, reach=50, noise=0), np.random.default_rng(0)
    world = World(draw_cells(ROOM) == 100, 2.0, (10, 20, 0))
    # The beams of four are 135° and 45° to the right, then to the left of the heading.
    south_east_north_west = scan(world, Pose(*world.point((1, 1)), pi / 4), lidar, rng)
    assert south_east_north_west == pytest.approx([5, 9, 1, 1])
    turned = World(world.blocked, 2.0, (10, 20, 0.5))
    again = scan(turned, Pose(*turned.point((1, 1)), pi / 4 + 0.5), lidar, rng)
    assert again == pytest.approx([5, 9, 1, 1])


def test_noise_has_its_standard_deviation_and_its_seed():
    world = two_room_world(door=False)
    lidar, pose = Lidar(noise=0.05), Pose(2, 2)
    clean = scan(world, pose, Lidar(noise=0), np.random.default_rng(0))
    noisy = np.concatenate([scan(world, pose, lidar, np.random.default_rng(seed)) - clean for seed in range(10)])
    assert abs(noisy.mean()) < 0.005
    assert 0.045 < noisy.std() < 0.055
    first, again = (scan(world, pose, lidar, np.random.default_rng(5)) for _ in range(2))
    assert np.array_equal(first, again)


def test_a_lidar_without_meaning_is_refused_with_every_fault():
    with pytest.raises(OptionError, match=r"beams.*reach.*noise.*field"):
        Lidar(beams=0, reach=-1, noise=float("nan"), field=9)


def test_a_scan_makes_free_cells_and_walls_and_leaves_the_rest_unknown():
    world = draw_world("####### #.....# #.###.# #.#.#.# #######")
    grid = OccupancyGrid(world)
    lidar = Lidar(beams=720, reach=20, noise=0)
    pose = Pose(*world.point((1, 3)))
    grid.add_scan(pose, lidar, scan(world, pose, lidar, np.random.default_rng(0)))
    assert grid.cells[3, 3] == -1
    assert (grid.cells[0] == 100).all()
    assert grid.cells[1].tolist() == [100, 0, 0, 0, 0, 0, 100]
    assert (grid.cells[2, 2:5] == 100).all()


def test_a_beam_without_echo_frees_the_cells_within_reach():
    world = draw_world("##########\n#........#\n##########")
    grid = OccupancyGrid(world)
    lidar = Lidar(beams=1, reach=3.2, noise=0)
    pose = Pose(*world.point((1, 1)))
    ranges = scan(world, pose, lidar, np.random.default_rng(0))
    assert ranges.tolist() == [inf]
    grid.add_scan(pose, lidar, ranges)
    assert grid.cells[1].tolist() == [-1, 0, 0, 0, 0, -1, -1, -1, -1, -1]


def test_many_scans_outvote_a_wrong_one():
    world = draw_world("##########\n#........#\n##########")
    grid = OccupancyGrid(world)
    lidar, pose = Lidar(beams=1, reach=20, noise=0), Pose(*world.point((1, 1)))
    grid.add_scan(pose, lidar, np.array([3.0]))
    assert grid.cells[1, 4] == 100
    for _ in range(2):
        grid.add_scan(pose, lidar, scan(world, pose, lidar, np.random.default_rng(0)))
    assert grid.cells[1].tolist() == [-1, 0, 0, 0, 0, 0, 0, 0, 0, 100]


def test_the_gain_is_the_unknown_area_that_no_obstacle_hides():
    known = np.full((41, 41), -1, np.int8)
    known[20, 20] = 0
    open_ = measure_gains(known, [(20, 20)], reach=1.5, resolution=0.1)
    assert open_[0] == pytest.approx(pi * 1.5**2 - 0.01, rel=0.002)
    known[:, 21] = 100
    half = measure_gains(known, [(20, 20)], reach=1.5, resolution=0.1)
    assert 0.5 < half[0] / open_[0] < 0.56


def test_without_numba_everything_is_the_same(monkeypatch):
    world = two_room_world()
    lidar, pose, maps = Lidar(), Pose(2, 2), []
    for numba in (True, False):
        monkeypatch.setattr(kernels, "has_numba", lambda numba=numba: numba)
        grid = OccupancyGrid(world)
        grid.add_scan(pose, lidar, scan(world, pose, lidar, np.random.default_rng(1)))
        maps.append(grid.cells)
    assert np.array_equal(maps[0], maps[1])
