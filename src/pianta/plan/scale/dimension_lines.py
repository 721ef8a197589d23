"""Dimension lines, a length beside a line that ends at two ticks, arrows or walls; and the scale by them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.io._files import count_noun
from pianta.plan.scale.evidence import Measure, ScaleEvidence
from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.text.sizes import parse_possible_lengths

_WHOLE_NUMBER = re.compile(r"\d{3,6}")
MAX_LENGTHS = 400  # texts of a sheet that may be dimensions, for time


@dataclass(frozen=True, kw_only=True)
class DimensionLineParameters:
    """Thresholds and errors of dimension lines; heights are those of the text. Chosen by hand."""

    reach: float = 1.8  # heights from the middle of the text to its line, at most
    min_reach: float = 0.3  # heights: nearer ink is the text itself
    tick: float = 0.35  # heights on both sides of the line that a tick, an arrow or a wall covers
    min_length: float = 1.5  # heights of a line, which is also longer than its text
    max_tick_px: int = 3  # of the stroke of a tick: thicker marks are walls or hatches, and lines end at their faces
    max_mark: float = 2.5  # heights along the line: a longer mark is a wall or another line beside it
    min_rounded: float = 0.6  # share of the whole numbers of a sheet that end in 0 or 5, if they are dimensions
    n_marks: int = 3  # on each side of the text that may be the end of its line
    # Errors of each line, and of all together, as of a picture that was stretched, or of faces that are drawn thick
    line_sd: float = 0.015
    line_px: float = 1.5
    common_sd: float = 0.01
    common_px: float = 1.0
    outlier_rate: float = 0.4
    failure_rate: float = 0.05  # of one line, and less of several: lines are misread one by one


PARAMETERS = DimensionLineParameters()


@dataclass(frozen=True, eq=False)
class DimensionLine:
    """A line beside a written length.

    row: of the line, start, stop: its first column and the one after its last; of an upright line, which is turned,
    rows and columns change places. text_height: pixels. lengths: metres that the text may mean. pixels: between two
    marks of the line, several if other lines cross it.
    """

    row: int
    start: int
    stop: int
    is_level: bool
    text_height: float
    lengths: tuple[float, ...]
    pixels: tuple[float, ...]

    @property
    def resolutions(self) -> tuple[float, ...]:
        """Metres per pixel that the line may mean."""
        return tuple(metres / px for metres in self.lengths for px in self.pixels)


def list_dimension_lines(texts: Sequence[PlacedText], ink: Mask) -> list[DimensionLine]:
    """The dimension lines of a sheet. ink: shape (H, W)."""
    dimensions = [
        (text, lengths) for text in _without_room_numbers(texts) if (lengths := parse_possible_lengths(text.text))
    ]
    lines = []
    for text, lengths in dimensions[:MAX_LENGTHS]:
        along = np.abs(text.corners[1] - text.corners[0])
        is_level = bool(along[1] >= along[0])
        # A text that is turned stands beside an upright line
        placed, turned = (text, ink) if is_level else (_transpose(text), ink.T)
        if (line := _find_line(placed, turned)) is not None:
            row, run = line
            pixels = _between_marks(turned, row, run, round(float(placed.middle[1])), text.height)
            lines.append(DimensionLine(row, *run, is_level, text.height, lengths, pixels))
    return lines


def measure_dimension_lines(lines: Sequence[DimensionLine]) -> ScaleEvidence | None:
    """The scale by dimension lines; None without any that ends at two marks."""
    p = PARAMETERS
    ended = [line for line in lines if line.pixels]
    if not ended:
        return None
    lengths = [float(np.median(line.pixels)) for line in ended]
    measures = tuple(
        Measure(line.resolutions, hypot(p.line_sd, p.line_px / length))
        for line, length in zip(ended, lengths, strict=True)
    )
    common_sd = hypot(p.common_sd, p.common_px / float(np.median(lengths)))
    title = count_noun(len(measures), "dimension line")
    return ScaleEvidence(title, measures, common_sd, p.outlier_rate, p.failure_rate / len(measures))


def _without_room_numbers(texts: Sequence[PlacedText]) -> Sequence[PlacedText]:
    """The texts without whole numbers, unless these are dimensions.

    Most dimensions end in 0 or 5, as a fifth of the numbers of rooms.
    """
    numbers = [text for text in texts if _WHOLE_NUMBER.fullmatch(text.text.strip())]
    even = sum(text.text.strip()[-1] in "05" for text in numbers)
    if even >= PARAMETERS.min_rounded * len(numbers):
        return texts
    return [text for text in texts if text not in numbers]


def _find_line(text: PlacedText, ink: Mask) -> tuple[int, tuple[int, int]] | None:
    """The row and the columns of the line above or below a level text, the nearer one; None without a line."""
    p, height = PARAMETERS, text.height
    middle_row, middle_col = text.middle
    col, half = round(float(middle_col)), float(np.ptp(text.corners[:, 1])) / 2
    near, far = round(p.min_reach * height), round(p.reach * height)
    for offset in sorted(range(-far, far + 1), key=abs):
        row = round(float(middle_row)) + offset
        if abs(offset) < near or not (0 <= row < ink.shape[0] and 0 <= col < ink.shape[1] and ink[row, col]):
            continue
        start, stop = _run_around(ink[row], col)
        if stop - start > max(2 * half, p.min_length * height):
            return row, (start, stop)
    return None


def _transpose(text: PlacedText) -> PlacedText:
    corners = text.corners[:, ::-1]
    # The shorter side stays the height of the line
    return PlacedText(text.text, np.asarray(corners), text.confidence)


def _run_around(line: Mask, col: int) -> tuple[int, int]:
    """The first column of the ink around a column, and the one after the last."""
    blank = np.flatnonzero(~line)
    before, after = blank[blank < col], blank[blank > col]
    return (int(before[-1]) + 1 if len(before) else 0), (int(after[0]) if len(after) else len(line))


def _between_marks(ink: Mask, row: int, run: tuple[int, int], col: int, height: float) -> tuple[float, ...]:
    """Pixels between marks on both sides of a column, on the line of a row; the ends of the line are marks."""
    p = PARAMETERS
    tick = max(3, round(p.tick * height))
    if row < tick or row + tick >= ink.shape[0]:
        return ()
    start, stop = max(run[0] - tick, 0), min(run[1] + tick, ink.shape[1])
    # A slash crosses the line with its two ends apart
    sides = [_widen(ink[row + side * tick, start:stop], tick) for side in (-1, 1)]
    both = np.flatnonzero(sides[0] & sides[1]) + start
    groups = np.split(both, np.flatnonzero(np.diff(both) > 1) + 1) if len(both) else []
    short = [group for group in groups if len(group) <= p.max_mark * height + 2 * tick]
    marks: Floats = np.array([_place_mark(group, col, tick) for group in short])
    marks = np.unique(np.concatenate([marks, _free_ends(run, marks, tick)]))
    before, after = marks[marks < col][-p.n_marks :], marks[marks > col][: p.n_marks]
    return tuple(float(last - first) for first in before for last in after)


def _place_mark(group: Indices, col: int, tick: int) -> float:
    """Where a line ends at a mark, by the columns of its widened ink: in its middle, or at the face of a wall.

    col: of the text, on whose side the face is.
    """
    if len(group) <= 2 * tick + 1 + PARAMETERS.max_tick_px:
        return float(group.mean())
    return float(group[0] + tick if group[0] > col else group[-1] - tick)


def _free_ends(run: tuple[int, int], marks: Floats, tick: int) -> Floats:
    """The ends of a line that no mark is near."""
    ends = np.array([run[0], run[1] - 1], float)
    near = np.abs(ends[:, None] - marks).min(axis=1, initial=np.inf) <= 2 * tick
    return np.asarray(ends[~near])


def _widen(line: Mask, reach: int) -> Mask:
    """A line of pixels in which ink reaches further to both sides."""
    return np.convolve(line, np.ones(2 * reach + 1), mode="same") > 0
