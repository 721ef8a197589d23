"""What robots take for rooms: the true ones, or those that a mapper reads from their map."""

from dataclasses import replace

import numpy as np
import pytest
from shapely import LineString, box

import pianta
from pianta import Door, Floor, Mapper, Room
from pianta.errors import OptionError
from pianta.exploration.map_perception import MapPerception, recognise_read_rooms
from pianta.exploration.perception import PerfectPerception
from pianta.exploration.perceptions import make_perception
from tests.explored_worlds import two_room_world


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
