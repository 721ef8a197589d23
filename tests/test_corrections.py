import json
from dataclasses import replace
from math import cos, pi, sin

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, box

from pianta.corrections.by_id import label_by_id, merge_by_id, outline_of, position_of, split_by_id
from pianta.corrections.correct import correct, correct_all, invert
from pianta.corrections.corrections_file import parse_corrections, read_corrections, save_corrections
from pianta.corrections.kinds import (
    KINDS,
    ChangeDoor,
    Correction,
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
    move_correction,
)
from pianta.errors import CorrectionError
from pianta.floor import Door, Floor, Room
from pianta.worlds.floors import make_floor

# Two rooms of 4 m x 3 m with a wall of 0.2 m between them, north of a corridor; the second has an entrance.
WEST, EAST, CORRIDOR = box(0, 2, 4, 5), box(4.2, 2, 8.2, 5), box(0, 0, 8.2, 1.8)
DOORS = (
    Door((1, 3), LineString([(1, 1.9), (2, 1.9)]), 1.0),
    Door((2, 3), LineString([(6, 1.9), (7, 1.9)]), 1.0),
    Door((2, None), LineString([(8.3, 3), (8.3, 4)]), 1.0),
)
FLOOR = Floor(
    (Room(1, WEST, "OFFICE"), Room(2, EAST, "KITCHEN", name="Bar"), Room(3, CORRIDOR, "CORRIDOR")), DOORS, last_id=7
)


def ids_of(floor: Floor) -> list[int]:
    return [room.id for room in floor]


def rooms_of_doors(floor: Floor) -> list[tuple[int, int | None]]:
    return [door.rooms for door in floor.doors]


