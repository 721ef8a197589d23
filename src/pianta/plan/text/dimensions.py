"""Lengths that are written on plans, and the metres per pixel that follow from them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import cv2
import numpy as np

from pianta._types import Floats, Mask
from pianta.plan.sheets.sheet import PlacedText, PlanScale
from pianta.plan.text.areas import AREA
from pianta.plan.text.sizes import FOOT, INCH, parse_inches

METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "ft": FOOT, "in": INCH}
SCALE_BAR = "the scale bar"  # the source of a scale
MAX_LENGTH = 1000.0  # m of a room and of a scale bar

# Files of drawings may hold anything, so there are limits, for time
MAX_TEXT_LENGTH = 200  # characters of a text that may state a length or a scale
MAX_NUMBERS = 2000  # of a sheet
MAX_IN_ROW = 40  # numbers in a row
MAX_MARKS = 400  # of a bar
MAX_ROWS = 20  # rows of numbers that are searched for a bar, the likeliest first


@dataclass(frozen=True, kw_only=True)
class DimensionParameters:
    """Thresholds of scale bars; heights are those of the numbers of a scale bar. Chosen by hand."""

    alike_heights: float = 1.7  # ratio of the heights of two numbers in a row, at most
    row_offset: float = 0.7  # heights between the middles of two numbers in a row, at most
    even_offset: float = 0.04  # of the length of a row, by which a number may be off an even one
    unit_distance: float = 6.0  # heights between a row and a text that names its unit
    bar_distance: float = 3.0  # heights above and below a row, in which the bar is looked for
    min_piece_width: float = 1.2  # heights of a piece of a bar
    max_piece_height: float = 2.0  # heights
    clearance: float = 0.25  # heights between the middle of the numbers and the bar
    min_mark: float = 0.2  # heights of a change along a bar that is a mark
    max_stroke: float = 0.25  # heights between two marks that are the sides of one stroke
    max_shift: float = 1.2  # heights by which all numbers are shifted from their marks
    max_offset: float = 0.35  # heights by which each number is off the common shift
    mark_tolerance: float = 0.01  # of the length of the bar, by which a mark is off its position
    mark_tolerance_px: float = 1.5  # px, if that is more
    bar_agreement: float = 0.05  # share by which the bar and the positions of its numbers differ
    # Confidences, 0 … 1
    confidence_of_bar: float = 0.95  # with at least three numbers that agree with their marks
    confidence_of_two_marks: float = 0.85  # with two numbers
    confidence_of_numbers: float = 0.4  # with numbers alone


PARAMETERS = DimensionParameters()

_UNITS = {
    "millimet(?:er|re|ri|ros)s?|mm": "mm",
    "centimet(?:er|re|ri|ros)s?|cm": "cm",
    "met(?:er|re|ri|ros)s?|m(?:ts?|tr)?": "m",
    "feet|foot|ft|pieds?|piedi|pies": "ft",
    "inch(?:es)?": "in",
}
_VALUE = re.compile(r"\d+(?:[.,]\d+)?")
_QUOTES = str.maketrans({"’": "'", "‘": "'", "`": "'", "´": "'", "′": "'", "“": '"', "”": '"', "″": '"', "×": "x"})
_NUMBER = r"\d{1,6}(?:[.,]\d{1,3})?"
_FRACTION = r"(?:[ -]?\d{1,2}/\d{1,2})?"
_INCHES = rf"(?P<inches>\d{{1,2}}{_FRACTION})\s*(?:\"|''|in\.?)?"
_FEET = rf"(?P<feet>\d{{1,4}}(?:\.\d{{1,2}})?)\s*(?:'|ft\.?|feet)(?:\s*-?\s*{_INCHES})?"
_METRIC = rf"(?P<number>{_NUMBER})\s*(?P<unit>mm|cm|m)?"
_LENGTH = re.compile(rf"(?:{_FEET}|{_METRIC})\.?", re.IGNORECASE)
_BY = re.compile(r"\s*(?:x|\*|by)\s*", re.IGNORECASE)
_SIDE = rf"\d[\d.,]*\s*(?:'(?:\s*-?\s*\d{{1,2}}{_FRACTION}\s*(?:\"|'')?)?|ft\.?|mm|cm|m)?\.?"
_SIZE = re.compile(rf"(?<![\w]){_SIDE}\s*[x*]\s*{_SIDE}(?![\w])", re.IGNORECASE)
_LENGTH_WITH_UNIT = re.compile(
    rf"(?<![\w.,])(?:\d[\d.,]*\s*'(?:\s*-?\s*\d{{1,2}}{_FRACTION}\s*(?:\"|''))?|{_NUMBER}\s*(?:mm|cm|m)(?![\w²-]))",
    re.IGNORECASE,
)
_SCALE_WORD = re.compile(r"scal[ea]|escala|échelle|echelle|ma(?:ß|ss)stab", re.IGNORECASE)


def parse_length(text: str) -> float | None:
    """Metres of a length such as 12'-6", 3.50 m, 350 cm, 3500 mm or 12,50; None for other texts.

    A number without a unit is metres if it has two or three decimals, else no length.
    """
    match = _LENGTH.fullmatch(_plain(text))
    if match is None:
        return None
    if match["feet"]:
        metres = float(match["feet"]) * FOOT + parse_inches(match["inches"] or "0") * INCH
    else:
        number, unit = match["number"].replace(",", "."), match["unit"]
        if unit is None and len(number.partition(".")[2]) < 2:
            return None
        metres = float(number) * METRES[(unit or "m").lower()]
    return metres if 0 < metres <= MAX_LENGTH else None


def parse_size(text: str) -> tuple[float, float] | None:
    """The two lengths, m, of a room's size such as 11' x 10' or 3.50 x 4,20 m; None for other texts.

    A unit behind the second length is that of both. The unit of sizes such as 24 x 30 is unknown.
    """
    parts = _BY.split(_plain(text))
    if len(parts) != 2:
        return None
    first, second = parts
    unit = re.search(r"('|ft\.?|feet|mm|cm|m)\.?$", second, re.IGNORECASE)
    if unit and re.fullmatch(_NUMBER, first):
        first = f"{first}{unit[1]}"
    lengths = parse_length(first), parse_length(second)
    return None if lengths[0] is None or lengths[1] is None else (lengths[0], lengths[1])


def remove_measures(text: str) -> str:
    """A text without the lengths, sizes and areas in it: BEDROOM of BEDROOM 11' x 10'.

    Single numbers stay, since rooms are numbered.
    """
    plain = quoted = text.translate(_QUOTES)
    if len(text) > MAX_TEXT_LENGTH:
        return text
    for pattern in (AREA, _SIZE, _LENGTH_WITH_UNIT):
        plain = pattern.sub(" ", plain)
    return text if plain == quoted else " ".join(plain.split()).strip(" -–—,;:=")


def parse_scale_bar(texts: Sequence[PlacedText], ink: Mask) -> PlanScale | None:
    """The scale of a bar: evenly growing numbers, a unit with or near them, and a line, ticks or blocks beside them.

    ink: shape (H, W). The scale is exact if at least two marks of the bar stand where the numbers do, and the two
    agree. Otherwise it is that of the positions of the numbers, less confidently, if they are at least three from 0 on.
    None without a bar: numbers beside walls, in rooms and of dimensions do not count.
    """
    short = [text for text in texts if len(text.text) <= MAX_TEXT_LENGTH]
    scales = []
    # A number stands at its mark by itself, or together with its unit
    for by_itself in (True, False):
        numbers = [number for text in short for number in _numbers_in(text, by_itself=by_itself)]
        rows = [_most_even(row) for row in _align_rows(numbers[:MAX_NUMBERS]) if len(row) <= MAX_IN_ROW]
        likely = sorted((row for row in rows if row), key=_rank, reverse=True)[:MAX_ROWS]
        scales += [scale for row in likely if (scale := _read_row(row, short, ink))]
    return max(scales, key=lambda scale: scale.confidence, default=None)


@dataclass(frozen=True, eq=False)
class _Number:
    """A number on a sheet: its value, its middle, the height of its line, and the unit that stands behind it."""

    value: float
    middle: Floats
    height: float
    unit: str | None


def _plain(text: str) -> str:
    """A text with plain quotes and without blanks around it; empty if it is too long."""
    return text.translate(_QUOTES).strip() if len(text) <= MAX_TEXT_LENGTH else ""


def _find_unit(text: str) -> str | None:
    """The unit that a text names as a word; the longest names first."""
    folded = text.lower().translate(_QUOTES)
    for names, unit in _UNITS.items():
        if re.search(rf"(?<![a-z])(?:{names})(?![a-z²2])", folded):
            return unit
    return "ft" if re.fullmatch(r"[\d.,\s]+'", folded) else None


def _is_quantity(text: str) -> bool:
    """Whether a text has nothing but numbers and units."""
    words = _VALUE.sub(" ", text.lower().translate(_QUOTES))
    return not re.search(r"[^\s'.]", re.sub(rf"\b(?:{'|'.join(_UNITS)})\b", "", words))


def _numbers_in(text: PlacedText, *, by_itself: bool) -> list[_Number]:
    """The numbers in a level text that has nothing else but a unit, each at its share of the line.

    by_itself: False for a single number in the middle of the line.
    """
    if not _is_quantity(text.text):
        return []
    along = text.corners[1] - text.corners[0]
    if abs(along[1]) <= abs(along[0]):
        return []
    left = (text.corners[0] + text.corners[3]) / 2
    unit = _find_unit(text.text)
    values = list(_VALUE.finditer(text.text))
    shares = [(value.start() + value.end()) / 2 / len(text.text) for value in values]
    if len(values) == 1 and not by_itself:
        shares = [0.5]
    return [
        _Number(float(value[0].replace(",", ".")), left + along * share, text.height, unit)
        for value, share in zip(values, shares, strict=True)
    ]


def _align_rows(numbers: Sequence[_Number]) -> list[list[_Number]]:
    """Numbers of like heights on level lines, each from left to right."""
    rows: list[list[_Number]] = []
    for number in sorted(numbers, key=lambda number: float(number.middle[0])):
        for row in rows:
            low, high = sorted((number.height, row[0].height))
            offset = abs(number.middle[0] - row[-1].middle[0])
            is_level = offset <= PARAMETERS.row_offset * min(low, row[-1].height)
            if is_level and high <= PARAMETERS.alike_heights * low:
                row.append(number)
                break
        else:
            rows.append([number])
    return [sorted(row, key=lambda number: float(number.middle[1])) for row in rows]


def _most_even(row: Sequence[_Number]) -> list[_Number]:
    """The most numbers of a row that grow evenly with their columns: three, or two of which the first is 0."""
    best: list[_Number] = []
    for first, last in combinations(row, 2):
        growth = last.value - first.value
        if growth <= 0 or last.middle[1] <= first.middle[1]:
            continue
        per_pixel = growth / (last.middle[1] - first.middle[1])
        off = [first.value + (number.middle[1] - first.middle[1]) * per_pixel - number.value for number in row]
        even = [number for number, value in zip(row, off, strict=True) if abs(value) <= PARAMETERS.even_offset * growth]
        if len(even) > len(best):
            best = even
    return best if len(best) > 2 or (len(best) == 2 == len(row) and best[0].value == 0) else []


def _rank(row: Sequence[_Number]) -> tuple[bool, bool, int]:
    """How likely a row is a scale bar: from 0 on, one unit, many numbers. Numbers of rooms have neither 0 nor unit."""
    return row[0].value == 0, sum(number.unit is not None for number in row) == 1, len(row)


def _read_row(row: Sequence[_Number], texts: Sequence[PlacedText], ink: Mask) -> PlanScale | None:
    """The scale by a row of numbers and the marks of a bar near it; None if it is no scale bar. ink: shape (H, W)."""
    units = [number.unit for number in row if number.unit]
    unit = units[0] if units else _unit_near(row, texts)
    from_zero, several = row[0].value == 0, len(row) > 2
    growth = row[-1].value - row[0].value
    # Lengths beside each other, each with its unit, are dimensions
    if unit is None or not 0 < growth * METRES[unit] <= MAX_LENGTH or (len(units) > 1 and not from_zero):
        return None
    values, cols = np.array([(number.value, number.middle[1]) for number in row]).T
    per_pixel, confidence = growth / float(cols[-1] - cols[0]), PARAMETERS.confidence_of_numbers
    height = max(number.height for number in row)
    fits = [fit for marks in _find_marks(row, ink) if (fit := _fit_marks(values, cols, marks, height))]
    agreeing = [fit for fit in fits if abs(fit.per_pixel / per_pixel - 1) <= PARAMETERS.bar_agreement]
    if agreeing:
        per_pixel = max(agreeing).per_pixel
        confidence = PARAMETERS.confidence_of_bar if several else PARAMETERS.confidence_of_two_marks
    elif not (from_zero and several):
        return None
    return PlanScale(per_pixel * METRES[unit], SCALE_BAR, confidence)


def _unit_near(row: Sequence[_Number], texts: Sequence[PlacedText]) -> str | None:
    """The unit that a text near the row names, the nearest one; not those of lengths."""
    height = max(number.height for number in row)
    ends = np.array([row[0].middle, row[-1].middle])
    near = []
    for text in texts:
        is_unit = _is_quantity(text.text) and not _VALUE.search(text.text)
        unit = _find_unit(text.text) if is_unit or _SCALE_WORD.search(text.text) else None
        nearest = np.clip(text.middle, ends.min(axis=0), ends.max(axis=0))
        reach = PARAMETERS.unit_distance * height + abs(text.corners[1][1] - text.corners[0][1]) / 2
        distance = float(np.hypot(*(text.middle - nearest)))
        if unit and distance <= reach:
            near.append((distance, unit))
    return min(near, default=(0.0, None))[1]


def _find_marks(row: Sequence[_Number], ink: Mask) -> Iterator[Floats]:
    """Columns, pixels, of the ends, ticks and borders of blocks of what may be the bar, above and below a row.

    Its pieces are low and wide, clear of the numbers, and end near them: walls go on.
    """
    p, height, middle = PARAMETERS, max(number.height for number in row), float(row[0].middle[0])
    first, last = float(row[0].middle[1]), float(row[-1].middle[1])
    # The text reader may have missed the 0 at which the bar begins
    zero = first - row[0].value / (row[-1].value - row[0].value) * (last - first)
    reach, length = p.bar_distance * height, last - zero
    top, bottom = (int(np.clip(limit, 0, ink.shape[0])) for limit in (middle - reach, middle + reach))
    left, right = (int(np.clip(limit, 0, ink.shape[1])) for limit in (zero - length, last + length))
    if bottom <= top or right <= left:
        return
    window = np.pad(ink[top:bottom, left:right].astype(np.uint8), 1)
    _, pieces, stats, _ = cv2.connectedComponentsWithStats(window, connectivity=8)
    start, above, wide, high, _ = stats.T
    inside = (start > 1) & (above > 1) & (start + wide <= right - left) & (above + high <= bottom - top)
    fits = inside & (wide >= p.min_piece_width * height) & (high <= p.max_piece_height * height)
    fits[0] = False
    numbers_row = middle - top + 1
    for side in (above + high <= numbers_row - p.clearance * height, above >= numbers_row + p.clearance * height):
        bar = np.isin(pieces, np.flatnonzero(fits & side))
        changes = np.flatnonzero((bar[:, 1:] != bar[:, :-1]).sum(axis=0) >= max(2, p.min_mark * height)) + 1
        ends = np.concatenate([start[fits & side], (start + wide)[fits & side]])
        marks = np.unique(np.concatenate([changes, ends])) + left - 1.0
        if 1 < len(marks) <= MAX_MARKS:
            strokes = np.split(marks, np.flatnonzero(np.diff(marks) > max(2, p.max_stroke * height)) + 1)
            yield np.array([stroke.mean() for stroke in strokes])


class _FittedBar(NamedTuple):
    """How many marks stand where numbers do, over which length, pixels, and how much the numbers grow per pixel.

    The more marks the better, then the longer.
    """

    marks: int
    length: float
    per_pixel: float


def _fit_marks(values: Floats, cols: Floats, marks: Floats, height: float) -> _FittedBar | None:
    """The marks that stand at the numbers, all shifted alike; None if fewer than two do, or the 0 has none.

    values, cols: shape (N,), numbers and where their middles lie. marks: shape (M,). height: of the numbers.
    """
    p, needs_zero = PARAMETERS, bool(values[0] > 0)
    if needs_zero:
        zero = cols[0] - values[0] * (cols[-1] - cols[0]) / (values[-1] - values[0])
        values, cols = np.append(0.0, values), np.append(zero, cols)
    offsets = marks - cols[:, None]
    shifts = np.arange(-p.max_shift * height, p.max_shift * height + 1)
    off = np.array([np.abs(offsets - shift).min(axis=1) for shift in shifts])
    near = off <= p.max_offset * height
    # The shift at which most numbers have a mark, and are near it
    best = int(np.lexsort([np.where(near, off, 0).sum(axis=1), -near.sum(axis=1)])[0])
    at = marks[np.abs(offsets - shifts[best]).argmin(axis=1)]
    fits = []
    for first, last in combinations(np.flatnonzero(near[best]), 2):
        length = float(at[last] - at[first])
        expected = at[first] + (values - values[first]) * length / (values[last] - values[first])
        tolerance = max(p.mark_tolerance_px, p.mark_tolerance * length)
        is_mark = near[best] & (np.abs(at - expected) <= tolerance)
        if length > 0 and (is_mark[0] or not needs_zero):
            fits.append(_FittedBar(int(is_mark.sum()), length, float((values[last] - values[first]) / length)))
    return max(fits, default=None)
