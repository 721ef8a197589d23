"""Doors are found by their swings, at any size and angle; other round shapes are no doors."""

from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray

from pianta.plan.doors.swings import Swing, consensus_door_width, find_swings
from pianta.plan.sheets.sheet import Sheet

Image = NDArray[Any]

SHIFT = 6


def draw_line(sheet: Image, points: ArrayLike, width: int = 1) -> None:
    """A line through points row, col in continuous pixels."""
    cols_and_rows = np.round((np.asarray(points, float)[:, ::-1] - 0.5) * 2**SHIFT).astype(np.int32)
    cv2.polylines(sheet, [cols_and_rows], False, 0, width, cv2.LINE_AA, SHIFT)


def draw_door(
    sheet: Image,
    hinge: ArrayLike,
    radius: float,
    *,
    turn: float = 0.0,
    mirrored: bool = False,
    stroke: int = 2,
    wall: int = 6,
) -> tuple[Image, Image]:
    """A wall through the hinge with a gap of the radius, a leaf, and its arc; turn in degrees."""
    angle = np.radians(turn)
    along = np.array([np.sin(angle), np.cos(angle)])
    up = np.array([-along[1], along[0]]) * (-1 if mirrored else 1)
    pivot = np.asarray(hinge, float)
    for start, stop in ((-2.5, 0), (1, 4)):
        draw_line(sheet, [pivot + start * radius * along, pivot + stop * radius * along], wall)
    draw_line(sheet, [pivot, pivot + radius * up], stroke)
    angles = np.linspace(0, np.pi / 2, 40)[:, None]
    draw_line(sheet, pivot + radius * (np.cos(angles) * along + np.sin(angles) * up), stroke)
    return pivot + radius * along, pivot + radius * up


def blank(height: int = 300, width: int = 300) -> Image:
    return np.full((height, width), 255, np.uint8)


def ink_of(colors: Image) -> Image:
    """Contrast, and full contrast in wide black areas, which are walls."""
    sheet = Sheet(colors)
    return np.asarray(np.maximum(sheet.contrast, sheet.ink))


def contrast_of(sheet: Image) -> Image:
    return ink_of(np.repeat(sheet[:, :, None], 3, axis=2))


@pytest.mark.slow
@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("turn", [0, 90, 180, 270, 30])
def test_a_door_is_found_in_every_pose(turn, mirrored):
    sheet = blank()
    jamb, open_end = draw_door(sheet, (150, 150), 30, turn=turn, mirrored=mirrored)
    (swing,) = find_swings(contrast_of(sheet))
    assert swing.radius == pytest.approx(30, abs=3)
    assert np.hypot(*(swing.hinge - (150, 150))) < 4
    assert np.hypot(*(swing.jamb - jamb)) < 5
    assert np.hypot(*(swing.open_end - open_end)) < 5


@pytest.mark.parametrize(("radius", "stroke", "wall"), [(16, 1, 3), (20, 1, 4), (60, 2, 8), (120, 3, 12)])
def test_a_door_is_found_at_every_size(radius, stroke, wall):
    sheet = blank(9 * radius, 9 * radius)
    jamb, _ = draw_door(sheet, (4 * radius, 4 * radius), radius, stroke=stroke, wall=wall)
    (swing,) = find_swings(contrast_of(sheet))
    assert swing.radius == pytest.approx(radius, rel=0.12)
    assert np.hypot(*(swing.jamb - jamb)) < 0.15 * radius + 1


def test_the_noise_of_jpeg_hides_no_door():
    sheet = blank()
    draw_door(sheet, (150, 150), 30)
    noisy = np.asarray(cv2.imdecode(cv2.imencode(".jpg", sheet, [cv2.IMWRITE_JPEG_QUALITY, 40])[1], 0))
    (swing,) = find_swings(contrast_of(noisy))
    assert swing.radius == pytest.approx(30, abs=2)


def test_both_leaves_of_a_double_door_are_found():
    sheet = blank()
    draw_line(sheet, [(150, 30), (150, 110)], 6)
    draw_line(sheet, [(150, 170), (150, 270)], 6)
    for hinge, side in ((110, 1), (170, -1)):
        angles = np.linspace(0, np.pi / 2, 40)
        draw_line(sheet, np.column_stack([150 - 30 * np.sin(angles), hinge + side * 30 * np.cos(angles)]), 2)
        draw_line(sheet, [(150, hinge), (120, hinge)], 2)
    swings = find_swings(contrast_of(sheet))
    assert len(swings) == 2
    assert all(swing.radius == pytest.approx(30, abs=4) for swing in swings)


