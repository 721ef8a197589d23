"""Lengths, sizes and scales in the texts of plans."""

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta._types import Mask
from pianta.plan.sheets.sheet import PlacedText, PlanScale
from pianta.plan.text import dimensions
from pianta.plan.text.dimensions import (
    parse_length,
    parse_scale_bar,
    parse_size,
    remove_measures,
)

NO_INK = np.zeros((200, 400), bool)


def number(text: str, col: float, *, row: float = 100.0, height: float = 10.0) -> PlacedText:
    """A text whose middle lies at row and col."""
    top, bottom, half = row - height / 2, row + height / 2, 3.0 * len(text)
    left, right = col - half, col + half
    return PlacedText(text, np.array([(top, left), (top, right), (bottom, right), (bottom, left)]))


@pytest.mark.parametrize(
    ("text", "metres"),
    [
        ("12'-6\"", 3.81),
        ("12' 6”", 3.81),
        ("12'", 3.6576),
        ("12′6″", 3.81),
        ("9' - 6 1/2\"", 2.9083),
        ("10 ft", 3.048),
        ("12.5 feet", 3.81),
        ("3.50 m", 3.5),
        ("3,5m", 3.5),
        ("350 cm", 3.5),
        ("3500 mm", 3.5),
        ("12,50", 12.5),
        ("3.125", 3.125),
        ("350", None),
        ("3.5", None),
        ("204", None),
        ("0 m", None),
        ("5000 m", None),
        ("AULA 3 m", None),
        ("11' x 10'", None),
        ("", None),
    ],
)
def test_lengths(text, metres):
    assert parse_length(text) == (None if metres is None else pytest.approx(metres))


@given(st.integers(1, 400), st.integers(0, 11))
def test_feet_and_inches_add_up(feet, inches):
    assert parse_length(f"{feet}'-{inches}\"") == pytest.approx(0.3048 * feet + 0.0254 * inches)


@pytest.mark.parametrize(
    ("text", "size"),
    [
        ("11' x 10'", (3.3528, 3.048)),
        ("11'×10'", (3.3528, 3.048)),
        ("11'-6\" X 10'", (3.5052, 3.048)),
        ("24 x 30 ft", (7.3152, 9.144)),
        ("3.50 x 4,20 m", (3.5, 4.2)),
        ("350 x 420 cm", (3.5, 4.2)),
        ("3,50 x 4,20", (3.5, 4.2)),
        ("24 X 30", None),
        ("12", None),
        ("2 x 3 x 4 m", None),
        ("box", None),
    ],
)
def test_sizes(text, size):
    assert parse_size(text) == (None if size is None else pytest.approx(size))


@pytest.mark.parametrize(
    ("text", "left"),
    [
        ("BEDROOM 11' x 10'", "BEDROOM"),
        ("Office 12.5 m²", "Office"),
        ("AULA 3 - 45,20 mq", "AULA 3"),
        ("24 X 30", ""),
        ("11' - 9\"", ""),
        ("120 SF", ""),
        ("350 cm", ""),
        ("AULA 3", "AULA 3"),
        ("204 French", "204 French"),
        ("Boys' Toilet", "Boys' Toilet"),
        ("4 Maxim x", "4 Maxim x"),
        ("3 m-room", "3 m-room"),
    ],
)
def test_measures_are_removed_from_names(text, left):
    assert remove_measures(text) == left


def test_a_bar_below_its_numbers_gives_metres_per_pixel():
    ink = NO_INK.copy()
    ink[112:115, 100:301] = True
    texts = [number(text, col) for text, col in (("0", 100), ("5", 203), ("10", 297))]
    scale = parse_scale_bar([*texts, number("m", 330)], ink)
    assert scale is not None
    assert scale.resolution == pytest.approx(10 / 201)
    assert scale.confidence > 0.9


def read_bar(ink: Mask, *texts: tuple[str, float]) -> PlanScale | None:
    """The scale of a bar below texts of a height of 10 at row 100; texts: with their columns."""
    return parse_scale_bar([number(text, col) for text, col in texts], ink)


