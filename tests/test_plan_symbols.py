"""Symbols of plans: their drawings, their jambs, and their positions on a floor."""

from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapely import GeometryCollection, LineString, MultiPoint, Point, Polygon, box, unary_union

from pianta.errors import OptionError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.plan.symbols.drawings import (
    GREEN,
    RED,
    SYMBOLS,
    Mark,
    draw_symbol,
    frame_symbol,
    paint_marks,
    pixel_matrix,
)
from pianta.worlds.plans.symbols import (
    DOUBLE_WIDTH,
    find_windows,
    mark_doors,
    mark_furniture,
    mark_room_symbol,
    mark_signs,
    mark_windows,
    place_marks,
    widen_doors,
)

LINES = sorted(name for name, symbol in SYMBOLS.items() if not symbol.is_sign)
SIGNS = sorted(SYMBOLS.keys() - LINES)

# Two rooms of 5 m × 4 m with an inner wall of 0.15 m between them, and a door of 0.9 m in it.
SOUTH, NORTH = box(0, 0, 5, 4), box(0, 4.15, 5, 8.15)
MIDDLE_DOOR = Door((1, 2), LineString([(2, 4.075), (2.9, 4.075)]), 0.9)
FLOOR = Floor((Room(1, SOUTH), Room(2, NORTH)), (MIDDLE_DOOR,))
FOOTPRINT = unary_union([SOUTH, NORTH]).buffer(0.3, join_style="mitre")


def cells_at(
    name: str, points: Sequence[tuple[float, float]], *, size_px: float = 40.0, stroke_px: int = 1
) -> list[int]:
    """Greys of a symbol at points of its own frame."""
    picture = draw_symbol(name, size_px=size_px, stroke_px=stroke_px)
    _, matrix = frame_symbol(name, size_px=size_px, stroke_px=stroke_px)
    cols, rows = np.floor(np.array(points) @ matrix[:, :2].T + matrix[:, 2]).astype(int).T
    greys: list[int] = picture[rows, cols].tolist()
    return greys


def test_there_are_doors_windows_and_objects():
    symbol_kinds = {name: symbol.kind for name, symbol in SYMBOLS.items()}
    assert {name for name, symbol_kind in symbol_kinds.items() if symbol_kind == "door"} == {
        *("door", "door 45", "leaf", "leaf 45", "double door", "sliding door"),
    }
    assert {name for name, symbol_kind in symbol_kinds.items() if symbol_kind == "window"} == {"window", "window 3"}
    assert {"stairs", "lift", "extinguisher", "hydrant", "exit", "first aid", "assembly point"} <= symbol_kinds.keys()
    assert [name for name, symbol in SYMBOLS.items() if (symbol.jambs is None) != (symbol.kind == "object")] == []


def test_a_door_is_a_leaf_and_a_quarter_of_a_circle():
    on_leaf, on_arc = (0, -0.5), (np.sqrt(0.5), -np.sqrt(0.5))
    inside, beyond, threshold = (0.5, -0.4), (0.9, -0.9), (0.5, 0)
    assert [grey < 128 for grey in cells_at("door", [on_leaf, on_arc, inside, beyond, threshold], stroke_px=2)] == [
        True,
        True,
        False,
        False,
        False,
    ]


def test_a_leaf_has_no_arc():
    on_arc = (np.cos(np.pi / 8), -np.sin(np.pi / 8))
    assert cells_at("door 45", [on_arc], stroke_px=2)[0] < 128
    assert cells_at("leaf 45", [on_arc], stroke_px=2)[0] == 255


def test_a_double_door_is_its_own_mirror_image():
    picture = draw_symbol("double door", size_px=30).astype(int)
    assert np.abs(picture - picture[:, ::-1]).max() <= 60
    assert picture.shape == frame_symbol("double door", size_px=30)[0]
    assert SYMBOLS["double door"].jambs == pytest.approx(np.array([(0, 0), (2, 0)]))


@pytest.mark.parametrize(("name", "lines"), [("window", 2), ("window 3", 3)])
def test_a_window_has_two_or_three_lines(name, lines):
    dark = draw_symbol(name, size_px=60)[:, 45] < 128
    assert int((np.diff(dark.astype(int)) == 1).sum()) == lines


