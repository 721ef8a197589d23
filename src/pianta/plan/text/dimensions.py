"""Lengths that are written on plans, and the metres per pixel that follow from them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, islice
from statistics import median
from typing import NamedTuple

import cv2
import numpy as np

from pianta._types import Floats, Mask
from pianta.plan.sheets.sheet import PlacedText

FOOT, INCH = 0.3048, 0.0254
METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "ft": FOOT, "in": INCH}
# No room, and no scale bar, is longer, m.
LONGEST = 1000.0
# Two ratios of a room, and the ratios of several rooms, agree within this share.
AGREEMENT = 0.12
# Numbers of a scale bar lie on a line within this many of their heights, the bar within so many from them, and the
# heights differ by less than this factor.
ROW_TOLERANCE, BAR_REACH, ALIKE = 0.7, 3.0, 1.7
# In heights of the numbers: pieces of a bar are as wide at least, and as high at most; what changes along it as high
# as that is a mark, and marks so near to each other are the sides of one stroke.
LEAST_PIECE, MOST_PIECE, LEAST_MARK, STROKE = 1.2, 2.0, 0.2, 0.25
# All numbers are shifted from their marks by so many heights at most, and each may lie off that by so many.
SHIFT, UNEVEN = 1.2, 0.35
# Marks lie where they belong within this share of the bar, and 1.5 pixels.
STRAIGHT = 0.01
# The bar and the places of its numbers agree within this share, or nobody knows what is measured.
BAR_AGREEMENT = 0.05
SURE_BAR, SURE_OF_TWO, UNSURE_BAR = 0.95, 0.85, 0.4
# Files of drawings may hold anything: longer texts, more numbers, and longer rows of numbers say no scale.
MAX_TEXT_LENGTH, MAX_NUMBERS, MAX_IN_ROW, MAX_MARKS = 200, 2000, 40, 400
# A sheet has few scale bars: so many rows of numbers are looked at.
MAX_ROWS = 20

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
_AREA = re.compile(
    rf"{_NUMBER}\s*(?:m2|m²|mq|qm|sqm|m\^2|sq\.?\s*(?:m|ft)\.?|sf|s\.f\.|ft2|ft²|gsf|square (?:feet|met(?:er|re)s))",
    re.IGNORECASE,
)
_INCHES_TO_FEET = re.compile(
    r"(?:(\d+)/(\d+)|(\d+|[lI]))\s*(?:\"|in\b|inch)\w*\s*=\s*(\d+)\s*(?:'|ft|feet|fo\wt)", re.IGNORECASE
)
_SAYS_SCALE = re.compile(r"scal[ea]|escala|échelle|echelle|ma(?:ß|ss)stab", re.IGNORECASE)
_RATIO = re.compile(r"(?<!\d)1\s*[:/]\s*(\d{2,5})(?![\d'\"])")


class Scale(NamedTuple):
    """What a plan says of its scale.

    resolution: metres per pixel. confidence: how sure, 0 … 1.
    """

    resolution: float
    confidence: float


def parse_length(text: str) -> float | None:
    """Metres of a length such as 12'-6", 3.50 m, 350 cm, 3500 mm or 12,50; None for what is none.

    A number without a unit is metres when it has two or three digits behind the point, and else no length.
    """
    found = _LENGTH.fullmatch(_plain(text))
    if found is None:
        return None
    if found["feet"]:
        metres = float(found["feet"]) * FOOT + _parse_inches(found["inches"] or "0") * INCH
    else:
        number, unit = found["number"].replace(",", "."), found["unit"]
        if unit is None and len(number.partition(".")[2]) < 2:
            return None
        metres = float(number) * METRES[(unit or "m").lower()]
    return metres if 0 < metres <= LONGEST else None


def parse_size(text: str) -> tuple[float, float] | None:
    """The two lengths, m, of a room's size such as 11' x 10' or 3.50 x 4,20 m; None for what is none.

    A unit behind the second length is that of both. Sizes without any unit, such as 24 x 30, are in no unit that can be
    known.
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
    """A text without the lengths, sizes and areas in it: what is left of BEDROOM 11' x 10' is BEDROOM.

    Single numbers stay, since rooms are numbered.
    """
    plain = quoted = text.translate(_QUOTES)
    if len(text) > MAX_TEXT_LENGTH:
        return text
    side = rf"\d[\d.,]*\s*(?:'(?:\s*-?\s*\d{{1,2}}{_FRACTION}\s*(?:\"|'')?)?|ft\.?|mm|cm|m)?\.?"
    size = re.compile(rf"(?<![\w]){side}\s*[x*]\s*{side}(?![\w])", re.IGNORECASE)
    with_unit = re.compile(
        rf"(?<![\w.,])(?:\d[\d.,]*\s*'(?:\s*-?\s*\d{{1,2}}{_FRACTION}\s*(?:\"|''))?|{_NUMBER}\s*(?:mm|cm|m)(?![\w²-]))",
        re.IGNORECASE,
    )
    for pattern in (_AREA, size, with_unit):
        plain = pattern.sub(" ", plain)
    return text if plain == quoted else " ".join(plain.split()).strip(" -–—,;:=")


