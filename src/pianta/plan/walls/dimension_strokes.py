"""Dimension lines are taken off a sheet before the network sees it, which would take them for walls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pianta._types import Mask
from pianta.plan.scale.dimension_lines import DimensionLine, list_dimension_lines
from pianta.plan.sheets.sheet import PlacedText, Sheet
from pianta.plan.walls.erased_strokes import erase_strokes


@dataclass(frozen=True, kw_only=True)
class DimensionStrokeParameters:
    """Thresholds of `erase_dimension_lines`; heights are those of the texts.

    Chosen by hand on one plan with such lines, and 61 without.
    """

    min_lines: int = 3  # which state the same scale: a room number beside a wall states one alone
    min_share: float = 0.4  # of the lines that state a scale
    agreement: float = 0.05  # of the logarithm of metres per pixel
    thickest: float = 0.3  # heights of a stroke: thicker ones are walls
    thicker_px: float = 1.0  # by which lines of one drawing differ in pixels


PARAMETERS = DimensionStrokeParameters()


def erase_dimension_lines(sheet: Sheet, texts: Sequence[PlacedText]) -> Sheet:
    """The sheet without its dimension lines: paper, or the colour of the room, where they were drawn.

    Only if several lines agree on the scale, so that they are dimension lines for certain; then all lines beside
    lengths that are as thin. What crosses a line stays, and so do its ticks.
    """
    lines = list_dimension_lines(texts, sheet.ink)
    agreeing = [lines[index] for index in _agreeing_lines(lines)]
    strokes = [_measure_stroke(line, sheet.ink) for line in agreeing]
    thickness = float(np.median(strokes)) if strokes else np.inf
    if not strokes or thickness > PARAMETERS.thickest * min(line.text_height for line in agreeing):
        return sheet
    mask = np.zeros(sheet.shape, bool)
    for line in lines:
        own = _measure_stroke(line, sheet.ink)
        if own <= thickness + PARAMETERS.thicker_px:
            _mark_stroke(line, sheet.ink, own + PARAMETERS.thicker_px, mask)
    return erase_strokes(sheet, mask, reach=round(2 * thickness + 2))


def _agreeing_lines(lines: Sequence[DimensionLine]) -> list[int]:
    """The lines that agree on the scale on which most do; none if too few."""
    p = PARAMETERS
    possible = {index: np.log(line.resolutions) for index, line in enumerate(lines) if line.pixels}
    if not possible:
        return []
    candidates = np.unique(np.concatenate([*possible.values()]).round(3))
    near = {
        index: np.abs(np.subtract.outer(candidates, scales)).min(axis=1) <= p.agreement
        for index, scales in possible.items()
    }
    best = int(np.sum([*near.values()], axis=0).argmax())
    agreeing = [index for index, is_near in near.items() if is_near[best]]
    return agreeing if len(agreeing) >= max(p.min_lines, p.min_share * len(possible)) else []


def _measure_stroke(line: DimensionLine, ink: Mask) -> float:
    """The thickness of most of a line, pixels."""
    return float(np.median(_stroke_around(line, ink)[1].sum(axis=0)))


def _mark_stroke(line: DimensionLine, ink: Mask, highest: float, mask: Mask) -> None:
    """Add the pixels of a line to a mask, without columns with more ink, where another line crosses."""
    rows, stroke = _stroke_around(line, ink)
    turned = mask if line.is_level else mask.T
    turned[rows, line.start : line.stop] |= stroke & (stroke.sum(axis=0) <= highest)


def _stroke_around(line: DimensionLine, ink: Mask) -> tuple[slice, Mask]:
    """The rows around a line, and what of its ink there is connected with it along each column."""
    reach = max(2, round(PARAMETERS.thickest * line.text_height)) + 1
    turned = ink if line.is_level else ink.T
    rows = slice(max(line.row - reach, 0), line.row + reach + 1)
    window, middle = turned[rows, line.start : line.stop], line.row - rows.start
    above = np.logical_and.accumulate(window[middle::-1])[::-1]
    below = np.logical_and.accumulate(window[middle + 1 :])
    return rows, np.concatenate([above, below])
