"""Symbols on a sheet, found by template matching over scale and rotation (thesis, section 3.3), and their removal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pianta.plan.paper import measure_contrast, straighten_tones, take_darkest, take_lightest
from pianta.plan.sheet import Colors
from pianta.plan.symbol_drawings import Kind
from pianta.plan.symbol_templates import Template
from pianta.plan.template_matching import LargeImage, find_peaks, respond

Floats = NDArray[np.float64]
Image = NDArray[Any]
# Top, left, height and width
_Box = tuple[int, int, int, int]

# Pixels of a door where places are looked for, where they are matched, and where their lines are checked.
COARSE_DOOR, FINE_DOOR, SHARP_DOOR = 7.0, 16.0, 40.0
# Sizes of our own line symbols, in doors as wide as the sheet's, and of symbols cut out of such a sheet.
OWN_SIZES, CUT_SIZES, SIGN_SIZES = (0.76, 0.97, 1.22, 1.52), (0.85, 1.0, 1.18), (0.4, 1.6)
FINER = (0.93, 1.0, 1.08)
# What is likely enough to look closer, and what is one: scores of TM_CCOEFF_NORMED.
LIKELY, SURE = 0.5, 0.68
# Half-open doors are a triangle, as much is; signs need less, as there is a spot of their colour, most of all a square.
SURE_TRIANGLE, SURE_SIGN, SURE_SQUARE = 0.8, 0.55, 0.4
# Of the lines of a symbol so much is drawn at least, and so much between them is clear.
LEAST_DRAWN, LEAST_CLEAR = 0.8, 0.85
MAX_LIKELY = 25
# Symbols share so little of the smaller one.
MOST_SHARED = 0.3
# Doors are looked for so many doors around the places that are given.
AROUND = 1.5
# Colours of signs are so far from grey; greens of ways are lighter than those of signs.
LEAST_CHROMA, LIGHT_GREEN = 45, 185
# White drawings part a sign into areas that are apart by so many doors at most.
JOINED = 0.4
# Fringes of letters have colours, but few.
LEAST_COLORED = 0.3
# Sizes of a sign by the spot of its colour, or by its picture; what is a square; how full of colour the spot of one is.
SIGN_STEPS, SQUARE, FULL, MOST_IN_ROW = (0.8, 0.87, 0.94, 1.0, 1.08, 1.17), 1.3, 0.55, 8


@dataclass(frozen=True, eq=False)
class PlacedSymbol:
    """A symbol on a sheet.

    corners: shape (4, 2), row and col in continuous pixels, from the upper left of the template clockwise, mirrored as
    it is. jambs: shape (2, 2), the ends of the gap of a door or window. score: 0 … 1, of the match.
    drawn: what of the template is ink, shape (H, W), as it lies on the sheet from the least row and col of its corners.
    """

    name: str
    kind: Kind
    corners: Floats
    jambs: Floats | None
    score: float
    drawn: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class _Pose:
    """A template turned: its image, and the matrix, shape (2, 3), from its row, col to those of the template turned."""

    template: Template
    image: Image
    matrix: Floats


def find_symbols(
    colors: Colors, *, door_px: float, templates: Sequence[Template], at: ArrayLike | None = None
) -> tuple[PlacedSymbol, ...]:
    """The symbols on a sheet that look like one of the templates, best first.

    colors: shape (H, W, 3). door_px: pixels that a door spans, right within a factor of 1.6. at: shape (N, 2), row and
    col near which doors are looked for; None for everywhere. Own templates are found at many sizes, others at their
    own, within 20 %; all in four rotations, and our own doors mirrored.
    """
    places = None if at is None else np.asarray(at, float).reshape(-1, 2)
    signs = [template for template in templates if _is_sign(template)]
    lines = [template for template in templates if not _is_sign(template)]
    found = [*_find_lines(colors, lines, door_px, places), *_find_signs(straighten_tones(colors), signs, door_px)]
    return tuple(_leave_out_lesser(found))


def _find_lines(
    colors: Colors, templates: Sequence[Template], door_px: float, places: Floats | None
) -> Iterator[PlacedSymbol]:
    if not templates:
        return
    contrast = _lift(measure_contrast(colors))
    coarse, fine, sharp = (_reduce(contrast, min(1.0, door / door_px)) for door in (COARSE_DOOR, FINE_DOOR, SHARP_DOOR))
    near = None if places is None else _mask_near(coarse[0].shape, places * coarse[1], AROUND * door_px * coarse[1])
    everywhere = LargeImage(coarse[0])
    for template in templates:
        scale = 1.0 if template.door_px is None else door_px / template.door_px
        sizes = CUT_SIZES if template.door_px is None else OWN_SIZES
        poses = list(_turn(template))
        for size, pose in product(sizes, poses):
            small = _resize(pose.image, scale * size * coarse[1])
            response = everywhere.respond(small)
            if response is None:
                continue
            if near is not None and template.kind == "door":
                response[~near[_middle_of(response, small)]] = -1
            finer = [(scale * size * step, _resize(pose.image, scale * size * step * fine[1])) for step in FINER]
            for place in find_peaks(response, least=LIKELY, most=MAX_LIKELY):
                symbol = _look_closer(fine, pose, finer, place / coarse[1])
                if symbol is not None and _is_drawn(sharp, pose, symbol):
                    yield symbol


def _look_closer(
    fine: tuple[Image, float], pose: _Pose, sizes: Sequence[tuple[float, Image]], place: Floats
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
    return _place(pose, scale, corner / factor, score)


def _is_drawn(sharp: tuple[Image, float], pose: _Pose, symbol: PlacedSymbol) -> bool:
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


def _place(pose: _Pose, scale: float, corner: Floats, score: float) -> PlacedSymbol:
    template = pose.template
    height, width = template.image.shape[:2]

    def on_sheet(points: ArrayLike) -> Floats:
        turned: Floats = np.asarray(points, float) @ pose.matrix[:, :2].T + pose.matrix[:, 2]
        return turned * scale + corner

    jambs = None if template.jambs is None else on_sheet(template.jambs)
    corners = on_sheet([(0, 0), (0, width), (height, width), (height, 0)])
    drawn = _resize(pose.image, scale) > 0.25 if pose.image.ndim == 2 else np.ones(_scaled(pose.image, scale), bool)
    return PlacedSymbol(template.name, template.kind, corners, jambs, float(score), drawn)


def _find_signs(colors: Colors, templates: Sequence[Template], door_px: float) -> Iterator[PlacedSymbol]:
    """Signs are looked for where there is something of a strong colour, of about their size."""
    if not templates:
        return
    poses = [(_main_channel(template), pose) for template in templates for pose in _turn(template)]
    for channel, box in _find_blobs(colors, door_px):
        fitting = [pose for main, pose in poses if main == channel]
        symbol = _match_sign(colors, fitting, box)
        if symbol is not None:
            yield symbol


def _match_sign(colors: Colors, poses: Sequence[_Pose], box: _Box) -> PlacedSymbol | None:
    """The sign that a spot of colour is a part of."""
    top, left, height, width = box
    side = min(height, width)
    slack = max(2, round(0.2 * side))
    start = np.maximum((top - slack, left - slack), 0)
    part = colors[start[0] : top + height + slack, start[1] : left + width + slack]
    best: PlacedSymbol | None = None
    for pose in poses:
        own, least = pose.template.door_px is not None, min(pose.image.shape[:2])
        for size in SIGN_STEPS:
            scale = side / least * size if own else size
            response = respond(part, _resize(pose.image, scale)) if 0.6 < scale * least / side < 1.7 else None
            if response is not None:
                _, score, _, (col, row) = cv2.minMaxLoc(response)
                if best is None or score > best.score:
                    best = _place(pose, scale, start + np.array([row, col]), score)
    sure = SURE_SQUARE if max(height, width) < SQUARE * side else SURE_SIGN
    return best if best is not None and best.score >= sure else None


def _find_blobs(colors: Colors, door_px: float) -> Iterator[tuple[int, _Box]]:
    """What is red, green or blue and as wide as a sign: its channel and its frame; signs in a row one by one."""
    least, most = (size * door_px for size in SIGN_SIZES)
    lightest = take_lightest(colors)
    strong, light = lightest - take_darkest(colors) > LEAST_CHROMA, lightest >= LIGHT_GREEN
    joined = np.ones((max(3, round(JOINED * door_px)),) * 2, np.uint8)
    red = strong & (colors[..., 0] == lightest)
    green = strong & ~red & (colors[..., 1] == lightest)
    for channel, mask in ((0, red), (2, strong & ~red & ~green), (1, green & light), (1, green & ~light)):
        if not mask.any():
            continue
        spots = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, joined)
        _, _, stats, _ = cv2.connectedComponentsWithStats(spots)
        for left, top, width, height, area in stats[1:].tolist():
            colored = mask[top : top + height, left : left + width].mean()
            if least <= min(height, width) <= most and colored > LEAST_COLORED:
                full = area > FULL * height * width
                yield from ((channel, box) for box in _split_row((top, left, height, width), full=full))


def _split_row(box: _Box, *, full: bool) -> Iterator[_Box]:
    """The squares of a row or column of squares; the box itself when it is none."""
    top, left, height, width = box
    side = min(height, width)
    count = round(max(height, width) / side)
    if not full or count > MOST_IN_ROW or abs(max(height, width) / side - count) > 0.08 * count:
        yield box
        return
    for number in range(count):
        if height > width:
            yield top + number * height // count, left, height // count, width
        else:
            yield top, left + number * width // count, height, width // count


def _main_channel(template: Template) -> int:
    """The channel that is the strongest where a sign has colours."""
    strong = template.image[np.ptp(template.image, axis=2) > LEAST_CHROMA]
    return int(strong.mean(axis=0).argmax())


def _is_sign(template: Template) -> bool:
    """Whether a template is told by its colours."""
    if template.image.ndim == 2 or template.kind != "object":
        return False
    return bool((np.ptp(template.image, axis=2) > LEAST_CHROMA).mean() > 0.1)


def _turn(template: Template) -> Iterator[_Pose]:
    """A template in the rotations that differ; doors, windows and what is drawn by lines mirrored, too."""
    image = template.image if _is_sign(template) else _contrast_of(template.image)
    height, width = image.shape[:2]
    own = template.door_px is not None
    turns = range(1 if own and _is_sign(template) and template.name != "way out" else 4)
    seen: list[Image] = []
    for mirrored, quarter in product((False, True) if own and not _is_sign(template) else (False,), turns):
        pose = np.rot90(image[:, ::-1] if mirrored else image, quarter)
        if any(pose.shape == other.shape and np.abs(pose - other).mean() < 0.02 for other in seen):
            continue
        seen.append(pose)
        yield _Pose(template, np.ascontiguousarray(pose), _turn_matrix(height, width, mirrored, quarter))


def _turn_matrix(height: int, width: int, mirrored: bool, quarter: int) -> Floats:  # noqa: FBT001
    """From row, col of an image to those of the image mirrored left to right and turned by np.rot90; shape (2, 3)."""
    matrix = np.array([[1.0, 0, 0], [0, -1, width]] if mirrored else [[1.0, 0, 0], [0, 1, 0]])
    for _ in range(quarter):
        matrix = np.array([[0.0, -1], [1, 0]]) @ matrix + np.array([[0, 0, width], [0, 0, 0]])
        height, width = width, height
    return matrix


def _contrast_of(image: Image) -> Image:
    """How dark each pixel of a template is, as of measure_contrast, lifted."""
    darkest = image if image.ndim == 2 else image.min(axis=2)
    paper = float(np.percentile(darkest, 90))
    return _lift(np.clip((paper - darkest.astype(np.float32)) / 60, 0, 1))


def _lift(contrast: Image) -> Image:
    """Hair-light lines count nearly as much as black ones."""
    return np.sqrt(np.maximum(contrast - np.float32(0.06), 0)).astype(np.float32)


def _reduce(image: Image, factor: float) -> tuple[Image, float]:
    return (_resize(image, factor) if factor < 1 else image), factor


def _scaled(image: Image, factor: float) -> tuple[int, int]:
    height, width = (max(1, round(side * factor)) for side in image.shape[:2])
    return height, width


def _resize(image: Image, factor: float) -> Image:
    way = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(image, _scaled(image, factor)[::-1], interpolation=way))


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
    that is connected to them in their colour. The paper has the median of the light colours around.
    """
    cleared = colors.copy()
    for symbol in symbols:
        low, high = symbol.corners.min(axis=0), symbol.corners.max(axis=0)
        size = float((high - low).max())
        top, left = np.maximum(np.round(low - 0.7 * size).astype(int), 0)
        bottom, right = np.round(high + 0.7 * size).astype(int) + 1
        part = cleared[top:bottom, left:right]
        mask = _lay_on(part.shape[:2], symbol, np.round(low).astype(int) - (top, left))
        if symbol.drawn.all():
            mask = _grow_in_color(part, mask)
        mask = np.asarray(cv2.dilate(mask, np.ones((3, 3), np.uint8)), np.uint8)
        for row, col in [] if symbol.jambs is None else symbol.jambs - (top, left):
            cv2.circle(mask, (int(col), int(row)), 1, 0, -1)
        around = part[(cv2.dilate(mask, np.ones((7, 7), np.uint8)) > 0) & (mask == 0)]
        if len(around):
            light = around[around.sum(axis=1) >= np.median(around.sum(axis=1))]
            part[mask > 0] = np.median(light, axis=0).astype(np.uint8)
    return cleared


def _lay_on(shape: tuple[int, ...], symbol: PlacedSymbol, corner: NDArray[np.int64]) -> NDArray[np.uint8]:
    """What a symbol draws, with its corner at a row and col of a mask."""
    mask = np.zeros(shape, np.uint8)
    drawn = symbol.drawn[max(-corner[0], 0) :, max(-corner[1], 0) :]
    there = mask[max(corner[0], 0) :, max(corner[1], 0) :][: drawn.shape[0], : drawn.shape[1]]
    there[:] = drawn[: there.shape[0], : there.shape[1]]
    return mask


def _grow_in_color(part: Colors, mask: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A mask and what is connected to it in the strong colour that is most of it."""
    strong, main = np.ptp(part, axis=2) > LEAST_CHROMA, part.argmax(axis=2)
    light = part.max(axis=2) >= LIGHT_GREEN
    tones = np.where(strong, 2 * main + light, -1)
    inside = tones[(mask > 0) & strong]
    if not len(inside):
        return mask
    same = tones == np.bincount(inside).argmax()
    _, labels = cv2.connectedComponents(same.astype(np.uint8))
    touched = np.unique(labels[(mask > 0) & same])
    return np.asarray((mask > 0) | np.isin(labels, touched), np.uint8)