def test_a_bar_may_lack_its_zero_and_have_one_wrong_number():
    texts = [number(text, col) for text, col in (("20", 140), ("40", 180), ("8", 220), ("80", 260))]
    unit = number("Scale in feet", 180, row=80)
    ink = NO_INK.copy()
    ink[112:114, 100:260] = True
    ink[112:114, 300:400] = True
    scale = parse_scale_bar([unit, *texts], ink)
    assert scale is not None
    assert scale.resolution == pytest.approx(80 * 0.3048 / 160)
    assert scale.confidence > 0.9
    assert parse_scale_bar([unit, *texts], NO_INK) is None
    assert parse_scale_bar(texts, ink) is None


def blocks(ink: Mask, *spans: tuple[int, int], top: int = 112, height: int = 5) -> Mask:
    for left, right in spans:
        ink[top : top + height, left:right] = True
    return ink


# Bars of 10 m from column 100 to column 300 in several styles, all 0.05 m per pixel.
CHEQUERED = blocks(blocks(NO_INK.copy(), (100, 150), (200, 250)), (150, 200), (250, 300), top=117)
ALTERNATING = blocks(NO_INK.copy(), (100, 150), (200, 250))
TWO_PARTS = blocks(blocks(NO_INK.copy(), (100, 200)), (200, 300), height=1)
TICKS = blocks(blocks(NO_INK.copy(), (60, 341), top=116, height=1), (100, 101), (200, 201), (300, 301))
EXTENDED = blocks(blocks(NO_INK.copy(), (80, 100), (100, 300), height=2), (90, 100), (200, 300))


@pytest.mark.parametrize("last", ["10", "10m", "10 m", "10 Meter"])
@pytest.mark.parametrize(
    "ink", [CHEQUERED, ALTERNATING, TWO_PARTS, TICKS, EXTENDED], ids=["chequer", "gaps", "two", "ticks", "extended"]
)
def test_bars_of_several_parts_are_exact(ink, last):
    """The last number is alone at its mark with the unit behind it, or one text with its unit."""
    for col in (300 + 3 * (len(last) - 2), 300):
        scale = read_bar(ink, ("0", 101), ("5", 199), (last, col), *([("m", 350)] if last == "10" else []))
        assert scale is not None
        assert scale.resolution == pytest.approx(0.05, rel=0.012)
        assert scale.confidence > 0.9


def test_a_bar_beside_its_numbers_is_read_at_every_size():
    for factor in (1, 2, 5):
        ink = np.kron(TICKS, np.ones((factor, factor), bool))
        texts = [
            number(text, factor * col, row=factor * 100, height=10 * factor)
            for text, col in (("0", 102), ("5", 202), ("10", 302), ("m", 340))
        ]
        scale = parse_scale_bar(texts, ink)
        assert scale is not None
        assert scale.resolution == pytest.approx(0.05 / factor, rel=0.005)


def test_a_bar_that_does_not_agree_with_its_numbers_is_not_trusted():
    """The line is 15 % longer than the distance of the numbers; only the numbers count, with low confidence."""
    texts = ("0", 100), ("5", 200), ("10", 300), ("m", 340)
    scale = read_bar(blocks(NO_INK.copy(), (85, 315)), *texts)
    assert scale is not None
    assert scale.resolution == pytest.approx(0.05)
    assert scale.confidence < 0.5
    assert read_bar(blocks(NO_INK.copy(), (85, 315)), ("0", 100), ("10", 300), ("m", 340)) is None


WALL = blocks(NO_INK.copy(), (0, 400))
TABLE = blocks(NO_INK.copy(), (100, 300), height=28)
ROOMS = blocks(NO_INK.copy(), (50, 150), (152, 250), (252, 350))


@pytest.mark.parametrize(
    ("ink", "texts"),
    [
        (WALL, [("5 m", 200)]),
        (WALL, [("0", 100), ("10 m", 300)]),
        (TABLE, [("0", 100), ("10 m", 300)]),
        (NO_INK, [("0", 100), ("10 m", 300)]),
        (ROOMS, [("1", 100), ("2", 200), ("3", 300), ("4.20 m", 350)]),
        (ROOMS, [("1", 100), ("2", 200), ("3", 300), ("m", 350)]),
        (ROOMS, [("3 m", 100), ("4 m", 200), ("5 m", 300)]),
        (blocks(NO_INK.copy(), (20, 300)), [("20", 100), ("30", 200), ("40 m", 300)]),
    ],
)
def test_numbers_beside_walls_are_no_bar(ink, texts):
    assert read_bar(ink, *texts) is None


