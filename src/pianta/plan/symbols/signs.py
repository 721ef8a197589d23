"""Signs on a sheet: squares and pictures in the colours of safety signs, red, green and blue (ISO 7010)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from pianta._types import Colors
from pianta.plan.sheets.binarization import take_darkest, take_lightest
from pianta.plan.symbols.poses import (
    LEAST_CHROMA,
    PlacedSymbol,
    Pose,
    find_colored,
    place_symbol,
    resize,
    turn_template,
)
from pianta.plan.symbols.template_matching import respond
from pianta.plan.symbols.templates import Template

# Channels of colours.
RED, GREEN, BLUE = range(3)
# Top, left, height and width
_Box = tuple[int, int, int, int]

# Sizes of signs in doors; those of squares, which are signs whatever their picture, where the door is misjudged, too.
SIGN_SIZES, LARGEST_SQUARE = (0.4, 1.6), 5.0
# Signs need less than other symbols, as there is a spot of their colour, most of all a square.
SURE_SIGN, SURE_SQUARE = 0.55, 0.4
# Greens of ways are lighter than those of signs.
LIGHT_GREEN = 185
# White drawings part a sign into areas that are apart by so many doors at most, and grain by so many pixels.
JOINED, GRAIN = 0.4, 5
# Fringes of letters have colours, but few.
LEAST_COLORED = 0.3
# Sizes of a sign by the spot of its colour, or by its picture; what is a square; how full of colour the spot of one is.
SIGN_STEPS, SQUARE, FULL, MOST_IN_ROW = (0.8, 0.87, 0.94, 1.0, 1.08, 1.17), 1.3, 0.45, 8
# A square is a sign of any picture where so much of it is white, and so much coloured or white; what is white.
WHITE_SHARE, LEAST_PLAIN, LIGHTEST_GREY = (0.08, 0.5), 0.65, 130


def find_signs(colors: Colors, templates: Sequence[Template], door_px: float) -> Iterator[PlacedSymbol]:
    """The signs of a sheet, looked for where there is something of a strong colour, of about their size.

    colors: shape (H, W, 3), paper white. templates: of signs. door_px: pixels that a door spans.
    """
    if not templates:
        return
    poses = [(_main_channel(template), pose) for template in templates for pose in turn_template(template)]
    for channel, box in _find_blobs(colors, door_px):
        fitting = [pose for main, pose in poses if main == channel]
        is_small = min(box[2:]) <= SIGN_SIZES[1] * door_px
        symbol = _match_sign(colors, fitting, box) if is_small else None
        symbol = symbol or _take_square(colors, channel, box)
        if symbol is not None:
            yield symbol


def _take_square(colors: Colors, channel: int, box: _Box) -> PlacedSymbol | None:
    """The sign that a square of one colour with something white in it is, whatever its picture."""
    top, left, height, width = box
    part = colors[top : top + height, left : left + width]
    lightest, darkest = take_lightest(part), take_darkest(part)
    strong = find_colored(lightest, darkest)
    colored, white = strong & (part[..., channel] == lightest), ~strong & (darkest >= LIGHTEST_GREY)
    is_even = max(height, width) < SQUARE * min(height, width)
    is_plain = (colored | white).mean() >= LEAST_PLAIN and WHITE_SHARE[0] <= white.mean() <= WHITE_SHARE[1]
    if channel == BLUE or not (is_even and is_plain):
        return None
    corners = np.array([(0.0, 0.0), (0, width), (height, width), (height, 0)]) + np.array((top, left))
    return PlacedSymbol("sign", "object", corners, None, SURE_SQUARE, np.ones((height, width), bool))


def _match_sign(colors: Colors, poses: Sequence[Pose], box: _Box) -> PlacedSymbol | None:
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
            response = respond(part, resize(pose.image, scale)) if 0.6 < scale * least / side < 1.7 else None
            if response is not None:
                _, score, _, (col, row) = cv2.minMaxLoc(response)
                if best is None or score > best.score:
                    best = place_symbol(pose, scale, start + np.array([row, col]), score)
    sure = SURE_SQUARE if max(height, width) < SQUARE * side else SURE_SIGN
    return best if best is not None and best.score >= sure else None


def _find_blobs(colors: Colors, door_px: float) -> Iterator[tuple[int, _Box]]:
    """What is red, green or blue and as wide as a sign: its channel and its frame; signs in a row one by one."""
    least, most = SIGN_SIZES[0] * door_px, LARGEST_SQUARE * door_px
    lightest = take_lightest(colors)
    strong, light = find_colored(lightest, take_darkest(colors)), lightest >= LIGHT_GREEN
    joined = np.ones((max(GRAIN, round(JOINED * door_px)),) * 2, np.uint8)
    red = strong & (colors[..., 0] == lightest)
    green = strong & ~red & (colors[..., 1] == lightest)
    for channel, mask in ((RED, red), (BLUE, strong & ~red & ~green), (GREEN, green & light), (GREEN, green & ~light)):
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
