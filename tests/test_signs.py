"""Signs of any picture are squares of one colour with something white in them; walls lead on behind them."""

import numpy as np
import pytest

from pianta._types import Colors
from pianta.plan.symbols.detection import remove_symbols
from pianta.plan.symbols.poses import PlacedSymbol, is_sign
from pianta.plan.symbols.signs import find_signs
from pianta.plan.symbols.templates import builtin_templates

SIGNS = [template for template in builtin_templates() if is_sign(template)]
WHITE, DARK_RED, GREEN, BLUE = (255, 255, 255), (110, 40, 40), (0, 120, 60), (0, 60, 160)
DOOR_PX = 20.0


def draw_sheet(*corners: tuple[int, int], color: tuple[int, int, int] = DARK_RED, side: int = 22) -> Colors:
    """A white sheet with squares at their upper left corners, each with a picture that no template has."""
    sheet = np.full((120, 160, 3), WHITE, np.uint8)
    for row, col in corners:
        sheet[row : row + side, col : col + side] = color
        sheet[row + side // 3 : row + side // 2, col + 3 : col + side - 3] = WHITE
        sheet[row + 3 : row + side - 4, col + side // 2 : col + side // 2 + 2] = WHITE
    return sheet


def find(sheet: Colors, *, door_px: float = DOOR_PX) -> list[PlacedSymbol]:
    return list(find_signs(sheet, SIGNS, door_px))


@pytest.mark.parametrize("color", [DARK_RED, GREEN])
@pytest.mark.parametrize("door_px", [DOOR_PX, 5.0])
def test_a_square_with_an_unknown_picture_is_a_sign_even_with_a_wrong_door_width(color, door_px):
    (sign,) = find(draw_sheet((40, 60), color=color), door_px=door_px)
    assert sign.kind == "object"
    assert sign.corners.min(axis=0) == pytest.approx([40, 60], abs=2)
    assert sign.corners.max(axis=0) == pytest.approx([62, 82], abs=2)


def test_signs_in_a_row_are_found_one_by_one():
    signs = find(draw_sheet((40, 20), (40, 44), (40, 68)))
    assert sorted(sign.corners[0, 1] for sign in signs) == pytest.approx([20, 44, 68], abs=3)


def test_areas_of_a_colour_and_blue_squares_are_no_signs_of_any_picture():
    area = draw_sheet()
    area[20:42, 20:42] = DARK_RED
    assert find(area, door_px=5.0) == []
    assert find(draw_sheet((40, 60), color=BLUE)) == []
    assert find(draw_sheet((5, 5), side=110)) == []


def test_a_wall_is_drawn_on_behind_a_sign():
    sheet = draw_sheet()
    sheet[48:52] = 0
    sheet[40:62, 60:82] = draw_sheet((40, 60))[40:62, 60:82]
    cleared = remove_symbols(sheet, find(sheet))
    assert (cleared[48:52] == 0).all()
    assert (np.delete(cleared, np.s_[48:52], axis=0) == 255).all()


def test_no_wall_is_drawn_across_a_sign_between_two_walls():
    """A corridor as wide as the sign, whose walls are 4 pixels thick."""
    sheet = draw_sheet((40, 60))
    sheet[:, 54:58] = sheet[:, 84:88] = 0
    cleared = remove_symbols(sheet, find(sheet))
    assert (cleared[:, 58:84] == 255).all()
    assert (cleared[:, 54:58] == 0).all()
