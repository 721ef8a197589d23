"""Dimension lines are taken off a sheet, walls are not."""

import cv2
import numpy as np
import pytest

from pianta._types import Colors
from pianta.plan.sheets.sheet import PlacedText, Sheet
from pianta.plan.walls.dimension_strokes import erase_dimension_lines

PAPER, BLACK = 255, 0
WALL_PX = 8


def placed(text: str, row: float, col: float, *, height: float = 12.0, is_upright: bool = False) -> PlacedText:
    """A text with its middle at a row and col, 8 pixels a letter."""
    half, up = 4.0 * len(text), height / 2
    corners = np.array([[-up, -half], [-up, half], [up, half], [up, -half]])
    if is_upright:
        corners = np.array([[half, -up], [-half, -up], [-half, up], [half, up]])
    return PlacedText(text, corners + np.array([row, col]))


def draw_room(*, line_px: int = 1) -> Colors:
    """A room of 400 × 300 pixels with a dimension line from wall to wall each way, and one outside."""
    colors = np.full((440, 560, 3), PAPER, np.uint8)
    cv2.rectangle(colors, (80, 60), (480, 360), (BLACK,) * 3, WALL_PX)
    for (col0, row0), (col1, row1) in [((80, 120), (480, 120)), ((140, 60), (140, 360)), ((80, 400), (480, 400))]:
        cv2.line(colors, (col0, row0), (col1, row1), (BLACK,) * 3, line_px)
        for col, row in [(col0, row0), (col1, row1)]:
            cv2.line(colors, (col - 5, row + 5), (col + 5, row - 5), (BLACK,) * 3, 2)
    return colors


TEXTS = (placed("4000", 110, 300), placed("3000", 220, 130, is_upright=True), placed("4000", 390, 300))


def test_lines_that_agree_on_the_scale_are_erased_and_walls_stay():
    colors = draw_room()
    erased = erase_dimension_lines(Sheet(colors), TEXTS).colors
    assert (erased[120, 160:470] == PAPER).all()
    assert (erased[130:350, 140] == PAPER).all()
    assert (erased[400, 100:460] == PAPER).all()
    walls = np.zeros(colors.shape[:2], np.uint8)
    cv2.rectangle(walls, (80, 60), (480, 360), 1, WALL_PX - 2)
    assert (erased[walls > 0] == BLACK).all()


@pytest.mark.parametrize(
    "texts",
    [TEXTS[:2], (placed("4000", 110, 300), placed("7000", 220, 130, is_upright=True), placed("9000", 390, 300))],
    ids=["two lines", "lines that disagree"],
)
def test_lines_that_state_no_common_scale_stay(texts):
    colors = draw_room()
    assert (erase_dimension_lines(Sheet(colors), texts).colors == colors).all()


def test_lines_as_thick_as_walls_stay():
    colors = draw_room(line_px=5)
    assert (erase_dimension_lines(Sheet(colors), TEXTS).colors == colors).all()


def test_light_lines_on_dark_paper_are_erased():
    erased = erase_dimension_lines(Sheet(255 - draw_room()), TEXTS).colors
    assert (erased[120, 160:470] == 0).all()
