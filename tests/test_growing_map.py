"""The readings of a map that grows: by a mapper where the options allow it, else each as a whole."""

from dataclasses import replace
from typing import Unpack

import numpy as np
import pytest
from shapely import box

import pianta
from pianta.errors import MapWarning
from pianta.mapping.events import Event, EventKind, describe_events
from pianta.reading._reader import Reader, ReadOptions
from pianta.reading.growing_map import GrowingMap


@pytest.fixture(scope="module")
def grids():
    """Two thirds, and all of the corridor world."""
    grid = pianta.make_world("corridor")[1]
    cells = np.full(grid.shape, -1)
    width = int(grid.shape[1] * 0.7)
    cells[:, :width] = grid.cells[:, :width]
    return replace(grid, cells=cells), grid


def make(**options: Unpack[ReadOptions]) -> GrowingMap:
    options["predict_partial"] = False
    return GrowingMap(Reader.make(**options))


class TestGrowingMap:
    def test_it_is_what_a_mapper_makes_of_the_maps(self, grids):
        growing, mapper = make(), pianta.Mapper(predict_partial=False)
        for grid in grids:
            floor = mapper.update(grid).floor
            reading = growing.read(grid, "map")
        assert reading.floor == floor
        ids, events = reading.messages
        assert "kept their ids" in ids
        assert "room complete" in events

    def test_rooms_keep_the_ids_of_an_earlier_run(self, grids):
        floor = make(labels=False).read(grids[0], "map").floor
        rooms = tuple(replace(room, id=room.id + 100) for room in floor)
        moved = replace(floor, rooms=rooms, doors=(), last_id=200)
        again = make(labels=False, previous=moved).read(grids[1], "map").floor
        assert {room.id for room in moved} < {room.id for room in again}

    def test_a_floor_of_another_building_is_a_warning(self, grids):
        growing = make(labels=False, previous=pianta.Floor((pianta.Room(1, box(500, 500, 501, 560)),)))
        with pytest.warns(MapWarning, match="map 'map' has no room in common with the floor of previous="):
            growing.read(grids[1], "map")

    @pytest.mark.parametrize(
        "options",
        [{"method": "thesis"}, {"labels": True, "label_unknown": True}],
        ids=["method", "label_unknown"],
    )
    def test_options_that_a_mapper_has_not(self, options):
        assert make(**options).mapper is None

    def test_what_people_have_named_needs_whole_readings(self, grids):
        floor = make(labels=False).read(grids[0], "map").floor
        first, *others = floor
        named = replace(floor, rooms=(replace(first, name="Archive"), *others))
        growing = make(labels=False, previous=named)
        assert growing.mapper is None
        assert growing.read(grids[1], "map").floor[first.id].name == "Archive"

    def test_a_map_without_rooms_changes_nothing(self, grids):
        growing = make(labels=False)
        before = growing.read(grids[1], "map").floor
        empty = replace(grids[1], cells=np.full(grids[1].shape, -1))
        with pytest.raises(pianta.errors.MapError, match="map 'map': "):
            growing.read(empty, "map")
        assert growing.read(grids[1], "map").floor == before


class TestDescribeEvents:
    def test_few_are_listed_and_many_are_counted(self):
        events = [Event(EventKind.COMPLETE_ROOM, (room,)) for room in range(1, 5)]
        events.append(Event(EventKind.NEW_TYPE, before=None, after="school"))
        assert describe_events(events) == "4 × room complete, type changed: unknown → school"
        assert describe_events(events[:2]) == "room complete 1, room complete 2"
