"""Maps from class maps: thin closed walls, rooms up to the middle of walls, outside unknown."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import ndimage

from pianta._types import Floats
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN
from pianta.plan.walls.floor_map import FINER, FloorMap, draw_floor_map, use_named_walls
from pianta.plan.walls.segmentation import DOOR, INSIDE, OUTSIDE, WALL, ClassMap
from tests.drawn_class_maps import (
    CELL,
    CELL_PX,
    DOORWAY,
    RESOLUTION,
    CellClasses,
    as_class_map,
    draw_classes,
    sheet_shape,
    two_rooms,
)

NONE = np.zeros((0, 2, 2))
JAMBS = np.array([[(112.0, 204.0), (144.0, 204.0)]])


def draw(classes: CellClasses, doors: Floats = NONE) -> FloorMap:
    return draw_floor_map(as_class_map(classes), doors, sheet_shape=sheet_shape(classes), resolution=RESOLUTION)


def free_parts(floor_map: FloorMap) -> list[float]:
    """Areas of connected free space, m², the largest first."""
    labels, count = ndimage.label(floor_map.grid.cells == FREE)
    areas = np.bincount(labels.ravel(), minlength=count + 1)[1:] * floor_map.grid.resolution**2
    return sorted(areas.tolist(), reverse=True)


def test_the_map_has_the_frame_of_the_sheet():
    floor_map = draw(two_rooms())
    assert floor_map.grid.shape == (60 * FINER, 102 * FINER)
    assert floor_map.grid.resolution == pytest.approx(CELL / FINER)
    assert floor_map.grid.origin == pytest.approx((0, 0, 0))
    assert floor_map.height == pytest.approx(6.0)
    assert floor_map.resolution == RESOLUTION


def test_rooms_are_free_walls_thin_and_the_outside_unknown():
    cells = draw(two_rooms(doors=())).grid.cells
    assert [cells[60, 60], cells[60, 150], cells[4, 4], cells[60, 200]] == [FREE, FREE, UNKNOWN, UNKNOWN]
    for line in (cells[60, 90:120], cells[5:30, 60], cells[60, 5:30]):
        assert 1 <= (line == OCCUPIED).sum() <= 3
    walls = np.flatnonzero(cells[60] == OCCUPIED)
    assert walls[[0, -1]] == pytest.approx([18, 186], abs=2)
    assert walls[(walls > 50) & (walls < 150)] == pytest.approx(102, abs=2)


def test_rooms_grow_to_the_middle_of_their_walls():
    areas = free_parts(draw(two_rooms(doors=())))
    assert len(areas) == 2
    assert all(16 < area < 4.2**2 for area in areas)


def test_the_gap_of_a_detected_door_is_closed():
    open_gap = two_rooms()
    assert len(free_parts(draw(open_gap))) == 1
    assert len(free_parts(draw(open_gap, JAMBS))) == 2


@pytest.mark.parametrize(("probability", "length", "rooms"), [(0.5, 5, 2), (0.5, 12, 1), (0.4, 5, 1), (0.58, 12, 2)])
def test_short_faint_pieces_of_walls_are_closed(probability, length, rooms):
    """length: of the faint piece of the wall between the two rooms, in cells of 0.1 m."""
    class_map = as_class_map(two_rooms(doors=()))
    faint = (slice(20, 20 + length), slice(50, 52))
    class_map.probabilities[WALL][faint], class_map.probabilities[INSIDE][faint] = probability, 0.98 - probability
    floor_map = draw_floor_map(class_map, NONE, sheet_shape=sheet_shape(two_rooms()), resolution=RESOLUTION)
    assert len(free_parts(floor_map)) == rooms


def test_a_door_that_the_network_misses_is_closed_by_its_jambs():
    classes = two_rooms()
    top, bottom, left, right = DOORWAY
    classes[top:bottom, left:right] = INSIDE
    assert len(free_parts(draw(classes))) == 1
    assert len(free_parts(draw(classes, JAMBS))) == 2
    elsewhere = JAMBS - (0, 100)
    assert len(free_parts(draw(classes, elsewhere))) == 1


def test_doors_off_the_sheet_change_nothing():
    classes = two_rooms(doors=())
    off = np.array([[(-500.0, -400.0), (-480.0, -400.0)], [(1e5, 2e5), (1e5, 3e5)]])
    assert np.array_equal(draw(classes, off).grid.cells, draw(classes).grid.cells)


def test_a_short_piece_of_a_line_is_no_wall_and_a_long_one_is():
    for length, walls in ((4, False), (20, True)):
        classes = two_rooms(doors=())
        classes[30, 20 : 20 + length] = WALL
        inner = draw(classes).grid.cells[40:80, 34:86]
        assert (inner == OCCUPIED).any() == walls


def test_a_yard_between_rooms_is_no_room():
    classes = draw_classes((60, 140), (10, 50, 10, 50), (10, 50, 52, 92), (10, 50, 94, 134))
    classes[10:50, 52:92] = OUTSIDE
    floor_map = draw(classes)
    assert not floor_map.inside[60, 144]
    assert floor_map.grid.cells[60, 144] == UNKNOWN
    assert len(free_parts(floor_map)) == 2


def test_the_majority_of_cells_decides_about_a_space():
    few, most = two_rooms(doors=()), two_rooms(doors=())
    few[10:50, 10:20] = OUTSIDE
    most[10:50, 10:44] = OUTSIDE
    assert draw(few).inside[60, 24]
    inside = draw(most).inside
    assert not inside[60, [24, 96]].any()
    assert inside[60, 150]


def test_a_room_with_a_gap_to_the_paper_stays_inside():
    classes = two_rooms(doors=())
    classes[14:46, 8:10] = OUTSIDE
    inside = draw(classes).inside
    assert inside[60, [60, 150]].all()
    assert not inside[[4, 60], [60, 2]].any()


def test_a_closet_of_less_than_a_square_metre_is_no_room():
    for side, rooms in ((8, 0), (14, 1)):
        floor_map = draw(draw_classes((60, 60), (20, 20 + side, 20, 20 + side)))
        assert len(free_parts(floor_map)) == rooms


@pytest.mark.parametrize("cell_class", [INSIDE, WALL, DOOR, OUTSIDE])
def test_a_sheet_of_one_class_has_no_walls_and_no_rooms(cell_class):
    floor_map = draw(np.full((40, 40), cell_class))
    assert not (floor_map.grid.cells == OCCUPIED).any()
    assert not floor_map.inside.any()


def test_the_sheet_need_not_be_a_whole_number_of_cells():
    """The last cells of the network extend over the edge of the sheet by up to half a cell."""
    classes = two_rooms()
    floor_map = draw_floor_map(as_class_map(classes), NONE, sheet_shape=(241, 407), resolution=RESOLUTION)
    _, y, _ = floor_map.grid.origin
    assert y + floor_map.grid.shape[0] * floor_map.grid.resolution == pytest.approx(241 * RESOLUTION)


def test_more_paper_around_a_plan_does_not_change_it():
    """Only the surroundings of rooms are drawn."""
    classes = two_rooms(doors=())
    few, much = (
        draw(classes).grid.cells,
        draw(np.pad(classes, ((90, 40), (20, 150)), constant_values=OUTSIDE)).grid.cells,
    )
    there = slice(FINER * 90, -FINER * 40), slice(FINER * 20, -FINER * 150)
    # Which side the middle of a wall belongs to depends on the order of cells
    assert (much[there] != few).mean() < 0.002
    assert (much == FREE).sum() == (much[there] == FREE).sum()
    assert (much == OCCUPIED).sum() == (much[there] == OCCUPIED).sum()


def test_an_outer_wall_of_two_metres_is_a_line_in_its_middle():
    """The drawn part of the sheet has both sides of the wall."""
    classes = draw_classes((120, 120), (40, 80, 40, 80), margin=20)
    walls = np.flatnonzero(draw(classes).grid.cells[60 * FINER] == OCCUPIED) / FINER
    assert walls[[0, -1]] == pytest.approx([30, 90], abs=1.5)


@pytest.mark.slow
@settings(max_examples=20)
@given(st.integers(1, 3), st.integers(-7, 7), st.integers(-6, 6))
def test_turned_and_shifted_class_maps_give_turned_and_shifted_rooms(quarters, down, right):
    plain = np.pad(two_rooms(doors=()), 12, constant_values=OUTSIDE)
    base = draw(plain)
    moved = draw(np.roll(plain, (down, right), (0, 1)))
    # The edge of the sheet is nearer
    assert (moved.inside != np.roll(base.inside, (FINER * down, FINER * right), (0, 1))).mean() < 0.02
    turned = draw(np.rot90(plain, quarters))
    assert turned.grid.shape == turned.inside.shape == (base.inside.shape if quarters == 2 else base.inside.shape[::-1])
    different = turned.inside != np.rot90(base.inside, quarters)
    # Which side the middle of a wall belongs to depends on the order of cells
    assert not ndimage.binary_erosion(different, np.ones((2, 2))).any()
    assert free_parts(turned) == pytest.approx(free_parts(base), rel=0.06)


def test_only_the_walls_that_the_file_names_are_walls():
    class_map = as_class_map(draw_classes((60, 102), (10, 50, 10, 92)))
    walls = np.zeros((240, 408), bool)
    walls[:, 200:208] = True
    named = use_named_walls(class_map, walls).probabilities
    assert named[WALL][:, 50:52] == pytest.approx(1)
    assert named[WALL][:, :50].max() == named[WALL][:, 52:].max() == 0
    assert named.sum(axis=0) == pytest.approx(1, abs=1e-5)
    assert [int(named[:, row, col].argmax()) for row, col in ((30, 20), (2, 2))] == [INSIDE, OUTSIDE]
    assert class_map.probabilities[WALL].max() == pytest.approx(0.94)


def test_the_space_between_the_lines_of_a_wall_is_wall():
    """Faces 0.3 m apart are a wall; 1 m apart, a passage."""
    walls = np.zeros((240, 408), bool)
    walls[40:200, [100, 112]] = True
    walls[40:200, [200, 240]] = True
    wall = use_named_walls(as_class_map(two_rooms()), walls).probabilities[WALL]
    assert wall[30, 26] == pytest.approx(1)
    assert wall[30, 54:58].max() == 0


@given(st.integers(0, 2**32 - 1), st.integers(1, 90), st.integers(1, 90))
def test_probabilities_with_named_walls_sum_to_one_at_every_size_of_sheet(seed, height, width):
    rng = np.random.default_rng(seed)
    shares = rng.dirichlet(np.ones(4), (12, 17)).transpose(2, 0, 1).astype(np.float32)
    named = use_named_walls(ClassMap(shares, CELL_PX), rng.random((height, width)) < 0.1).probabilities
    assert named.shape == shares.shape
    assert named.min() >= 0
    assert named.sum(axis=0) == pytest.approx(1, abs=1e-4)


def test_gaps_longer_than_the_longest_one_stay_in_coarse_maps():
    """Two rooms of 104 m with a gap of 5.2 m between them, in cells of 1.3 m."""
    class_map = as_class_map(two_rooms(doors=()))
    gap = (slice(20, 22), slice(50, 52))
    class_map.probabilities[WALL][gap], class_map.probabilities[INSIDE][gap] = 0.5, 0.48
    floor_map = draw_floor_map(class_map, NONE, sheet_shape=sheet_shape(two_rooms()), resolution=26 * RESOLUTION)
    assert free_parts(floor_map)[0] == pytest.approx(2 * 104**2, rel=0.06)
