"""Worlds: walls of a thickness, open doors, starts, and what a robot can reach."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, Point, box

from pianta.errors import MapError, OptionError
from pianta.exploration.starts import check_start, find_starts, place_robots
from pianta.exploration.world import (
    build_world,
    clear_cells,
    explorable_cells,
    reachable_cells,
    read_world,
)
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.worlds.floors import FLOOR_MAKERS, make_floor
from tests.explored_worlds import draw_cells, draw_world, two_room_world, two_rooms


def test_rooms_whose_outlines_meet_give_half_of_the_wall_each():
    world = two_room_world()
    row = world.cell(2, 0.55)[0]
    free = np.flatnonzero(world.free[row])
    west, wall, east = world.cell(0, 1)[1], world.cell(4, 1)[1], world.cell(7, 1)[1]
    assert free.tolist() == [*range(west, wall - 1), *range(wall + 1, east)]


def test_a_door_is_opened_as_wide_as_drawn_and_no_wider():
    world = two_room_world()
    column = world.cell(4, 1)[1]
    rows = np.flatnonzero(world.free[:, column])
    ys = [world.point((row, column))[1] for row in rows.tolist()]
    assert np.allclose(ys, np.arange(2.35, 1.5, -0.1))
    (passage,) = world.door_cells
    assert {tuple(cell) for cell in passage.tolist()} == {(row, col) for row in rows for col in (column - 1, column)}


def test_a_narrow_door_is_widened_and_a_point_becomes_one():
    for line in (LineString([(4, 1.9), (4, 2)]), LineString([(4, 2), (4, 2)])):
        world = build_world(replace(two_rooms(), doors=(Door((1, 2), line, 0.1),)))
        assert np.count_nonzero(world.free[:, world.cell(4, 2)[1]]) == 9


def test_entrances_stay_closed():
    entrance = Door((1, None), LineString([(0, 1), (0, 2)]), 1)
    world = build_world(replace(two_rooms(), doors=(entrance,)))
    assert np.array_equal(world.blocked, two_room_world(door=False).blocked)


@pytest.mark.parametrize("floor_type", FLOOR_MAKERS)
def test_a_gap_between_rooms_is_the_wall(floor_type):
    floor = make_floor(floor_type, seed=3)
    world = build_world(floor, wall=0.1)
    inside = floor.label_image(world.grid) > 0
    assert not (world.blocked & inside).any()
    assert len(world.door_cells) == len(floor.doors)
    assert all(len(cells) and world.free[tuple(cells.T)].all() for cells in world.door_cells)


@pytest.mark.slow
@pytest.mark.parametrize("floor_type", FLOOR_MAKERS)
def test_every_room_of_a_synthetic_floor_is_reached_and_no_wall_leaks(floor_type):
    floor = make_floor(floor_type, seed=1)
    world = build_world(floor)
    reached = reachable_cells(world, [world.cell(*find_starts(world)[0])], radius=0.2)
    assert {room.id for room in floor.rooms} == {*np.unique(world.room_of_cell[reached]).tolist()} - {0}
    shut = build_world(replace(floor, doors=()))
    alone = reachable_cells(shut, [shut.cell(*find_starts(shut)[0])], radius=0.2)
    assert np.unique(shut.room_of_cell[alone]).tolist() == [1]


def test_the_origin_of_a_world_is_that_of_its_floor():
    world = two_room_world()
    cell = world.cell(5.5, 3)
    assert world.room_of_cell[cell] == 2
    assert world.point(cell) == pytest.approx((5.5, 3), abs=0.051)


@pytest.mark.parametrize(
    ("options", "messages"),
    [
        ({"resolution": 0}, "resolution"),
        ({"wall": -1}, "wall"),
        ({"door": float("nan")}, "door"),
        ({"resolution": 0.0001}, "cells"),
    ],
)
def test_lengths_without_meaning_are_refused(options, messages):
    with pytest.raises(OptionError, match=messages):
        build_world(two_rooms(), **options)


def test_a_floor_without_rooms_is_refused():
    with pytest.raises(OptionError, match="rooms"):
        build_world(Floor(()))


def test_unknown_cells_of_a_grid_map_are_obstacles():
    world = read_world(GridMap(draw_cells("#?. ..."), 0.5, (1, 2, 0.3)))
    assert world.blocked.tolist() == [[True, True, False], [False, False, False]]
    assert (world.resolution, world.origin) == (0.5, (1, 2, 0.3))
    assert world.floor is None


def test_clear_cells_are_further_from_obstacles_than_the_radius():
    blocked = np.zeros((7, 7), bool)
    blocked[3, 3] = True
    clear = clear_cells(blocked, 1)
    assert np.argwhere(~clear[1:-1, 1:-1]).tolist() == [[1, 2], [2, 1], [2, 2], [2, 3], [3, 2]]
    assert not clear[0].any()
    assert not clear[:, -1].any()


@pytest.mark.slow
@given(cells=st.lists(st.lists(st.booleans(), min_size=6, max_size=6), min_size=5, max_size=9), radius=st.floats(0, 3))
def test_cells_are_clear_if_all_cells_within_the_radius_are_free(cells, radius):
    blocked = np.pad(np.array(cells), 4, constant_values=True)
    obstacles = np.argwhere(blocked) - 4
    clear = clear_cells(np.array(cells), radius)
    for cell in np.ndindex(clear.shape):
        squares = ((obstacles - cell) ** 2).sum(axis=1)
        assert clear[cell] == (squares > radius**2).all()


def test_corners_count_as_explorable_and_rooms_behind_walls_do_not():
    world = two_room_world(door=False)
    reachable = reachable_cells(world, [world.cell(2, 2)], radius=0.2)
    area = explorable_cells(world, reachable, radius=0.2)
    assert np.array_equal(area, world.room_of_cell == 1)


def test_a_start_at_the_entrance_comes_before_stairs_and_these_before_corridors():
    floor = two_rooms()
    entrance = Door((1, None), LineString([(0, 1), (0, 2)]), 1)
    at_entrance = find_starts(build_world(replace(floor, doors=(*floor.doors, entrance))))
    assert len(at_entrance) == 1
    assert Point(at_entrance[0]).distance(Point(0.25, 1.5)) < 0.15
    ((x, y),) = find_starts(build_world(floor))
    assert box(5, 1, 6.2, 3).contains(Point(x, y))
    halls = replace(floor, rooms=(replace(floor.rooms[0], label="HALL"), replace(floor.rooms[1], label="OFFICE")))
    ((x, y),) = find_starts(build_world(halls))
    assert box(1, 1, 3, 3).contains(Point(x, y))


def test_a_map_without_a_floor_starts_in_its_widest_place():
    world = draw_world("######## ###....# #......# #.#....# ########")
    assert find_starts(world, radius=0.5) == [world.point((2, 4))]


def test_a_shut_room_is_no_start_when_there_is_a_larger_part():
    closed = Floor((Room(1, box(0, 0, 2, 2), "STAIRS"), Room(2, box(3, 0, 9, 4), "ROOM")))
    ((x, _),) = find_starts(build_world(closed))
    assert x > 3


def test_a_world_that_is_too_narrow_has_no_start():
    with pytest.raises(OptionError, match="radius"):
        find_starts(two_room_world(), radius=3)


@pytest.mark.parametrize(
    ("start", "messages"),
    [
        ((100, 100), "outside"),
        ((-0.2, 2), "wall"),
        ((4, 0.5), "wall"),
        ((0.15, 2), "radius"),
        ((float("nan"), 2), "finite"),
    ],
)
def test_a_start_where_no_robot_can_stand_is_one_clear_line(start, messages):
    with pytest.raises(OptionError, match=messages) as raised:
        check_start(two_room_world(), start, radius=0.2)
    assert "\n" not in str(raised.value)


def test_robots_start_beside_each_other():
    world = two_room_world()
    points = place_robots(world, [(2, 2), (3, 3)], 4, radius=0.2)
    assert points[:2] == [(2, 2), (3, 3)]
    gaps = [Point(one).distance(Point(other)) for i, one in enumerate(points) for other in points[:i]]
    assert min(gaps) > 0.55
    clear = clear_cells(world.blocked, 0.2 / world.resolution)
    assert all(clear[world.cell(*point)] for point in points)
    assert Point(points[2]).distance(Point(2, 2)) < 0.75


def test_too_many_robots_for_a_room_are_refused():
    with pytest.raises(OptionError, match="robot"):
        place_robots(two_room_world(door=False), [(2, 2)], 100, radius=0.2)


@pytest.mark.parametrize(
    ("resolution", "message"),
    [(100, "cells of 100 m are too coarse"), (1e300, "too coarse"), (1e-9, "5e-08 m across"), (1e-300, "m across")],
)
def test_maps_on_which_no_robot_can_drive_are_refused(resolution, message):
    with pytest.raises(MapError, match=message):
        read_world(GridMap(np.zeros((50, 50), np.int8), resolution, (0.0, 0.0, 0.0)))
