"""Rooms on one line and rooms that are mirror images: by hand, and independent of scale, turn and position."""

from dataclasses import replace

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Polygon, box
from shapely.affinity import affine_transform

from pianta.floor import Door, Floor, Room
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.layout.reconstruct import reconstruct
from pianta.relational.room_relations import find_aligned, find_symmetric
from pianta.worlds.floors import make_corridor_floor, make_floor
from pianta.worlds.scan import simulate_map


def floor_of(*polygons: Polygon, walls=()) -> Floor:
    return Floor(tuple(Room(n, polygon) for n, polygon in enumerate(polygons, 1)), walls=walls)


# Two offices above a corridor.
OFFICES = (box(0, 2, 4, 7), box(4, 2, 8, 7), box(0, 0, 20, 2))


def test_rooms_with_walls_on_one_line_are_aligned():
    # The fourth has its lower wall on the upper wall of the corridor; the last has walls half a metre from all others.
    floor = floor_of(*OFFICES, box(12, 2, 16, 6), box(20.5, 2.5, 24.5, 8))
    assert find_aligned(floor) == [(1, 2), (1, 3), (1, 4), (2, 3), (2, 4), (3, 4)]


def test_rooms_far_apart_are_aligned_across_the_building():
    # Upper walls at y = 5, of rooms 60 m apart; at that distance a turn by 0.5° is a shift of half a metre.
    tilted = Polygon([(60, 0.6), (64, 0.6), (64, 5.02), (60, 4.98)])
    # Many long walls fix the direction.
    row = [box(4 * n, 0, 4 * n + 4, 5) for n in range(5)]
    pairs = find_aligned(floor_of(*row, tilted))
    assert {(n, 6) for n in range(1, 6)} <= set(pairs)
    lower = Polygon([(60, 0.6), (64, 0.6), (64, 4.42), (60, 4.38)])
    assert not {(n, 6) for n in range(1, 6)} & set(find_aligned(floor_of(*row, lower)))


def test_both_sides_of_a_wall_are_one_line():
    # Rooms of a robot's map are 0.2 m apart; the lengths of doors show how thick the wall is.
    rooms = floor_of(box(0, 0, 4, 5), box(4.2, 5.2, 8, 10), box(4.2, 0.7, 8, 4))
    doors = (Door((1, 3), LineString([(4.1, 1), (4.1, 2)]), 1.0),)
    assert find_aligned(replace(rooms, doors=doors)) == [(1, 2), (1, 3), (2, 3)]


def test_walls_of_the_floor_are_the_lines_where_there_are_any():
    rooms = OFFICES[:2]
    wall = LineString([(-1, 7), (9, 7)])
    assert find_aligned(floor_of(*rooms)) == [(1, 2)]
    assert find_aligned(floor_of(*rooms, walls=[wall])) == [(1, 2)]
    assert find_aligned(floor_of(*rooms, walls=[LineString([(-1, 8), (9, 8)])])) == []
    # A line across their walls is a wall of neither room, in both directions of the line.
    assert find_aligned(floor_of(*rooms, walls=[LineString([(2, 0), (2, 9)])])) == []
    assert find_aligned(floor_of(*rooms, walls=[wall.reverse()])) == [(1, 2)]


def test_niches_align_nothing():
    first = Polygon([(0, 0), (4, 0), (4, 5), (0, 5)])
    second = Polygon([(10, 0.7), (14, 0.7), (14, 4.4), (12.5, 4.4), (12.5, 5), (12, 5), (12, 4.4), (10, 4.4)])
    assert find_aligned(floor_of(first, second)) == []


def test_mirror_images_in_the_axis_of_the_building_are_symmetric():
    # Classrooms, stores and gyms of two wings; the entrance hall between them is its own image.
    west = [box(0, 0, 7, 9), box(7, 0, 10, 4), box(0, 12, 13, 26)]
    east = [box(20, 0, 27, 9), box(17, 0, 20, 4), box(14, 12, 27, 26)]
    hall = box(10, -3, 17, 12)
    assert find_symmetric(floor_of(*west, *east, hall)) == [(1, 4), (2, 5), (3, 6)]


def test_an_l_is_mirrored_and_not_moved():
    left = Polygon([(0, 0), (6, 0), (6, 2), (2, 2), (2, 6), (0, 6)])
    moved = Polygon([(8, 0), (14, 0), (14, 2), (10, 2), (10, 6), (8, 6)])
    mirrored = Polygon([(14, 0), (14, 6), (12, 6), (12, 2), (8, 2), (8, 0)])
    assert find_symmetric(floor_of(left, mirrored)) == [(1, 2)]
    assert find_symmetric(floor_of(left, moved)) == []


