"""Symbols on a sheet, found by template matching over scale and rotation (thesis, section 3.3), and their removal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import product

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pianta._types import Colors, Floats
from pianta.plan.sheets.binarization import BLACK, measure_contrast, straighten_tones, take_darkest, take_lightest
from pianta.plan.symbols.poses import (
    Image,
    PlacedSymbol,
    Pose,
    find_colored,
    is_sign,
    lift,
    place_symbol,
    resize,
    turn_template,
)
from pianta.plan.symbols.signs import LIGHT_GREEN, find_signs
from pianta.plan.symbols.template_matching import LargeImage, find_peaks, respond
from pianta.plan.symbols.templates import Template

# Pixels of a door where places are looked for, where they are matched, and where their lines are checked.
COARSE_DOOR, FINE_DOOR, SHARP_DOOR = 7.0, 16.0, 40.0
# Sizes of our own line symbols, in doors as wide as the sheet's, and of symbols cut out of such a sheet.
OWN_SIZES, CUT_SIZES = (0.76, 0.97, 1.22, 1.52), (0.85, 1.0, 1.18)
FINER = (0.93, 1.0, 1.08)
# What is likely enough to look closer, and what is one: scores of TM_CCOEFF_NORMED.
LIKELY, SURE = 0.5, 0.68
# Half-open doors are a triangle, as much is.
SURE_TRIANGLE = 0.8
# Of the lines of a symbol so much is drawn at least, and so much between them is clear.
LEAST_DRAWN, LEAST_CLEAR = 0.8, 0.85
MAX_LIKELY = 25
# Symbols share so little of the smaller one.
MOST_SHARED = 0.3
# Paper is as light as this share of the lightest around.
PAPER = 0.7
# Between a sign and a wall that it covers are so many pixels of fringe; the wall leads on for this share of the sign.
FRINGE, AS_LINE = 5, 0.4
# Doors are looked for so many doors around the places that are given.
AROUND = 1.5


def find_symbols(
    colors: Colors, *, door_px: float, templates: Sequence[Template], at: ArrayLike | None = None
) -> tuple[PlacedSymbol, ...]:
    """The symbols on a sheet that look like one of the templates, best first.

    colors: shape (H, W, 3). door_px: pixels that a door spans, right within a factor of 1.6. at: shape (N, 2), row and
    col near which doors are looked for; None for everywhere. Own templates are found at many sizes, others at their
    own, within 20 %; all in four rotations, and our own doors mirrored.
    """
    places = None if at is None else np.asarray(at, float).reshape(-1, 2)
    signs = [template for template in templates if is_sign(template)]
    lines = [template for template in templates if not is_sign(template)]
    found = [*_find_lines(colors, lines, door_px, places), *find_signs(straighten_tones(colors), signs, door_px)]
    return tuple(_leave_out_lesser(found))


def _find_lines(
    colors: Colors, templates: Sequence[Template], door_px: float, places: Floats | None
) -> Iterator[PlacedSymbol]:
    if not templates:
        return
    contrast = lift(measure_contrast(colors))
    coarse, fine, sharp = (_reduce(contrast, min(1.0, door / door_px)) for door in (COARSE_DOOR, FINE_DOOR, SHARP_DOOR))
    near = None if places is None else _mask_near(coarse[0].shape, places * coarse[1], AROUND * door_px * coarse[1])
    everywhere = LargeImage(coarse[0])
    for template in templates:
        scale = 1.0 if template.door_px is None else door_px / template.door_px
        sizes = CUT_SIZES if template.door_px is None else OWN_SIZES
        poses = list(turn_template(template))
        for size, pose in product(sizes, poses):
            small = resize(pose.image, scale * size * coarse[1])
            response = everywhere.respond(small)
            if response is None:
                continue
            if near is not None and template.kind == "door":
                response[~near[_middle_of(response, small)]] = -1
            finer = [(scale * size * step, resize(pose.image, scale * size * step * fine[1])) for step in FINER]
            for place in find_peaks(response, least=LIKELY, most=MAX_LIKELY):
                symbol = _look_closer(fine, pose, finer, place / coarse[1])
                if symbol is not None and _is_drawn(sharp, pose, symbol):
                    yield symbol


def _look_closer(
    fine: tuple[Image, float], pose: Pose, sizes: Sequence[tuple[float, Image]], place: Floats
) -> PlacedSymbol | None:
    """The symbol at a place, row and col of its upper left corner on the sheet, when it is one on the fine image.

    sizes: the scales that are tried, each with the image of the pose as it is on the fine image.
    """
    image, factor = fine
    slack = round(3 * FINE_DOOR / COARSE_DOOR)
    start = np.maximum(np.round(place * factor).astype(int) - slack, 0)
    best: tuple[float, float, Floats] | None = None
    for scale, small in sizes:
        stop = start + small.shape[:2] + 2 * slack
        response = respond(image[start[0] : stop[0], start[1] : stop[1]], small)
        if response is None:
            continue
        _, score, _, (col, row) = cv2.minMaxLoc(response)
        if best is None or score > best[0]:
            best = score, scale, start + np.array([row, col])
    if best is None or best[0] < (SURE_TRIANGLE if pose.template.name == "door 45" else SURE):
        return None
    score, scale, corner = best
    return place_symbol(pose, scale, corner / factor, score)


def _is_drawn(sharp: tuple[Image, float], pose: Pose, symbol: PlacedSymbol) -> bool:
    """Whether what a symbol draws is there, and what it leaves clear is clear: walls are no windows."""
    image, factor = sharp
    top, left = np.maximum(np.round(symbol.corners.min(axis=0) * factor).astype(int), 0)
    there = image[top:, left:]
    size = np.round(np.ptp(symbol.corners, axis=0) * factor).astype(int)
    small = cv2.resize(pose.image, (int(size[1]), int(size[0])), interpolation=cv2.INTER_AREA)
    small = small[: there.shape[0], : there.shape[1]]
    there = (there[: small.shape[0], : small.shape[1]] > 0.2).astype(np.uint8)
    room = np.ones((5, 5) if factor * FINE_DOOR < SHARP_DOOR * 0.9 and factor < 1 else (3, 3), np.uint8)
    ink, clear = small > 0.35, cv2.dilate(small, room) < 0.1
    if not ink.any() or clear.mean() < 0.08:
        return False
    return bool(cv2.dilate(there, room)[ink].mean() >= LEAST_DRAWN and 1 - there[clear].mean() >= LEAST_CLEAR)


def _reduce(image: Image, factor: float) -> tuple[Image, float]:
    return (resize(image, factor) if factor < 1 else image), factor


def _mask_near(shape: tuple[int, ...], places: Floats, reach: float) -> NDArray[np.bool_]:
    mask = np.zeros(shape, np.uint8)
    for row, col in places:
        cv2.circle(mask, (int(col), int(row)), max(1, round(reach)), 1, -1)
    return mask > 0


def _middle_of(response: Image, template: Image) -> tuple[slice, slice]:
    """Where the middles of the template lie on the image for a response."""
    top, left = (side // 2 for side in template.shape[:2])
    return slice(top, top + response.shape[0]), slice(left, left + response.shape[1])


def _leave_out_lesser(symbols: Iterable[PlacedSymbol]) -> Iterator[PlacedSymbol]:
    """The best of symbols that cover each other, best first."""
    kept: list[Floats] = []
    for symbol in sorted(symbols, key=lambda symbol: (-symbol.score, symbol.name)):
        box = np.array([symbol.corners.min(axis=0), symbol.corners.max(axis=0)])
        if all(_shared_part(box, other) < MOST_SHARED for other in kept):
            kept.append(box)
            yield symbol


def _shared_part(box: Floats, other: Floats) -> float:
    """How much of the smaller of two boxes, shape (2, 2), lies in the other."""
    shared = np.prod(np.maximum(np.minimum(box[1], other[1]) - np.maximum(box[0], other[0]), 0))
    return float(shared / min(np.prod(box[1] - box[0]), np.prod(other[1] - other[0])))


def remove_symbols(colors: Colors, symbols: Iterable[PlacedSymbol]) -> Colors:
    """The sheet without symbols: paper where they were drawn, shape (H, W, 3).

    What is drawn of a door or window goes with a stroke around it, but not the wall at its jambs; signs go with all
    that is connected to them in their colour, and walls that they interrupt are drawn on. The paper has the median of
    the light colours around.
    """
    cleared, covered = colors.copy(), np.zeros(colors.shape[:2], bool)
    for symbol in symbols:
        low, high = symbol.corners.min(axis=0), symbol.corners.max(axis=0)
        size = float((high - low).max())
        top, left = np.maximum(np.round(low - 0.7 * size).astype(int), 0)
        bottom, right = np.round(high + 0.7 * size).astype(int) + 1
        part = cleared[top:bottom, left:right]
        mask = _lay_on(part.shape[:2], symbol, np.round(low).astype(int) - (top, left))
        is_solid = symbol.drawn.all()
        if is_solid:
            mask = _grow_in_color(part, mask)
        mask = np.asarray(cv2.dilate(mask, np.ones((3, 3), np.uint8)), np.uint8)
        for row, col in [] if symbol.jambs is None else symbol.jambs - (top, left):
            cv2.circle(mask, (int(col), int(row)), 1, 0, -1)
        around = part[(cv2.dilate(mask, np.ones((7, 7), np.uint8)) > 0) & (mask == 0)]
        if len(around):
            tones = around.sum(axis=1, dtype=int)
            light = around[tones >= max(np.median(tones), PAPER * tones.max())]
            part[mask > 0] = np.median(light, axis=0).astype(np.uint8)
            covered[top:bottom, left:right] |= is_solid & (mask > 0)
    return _draw_lines_on(cleared, covered)


def _draw_lines_on(colors: Colors, covered: NDArray[np.bool_]) -> Colors:
    """The sheet with the lines drawn on that lead along a row or column into what was covered from both sides."""
    black = (take_lightest(colors) < BLACK) & ~covered
    drawn = np.zeros_like(covered)
    for ink, gap, filled in ((black, covered, drawn), (black.T, covered.T, drawn.T)):
        edges = np.diff(np.pad(gap, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        for (row, start), (_, stop) in zip(np.argwhere(edges == 1), np.argwhere(edges == -1), strict=True):
            line = round(AS_LINE * (stop - start)) + FRINGE
            before, after = ink[row, max(start - line, 0) : start], ink[row, stop : stop + line]
            if min(before.sum(), after.sum()) >= line - FRINGE:
                filled[row, max(start - FRINGE, 0) : stop + FRINGE] = True
    colors[drawn] = 0
    return colors


def _lay_on(shape: tuple[int, ...], symbol: PlacedSymbol, corner: NDArray[np.int64]) -> NDArray[np.uint8]:
    """What a symbol draws, with its corner at a row and col of a mask."""
    mask = np.zeros(shape, np.uint8)
    drawn = symbol.drawn[max(-corner[0], 0) :, max(-corner[1], 0) :]
    there = mask[max(corner[0], 0) :, max(corner[1], 0) :][: drawn.shape[0], : drawn.shape[1]]
    there[:] = drawn[: there.shape[0], : there.shape[1]]
    return mask


def _grow_in_color(part: Colors, mask: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A mask and what is connected to it in the strong colour that is most of it."""
    lightest, main = take_lightest(part), part.argmax(axis=2)
    strong, light = find_colored(lightest, take_darkest(part)), lightest >= LIGHT_GREEN
    tones = np.where(strong, 2 * main + light, -1)
    inside = tones[(mask > 0) & strong]
    if not len(inside):
        return mask
    same = tones == np.bincount(inside).argmax()
    _, labels = cv2.connectedComponents(same.astype(np.uint8))
    touched = np.unique(labels[(mask > 0) & same])
    return np.asarray((mask > 0) | np.isin(labels, touched), np.uint8)
