"""What robots take for rooms: the true ones, or those that a mapper reads from their map."""

from dataclasses import replace

import numpy as np
import pytest
from shapely import LineString, box

import pianta
from pianta import Door, Floor, GridMap, Mapper, Room
from pianta.errors import OptionError
from pianta.exploration.lidar import Pose
from pianta.exploration.map_perception import (
    MapPerception,
    choose_likeliest_room,
    measure_label_probability,
    recognise_read_rooms,
)
from pianta.exploration.perception import PerfectPerception, WantedRoom
from pianta.exploration.perceptions import make_perception
from pianta.exploration.record import Record
from pianta.exploration.robots import Robot
from pianta.mapping.state import MapState
from tests.explored_worlds import two_room_world

P_GYM = (0.4, 0.5)  # beliefs of two rooms


@pytest.fixture(scope="module")
def run():
    """A corridor with rooms, explored by the nearest frontier, and its perception."""
    floor = pianta.make_world("corridor")[0]
    mapper = Mapper()
    return pianta.explore(floor, "nearest", perception=mapper), mapper, floor


class TestRecognised:
    ROOMS = (
        Room(1, box(0, 0, 4, 4), "CLASSROOM"),
        Room(2, box(4, 0, 5, 4), partial=True, predicted=box(4, 0, 14, 4)),
        Room(3, box(0, 4, 14, 6), "CORRIDOR", partial=True, predicted=box(0, 4, 28, 6)),
    )
    DOORS = (
        Door((1, 2), LineString([(4, 1), (4, 2)]), 1.0),
        Door((1, 3), LineString([(1, 4), (2, 4)]), 1.0),
        Door((3, None), LineString([(0, 4.5), (0, 5.5)]), 1.0),
    )

    def test_a_room_of_which_little_was_seen_is_behind_a_door_that_is_not_open_yet(self):
        recognised = recognise_read_rooms(Floor(self.ROOMS, self.DOORS), np.array([(1.0, 1.0)]))
        assert [(room.id, room.label, room.share, room.entered) for room in recognised.rooms] == [
            (1, "CLASSROOM", 1.0, True),
            (3, "CORRIDOR", 0.5, False),
        ]
        assert [door.rooms for door in recognised.floor.doors] == [(1, 3)]
        assert recognised.unopened == ((1, 0),)
        assert recognised.unopened_lines == (self.DOORS[0].line,)

    def test_a_room_in_which_a_robot_was_is_recognised(self):
        recognised = recognise_read_rooms(Floor(self.ROOMS, self.DOORS), np.array([(4.5, 2.0)]))
        assert [(room.id, room.area, room.share, room.entered) for room in recognised.rooms][1] == (2, 4.0, 0.1, True)
        assert recognised.unopened == ()


def test_robots_read_the_building_from_their_map(run):
    exploration, mapper, floor = run
    scores = pianta.score_floor(mapper.floor, floor)
    assert exploration.outcome == "done"
    assert scores.rooms.f1 > 0.9


def test_perception_does_not_change_a_policy_that_does_not_use_it(run):
    exploration, _, floor = run
    assert np.array_equal(exploration.tracks[0], pianta.explore(floor, "nearest").tracks[0])


def test_a_map_without_rooms_is_explored_with_what_is_read_from_it():
    _, grid = pianta.make_world("corridor")
    mapper = Mapper()
    pianta.explore(replace(grid, cells=np.where(grid.cells < 0, 100, grid.cells)), perception=mapper, stop=0.5)
    assert len(mapper.floor) > 3


def test_perceptions_by_name():
    world = two_room_world()
    assert isinstance(make_perception("perfect", world), PerfectPerception)
    assert isinstance(make_perception("map", world), MapPerception)
    mapper = Mapper()
    perception = make_perception(mapper, world)
    assert isinstance(perception, MapPerception)
    assert perception.mapper is mapper
    with pytest.raises(OptionError, match="perception is 'eyes', give perfect or map"):
        pianta.explore(world, perception="eyes")