class TestRooms:
    def test_merged_rooms_have_the_wall_between_them_and_the_oldest_id(self):
        merged = FLOOR.merge(2, 1)
        assert merged[1].polygon.equals(box(0, 2, 8.2, 5))
        assert (ids_of(merged), rooms_of_doors(merged)) == ([1, 3], [(1, 3), (1, 3), (1, None)])
        assert (merged[1].name, merged.last_id) == ("Bar", 7)

    def test_a_door_between_merged_rooms_is_gone(self):
        merged = FLOOR.merge(1, 3)
        assert (ids_of(merged), rooms_of_doors(merged)) == ([1, 2], [(1, 2), (2, None)])
        assert merged[1].polygon.area == pytest.approx(12 + 8.2 * 1.8 + 4 * 0.2)
        assert merged[1].label == "CORRIDOR"

    def test_merged_rooms_do_not_grow_into_others(self):
        row = Floor(tuple(Room(number, box(x, 0, x + 2, 2)) for number, x in enumerate((0, 2.1, 4.2), start=1)))
        assert row.merge(1, 2)[1].polygon.equals(box(0, 0, 4.1, 2))

    def test_rooms_that_are_far_apart_are_not_merged(self):
        far = replace(FLOOR, rooms=(*FLOOR.rooms, Room(5, box(20, 0, 24, 3))))
        with pytest.raises(CorrectionError, match=r"rooms 1 and 5 are 16\.0 m apart"):
            far.merge(1, 5)

    def test_rooms_with_another_one_between_them_are_not_merged(self):
        shapes = (box(0, 0, 3, 3), box(3.8, 0, 6.8, 3), box(3.1, -1, 3.7, 4))
        row = Floor(tuple(Room(number, shape) for number, shape in enumerate(shapes, start=1)))
        with pytest.raises(CorrectionError, match="another room divides rooms 1 and 2, merge it with them"):
            row.merge(1, 2)
        assert row.merge(1, 2, 3)[1].polygon.area == pytest.approx(9 + 9 + 3 + 0.2 * 3)

    def test_the_largest_part_of_a_split_room_keeps_its_id_and_an_opening_joins_both(self):
        split = FLOOR.split(2, [(5.2, 2), (5.2, 5)])
        assert (split[2].polygon.area, split[8].polygon.area, split.last_id) == (pytest.approx(9), pytest.approx(3), 8)
        assert (split[2].name, split[8].name) == ("Bar", None)
        assert split.doors[-1] == Door((2, 8), LineString([(5.2, 2), (5.2, 5)]), 3.0, "opening")
        assert rooms_of_doors(split)[:3] == [(1, 3), (2, 3), (2, None)]

    def test_doors_go_to_the_part_that_they_are_at(self):
        split = FLOOR.split(3, [(5, 0), (5, 1.8)])
        assert [room.polygon.area for room in (split[3], split[8])] == pytest.approx([9, 5.76])
        assert rooms_of_doors(split)[:2] == [(1, 3), (2, 8)]

    def test_a_line_that_ends_before_the_wall_is_extended(self):
        assert FLOOR.split(1, [(2, 2.5), (2, 4.5)])[1].polygon.equals(FLOOR.split(1, [(2, 2), (2, 5)])[1].polygon)

    def test_a_line_whose_ends_are_on_the_outline_but_for_rounding_divides_the_room(self):
        slanted = Floor((Room(1, box(38.25, 12.7, 44.05, 18.2)),))
        line = [(42.480722398340426, 12.7), (42.43643647847782, 18.2)]
        assert len(slanted.split(1, line)) == 2

    def test_a_point_of_a_line_may_be_repeated(self):
        line = [(2, 2.5), (2, 2.5), (2, 4.5), (2, 4.5)]
        assert FLOOR.split(1, line)[1].polygon.equals(FLOOR.split(1, [(2, 2), (2, 5)])[1].polygon)

    def test_a_line_that_divides_nothing_is_refused(self):
        with pytest.raises(CorrectionError, match="does not divide room 1, draw it from wall to wall"):
            FLOOR.split(1, [(1, 3), (3, 3)])

    def test_a_drawn_room_leaves_the_others_as_they_are(self):
        more = FLOOR.draw_room([(8, 2), (12, 2), (12, 5), (8, 5)])
        assert more[8].polygon.equals(box(8.2, 2, 12, 5))
        assert rooms_of_doors(more)[2] == (2, 8)

    def test_a_room_cannot_be_drawn_in_another(self):
        with pytest.raises(CorrectionError, match="other rooms are where the room"):
            FLOOR.draw_room([(0, 2), (3, 2), (3, 4), (0, 4)])

    def test_a_deleted_room_has_no_doors_and_its_id_is_not_used_again(self):
        less = FLOOR.delete_room(3)
        assert (ids_of(less), rooms_of_doors(less), less.last_id) == ([1, 2], [(2, None)], 7)

    def test_doors_to_what_is_outside_are_entrances(self):
        outside = FLOOR.mark_outside(3)
        assert (ids_of(outside), rooms_of_doors(outside)) == ([1, 2], [(1, None), (2, None), (2, None)])

    def test_a_room_that_is_outside_in_part_loses_that_part(self):
        cut = FLOOR.mark_outside([(2, -1), (9, -1), (9, 1.9), (2, 1.9)])
        assert cut[3].polygon.equals(box(0, 0, 2, 1.8))

    def test_a_name_and_a_label_are_set_and_taken_away(self):
        named = FLOOR.rename(1, "204").relabel(1, "kitchen")
        assert (named[1].name, named[1].label, named[1].label_probabilities) == ("204", "KITCHEN", {})
        assert named.rename(1, None)[1].name is None

    def test_a_number_is_apart_from_the_name(self):
        numbered = FLOOR.rename(1, "French").renumber(1, "204")
        assert (numbered[1].number, numbered[1].name, numbered[1].title) == ("204", "French", "204 French")
        assert numbered.renumber(1, None)[1].title == "French"
        assert numbered.renumber(1, "204") is numbered
        with pytest.raises(CorrectionError, match="number"):
            FLOOR.renumber(1, "2\n04")

    def test_a_label_of_no_schema_is_refused_with_similar_ones(self):
        with pytest.raises(CorrectionError, match="'KITCHN' is in no schema, give one such as KITCHEN"):
            FLOOR.relabel(1, "kitchn")

    def test_an_id_that_does_not_exist_is_refused(self):
        with pytest.raises(CorrectionError, match=r"there is no room 9, the ids of the floor are 1 … 3"):
            FLOOR.rename(9, "x")


