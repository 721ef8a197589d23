"""Plans to clean a floor: lanes around obstacles, the order of rooms, and how much is swept."""

import json
from collections.abc import Iterable
from itertools import pairwise, permutations

import networkx as nx
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from shapely import LineString

import pianta
from pianta.errors import FloorError
from pianta.navigation.boustrophedon import decompose
from pianta.navigation.cleaning import improve_tour, measure_plain_sweep
from pianta.navigation.free_space import SLACK_PX, FreeSpace, cross_cells, find_free_space
from pianta.navigation.sweep import SweepArea, connect_points, dilate, find_swept_cells
from tests.test_nav2_route import FLOOR, GRID

RADIUS = 0.22


def test_a_rectangle_is_one_cell_of_lanes_along_its_long_side():
    """5 x 9 cells: rows 0, 2 and 4 are at most 2 apart, as 9 columns would be 5 lanes."""
    lanes = decompose(np.ones((5, 9), bool), 2)
    assert lanes.along_rows
    assert lanes.cells == (((0, 0, 8), (2, 0, 8), (4, 0, 8)),)


def test_an_obstacle_divides_a_room_into_four_cells():
    """Above, left and right of, and below the obstacle, as in Fig. 3 of Choset (2000)."""
    part = np.ones((9, 21), bool)
    part[3:6, 8:13] = False
    lanes = decompose(part, 1)
    assert lanes.along_rows
    assert [len(cell) for cell in lanes.cells] == [3, 3, 3, 3]
    left, right = lanes.cells[1:3]
    assert left == ((3, 0, 7), (4, 0, 7), (5, 0, 7))
    assert right == ((3, 13, 20), (4, 13, 20), (5, 13, 20))


def test_swept_cells_are_those_within_the_radius():
    """A straight path of 10 cells: 2 · 3 + 1 rows beside it, and half discs at its ends."""
    swept = find_swept_cells([np.array([[10, 5], [10, 15]])], (21, 21), 3.0)
    rows, cols = np.nonzero(swept)
    expected = [(row, col) for row in range(21) for col in range(21) if distance_to(row, col) <= 3]
    assert sorted(zip(rows.tolist(), cols.tolist(), strict=True)) == expected


def distance_to(row: int, col: int) -> float:
    return float(LineString([(10, 5), (10, 15)]).distance(shapely.Point(row, col)))


@pytest.mark.parametrize("world", ["corridor", "home", "ring"])
def test_paths_sweep_the_floor_and_touch_nothing(world):
    floor, grid = pianta.make_world(world, seed=5, furniture=0.5)
    plan = pianta.plan_cleaning(floor, grid)
    assert {*plan.rooms} | {*plan.left_out} == {room.id for room in floor}
    assert plan.swept.coverage > 0.95
    assert plan.swept.coverage > measure_plain_sweep(floor, grid, plan.rooms).coverage
    space = find_free_space(floor, grid, RADIUS)
    for path in (*plan.paths.values(), *plan.ways.values()):
        pixels = np.column_stack(grid.map_to_pixel(*path.T))
        for start, end in pairwise(pixels):
            cells, lengths = cross_cells(start, end)
            # Corners of closed cells may be touched
            assert space.open[tuple(cells[lengths > 0.1].T)].all()


def test_coverage_is_that_of_the_buffered_path():
    """The same figures by shapely, from cells whose middles are in the buffer of the paths."""
    plan = pianta.plan_cleaning(FLOOR, GRID)
    space = find_free_space(FLOOR, GRID, RADIUS)
    goal = dilate(space.open & (space.rooms > 0), RADIUS / GRID.resolution)
    rows, cols = np.nonzero(goal)
    x, y = GRID.pixel_to_map(rows + 0.5, cols + 0.5)
    swept = shapely.union_all([LineString(path).buffer(RADIUS + 1e-4, quad_segs=64) for path in plan.paths.values()])
    assert shapely.contains_xy(swept, x, y).mean() == pytest.approx(plan.swept.coverage, abs=0.005)
    length = sum(LineString(path).length for path in plan.paths.values())
    assert plan.swept.length == pytest.approx(length)
    assert plan.swept.overlap == pytest.approx(length * 2 * RADIUS / swept.area - 1, abs=0.03)


def test_ways_join_the_paths():
    floor, grid = pianta.make_world("corridor", seed=1)
    plan = pianta.plan_cleaning(floor, grid)
    for before, room in zip((plan.rooms[-1], *plan.rooms[:-1]), plan.rooms, strict=True):
        assert plan.ways[room][0] == pytest.approx(plan.paths[before][-1], abs=1e-3)
        assert plan.ways[room][-1] == pytest.approx(plan.paths[room][0], abs=1e-3)


