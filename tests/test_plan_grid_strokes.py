"""Grids are taken off a sheet, walls are not."""

import cv2
import numpy as np
import pytest

from pianta._types import Colors
from pianta.plan.sheets.sheet import Sheet
from pianta.plan.walls.grid_strokes import erase_grid

SPACING = 70  # px


def draw_plan(*, columns: int = 8, rows: int = 6, uneven: int = 0, gap: int = 0) -> Colors:
    """Two rooms with walls of 8 px on a grid of lines of 1 px; uneven: px by which every other line is shifted."""
    colors = np.full((500, 700, 3), 255, np.uint8)
    for number in range(columns):
        col = 60 + number * SPACING + uneven * (number % 2)
        colors[40:460, col] = 120
    for number in range(rows):
        row = 50 + number * SPACING + uneven * (number % 2)
        colors[row, 40:660] = 120
        if gap:
            # Dashes
            for start in range(40, 660, 10 * gap):
                colors[row, start : start + gap] = 255
    for left, right in ((100, 330), (330, 600)):
        cv2.rectangle(colors, (left, 80), (right, 430), (0, 0, 0), 8)
    return colors


@pytest.mark.parametrize("gap", [0, 4], ids=["lines", "dashes"])
def test_a_grid_is_erased_and_walls_stay(gap):
    erased = erase_grid(Sheet(draw_plan(gap=gap))).colors
    walls = np.zeros(erased.shape[:2], np.uint8)
    for left, right in ((100, 330), (330, 600)):
        cv2.rectangle(walls, (left, 80), (right, 430), 1, 8)
    assert (erased[walls > 0] == 0).all()
    far = cv2.dilate(walls, np.ones((9, 9), np.uint8)) == 0
    assert (erased[far] == 255).all()


@pytest.mark.parametrize(
    "shape",
    [{"columns": 3}, {"rows": 4}, {"uneven": 25}],
    ids=["few columns", "few rows", "uneven"],
)
def test_lines_that_are_no_grid_stay(shape):
    sheet = Sheet(draw_plan(**shape))
    assert erase_grid(sheet) is sheet


def test_a_blank_sheet_stays():
    sheet = Sheet(np.full((50, 60, 3), 255, np.uint8))
    assert erase_grid(sheet) is sheet