def test_a_unit_may_follow_the_last_number():
    corners = np.array([(95, 100), (95, 200), (105, 200), (105, 100)], float)
    texts = [number("0", 100), number("5", 150), number("10m", 200)]
    scale = parse_scale_bar(texts, NO_INK)
    assert scale is not None
    # The unit moves the middle of the text; the number is at its share of the text.
    assert scale.resolution == pytest.approx(0.1, rel=0.05)
    row = parse_scale_bar([PlacedText("0    5    10 m", corners)], NO_INK)
    assert row is not None
    assert 0.1 < row.resolution < 0.2


@pytest.mark.parametrize(
    "texts",
    [
        [],
        [number("0", 100), number("5", 150), number("10", 200)],
        [number("5 m", 150)],
        [number("201", 100), number("202", 150), number("m", 180)],
        [number("0", 100), number("5", 150), number("7", 250), number("10", 300), number("20", 350), number("m", 370)],
        [number("0", 100), number("5", 150), number("10", 200), number("Room M", 220)],
        [number("0", 100), number("50000", 150), number("100000", 200), number("m", 220)],
    ],
)
def test_other_numbers_are_no_scale_bar(texts):
    assert parse_scale_bar(texts, NO_INK) is None


def test_a_tall_number_on_the_line_of_a_bar_does_not_belong_to_it():
    """It is at the position of 12.5; the bar is sought within some heights of the other numbers."""
    texts = [number("0", 101), number("5", 201), number("10", 301), number("m", 330)]
    scale = parse_scale_bar([*texts, number("12.5", 351, height=100)], TICKS)
    assert scale is not None
    assert scale.resolution == pytest.approx(0.05, rel=0.005)
    assert scale.confidence > 0.9


@pytest.fixture
def windows(monkeypatch) -> list[tuple[int, ...]]:
    """The shapes of the windows that are searched for bars."""
    searched: list[tuple[int, ...]] = []
    search = cv2.connectedComponentsWithStats

    def record(window, **options):
        searched.append(window.shape)
        return search(window, **options)

    monkeypatch.setattr(cv2, "connectedComponentsWithStats", record)
    return searched


def test_a_number_as_tall_as_the_sheet_does_not_enlarge_the_search(windows):
    """Each row begins with two small numbers and a unit above them."""
    texts = []
    for row in range(20, 190, 15):
        texts += [number("0", 100, row=row, height=4), number("5", 150, row=row, height=4)]
        texts += [number("10", 200, row=row, height=200), number("m", 125, row=row - 5, height=4)]
    parse_scale_bar(texts, NO_INK)
    # Two paddings, and BAR_REACH of 4 on both sides.
    assert windows
    assert max(height for height, _ in windows) <= 2 + 2 * 3 * 4


def test_few_of_many_rows_are_searched(windows):
    texts = [
        number(text, col, row=4 * row, height=4)
        for row in range(1, 50)
        for text, col in (("0", 100), ("5", 150), ("10m", 200))
    ]
    assert parse_scale_bar(texts, NO_INK) is not None
    # Numbers at their share of a text, and in the middle of the text.
    assert len(windows) == 2 * dimensions.MAX_ROWS


@pytest.mark.slow
@pytest.mark.parametrize("bar_row", [100, 1350])
@pytest.mark.parametrize(
    "bar",
    [
        [("0", 100), ("5", 200), ("10", 300), ("m", 340)],
        [("2.5", 150), ("5", 200), ("10m", 300)],
    ],
    ids=["from zero", "one unit"],
)
def test_a_bar_is_found_among_many_rows_of_rooms_and_dimensions(bar, bar_row):
    ink = blocks(np.zeros((1400, 400), bool), (100, 300), top=bar_row + 12)
    texts = []
    for row in range(200, 1300, 20):
        first, unit = (row, "") if row % 40 else (3, " m")
        texts += [number(f"{first + step}{unit}", 60 + 60 * step, row=row) for step in range(5)]
    scale = parse_scale_bar([*texts, *(number(text, col, row=bar_row) for text, col in bar)], ink)
    assert scale is not None
    assert scale.resolution == pytest.approx(0.05)
    assert scale.confidence > 0.9


@given(st.text(max_size=40))
def test_any_text_is_parsed_without_error(text):
    for length in (parse_length(text), *(parse_size(text) or ())):
        assert length is None or length >= 0
    assert len(remove_measures(text)) <= len(text)
