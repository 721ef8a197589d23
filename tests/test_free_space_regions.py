import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta._types import Floats, Mask
from pianta.layout._voronoi_doors import compute_clearance
from pianta.layout.structure.regions import Regions, Separators, cut_into_regions, find_separators, grow_regions
from tests.drawn_maps import carve

SHAPE = (60, 120)
# Two rooms, a wall of 4 cells between them, and a door of 12 cells.
ROOMS = carve(SHAPE, (10, 50, 10, 58), (10, 50, 62, 110), (26, 38, 58, 62))
DOOR = np.array([[[25, 58], [38, 58]]], float)
# One hall with a wall across its upper half, which has a hatch of 4 cells, too small to be a door.
HALL = carve(SHAPE, (10, 50, 10, 58), (10, 50, 62, 110), (30, 50, 58, 62), (14, 18, 58, 62))
HALF_WALL = np.array([[[29, 60], [50, 60]]], float)
HATCH = np.array([[[13, 60], [18, 60]]], float)


def cut(space: Mask, lines: Floats, *, min_clearance: float = 1.0) -> Regions:
    return cut_into_regions(space, compute_clearance(space), lines, min_clearance=min_clearance, resolution=0.05)


def separators_of(space: Mask, lines: Floats) -> tuple[Regions, Separators]:
    regions = cut(space, lines)
    return regions, find_separators(regions, lines)


def test_a_door_cuts_two_rooms_into_two_regions_that_cover_them():
    regions = cut(ROOMS, DOOR)
    assert np.array_equal(regions.labels > 0, ROOMS)
    west, east = regions.labels[30, 20], regions.labels[30, 100]
    assert {west, east} == {1, 2}
    assert (regions.labels[10:50, 10:58] == west).all()
    assert (regions.labels[10:50, 62:110] == east).all()
    assert (regions.labels[26:38, 60:62] == east).all()


def test_regions_have_an_area_and_a_width():
    regions = cut(ROOMS, DOOR)
    assert regions.area.sum() == pytest.approx(ROOMS.sum() * 0.05**2)
    assert regions.area[regions.labels[30, 20]] == pytest.approx(40 * 48 * 0.05**2, rel=0.02)
    # The largest circle touches two walls 40 cells apart.
    assert regions.width.tolist() == pytest.approx([0, 2, 2])


def test_a_slanting_line_cuts_without_a_leak():
    space = carve((60, 60), (10, 50, 10, 50))
    regions = cut(space, np.array([[[9, 15], [50, 40]]], float))
    assert regions.labels.max() == 2
    assert regions.labels[30, 12] != regions.labels[30, 47]


def test_narrow_space_belongs_to_the_nearest_region():
    space = carve(SHAPE, (10, 50, 10, 58), (28, 30, 58, 80))
    regions = cut(space, np.zeros((0, 2, 2)), min_clearance=2.0)
    assert np.array_equal(regions.labels, space.astype(int))


rooms = st.tuples(st.integers(4, 20), st.integers(24, 36), st.integers(4, 20), st.integers(24, 36))
ends = st.tuples(st.integers(0, 39), st.integers(0, 39))


@pytest.mark.slow
@given(st.lists(rooms, min_size=1, max_size=3), st.lists(st.tuples(ends, ends), max_size=5))
def test_regions_cover_the_space_for_any_cuts(spans, lines):
    space = carve((40, 40), *spans)
    all_lines = np.array(lines, float).reshape(-1, 2, 2)
    regions, separators = separators_of(space, all_lines)
    assert np.array_equal(regions.labels > 0, space)
    assert np.array_equal(np.unique(regions.labels[space]), np.arange(1, len(regions.area)))
    assert regions.area == pytest.approx(np.bincount(regions.labels[space], minlength=len(regions.area)) * 0.05**2)
    assert (separators.sides > 0).all()
    assert (separators.sides[:, 0] != separators.sides[:, 1]).all()


@pytest.mark.parametrize("turned", [False, True])
def test_left_and_right_of_a_separator_are_seen_from_its_first_end(turned):
    line = DOOR[:, ::-1] if turned else DOOR
    regions, separators = separators_of(ROOMS, line)
    west, east = regions.labels[30, 20], regions.labels[30, 100]
    # Down the map, the east is on the left.
    assert separators.sides.tolist() == [[west, east] if turned else [east, west]]


def test_the_opening_of_a_separator_is_its_length():
    _, separators = separators_of(ROOMS, DOOR)
    assert separators.opening == pytest.approx([13 * 0.05])


def test_only_lines_between_two_regions_are_separators():
    lines = np.concatenate([HALF_WALL, HATCH])
    regions = cut(HALL, lines)
    west, east = regions.labels[30, 20], regions.labels[30, 100]
    assert find_separators(regions, lines).sides.tolist() == [[east, west], [east, west]]
    assert find_separators(cut(HALL, HALF_WALL), HALF_WALL).sides.shape == (0, 2)


def test_a_line_that_does_not_divide_the_space_is_no_separator():
    regions, separators = separators_of(HALL, HALF_WALL)
    # The two sides are still joined through the hatch.
    assert regions.labels.max() == 1
    assert separators.lines.shape == (0, 2, 2)
    assert separators.sides.shape == (0, 2)


def test_separators_have_the_order_of_their_lines():
    across = np.array([[[30, 58], [30, 110]]], float)
    outside = np.zeros((1, 2, 2))
    _, separators = separators_of(ROOMS, np.concatenate([across, outside, DOOR]))
    assert separators.lines.tolist() == [*across.tolist(), *DOOR.tolist()]


def test_labels_grow_over_all_of_the_space_and_no_further():
    labels = np.zeros((3, 7), np.int32)
    labels[1, 0], labels[1, 6] = 2, 1
    space = carve((3, 7), (1, 2, 0, 7))
    grown = grow_regions(labels, space)
    assert grown[1, [0, 1, 2, 4, 5, 6]].tolist() == [2, 2, 2, 1, 1, 1]
    assert not grown[~space].any()


def test_a_niche_belongs_to_its_own_room_and_not_to_the_one_behind_the_wall():
    # The niche is too narrow to pass, and the other room is only 2 cells away.
    niche = (10, 14, 58, 80)
    space = carve(SHAPE, (10, 50, 10, 58), niche, (16, 50, 62, 110))
    regions = cut(space, np.zeros((0, 2, 2)), min_clearance=3.0)
    assert np.unique(regions.labels[10:14, 58:80]).tolist() == [regions.labels[30, 30]]
    assert regions.labels[30, 100] != regions.labels[30, 30]


def test_an_isolated_gap_that_is_too_narrow_is_in_no_region():
    room = carve(SHAPE, (10, 50, 10, 58))
    regions = cut(room | carve(SHAPE, (10, 50, 61, 64)), np.zeros((0, 2, 2)), min_clearance=3.0)
    assert np.array_equal(regions.labels > 0, room)
    assert regions.area.tolist() == pytest.approx([0, 40 * 48 * 0.05**2])


def test_without_any_region_nothing_grows():
    assert not grow_regions(np.zeros((4, 4), np.int32), np.ones((4, 4), bool)).any()