def test_a_few_equal_rooms_make_no_axis_of_a_building():
    pair = box(0, 0, 3, 3), box(3, 0, 6, 3)
    assert find_symmetric(floor_of(*pair)) == [(1, 2)]
    assert find_symmetric(floor_of(*pair, box(6, 0, 9, 5), box(12, 0, 20, 4), box(20, 4, 30, 12))) == []


def test_the_axis_of_a_row_is_that_of_the_whole_row():
    # All rooms are equal; an axis that leaves one of them out would mirror three quarters.
    assert find_symmetric(floor_of(*(box(3 * n, 0, 3 * n + 3, 5) for n in range(4)))) == [(1, 4), (2, 3)]


def test_a_building_may_have_two_axes():
    corners = [box(x, y, x + 4, y + 3) for x in (0, 8) for y in (0, 6)]
    # Each room is the mirror image of its two neighbours, but not of the room in the opposite corner.
    assert find_symmetric(floor_of(*corners)) == [(1, 2), (1, 3), (2, 4), (3, 4)]


@pytest.mark.parametrize("find", [find_aligned, find_symmetric])
def test_one_room_or_none_has_no_relation(find):
    assert find(Floor(())) == []
    assert find(floor_of(box(0, 0, 4, 5))) == []
    # No edge of a circle of short edges is long enough for a wall.
    assert find(floor_of(shapely.Point(0, 0).buffer(3, quad_segs=32))) == []


def moved(floor: Floor, *, turn: float, scale: float, shift: tuple[float, float], mirror: bool) -> Floor:
    cos, sin, side = scale * np.cos(turn), scale * np.sin(turn), -1 if mirror else 1
    matrix = [side * cos, -sin, side * sin, cos, *shift]
    rooms = tuple(replace(room, polygon=affine_transform(room.polygon, matrix)) for room in floor.rooms)
    walls = tuple(affine_transform(wall, matrix) for wall in floor.walls)
    doors = tuple(
        replace(door, line=affine_transform(door.line, matrix), width=scale * door.width) for door in floor.doors
    )
    return replace(floor, rooms=rooms, walls=walls, doors=doors)


motions = st.fixed_dictionaries(
    {
        "turn": st.floats(0, 7),
        "scale": st.sampled_from([0.01, 0.5, 3.0]),
        "shift": st.tuples(*[st.floats(-1e3, 1e3)] * 2),
        "mirror": st.booleans(),
    }
)


@pytest.mark.slow
@pytest.mark.parametrize("with_walls", [False, True])
@pytest.mark.parametrize("building_type", ["corridor", "hall", "ring"])
@settings(max_examples=40)
@given(motion=motions, random=st.randoms(use_true_random=False))
def test_scale_turn_shift_and_order_change_nothing(building_type, with_walls, motion, random):
    floor = make_floor(building_type, seed=4)
    floor = floor if with_walls else replace(floor, walls=())
    rooms = [*floor.rooms]
    random.shuffle(rooms)
    other = moved(replace(floor, rooms=tuple(rooms)), **motion)
    aligned, symmetric = find_aligned(floor), find_symmetric(floor)
    assert len(aligned) > len(floor.rooms)
    assert symmetric
    assert find_aligned(other) == aligned
    assert find_symmetric(other) == symmetric


@pytest.mark.slow
@given(seed=st.integers(0, 1000))
def test_rooms_of_one_row_are_aligned(seed):
    floor = make_corridor_floor(seed=seed)
    corridor, *rooms = floor.rooms
    pairs = set(find_aligned(replace(floor, walls=())))
    for side in (-1, 1):
        row = [room.id for room in rooms if side * (room.polygon.centroid.y - corridor.polygon.centroid.y) > 0]
        assert {(one, other) for one in row for other in row if one < other} <= pairs


def test_a_map_has_the_relations_of_the_floor():
    truth = make_floor("corridor", seed=1)
    floor = reconstruct(simulate_map(truth))
    same = {room.id: max(truth.rooms, key=lambda one: one.polygon.intersection(room.polygon).area).id
            for room in floor.rooms}  # fmt: skip
    for find, least in ((find_aligned, 0.85), (find_symmetric, 1.0)):
        there = set(find(truth))
        result = {tuple(sorted((same[one], same[other]))) for one, other in find(floor)}
        assert len(there & result) >= least * len(there | result)


@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
@pytest.mark.parametrize(("name", "pairs"), [("office/pinecondos", 20), ("school/plans1", 7), ("school/bronxville", 0)])
def test_buildings_with_and_without_an_axis(data, name, pairs):
    # By their drawings: two mirrored halves; a school with two equal wings; a school without an axis.
    assert len(find_symmetric(read_building_xml(data / "buildings" / f"{name}.xml"))) == pairs