def test_signs_have_the_colours_of_their_meaning():
    assert tuple(draw_symbol("extinguisher", size_px=40)[4, 4]) == RED
    assert tuple(draw_symbol("hydrant", size_px=40)[4, 4]) == RED
    assert tuple(draw_symbol("exit", size_px=40)[4, 4]) == GREEN
    cross = draw_symbol("first aid", size_px=40)
    assert tuple(cross[20, 20]) == (255, 255, 255)
    assert tuple(cross[10, 10]) == GREEN


@given(st.sampled_from(sorted(SYMBOLS)), st.floats(4, 60), st.integers(1, 3))
def test_symbols_are_completely_inside_their_image(name, size_px, stroke_px):
    picture = draw_symbol(name, size_px=size_px, stroke_px=stroke_px)
    assert picture.shape == (*frame_symbol(name, size_px=size_px, stroke_px=stroke_px)[0], 3)[: picture.ndim]
    assert picture.ndim == (3 if name in SIGNS else 2)
    edge = np.concatenate([picture[0], picture[-1], picture[:, 0], picture[:, -1]])
    assert edge.min() > 100
    assert picture.min() < 160


@pytest.mark.parametrize("name", LINES)
def test_jambs_lie_in_the_symbol(name):
    jambs = SYMBOLS[name].jambs
    if jambs is not None:
        shape, matrix = frame_symbol(name, size_px=20)
        cols, rows = (jambs @ matrix[:, :2].T + matrix[:, 2]).T
        assert rows.min() >= 0
        assert rows.max() <= shape[0]
        assert np.hypot(np.ptp(cols), np.ptp(rows)) == pytest.approx(20 * np.hypot(*(jambs[1] - jambs[0])))


def test_invalid_symbols_are_refused_with_a_message():
    with pytest.raises(OptionError, match="sofa"):
        draw_symbol("sofa", size_px=20)
    with pytest.raises(OptionError, match="3 px"):
        draw_symbol("door", size_px=3)
    with pytest.raises(OptionError, match="0 px"):
        draw_symbol("door", size_px=20, stroke_px=0)


def test_the_matrix_of_a_grid_is_its_map_to_pixel():
    grid = GridMap(np.zeros((40, 60), int), 0.1, (1.0, 2.0, 0.5))
    xy = np.array([(3.0, 2.5), (1.5, 4.0)])
    matrix = pixel_matrix(grid)
    assert (xy @ matrix[:, :2].T + matrix[:, 2])[:, ::-1] == pytest.approx(np.column_stack(grid.map_to_pixel(*xy.T)))


def test_areas_are_painted_in_their_colour_and_lines_in_ink():
    colors = np.full((10, 20, 3), 255, np.uint8)
    area = Mark(np.array([(0, 0), (4, 0), (4, 4), (0, 4)], float), closed=True, color=(10, 200, 30))
    line = Mark(np.array([(6, 4.5), (16, 4.5)]))
    paint_marks(colors, [area, line], np.array([(1, 0, 1), (0, 1, 1)]), ink=(0, 0, 90))
    assert colors[3, 3].tolist() == [10, 200, 30]
    assert colors[5, 12].tolist() == pytest.approx([0, 0, 90], abs=30)
    assert colors[8, 12].tolist() == [255, 255, 255]


def points_of(marks: Sequence[Mark]) -> MultiPoint:
    return MultiPoint(np.concatenate([mark.points for mark in marks]))


@given(st.integers(0, 50))
def test_a_leaf_hangs_at_a_jamb_and_swings_into_one_room(seed):
    marks = mark_doors(FLOOR, "arc", wall=0.15, rng=np.random.default_rng(seed))
    swung = points_of(marks)
    assert len(marks) == 2
    assert (swung.within(SOUTH.buffer(1e-6))) != (swung.within(NORTH.buffer(1e-6)))
    assert swung.distance(MIDDLE_DOOR.line) == pytest.approx(0.075)
    width, height = np.ptp(np.concatenate([mark.points for mark in marks]), axis=0)
    assert (width, height) == pytest.approx((0.9, 0.9))


def test_openings_and_gaps_are_not_marked():
    opening = Floor(FLOOR.rooms, (Door((1, 2), MIDDLE_DOOR.line, 0.9, "opening"),))
    rng = np.random.default_rng(0)
    assert mark_doors(opening, "arc", wall=0.15, rng=rng) == []
    assert mark_doors(FLOOR, "gap", wall=0.15, rng=rng) == []


