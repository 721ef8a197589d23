"""A grid that is drawn over a whole plan is taken off before the network sees it, which would take it for walls.

Grids of axes and of squared paper are known by their lines: straight, thin, as long as the drawing, and evenly spaced
in both directions.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pianta._types import Indices, Mask
from pianta.plan.sheets.sheet import Sheet
from pianta.plan.walls.erased_strokes import erase_strokes


@dataclass(frozen=True, kw_only=True)
class GridParameters:
    """Thresholds of `erase_grid`. Chosen by hand on one plan with a grid and 61 without."""

    tolerance: float = 0.002  # of the longer side of the sheet, by which a line drawn by hand or a photo is off
    gap: float = 8.0  # tolerances: shorter gaps in a line, as between dashes, are closed
    min_length: float = 0.5  # of the drawing that a line crosses
    min_spacing: float = 12.0  # tolerances between two lines: nearer ones are the two faces of a wall
    min_lines: int = 5  # in each direction
    min_span: float = 0.35  # of the drawing, from the first line to the last
    alike: float = 0.15  # by which the distances between neighbouring lines differ from each other
    thicker: float = 2.0  # strokes: where ink along a line is thicker, something else is drawn


PARAMETERS = GridParameters()


def erase_grid(sheet: Sheet) -> Sheet:
    """The sheet without its grid: paper where its lines were drawn; the same sheet if it has none.

    What is thicker than a line of the grid stays, and so does what crosses it.
    """
    tolerance = max(1, round(PARAMETERS.tolerance * max(sheet.shape)))
    level, upright = (_find_even_lines(_find_lines(ink, tolerance), ink) for ink in (sheet.ink, sheet.ink.T))
    if not (len(level) and len(upright)):
        return sheet
    mask = _strokes_along(sheet.ink, level, tolerance) | _strokes_along(sheet.ink.T, upright, tolerance).T
    mask |= _crossings(sheet.ink, level, upright, tolerance)
    return erase_strokes(sheet, mask, reach=2 * tolerance + 3)


def _find_lines(ink: Mask, tolerance: int) -> Indices:
    """The rows along which ink goes on across the drawing, shape (N,)."""
    p = PARAMETERS
    thick = cv2.dilate(ink.astype(np.uint8), np.ones((2 * tolerance + 1, 1), np.uint8))
    closed = cv2.morphologyEx(thick, cv2.MORPH_CLOSE, np.ones((1, round(p.gap * tolerance) + 1), np.uint8))
    longest = _longest_runs(closed > 0)
    drawing = max(_extent(np.asarray(ink.any(axis=0))), 1)
    rows: list[int] = []
    for row in np.argsort(-longest, kind="stable"):
        if longest[row] < p.min_length * drawing:
            break
        if all(abs(row - other) >= p.min_spacing * tolerance for other in rows):
            rows.append(int(row))
    return np.sort(np.array(rows, int))


def _longest_runs(mask: Mask) -> Indices:
    """The length of the longest run of each row, shape (H,)."""
    longest, run = np.zeros(len(mask), int), np.zeros(len(mask), int)
    for column in mask.T:
        run = (run + 1) * column
        np.maximum(longest, run, out=longest)
    return longest


def _extent(mask: Mask) -> int:
    """From the first true value to the last."""
    indices = np.flatnonzero(mask)
    return int(indices[-1] - indices[0] + 1) if len(indices) else 0


def _find_even_lines(lines: Indices, ink: Mask) -> Indices:
    """The most lines each of which is as far from the one before; none if these are few, or near each other.

    Other lines, as of walls, may stand between them.
    """
    p, best = PARAMETERS, list[int]()
    distances = np.unique(np.abs(np.subtract.outer(lines, lines)))
    for distance in distances[distances > 0]:
        chains: dict[int, list[int]] = {}
        for line in lines.tolist():
            before = [chains[other] for other in chains if abs(line - other - distance) <= p.alike * distance]
            chains[line] = [*max(before, key=len, default=[]), line]
        best = max([best, *chains.values()], key=len)
    is_grid = len(best) >= p.min_lines and best[-1] - best[0] >= p.min_span * _extent(np.asarray(ink.any(axis=1)))
    return np.array(best if is_grid else [], int)


def _strokes_along(ink: Mask, rows: Indices, tolerance: int) -> Mask:
    """The ink within the tolerance around rows, without columns where it is thicker than most of the lines."""
    strokes = np.zeros_like(ink)
    reach = 2 * tolerance
    bands = [slice(max(row - reach, 0), row + reach + 1) for row in rows]
    heights = np.concatenate([ink[band].sum(axis=0) for band in bands])
    thickest = PARAMETERS.thicker * float(np.median(heights[heights > 0]))
    for band in bands:
        strokes[band] |= ink[band] & (ink[band].sum(axis=0) <= thickest)
    return strokes


def _crossings(ink: Mask, level: Indices, upright: Indices, tolerance: int) -> Mask:
    """The ink where level and upright lines cross, without crossings on which a wall stands."""
    strokes = np.zeros_like(ink)
    reach = 2 * tolerance
    windows = [
        (slice(max(row - reach, 0), row + reach + 1), slice(max(col - reach, 0), col + reach + 1))
        for row in level
        for col in upright
    ]
    areas = [int(ink[window].sum()) for window in windows]
    largest = PARAMETERS.thicker * float(np.median(areas))
    for window, area in zip(windows, areas, strict=True):
        if area <= largest:
            strokes[window] |= ink[window]
    return strokes