def parse_drawing_scale(text: str) -> float | None:
    """How much smaller than the building a drawing is: 100 of "Scale 1:100", 96 of 1/8" = 1'-0"; None for no scale.

    It gives metres per pixel only where the size of the paper is known.
    """
    plain = _plain(text)
    named = _INCHES_TO_FEET.search(plain)
    if named:
        # OCR takes a 1 for I or l.
        whole = int(named[3]) if named[3] and named[3].isdigit() else 1
        inches = whole if named[3] else int(named[1]) / max(int(named[2]), 1)
        return int(named[4]) * 12 / inches if inches else None
    ratio = _RATIO.search(plain)
    return float(ratio[1]) if ratio else None


def parse_scale_bar(texts: Sequence[PlacedText], ink: Mask) -> Scale | None:
    """The scale that a bar says: evenly growing numbers, a unit with or near them, a line, ticks or blocks at them.

    ink: shape (H, W). Exact where two marks of the bar at least stand where the numbers do, and the two agree within
    BAR_AGREEMENT. Otherwise the places of the numbers are taken, with confidence UNSURE_BAR, when they are three from
    0 on. None where there is no bar: numbers beside walls, in rooms and of dimensions are none.
    """
    short = [text for text in texts if len(text.text) <= MAX_TEXT_LENGTH]
    found = []
    # A number stands at its mark by itself, or together with its unit.
    for by_itself in (True, False):
        numbers = [number for text in short for number in _numbers_of(text, by_itself=by_itself)]
        rows = [_find_even(row) for row in _rows_of(numbers[:MAX_NUMBERS]) if len(row) <= MAX_IN_ROW]
        likely = sorted((row for row in rows if row), key=_rank, reverse=True)[:MAX_ROWS]
        found += [scale for row in likely if (scale := _read_row(row, short, ink))]
    return max(found, key=lambda scale: scale.confidence, default=None)


def scale_from_dimensions(texts: Sequence[PlacedText], boxes: Floats) -> Scale | None:
    """The scale on which most sizes that are written in rooms agree with the rooms; None where fewer than two do.

    boxes: shape (R, 4), top, left, bottom, right of the rooms inside their walls, pixels.
    """
    found = (ratio for text in texts if (ratio := _ratio_of_size(text, boxes)) is not None)
    ratios = list(islice(found, MAX_NUMBERS))
    if len(ratios) < 2:
        return None
    # The ratio with which most others agree, and the median of these.
    near = [[other for other in ratios if abs(other / ratio - 1) <= AGREEMENT] for ratio in ratios]
    agreeing = max(near, key=len)
    if len(agreeing) < 2 or 2 * len(agreeing) <= len(ratios):
        return None
    return Scale(median(agreeing), len(agreeing) / len(ratios) * (1 - 1 / (1 + len(agreeing))))


@dataclass(frozen=True, eq=False)
class _Number:
    """A number on a sheet: its value, its middle, the height of its line, and the unit that stands behind it."""

    value: float
    middle: Floats
    height: float
    unit: str | None


def _plain(text: str) -> str:
    """A text with plain quotes and without blanks around it; none for one that is too long."""
    return text.translate(_QUOTES).strip() if len(text) <= MAX_TEXT_LENGTH else ""


def _parse_inches(text: str) -> float:
    whole, _, fraction = text.replace("-", " ").rpartition(" ") if "/" in text else (text, "", "")
    above, _, below = fraction.partition("/")
    return float(whole or 0) + (float(above) / max(float(below), 1) if below else 0.0)


def _unit_of(text: str) -> str | None:
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


