"""Boxes beside a building: legends, boxes of text, tables, title blocks, site plans and key plans, and the frame.

They are erased before walls are looked for: the network takes their lines for walls, and the paper between them and the
building for rooms.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy import ndimage

from pianta._types import Colors, Indices, Mask
from pianta.plan.sheets.parts import SheetParts
from pianta.plan.sheets.sheet import PlacedText, Sheet
from pianta.plan.text.legend import find_legend, names_legend

LEGEND, TEXT_BOX, SITE_PLAN = "legend", "box of text", "site plan"
# In the order in which they are named
PLURALS = {LEGEND: "legends", TEXT_BOX: "boxes of text", SITE_PLAN: "site plans"}

_SITE_TITLE = re.compile(
    r"\b(?:site|key|location|locality|vicinity|plot|block)[ -]?(?:plan|map)\b|\blage[ -]?plan"
    r"|\b(?:übersichts|kataster)[ -]?(?:plan|karte)|\bplan de (?:situation|masse)\b"
    r"|\bplano de (?:situaci[óo]n|ubicaci[óo]n|emplazamiento)\b|\bplanta de situa[çc][ãa]o\b|\binquadramento\b",
    re.IGNORECASE,
)
_WORD = re.compile(r"[^\W\d_]{2,}")


@dataclass(frozen=True, kw_only=True)
class BoxParameters:
    """Thresholds of `find_boxes`.

    Chosen on the plans of `floorplans` and `planfiles`, and on drawn sheets with boxes: parts of buildings have text on
    up to 0.14 of their area there, boxes on 0.27 and more.
    """

    text_cover: float = 0.22  # of its area that is text
    least_lines: int = 3
    least_words: int = 4
    many_lines: int = 6  # with fewer lines there must be
    many_words: int = 8
    site_size: float = 0.4  # of the area of the largest part, at most
    title_distance: float = 3.0  # heights of its letters between a site plan and its title


PARAMETERS = BoxParameters()


def count_words(texts: Sequence[PlacedText]) -> int:
    """The words of at least two letters in texts."""
    return sum(len(_WORD.findall(text.text)) for text in texts)


def name_box(texts: Sequence[PlacedText], legend: Sequence[PlacedText]) -> str:
    """LEGEND for a box with such a heading, or half of whose texts are in the legend of the sheet; else TEXT_BOX."""
    listed = set(map(id, legend))
    is_legend = 2 * sum(id(text) in listed for text in texts) >= len(texts) > 0
    return LEGEND if is_legend or any(names_legend(text.text) for text in texts) else TEXT_BOX


def find_boxes(parts: SheetParts, texts: Sequence[PlacedText]) -> dict[int, str]:
    """What the parts of a sheet are that are no buildings, by number; the largest part always counts as one."""
    p, numbers = PARAMETERS, parts.numbers
    areas = np.bincount(numbers.ravel(), minlength=2)
    written = np.zeros(numbers.shape, np.uint8)
    for text in texts:
        corners = np.clip(text.corners[:, ::-1] / parts.cell_px - 0.5, -1, max(numbers.shape))
        cv2.fillPoly(written, [np.rint(corners).astype(np.int32)], 1)
    covers = np.bincount(numbers.ravel(), written.ravel(), minlength=2) / np.maximum(areas, 1)
    inside: dict[int, list[PlacedText]] = {}
    for text in texts:
        inside.setdefault(parts.number_at(text.middle), []).append(text)
    legend = find_legend(texts).texts
    boxes = {}
    for number in range(2, len(areas)):
        own = inside.get(number, [])
        words = count_words(own)
        is_written = len(own) >= p.least_lines and words >= p.least_words and covers[number] >= p.text_cover
        if is_written and (len(own) >= p.many_lines or words >= p.many_words):
            boxes[number] = name_box(own, legend)
    plans = (_find_site_plan(text, parts, areas, boxes) for text in texts if _SITE_TITLE.search(text.text))
    return boxes | {number: SITE_PLAN for number in plans if number is not None}


def _find_site_plan(title: PlacedText, parts: SheetParts, areas: Indices, boxes: Collection[int]) -> int | None:
    """The number of the part to which the title of a site plan belongs, None without one.

    It is the nearest one that is far smaller than the largest part, larger than a line of text, and no other box.
    areas: of all parts, cells, shape (N,).
    """
    p, cell_px = PARAMETERS, parts.cell_px
    low, high = title.corners.min(axis=0) / cell_px, title.corners.max(axis=0) / cell_px
    reach = p.title_distance * title.height / cell_px
    first, last = np.maximum(low - reach, 0).astype(int), np.maximum(high + reach, 0).astype(int) + 1
    near = parts.numbers[first[0] : last[0], first[1] : last[1]]
    written = float(np.prod(high - low)) + 2 * reach**2
    possible = (areas > written) & (areas <= p.site_size * areas[1])
    possible[[0, 1, *boxes]] = False
    cells = np.argwhere(possible[near])
    if not len(cells):
        return None
    offsets = np.maximum(np.maximum(low - 1 - first - cells, cells + first - high), 0)
    return int(near[tuple(cells[np.hypot(*offsets.T).argmin()])])


def describe_left_out(kinds: Sequence[str]) -> tuple[str, ...]:
    """What was left out as a line, such as "left out: a legend, 2 boxes of text"; none for nothing."""
    counts = Counter(kinds)
    named = [
        f"a {kind}" if counts[kind] == 1 else f"{counts[kind]} {plural}"
        for kind, plural in PLURALS.items()
        if counts[kind]
    ]
    return (f"left out: {', '.join(named)}",) if named else ()


def erase_boxes(sheet: Sheet, parts: SheetParts, numbers: Collection[int]) -> Sheet:
    """The sheet with paper where some parts and the frame were drawn."""
    if not numbers and not parts.frame.any():
        return sheet
    colors = sheet.colors.copy()
    windows = ndimage.find_objects(parts.numbers)
    for number in numbers:
        window = windows[number - 1]
        if window is not None:
            _blank(colors, sheet, parts.numbers[window] == number, window, parts)
    if parts.frame.any():
        # With the soft edges of its lines
        frame = cv2.dilate(parts.frame.view(np.uint8), np.ones((3, 3), np.uint8)) > 0
        _blank(colors, sheet, frame, (slice(0, frame.shape[0]), slice(0, frame.shape[1])), parts)
    return replace(sheet, colors=colors)


def _blank(colors: Colors, sheet: Sheet, cells: Mask, window: tuple[slice, slice], parts: SheetParts) -> None:
    """Give the pixels of some cells the colour of the paper between what is drawn on them."""
    # Cells are stretched a little, so that whole ones cover the sheet
    scales = np.array(sheet.shape) / parts.numbers.shape
    rows, cols = (
        slice(round(side.start * scale), round(side.stop * scale)) for side, scale in zip(window, scales, strict=True)
    )
    pixels = colors[rows, cols]
    mask = cv2.resize(cells.view(np.uint8), pixels.shape[1::-1], interpolation=cv2.INTER_NEAREST) > 0
    blank = pixels[mask & ~sheet.ink[rows, cols]]
    if len(blank):
        pixels[mask] = np.median(blank, axis=0).astype(np.uint8)
