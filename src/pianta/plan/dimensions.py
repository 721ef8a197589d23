"""Lengths that are written on plans, and the metres per pixel that follow from them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, islice
from statistics import median
from typing import NamedTuple

import cv2
import numpy as np

from pianta.plan.sheet import Floats, Mask, PlacedText

FOOT, INCH = 0.3048, 0.0254
METRES = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "ft": FOOT, "in": INCH}
# No room, and no scale bar, is longer, m.
LONGEST = 1000.0
# Two ratios of a room, and the ratios of several rooms, agree within this share.
AGREEMENT = 0.12
# Numbers of a scale bar lie on a line within this many of their heights, the bar within so many from them.
ROW_TOLERANCE, BAR_REACH = 0.7, 3.0
# Files of drawings may hold anything: longer texts, more numbers, and longer rows of numbers say no scale.
MAX_TEXT_LENGTH, MAX_NUMBERS, MAX_IN_ROW = 200, 2000, 40

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
    """The scale that a bar says: increasing numbers in a row, a unit with or near them, a line or chequered bar.

    ink: shape (H, W). Without a bar the places of the numbers are taken, which is less sure. None where there is none.
    """
    short = [text for text in texts if len(text.text) <= MAX_TEXT_LENGTH]
    numbers = [number for text in short for number in _numbers_of(text)]
    rows = [_find_even(row) for row in _rows_of(numbers[:MAX_NUMBERS]) if len(row) <= MAX_IN_ROW]
    found = [scale for row in rows if len(row) > 1 and (scale := _read_row(row, short, ink))]
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


def _numbers_of(text: PlacedText) -> list[_Number]:
    """The numbers in a level text that consists of nothing else but a unit, each at its share of the line."""
    if not _is_quantity(text.text):
        return []
    along = text.corners[1] - text.corners[0]
    if abs(along[1]) <= abs(along[0]):
        return []
    left = (text.corners[0] + text.corners[3]) / 2
    unit = _unit_of(text.text)
    return [
        _Number(
            float(found[0].replace(",", ".")),
            left + along * ((found.start() + found.end()) / 2 / len(text.text)),
            text.height,
            unit,
        )
        for found in _VALUE.finditer(text.text)
    ]


def _rows_of(numbers: Sequence[_Number]) -> list[list[_Number]]:
    """Numbers on level lines, each from left to right."""
    rows: list[list[_Number]] = []
    for number in sorted(numbers, key=lambda number: float(number.middle[0])):
        for row in rows:
            if abs(number.middle[0] - row[-1].middle[0]) <= ROW_TOLERANCE * min(number.height, row[-1].height):
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
        if grown <= 0:
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


def _read_row(row: Sequence[_Number], texts: Sequence[PlacedText], ink: Mask) -> Scale | None:
    unit = next((number.unit for number in row if number.unit), None) or _unit_near(row, texts)
    grown, wide = row[-1].value - row[0].value, float(row[-1].middle[1] - row[0].middle[1])
    if unit is None or not 0 < grown * METRES[unit] <= LONGEST or wide <= 0:
        return None
    several = len(row) > 2
    # OCR may have overlooked the 0 at which the bar begins.
    first = float(row[0].middle[1])
    for value, col in ((row[0].value, first), (0.0, first - row[0].value / grown * wide)):
        bar = _find_bar(row, col, ink)
        if bar is not None:
            return Scale((row[-1].value - value) * METRES[unit] / bar, 0.95 if several else 0.85)
    return Scale(grown * METRES[unit] / wide, 0.7 if several else 0.4)


def _unit_near(row: Sequence[_Number], texts: Sequence[PlacedText]) -> str | None:
    """The unit that a text names within some heights of the row, the nearest one."""
    height = max(number.height for number in row)
    ends = np.array([row[0].middle, row[-1].middle])
    near = []
    for text in texts:
        unit = _unit_of(text.text) if _is_quantity(text.text) or _SAYS_SCALE.search(text.text) else None
        nearest = np.clip(text.middle, ends.min(axis=0), ends.max(axis=0))
        reach = 6 * height + abs(text.corners[1][1] - text.corners[0][1]) / 2
        distance = float(np.hypot(*(text.middle - nearest)))
        if unit and distance <= reach:
            near.append((distance, unit))
    return min(near, default=(0.0, None))[1]


def _find_bar(row: Sequence[_Number], first: float, ink: Mask) -> float | None:
    """Length, pixels, of the piece of ink above or below a row of numbers that runs from a column to the last one."""
    height = max(number.height for number in row)
    last = float(row[-1].middle[1])
    middle, reach = row[0].middle[0], BAR_REACH * height
    slack = 0.1 * (last - first) + 2
    top, bottom = (int(np.clip(middle + side * reach, 0, ink.shape[0])) for side in (-1, 1))
    left, right = (int(np.clip(col, 0, ink.shape[1])) for col in (first - 2 * slack, last + 2 * slack))
    if bottom <= top or right <= left:
        return None
    window = ink[top:bottom, left:right].astype(np.uint8)
    _, _, stats, _ = cv2.connectedComponentsWithStats(window, connectivity=8)
    starts, widths = stats[1:, cv2.CC_STAT_LEFT] + left, stats[1:, cv2.CC_STAT_WIDTH]
    fits = (np.abs(starts - first) <= slack) & (np.abs(starts + widths - last) <= slack)
    # What reaches the sides of the window goes on beyond it.
    fits &= (starts > left) & (starts + widths < right)
    lengths = widths[fits]
    return float(lengths[np.abs(lengths - (last - first)).argmin()]) if len(lengths) else None


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
