"""What a sheet shows beside its building: boxes of text, legends, site plans, the frame, and open spaces."""

import cv2
import numpy as np
import pytest
from shapely import LineString, box

from pianta.floor import OUTSIDE_FLAG, Door, Floor, Room
from pianta.plan.sheets.boxes import describe_left_out, erase_boxes, find_boxes
from pianta.plan.sheets.no_rooms import leave_out
from pianta.plan.sheets.parts import find_parts
from pianta.plan.sheets.sheet import PlacedText, Sheet

HEIGHT, WIDTH, DOOR_PX = 400, 600, 24.0
BUILDING = (40, 60, 340, 340)  # left, top, right, bottom in pixels
BOX = (400, 60, 560, 160)
LINES = ("All dimensions to be checked", "Do not scale from this drawing", "Copyright of the architect")


def draw_sheet(*rectangles: tuple[int, int, int, int]) -> Sheet:
    """A white sheet with the lines of rectangles: left, top, right, bottom."""
    colors = np.full((HEIGHT, WIDTH, 3), 255, np.uint8)
    for left, top, right, bottom in rectangles:
        cv2.rectangle(colors, (left, top), (right, bottom), (0, 0, 0), 3)
    return Sheet(colors)


def write(text: str, left: float, top: float, width: float = 130, height: float = 14) -> PlacedText:
    right, bottom = left + width, top + height
    return PlacedText(text, np.array([(top, left), (top, right), (bottom, right), (bottom, left)], float))


def write_lines(*lines: str, left: float = 410, top: float = 70) -> list[PlacedText]:
    return [write(line, left, top + 25 * number) for number, line in enumerate(lines)]


def room_of(number: int, rectangle: tuple[float, float, float, float]) -> Room:
    """A room within lines, with y up."""
    left, top, right, bottom = rectangle
    return Room(number, box(left + 3, HEIGHT - bottom + 3, right - 3, HEIGHT - top - 3))


def divide(*, columns: int, rows: int, rectangle=BUILDING) -> list[tuple[int, int, int, int]]:
    left, top, right, bottom = rectangle
    x, y = np.linspace(left, right, columns + 1).astype(int), np.linspace(top, bottom, rows + 1).astype(int)
    return [(x[i], y[j], x[i + 1], y[j + 1]) for j in range(rows) for i in range(columns)]


def join(one: int, other: int, x: float, y: float) -> Door:
    return Door((one, other), LineString([(x, y), (x, y + 20)]), 20.0)


def test_pieces_with_paper_between_them_are_parts_with_what_they_enclose():
    parts = find_parts(draw_sheet(BUILDING, BOX).ink, door_px=DOOR_PX)
    positions = [(200, 200), (100, 480), (300, 480), (45, 50)]
    assert [parts.number_at(np.array(position)) for position in positions] == [1, 2, 0, 0]
    assert not parts.frame.any()


def test_a_frame_is_no_part():
    parts = find_parts(draw_sheet(BUILDING, BOX, (10, 10, 589, 389)).ink, door_px=DOOR_PX)
    assert parts.number_at(np.array((370, 300))) == 0
    assert parts.number_at(np.array((100, 480))) == 2
    assert parts.frame.any()


def test_a_title_block_has_sides_in_common_with_the_frame():
    """Only the upper and left sides are its own, with the frame it encloses 180 x 120 px."""
    sheet = draw_sheet(BUILDING, (10, 10, 589, 389), (409, 269, 589, 389))
    parts = find_parts(sheet.ink, door_px=DOOR_PX)
    block = parts.number_at(np.array((330, 500)))
    assert block > 1
    lines = write_lines(*LINES, left=430, top=290)
    assert find_boxes(parts, lines) == {block: "box of text"}
    assert np.array_equal(erase_boxes(sheet, parts, {block}).colors, draw_sheet(BUILDING).colors)


def test_outer_walls_of_a_building_that_fills_the_sheet_are_no_frame():
    rooms = divide(columns=3, rows=2, rectangle=(10, 10, 589, 389))
    parts = find_parts(draw_sheet(*rooms).ink, door_px=DOOR_PX)
    assert not parts.frame.any()
    assert (parts.numbers > 0).mean() > 0.9


@pytest.mark.parametrize(
    ("lines", "name"),
    [
        (LINES, "box of text"),
        (("LEGEND", "Fire extinguisher", "Escape route", "First aid kit, you are here"), "legend"),
        (("1. Vestibule", "2. Main office", "3. Reading room", "4. Health room below"), "legend"),
        (("Elm School", "Scale 1:100", "Date 12.3.2014"), "box of text"),
        (LINES[:2], None),
        (("Garage", "12 m2", "3.0 x 4.0"), None),
    ],
    ids=["notes", "legend by heading", "legend by keys", "title block", "two lines", "a room"],
)
def test_boxes_are_named_by_what_is_written_in_them(lines, name):
    parts = find_parts(draw_sheet(BUILDING, BOX).ink, door_px=DOOR_PX)
    assert find_boxes(parts, write_lines(*lines)) == ({2: name} if name else {})


def test_names_in_the_rooms_of_a_second_building_are_no_list():
    """As many words, also on three tenths of it, but not below each other."""
    parts = find_parts(draw_sheet(BUILDING, BOX).ink, door_px=DOOR_PX)
    names = [write(name, 405 + 50 * (n % 3), 65 + 20 * n, 50, 14) for n, name in enumerate(["Girls shower"] * 5)]
    assert find_boxes(parts, names) == {}


def test_a_part_with_a_door_is_a_building():
    parts = find_parts(draw_sheet(BUILDING, BOX).ink, door_px=DOOR_PX)
    assert find_boxes(parts, write_lines(*LINES), [np.array((110.0, 480.0))]) == {}


