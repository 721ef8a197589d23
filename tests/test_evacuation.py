"""Evacuation: ways, rooms with one way out, people and times on floors that can be worked out by hand."""

import json
import warnings
from itertools import pairwise
from math import hypot, inf, sqrt
from typing import Any

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.collections import LineCollection
from shapely import LineString, Polygon, box

import pianta
from pianta.errors import BuildingWarning, OptionError
from pianta.evacuation.evacuation import Evacuation
from pianta.evacuation.flow import FREE_SPEED, MAX_FLOW, door_capacity, pass_queue, walking_speed
from pianta.evacuation.people import EMPTY_LABELS, SQUARE_FEET_PER_PERSON, count_people
from pianta.exploration.routes import measure_distances
from pianta.exploration.world import build_world
from pianta.floor import Door, Floor, Room
from pianta.labels import SCHEMAS
from tests.hidden_figures import hiding_figures


def upright(rooms: tuple[int, int | None], x: float, y: float, width: float = 1.0) -> Door:
    """A door in an upright wall, with its middle at x, y."""
    return Door(rooms, LineString([(x, y - width / 2), (x, y + width / 2)]), width)


def level(rooms: tuple[int, int | None], x: float, y: float, width: float = 1.0) -> Door:
    """A door in a level wall, with its middle at x, y."""
    return Door(rooms, LineString([(x - width / 2, y), (x + width / 2, y)]), width)


# Two rooms of 4 m × 3 m in a row, and an entrance at the far end of the second.
ROW = Floor(
    (Room(1, box(0, 0, 4, 3), "OFFICE"), Room(2, box(4, 0, 8, 3), "CORRIDOR")),
    (upright((1, 2), 4, 1.5), upright((2, None), 8, 1.5)),
)
# A corridor with a corner at (8, 2), a room at one end and an entrance at the other.
BEND = Polygon([(0, 0), (10, 0), (10, 10), (8, 10), (8, 2), (0, 2)])
ANGLE = Floor((Room(1, box(-4, 0, 0, 2)), Room(2, BEND)), (upright((1, 2), 0, 1), level((2, None), 9, 10)))


def ways_of(floor: Floor, **options: object) -> dict[int, object]:
    return {way.room: way for way in pianta.evacuate(floor, **options).ways}  # type: ignore[arg-type]


class TestWays:
    def test_from_the_middle_and_the_farthest_point_through_two_doors(self):
        first, second = pianta.evacuate(ROW).ways
        assert first.distance == pytest.approx(2 + 4)
        assert first.doors == (1, 2)
        assert first.longest == pytest.approx(hypot(4, 1.5) + 4)
        assert second.distance == pytest.approx(2)
        assert second.doors == (2,)
        assert first.line.tolist() == [[2, 1.5], [4, 1.5], [4, 1.5], [8, 1.5], [8, 1.5]]

    def test_a_way_bends_at_the_corner_of_a_corridor(self):
        first, _ = pianta.evacuate(ANGLE).ways
        assert first.distance == pytest.approx(2 + sqrt(65) + sqrt(65))
        assert [8, 2] in first.line.tolist()

    def test_a_way_through_thick_walls_is_measured_from_room_to_room(self):
        """Half a metre of wall; the door is in its middle."""
        floor = Floor(
            (Room(1, box(0, 0, 4, 3)), Room(2, box(4.5, 0, 8, 3))),
            (upright((1, 2), 4.25, 1.5), upright((2, None), 8, 1.5)),
        )
        assert pianta.evacuate(floor).ways[0].distance == pytest.approx(6)

    def test_a_way_around_a_courtyard_takes_the_shorter_side(self):
        ring = box(0, 0, 12, 12).difference(box(2, 2, 10, 10))
        floor = Floor(
            (Room(1, box(-2, 5, 0, 7)), Room(2, ring)), (upright((1, 2), 0, 5.9), upright((2, None), 12, 5.9))
        )
        # From (0, 5.9) by the lower corners (2, 2) and (10, 2).
        assert pianta.evacuate(floor).ways[0].distance == pytest.approx(hypot(1, 0.1) + 8 + 2 * hypot(2, 3.9))

    def test_the_farthest_point_of_a_corridor_with_two_exits_is_between_them(self):
        floor = Floor((Room(1, box(0, 0, 40, 2)),), (upright((1, None), 0, 1), upright((1, None), 40, 1)))
        (way,) = pianta.evacuate(floor).ways
        assert way.longest == pytest.approx(hypot(20, 1), abs=0.05)

    def test_ways_are_those_on_a_grid_to_within_its_eight_directions(self):
        """A grid is at most 8 % longer, and shorter by what it saves beside the middles of doors."""
        floor, _ = pianta.make_world("ring", seed=3)
        exit_room = floor.rooms[-1].id
        world = build_world(floor, wall=0.1)
        sources = [(int(row), int(col)) for row, col in np.argwhere(world.room_of_cell == exit_room)]
        cells = measure_distances(world.free, sources, resolution=world.resolution)
        for way in pianta.evacuate(floor, exits=[exit_room]).ways:
            if way.room != exit_room:
                assert -0.75 < cells[world.cell(*way.line[0])] - way.distance < 0.083 * way.distance

    def test_a_door_on_a_side_corner_does_not_join_neighbouring_corners(self):
        """Corners that follow each other in a zigzag are no sides of a door, although their numbers are pairs."""
        steps = [(0, 0), (6, 0), (6, 6), (5, 6), (5, 5), (4, 5), (4, 4), (3, 4), (3, 3), (2, 3), (2, 2), (0, 2)]
        floor = Floor((Room(1, Polygon(steps)),), (level((1, None), 5.5, 6),))
        assert pianta.evacuate(floor).ways[0].doors == (1,)