def _numbers_of(text: PlacedText, *, by_itself: bool) -> list[_Number]:
    """The numbers in a level text that consists of nothing else but a unit, each at its share of the line.

    by_itself: False for a single number in the middle of the line.
    """
    if not _is_quantity(text.text):
        return []
    along = text.corners[1] - text.corners[0]
    if abs(along[1]) <= abs(along[0]):
        return []
    left = (text.corners[0] + text.corners[3]) / 2
    unit = _unit_of(text.text)
    values = list(_VALUE.finditer(text.text))
    shares = [(found.start() + found.end()) / 2 / len(text.text) for found in values]
    if len(values) == 1 and not by_itself:
        shares = [0.5]
    return [
        _Number(float(found[0].replace(",", ".")), left + along * share, text.height, unit)
        for found, share in zip(values, shares, strict=True)
    ]


def _rows_of(numbers: Sequence[_Number]) -> list[list[_Number]]:
    """Numbers of like heights on level lines, each from left to right."""
    rows: list[list[_Number]] = []
    for number in sorted(numbers, key=lambda number: float(number.middle[0])):
        for row in rows:
            low, high = sorted((number.height, row[0].height))
            near = abs(number.middle[0] - row[-1].middle[0]) <= ROW_TOLERANCE * min(low, row[-1].height)
            if near and high <= ALIKE * low:
                row.append(number)
                break
        else:
            rows.append([number])
    return [sorted(row, key=lambda number: float(number.middle[1])) for row in rows]


def _find_even(row: Sequence[_Number]) -> list[_Number]:
    """The most numbers of a row that grow as evenly as their places: three, or two of which the first is 0."""
    best: list[_Number] = []
    for first, last in combinations(row, 2):
        grown = last.value - first.value
        if grown <= 0 or last.middle[1] <= first.middle[1]:
            continue
        per_pixel = grown / (last.middle[1] - first.middle[1])
        even = [
            number
            for number in row
            if abs(first.value + (number.middle[1] - first.middle[1]) * per_pixel - number.value) <= 0.04 * grown
        ]
        if len(even) > len(best):
            best = even
    return best if len(best) > 2 or (len(best) == 2 == len(row) and best[0].value == 0) else []


def _rank(row: Sequence[_Number]) -> tuple[bool, bool, int]:
    """How likely a row is a scale bar: from 0 on, one unit, many numbers. Numbers of rooms have neither 0 nor unit."""
    return row[0].value == 0, sum(number.unit is not None for number in row) == 1, len(row)


def _read_row(row: Sequence[_Number], texts: Sequence[PlacedText], ink: Mask) -> Scale | None:
    units = [number.unit for number in row if number.unit]
    unit = units[0] if units else _unit_near(row, texts)
    from_zero, several = row[0].value == 0, len(row) > 2
    grown = row[-1].value - row[0].value
    # Lengths beside each other, each with its unit, are dimensions.
    if unit is None or not 0 < grown * METRES[unit] <= LONGEST or (len(units) > 1 and not from_zero):
        return None
    values, cols = np.array([(number.value, number.middle[1]) for number in row]).T
    by_places = grown / float(cols[-1] - cols[0])
    height = max(number.height for number in row)
    fitted = [fit for marks in _find_marks(row, ink) if (fit := _fit_marks(values, cols, marks, height))]
    agreeing = [fit for fit in fitted if abs(fit.per_pixel / by_places - 1) <= BAR_AGREEMENT]
    if agreeing:
        return Scale(max(agreeing).per_pixel * METRES[unit], SURE_BAR if several else SURE_OF_TWO)
    return Scale(by_places * METRES[unit], UNSURE_BAR) if from_zero and several else None


def _unit_near(row: Sequence[_Number], texts: Sequence[PlacedText]) -> str | None:
    """The unit that a text names within some heights of the row, the nearest one; not those of lengths."""
    height = max(number.height for number in row)
    ends = np.array([row[0].middle, row[-1].middle])
    near = []
    for text in texts:
        is_unit = _is_quantity(text.text) and not _VALUE.search(text.text)
        unit = _unit_of(text.text) if is_unit or _SAYS_SCALE.search(text.text) else None
        nearest = np.clip(text.middle, ends.min(axis=0), ends.max(axis=0))
        reach = 6 * height + abs(text.corners[1][1] - text.corners[0][1]) / 2
        distance = float(np.hypot(*(text.middle - nearest)))
        if unit and distance <= reach:
            near.append((distance, unit))
    return min(near, default=(0.0, None))[1]


