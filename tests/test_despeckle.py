"""Noise of single cells is removed; what spans two cells stays."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from pianta.gridmap import FREE, OCCUPIED, UNKNOWN
from pianta.layout._despeckle import despeckle

VALUES = {".": FREE, "#": OCCUPIED, "?": UNKNOWN}
maps = arrays(np.int8, array_shapes(min_dims=2, max_dims=2, max_side=12), elements=st.sampled_from([*VALUES.values()]))


def check(drawing: str, expected: str) -> None:
    """The drawing, whose outermost cells go on around it, becomes the expected one."""
    cells = np.pad(np.array([[VALUES[cell] for cell in row] for row in drawing.split()]), 3, mode="edge")
    names = {value: name for name, value in VALUES.items()}
    cleaned = despeckle(cells)[3:-3, 3:-3]
    assert ["".join(names[cell] for cell in row) for row in cleaned.tolist()] == expected.split()


def test_single_obstacles_become_what_is_around_them():
    check("..... ..... ..#.. ..... .....", "..... ..... ..... ..... .....")
    check("????? ????? ??#?? ????? ?????", "????? ????? ????? ????? ?????")


def test_a_single_obstacle_between_free_and_unknown_space_stays():
    """A wall that was seen by a single beam."""
    check("..... ..... ..#.. ????? ?????", "..... ..... ..#.. ????? ?????")


@pytest.mark.parametrize("leg", ["..... .##.. .....", ".#... ..#.. .....", "..... .###. ....."])
def test_obstacles_of_two_cells_and_more_stay(leg):
    """The legs of a table, and the end of a thin wall."""
    drawing = " ".join([".....", *leg.split(), "....."])
    check(drawing, drawing)


def test_a_bump_of_a_wall_is_removed_and_its_corner_stays():
    check("....... ...#... ####### #######", "....... ....... ####### #######")
    check("....... ..#.... ..#.... ####### #######", "....... ..#.... ..#.... ####### #######")


def test_a_hole_in_a_wall_is_filled():
    check("..... ##.## ##### ?????", "..... ##### ##### ?????")
    check("..... ##.## ????? ?????", "..... ##### ????? ?????")
    check("##### ##.## #####", "##### ##### #####")


def test_a_gap_through_a_wall_stays():
    """It may be a door of a map with large cells."""
    drawing = "..... ##.## ..... ....."
    check(drawing, drawing)


def test_free_cells_apart_become_unknown_up_to_four():
    check("?????? ?..??? ?..??? ?????? ??????", "?????? ?????? ?????? ?????? ??????")
    drawing = "?????? ?...?? ?...?? ?????? ??????"
    check(drawing, drawing)


def test_a_free_cell_beside_the_floor_becomes_unknown():
    check("????? ??.?? ..... ..... .....", "????? ????? ..... ..... .....")


def test_an_unknown_cell_in_free_space_becomes_free():
    check("..... ..... ..?.. ..... .....", "..... ..... ..... ..... .....")


@given(maps)
def test_a_cell_changes_only_to_a_value_beside_it(cells):
    changed = despeckle(cells)
    for row, col in np.argwhere(changed != cells):
        assert changed[row, col] in np.pad(cells, 1, constant_values=UNKNOWN)[row : row + 3, col : col + 3]


@given(maps, st.sampled_from(["turn", "mirror"]))
def test_turned_and_mirrored_maps_are_cleaned_alike(cells, how):
    turn = np.rot90 if how == "turn" else np.fliplr
    assert np.array_equal(turn(despeckle(cells)), despeckle(turn(cells)))


@given(maps, st.integers(1, 3))
def test_unknown_cells_around_the_map_change_nothing(cells, width):
    padded = despeckle(np.pad(cells, width, constant_values=UNKNOWN))
    assert np.array_equal(padded[width:-width, width:-width], despeckle(cells))


def test_noise_in_an_empty_hall_is_removed():
    """100 cells of 100 x 100, no two of them beside each other."""
    cells = np.full((100, 100), FREE, np.int8)
    cells[5::10, 5::10] = OCCUPIED
    assert (despeckle(cells) == FREE).all()