class TestExits:
    def test_entrances_come_before_labels(self):
        labelled = Floor((ROW.rooms[0], Room(2, ROW.rooms[1].polygon, "STAIRS")), ROW.doors)
        evacuation = pianta.evacuate(labelled)
        assert (evacuation.exit_rooms, evacuation.exit_doors) == ((), (2,))

    @pytest.mark.parametrize("label", ["ENTRANCE", "STAIRS", "stairs"])
    def test_without_entrances_people_are_out_in_rooms_with_a_label(self, label):
        floor = Floor((ROW.rooms[0], Room(2, ROW.rooms[1].polygon, label)), ROW.doors[:1])
        first, second = pianta.evacuate(floor).ways
        assert first.distance == pytest.approx(2)
        assert first.doors == (1,)
        assert (second.distance, second.longest, second.people, second.shared_doors) == (0, 0, 0, ())

    def test_a_lift_is_no_exit(self):
        floor = Floor((ROW.rooms[0], Room(2, ROW.rooms[1].polygon, "ELEVATOR")), ROW.doors[:1])
        with pytest.raises(OptionError, match="no exit is known"):
            pianta.evacuate(floor)

    def test_given_exits_replace_entrances(self):
        evacuation = pianta.evacuate(ROW, exits=[1])
        assert (evacuation.exit_rooms, evacuation.exit_doors) == ((1,), ())
        assert evacuation.ways[1].doors == (1,)


# Classrooms 1 and 2, each with a door to corridor 3; closet 4 behind room 1; corridor 3 has two entrances.
SCHOOL = Floor(
    (
        Room(1, box(0, 2, 4, 6), "CLASSROOM"),
        Room(2, box(4, 2, 8, 6), "CLASSROOM"),
        Room(3, box(0, 0, 8, 2), "CORRIDOR"),
        Room(4, box(0, 6, 2, 8), "CLOSET"),
    ),
    (
        level((1, 3), 2, 2),
        level((2, 3), 6, 2),
        level((1, 4), 1, 6),
        upright((3, None), 0, 1),
        upright((3, None), 8, 1),
    ),
)


