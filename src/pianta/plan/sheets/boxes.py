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
from scipy.sparse.csgraph import connected_components

from pianta._types import Colors, Floats, Indices, Mask
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


# What title blocks say
_TITLE_WORDS = re.compile(
    r"\b(?:scale|date|sheet|drawn|checked|project|drawing|dwg|revision|client|architects?|ma(?:ß|ss)stab|datum|blatt|plan-?nr"
    r"|gezeichnet|gepr[üu]ft|projekt|bauherr|architekt|scala|tavola|progetto|committente|disegno|[ée]chelle|dessin[ée]?"
    r"|projet|ma[îi]tre d'ouvrage|escala|fecha|l[áa]mina|proyecto|plano n|dibujado|desenho)\b",
    re.IGNORECASE,
)


@dataclass(frozen=True, kw_only=True)
class BoxParameters:
    """Thresholds of `find_boxes`; heights are those of a line of text.

    Chosen on the plans of `floorplans` and `planfiles`, and on drawn sheets with boxes: parts of buildings have text on
    up to 0.41 of their area there, but none of it in columns; boxes have 0.27 to 0.7.
    """

    text_cover: float = 0.22  # of its area that is text
    bare_text: float = 0.85  # of its area, from which on text has no box around it, and makes no room
    least_lines: int = 3
    listed_share: float = 0.6  # of its lines that are in columns
    least_words: int = 8  # in columns
    many_lines: int = 10  # with as many, fewer words are enough, as in tables
    title_lines: int = 2  # with different words of title blocks
    size: float = 0.4  # of the area of the largest part, at most
    many_words: int = 40  # with as many in columns, any size
    # A column: at least as many lines below each other
    column_lines: int = 3
    left_offset: float = 0.8  # heights between left edges, at most
    line_distance: float = 3.0  # heights from a line to the next, at most
    alike_heights: float = 1.5  # ratio of the heights of two lines, at most
    max_texts: int = 400  # of a part; more are not compared, for time
    # A site plan
    site_size: float = 0.4  # of the area of the largest part, at most
    title_distance: float = 3.0  # heights of its letters between a site plan and its title


PARAMETERS = BoxParameters()


def count_words(texts: Sequence[PlacedText]) -> int:
    """The words of at least two letters in texts."""
    return sum(len(_WORD.findall(text.text)) for text in texts)


def share_in_columns(texts: Sequence[PlacedText]) -> float:
    """The share of texts that stand below each other, three and more with one left edge, as the lines of a list."""
    p = PARAMETERS
    if not p.column_lines <= len(texts) <= p.max_texts:
        return 0.0
    heights = np.array([max(text.height, 1e-9) for text in texts])
    tops, lefts = np.array([text.corners[0] for text in texts]).T
    height = np.minimum.outer(heights, heights)
    alike = np.maximum.outer(heights, heights) <= p.alike_heights * height
    aligned = np.abs(np.subtract.outer(lefts, lefts)) <= p.left_offset * height
    near = np.abs(np.subtract.outer(tops, tops)) <= p.line_distance * height
    _, columns = connected_components(alike & aligned & near, directed=False)
    return float((np.bincount(columns)[columns] >= p.column_lines).mean())


def name_box(texts: Sequence[PlacedText], legend: Sequence[PlacedText]) -> str:
    """LEGEND for a box with such a heading, or half of whose texts are in the legend of the sheet; else TEXT_BOX."""
    listed = set(map(id, legend))
    is_legend = 2 * sum(id(text) in listed for text in texts) >= len(texts) > 0
    return LEGEND if is_legend or any(names_legend(text.text) for text in texts) else TEXT_BOX


def find_boxes(parts: SheetParts, texts: Sequence[PlacedText], doors: Sequence[Floats] = ()) -> dict[int, str]:
    """What the parts of a sheet are that are no buildings, by number; the largest part always counts as one.

    doors: positions of certain doors, row and col; a part with one is a building.
    """
    numbers = parts.numbers
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
    buildings = {0, 1, *map(parts.number_at, doors)}
    boxes = {
        number: name_box(own, legend)
        for number, own in sorted(inside.items())
        if number not in buildings and _is_box(own, covers[number], areas[number] / areas[1])
    }
    plans = (
        _find_site_plan(text, parts, areas, {*buildings, *boxes}) for text in texts if _SITE_TITLE.search(text.text)
    )
    return boxes | {number: SITE_PLAN for number in plans if number is not None}


def _is_box(texts: Sequence[PlacedText], cover: float, size: float) -> bool:
    """Whether a part with these texts is a box of text. cover, size: its text, and itself, as in BoxParameters."""
    p = PARAMETERS
    if not p.text_cover <= cover < p.bare_text or len(texts) < p.least_lines:
        return False
    words, is_list = count_words(texts), share_in_columns(texts) >= p.listed_share
    if size > p.size:
        return is_list and words >= p.many_words
    titles = [{word.casefold() for word in _TITLE_WORDS.findall(text.text)} for text in texts]
    is_title = sum(map(bool, titles)) >= p.title_lines and len(set().union(*titles)) >= p.title_lines
    return is_title or (is_list and (words >= p.least_words or len(texts) >= p.many_lines))


def _find_site_plan(title: PlacedText, parts: SheetParts, areas: Indices, excluded: Collection[int]) -> int | None:
    """The number of the part to which the title of a site plan belongs, None without one.

    It is the nearest one that is far smaller than the largest part, larger than a line of text, and not excluded.
    areas: of all parts, cells, shape (N,).
    """
    p, cell_px = PARAMETERS, parts.cell_px
    low, high = title.corners.min(axis=0) / cell_px, title.corners.max(axis=0) / cell_px
    reach = p.title_distance * title.height / cell_px
    first, last = np.maximum(low - reach, 0).astype(int), np.maximum(high + reach, 0).astype(int) + 1
    near = parts.numbers[first[0] : last[0], first[1] : last[1]]
    written = float(np.prod(high - low)) + 2 * reach**2
    possible = (areas > written) & (areas <= p.site_size * areas[1])
    possible[[0, 1, *excluded]] = False
    cells = np.argwhere(possible[near])
    if not len(cells):
        return None
    offsets = np.maximum(np.maximum(low - 1 - first - cells, cells + first - high), 0)
    return int(near[tuple(cells[np.hypot(*offsets.T).argmin()])])


def describe_left_out(kinds: Sequence[str]) -> tuple[str, ...]:
    """What was left out as a line, such as "left out: a legend, 2 boxes of text"; none for nothing."""
    counts = Counter(kinds)
    named = [
        f"a {name}" if counts[name] == 1 else f"{counts[name]} {plural}"
        for name, plural in PLURALS.items()
        if counts[name]
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
