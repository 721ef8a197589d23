"""Symbols on a sheet, found by template matching over scale and rotation (thesis, section 3.3), and their removal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pianta._types import Colors, Floats, Mask
from pianta.plan.sheets.binarization import PARAMETERS as INK_PARAMETERS
from pianta.plan.sheets.binarization import max_channel, min_channel
from pianta.plan.sheets.sheet import Sheet
from pianta.plan.symbols.poses import (
    PlacedSymbol,
    Pose,
    boost_faint_lines,
    find_colored,
    is_sign,
    place_symbol,
    resize,
    template_poses,
)
from pianta.plan.symbols.signs import PARAMETERS as SIGN_PARAMETERS
from pianta.plan.symbols.signs import find_signs
from pianta.plan.symbols.template_matching import Image, LargeImage, correlate, find_peaks
from pianta.plan.symbols.templates import Template


@dataclass(frozen=True, kw_only=True)
class SymbolParameters:
    """Thresholds of `find_symbols`; scores are those of TM_CCOEFF_NORMED, contrasts are boosted.

    Chosen by hand, no fit is on record.
    """

    # Pixels of a door to which the sheet is reduced
    coarse_door_px: float = 7.0  # where candidates are found
    fine_door_px: float = 16.0  # where they are matched
    sharp_door_px: float = 40.0  # where their lines are checked
    builtin_sizes: tuple[float, ...] = (0.76, 0.97, 1.22, 1.52)  # of our own templates, in doors of the sheet
    folder_sizes: tuple[float, ...] = (0.85, 1.0, 1.18)  # of templates that were cut out of such a sheet
    fine_sizes: tuple[float, ...] = (0.93, 1.0, 1.08)  # of a candidate, times its own
    min_coarse_score: float = 0.5  # of a candidate
    min_score: float = 0.68  # of a symbol
    min_triangle_score: float = 0.8  # of a half-open door, since many drawings have triangles
    max_candidates: int = 25  # of each template, size and pose
    max_overlap: float = 0.3  # of two symbols, share of the smaller one
    search_radius: float = 1.5  # door widths around the points near which doors are looked for
    # Lines of a symbol on the sharp sheet
    sheet_ink: float = 0.2  # contrast from which on a pixel of the sheet is drawn
    template_ink: float = 0.35  # contrast from which on a pixel of the template is a line
    template_clear: float = 0.1  # contrast below which it is clear
    min_clear_area: float = 0.08  # share of the template that is clear, else it cannot be checked
    min_drawn: float = 0.8  # share of the template's lines that are drawn
    min_clear: float = 0.85  # share of its clear pixels that are clear


@dataclass(frozen=True, kw_only=True)
class RemovalParameters:
    """Sizes of `remove_symbols`. Chosen by hand, no fit is on record."""

    margin: float = 0.7  # sizes of the symbol around it, in which the paper is looked for
    paper: float = 0.7  # share of the lightest pixel around, from which on a pixel is paper
    fringe_px: int = 5  # px between a sign and a wall that it covers
    min_line: float = 0.4  # length of a wall beside a sign, share of the sign, for the wall to be drawn on


PARAMETERS = SymbolParameters()
REMOVAL = RemovalParameters()


@dataclass(frozen=True, eq=False)
class _Reduced:
    """The contrast of a sheet reduced by a factor, at most 1."""

    image: Image
    factor: float


def find_symbols(
    sheet: Sheet, *, door_px: float, templates: Sequence[Template], near: ArrayLike | None = None
) -> tuple[PlacedSymbol, ...]:
    """The symbols on a sheet that match one of the templates, best first.

    door_px: pixels of a door, right within a factor of 1.6. near: shape (N, 2), row and col around which doors are
    looked for; None for everywhere. Our own templates are matched at many sizes, others at their own, within 20 %; all
    in four rotations, and our own doors mirrored.
    """
    points = None if near is None else np.asarray(near, float).reshape(-1, 2)
    signs = [template for template in templates if is_sign(template)]
    lines = [template for template in templates if not is_sign(template)]
    return tuple(_drop_covered([*_find_lines(sheet, lines, door_px, points), *find_signs(sheet.paper, signs, door_px)]))


def _find_lines(
    sheet: Sheet, templates: Sequence[Template], door_px: float, points: Floats | None
) -> Iterator[PlacedSymbol]:
    """The symbols that are drawn by lines."""
    if not templates:
        return
    p, contrast = PARAMETERS, boost_faint_lines(sheet.contrast)
    coarse, fine, sharp = (
        _reduce(contrast, min(1.0, px / door_px)) for px in (p.coarse_door_px, p.fine_door_px, p.sharp_door_px)
    )
    near = None
    if points is not None:
        near = _mask_near(coarse.image.shape, points * coarse.factor, p.search_radius * door_px * coarse.factor)
    everywhere = LargeImage(coarse.image)
    for template in templates:
        scale = 1.0 if template.door_px is None else door_px / template.door_px
        sizes = p.folder_sizes if template.door_px is None else p.builtin_sizes
        for size, pose in product(sizes, list(template_poses(template))):
            small = resize(pose.image, scale * size * coarse.factor)
            response = everywhere.correlate(small)
            if response is None:
                continue
            if near is not None and template.kind == "door":
                response[~near[_middles(response, small)]] = -1
            finer = [
                (scale * size * step, resize(pose.image, scale * size * step * fine.factor)) for step in p.fine_sizes
            ]
            for peak in find_peaks(response, least=p.min_coarse_score, most=p.max_candidates):
                symbol = _match_finely(fine, pose, finer, peak / coarse.factor)
                if symbol is not None and _has_lines(sharp, pose, symbol):
                    yield symbol


def _match_finely(
    fine: _Reduced, pose: Pose, sizes: Sequence[tuple[float, Image]], corner: Floats
) -> PlacedSymbol | None:
    """The symbol of a candidate, if it matches on the fine image.

    sizes: the scales to try, each with the image of the pose on the fine image. corner: row and col of the candidate's
    upper left corner on the sheet.
    """
    slack = round(3 * PARAMETERS.fine_door_px / PARAMETERS.coarse_door_px)
    start = np.maximum(np.round(corner * fine.factor).astype(int) - slack, 0)
    best: tuple[float, float, Floats] | None = None
    for scale, small in sizes:
        stop = start + small.shape[:2] + 2 * slack
        response = correlate(fine.image[start[0] : stop[0], start[1] : stop[1]], small)
        if response is None:
            continue
        _, score, _, (col, row) = cv2.minMaxLoc(response)
        if best is None or score > best[0]:
            best = score, scale, start + np.array([row, col])
    least = PARAMETERS.min_triangle_score if pose.template.name == "door 45" else PARAMETERS.min_score
    if best is None or best[0] < least:
        return None
    score, scale, best_corner = best
    return place_symbol(pose, scale, best_corner / fine.factor, score)


def _has_lines(sharp: _Reduced, pose: Pose, symbol: PlacedSymbol) -> bool:
    """Whether the lines of a symbol are drawn, and what it leaves clear is clear: walls are no windows."""
    p = PARAMETERS
    top, left = np.maximum(np.round(symbol.corners.min(axis=0) * sharp.factor).astype(int), 0)
    window = sharp.image[top:, left:]
    size = np.round(np.ptp(symbol.corners, axis=0) * sharp.factor).astype(int)
    small = cv2.resize(pose.image, (int(size[1]), int(size[0])), interpolation=cv2.INTER_AREA)
    small = small[: window.shape[0], : window.shape[1]]
    drawn_mask = (window[: small.shape[0], : small.shape[1]] > p.sheet_ink).astype(np.uint8)
    # A line may be one pixel off, on a reduced sheet two
    tolerance = np.ones((5, 5) if sharp.factor < 1 else (3, 3), np.uint8)
    lines, clear = small > p.template_ink, cv2.dilate(small, tolerance) < p.template_clear
    if not lines.any() or clear.mean() < p.min_clear_area:
        return False
    is_drawn = cv2.dilate(drawn_mask, tolerance)[lines].mean() >= p.min_drawn
    return bool(is_drawn and 1 - drawn_mask[clear].mean() >= p.min_clear)


def _reduce(image: Image, factor: float) -> _Reduced:
    return _Reduced(resize(image, factor) if factor < 1 else image, factor)


def _mask_near(shape: tuple[int, ...], points: Floats, radius: float) -> Mask:
    mask = np.zeros(shape, np.uint8)
    for row, col in points:
        cv2.circle(mask, (int(col), int(row)), max(1, round(radius)), 1, -1)
    return mask > 0


def _middles(response: Image, template: Image) -> tuple[slice, slice]:
    """Where the middles of the template lie on the image for a response."""
    top, left = (side // 2 for side in template.shape[:2])
    return slice(top, top + response.shape[0]), slice(left, left + response.shape[1])


def _drop_covered(symbols: Iterable[PlacedSymbol]) -> Iterator[PlacedSymbol]:
    """The best of symbols that cover each other, best first."""
    boxes: list[Floats] = []
    for symbol in sorted(symbols, key=lambda symbol: (-symbol.score, symbol.name)):
        box = np.array([symbol.corners.min(axis=0), symbol.corners.max(axis=0)])
        if all(_overlap(box, other) < PARAMETERS.max_overlap for other in boxes):
            boxes.append(box)
            yield symbol


def _overlap(box: Floats, other: Floats) -> float:
    """The share of the smaller of two boxes, shape (2, 2), that lies in the other."""
    shared = np.prod(np.maximum(np.minimum(box[1], other[1]) - np.maximum(box[0], other[0]), 0))
    return float(shared / min(np.prod(box[1] - box[0]), np.prod(other[1] - other[0])))


def remove_symbols(colors: Colors, symbols: Iterable[PlacedSymbol]) -> Colors:
    """The sheet with paper where symbols were drawn, shape (H, W, 3).

    The lines of a door or window are removed with a pixel around them, but not the wall at its jambs; signs with all
    that is connected to them in their colour, and walls that they interrupt are drawn on. The paper has the median of
    the light colours around.
    """
    cleared, covered = colors.copy(), np.zeros(colors.shape[:2], bool)
    for symbol in symbols:
        low, high = symbol.corners.min(axis=0), symbol.corners.max(axis=0)
        size = float((high - low).max())
        top, left = np.maximum(np.round(low - REMOVAL.margin * size).astype(int), 0)
        bottom, right = np.round(high + REMOVAL.margin * size).astype(int) + 1
        window = cleared[top:bottom, left:right]
        mask = _ink_in_window(window.shape[:2], symbol, np.round(low).astype(int) - (top, left))
        is_solid = symbol.ink.all()
        if is_solid:
            mask = _grow_in_color(window, mask)
        mask = np.asarray(cv2.dilate(mask, np.ones((3, 3), np.uint8)), np.uint8)
        for row, col in [] if symbol.jambs is None else symbol.jambs - (top, left):
            cv2.circle(mask, (int(col), int(row)), 1, 0, -1)
        around = window[(cv2.dilate(mask, np.ones((7, 7), np.uint8)) > 0) & (mask == 0)]
        if len(around):
            tones = around.sum(axis=1, dtype=int)
            light = around[tones >= max(np.median(tones), REMOVAL.paper * tones.max())]
            window[mask > 0] = np.median(light, axis=0).astype(np.uint8)
            covered[top:bottom, left:right] |= is_solid & (mask > 0)
    return _extend_walls(cleared, covered)


def _extend_walls(colors: Colors, covered: Mask) -> Colors:
    """The sheet with walls drawn on that lead along a row or column into what was covered from both sides."""
    fringe = REMOVAL.fringe_px
    black = (max_channel(colors) < INK_PARAMETERS.black) & ~covered
    walls = np.zeros_like(covered)
    for ink, gap, filled in ((black, covered, walls), (black.T, covered.T, walls.T)):
        edges = np.diff(np.pad(gap, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        for (row, start), (_, stop) in zip(np.argwhere(edges == 1), np.argwhere(edges == -1), strict=True):
            line = round(REMOVAL.min_line * (stop - start)) + fringe
            before, after = ink[row, max(start - line, 0) : start], ink[row, stop : stop + line]
            if min(before.sum(), after.sum()) >= line - fringe:
                filled[row, max(start - fringe, 0) : stop + fringe] = True
    colors[walls] = 0
    return colors


def _ink_in_window(shape: tuple[int, ...], symbol: PlacedSymbol, corner: NDArray[np.int64]) -> NDArray[np.uint8]:
    """The ink of a symbol as a mask of a window, with the symbol's corner at a row and col of the window."""
    mask = np.zeros(shape, np.uint8)
    ink = symbol.ink[max(-corner[0], 0) :, max(-corner[1], 0) :]
    target = mask[max(corner[0], 0) :, max(corner[1], 0) :][: ink.shape[0], : ink.shape[1]]
    target[:] = ink[: target.shape[0], : target.shape[1]]
    return mask


def _grow_in_color(window: Colors, mask: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A mask and what is connected to it in the strong colour that is most of it."""
    highest, main = max_channel(window), window.argmax(axis=2)
    strong, light = find_colored(highest, min_channel(window)), highest >= SIGN_PARAMETERS.light_green
    tones = np.where(strong, 2 * main + light, -1)
    inside = tones[(mask > 0) & strong]
    if not len(inside):
        return mask
    same = tones == np.bincount(inside).argmax()
    _, labels = cv2.connectedComponents(same.astype(np.uint8))
    touched = np.unique(labels[(mask > 0) & same])
    return np.asarray((mask > 0) | np.isin(labels, touched), np.uint8)
