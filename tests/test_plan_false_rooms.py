"""False rooms of a sheet: blocks of wall, parts of open rooms, and areas outside."""

import numpy as np
import pytest
from shapely import LineString, box

from pianta.floor import Door, Floor, Room
from pianta.plan.sheets.flagged_rooms import flag_rooms
from pianta.plan.sheets.open_rooms import join_open_rooms
from pianta.plan.sheets.sheet import Sheet
from pianta.plan.walls.segmentation import INSIDE, WALL, ClassMap

RESOLUTION = 0.02  # m per pixel
CELL_PX = 5.0
SHAPE = 400, 600  # a sheet of 8 m x 12 m


def draw_sheet(*strokes: tuple[float, float, float, float]) -> Sheet:
    """A white sheet with black rectangles: left, bottom, right, top in metres."""
    colors = np.full((*SHAPE, 3), 255, np.uint8)
    for stroke in strokes:
        left, bottom, right, top = (round(side / RESOLUTION) for side in stroke)
        colors[SHAPE[0] - top : SHAPE[0] - bottom, left:right] = 0
    return Sheet(colors)


def classify(*walls: tuple[float, float, float, float]) -> ClassMap:
    """Inside everywhere but on rectangles of wall, in metres."""
    probabilities = np.zeros((4, round(SHAPE[0] / CELL_PX), round(SHAPE[1] / CELL_PX)), np.float32)
    probabilities[INSIDE] = 1
    cell = CELL_PX * RESOLUTION
    for wall in walls:
        left, bottom, right, top = (round(side / cell) for side in wall)
        rows = slice(probabilities.shape[1] - top, probabilities.shape[1] - bottom)
        probabilities[INSIDE, rows, left:right], probabilities[WALL, rows, left:right] = 0, 1
    return ClassMap(probabilities, CELL_PX)


def two_halves() -> Floor:
    """Rooms of 5 m x 6 m on both sides of x = 6 m, with an opening between them and an entrance."""
    rooms = Room(1, box(1, 1, 5.95, 7)), Room(2, box(6.05, 1, 11, 7))
    opening = Door((1, 2), LineString([(6, 3), (6, 5)]), 2.0, kind="opening")
    entrance = Door((2, None), LineString([(11, 3), (11, 4)]), 1.0)
    return Floor(rooms, (opening, entrance))


def join(floor: Floor, sheet: Sheet, class_map: ClassMap, *, at_home: bool = True) -> Floor:
    return join_open_rooms(floor, sheet, class_map, resolution=RESOLUTION, at_home=at_home)


def test_halves_of_an_open_room_are_one_at_home():
    floor = join(two_halves(), draw_sheet(), classify())
    assert [room.id for room in floor] == [1]
    assert floor[1].polygon.area == pytest.approx(60.0, rel=0.01)
    assert [door.rooms for door in floor.doors] == [(1, None)]


def test_halves_stay_two_elsewhere():
    assert len(join(two_halves(), draw_sheet(), classify(), at_home=False)) == 2


@pytest.mark.parametrize("is_drawn", [True, False], ids=["ink", "wall of the network"])
def test_a_wall_with_a_doorway_divides_rooms(is_drawn):
    """4.5 of 6 metres of wall: the free 1.5 m are a passage."""
    wall = (5.9, 1, 6.1, 5.5)
    sheet, class_map = (draw_sheet(wall), classify()) if is_drawn else (draw_sheet(), classify(wall))
    assert len(join(two_halves(), sheet, class_map)) == 2


def test_a_block_of_wall_is_no_room():
    floor = Floor((Room(1, box(1, 1, 5, 7)), Room(2, box(5.1, 1, 6, 7)), Room(3, box(6.1, 1, 11, 7))))
    wall = (4.9, 0.9, 6.1, 7.1)
    joined = join(floor, draw_sheet(wall), classify(wall))
    assert [(room.id, room.polygon.bounds) for room in joined] == [(1, (1, 1, 5, 7)), (2, (6.1, 1, 11, 7))]


@pytest.mark.parametrize("at_home", [True, False])
def test_a_small_part_joins_the_room_into_which_it_opens(at_home):
    """1 m x 1 m beside room 1, behind a wall on the other side."""
    wall = (6.0, 1, 6.2, 7)
    floor = Floor((Room(1, box(1, 1, 4.95, 7)), Room(2, box(5.05, 1, 6.0, 2)), Room(3, box(6.2, 1, 11, 7))))
    joined = join(floor, draw_sheet(wall), classify(wall), at_home=at_home)
    assert len(joined) == 2
    assert joined[1].polygon.contains(floor[2].polygon.centroid)


def row_of_rooms(large: float, *, name: str | None = None) -> Floor:
    """Four rooms of 10 m² with doors, and one of another area without."""
    rooms = [Room(number, box(2 * number, 0, 2 * number + 2, 5)) for number in range(1, 5)]
    doors = tuple(Door((room.id, None), LineString([(2 * room.id, 0), (2 * room.id + 1, 0)]), 1.0) for room in rooms)
    return Floor((*rooms, Room(5, box(0, 10, large / 10, 20), name=name)), doors)


@pytest.mark.parametrize(
    ("floor", "flag"),
    [
        (row_of_rooms(120), "outside"),
        (row_of_rooms(80), None),
        (row_of_rooms(120, name="Gymnasium"), None),
        (row_of_rooms(8, name="Balkong"), "balcony"),
        (row_of_rooms(8, name="TERRACE"), "balcony"),
        (row_of_rooms(120, name="COURTYARD"), "courtyard"),
        (row_of_rooms(120, name="Garten 2"), "outside"),
        (row_of_rooms(20, name="Garden room"), None),
        (row_of_rooms(20, name="Decke 3"), None),
        (row_of_rooms(20, name="Winter garden"), None),
        (row_of_rooms(20, name="Court room"), None),
    ],
)
def test_rooms_outside_have_a_flag(floor, flag):
    assert [room.flag for room in flag_rooms(floor)] == [None] * 4 + [flag]


def test_large_rooms_have_no_flag_if_doors_are_not_drawn():
    floor = row_of_rooms(120)
    assert all(room.flag is None for room in flag_rooms(Floor(floor.rooms)))