def test_doors_are_widened_where_the_wall_is_straight_and_long_enough():
    (door,) = widen_doors(FLOOR).doors
    assert door.width == DOUBLE_WIDTH
    assert door.line.length == pytest.approx(DOUBLE_WIDTH)
    assert door.line.centroid.distance(MIDDLE_DOOR.line.centroid) == pytest.approx(0)
    corner = Door((1, 2), LineString([(0.3, 4.075), (1.2, 4.075)]), 0.9)
    assert widen_doors(Floor(FLOOR.rooms, (corner,))).doors == (corner,)


def test_of_two_doors_side_by_side_not_both_are_widened():
    other = Door((1, 2), LineString([(3.5, 4.075), (4.4, 4.075)]), 0.9)
    widths = [door.width for door in widen_doors(Floor(FLOOR.rooms, (MIDDLE_DOOR, other))).doors]
    assert widths == [DOUBLE_WIDTH, 0.9]


def test_a_double_door_has_two_leaves():
    wide = widen_doors(FLOOR)
    marks = mark_doors(wide, "double", wall=0.0, rng=np.random.default_rng(0))
    assert len(marks) == 4
    across, along = sorted(np.ptp(np.concatenate([mark.points for mark in marks]), axis=0))
    assert (across, along) == pytest.approx((DOUBLE_WIDTH / 2, DOUBLE_WIDTH))
    assert len(mark_doors(FLOOR, "double", wall=0.0, rng=np.random.default_rng(0))) == 2


def test_windows_are_in_outer_walls_only():
    windows = find_windows(FLOOR, FOOTPRINT)
    wall = FOOTPRINT.difference(unary_union([SOUTH, NORTH]))
    assert len(windows) == 2 * (2 + 1 + 1)
    assert all(window.line.length == pytest.approx(1.5) for window in windows)
    assert all(wall.contains(window.line) for window in windows)
    assert all(window.line.distance(box(0, 4, 5, 4.15)) > 0.5 for window in windows)
    marks = mark_windows(windows[:1], 3)
    assert len(marks) == 5
    assert points_of(marks).within(FOOTPRINT.buffer(1e-6))


@pytest.mark.parametrize(("label", "lines"), [("STAIRS", 12), ("ELEVATOR", 3), ("OFFICE", 0)])
def test_stairs_and_lifts_stand_in_their_rooms(label, lines):
    marks = mark_room_symbol(Room(1, box(2, 1, 3.6, 5), label))
    assert len(marks) == lines
    assert not marks or points_of(marks).within(box(2, 1, 3.6, 5))


@pytest.mark.slow
@given(st.integers(0, 20))
def test_furniture_keeps_clear(seed):
    blocked = box(3, 1, 5, 3)
    rng = np.random.default_rng(seed)
    marks = mark_furniture(Room(1, SOUTH), [MIDDLE_DOOR], density=1.0, blocked=blocked, rng=rng)
    pieces = GeometryCollection([Polygon(mark.points) for mark in marks])
    assert marks
    assert SOUTH.buffer(-0.09).contains(pieces)
    assert pieces.distance(MIDDLE_DOOR.line) > 1.05
    assert pieces.disjoint(blocked)


def test_there_is_no_furniture_at_density_0():
    nothing = GeometryCollection()
    assert mark_furniture(Room(1, SOUTH), [], density=0.0, blocked=nothing, rng=np.random.default_rng(0)) == []


def test_signs_stand_in_the_passage():
    marks = mark_signs(box(0, 0, 20, 3), np.random.default_rng(0))
    assert points_of(marks).within(box(0, 0, 20, 3))
    assert {mark.color for mark in marks} >= {RED, GREEN}


def test_a_room_too_narrow_for_a_sign_gets_none():
    assert mark_signs(box(0, 0, 6, 0.3), np.random.default_rng(0)) == []


def test_marks_are_placed_by_origin_and_axes():
    (placed,) = place_marks([Mark(np.array([(1.0, 0.0), (0.0, 2.0)]))], (10, 20), (0, 1), (-1, 0))
    assert placed.points == pytest.approx(np.array([(10, 21), (8, 20)]))
    assert Point(placed.points[0]).distance(Point(10, 20)) == pytest.approx(1)