def test_text_without_a_box_is_left_alone():
    parts = find_parts(draw_sheet(BUILDING, *((405, y, 545, y + 16) for y in (69, 94, 119))).ink, door_px=DOOR_PX)
    assert find_boxes(parts, [write(line, 403, 65 + 25 * n, 145, 24) for n, line in enumerate(LINES)]) == {}


def test_the_largest_part_is_no_box():
    parts = find_parts(draw_sheet(BOX).ink, door_px=DOOR_PX)
    assert find_boxes(parts, write_lines(*LINES)) == {}


def test_a_title_names_the_nearest_part_a_site_plan():
    parts = find_parts(draw_sheet(BUILDING, BOX, (400, 220, 560, 320)).ink, door_px=DOOR_PX)
    assert find_boxes(parts, [write("Lageplan 1:500", 410, 168)]) == {
        parts.number_at(np.array((100, 480))): "site plan"
    }
    assert find_boxes(parts, [write("Kitchen", 410, 168)]) == {}


def test_a_title_does_not_name_a_building_a_site_plan():
    other = (400, 60, 590, 340)
    parts = find_parts(draw_sheet(BUILDING, other).ink, door_px=DOOR_PX)
    assert find_boxes(parts, [write("SITE PLAN", 410, 350)]) == {}


def test_boxes_and_the_frame_become_paper():
    sheet = draw_sheet(BUILDING, BOX, (10, 10, 589, 389))
    sheet.colors[sheet.colors == 255] = 240
    parts = find_parts(sheet.ink, door_px=DOOR_PX)
    erased = erase_boxes(sheet, parts, {2: "legend"})
    expected = draw_sheet(BUILDING).colors
    assert np.array_equal(erased.colors, np.minimum(expected, 240))


def test_a_sheet_without_boxes_stays_as_it_is():
    sheet = draw_sheet(BUILDING)
    assert erase_boxes(sheet, find_parts(sheet.ink, door_px=DOOR_PX), {}) is sheet


def leave_out_of(floor: Floor, sheet: Sheet, texts=()) -> tuple[list[Floor], list[str]]:
    return leave_out([floor], find_parts(sheet.ink, door_px=DOOR_PX), texts, height=HEIGHT)


def test_a_box_of_text_that_touches_the_building_is_no_room():
    sheet_plan = [(40, 60, 190, 200), (190, 60, 340, 200), (340, 60, 500, 200)]
    lines = write_lines(*LINES, *LINES, left=350, top=62)
    rooms = [room_of(1, sheet_plan[2]), room_of(2, sheet_plan[0]), room_of(3, sheet_plan[1])]
    floor = Floor(tuple(rooms), (join(2, 3, 190, 260),))
    (left,), kinds = leave_out_of(floor, draw_sheet(*sheet_plan), lines)
    assert kinds == ["box of text"]
    assert [(room.id, room.polygon.bounds[0]) for room in left] == [(1, 43), (2, 193)]
    assert [door.rooms for door in left.doors] == [(1, 2)]


def test_a_room_with_a_door_is_no_box_of_text():
    sheet_plan = [(40, 60, 340, 200), (340, 60, 500, 200)]
    floor = Floor((room_of(1, sheet_plan[0]), room_of(2, sheet_plan[1])), (join(1, 2, 340, 260),))
    assert leave_out_of(floor, draw_sheet(*sheet_plan), write_lines(*LINES, *LINES, left=350, top=62)) == ([floor], [])


def test_small_rectangles_beside_a_building_with_doors_are_a_site_plan():
    large, small = divide(columns=2, rows=2), divide(columns=3, rows=2, rectangle=(420, 100, 520, 160))
    rooms = [room_of(number, sheet_plan) for number, sheet_plan in enumerate([*large, *small], start=1)]
    doors = join(1, 2, 190, 260), join(3, 4, 190, 100), join(1, 3, 100, 200)
    sheet = draw_sheet(*large, *small)
    (left,), kinds = leave_out_of(Floor(tuple(rooms), doors), sheet)
    assert (len(left), kinds) == (4, ["site plan"])
    # Without doors it may be a wing whose rooms are small
    assert leave_out_of(Floor(tuple(rooms)), sheet)[1] == []


def test_all_that_is_drawn_is_not_left_out():
    floor = Floor((room_of(1, BOX),))
    assert leave_out_of(floor, draw_sheet(BOX), write_lines(*LINES, *LINES, left=405, top=50)) == ([floor], [])


def test_a_room_that_no_lines_enclose_is_outside():
    large = divide(columns=3, rows=2)
    rooms = [room_of(number, sheet_plan) for number, sheet_plan in enumerate(large, start=1)]
    beside = Room(7, box(345, 100, 500, 300))
    (flagged,), kinds = leave_out_of(Floor((*rooms, beside)), draw_sheet(*large))
    assert kinds == []
    assert [room.flag for room in flagged] == [None] * 6 + [OUTSIDE_FLAG]
    # A name and a door make it a room
    named = [write("Terrace", 380, 200)]
    (remaining,), _ = leave_out_of(Floor((*rooms, beside)), draw_sheet(*large), named)
    assert remaining[7].flag is None
    (joined,), _ = leave_out_of(Floor((*rooms, beside), (join(3, 7, 340, 250),)), draw_sheet(*large))
    assert joined[7].flag is None


@pytest.mark.parametrize(
    ("kinds", "line"),
    [
        ([], ()),
        (["site plan", "box of text", "legend", "box of text"], ("left out: a legend, 2 boxes of text, a site plan",)),
    ],
)
def test_what_was_left_out_is_a_line(kinds, line):
    assert describe_left_out(kinds) == line
