"""Rooms that corrections confirm are read as in the previous map where that has not changed."""

from dataclasses import replace
from itertools import pairwise
from math import pi
from pathlib import Path

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, Polygon, box

from pianta.corrections.confirmed import list_confirmed
from pianta.corrections.correct import correct_all
from pianta.corrections.kinds import (
    ChangeDoor,
    DeleteDoor,
    DeleteRoom,
    DrawDoor,
    DrawRoom,
    LabelRoom,
    MarkOutside,
    MergeRooms,
    MoveDoor,
    NameRoom,
    NumberRoom,
    ScaleToArea,
    ScaleToLength,
    SetType,
    SplitRoom,
)
from pianta.floor import Door, Floor, Room
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout.frames import Motion
from pianta.reading._map_change import MapChange
from pianta.reading._restored_rooms import restore_rooms
from pianta.reading.saved_reading import SavedReading

# A building of 8 m x 4 m: rooms west and east of a wall at x = 4 that is 0.2 m thick.
RESOLUTION = 0.1
WEST, EAST, BUILDING = box(0, 0, 4, 4), box(4, 0, 8, 4), box(0, 0, 8, 4)
WALL = box(3.9, 0, 4.1, 4)
DOOR = Door((1, 2), LineString([(4, 1), (4, 2)]), 1.0)


def draw_map(*walls: Polygon, free: Polygon = BUILDING) -> GridMap:
    """A map with 1 m of unknown cells around the building, walls along its sides, and other walls."""
    x, y = np.meshgrid(np.arange(-1, 9, RESOLUTION) + 0.05, np.arange(5, -1, -RESOLUTION) - 0.05)
    cells = np.where(shapely.contains_xy(free, x, y), FREE, UNKNOWN)
    for wall in (BUILDING.boundary.buffer(0.15), *walls):
        cells[shapely.contains_xy(wall, x, y)] = OCCUPIED
    return GridMap(cells, RESOLUTION, (-1.0, -1.0, 0.0))


def floor_of(*outlines: Polygon, doors: tuple[Door, ...] = ()) -> Floor:
    return Floor(tuple(Room(number, outline) for number, outline in enumerate(outlines, start=1)), doors)


def restore(new: Floor, previous: Floor, grid: GridMap, old_grid: GridMap, *ids: int) -> list[Polygon]:
    """The outlines after the rooms of the previous floor with these ids were restored, from west to east."""
    change = MapChange(grid, old_grid, Motion())
    floor = restore_rooms(new, previous, [previous[room_id] for room_id in ids], change).floor
    return sorted((room.polygon for room in floor), key=lambda polygon: polygon.bounds)


def are_equal(outlines: list[Polygon], *expected: Polygon) -> bool:
    return len(outlines) == len(expected) and all(
        one.symmetric_difference(other).area < 0.01 for one, other in zip(outlines, expected, strict=True)
    )


class TestTwoNewRoomsInOneThatIsConfirmed:
    def test_are_one_where_no_map_has_a_wall(self):
        outlines = restore(floor_of(WEST, EAST), floor_of(BUILDING), draw_map(), draw_map(), 1)
        assert are_equal(outlines, BUILDING)

    def test_are_one_where_the_wall_was_there_before(self):
        outlines = restore(floor_of(WEST, EAST), floor_of(BUILDING), draw_map(WALL), draw_map(WALL), 1)
        assert are_equal(outlines, BUILDING)

    def test_stay_two_where_the_wall_is_new(self):
        outlines = restore(floor_of(WEST, EAST), floor_of(BUILDING), draw_map(WALL), draw_map(), 1)
        assert are_equal(outlines, WEST, EAST)

    def test_are_one_where_less_than_half_of_the_border_is_a_new_wall(self):
        short = box(3.9, 0, 4.1, 1.2)
        outlines = restore(floor_of(WEST, EAST), floor_of(BUILDING), draw_map(short), draw_map(), 1)
        assert are_equal(outlines, BUILDING)

    def test_stay_two_if_no_correction_confirms_the_room(self):
        outlines = restore(floor_of(WEST, EAST), floor_of(BUILDING), draw_map(), draw_map())
        assert are_equal(outlines, WEST, EAST)

    def test_have_no_door_between_them(self):
        new = floor_of(WEST, EAST, doors=(DOOR, Door((2, None), LineString([(8, 1), (8, 2)]), 1.0)))
        previous = floor_of(BUILDING)
        restored = restore_rooms(new, previous, [*previous], MapChange(draw_map(), draw_map(), Motion()))
        (room,) = restored.floor
        assert [door.rooms for door in restored.floor.doors] == [(room.id, None)]
        assert restored.count == 1