class TestDoors:
    def test_a_door_joins_the_rooms_on_both_sides(self):
        more = FLOOR.draw_door([(4.1, 3), (4.1, 4)])
        assert more.doors[-1] == Door((1, 2), LineString([(4.1, 3), (4.1, 4)]), 1.0, "door", 1.0)

    def test_a_door_to_the_outside_is_an_entrance(self):
        assert FLOOR.draw_door([(-0.1, 3), (-0.1, 4)], door_kind="opening").doors[-1].rooms == (1, None)

    def test_a_door_in_a_room_is_refused(self):
        with pytest.raises(CorrectionError, match="room 1 is on both sides"):
            FLOOR.draw_door([(2, 3), (2, 4)])
        with pytest.raises(CorrectionError, match="no room is beside the door"):
            FLOOR.draw_door([(20, 3), (20, 4)])

    @pytest.mark.filterwarnings("error")
    def test_a_door_that_ends_where_it_starts_is_refused(self):
        with pytest.raises(CorrectionError, match="ends where it starts, draw it from jamb to jamb"):
            FLOOR.draw_door([(4.1, 3), (4.1, 4), (4.1, 3)])
        with pytest.raises(CorrectionError, match="ends where it starts, draw it from jamb to jamb"):
            FLOOR.move_door((1.5, 1.9), [(4.1, 3), (4.1, 4), (4.1, 3)])

    def test_a_possible_door_is_gone_where_a_door_is_drawn(self):
        shut = replace(FLOOR, doors=FLOOR.doors[1:], possible_doors=FLOOR.doors[:1])
        more = shut.draw_door([(1, 1.9), (2, 1.9)])
        assert (len(more.doors), more.possible_doors) == (3, ())

    def test_a_door_is_moved_deleted_and_turned_into_an_opening(self):
        moved = FLOOR.move_door((1.5, 1.9), [(4.1, 3), (4.1, 4)])
        assert sorted(rooms_of_doors(moved), key=str) == [(1, 2), (2, 3), (2, None)]
        assert rooms_of_doors(FLOOR.delete_door((1.5, 2.2))) == [(2, 3), (2, None)]
        assert correct(FLOOR, ChangeDoor((1.5, 1.9), "opening")).doors[0].kind == "opening"

    def test_a_place_without_a_door_is_refused(self):
        with pytest.raises(CorrectionError, match=r"no door is within 0\.9 m of \(4\.00, 4\.50\)"):
            FLOOR.delete_door((4, 4.5))


class TestScale:
    def test_a_line_has_its_length(self):
        scaled = correct(FLOOR, ScaleToLength(((0, 2), (4, 2)), 6.0))
        assert scaled[1].polygon.equals(box(0, 3, 6, 7.5))

    def test_a_room_has_its_area(self):
        assert correct(FLOOR, ScaleToArea((2, 3), 48.0))[1].polygon.area == pytest.approx(48)

    @pytest.mark.parametrize("area", [0.0, -1.0, float("nan"), float("inf")])
    def test_a_size_is_positive(self, area):
        with pytest.raises(CorrectionError, match="is no size, give a positive number"):
            correct(FLOOR, ScaleToArea((2, 3), area))

    @pytest.mark.parametrize("length", [1e-300, 1e-5, 1e5, 1e16])
    def test_a_scale_that_cannot_be_is_refused(self, length):
        with pytest.raises(CorrectionError, match=r"multiplies all lengths by .*, give one that changes them less"):
            correct(FLOOR, ScaleToLength(((0, 2), (4, 2)), length))


ALL: tuple[Correction, ...] = (
    merge_by_id(FLOOR, [1, 2]),
    split_by_id(FLOOR, 1, ((2, 2), (2, 5))),
    DrawRoom(((10, 0), (12, 0), (12, 2))),
    DeleteRoom((2, 3)),
    MarkOutside(outline_of(FLOOR, 3)),
    DrawDoor(((4.1, 3), (4.1, 4))),
    MoveDoor((1.5, 1.9), ((4.1, 3), (4.1, 4))),
    DeleteDoor((1.5, 1.9)),
    ChangeDoor((1.5, 1.9), "opening"),
    NameRoom(position_of(FLOOR, 1), "Küche"),
    NumberRoom(position_of(FLOOR, 1), "2.04"),
    label_by_id(FLOOR, 3, "hall"),
    SetType("school"),
    ScaleToLength(((0, 2), (4, 2)), 6.0),
    ScaleToArea((2, 3), 48.0),
)
KIND_NAMES = [*KINDS]


