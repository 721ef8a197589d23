"""The mapper: a building that grows with the map of a robot."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from shapely import LineString, box

import pianta
from pianta import Door, Floor, GridMap, Mapper, Room
from pianta.building_types.growing_map_types import read_default_growing_map_type_model
from pianta.building_types.map_types import MapTypePrediction
from pianta.errors import MapError, MapWarning, OptionError
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.frontiers import is_partial_room
from pianta.mapping.beliefs import choose_announced, choose_type, measure_trust, update_belief, update_type
from pianta.mapping.changed_parts import (
    choose_windows,
    forget_cells,
    have_same_frame,
    list_cuts,
    list_windows,
    measure_wall_agreement,
    put_on_grid,
)
from pianta.mapping.events import Event, EventKind, list_events
from pianta.mapping.partial_shapes import let_wait, list_waiting
from pianta.worlds.floors import make_floor

SHUT = 100


@pytest.fixture(scope="module")
def grid():
    """A corridor with rooms on both sides, cells of 0.05 m."""
    return pianta.make_world("corridor")[1]


def reveal(grid: GridMap, share: float) -> GridMap:
    """The map of a robot that has seen the columns up to a share."""
    cells = grid.cells.copy()
    cells[:, round(share * grid.shape[1]) :] = -1
    return replace(grid, cells=cells)


@pytest.fixture(scope="module")
def run(grid):
    """A mapper over a map that grows in twelve steps, and all of its updates."""
    mapper = Mapper()
    return mapper, [mapper.update(reveal(grid, share)) for share in np.linspace(0.3, 1, 12)]


class TestBeliefs:
    def test_the_first_reading_with_full_trust_is_the_belief(self):
        belief = update_belief(None, {"a": 0.8, "b": 0.2}, {"a": 0.5, "b": 0.5}, 1.0)
        assert belief == {"a": 0.8, "b": 0.2}

    def test_a_reading_without_trust_is_the_prior(self):
        belief = update_belief(None, {"a": 0.9, "b": 0.1}, {"a": 0.3, "b": 0.7}, 0.0)
        assert belief == {"a": 0.3, "b": 0.7}

    def test_a_belief_moves_half_of_the_way_in_log_odds(self):
        # Odds of 4 and 1: their geometric mean is 2
        belief = update_belief({"a": 0.8, "b": 0.2}, {"a": 0.5, "b": 0.5}, {"a": 0.5, "b": 0.5}, 1.0)
        assert belief == pytest.approx({"a": 2 / 3, "b": 1 / 3}, abs=1e-4)

    def test_a_belief_over_other_answers_is_left_out(self):
        belief = update_belief({"c": 1.0}, {"a": 0.8, "b": 0.2}, {"a": 0.5, "b": 0.5}, 1.0)
        assert belief == {"a": 0.8, "b": 0.2}

    def test_what_is_announced_changes_only_once_another_answer_is_clearly_more_probable(self):
        assert choose_announced({"a": 0.47, "b": 0.53}, "a") == "a"
        assert choose_announced({"a": 0.44, "b": 0.56}, "a") == "b"
        assert choose_announced({"a": 0.47, "b": 0.53}, None) == "b"

    def test_a_type_that_was_announced_may_be_a_little_less_probable_than_a_new_one(self):
        belief = {"office": 0.5, "school": 0.3, "other": 0.2}
        assert choose_type(belief, None) is None
        assert choose_type(belief, "office") == "office"
        assert choose_type({"office": 0.6, "school": 0.3, "other": 0.1}, None) == "office"

    def test_all_rooms_count_for_the_type_also_partial_ones(self):
        class Model:
            def predict(self, floor: Floor, *, context: object) -> MapTypePrediction:
                return MapTypePrediction({"office": 0.1, "school": 0.8}, 0.1)

        rooms = tuple(Room(number, box(number, 0, number + 1, 1), partial=True) for number in (1, 2))
        belief = update_type(None, Floor(rooms), Model())  # type: ignore[arg-type]
        # Two rooms have a trust of 2/3: 0.8 ** (2/3) is four times 0.1 ** (2/3), as 8 ** (2/3) = 4
        assert belief == pytest.approx({"office": 1 / 6, "school": 4 / 6, "other": 1 / 6}, abs=1e-4)

    def test_parts_of_floors_have_the_type_of_the_model_of_growing_maps(self):
        floor = make_floor("corridor", seed=1)
        part = Floor(tuple(Room(room.id, room.polygon, partial=True) for room in floor))
        prediction = read_default_growing_map_type_model().predict(part)
        trust = len(part) / (len(part) + 1)
        weights = {**prediction.probabilities, "other": prediction.neither}
        total = sum(value**trust for value in weights.values())
        assert update_type(None, part) == pytest.approx(
            {name: value**trust / total for name, value in weights.items()}, abs=1e-3
        )

    def test_a_room_is_trusted_by_the_share_of_it_that_was_seen(self):
        room = Room(1, box(0, 0, 1, 3), partial=True, predicted=box(0, 0, 4, 3))
        assert measure_trust(room) == 0.25
        assert measure_trust(Room(1, box(0, 0, 1, 3))) == 1.0


class TestWindows:
    def test_a_window_has_the_changed_cells_with_a_margin(self):
        grid = GridMap(np.zeros((100, 200), np.int8), 0.1)
        changed = np.zeros(grid.shape, bool)
        changed[50:52, 60:70] = True
        assert list_windows(grid, changed, Floor((), ())) == [(40, 50, 62, 80)]

    def test_changes_far_apart_have_windows_of_their_own_and_near_ones_share_one(self):
        """Windows have 1 m around squares of 0.2 m."""
        grid = GridMap(np.zeros((100, 400), np.int8), 0.1)
        changed = np.zeros(grid.shape, bool)
        changed[50, [20, 60, 300]] = True
        assert list_windows(grid, changed, Floor((), ())) == [(40, 10, 62, 72), (40, 290, 62, 312)]

    def test_a_window_has_all_of_a_changed_room_unless_it_is_long(self):
        grid = GridMap(np.zeros((100, 400), np.int8), 0.1)
        changed = np.zeros(grid.shape, bool)
        changed[50, 100] = True
        # Rows count from the top, at y = 10 m
        rooms = (Room(1, box(9, 4, 12, 6)), Room(2, box(0, 2, 40, 4.5)))
        assert list_windows(grid, changed, Floor(rooms, ())) == [(30, 80, 70, 130)]

    @pytest.mark.parametrize(("depth", "window"), [(7.9, (344, 90, 366, 112)), (8.0, (300, 0, 400, 220))])
    def test_a_hall_is_inside_and_a_strip_of_its_length_is_not(self, depth, window):
        """A room of 20 m, from 1 m on; strips are narrower than 0.4 of their length."""
        grid = GridMap(np.zeros((400, 400), np.int8), 0.1)
        changed = np.zeros(grid.shape, bool)
        changed[355, 100] = True
        assert list_windows(grid, changed, Floor((Room(1, box(1, 1, 21, 1 + depth)),), ())) == [window]

    @pytest.mark.parametrize(("area", "window"), [(580.0, (120, 120, 280, 280)), (570.0, (190, 120, 245, 215))])
    def test_rooms_that_need_too_much_are_cut(self, area, window):
        """With 4 m around it, the window of a room of 14 m sees 24 × 24 m, 576 m²."""
        grid = GridMap(np.zeros((400, 400), np.int8), 0.1)
        changed = np.zeros(grid.shape, bool)
        changed[200, [200, 202]] = True
        floor = Floor((Room(1, box(13, 13, 27, 27)), Room(2, box(13, 16.5, 20.5, 19.5))), ())
        windows = list_windows(grid, changed, floor)
        assert choose_windows(grid, changed, floor, windows, area) == [window]

    def test_frames_are_the_same_if_their_cells_coincide(self):
        grid = GridMap(np.zeros((10, 10), np.int8), 0.1)
        assert have_same_frame(grid, GridMap(np.zeros((20, 30), np.int8), 0.1, (-0.5, 0.3, 0.0)))
        assert not have_same_frame(grid, replace(grid, origin=(0.05, 0.0, 0.0)))
        assert not have_same_frame(grid, replace(grid, resolution=0.2))
        assert not have_same_frame(grid, replace(grid, origin=(0.0, 0.0, 0.1)))

    def test_a_smaller_map_is_put_at_its_position_on_a_larger_one(self):
        small = GridMap(np.array([[0, 100]], np.int8), 1.0, (1.0, 1.0, 0.0))
        large = GridMap(np.full((3, 4), -1, np.int8), 1.0)
        assert put_on_grid(small, large).tolist() == [[-1, -1, -1, -1], [-1, 0, 100, -1], [-1, -1, -1, -1]]
        assert put_on_grid(large, small).tolist() == [[-1, -1]]


class TestPartsOfChanges:
    """Cells of 1 m, so that windows see 4 cells around them, and walls move by one cell at most."""

    @pytest.mark.parametrize(
        ("max_area", "chosen"),
        [
            (8 * 8 + 8 * 14, [(1, 1, 4, 4), (1, 19, 4, 25)]),
            (8 * 8 + 8 * 14 - 1, [(1, 19, 4, 25)]),
            (1, [(1, 19, 4, 25)]),
        ],
    )
    def test_most_changes_come_first_and_one_part_is_read_at_least(self, max_area, chosen):
        """With what is around them, the windows see 8 × 8 and 8 × 14 cells."""
        grid = GridMap(np.zeros((16, 32), np.int8), 1.0)
        changed = np.zeros(grid.shape, bool)
        changed[2, 2] = changed[2, 20:24] = True
        windows = list_windows(grid, changed, Floor((), ()))
        assert choose_windows(grid, changed, Floor((), ()), windows, max_area) == chosen

    def test_unknown_cells_cost_nothing(self):
        cells = np.full((16, 32), -1, np.int8)
        cells[2, 20:24] = 0
        changed = cells == 0
        changed[2, 2] = True
        grid = GridMap(cells, 1.0)
        windows = list_windows(grid, changed, Floor((), ()))
        assert choose_windows(grid, changed, Floor((), ()), windows, 4) == windows

    def test_squares_of_a_large_change_are_read_one_by_one(self):
        grid = GridMap(np.zeros((8, 80), np.int8), 1.0)
        changed = np.ones(grid.shape, bool)
        changed[:, 40] = False
        windows = list_windows(grid, changed, Floor((), ()))
        assert windows == [(0, 0, 8, 80)]
        # The first square sees 1 m and 4 m beyond its 8 m; the second one makes it longer by 8 m
        assert choose_windows(grid, changed, Floor((), ()), windows, 8 * (8 + 8 + 5)) == [(0, 0, 8, 17)]

    @pytest.mark.parametrize(("motion", "share"), [(0, 1.0), (1, 1.0), (2, 0.0)])
    def test_walls_that_move_by_a_metre_are_those_of_before(self, motion, share):
        before = np.zeros((16, 16), np.int8)
        before[5] = 100
        assert measure_wall_agreement(np.roll(before, motion, axis=0), before, 1.0) == pytest.approx(share)

    def test_walls_that_are_not_on_the_map_do_not_count(self):
        before = np.zeros((16, 16), np.int8)
        before[5] = 100
        cells = before.copy()
        cells[:, :8] = -1
        assert measure_wall_agreement(cells, before, 1.0) == pytest.approx(1.0)
        assert measure_wall_agreement(np.full_like(before, -1), before, 1.0) == 0.0


class TestCuts:
    """Rooms that touch at the edge of a window, x = 5 m, cells of 0.1 m."""

    GRID = GridMap(np.zeros((20, 100), np.int8), 0.1)
    PARTS = Floor((Room(1, box(0, 0, 5, 2)), Room(2, box(5, 0, 10, 2))))

    def test_a_border_without_wall_or_door_may_cut_a_room(self):
        cuts = list_cuts(self.PARTS, self.GRID, [(0, 0, 20, 50)], without=())
        assert [*cuts] == [(1, 2)]
        assert abs(cuts[1, 2][:, 0] - 5).max() <= 0.151
        assert list_cuts(self.PARTS, self.GRID, [(0, 0, 20, 50)], without={(1, 2)}) == {}
        # Cells there count as changed: they are unknown
        assert (forget_cells(self.GRID, cuts[1, 2]).cells == -1).any()

    def test_a_wall_a_door_and_borders_elsewhere_do_not(self):
        cells = self.GRID.cells.copy()
        cells[:, 49:51] = 100
        assert list_cuts(self.PARTS, replace(self.GRID, cells=cells), [(0, 0, 20, 50)], without=()) == {}
        door = Door((1, 2), LineString([(5, 0.5), (5, 1.5)]), 1.0)
        assert list_cuts(replace(self.PARTS, doors=(door,)), self.GRID, [(0, 0, 20, 50)], without=()) == {}
        # The edges of this window are more than 4 m away
        assert list_cuts(self.PARTS, self.GRID, [(0, -300, 20, -200)], without=()) == {}


class TestPartialOutlines:
    """Rooms of 10 × 4 m, cells of 0.1 m, with walls of one cell."""

    def make(self, *, end: int) -> GridMap:
        """A room between walls that ends, at a column, at unknown cells."""
        cells = np.full((60, 140), -1, np.int8)
        cells[10:50, 20:120] = 0
        cells[[9, 50], 19:121] = cells[9:51, 19] = cells[9:51, 120] = 100
        cells[:, end:] = -1
        return GridMap(cells, 0.1)

    @pytest.mark.parametrize(("end", "is_partial"), [(140, False), (100, True)])
    def test_a_room_that_ends_at_unknown_space_is_partial(self, end, is_partial):
        outline = box(2, 1, min(end / 10, 12), 5)
        assert is_partial_room(outline, self.make(end=end), StructureParameters()) is is_partial

    def test_a_room_without_free_cells_is_not_partial(self):
        assert not is_partial_room(box(2, 1, 12, 5), self.make(end=0), StructureParameters())


class TestEvents:
    ROOM = Room(1, box(0, 0, 4, 4), "OFFICE", partial=True)

    def test_a_room_is_found_and_complete(self):
        events = list_events(Floor((self.ROOM, Room(2, box(5, 0, 8, 4))), ()), Floor((self.ROOM,), ()))
        assert events == [Event(EventKind.NEW_ROOM, (2,)), Event(EventKind.COMPLETE_ROOM, (2,))]

    def test_a_label_and_a_type_change(self):
        other = Floor((replace(self.ROOM, label="LAB"),), (), building_type={"school": 0.9})
        events = list_events(other, Floor((self.ROOM,), (), building_type={"office": 0.6, "school": 0.4}))
        assert [*map(str, events)] == ["type changed: office → school", "label changed 1: OFFICE → LAB"]

    def test_rooms_are_joined_and_divided(self):
        halves = Floor((Room(1, box(0, 0, 4, 4)), Room(2, box(4, 0, 7, 4))), ())
        both = Floor((Room(1, box(0, 0, 7, 4)),), ())
        assert list_events(both, halves) == [Event(EventKind.JOINED_ROOMS, (1, 2))]
        events = list_events(halves, both)
        assert events[0] == Event(EventKind.DIVIDED_ROOM, (1, 2))

    def test_a_room_is_gone(self):
        assert list_events(Floor((), ()), Floor((self.ROOM,), ())) == [Event(EventKind.LOST_ROOM, (1,))]


class TestUpdates:
    def test_the_last_floor_is_that_of_a_reading_of_the_last_map(self, grid, run):
        mapper, _ = run
        scores = pianta.score_floor(mapper.floor, pianta.reconstruct(grid))
        assert (scores.rooms.f1, scores.doors.f1) == (1.0, 1.0)

    def test_rooms_keep_their_ids(self, run):
        _, updates = run
        ids = [{room.id for room in update.floor} for update in updates]
        assert all(before <= after for before, after in pairwise(ids))
        assert ids[-1] == {*range(1, 20)}

    def test_less_than_the_map_is_read_again(self, run):
        _, updates = run
        assert all(0 < update.read_share < 0.5 for update in updates[5:])

    def test_every_room_is_found_once_and_complete_at_the_end(self, run):
        mapper, updates = run
        events = [event for update in updates for event in update.events]
        new = [event.rooms[0] for event in events if event.kind is EventKind.NEW_ROOM]
        assert sorted(new) == [*range(1, 20)]
        assert {event.rooms[0] for event in events if event.kind is EventKind.COMPLETE_ROOM} >= {
            room.id for room in mapper.floor if not room.partial
        }

    def test_labels_of_the_last_map_are_those_of_a_reading(self, grid, run):
        mapper, _ = run
        read = pianta.label_rooms(pianta.reconstruct(grid))
        labels = {room.polygon.centroid.wkt: room.labels["R/C"] for room in read}
        corridors = [room.polygon for room in read if room.labels["R/C"] == "CORRIDOR"]
        assert labels
        assert [room.labels["R/C"] for room in mapper.floor if corridors[0].intersects(room.polygon.centroid)] == [
            "CORRIDOR"
        ]

    def test_the_same_map_again_changes_nothing(self, grid, run):
        mapper, updates = run
        update = mapper.update(grid)
        assert (update.events, update.read_share) == ((), 0.0)
        assert update.floor == updates[-1].floor

    def test_a_map_that_is_older_is_left_out(self, grid):
        mapper = Mapper()
        mapper.update(reveal(grid, 0.6), time=5.0)
        with pytest.warns(MapWarning, match=r"a map of 4 s came after one of 5 s and is left out; send maps in their"):
            update = mapper.update(grid, time=4.0)
        assert update.events == ()
        assert mapper.update(grid).events
        with pytest.warns(MapWarning, match=r"a map of 4 s came after one of 5 s and is left out; send maps in their"):
            mapper.update(reveal(grid, 0.6), time=4.0)
        assert len(mapper.floor) == 19

    @pytest.mark.parametrize("time", [float("nan"), float("inf"), "12"])
    def test_a_time_is_a_number(self, grid, time):
        mapper = Mapper()
        with pytest.raises(OptionError, match=r"^time"):
            mapper.update(grid, time=time)
        assert mapper.state is None

    def test_a_map_without_rooms_leaves_the_mapper_as_it_was(self, grid, run):
        mapper, _ = run
        before = mapper.state
        with pytest.raises(MapError, match="no free cell"):
            mapper.update(replace(grid, cells=np.full((50, 50), 100, np.int8)))
        assert mapper.state is before


class TestShapesThatWait:
    def test_an_update_predicts_few_shapes_and_the_next_ones_the_others(self, grid, tmp_path, monkeypatch):
        # One shape after the whole map has been read, and after nothing
        for name in ("MAX_COST", "SHAPE_COST", "MAX_SHAPE_COST"):
            monkeypatch.setattr(f"pianta.mapping.partial_shapes.{name}", 100.0)
        mapper = Mapper(labels=False)
        mapper.update(reveal(grid, 0.5))
        observed = reveal(grid, 0.55)
        mapper.update(observed)
        assert mapper.state is not None
        waiting = mapper.state.waiting
        assert len(waiting) == sum(room.partial for room in mapper.floor) - 1 > 0
        mapper.save(tmp_path)
        mapper = Mapper.load(tmp_path, labels=False)
        for _ in waiting:
            mapper.update(observed)
        assert mapper.state is not None
        assert mapper.state.waiting == ()
        assert all(room.predicted for room in mapper.floor if room.partial)

    def test_an_update_that_reads_the_whole_map_predicts_one_shape(self, grid, monkeypatch):
        mapper = Mapper(labels=False)
        mapper.update(reveal(grid, 0.5))
        before = {room.id: room.predicted for room in mapper.floor if room.predicted}
        monkeypatch.setattr("pianta.mapping.mapper.MAX_READ_SHARE", 0.0)
        for name in ("SHAPE_COST", "MAX_SHAPE_COST"):
            monkeypatch.setattr(f"pianta.mapping.partial_shapes.{name}", 100.0)
        update = mapper.update(reveal(grid, 0.52))
        assert update.read_share == 1.0
        assert mapper.state is not None
        partial = [room for room in update.floor if room.partial]
        assert len(mapper.state.waiting) == len(partial) - 1 > 0
        # Those that wait keep their shapes
        assert any(room.predicted for room in partial if room.id in before.keys() & {*mapper.state.waiting})

    def test_long_rooms_and_large_readings_leave_less_for_other_shapes(self):
        """A shape counts as 80 m², and 10 m² for each metre of its room, 400 m² at most."""
        rooms = [
            Room(number, box(0, 0, length, 3), partial=True) for number, length in enumerate((40, 10, 60, 4), start=1)
        ]
        assert list_waiting(rooms, 700.0) == [3]
        assert list_waiting(rooms, 580.0) == [3, 4]
        assert list_waiting(rooms, 300.0) == [1, 3]
        assert list_waiting(rooms, -50.0) == [1, 2, 3, 4]

    def test_a_shape_that_waits_overlaps_no_other_room(self):
        before = Room(1, box(0, 0, 4, 4), partial=True, predicted=box(0, 0, 8, 4), confidence=0.5)
        room, other = (
            replace(before, polygon=box(0, 0, 5, 4), predicted=None, confidence=None),
            Room(2, box(7, 0, 9, 4)),
        )
        longer = let_wait(room, before, Floor((room,)))
        assert longer.predicted is not None
        assert longer.predicted.equals(box(0, 0, 8, 4))
        assert let_wait(room, before, Floor((room, other))).predicted is None
        assert let_wait(room, None, Floor((room,))) == room


class TestLimitedUpdates:
    """An update reads a limited area; the rest waits."""

    def test_what_waits_is_read_by_the_next_updates_with_the_same_map(self, grid):
        mapper = Mapper(labels=False, predict_partial=False, max_read_area=100.0)
        mapper.update(reveal(grid, 0.3))
        updates = [mapper.update(grid)]
        while updates[-1].waiting_share:
            updates.append(mapper.update(grid))
        waiting = [update.waiting_share for update in updates]
        assert len(updates) > 2
        assert all(after < before for before, after in pairwise(waiting))
        assert all(0 < update.read_share < 0.6 for update in updates)
        scores = pianta.score_floor(mapper.floor, pianta.reconstruct(grid))
        assert (scores.rooms.f1, scores.doors.f1) == (1.0, 1.0)
        assert mapper.update(grid).read_share == 0.0

    def test_a_loop_closure_is_read_in_parts_and_ids_stay(self, grid):
        mapper = Mapper(labels=False, predict_partial=False, max_read_area=100.0)
        before = {room.id for room in mapper.update(grid).floor}
        # The whole map moves up by half a metre, in the same frame
        moved = replace(grid, cells=np.roll(grid.cells, -round(0.5 / grid.resolution), axis=0))
        update = mapper.update(moved)
        assert 0 < update.read_share < 0.5
        while update.waiting_share:
            update = mapper.update(moved)
        assert {room.id for room in update.floor} == before
        assert pianta.score_floor(update.floor, pianta.reconstruct(moved)).rooms.f1 == 1.0

    def test_the_end_of_a_run_reads_all_that_waits(self, grid, tmp_path):
        mapper = Mapper(labels=False, max_read_area=100.0)
        with pytest.raises(MapError, match="there was no map yet; call update first"):
            mapper.finish()
        mapper.update(reveal(grid, 0.3))
        assert mapper.update(grid).waiting_share > 0
        mapper.save(tmp_path)
        loaded = Mapper.load(tmp_path, labels=False, max_read_area=100.0)
        assert loaded.finish().waiting_share == 0
        # The source of a map that was saved is its file
        assert mapper.finish().floor == replace(loaded.floor, source=grid.source)
        assert (len(loaded.floor), loaded.max_read_area) == (19, 100.0)
        loaded.save(tmp_path)
        assert not (tmp_path / "as_read.npz").exists()

    def test_without_a_limit_nothing_waits(self, grid):
        mapper = Mapper(labels=False, predict_partial=False, max_read_area=None)
        mapper.update(reveal(grid, 0.3))
        update = mapper.update(grid)
        assert (update.read_share, update.waiting_share) == (1.0, 0.0)

    @pytest.mark.parametrize("area", [0.0, -1.0, float("nan")])
    def test_a_limit_is_above_0(self, area):
        with pytest.raises(OptionError, match=r"max_read_area is .* m², give an area above 0, or None for no limit"):
            Mapper(max_read_area=area)

    def test_a_saved_map_of_another_size_is_one_line(self, grid, tmp_path):
        mapper = Mapper(labels=False, predict_partial=False, max_read_area=100.0)
        mapper.update(reveal(grid, 0.3))
        mapper.update(grid)
        mapper.save(tmp_path)
        GridMap(np.zeros((5, 6), np.int8), 0.05).save(tmp_path / "as_read.npz")
        with pytest.raises(MapError, match=r"map\.npz and as_read\.npz have \d+ × \d+ and 5 × 6 cells"):
            Mapper.load(tmp_path)


class TestPatches:
    def test_a_patch_is_as_good_as_the_map(self, grid):
        by_map, by_patch = Mapper(), Mapper()
        for mapper in (by_map, by_patch):
            mapper.update(reveal(grid, 0.5))
        column = grid.shape[1] // 3
        x, y = grid.pixel_to_map(grid.shape[0], column)
        patch = GridMap(grid.cells[:, column:], grid.resolution, (float(x), float(y), 0.0))
        assert by_patch.update_patch(patch).floor == by_map.update(grid).floor

    def test_a_patch_outside_of_the_map_is_refused(self, grid):
        mapper = Mapper()
        with pytest.raises(MapError, match="a patch came before the first map"):
            mapper.update_patch(grid)
        mapper.update(grid)
        with pytest.raises(
            MapError, match=r"the patch, 2 × 3 cells from row -?\d+, column \d+, is not inside the map of"
        ):
            mapper.update_patch(GridMap(np.zeros((2, 3), np.int8), grid.resolution, (500.0, 0.0, 0.0)))
        other = (
            r"the patch has cells of 0\.05 m from 0\.02, 0, 0 \(x, y, yaw\), give cells of the map, of 0\.05 m from "
        )
        with pytest.raises(MapError, match=other):
            mapper.update_patch(GridMap(np.zeros((2, 3), np.int8), grid.resolution, (0.02, 0.0, 0.0)))


class TestBadMaps:
    def test_another_building_is_a_new_one_and_no_id_is_used_again(self, grid):
        mapper = Mapper()
        last = mapper.update(grid).floor.last_id
        update = mapper.update(pianta.make_world("hall", seed=5)[1])
        assert update.events[0] == Event(EventKind.NEW_BUILDING)
        assert min(room.id for room in update.floor) == last + 1

    def test_a_loop_closure_moves_rooms_and_ids_stay(self, grid):
        mapper = Mapper()
        before = mapper.update(grid).floor
        # The right half moves up by half a metre
        cells, half, step = grid.cells.copy(), grid.shape[1] // 2, round(0.5 / grid.resolution)
        cells[:, half:] = np.roll(cells[:, half:], -step, axis=0)
        after = mapper.update(replace(grid, cells=cells)).floor
        common = {room.id for room in after} & {room.id for room in before}
        assert len(common) >= len(before) - 2

    def test_a_frame_that_moves_keeps_ids(self, grid):
        mapper = Mapper()
        before = mapper.update(grid).floor
        moved = mapper.update(replace(grid, origin=(grid.origin[0] + 0.53, grid.origin[1] - 0.31, 0.0))).floor
        assert [room.id for room in moved] == [room.id for room in before]

    def test_a_map_that_shrinks_keeps_the_ids_of_what_is_left(self, grid):
        mapper = Mapper()
        before = {room.id: room.polygon.centroid for room in mapper.update(grid).floor}
        after = mapper.update(reveal(grid, 0.7)).floor
        complete = [room for room in after if not room.partial]
        assert len(complete) > 5
        assert all(room.polygon.intersects(before[room.id]) for room in complete)

    def test_a_door_that_is_shut_and_opened_keeps_ids(self, grid):
        mapper = Mapper()
        floor = mapper.update(grid).floor
        door: Door = next(door for door in floor.doors if door.kind == "door" and door.joins_rooms)
        x, y = door.line.interpolate(0.5, normalized=True).coords[0]
        row, col = (int(each) for each in grid.map_to_pixel(x, y))
        reach = round(0.6 / grid.resolution)
        cells = grid.cells.copy()
        window = cells[row - reach : row + reach, col - reach : col + reach]
        middle = slice(reach - 2, reach + 3)
        (window[middle] if door.line.bounds[3] - door.line.bounds[1] < 0.3 else window[:, middle])[:] = SHUT
        shut = mapper.update(replace(grid, cells=cells)).floor
        opened = mapper.update(grid).floor
        ids = {room.id for room in floor}
        assert {room.id for room in shut} == ids
        assert {room.id for room in opened} == ids
        assert door.rooms not in [each.rooms for each in shut.doors]
        assert door.rooms in [each.rooms for each in opened.doors]


class TestSavedStates:
    def test_a_loaded_mapper_goes_on_as_the_saved_one(self, grid, tmp_path):
        mapper = Mapper()
        for share in (0.5, 0.6, 0.7):
            mapper.update(reveal(grid, share), time=share)
        mapper.save(tmp_path / "state")
        loaded = Mapper.load(tmp_path / "state")
        assert loaded.floor == mapper.floor
        one, other = mapper.update(grid), loaded.update(grid)
        assert (one.floor, one.events, dict(one.types)) == (other.floor, other.events, dict(other.types))

    def test_nothing_can_be_saved_before_the_first_map(self, tmp_path):
        with pytest.raises(MapError, match="there was no map yet; call update first"):
            Mapper().save(tmp_path / "state")
        assert not (tmp_path / "state").exists()

    @pytest.mark.parametrize("tried", ["[[1]]", "[[1, 2, 3]]", '["12"]'])
    def test_ids_of_tried_borders_are_pairs(self, grid, tmp_path, tried):
        mapper = Mapper(labels=False, predict_partial=False)
        mapper.update(reveal(grid, 0.4))
        mapper.save(tmp_path)
        file = tmp_path / "mapper.json"
        file.write_text(file.read_text().replace('"tried": []', f'"tried": {tried}'))
        with pytest.raises(MapError, match="tried"):
            Mapper.load(tmp_path)

    @pytest.mark.parametrize("content", ["", "{}", '{"format": "pianta mapper", "version": "1.0", "types": {"a": 2}}'])
    def test_a_damaged_state_is_one_line(self, grid, tmp_path, content):
        mapper = Mapper(building_type="School")
        mapper.update(reveal(grid, 0.4))
        mapper.save(tmp_path)
        (tmp_path / "mapper.json").write_text(content)
        with pytest.raises(MapError) as caught:
            Mapper.load(tmp_path)
        assert "\n" not in str(caught.value)
