"""Flights of stairs are found by their treads, and what looks like them is not."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pianta.io.images import read_colors
from pianta.plan.scale.evidence import combine_evidence
from pianta.plan.scale.stairs import PARAMETERS, Flight, find_flights, measure_stairs
from pianta.plan.sheets.sheet import PlacedText, Sheet

BLACK = (0, 0, 0)


def blank(side: int = 400) -> np.ndarray:
    return np.full((side, side, 3), 255, np.uint8)


def draw_flight(
    colors: np.ndarray, *, pitch: int = 12, lines: int = 9, length: int = 44, sides: bool = True, stroke: int = 1
) -> np.ndarray:
    """Level treads from row 100 and column 150 on, between two walls."""
    for row in range(100, 100 + pitch * lines, pitch):
        cv2.line(colors, (150, row), (150 + length, row), BLACK, stroke)
    if sides:
        for col in (148, 150 + length + 2):
            cv2.line(colors, (col, 80), (col, 120 + pitch * lines), BLACK, 4)
    return colors


def find(colors: np.ndarray, *texts: PlacedText) -> list[Flight]:
    sheet = Sheet(colors)
    return find_flights(sheet.contrast, sheet.ink, texts)


def text_at(text: str, row: float, col: float) -> PlacedText:
    return PlacedText(
        text, np.array([(row - 4, col - 10), (row - 4, col + 10), (row + 4, col + 10), (row + 4, col - 10)])
    )


@pytest.mark.parametrize("is_level", [True, False])
def test_a_flight_has_the_pitch_of_its_treads(is_level):
    colors = draw_flight(blank())
    (flight,) = find(colors if is_level else np.ascontiguousarray(colors.transpose(1, 0, 2)))
    assert flight.n_lines == 9
    assert flight.pitch == pytest.approx(12, abs=0.05)
    along, across = (flight.rows, flight.cols) if is_level else (flight.cols, flight.rows)
    assert along == pytest.approx((100, 196), abs=1)
    assert across == pytest.approx((150, 195), abs=3)


def test_lines_of_walking_and_of_a_break_cut_no_flight():
    colors = draw_flight(blank())
    cv2.arrowedLine(colors, (172, 198), (172, 104), BLACK, 1, tipLength=0.05)
    assert [flight.n_lines for flight in find(colors)] == [9]


def test_one_tread_gives_the_scale_roughly():
    """A tread of 0.275 m on 12 pixels."""
    evidence = measure_stairs(find(draw_flight(blank())))
    assert evidence is not None
    assert evidence.text == "the steps of 1 flight of stairs"
    combined = combine_evidence([evidence], low=1e-3, high=1.0)
    assert combined.resolution == pytest.approx(0.275 / 12, rel=0.02)
    # 82 % of the errors of 0.1 between buildings and 0.05 between flights are within 15 %; a fifth may be nonsense
    assert combined.certainty == pytest.approx(0.77 * 0.82, abs=0.04)


@pytest.mark.parametrize(
    "options",
    [
        {"lines": 4},  # a window, a shelf
        {"pitch": 4, "length": 16},  # a hatch
        {"pitch": 12, "length": 240},  # boards across a room
        {"pitch": 24, "length": 48},  # parking lots
        {"pitch": 12, "stroke": 6},  # stripes
        {"sides": False},  # rows of seats
        {"lines": 20, "pitch": 10, "length": 20},  # a radiator
    ],
)
def test_other_even_lines_are_no_flights(options):
    assert find(draw_flight(blank(), **options)) == []


@pytest.mark.parametrize("spacing", [6, 12])
def test_tiles_and_grates_are_no_flights(spacing):
    colors = draw_flight(blank(), length=60)
    for col in range(150 + spacing, 210, spacing):
        cv2.line(colors, (col, 100), (col, 196), BLACK, 1)
    assert find(colors) == []


def test_lines_that_fill_a_space_are_no_flight():
    """Boards of a passage, rows of a table: lines from one end to the other; a flight has a landing."""
    colors = draw_flight(blank())
    for row in (84, 213):
        cv2.line(colors, (148, row), (196, row), BLACK, 4)
        assert len(find(colors)) == (1 if row == 84 else 0)


def test_sheets_with_hatched_floors_show_no_flights():
    """A room with boards of 200 pixels, each 12 pixels wide."""
    colors = draw_flight(blank())
    for row in range(250, 330, 12):
        cv2.line(colors, (150, row), (350, row), BLACK, 1)
    assert find(colors) == []


def test_paler_lines_between_are_a_hatch():
    """Every second line is too pale to be ink, as in hatches of pictures that were made smaller."""
    sheet = Sheet(draw_flight(blank()))
    contrast = sheet.contrast.copy()
    assert len(find_flights(contrast, sheet.ink, ())) == 1
    for row in range(106, 196, 12):
        contrast[row, 150:195] = 0.45
    assert find_flights(contrast, sheet.ink, ()) == []


def test_tables_are_no_flights_but_a_direction_may_be_written_on_one():
    colors = draw_flight(blank())
    assert find(colors, text_at("Wand F90", 130, 170)) == []
    assert len(find(colors, text_at("UP", 130, 170))) == 1


def test_flights_that_disagree_are_no_evidence():
    """Tiers of seats beside stairs."""
    stairs, tier = (Flight((0, 8 * pitch), (0, 40), pitch, 9) for pitch in (10.0, 30.0))
    assert measure_stairs([stairs, tier]) is None
    assert measure_stairs([]) is None
    several = measure_stairs([stairs, stairs, stairs, tier])
    assert several is not None
    assert several.text == "the steps of 3 flights of stairs"
    assert [each.resolutions[0] for each in several.measures] == pytest.approx([0.0275] * 3)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 60))
def test_any_ink_is_searched(seed, side):
    rng = np.random.default_rng(seed)
    ink = rng.random((side, 2 * side)) < 0.4
    assert all(flight.n_lines >= PARAMETERS.min_lines for flight in find_flights(ink.astype(np.float32), ink, ()))


@pytest.mark.parametrize(("name", "pitch"), [("evac_a.png", 13.8), ("f2b_example5.png", 16.5)])
def test_the_stairs_of_real_plans_are_found(data, name, pitch):
    """Pitches by eye: 83 pixels of six treads, and 66 of four."""
    (flight,) = find(read_colors(data / "planfiles/raster" / name))
    assert flight.pitch == pytest.approx(pitch, rel=0.02)