class TestOneWay:
    def test_doors_and_rooms_that_all_ways_share(self):
        ways = {way.room: way for way in pianta.evacuate(SCHOOL).ways}
        assert {room: way.shared_doors for room, way in ways.items()} == {1: (1,), 2: (2,), 3: (), 4: (1, 3)}
        assert {room: way.shared_rooms for room, way in ways.items()} == {1: (3,), 2: (3,), 3: (), 4: (1, 3)}

    def test_a_dead_end_is_what_has_one_way_behind_its_own_door(self):
        evacuation = pianta.evacuate(SCHOOL)
        assert (evacuation.one_way, evacuation.dead_ends) == ((1, 2, 4), (4,))

    def test_its_length_is_from_the_farthest_point_to_the_last_door_that_all_ways_share(self):
        """From the corner (2, 8) by the door at (1, 6) to that at (2, 2)."""
        way = pianta.evacuate(SCHOOL).ways[3]
        assert way.dead_end == pytest.approx(hypot(1, 2) + hypot(1, 4))

    def test_one_entrance_is_shared_by_all(self):
        evacuation = pianta.evacuate(SCHOOL, shut=[4])
        assert all(5 in way.shared_doors for way in evacuation.ways)
        assert evacuation.one_way == (1, 2, 3, 4)

    @given(st.data())
    @settings(max_examples=25, deadline=None)
    def test_shared_doors_are_those_without_which_a_graph_has_no_path(self, data):
        floor = data.draw(random_floors())
        graph = nx.MultiGraph()
        graph.add_nodes_from([0, *(room.id for room in floor.rooms)])
        ends = [(first, second or 0) for first, second in (door.rooms for door in floor.doors)]
        graph.add_edges_from((*pair, number) for number, pair in enumerate(ends, start=1))
        for way in evacuate_quietly(floor).ways:
            shared = []
            for number, pair in enumerate(ends, start=1):
                graph.remove_edge(*pair, key=number)
                if not nx.has_path(graph, way.room, 0):
                    shared.append(number)
                graph.add_edge(*pair, key=number)
            if nx.has_path(graph, way.room, 0):
                assert list(way.shared_doors) == shared
            else:
                assert (way.longest, way.shared_doors, way.line.size) == (inf, (), 0)


class TestShutDoors:
    def test_a_shut_door_lengthens_ways(self):
        """The classroom on the left has to walk to the right."""
        assert pianta.evacuate(SCHOOL).ways[0].distance == pytest.approx(2 + hypot(2, 1))
        assert pianta.evacuate(SCHOOL, shut=[4]).ways[0].distance == pytest.approx(2 + hypot(6, 1))

    def test_two_rooms_name_all_doors_between_them(self):
        with pytest.raises(OptionError, match="no room has a way"):
            pianta.evacuate(SCHOOL, shut=[(3, None)])

    def test_rooms_behind_it_are_cut_off_and_reported(self):
        with pytest.warns(BuildingWarning, match="2 of 4 rooms have no way out.*: 1, 4"):
            evacuation = pianta.evacuate(SCHOOL, shut=[(3, 1)])
        assert evacuation.cut_off == (1, 4)
        assert evacuation.ways[0].time is None
        assert evacuation.doors[0].is_shut
        assert all(door.number != 1 for door in evacuation.rank_doors())

    def test_each_door_is_tried(self):
        """A classroom of 16 m² has 9 people, a closet of 4 m² none."""
        evacuation = pianta.evacuate(SCHOOL)
        by_number = {door.number: door for door in evacuation.doors}
        assert [(n, d.cut_off, d.people_cut_off) for n, d in by_number.items()] == [
            (1, (1, 4), 9),
            (2, (2,), 9),
            (3, (4,), 0),
            (4, (), 0),
            (5, (), 0),
        ]
        assert by_number[4].longest_if_shut == pytest.approx(pianta.evacuate(SCHOOL, shut=[4]).longest.longest)
        assert by_number[4].time_if_shut == pytest.approx(pianta.evacuate(SCHOOL, shut=[4]).time)
        assert [door.number for door in evacuation.rank_doors()][:2] == [1, 2]

    def test_a_door_that_only_empty_rooms_use_is_tried_too(self):
        evacuation = pianta.evacuate(SCHOOL, people={1: 0, 2: 0, 3: 0, 4: 0})
        assert evacuation.doors[3].longest_if_shut > evacuation.longest.longest
        assert evacuation.doors[3].longest_if_shut == pytest.approx(pianta.evacuate(SCHOOL, shut=[4]).longest.longest)

    @given(st.data())
    @settings(max_examples=25, deadline=None)
    def test_each_door_is_tried_as_if_it_were_shut(self, data):
        floor = data.draw(random_floors())
        door = data.draw(st.sampled_from(evacuate_quietly(floor, density=0.5).doors))
        try:
            after = evacuate_quietly(floor, density=0.5, shut=[door.number])
        except OptionError:
            return
        assert door.time_if_shut == pytest.approx(after.time)
        assert door.longest_if_shut == pytest.approx(after.longest.longest)

    @given(st.data())
    @settings(max_examples=25, deadline=None)
    def test_it_never_shortens_a_way(self, data):
        floor = data.draw(random_floors())
        door = data.draw(st.integers(1, len(floor.doors)))
        before = evacuate_quietly(floor)
        try:
            after = evacuate_quietly(floor, shut=[door])
        except OptionError:
            return
        for one, other in zip(before.ways, after.ways, strict=True):
            assert other.distance >= one.distance - 1e-9
            assert other.longest >= one.longest - 1e-9
            assert {*one.shared_doors} - {door} <= {*other.shared_doors} or other.longest == inf


