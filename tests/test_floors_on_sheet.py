"""The floors on a sheet are separated, reconstructed each on its own, and get their drawn doors."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import LineString, Polygon, box

from pianta._types import Floats
from pianta.floor import Door, Floor, Room
from pianta.layout.reconstruct import find_rooms
from pianta.plan.doors.lines import PlanDoors
from pianta.plan.sheets.floors_on_sheet import reconstruct_sheet_floors, split_sheet
from pianta.plan.walls.floor_map import draw_floor_map
from pianta.plan.walls.segmentation import DOOR, INSIDE
from tests.drawn_class_maps import CELL_PX, RESOLUTION, CellClasses, as_class_map, draw_classes, sheet_shape, two_rooms
from tests.drawn_maps import carve

LINE = LineString([(40, 60), (40, 92)])
NONE = np.zeros((0, 2, 2))
JAMBS = np.array([[(112.0, 204.0), (144.0, 204.0)]])
# The rooms of two_rooms, pixels of the sheet, y up.
LEFT, RIGHT = box(40, 40, 200, 200), box(208, 40, 368, 200)


def reconstruct(
    classes: CellClasses,
    doors: Floats = NONE,
    *,
    method: str = "structure",
    closed: bool = True,
    uncertain: list[bool] | None = None,
) -> list[Floor]:
    """The floors. closed: whether doors are also drawn into the map; uncertain: for each door, False by default."""
    closed_doors = doors if closed else NONE
    floor_map = draw_floor_map(
        as_class_map(classes), closed_doors, sheet_shape=sheet_shape(classes), resolution=RESOLUTION
    )
    plan_doors = PlanDoors(doors, doors, np.zeros(len(doors), bool) if uncertain is None else np.array(uncertain))
    return reconstruct_sheet_floors(floor_map, plan_doors, method=method, source="plan.png")


def overlap(one: Polygon, other: Polygon) -> float:
    return float(one.intersection(other).area / one.union(other).area)


def room_at(floor: Floor, polygon: Polygon) -> Room:
    """The room with this polygon, within half the thickness of a wall."""
    (same_room,) = [room for room in floor.rooms if overlap(room.polygon, polygon) > 0.8]
    return same_room


@pytest.mark.parametrize("method", ["structure", "thesis", "morphological"])
def test_two_rooms_and_the_door_between_them(method):
    (floor,) = reconstruct(two_rooms(), JAMBS, method=method)
    assert len(floor.rooms) == 2
    ids = sorted([room_at(floor, LEFT).id, room_at(floor, RIGHT).id])
    (door,) = floor.doors
    assert door.room_ids == tuple(ids)
    # y goes up from the lower edge of the sheet: 240 - 112 and 240 - 144.
    assert np.array(sorted(door.line.coords)) == pytest.approx(np.array([(204, 96), (204, 128)]))
    assert door.width == pytest.approx(32)
    assert floor.source == "plan.png"


def test_rooms_of_a_plan_are_complete_and_not_predicted():
    (floor,) = reconstruct(two_rooms(), JAMBS)
    assert [(room.partial, room.predicted, room.confidence) for room in floor.rooms] == [(False, None, None)] * 2


def test_a_plan_has_no_possible_doors(monkeypatch):
    def find_with_possible_door(*args, **options) -> Floor:
        floor = find_rooms(*args, **options)
        return replace(floor, possible_doors=(Door((floor.rooms[0].id, None), LINE, 0.9),))

    monkeypatch.setattr("pianta.plan.sheets.floors_on_sheet.find_rooms", find_with_possible_door)
    (floor,) = reconstruct(two_rooms(), JAMBS)
    assert (len(floor.rooms), floor.possible_doors) == (2, ())


def test_a_door_to_the_outside_is_an_entrance():
    entrance = np.array([[(206.0, 80.0), (206.0, 112.0)]])
    (floor,) = reconstruct(two_rooms(), np.concatenate([JAMBS, entrance]))
    left, right = room_at(floor, LEFT).id, room_at(floor, RIGHT).id
    assert sorted(door.rooms for door in floor.doors if door.is_entrance) == [(left, None)]
    assert [door.room_ids for door in floor.doors if not door.is_entrance] == [tuple(sorted([left, right]))]


@pytest.mark.parametrize(("uncertain", "count"), [([False, False], 2), ([False, True], 1), ([True, True], 1)])
def test_an_uncertain_door_counts_if_a_room_has_no_other(uncertain, count):
    second = JAMBS + np.array((-60.0, 0.0))
    (floor,) = reconstruct(two_rooms(), np.concatenate([JAMBS, second]), uncertain=uncertain)
    assert [door.kind for door in floor.doors] == ["door"] * count


def test_a_drawn_door_that_the_layout_finds_too_is_one_door():
    """Its gap is left open, so that the layout method finds it, too."""
    (floor,) = reconstruct(two_rooms(), JAMBS, closed=False)
    assert len(floor.rooms) == 2
    assert [door.width for door in floor.doors] == pytest.approx([32])
    (without,) = reconstruct(two_rooms())
    assert len(without.doors) == 1


def test_on_a_plan_with_doors_a_passage_without_one_is_an_opening():
    """A third room below the left one, behind a gap that the layout method finds."""
    classes = draw_classes((104, 102), (10, 50, 10, 50), (10, 50, 52, 92), (52, 92, 10, 50))
    classes[28:36, 50:52] = DOOR
    classes[50:52, 26:34] = INSIDE
    (floor,) = reconstruct(classes, JAMBS)
    assert sorted(door.kind for door in floor.doors) == ["door", "opening"]
    elsewhere = JAMBS + np.array((0, 1000))
    for doors in (NONE, elsewhere):
        (without,) = reconstruct(classes, doors)
        assert {door.kind for door in without.doors} == {"door"}


def test_doors_outside_of_a_floor_are_ignored():
    (floor,) = reconstruct(two_rooms(doors=()), JAMBS - (0, 80))
    assert floor.doors == ()


def test_floors_beside_each_other_come_the_larger_first():
    small, large = (10, 50, 10, 90), (10, 90, 130, 230)
    classes = draw_classes((100, 240), small, large)
    doors = np.array([[(100.0, 360.0), (132.0, 360.0)], [(200.0, 928.0), (232.0, 928.0)]])
    first, second = reconstruct(classes, doors)
    right, left = box(520, 40, 920, 360), box(40, 200, 360, 360)
    assert len(first.rooms) == len(second.rooms) == 1
    assert overlap(first.rooms[0].polygon, right) > 0.8
    assert overlap(second.rooms[0].polygon, left) > 0.8
    for floor, x in ((first, 928), (second, 360)):
        (door,) = floor.doors
        assert door.is_entrance
        assert [at for at, _ in door.line.coords] == pytest.approx([x, x])


def test_a_sheet_without_rooms_has_no_floors():
    assert reconstruct(draw_classes((60, 60))) == []
    assert reconstruct(draw_classes((60, 60)), JAMBS) == []


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_turned_class_maps_give_turned_rooms_and_doors(quarters):
    classes = np.rot90(two_rooms(), quarters)
    height, width = 240.0, 408.0
    doors, rooms = JAMBS, [LEFT, RIGHT]
    for turn in range(quarters):
        high, wide = (height, width) if turn % 2 == 0 else (width, height)
        doors = np.stack([wide - doors[..., 1], doors[..., 0]], axis=-1)
        rooms = [Polygon([(high - y, x) for x, y in room.exterior.coords]) for room in rooms]
    (floor,) = reconstruct(classes, doors)
    assert len(floor.rooms) == 2
    ids = sorted(room_at(floor, room).id for room in rooms)
    (door,) = floor.doors
    assert door.room_ids == tuple(ids)
    assert door.width == pytest.approx(32)


@pytest.mark.parametrize(("down", "right"), [(5, 0), (-6, 3), (0, -6)])
def test_shifted_class_maps_give_shifted_rooms_and_doors(down, right):
    (base,) = reconstruct(two_rooms(), JAMBS)
    shift = np.array([down, right]) * CELL_PX
    (moved,) = reconstruct(np.roll(two_rooms(), (down, right), (0, 1)), JAMBS + shift)
    for room, other in zip(base.rooms, moved.rooms, strict=True):
        expected = [(x + shift[1], y - shift[0]) for x, y in room.polygon.exterior.coords]
        assert overlap(other.polygon, Polygon(expected)) > 0.99
    assert [door.rooms for door in base.doors] == [door.rooms for door in moved.doors]


def test_distant_parts_are_two_floors():
    """Blocks of 10 m × 10 m with a gap; 1.9 m is the wall of a courtyard, 2.5 m is paper."""
    for gap, floors in ((19, 1), (25, 2)):
        inside = carve((100, 300), (0, 100, 0, 100), (0, 100, 100 + gap, 200 + gap))
        assert split_sheet(inside, resolution=0.1).max() == floors


def test_floors_are_numbered_by_their_size():
    inside = carve((200, 400), (0, 80, 0, 80), (0, 120, 150, 300), (0, 90, 330, 400))
    parts = split_sheet(inside, resolution=0.1)
    assert [parts[10, 10], parts[10, 200], parts[10, 350], parts[190, 10]] == [2, 1, 3, 0]
    assert np.array_equal(parts > 0, inside)


def test_sketches_and_legends_are_no_floors():
    """Beside a floor of 400 m²: 7 m × 7 m is less than 0.15 of it, and 5 m × 5 m less than any floor."""
    floor = (0, 200, 0, 200)
    assert split_sheet(carve((200, 300), floor, (0, 70, 225, 295)), resolution=0.1).max() == 1
    assert split_sheet(carve((200, 325), floor, (0, 80, 240, 320)), resolution=0.1).max() == 2
    small = carve((200, 325), (0, 80, 0, 80), (0, 50, 240, 290))
    assert split_sheet(small, resolution=0.1).max() == 1


def test_the_only_floor_may_be_small():
    assert split_sheet(carve((100, 100), (0, 20, 0, 20)), resolution=0.1).max() == 1
    assert split_sheet(np.zeros((50, 60), bool), resolution=0.1).max() == 0
    assert (split_sheet(np.ones((50, 60), bool), resolution=0.1) == 1).all()


@pytest.mark.slow
@given(st.integers(0, 2**32 - 1), st.integers(0, 3))
def test_turning_a_sheet_turns_its_floors(seed, quarters):
    rng = np.random.default_rng(seed)
    corners, sizes = rng.integers(0, 100, (4, 2)), rng.integers(10, 60, (4, 2))
    boxes = [(top, top + high, left, left + wide) for (top, left), (high, wide) in zip(corners, sizes, strict=True)]
    inside = carve((160, 160), *boxes)
    parts = split_sheet(inside, resolution=0.2)
    turned = split_sheet(np.rot90(inside, quarters), resolution=0.2)
    areas = [np.bincount(image.ravel())[1:].tolist() for image in (parts, turned)]
    assert areas[0] == areas[1] == sorted(areas[0], reverse=True)
    assert np.array_equal(turned > 0, np.rot90(parts > 0, quarters))
