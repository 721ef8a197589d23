"""Hatches: runs of parallel, evenly spaced lines of one width; walls, short runs and uneven lines do not count."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pianta.io.drawings._drawing import PlanDrawing
from pianta.plan.sheets.drawn_sheet import draw_sheet
from pianta.plan.sheets.hatches import MIN_RUN, find_hatches

Lines = NDArray[np.float64]

# A square of 1000 units, so that lines of a hatch are at most 10 apart
SQUARE = np.array([[[0, 0], [1000, 0]], [[1000, 0], [1000, 1000]], [[1000, 1000], [0, 1000]], [[0, 1000], [0, 0.0]]])


def run(count: int, *, spacing: float = 5, start: float = 100, length: float = 50) -> Lines:
    """Level lines above each other."""
    heights = start + spacing * np.arange(count)
    return np.stack([np.stack([np.full(count, x), heights], axis=1) for x in (300.0, 300.0 + length)], axis=1)


def hatches(*parts: Lines) -> list[int]:
    """How many lines of each part are hatches."""
    lines = np.concatenate(parts)
    is_hatch = find_hatches(lines, np.ones(len(lines)))
    return [int(part.sum()) for part in np.split(is_hatch, np.cumsum([len(part) for part in parts])[:-1])]


@pytest.mark.parametrize(
    ("count", "spacing", "expected"), [(20, 5, 20), (MIN_RUN, 5, MIN_RUN), (MIN_RUN - 1, 5, 0), (20, 11, 0)]
)
def test_many_lines_close_together_are_a_hatch(count, spacing, expected):
    assert hatches(SQUARE, run(count, spacing=spacing)) == [0, expected]


def test_uneven_lines_are_none():
    uneven = run(20)
    uneven[:, :, 1] += np.where(np.arange(20) % 2, 2.0, 0.0)[:, None]
    assert hatches(SQUARE, uneven) == [0, 0]


def test_lines_of_another_width_are_not_of_the_run():
    lines = np.concatenate([SQUARE, run(20)])
    widths = np.ones(24)
    widths[4::2] = 2.0
    assert not find_hatches(lines, widths)[:4].any()
    # Each width has 10 lines, 10 units apart
    assert find_hatches(lines, widths)[4:].all()


def test_short_lines_in_the_corner_of_the_area_belong_to_it_and_lines_across_do_not():
    corner = run(1, start=112.5 + 2.5, length=4)
    corner[:, :, 0] += 46
    across = run(1, start=102.3, length=50)
    assert hatches(SQUARE, run(20), corner, across) == [0, 20, 1, 0]


@given(angle=st.floats(0, 2 * np.pi), scale=st.floats(1e-3, 1e3), shift=st.floats(-1e4, 1e4))
def test_hatches_do_not_depend_on_the_frame(angle, scale, shift):
    lines = np.concatenate([SQUARE, run(20)])
    # The extent, to which spacings relate, grows when the square turns
    lines[4:, :, 1] = 100 + (lines[4:, :, 1] - 100) * 0.9
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = scale * (lines @ turn.T) + shift
    assert find_hatches(moved, np.ones(24)).tolist() == [False] * 4 + [True] * 20


def test_hostile_lines_are_refused_quietly(monkeypatch):
    assert not find_hatches(np.zeros((0, 2, 2)), np.zeros(0)).any()
    assert not find_hatches(np.zeros((30, 2, 2)), np.zeros(30)).any()
    assert not find_hatches(np.full((30, 2, 2), 1e12), np.zeros(30)).any()
    monkeypatch.setattr("pianta.plan.sheets.hatches.MAX_PAIRS", 3)
    assert hatches(SQUARE, run(20)) == [0, 0]


def test_a_sheet_is_drawn_without_hatches():
    def draw(lines: Lines) -> NDArray[np.uint8]:
        drawing = PlanDrawing(lines, np.full(len(lines), 3), np.ones(len(lines)), source="plan.pdf")
        return draw_sheet(drawing).colors

    np.testing.assert_array_equal(draw(np.concatenate([SQUARE, run(20)])), draw(SQUARE))