def _find_marks(row: Sequence[_Number], ink: Mask) -> Iterator[Floats]:
    """Columns, pixels, of the ends, ticks and borders of blocks of what may be the bar, above and below a row.

    Its pieces are low and wide, clear of the numbers, and end near them: walls go on.
    """
    height, middle = max(number.height for number in row), float(row[0].middle[0])
    first, last = float(row[0].middle[1]), float(row[-1].middle[1])
    # OCR may have overlooked the 0 at which the bar begins.
    zero = first - row[0].value / (row[-1].value - row[0].value) * (last - first)
    top, bottom = (int(np.clip(middle + side * BAR_REACH * height, 0, ink.shape[0])) for side in (-1, 1))
    around = last - zero
    left, right = (int(np.clip(col, 0, ink.shape[1])) for col in (zero - around, last + around))
    if bottom <= top or right <= left:
        return
    window = np.pad(ink[top:bottom, left:right].astype(np.uint8), 1)
    _, pieces, stats, _ = cv2.connectedComponentsWithStats(window, connectivity=8)
    start, above, wide, high, _ = stats.T
    inside = (start > 1) & (above > 1) & (start + wide <= right - left) & (above + high <= bottom - top)
    fits = inside & (wide >= LEAST_PIECE * height) & (high <= MOST_PIECE * height)
    fits[0] = False
    core = middle - top + 1
    for side in (above + high <= core - height / 4, above >= core + height / 4):
        bar = np.isin(pieces, np.flatnonzero(fits & side))
        changes = np.flatnonzero((bar[:, 1:] != bar[:, :-1]).sum(axis=0) >= max(2, LEAST_MARK * height)) + 1
        ends = np.concatenate([start[fits & side], (start + wide)[fits & side]])
        marks = np.unique(np.concatenate([changes, ends])) + left - 1.0
        if 1 < len(marks) <= MAX_MARKS:
            strokes = np.split(marks, np.flatnonzero(np.diff(marks) > max(2, STROKE * height)) + 1)
            yield np.array([stroke.mean() for stroke in strokes])


class _FittedBar(NamedTuple):
    """Marks that stand where numbers do; the more the better, then the farther apart.

    per_pixel: by how much the numbers grow with a pixel.
    """

    marks: int
    length: float
    per_pixel: float


def _fit_marks(values: Floats, cols: Floats, marks: Floats, height: float) -> _FittedBar | None:
    """The marks that stand at the numbers, all shifted alike; None where fewer than two do, or the 0 has none.

    values, cols: shape (N,), numbers and where their middles lie. marks: shape (M,). height: of the numbers.
    """
    if values[0] > 0:
        zero = cols[0] - values[0] * (cols[-1] - cols[0]) / (values[-1] - values[0])
        values, cols, needs_zero = np.append(0.0, values), np.append(zero, cols), True
    else:
        needs_zero = False
    offsets = marks - cols[:, None]
    shifts = np.arange(-SHIFT * height, SHIFT * height + 1)
    off = np.array([np.abs(offsets - shift).min(axis=1) for shift in shifts])
    near = off <= UNEVEN * height
    # Most numbers have a mark, and are near it.
    best = int(np.lexsort([np.where(near, off, 0).sum(axis=1), -near.sum(axis=1)])[0])
    at = marks[np.abs(offsets - shifts[best]).argmin(axis=1)]
    fits = []
    for first, last in combinations(np.flatnonzero(near[best]), 2):
        length = float(at[last] - at[first])
        expected = at[first] + (values - values[first]) * length / (values[last] - values[first])
        straight = near[best] & (np.abs(at - expected) <= max(1.5, STRAIGHT * length))
        if length > 0 and (straight[0] or not needs_zero):
            fits.append(_FittedBar(int(straight.sum()), length, float((values[last] - values[first]) / length)))
    return max(fits, default=None)


def _ratio_of_size(text: PlacedText, boxes: Floats) -> float | None:
    """Metres per pixel of a size in the smallest box around it, where both of its lengths agree."""
    size = parse_size(text.text)
    row, col = text.middle
    around = boxes[(boxes[:, 0] <= row) & (row <= boxes[:, 2]) & (boxes[:, 1] <= col) & (col <= boxes[:, 3])]
    if size is None or not len(around):
        return None
    sides = np.column_stack([around[:, 2] - around[:, 0], around[:, 3] - around[:, 1]])
    short, long = np.sort(sides[sides.prod(axis=1).argmin()])
    if short <= 0:
        return None
    ratios = min(size) / short, max(size) / long
    return float(np.sqrt(ratios[0] * ratios[1])) if abs(ratios[0] / ratios[1] - 1) <= 2 * AGREEMENT else None