class TestPeople:
    def test_they_follow_from_label_and_area(self):
        """20 square feet a person are 1.858 m², 150 are 13.94 m²."""
        floor = Floor(
            (
                Room(1, box(0, 0, 10, 1.858), "classroom"),
                Room(2, box(0, 2, 10, 16), "OFFICE"),
                Room(3, box(0, 20, 10, 30), "CORRIDOR"),
                Room(4, box(0, 30, 10, 44)),
                Room(5, box(0, 50, 10, 51), "DRAGON LAIR"),
            )
        )
        assert count_people(floor) == {1: 10, 2: 10, 3: 0, 4: 10, 5: 1}
        assert count_people(floor, density=0.5) == {1: 9, 2: 70, 3: 50, 4: 70, 5: 5}
        options: Any = {"densities": {"Office": 0.1, "CORRIDOR": 0.01}, "people": {5: 7}, "exit_rooms": {1}}
        assert count_people(floor, **options) == {1: 0, 2: 14, 3: 1, 4: 10, 5: 7}

    @pytest.mark.parametrize(
        ("building_type", "people"), [({"school": 0.7, "office": 0.2}, 50), ({"office": 0.9}, 7), ({}, 7)]
    )
    def test_functional_rooms_are_classrooms_in_schools(self, building_type, people):
        """93 m² are 1000 square feet."""
        floor = Floor((Room(1, box(0, 0, 10, 9.29), "FUNCTIONAL"),), building_type=building_type)
        assert count_people(floor) == {1: people}

    def test_every_label_of_the_thesis_has_a_number(self):
        names = {name for schema in SCHEMAS.values() for name in schema.by_name}
        assert names <= {*SQUARE_FEET_PER_PERSON, *EMPTY_LABELS}

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"people": {1: -1}}, r"people= has -1 for room 1"),
            ({"people": {1: 85}}, r"people= has 85 for room 1, give 0 to 84"),
            ({"people": {9: 1}}, r"people= has the rooms 9"),
            ({"densities": {"OFFICE": -0.5}}, r"density= is -0.5 for OFFICE"),
            ({"density": float("nan")}, r"density= is nan"),
            ({"density": 8}, r"density= is 8"),
            ({"exits": [7, 8]}, r"exits= has the rooms 7, 8"),
            ({"shut": [3]}, r"shut= has the door 3, which does not exist, give a number from 1 to 2"),
            ({"shut": [0]}, r"shut= has the door 0"),
            ({"shut": [(1, None)]}, r"shut= has the door 1-out"),
            ({"shut": [2]}, r"no room has a way to an exit"),
        ],
    )
    def test_impossible_options_are_refused_in_one_line(self, options, message):
        with pytest.raises(OptionError, match=message) as error:
            pianta.evacuate(ROW, **options)
        assert "\n" not in str(error.value)

    def test_a_floor_without_doors_has_no_exit(self):
        with pytest.raises(OptionError, match="no exit is known"):
            pianta.evacuate(Floor((Room(1, box(0, 0, 4, 3)),)))

    def test_the_only_room_may_be_the_exit(self):
        evacuation = pianta.evacuate(Floor((Room(1, box(0, 0, 4, 3)),)), exits=[1])
        assert (evacuation.people, evacuation.time, evacuation.longest.longest) == (0, 0, 0)


