"""Ranges in worlds small enough to measure by hand, and the maps made of them."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import OptionError
from pianta.exploration import beams
from pianta.exploration.beams import measure_ranges
from pianta.exploration.gain import measure_gains
from pianta.exploration.lidar import Lidar, Pose, scan
from pianta.exploration.occupancy import OccupancyGrid
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
def beam_cases(draw):
    """Cells, a point among them, and beams in all directions, axes and diagonals included."""
    height, width = draw(st.integers(1, 8)), draw(st.integers(1, 8))
    cells = draw(st.lists(st.sampled_from([0, 0, -1, 100]), min_size=height * width, max_size=height * width))
    row = draw(st.floats(0, height, exclude_max=True))
    col = draw(st.floats(0, width, exclude_max=True))
    angles = np.array([*draw(st.lists(st.floats(-7, 7), max_size=20)), *np.arange(8) * pi / 4])
    directions = np.vstack([np.column_stack([-np.sin(angles), np.cos(angles)]), [EAST, NORTH, WEST, SOUTH]])
    return np.array(cells, np.int8).reshape(height, width), (row, col), directions


@pytest.mark.slow
def test_ranges_along_the_axes_are_exact():
    blocked = draw_cells(ROOM) == 100
    ranges = measure_ranges(blocked, (2.25, 4.5), np.array([EAST, NORTH, WEST, SOUTH], float), 100)
    assert ranges.tolist() == [1.5, 1.25, 3.5, 0.75]


def test_a_diagonal_beam_ends_on_the_face_that_it_meets():
    blocked = draw_cells(ROOM) == 100
    (length,) = measure_ranges(blocked, (1.25, 1.5), np.array([[sqrt(0.5), sqrt(0.5)]]), 100)
    assert length == pytest.approx(2.5 * sqrt(2))
    (short,) = measure_ranges(blocked, (1.5, 2.25), np.array([[sqrt(0.5), sqrt(0.5)]]), 100)
    assert short == pytest.approx(1.75 * sqrt(2))


def test_no_beam_slips_between_two_obstacles_that_touch_at_a_corner():
    blocked = draw_cells("...#. ..#.. .#...") == 100
    for col in (0.5, 0.25, 0.123):
        (length,) = measure_ranges(blocked, (0.5, col), np.array([[sqrt(0.5), sqrt(0.5)]]), 100)
        assert length < 3


def test_beyond_the_reach_and_at_its_end_there_is_no_echo():
    blocked = draw_cells(ROOM) == 100
    east = np.array([EAST], float)
    assert measure_ranges(blocked, (1.5, 1.5), east, 4.5)[0] == inf
    assert measure_ranges(blocked, (1.5, 1.5), east, 4.6)[0] == 4.5


def test_the_world_ends_where_its_cells_do():
    assert measure_ranges(np.zeros((1, 4), bool), (0.5, 1.5), np.array([EAST, NORTH], float), 9).tolist() == [2.5, 0.5]


def test_a_lidar_in_an_obstacle_measures_zero():
    assert measure_ranges(np.ones((2, 2), bool), (0.5, 0.5), np.array([EAST], float), 9).tolist() == [0]


@pytest.mark.slow
@given(beam_cases(), st.floats(0.5, 12))
def test_beams_cross_connected_cells_up_to_a_stop_the_limit_or_the_border(case, reach):
    cells, origin, directions = case
    stops = cells == 100
    crossings = beams.cross_cells(stops, origin, directions, np.full(len(directions), reach))
    ranges = beams.measure_ranges(stops, origin, directions, reach)
    for number, direction in enumerate(directions):
        entries, exits = (values[crossings.beams == number] for values in (crossings.entries, crossings.exits))
        rows, cols = np.unravel_index(crossings.cells[crossings.beams == number], cells.shape)
        assert not stops[rows, cols].any()
        assert entries.tolist() == [0, *exits[:-1]][: len(exits)]
        assert (entries < reach).all()
        middles = np.array(origin) + ((entries + exits) / 2)[:, None] * direction
        assert np.abs(middles - np.column_stack([rows, cols]) - 0.5).max(initial=0) <= 0.5 + 1e-9
        end = exits[-1] if len(exits) else 0.0
        assert ranges[number] == (end if end < reach else inf)


@pytest.mark.slow
@given(beam_cases(), st.floats(0.5, 12), st.integers(0, 2**32 - 1))
def test_compiled_maps_and_gains_are_those_of_python(case, reach, seed):
    cells, (row, col), _ = case
    world = World(cells == 100, 1.0)
    x, y = world.grid.pixel_to_map(row, col)
    pose, lidar = Pose(float(x), float(y)), Lidar(beams=24, reach=reach, noise=0.5)
    results = []
    for compiled in (True, False):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(beams, "has_numba", lambda compiled=compiled: compiled)
            grid, rng = OccupancyGrid(world), np.random.default_rng(seed)
            for _ in range(3):
                grid.add_scan(pose, lidar, scan(world, pose, lidar, rng))
            gains = measure_gains(
                cells, [(row, col) for row, col in np.argwhere(cells == 0).tolist()], reach=reach, resolution=1.0
            )
            results.append((grid.cells, grid.log_odds, gains))
    assert all(np.array_equal(one, other) for one, other in zip(*results, strict=True))


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
    mapped = np.full((41, 41), -1, np.int8)
    mapped[20, 20] = 0
    open_ = measure_gains(mapped, [(20, 20)], reach=1.5, resolution=0.1)
    assert open_[0] == pytest.approx(pi * 1.5**2 - 0.01, rel=0.002)
    mapped[:, 21] = 100
    half = measure_gains(mapped, [(20, 20)], reach=1.5, resolution=0.1)
    assert 0.5 < half[0] / open_[0] < 0.56


def test_without_numba_everything_is_the_same(monkeypatch):
    world = two_room_world()
    lidar, pose, maps = Lidar(), Pose(2, 2), []
    for numba in (True, False):
        monkeypatch.setattr(beams, "has_numba", lambda numba=numba: numba)
        grid = OccupancyGrid(world)
        grid.add_scan(pose, lidar, scan(world, pose, lidar, np.random.default_rng(1)))
        maps.append(grid.cells)
    assert np.array_equal(maps[0], maps[1])