class TestSearchOnTheMap:
    """A robot searches for a label on the map that it reads itself."""

    FLOOR = Floor(
        (Room(1, box(0, 0, 4, 4), "CLASSROOM"), Room(2, box(4, 0, 8, 4), "GYM"), Room(3, box(8, 0, 12, 4), "ROOM"))
    )

    @classmethod
    def find(cls, *labels: str | None, wanted: str = "GYM", true_floor: Floor | None = FLOOR) -> WantedRoom | None:
        """The room that is found on a map on which rooms of 3 × 4 m have these labels, all of them in sight."""
        perception = MapPerception(Mapper(), true_floor)
        rooms = tuple(
            Room(number, box(4 * number - 4, 0, 4 * number - 1, 4), label) for number, label in enumerate(labels, 1)
        )
        grid = GridMap(np.zeros((20, 60), int), 0.2)
        perception.mapper.state = MapState(grid, Floor(rooms), (), {}, None, None)
        world = two_room_world()
        record = Record(world, world.free, [Robot(Pose(1.0, 1.0), "point")], 8.0)
        perception._updated_at = 0.0
        assert perception.find_room(wanted, record) is None
        perception.perceive(grid, record)
        return perception.find_room(wanted, record)

    @pytest.mark.parametrize(
        ("labels", "number", "is_right"),
        [
            ((None, "GYM", None), 2, True),
            (("GYM", "GYM", None), 1, False),
            ((None, None, "GYM"), 3, None),
            ((None, "gym", None), 2, True),
            ((None, None, None, "GYM"), 4, False),
        ],
    )
    def test_the_first_room_with_the_label_is_compared_with_the_truth(self, labels, number, is_right):
        """The truth has a classroom, a gym, a room of which it says no more, and nothing beyond them."""
        room = self.find(*labels)
        assert room is not None
        assert (room.id, room.is_right) == (number, is_right)

    def test_a_coarse_label_is_compared_with_a_coarse_truth(self):
        room = self.find(None, None, "ROOM", wanted="ROOM")
        assert room is not None
        assert room.is_right is True

    def test_without_truth_it_is_unknown(self):
        room = self.find("GYM", true_floor=None)
        assert room is not None
        assert room.is_right is None

    def test_no_room_has_the_label(self):
        assert self.find("CLASSROOM", None, None) is None

    def test_a_room_is_found_from_a_probability_of_a_half_on(self):
        """Both rooms are called GYM, the first with less than a half, and a coarser set has no GYM."""
        mapper = Mapper()
        beliefs = [{"F/C/E/S": {"F": 0.9, "C": 0.1}, "school": {"GYM": share, "STAIRS": 1 - share}} for share in P_GYM]
        rooms = tuple(
            Room(number, box(4 * number - 4, 0, 4 * number - 1, 4), "GYM", label_probabilities=belief)
            for number, belief in enumerate(beliefs, 1)
        )
        assert [measure_label_probability(room, "GYM") for room in rooms] == [*P_GYM]
        assert [measure_label_probability(room, "F") for room in rooms] == [0.9, 0.9]
        perception = MapPerception(mapper, self.FLOOR)
        mapper.state = MapState(GridMap(np.zeros((20, 60), int), 0.2), Floor(rooms), (), {}, None, None)
        perception._recognised = recognise_read_rooms(mapper.floor, np.zeros((0, 2)))
        record = Record(world := two_room_world(), world.free, [Robot(Pose(1.0, 1.0), "point")], 8.0)
        assert perception.find_room("GYM", record) == WantedRoom(2, "GYM", is_right=True, probability=0.5)
        assert perception.find_room("STAIRS", record) is None

    def test_the_likeliest_room(self):
        rooms = tuple(
            Room(number, box(4 * number - 4, 0, 4 * number - 1, 4), label_probabilities={"school": {"GYM": share}})
            for number, share in enumerate((0.1, 0.3), 1)
        )
        assert choose_likeliest_room(Floor(rooms), "GYM") == (0.3, 2)
        assert choose_likeliest_room(Floor(rooms), "STAIRS")[0] == 0
        assert choose_likeliest_room(Floor(()), "GYM") == (0, None)

    def test_a_coarse_label_is_found_in_rooms_with_finer_ones(self):
        """The truth has a classroom, which is a room and functional; the map says so too."""
        mapper = Mapper()
        beliefs = {"R/C": {"ROOM": 0.9, "CORRIDOR": 0.1}, "F/C/E/S": {"FUNCTIONAL": 0.4, "SERVICE": 0.6}}
        labels = {"R/C": "ROOM", "F/C/E/S": "SERVICE"}
        room = Room(1, box(0, 0, 3, 4), "CLOSET", labels=labels, label_probabilities=beliefs)
        mapper.state = MapState(GridMap(np.zeros((20, 60), int), 0.2), Floor((room,)), (), {}, None, None)
        perception = MapPerception(mapper, replace(self.FLOOR, building_type={"school": 1.0}))
        perception._recognised = recognise_read_rooms(mapper.floor, np.zeros((0, 2)))
        record = Record(world := two_room_world(), world.free, [Robot(Pose(1.0, 1.0), "point")], 8.0)
        assert perception.find_room("ROOM", record) == WantedRoom(1, "ROOM", is_right=True, probability=0.9)
        assert perception.find_room("SERVICE", record) == WantedRoom(1, "SERVICE", is_right=False, probability=0.6)
        assert perception.find_room("FUNCTIONAL", record) is None
        assert perception._is_right(1, "FUNCTIONAL") is True

    def test_a_run_in_vain_names_the_likeliest_room(self):
        """The belief in STAIRS stays below a half in a floor of offices."""
        floor = pianta.make_world("corridor")[0]
        run = pianta.explore(floor, perception=Mapper(building_type="school"), find="stairs")
        assert run.outcome in {"done", "no reachable frontier"}
        assert run.found_room is not None
        assert run.found_probability is not None
        assert 0 < run.found_probability < 0.5

    def test_it_ends_when_the_map_has_the_label(self):
        floor = pianta.make_world("corridor")[0]
        mapper = Mapper(building_type="office")
        run = pianta.explore(floor, perception=mapper, find="office")
        assert (run.outcome, run.is_found_room_right) == ("found OFFICE", None)
        assert run.found_room is not None
        assert mapper.floor[run.found_room].label == "OFFICE"
        assert run.share[-1] < 0.5

    def test_a_map_without_true_rooms_is_searched(self):
        _, grid = pianta.make_world("corridor")
        world = replace(grid, cells=np.where(grid.cells < 0, 100, grid.cells))
        run = pianta.explore(world, perception="map", find="corridor")
        assert (run.outcome, run.is_found_room_right) == ("found CORRIDOR", None)

    def test_labels_that_the_mapper_never_gives_are_refused(self):
        grid = two_room_world().grid
        with pytest.raises(OptionError, match=r"never labelled BRIDGE, give one of .*CLASSROOM"):
            pianta.explore(grid, perception="map", find="bridge")
        with pytest.raises(OptionError, match="gives no room the label GYM, leave out labels=False"):
            pianta.explore(grid, perception=Mapper(labels=False), find="gym")