class TestANewRoomThatCoversTwo:
    previous = floor_of(WEST, EAST, doors=(DOOR,))

    def test_is_divided_along_the_confirmed_one(self):
        for room_id in (1, 2):
            outlines = restore(floor_of(BUILDING), self.previous, draw_map(WALL), draw_map(WALL), room_id)
            assert are_equal(outlines, WEST, EAST)

    def test_has_the_previous_door_again(self):
        change = MapChange(draw_map(WALL), draw_map(WALL), Motion())
        floor = restore_rooms(floor_of(BUILDING), self.previous, [self.previous[1]], change).floor
        (door,) = floor.doors
        assert {*door.rooms} == {room.id for room in floor}
        assert (door.line, door.kind) == (DOOR.line, DOOR.kind)

    def test_stays_one_if_the_wall_is_gone(self):
        outlines = restore(floor_of(BUILDING), self.previous, draw_map(), draw_map(WALL), 1)
        assert are_equal(outlines, BUILDING)

    def test_is_divided_where_no_map_has_a_wall(self):
        outlines = restore(floor_of(BUILDING), self.previous, draw_map(), draw_map(), 1)
        assert are_equal(outlines, WEST, EAST)


def test_a_room_that_has_grown_where_no_room_was_stays_as_it_is_read():
    outlines = restore(floor_of(BUILDING), floor_of(WEST), draw_map(), draw_map(free=WEST), 1)
    assert are_equal(outlines, BUILDING)


def test_a_room_whose_place_is_no_longer_free_stays_as_it_is_read():
    half = box(0, 0, 2, 4)
    outlines = restore(floor_of(half), floor_of(WEST), draw_map(free=half), draw_map(), 1)
    assert are_equal(outlines, half)


def test_a_room_that_grows_takes_nothing_from_confirmed_ones():
    previous = floor_of(box(0, 0, 3, 4), box(3, 0, 5, 4))
    outlines = restore(floor_of(BUILDING), previous, draw_map(), draw_map(free=box(0, 0, 5, 4)), 1, 2)
    assert are_equal(outlines, box(0, 0, 3, 4), box(3, 0, 8, 4))


def test_maps_without_walls_such_as_plans_change_nothing():
    plan = GridMap(np.full((60, 100), UNKNOWN), RESOLUTION, (-1.0, -1.0, 0.0))
    new, previous = floor_of(WEST, EAST), floor_of(BUILDING)
    for grids in ((plan, plan), (plan, draw_map()), (draw_map(), plan)):
        assert restore_rooms(new, previous, [*previous], MapChange(*grids, Motion())).floor is new


@given(st.lists(st.floats(0.5, 7.5), max_size=4), st.lists(st.floats(0.5, 7.5), max_size=4), st.sets(st.integers(1, 5)))
def test_rooms_never_overlap_and_cover_the_building(cuts, old_cuts, ids):
    new, previous = (cut_floor(each) for each in (cuts, old_cuts))
    outlines = restore(new, previous, draw_map(), draw_map(), *(ids & {room.id for room in previous}))
    assert sum(outline.area for outline in outlines) == pytest.approx(shapely.union_all(outlines).area, abs=1e-6)
    # Strips that are too narrow to be a room may be lost
    assert shapely.union_all(outlines).area >= BUILDING.area - 4 * 0.5 * 4
    assert all(outline.is_valid for outline in outlines)


def cut_floor(cuts: list[float]) -> Floor:
    edges = [0, *sorted(cuts), 8]
    return floor_of(*(box(west, 0, east, 4) for west, east in pairwise(edges) if east - west > 0.3))