def draw_table(sheet: Image) -> None:
    cv2.circle(sheet, (150, 150), 30, 0, 2, cv2.LINE_AA)


def draw_table_at_wall(sheet: Image) -> None:
    draw_line(sheet, [(150, 20), (150, 280)], 6)
    cv2.circle(sheet, (150, 118), 30, 0, 2, cv2.LINE_AA)


def draw_rounded_desk(sheet: Image) -> None:
    draw_line(sheet, [(20, 60), (280, 60)], 6)
    cv2.ellipse(sheet, (150, 150), (40, 40), 0, 180, 270, 0, 2, cv2.LINE_AA)
    draw_line(sheet, [(110, 150), (110, 250)], 2)
    draw_line(sheet, [(150, 110), (250, 110)], 2)


def draw_text(sheet: Image) -> None:
    cv2.putText(sheet, "OFFICE 108", (20, 100), cv2.FONT_HERSHEY_SIMPLEX, 1.2, 0, 2, cv2.LINE_AA)
    cv2.putText(sheet, "BOARD ROOM", (20, 200), cv2.FONT_HERSHEY_DUPLEX, 1.0, 0, 1, cv2.LINE_AA)


def draw_disk(sheet: Image) -> None:
    cv2.circle(sheet, (150, 150), 30, 0, -1, cv2.LINE_AA)


def draw_room(sheet: Image) -> None:
    cv2.rectangle(sheet, (50, 50), (250, 250), 0, 5)
    draw_line(sheet, [(50, 150), (250, 150)], 5)


@pytest.mark.slow
@pytest.mark.parametrize(
    "draw", [draw_table, draw_table_at_wall, draw_rounded_desk, draw_text, draw_disk, draw_room, lambda sheet: None]
)
def test_other_round_shapes_are_no_doors(draw):
    sheet = blank()
    draw(sheet)
    assert find_swings(contrast_of(sheet)) == ()
    assert consensus_door_width(find_swings(contrast_of(sheet))) is None


@pytest.mark.slow
@settings(max_examples=15)
@given(st.integers(100, 180), st.integers(100, 180), st.integers(0, 3))
def test_shifts_and_quarter_turns_of_a_sheet_turn_its_doors(row, col, quarters):
    sheet = blank()
    draw_door(sheet, (row, col), 25)
    (swing,) = find_swings(contrast_of(np.rot90(sheet, quarters)))
    hinge = np.array([row, col], float)
    for _ in range(quarters):
        hinge = np.array([300 - hinge[1], hinge[0]])
    assert np.hypot(*(swing.hinge - hinge)) < 4
    assert swing.radius == pytest.approx(25, abs=2.5)


def test_the_width_is_that_of_most_doors():
    sheet = blank(500, 900)
    for number in range(5):
        draw_door(sheet, (120, 120 + 160 * number), 20)
    draw_door(sheet, (350, 300), 45)
    size = consensus_door_width(find_swings(contrast_of(sheet)))
    assert size is not None
    assert size.px == pytest.approx(20, abs=1.5)
    assert 4 <= size.count <= 5
    assert 0.2 < size.confidence < 1


def make_swing(radius: float, score: float = 1.0) -> Swing:
    return Swing(np.zeros(2), np.array([0.0, radius]), np.array([-radius, 0.0]), radius, score)


def test_fewer_than_three_swings_that_agree_give_no_width():
    assert consensus_door_width([make_swing(20), make_swing(21)]) is None
    assert consensus_door_width([make_swing(20), make_swing(40), make_swing(80)]) is None
    agreed = consensus_door_width([make_swing(radius) for radius in (19.0, 20.0, 21.0)])
    assert agreed is not None
    assert (agreed.px, agreed.count) == (20.0, 3)
    assert agreed.confidence == pytest.approx(3 / 5)


def test_more_doors_that_agree_are_more_certain():
    few, many = (consensus_door_width([make_swing(20.0)] * count) for count in (3, 12))
    assert few is not None
    assert many is not None
    assert few.confidence < many.confidence < 1


def test_ink_serves_as_contrast_and_small_sheets_have_no_swings():
    sheet = blank()
    draw_door(sheet, (150, 150), 30)
    assert len(find_swings(sheet < 128)) == 1
    assert find_swings(np.zeros((8, 100), bool)) == ()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "least", "most"), [("off2.jpg", 37, 44), ("village.png", 15, 20)])
def test_doors_of_real_plans_have_their_width(data, name, least, most):
    colors = np.asarray(cv2.imread(str(data / "floorplans" / name)))
    size = consensus_door_width(find_swings(ink_of(colors)))
    assert size is not None
    assert least < size.px < most