class TestTimes:
    def test_formulas_of_the_handbook(self):
        assert pytest.approx(1.316, abs=0.001) == MAX_FLOW
        assert door_capacity(0.9) == pytest.approx(0.6 * MAX_FLOW)
        assert door_capacity(0.3) == door_capacity(0.6) == pytest.approx(0.3 * MAX_FLOW)
        assert walking_speed(0.3) == walking_speed(0.54) == pytest.approx(1.199, abs=0.001)
        assert walking_speed(1.0) == pytest.approx(1.40 * (1 - 0.266))
        assert walking_speed(5) == pytest.approx(0.7)

    def test_one_person_only_walks(self):
        evacuation = pianta.evacuate(ROW, people={1: 1})
        assert evacuation.time == evacuation.ways[0].time == pytest.approx((hypot(4, 1.5) + 4) / FREE_SPEED)
        assert evacuation.time == evacuation.time_without_queues

    def test_a_crowd_in_a_small_room_waits_at_its_door(self):
        """Of 7 people in 1 m² one is in a corner, six in the middle; they are at the door before it is free."""
        floor = Floor((Room(1, box(0, 0, 1, 1)),), (upright((1, None), 1, 0.5, 0.9),))
        evacuation = pianta.evacuate(floor, people={1: 7})
        assert evacuation.time == pytest.approx(0.5 / 0.7 + 6 / 0.78947, abs=1e-3)
        (door,) = evacuation.doors
        assert door.people == 7
        assert door.last == pytest.approx(evacuation.time)
        assert door.wait == pytest.approx(evacuation.time - hypot(1, 0.5) / 0.7)
        assert evacuation.time_without_queues == pytest.approx(hypot(1, 0.5) / 0.7)

    def test_people_of_two_rooms_share_the_queue_of_one_door(self):
        """The last of 18 pupils passes at least 17 gaps after the first; without that door it takes half as long."""
        one_exit = pianta.evacuate(SCHOOL, shut=[4])
        gap = 1 / door_capacity(1.0)
        assert one_exit.doors[4].people == 18
        assert one_exit.time >= 17 * gap
        assert pianta.evacuate(SCHOOL).time < one_exit.time

    def test_wide_doors_are_faster(self):
        narrow, wide = (
            pianta.evacuate(Floor(ROW.rooms, (upright((1, 2), 4, 1.5, width), ROW.doors[1])), people={1: 40}).time
            for width in (0.8, 1.6)
        )
        assert wide < narrow

    def test_a_queue_serves_in_order(self):
        assert pass_queue(np.array([1.0, 1.0, 1.5, 20.0]), 0.5).tolist() == [1, 3, 5, 20]
        assert pass_queue(np.zeros(0), 0.5).tolist() == []

    def test_a_person_walks_along_a_corridor(self):
        """IMO MSC.1/Circ.1238 (2007), annex 3, test 1: 40 m, here with the speed of the handbook."""
        floor = Floor((Room(1, box(0, 0, 40, 2)),), (upright((1, None), 40, 1),))
        assert pianta.evacuate(floor, people={1: 1}).time == pytest.approx(hypot(40, 1) / 1.199, rel=1e-3)

    def test_the_flow_through_an_exit_is_limited(self):
        """IMO, test 4: 100 persons, 8 m by 5 m, an exit of 1 m: at most 1.33 persons per second."""
        floor = Floor((Room(1, box(0, 0, 8, 5)),), (upright((1, None), 8, 2.5),))
        assert 0.8 < 100 / pianta.evacuate(floor, people={1: 100}).time < 1.33

    def test_half_of_the_exits_take_twice_as_long(self):
        """IMO, test 9: 1000 persons in a hall of 30 m by 20 m with four exits of 1 m, then with two."""
        exits = tuple(level((1, None), x, y) for y in (0, 20) for x in (5, 25))
        hall = Floor((Room(1, box(0, 0, 30, 20)),), exits)
        four, two = (pianta.evacuate(hall, people={1: 1000}, shut=shut).time for shut in ((), (1, 2)))
        assert two / four == pytest.approx(2, abs=0.1)

    @given(st.data())
    @settings(max_examples=25, deadline=None)
    def test_more_people_are_never_out_earlier(self, data):
        floor = data.draw(random_floors())
        people = {room.id: data.draw(st.integers(0, 25)) for room in floor.rooms}
        more = {room: count + data.draw(st.integers(0, 8)) for room, count in people.items()}
        fewer_out, more_out = (evacuate_quietly(floor, people=counts) for counts in (people, more))
        assert more_out.time >= fewer_out.time - 1e-9
        assert more_out.time_without_queues >= fewer_out.time_without_queues - 1e-9
        assert fewer_out.time >= fewer_out.time_without_queues - 1e-9