@pytest.mark.parametrize(
    ("correction", "ids"),
    [
        (NameRoom((1, 1), "Bar"), [1]),
        (NumberRoom((7, 1), "204"), [2]),
        (LabelRoom((7, 1), "OFFICE"), [2]),
        (ScaleToArea((1, 1), 12), [1]),
        (DeleteRoom((1, 1)), [1]),
        (SplitRoom(((0, 2), (4, 2)), ((1, 1), (1, 3))), [1]),
        (MergeRooms(((1, 1), (7, 1))), [1, 2]),
        (DrawDoor(((4, 3), (4, 3.9))), [1, 2]),
        (MoveDoor((4, 1.5), ((4, 3), (4, 3.9))), [1, 2]),
        (DeleteDoor((4, 1.5)), [1, 2]),
        (ChangeDoor((4, 1.5), "opening"), [1, 2]),
        (DeleteDoor((90, 90)), []),
        (NameRoom((90, 90), "Bar"), []),
        (DrawRoom(((20, 0), (24, 0), (24, 3))), []),
        (MarkOutside(((0, 0), (2, 0), (2, 2))), []),
        (SetType("office"), []),
        (ScaleToLength(((0, 0), (4, 0)), 5), []),
    ],
)
def test_a_correction_confirms_the_rooms_that_it_is_about(correction, ids):
    assert [room.id for room in list_confirmed(floor_of(WEST, EAST, doors=(DOOR,)), [correction])] == ids


class TestSavedReading:
    def read(self, *outlines: Polygon) -> SavedReading:
        floor = floor_of(*outlines)
        return SavedReading(Path(), floor, floor, grid=draw_map())

    def test_a_later_map_is_corrected_in_its_frame(self):
        annexe = box(9, 0, 10, 3)
        saved = self.read(BUILDING, annexe).add(NameRoom((2, 2), "Hall"))
        turned = replace(draw_map(), origin=(1.0, -1.0, pi / 2))
        new = floor_of(*(shapely.affinity.rotate(each, 90, origin=(0, 0)) for each in (WEST, EAST, annexe)))
        carried = saved.carry_over(new, turned)
        assert carried.restored == 1
        corrected, _ = correct_all(carried.floor, carried.corrections)
        assert [room.name for room in corrected if room.polygon.area > 30] == ["Hall"]
        hall = next(room for room in corrected if room.name)
        assert are_equal([hall.polygon], box(-4, 0, 0, 8))

    def test_a_later_correction_has_priority(self):
        split = SplitRoom(((4, 0), (4, 4)), ((2, 2), (6, 2)))
        saved = self.read(BUILDING).add(NameRoom((2, 2), "Hall")).add(split)
        carried = saved.carry_over(floor_of(box(0, 0, 8, 1), box(0, 1, 8, 4)), draw_map())
        corrected, outcomes = correct_all(carried.floor, carried.corrections)
        assert are_equal(sorted((room.polygon for room in corrected), key=lambda each: each.bounds), WEST, EAST)
        assert all(outcome.problem is None for outcome in outcomes)

    def test_corrections_after_one_of_the_scale_confirm_rooms_in_its_metres(self):
        saved = self.read(WEST, EAST).add(ScaleToLength(((0, 0), (4, 0)), 8)).add(NameRoom((12, 4), "East"))
        assert saved.grid is not None
        assert saved.grid.resolution == 2 * RESOLUTION
        carried = saved.carry_over(floor_of(WEST, box(4, 0, 6, 4), box(6, 0, 8, 4)), draw_map())
        assert carried.restored == 1
        assert are_equal(sorted((room.polygon for room in carried.floor), key=lambda each: each.bounds), WEST, EAST)

    def test_a_correction_that_does_not_fit_confirms_nothing(self):
        saved = self.read(BUILDING).add(MarkOutside(tuple(BUILDING.exterior.coords)[:-1]))
        saved = saved.keep([*saved.corrections, NameRoom((2, 2), "Hall")])
        assert saved.outcomes[-1].problem
        assert saved.carry_over(floor_of(WEST, EAST), draw_map()).restored == 0

    def test_a_folder_of_an_older_pianta_without_a_map_is_read_as_it_is(self):
        saved = replace(self.read(BUILDING).add(NameRoom((2, 2), "Hall")), grid=None)
        carried = saved.carry_over(floor_of(WEST, EAST), draw_map())
        assert (carried.restored, len(carried.floor)) == (0, 2)

    def test_reading_the_same_map_again_and_again_gives_the_same_rooms(self):
        saved = self.read(BUILDING).add(NameRoom((2, 2), "Hall"))
        one = saved.carry_over(floor_of(WEST, EAST), draw_map())
        assert (one.restored, [room.id for room in one.floor]) == (1, [1])
        again = replace(saved, uncorrected=one.floor, floor=one.floor).carry_over(floor_of(WEST, EAST), draw_map())
        assert again.floor[1].polygon.equals(one.floor[1].polygon)
