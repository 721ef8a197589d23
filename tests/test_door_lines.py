"""Doors as lines from jamb to jamb, and the rooms on both sides of them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from shapely import LineString, box

from pianta.floor import Door, Floor, Room
from pianta.plan.doors.lines import drop_narrow_doors, find_doors, find_network_doors, join_rooms
from pianta.plan.doors.swings import Swing
from pianta.plan.symbols.drawings import SymbolKind
from pianta.plan.symbols.poses import PlacedSymbol
from pianta.plan.walls.segmentation import DOOR, INSIDE
from tests.drawn_class_maps import CELL_PX, as_class_map, draw_classes, two_rooms

NONE = np.zeros((0, 2, 2))
# The doorway of two_rooms: rows 28 … 36 of the wall in the columns 50 and 51, times CELL_PX.
JAMBS = np.array([(112.0, 204.0), (144.0, 204.0)])
ROOMS = (Room(1, box(0, 0, 4, 4)), Room(2, box(4.2, 0, 8, 4)))


def swing(hinge: tuple[float, float], jamb: tuple[float, float]) -> Swing:
    start, end = np.array(hinge), np.array(jamb)
    across = (end - start)[::-1] * (1, -1)
    return Swing(start, end, start + across, float(np.hypot(*across)), 1.0)


def symbol(symbol_kind: SymbolKind, jambs: NDArray[np.float64] | None) -> PlacedSymbol:
    return PlacedSymbol("symbol", symbol_kind, np.zeros((4, 2)), jambs, 0.9, np.ones((2, 2), bool))


def sorted_ends(lines: NDArray[np.float64]) -> NDArray[np.float64]:
    """Lines whose upper or left end comes first."""
    return np.array([sorted(line.tolist()) for line in lines])


def test_a_door_of_the_network_is_a_line_along_the_wall():
    assert sorted_ends(find_network_doors(as_class_map(two_rooms()))) == pytest.approx(JAMBS[None])


def test_fewer_than_four_cells_are_no_door():
    classes = two_rooms(doors=((28, 29, 50, 53),))
    assert find_network_doors(as_class_map(classes)).shape == (0, 2, 2)
    classes[28, 49] = DOOR
    assert find_network_doors(as_class_map(classes)).shape == (1, 2, 2)
    assert find_network_doors(as_class_map(two_rooms(doors=()))).shape == (0, 2, 2)


def test_a_slanting_door_is_a_slanting_line():
    classes = draw_classes((60, 60), (5, 55, 5, 55))
    for step in range(8):
        classes[20 + step, 20 + step : 22 + step] = DOOR
    (line,) = sorted_ends(find_network_doors(as_class_map(classes)))
    slope = np.degrees(np.arctan2(*(line[1] - line[0])))
    assert slope == pytest.approx(45, abs=6)
    assert np.hypot(*(line[1] - line[0])) == pytest.approx(8 * CELL_PX * np.sqrt(2), rel=0.15)
    assert line.mean(axis=0) == pytest.approx([96, 98])


def test_a_door_of_the_network_has_a_least_probability():
    class_map = as_class_map(two_rooms())
    where = class_map.probabilities[DOOR] > 0.5
    for door, count in ((0.45, 1), (0.35, 0)):
        class_map.probabilities[:, where] = 0
        class_map.probabilities[DOOR, where], class_map.probabilities[INSIDE, where] = door, 1 - door
        assert len(find_network_doors(class_map)) == count


@settings(max_examples=25)
@given(st.integers(0, 3), st.integers(-8, 8), st.integers(-8, 8))
def test_turned_and_shifted_class_maps_have_turned_and_shifted_doors(quarters, down, right):
    classes = np.rot90(np.roll(two_rooms(), (down, right), (0, 1)), quarters)
    height, width = np.array((60, 102)) * CELL_PX
    expected = JAMBS + np.array([down, right]) * CELL_PX
    for turn in range(quarters):
        side = height if turn % 2 else width
        expected = np.column_stack([side - expected[:, 1], expected[:, 0]])
    detected = find_network_doors(as_class_map(classes))
    assert sorted_ends(detected) == pytest.approx(sorted_ends(expected[None]))


def test_files_symbols_and_swings_come_before_the_network():
    class_map = as_class_map(two_rooms())
    jambs = np.array([(110.0, 202.0), (140.0, 202.0)])
    assert find_doors(class_map, [], [symbol("door", jambs)], NONE).closed == pytest.approx(jambs[None])
    leaf = swing((143, 203), (113, 203))
    assert find_doors(class_map, [leaf], [], NONE).closed == pytest.approx(np.array([[(143, 203), (113, 203)]]))
    both = find_doors(class_map, [leaf], [symbol("door", jambs)], NONE).closed
    assert both == pytest.approx(jambs[None])
    named = np.array([[(100.0, 205.0), (150.0, 205.0)]])
    assert find_doors(class_map, [leaf], [symbol("door", jambs)], named).closed == pytest.approx(named)


def test_a_single_swing_needs_the_network():
    class_map = as_class_map(two_rooms())
    chair = swing((60, 100), (60, 130))
    assert sorted_ends(find_doors(class_map, [chair], [], NONE).closed) == pytest.approx(JAMBS[None])
    # Doors of the file need no network.
    named = np.array([[(60.0, 100.0), (60.0, 130.0)]])
    assert len(find_doors(class_map, [], [], named).lines) == 2


@pytest.mark.parametrize(("count", "accepted"), [(7, 0), (8, 8)])
def test_many_swings_of_one_width_are_doors_without_the_network(count, accepted):
    class_map = as_class_map(two_rooms(doors=()))
    leaves = [swing((20 + 25 * number, 100), (20 + 25 * number, 120)) for number in range(count)]
    other = swing((20, 250), (20, 290))
    detected = find_doors(class_map, [*leaves, other], [], NONE).closed
    assert sorted_ends(detected) == pytest.approx(sorted_ends(np.array([leaf.closed for leaf in leaves[:accepted]])))


def test_a_leaf_closes_on_the_face_of_the_wall_and_the_door_is_in_its_middle():
    """A wall of 8 px between the rows 100 and 108; the leaf of 40 px swings up."""
    class_map = as_class_map(two_rooms(doors=()))
    class_map.probabilities[DOOR] = 0.9
    leaf = Swing(np.array([100.0, 60]), np.array([100.0, 100]), np.array([60.0, 60]), 40.0, 1.0)
    detected = find_doors(class_map, [leaf], [], NONE)
    assert detected.closed.tolist()[0] == [[100, 60], [100, 100]]
    assert detected.lines.tolist()[0] == [[104, 60], [104, 100]]
    for jambs in ([(100, 60), (100, 100)], [(100, 100), (100, 60)]):
        placed = replace(symbol("door", np.array(jambs, float)), corners=np.array([(60, 60), (60, 100), (100, 100)]))
        detected = find_doors(class_map, [], [placed], NONE)
        assert detected.closed.tolist()[0] == np.array(jambs).tolist()
        assert detected.lines[0, :, 0].tolist() == [104, 104]


@pytest.mark.parametrize(
    ("jamb", "opens", "lines"),
    [((100, 142), (60, 182), 1), ((100, 160), (60, 200), 2), ((100, 142), (140, 182), 2), ((100, 182), (60, 142), 2)],
)
def test_two_leaves_that_meet_and_open_to_one_side_are_one_door(jamb, opens, lines):
    """A leaf from column 100 to 140; the other meets it, ends 20 px away, opens to the other side, or follows it."""
    class_map = as_class_map(two_rooms(doors=()))
    class_map.probabilities[DOOR] = 0.9
    left = Swing(np.array([100.0, 100]), np.array([100.0, 140]), np.array([60.0, 100]), 40.0, 1.0)
    hinge = np.array([100.0, opens[1]])
    right = Swing(hinge, np.array(jamb, float), np.array(opens, float), 40.0, 1.0)
    detected = find_doors(class_map, [left, right], [], NONE)
    closed_lines = [line for line in detected.closed.tolist() if line[0][0] == 100]
    assert len(closed_lines) == lines
    if lines == 1:
        assert closed_lines == [[[100, 100], [100, 182]]]


@pytest.mark.parametrize(("probability", "rows", "uncertain"), [(0.9, 8, False), (0.5, 8, True), (0.9, 3, True)])
def test_a_faint_or_short_door_of_the_network_is_uncertain(probability, rows, uncertain):
    classes = two_rooms(doors=((28, 28 + rows, 50, 52),))
    class_map = as_class_map(classes)
    where = class_map.probabilities[DOOR] > 0.5
    class_map.probabilities[DOOR, where], class_map.probabilities[INSIDE, where] = probability, 1 - probability
    assert find_doors(class_map, [], [], NONE).uncertain.tolist() == [uncertain]


def test_a_symbol_that_the_network_hardly_supports_is_uncertain_and_a_swing_is_not():
    class_map = as_class_map(two_rooms(doors=()))
    class_map.probabilities[DOOR] = 0.2
    assert find_doors(class_map, [], [symbol("door", JAMBS)], NONE).uncertain.tolist() == [True]
    assert find_doors(class_map, [swing((112, 204), (144, 204))], [], NONE).uncertain.tolist() == [False]
    assert find_doors(class_map, [], [], JAMBS[None]).uncertain.tolist() == [False]


def test_windows_stairs_and_doors_without_jambs_are_no_doors():
    class_map = as_class_map(two_rooms(doors=()))
    class_map.probabilities[DOOR] = 0.2
    symbols = [symbol("window", JAMBS), symbol("object", None), symbol("door", None)]
    assert find_doors(class_map, [], symbols, NONE).lines.shape == (0, 2, 2)
    assert len(find_doors(class_map, [], [symbol("door", JAMBS)], NONE).lines) == 1


def test_two_doors_beside_each_other_are_two():
    classes = two_rooms(doors=((16, 24, 50, 52), (28, 36, 50, 52)))
    leaves = [swing((64, 204), (96, 204)), swing((144, 204), (112, 204))]
    assert len(find_doors(as_class_map(classes), leaves, [], NONE).lines) == 2


@pytest.mark.parametrize("corner", [(-200.0, -300.0), (5000.0, 90.0), (-500.0, 90.0)])
def test_a_line_off_the_sheet_is_near_no_door(corner):
    off = symbol("door", np.array([corner, (corner[0], corner[1] + 30)]))
    assert sorted_ends(find_doors(as_class_map(two_rooms()), [], [off], NONE).lines) == pytest.approx(JAMBS[None])


def test_a_door_joins_the_rooms_on_its_sides():
    (door,) = join_rooms(ROOMS, [LineString([(4.1, 1), (4.1, 1.9)])])
    assert door.rooms == (1, 2)
    assert door.width == pytest.approx(0.9)
    assert door.line.equals(LineString([(4.1, 1), (4.1, 1.9)]))


@given(st.booleans(), st.permutations(ROOMS))
def test_the_order_of_rooms_and_of_jambs_does_not_matter(turned, rooms):
    line = LineString([(4.1, 1), (4.1, 1.9)])
    (door,) = join_rooms(rooms, [line.reverse() if turned else line])
    assert door.rooms == (1, 2)


def test_a_door_to_the_outside_is_an_entrance():
    doors = join_rooms(ROOMS, [LineString([(1, -0.1), (1.9, -0.1)]), LineString([(8.1, 3), (8.1, 2)])])
    assert [door.rooms for door in doors] == [(1, None), (2, None)]
    assert all(door.is_entrance for door in doors)


def test_lines_within_a_room_and_far_from_rooms_are_no_doors():
    lines = [LineString([(1, 2), (2, 2)]), LineString([(20, 2), (21, 2)]), LineString([(1, -2), (2, -2)])]
    assert join_rooms(ROOMS, lines) == []
    assert join_rooms(ROOMS, []) == []
    assert join_rooms([], [LineString([(4.1, 1), (4.1, 1.9)])]) == []


@pytest.mark.parametrize(("thickness", "rooms"), [(0.1, (1, 2)), (0.6, (1, 2)), (1.6, (1, 2)), (2.4, None)])
def test_walls_up_to_two_metres_lie_between_two_rooms(thickness, rooms):
    apart = (Room(1, box(0, 0, 4, 4)), Room(2, box(4 + thickness, 0, 9, 4)))
    middle = 4 + thickness / 2
    doors = join_rooms(apart, [LineString([(middle, 1), (middle, 1.9)])])
    assert [door.rooms for door in doors] == ([rooms] if rooms else [])


@pytest.mark.parametrize(("offset", "rooms"), [(0.5, (1, 2)), (-0.5, (1, 2)), (0.8, None)])
def test_a_line_drawn_beside_the_wall_joins_the_rooms_of_the_wall(offset, rooms):
    doors = join_rooms(ROOMS, [LineString([(4.1 + offset, 1), (4.1 + offset, 1.9)])])
    assert [door.rooms for door in doors] == ([rooms] if rooms else [])


def test_a_line_without_length_is_no_door():
    assert join_rooms(ROOMS, [LineString([(4.1, 1), (4.1, 1)])]) == []


def test_doors_that_are_too_narrow_for_people_are_left_out():
    lines = [LineString([(4.1, y), (4.1, y + length)]) for y, length in ((0.5, 0.29), (1.5, 0.31), (2.5, 0.9))]
    doors = tuple(Door((1, 2), line, line.length) for line in lines)
    assert drop_narrow_doors(Floor(ROOMS, doors)).doors == doors[1:]