def test_all_kinds_are_tested():
    assert {type(correction) for correction in ALL} == {*KINDS.values()}


@pytest.mark.parametrize("correction", ALL, ids=KIND_NAMES)
def test_a_correction_is_taken_back(correction):
    corrected = correct(FLOOR, correction)
    assert corrected != FLOOR
    assert invert(FLOOR, correction).apply(corrected) == FLOOR


@pytest.mark.parametrize("correction", ALL, ids=KIND_NAMES)
def test_a_correction_in_a_turned_frame_gives_the_turned_floor(correction):
    turn = np.array([[cos(0.3), sin(0.3)], [-sin(0.3), cos(0.3)]])

    def move(xy: np.ndarray) -> np.ndarray:
        return np.asarray(xy @ turn + [7.0, -3.0])

    def turned(floor: Floor) -> Floor:

        rooms = tuple(replace(room, polygon=shapely.transform(room.polygon, move)) for room in floor)
        return replace(
            floor, rooms=rooms, doors=tuple(replace(d, line=shapely.transform(d.line, move)) for d in floor.doors)
        )

    corrected = correct(turned(FLOOR), move_correction(correction, move))
    expected = correct(FLOOR, correction)
    assert (ids_of(corrected), rooms_of_doors(corrected)) == (ids_of(expected), rooms_of_doors(expected))
    assert [room.polygon.area for room in corrected] == pytest.approx([room.polygon.area for room in expected])


@pytest.mark.parametrize("correction", [each for each in ALL if not isinstance(each, MoveDoor | DeleteDoor)], ids=str)
def test_a_correction_that_holds_already_changes_nothing(correction):
    corrected = correct(FLOOR, correction)
    if isinstance(correction, ScaleToLength):
        correction = ScaleToLength(((0, 3), (6, 3)), 6.0)
    if isinstance(correction, ScaleToArea):
        correction = ScaleToArea((4, 6), 48.0)
    assert correct(corrected, correction) is corrected


def test_an_inverse_is_refused_after_a_later_correction():
    merge = merge_by_id(FLOOR, [1, 2])
    inverse, merged = invert(FLOOR, merge), FLOOR.merge(1, 2)
    with pytest.raises(CorrectionError, match="rooms have changed since"):
        inverse.apply(merged.rename(1, "x"))


def test_corrections_that_do_not_fit_are_left_out_and_explained():
    corrected, outcomes = correct_all(FLOOR, [NameRoom((90, 90), "x"), NameRoom((2, 3), "y"), NameRoom((2, 3), "y")])
    assert [outcome.changed for outcome in outcomes] == [False, True, False]
    assert outcomes[0].problem == "there is no room at (90.00, 90.00), give a position inside a room"
    assert corrected == FLOOR.rename(1, "y")


@given(data=st.data(), seed=st.integers(0, 5))
def test_any_merge_and_split_keeps_the_area_and_the_other_rooms(data, seed):
    floor = make_floor("corridor", seed=seed)
    first = data.draw(st.sampled_from([door for door in floor.doors if not door.is_entrance])).rooms
    merged = floor.merge(*first)
    united = floor[first[0]].polygon.union(floor[first[1]].polygon)
    assert merged[min(first)].polygon.buffer(1e-5).contains(united)
    assert [room for room in merged if room.id not in first] == [room for room in floor if room.id not in first]
    room = data.draw(st.sampled_from(floor.rooms))
    angle = data.draw(st.floats(0, pi))
    middle, reach = np.array(position_of(floor, room.id)), 50 * np.array([cos(angle), sin(angle)])
    split = floor.split(room.id, [tuple(middle - reach), tuple(middle + reach)])
    parts = [each for each in split if each.id == room.id or each.id > floor.last_id]
    assert sum(part.polygon.area for part in parts) == pytest.approx(room.polygon.area)
    assert len({each.id for each in split}) == len(split)