class TestResult:
    def test_json_has_no_infinity(self):
        with pytest.warns(BuildingWarning, match="no way out"):
            evacuation = pianta.evacuate(SCHOOL, shut=[1])
        content = json.loads(json.dumps(evacuation.as_json(), allow_nan=False))
        assert content["rooms"][0]["longest"] is None
        assert content["cut_off"] == [1, 4]
        assert content["doors"][1]["rooms"] == [2, 3]
        assert content["rooms"][1]["line"][0] == [6, 4]

    def test_the_picture_shows_rooms_ways_and_marks(self):
        with hiding_figures():
            ax = evacuate_quietly(SCHOOL, shut=[1]).plot()
        hatches = {artist.get_hatch() for artist in ax.get_children() if hasattr(artist, "get_hatch")}
        assert "xxxx" in hatches
        (ways,) = [each for each in ax.collections if isinstance(each, LineCollection)]
        lines = [way.line.tolist() for way in evacuate_quietly(SCHOOL, shut=[1]).ways]
        assert len(ways.get_segments()) == len({pair for line in lines for pair in pairwise(map(tuple, line))})
        assert {line.get_marker() for line in ax.lines} >= {"X", "o"}


@st.composite
def random_floors(draw: st.DrawFn) -> Floor:
    """Rooms of 3 m × 3 m in rows and columns, doors between some neighbours, and one to three entrances."""
    rows, cols = draw(st.integers(1, 3)), draw(st.integers(1, 4))
    rooms = [
        Room(row * cols + col + 1, box(3 * col, 3 * row, 3 * col + 3, 3 * row + 3))
        for row in range(rows)
        for col in range(cols)
    ]
    sides = [
        upright((room.id, room.id + 1), 3 * ((room.id - 1) % cols) + 3, 3 * ((room.id - 1) // cols) + 1.2)
        for room in rooms
        if room.id % cols
    ]
    sides += [
        level((room.id, room.id + cols), 3 * ((room.id - 1) % cols) + 1.7, 3 * ((room.id - 1) // cols) + 3)
        for room in rooms[: (rows - 1) * cols]
    ]
    doors = [door for door in sides if draw(st.booleans())]
    columns = draw(st.lists(st.integers(0, cols - 1), min_size=1, max_size=3, unique=True))
    doors += [level((col + 1, None), 3 * col + draw(st.sampled_from([0.6, 1.5, 2.2])), 0) for col in columns]
    return Floor(tuple(rooms), tuple(doors))


def evacuate_quietly(floor: Floor, **options: Any) -> Evacuation:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        return pianta.evacuate(floor, **options)