def test_the_tour_is_the_shortest():
    """On the route graph, beside all other tours."""
    floor, grid = pianta.make_world("home", seed=1)
    plan, graph = pianta.plan_cleaning(floor, grid), pianta.build_route_graph(floor, grid)
    lengths = dict(nx.all_pairs_dijkstra_path_length(graph, weight="cost"))
    first, *others = plan.rooms
    assert 4 <= len(others) <= 8

    def measure(order: Iterable[int]) -> float:
        return float(sum(lengths[a][b] for a, b in pairwise((first, *order, first))))

    assert measure(others) == pytest.approx(min(map(measure, permutations(others))))


def test_crossed_steps_of_a_tour_are_exchanged():
    """The corners of a square of 1 m: the diagonals of a tour along both of them become sides."""
    corners = np.array([[0, 0], [0, 1], [1, 1], [1, 0]])
    costs = np.hypot(*(corners[:, None] - corners[None]).transpose(2, 0, 1))
    tour = improve_tour(costs, np.array([0, 2, 1, 3]))
    assert sorted(tour.tolist()) == [0, 1, 2, 3]
    assert costs[tour, np.roll(tour, -1)].sum() == pytest.approx(4)


def make_space(picture: str) -> FreeSpace:
    """Cells of 1 m; closed where a picture has a #, without slower cells beside them."""
    is_open = np.array([[letter != "#" for letter in line] for line in picture.split()])
    grid = pianta.GridMap(np.where(is_open, 0, 100).astype(np.int8), 1.0)
    return FreeSpace(grid, 0.0, is_open, np.where(is_open, 9.0, 0.0), is_open.astype(np.int32))


def test_a_way_goes_around_a_wall():
    """Along the wall, past its end and back: straight lines from corner to corner."""
    space = make_space("..... ####. .....")
    area = SweepArea(space, space.open, (0, 0))
    path = connect_points(area, [(0, 0), (2, 0)])
    assert path.tolist() == [[0, 0], [0, 4], [2, 4], [2, 0]]


def test_a_way_leaves_the_room_where_the_room_has_none():
    """The last column is in another room."""
    space = make_space("..... ####. .....")
    part = space.open.copy()
    part[:, 4] = False
    path = connect_points(SweepArea(space, part, (0, 0)), [(0, 0), (2, 0)])
    assert path.tolist() == [[0, 0], [0, 4], [2, 4], [2, 0]]


@given(
    arrays(bool, (7, 9), elements=st.sampled_from([True, True, True, False])),
    st.tuples(st.integers(0, 6), st.integers(0, 8)),
    st.tuples(st.integers(0, 6), st.integers(0, 8)),
)
def test_a_line_is_straight_if_all_cells_that_it_crosses_are_open(is_open, start, end):
    """Beside `cross_cells`, for both sides of the line."""
    grid = pianta.GridMap(np.where(is_open, 0, 100).astype(np.int8), 1.0)
    space = FreeSpace(grid, 0.0, is_open, is_open.astype(float), is_open.astype(np.int32))
    ahead = np.subtract(end, start).astype(float)
    aside = SLACK_PX * np.array([ahead[1], -ahead[0]]) / (np.hypot(*ahead) or 1)
    ends = np.array([start, end]) + 0.5
    crossed = np.concatenate([cross_cells(*(ends + side))[0] for side in (aside, -aside)])
    assert space.is_straight(start, end) == is_open[tuple(crossed.T)].all()


def test_the_file(tmp_path):
    notes = pianta.convert(FLOOR, tmp_path / "cleaning.json", to="cleaning", grid=GRID)
    content = json.loads((tmp_path / "cleaning.json").read_text(encoding="utf-8"))
    plan = pianta.plan_cleaning(FLOOR, GRID)
    assert [stop["room"] for stop in content["rooms"]] == [*plan.rooms]
    assert content["rooms"][0]["path"] == np.round(plan.paths[plan.rooms[0]], 3).tolist()
    assert content["coverage"] == round(plan.swept.coverage, 3)
    assert len(notes) == 1
    assert "of the reachable floor" in notes[0]


def test_a_robot_that_fits_nowhere_is_refused(tmp_path):
    with pytest.raises(FloorError, match="fits nowhere, give a smaller robot_radius"):
        pianta.convert(FLOOR, tmp_path / "c.json", to="cleaning", grid=GRID, robot_radius=3)
