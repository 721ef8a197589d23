import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from pianta.layout._working_grid import remove_clutter
from tests.drawn_maps import carve

masks = arrays(bool, array_shapes(min_dims=2, max_dims=2, max_side=12))
sizes = st.floats(0.5, 15)

ROOM = carve((30, 40), (5, 25, 5, 35))


@pytest.mark.parametrize(
    ("obstacle", "stays"),
    [
        ((10, 13, 10, 14), False),  # 3 by 4 cells, 5 across
        ((10, 13, 10, 15), True),
        ((10, 11, 10, 14), False),
        ((10, 11, 10, 16), True),
        ((5, 7, 10, 12), True),  # part of the wall
    ],
)
def test_obstacles_below_the_size_become_free(obstacle, stays):
    free = ROOM & ~carve(ROOM.shape, obstacle)
    cleaned = remove_clutter(free, size_px=5.1)
    assert np.array_equal(cleaned, free if stays else ROOM)


def test_obstacles_that_touch_at_a_corner_are_one():
    free = ROOM & ~carve(ROOM.shape, (10, 12, 10, 12), (12, 14, 12, 14))
    assert np.array_equal(remove_clutter(free, size_px=5), free)
    assert np.array_equal(remove_clutter(free, size_px=6), ROOM)


def test_a_corner_of_the_outside_is_no_clutter():
    free = carve((30, 40), (0, 30, 0, 40)) & ~carve((30, 40), (0, 2, 0, 2))
    assert np.array_equal(remove_clutter(free, size_px=10), free)


@given(masks, sizes, st.integers(1, 3))
def test_unknown_cells_around_the_map_change_nothing(free, size, padding):
    padded = remove_clutter(np.pad(free, padding), size_px=size)
    assert np.array_equal(padded, np.pad(remove_clutter(free, size_px=size), padding))


@given(masks, sizes)
def test_free_cells_stay_free_and_a_second_pass_finds_nothing(free, size):
    cleaned = remove_clutter(free, size_px=size)
    assert cleaned[free].all()
    assert np.array_equal(remove_clutter(cleaned, size_px=size), cleaned)


@given(masks, sizes)
def test_size_counts_in_metres_whatever_the_cells(free, size):
    fine = free.repeat(2, axis=0).repeat(2, axis=1)
    cleaned = remove_clutter(free, size_px=size).repeat(2, axis=0).repeat(2, axis=1)
    assert np.array_equal(remove_clutter(fine, size_px=2 * size), cleaned)
