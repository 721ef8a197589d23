"""A sheet has what its file states and the ink of its pixels, a text its middle and height."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.plan.sheets.sheet import PlacedText, Sheet


def placed(*corners: tuple[float, float]) -> PlacedText:
    return PlacedText("WC", np.array(corners, float))


@pytest.mark.parametrize(
    ("corners", "middle", "height"),
    [
        ([(10, 20), (10, 50), (18, 50), (18, 20)], [14, 35], 8),
        ([(50, 20), (20, 20), (20, 28), (50, 28)], [35, 24], 8),  # read upwards
        ([(18, 50), (18, 20), (10, 20), (10, 50)], [14, 35], 8),  # upside down
        ([(0, 0), (40, 30), (43, 26), (3, -4)], [21.5, 13], 5),  # aslant
        ([(7, 7), (7, 7), (7, 7), (7, 7)], [7, 7], 0),
    ],
)
def test_middle_and_height_follow_the_corners(corners, middle, height):
    text = placed(*corners)
    assert text.middle.tolist() == middle
    assert text.height == height
    assert type(text.height) is float


@given(
    height=st.floats(1, 100),
    width=st.floats(1, 500),
    angle=st.floats(-4, 4),
    shift=st.tuples(*[st.floats(-1000, 1000)] * 2),
)
def test_turning_a_text_moves_no_middle_and_changes_no_height(height, width, angle, shift):
    upright = np.array([(-height, -width), (-height, width), (height, width), (height, -width)]) / 2
    turn = np.array([(np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))])
    text = placed(*(upright @ turn.T + shift))
    assert text.middle == pytest.approx(np.array(shift), abs=1e-6)
    assert text.height == pytest.approx(height, abs=1e-6)


def test_a_picture_has_only_its_pixels():
    sheet = Sheet(np.zeros((2, 3, 3), np.uint8))
    assert (sheet.walls, sheet.texts, sheet.resolution, sheet.source) == (None, None, None, "")
    assert sheet.doors.shape == (0, 2, 2)
    assert placed(*[(0, 0)] * 4).confidence == 1


def test_sheets_and_texts_are_frozen():
    with pytest.raises(FrozenInstanceError):
        Sheet(np.zeros((1, 1, 3), np.uint8)).source = "a"  # type: ignore[misc]
    with pytest.raises(FrozenInstanceError):
        placed(*[(0, 0)] * 4).text = "a"  # type: ignore[misc]
