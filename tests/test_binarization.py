"""Ink on light and dark paper, in uneven light, beside colours and among noise."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from numpy.typing import NDArray

from pianta._types import Colors, Mask
from pianta.plan.sheets.binarization import binarise, compare_to_paper, invert_if_dark, measure_noise
from pianta.plan.sheets.sheet import Sheet

SIDE = 200
SHEETS = arrays.arrays(np.uint8, st.tuples(st.integers(1, 12), st.integers(1, 12), st.just(3)))


def line_mask(*, width: int = 3) -> Mask:
    """A horizontal and a vertical line that meet; thinner than the reach of paper, which is 5 pixels here."""
    mask = np.zeros((SIDE, SIDE), bool)
    mask[60 : 60 + width, 20:180] = mask[60:160, 20 : 20 + width] = True
    return mask


def paint(mask: Mask, *, ink: int | tuple[int, ...] = 0, paper: int | tuple[int, ...] = 255) -> Colors:
    colors = np.zeros((*mask.shape, 3), np.uint8)
    colors[mask], colors[~mask] = ink, paper
    return colors


def grained(greys: NDArray[np.float64], deviation: float) -> NDArray[np.uint8]:
    noise = np.random.default_rng(0).normal(0, deviation, greys.shape)
    return np.asarray((greys + noise).round().clip(0, 255), np.uint8)


def test_dark_paper_becomes_its_negative():
    blueprint = np.array([[[20, 30, 90], [255, 255, 255], [20, 30, 90]]], np.uint8)
    assert invert_if_dark(blueprint).tolist() == [[[235, 225, 165], [0, 0, 0], [235, 225, 165]]]
    assert invert_if_dark(np.full((1, 1, 3), 99, np.uint8)).tolist() == [[[156, 156, 156]]]


@pytest.mark.parametrize("paper", [(100, 0, 0), (0, 0, 100), (255, 255, 255)])
def test_light_and_strongly_coloured_paper_stays(paper):
    colors = np.array([[paper, (0, 0, 0), paper]], np.uint8)
    assert invert_if_dark(colors).tolist() == colors.tolist()


@pytest.mark.parametrize("step", [4, 5, 11])
def test_hatched_sheets_are_not_dark(step):
    """At every distance of the lines, although only a sample of the pixels of a large sheet is used."""
    colors = np.full((1100, 2000, 3), 255, np.uint8)
    colors[::step] = colors[:, ::step] = 0
    assert (invert_if_dark(colors) == colors).all()


@pytest.mark.parametrize(
    ("paper", "ink"),
    [
        (255, 0),
        (255, 190),
        (255, 240),
        (200, 150),
        (120, 60),
        (0, 255),
        ((20, 30, 90), (230, 230, 255)),
        ((255, 255, 255), (255, 0, 0)),
        ((255, 250, 200), (0, 0, 160)),
    ],
)
def test_lines_on_paper_are_ink_to_the_pixel(paper, ink):
    assert (binarise(paint(line_mask(), ink=ink, paper=paper)) == line_mask()).all()


def test_ink_is_at_least_15_levels_darker_than_its_paper():
    """14 levels are too few."""
    assert not binarise(paint(line_mask(), ink=241)).any()
    assert (binarise(paint(line_mask(), ink=240)) == line_mask()).all()


def test_thin_grey_lines_beside_black_walls_are_ink():
    colors = paint(line_mask())
    colors[100, 40:180] = 185
    expected = line_mask()
    expected[100, 40:180] = True
    assert (binarise(colors) == expected).all()


@pytest.mark.parametrize(
    ("paper", "grey", "ink"), [(255, 89, True), (255, 90, False), (150, 52, True), (150, 53, False)]
)
def test_wide_areas_are_ink_only_if_black_in_the_light_of_the_sheet(paper, grey, ink):
    area = np.zeros((SIDE, SIDE), bool)
    area[50:110, 50:110] = True
    assert (binarise(paint(area, ink=grey, paper=paper)) == (area & ink)).all()


def test_coloured_rooms_are_paper_and_their_walls_ink():
    """Two rooms side by side within walls, one pale, the other without any blue."""
    colors = np.full((SIDE, SIDE, 3), 255, np.uint8)
    colors[40:160, 40:100], colors[40:160, 100:160] = (150, 220, 255), (255, 200, 0)
    walls = np.zeros((SIDE, SIDE), bool)
    for line in (slice(37, 40), slice(160, 163)):
        walls[line, 37:163] = walls[37:163, line] = True
    walls[40:160, 99:102] = True
    colors[walls] = 0
    assert (binarise(colors) == walls).all()


def test_uneven_light_is_no_ink():
    light = np.linspace(255, 140, SIDE).round()[None, :, None].repeat(SIDE, axis=0).repeat(3, axis=2)
    colors = np.asarray(np.where(line_mask()[:, :, None], light * 0.4, light), np.uint8)
    assert (binarise(colors) == line_mask()).all()


@pytest.mark.parametrize("deviation", [3, 8, 12])
def test_grain_is_no_ink_and_hides_no_ink(deviation):
    colors = grained(paint(line_mask(), ink=60, paper=210)[..., 0].astype(float), deviation)[..., None].repeat(
        3, axis=2
    )
    ink = binarise(colors)
    assert ink[line_mask()].all()
    assert ink[~line_mask()].mean() < 0.002


@pytest.mark.parametrize("quality", [10, 50, 90])
def test_ripples_of_jpeg_are_hardly_any_ink(quality):
    """Blocks of 8 pixels ripple beside lines; a few pixels of them may be ink, and none beyond."""
    written = cv2.imencode(".jpg", paint(line_mask()), [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    ink = binarise(np.asarray(cv2.imdecode(written, cv2.IMREAD_COLOR), np.uint8))
    rippled = cv2.dilate(line_mask().astype(np.uint8), np.ones((17, 17), np.uint8)) > 0
    assert ink[line_mask()].all()
    assert not ink[~rippled].any()
    assert (ink & ~line_mask()).sum() < 0.02 * line_mask().sum()


def test_contrast_of_ink_is_full_and_of_paper_none():
    contrast = Sheet(paint(line_mask())).contrast
    assert contrast.dtype == np.float32
    assert (contrast == line_mask()).all()


def test_half_of_full_contrast_separates_ink_from_paper():
    """Half of full contrast is 30 levels without ink, and 14, the minimum, if all ink has one level."""
    colors = paint(line_mask(), ink=248)
    assert np.unique(Sheet(colors).contrast) == pytest.approx([0, 7 / 60])
    colors[100, 40:180] = 234
    assert np.unique(Sheet(colors).contrast).tolist() == [0, 0.25, 0.75]


def test_60_levels_below_the_paper_are_always_ink():
    """A line that fades from black to pale has an Otsu threshold of more than twice as many."""
    faded = np.linspace(0, 235, 160).round().astype(np.uint8)
    colors = paint(line_mask())
    colors[60:160, 20:180] = 255
    colors[60:63, 20:180] = faded[:, None]
    assert (binarise(colors)[61, 20:180] == (255 - faded.astype(int) > 60)).all()


@pytest.mark.parametrize("grey", [0, 99, 100, 255])
def test_an_empty_sheet_has_no_ink(grey):
    assert not binarise(np.full((9, 7, 3), grey, np.uint8)).any()


@given(colors=SHEETS)
def test_contrast_is_a_share_and_contains_the_ink(colors):
    contrast = Sheet(colors).contrast
    ink = binarise(colors)
    assert contrast.shape == ink.shape == colors.shape[:2]
    assert contrast.dtype == np.float32
    assert ink.dtype == np.bool_
    assert ((contrast >= 0) & (contrast <= 1)).all()
    assert ink[contrast > 0.5].all()


@given(colors=SHEETS)
def test_contrast_uint8_is_the_contrast_rounded_down(colors):
    """The networks were trained on it."""
    graded = compare_to_paper(invert_if_dark(colors)).contrast_uint8
    assert graded.dtype == np.uint8
    assert (graded == np.floor(Sheet(colors).contrast * 255)).all()


@given(colors=SHEETS)
def test_light_paper_stays_the_same_array(colors):
    straight = invert_if_dark(colors)
    assert invert_if_dark(straight) is straight


@given(colors=SHEETS, order=st.permutations(range(3)))
def test_the_order_of_channels_does_not_matter(colors, order):
    assert (binarise(colors[..., order]) == binarise(colors)).all()


@given(mask=arrays.arrays(np.bool_, st.tuples(st.integers(1, 12), st.integers(1, 12))))
def test_black_on_white_and_white_on_black_are_what_was_drawn(mask):
    """Up to half of the sheet may be ink; with more, the paper counts as ink."""
    mask = mask if mask.mean() < 0.5 else np.zeros_like(mask)
    assert (binarise(paint(mask)) == mask).all()
    assert (binarise(paint(mask, ink=255, paper=0)) == mask).all()


@given(deviation=st.floats(2, 15))
def test_noise_is_the_deviation_of_the_grain(deviation):
    assert measure_noise(grained(np.full((SIDE, SIDE), 128.0), deviation)) == pytest.approx(deviation, rel=0.1)


def test_lines_and_slopes_are_no_noise():
    grain = grained(np.full((SIDE, SIDE), 128.0), 5)
    slope = np.arange(SIDE, dtype=np.uint8)[None].repeat(SIDE, axis=0)
    assert measure_noise(np.where(line_mask(), np.uint8(0), grain)) == pytest.approx(5, rel=0.15)
    assert measure_noise(slope) == 0
    assert measure_noise(paint(line_mask())[..., 0]) == 0


@pytest.mark.parametrize("paper", [(0, 0, 160), (10, 40, 140), (0, 0, 255), (120, 0, 40)])
def test_blueprints_become_their_grey_negative(paper):
    """Light lines on strong, dark paper are the ink."""
    colors = np.full((200, 200, 3), paper, np.uint8)
    colors[50:53, 20:180] = 255
    ink = binarise(colors)
    assert ink[50:53, 20:180].all()
    assert ink.mean() < 0.05


def test_plans_with_large_coloured_rooms_are_no_blueprints():
    """Dark red rooms cover most of the sheet; its paper is white, and its walls are black."""
    colors = np.full((200, 200, 3), 255, np.uint8)
    colors[20:180, 20:180] = (180, 0, 0)
    colors[20:180, 98:102] = 0
    np.testing.assert_array_equal(invert_if_dark(colors), colors)