@given(data=st.data(), seed=st.integers(0, 5))
def test_any_corrections_keep_the_rules_of_floors_and_are_taken_back(data, seed):
    first = floor = make_floor("corridor", seed=seed)
    inverses, gone, applied = [], set[int](), list[Correction]()
    for _ in range(6):
        correction = draw_correction(data, floor)
        try:
            corrected = correct(floor, correction)
        except CorrectionError:
            continue
        inverses.append(invert(floor, correction))
        applied.append(correction)
        assert inverses[-1].apply(corrected) == floor
        assert not gone & {*ids_of(corrected)}
        gone |= {*ids_of(floor)} - {*ids_of(corrected)}
        assert all(room_id in corrected for door in corrected.doors for room_id in door.room_ids)
        assert all(len({*door.rooms}) == 2 for door in corrected.doors)
        floor = corrected
    shapes = [room.polygon for room in floor]
    assert sum(shape.area for shape in shapes) == pytest.approx(shapely.union_all(shapes).area, abs=1e-4)
    assert correct_all(first, applied)[0] == floor
    for inverse in reversed(inverses):
        floor = inverse.apply(floor)
    assert floor == first


def draw_correction(data: st.DataObject, floor: Floor) -> Correction:
    """Any correction near a room, which may not fit."""
    room = data.draw(st.sampled_from(floor.rooms)) if len(floor) else Room(1, box(0, 0, 4, 4))
    x, y = position_of(Floor((room,), last_id=room.id), room.id)
    dx, dy = (data.draw(st.floats(-5, 5)) for _ in "xy")
    near, line = (x + dx, y + dy), ((x - dx, y - dy), (x + dx, y + dy))
    outline = ((x, y), (x + dx, y), (x + dx, y + dy), (x, y + dy))
    candidates: list[Correction] = [
        MergeRooms(((x, y), near)),
        SplitRoom(((x - 9 * dx, y - 9 * dy), (x + 9 * dx, y + 9 * dy)), ((x - dy, y + dx), (x + dy, y - dx))),
        DrawRoom(outline),
        DeleteRoom(near),
        MarkOutside(outline),
        DrawDoor(line),
        MoveDoor(near, line),
        DeleteDoor(near),
        ChangeDoor(near, "opening"),
        NameRoom(near, "x"),
        LabelRoom(near, None),
        SetType("school"),
    ]
    return data.draw(st.sampled_from(candidates))


class TestFile:
    def test_all_kinds_are_read_as_they_were_saved(self, tmp_path):
        save_corrections(ALL, tmp_path / "corrections.json")
        assert read_corrections(tmp_path / "corrections.json") == [*ALL]

    @pytest.mark.parametrize(
        ("item", "message"),
        [
            ({"kind": "mrge"}, "correction 1: its kind is 'mrge', give one of merge, "),
            ({"kind": "merge", "positions": [[1, 2]]}, "correction 1: merge: positions: "),
            (
                {"kind": "name", "position": [1, "2"], "name": "x"},
                "position[1]: Input should be a valid number, found '2'",
            ),
            ({"kind": "delete room", "position": [1, 1e300]}, "position[1]: Input should be less than"),
            ({"kind": "delete room", "position": [1, 2], "id": 3}, "correction 1: delete room: id: "),
            ({"kind": "delete room"}, "correction 1: delete room: position: "),
        ],
    )
    def test_a_damaged_correction_is_named(self, item, message):
        content = {"format": "pianta corrections", "version": "1.0", "corrections": [item]}
        with pytest.raises(CorrectionError) as error:
            parse_corrections(json.dumps(content).encode())
        assert message in str(error.value)

    @pytest.mark.parametrize("content", [b"[]", b"{}", b'{"format": "pianta floor", "version": "1.0"}', b"\xff"])
    def test_another_file_is_refused(self, content, tmp_path):
        file = tmp_path / "corrections.json"
        file.write_bytes(content)
        with pytest.raises(CorrectionError, match="cannot read the corrections"):
            read_corrections(file)


def test_corrections_read_as_sentences():
    assert [str(each) for each in ALL[:2]] == [
        "merge the rooms at (1.50, 3.50) (5.70, 3.50)",
        "split the room along (2.00, 2.00) (2.00, 5.00)",
    ]
    assert str(SplitRoom(((0, 0),) * 5, ((0, 0), (1, 1)))).endswith("(0.00, 0.00) …")
    assert str(LabelRoom((1, 2), None)) == "the room at (1.00, 2.00) has no label"
    assert isinstance(ALL[0], MergeRooms)
