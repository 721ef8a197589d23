"""Signs on a sheet: squares and pictures in the colours of safety signs, red, green and blue (ISO 7010)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pianta._types import Colors
from pianta.plan.sheets.binarization import max_channel, min_channel
from pianta.plan.symbols.poses import TONES, PlacedSymbol, Pose, find_colored, place_symbol, resize, template_poses
from pianta.plan.symbols.template_matching import correlate
from pianta.plan.symbols.templates import Template

# Channels of colours
RED, GREEN, BLUE = range(3)
# Top, left, height and width
_Box = tuple[int, int, int, int]


@dataclass(frozen=True, kw_only=True)
class SignParameters:
    """Thresholds of `find_signs`. Chosen by hand, no fit is on record."""

    min_size: float = 0.4  # door widths of the shorter side of a sign
    max_size: float = 1.6  # door widths; larger spots are signs only as squares
    max_square: float = 5.0  # door widths of a square, which is a sign even if the door's width is wrong
    min_score: float = 0.55  # of TM_CCOEFF_NORMED; less than other symbols need, as the colour counts, too
    min_square_score: float = 0.4  # for a square spot
    light_green: int = 185  # grey level of the highest channel: greens of escape routes are lighter than those of signs
    gap: float = 0.4  # door widths between the areas of one sign, which white drawings separate
    grain_px: int = 5  # px of grain between the areas of one sign, at least
    min_colored_share: float = 0.3  # of the box of a spot: the coloured fringes of letters have less
    scales: tuple[float, ...] = (0.8, 0.87, 0.94, 1.0, 1.08, 1.17)  # tried, of the spot's or the template's size
    min_spot_ratio: float = 0.6  # shorter side of the template over that of the spot
    max_spot_ratio: float = 1.7
    slack: float = 0.2  # shorter sides of the spot around it in which the template may lie
    square: float = 1.3  # longer side over shorter one of a square, at most
    full_share: float = 0.45  # of the box of a row of squares that is filled
    max_in_row: int = 8  # squares
    row_tolerance: float = 0.08  # by which the sides of a row may miss a whole number of squares
    white_share: tuple[float, float] = (0.08, 0.5)  # of a square that is a sign whatever its picture
    min_plain_share: float = 0.65  # of such a square, of its colour or white
    lightest_grey: int = 130  # grey level of the lowest channel from which on white is white


PARAMETERS = SignParameters()


def find_signs(colors: Colors, templates: Sequence[Template], door_px: float) -> Iterator[PlacedSymbol]:
    """The signs of a sheet, in spots of a strong colour that have about their size.

    colors: shape (H, W, 3), on white paper. templates: of signs. door_px: pixels of a door.
    """
    if not templates:
        return
    poses = [(_main_channel(template), pose) for template in templates for pose in template_poses(template)]
    for channel, box in _find_blobs(colors, door_px):
        fitting = [pose for main, pose in poses if main == channel]
        is_small = min(box[2:]) <= PARAMETERS.max_size * door_px
        symbol = _match_sign(colors, fitting, box) if is_small else None
        symbol = symbol or _plain_square(colors, channel, box)
        if symbol is not None:
            yield symbol


def _plain_square(colors: Colors, channel: int, box: _Box) -> PlacedSymbol | None:
    """The sign of a square of one colour with something white in it, whatever its picture."""
    p, (top, left, height, width) = PARAMETERS, box
    window = colors[top : top + height, left : left + width]
    highest, lowest = max_channel(window), min_channel(window)
    strong = find_colored(highest, lowest)
    colored, white = strong & (window[..., channel] == highest), ~strong & (lowest >= p.lightest_grey)
    is_square = max(height, width) < p.square * min(height, width)
    is_plain = (colored | white).mean() >= p.min_plain_share and p.white_share[0] <= white.mean() <= p.white_share[1]
    if channel == BLUE or not (is_square and is_plain):
        return None
    corners = np.array([(0.0, 0.0), (0, width), (height, width), (height, 0)]) + np.array((top, left))
    return PlacedSymbol("sign", "object", corners, None, p.min_square_score, np.ones((height, width), bool))


def _match_sign(colors: Colors, poses: Sequence[Pose], box: _Box) -> PlacedSymbol | None:
    """The sign that a spot of colour is a part of."""
    p, (top, left, height, width) = PARAMETERS, box
    side = min(height, width)
    slack = max(2, round(p.slack * side))
    start = np.maximum((top - slack, left - slack), 0)
    window = colors[start[0] : top + height + slack, start[1] : left + width + slack]
    best: PlacedSymbol | None = None
    for pose in poses:
        is_builtin, template_side = pose.template.door_px is not None, min(pose.image.shape[:2])
        for size in p.scales:
            scale = side / template_side * size if is_builtin else size
            if not p.min_spot_ratio < scale * template_side / side < p.max_spot_ratio:
                continue
            response = correlate(window, resize(pose.image, scale))
            if response is not None:
                _, score, _, (col, row) = cv2.minMaxLoc(response)
                if best is None or score > best.score:
                    best = place_symbol(pose, scale, start + np.array([row, col]), score)
    least = p.min_square_score if max(height, width) < p.square * side else p.min_score
    return best if best is not None and best.score >= least else None


def _find_blobs(colors: Colors, door_px: float) -> Iterator[tuple[int, _Box]]:
    """The spots in red, green or blue that are as wide as a sign: channel and box; signs in a row one by one."""
    p, highest = PARAMETERS, max_channel(colors)
    strong, light = find_colored(highest, min_channel(colors)), highest >= p.light_green
    gap = np.ones((max(p.grain_px, round(p.gap * door_px)),) * 2, np.uint8)
    red = strong & (colors[..., 0] == highest)
    green = strong & ~red & (colors[..., 1] == highest)
    for channel, mask in ((RED, red), (BLUE, strong & ~red & ~green), (GREEN, green & light), (GREEN, green & ~light)):
        if not mask.any():
            continue
        spots = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, gap)
        _, _, stats, _ = cv2.connectedComponentsWithStats(spots)
        for left, top, width, height, area in stats[1:].tolist():
            colored = mask[top : top + height, left : left + width].mean()
            is_wide = p.min_size * door_px <= min(height, width) <= p.max_square * door_px
            if is_wide and colored > p.min_colored_share:
                is_full = area > p.full_share * height * width
                yield from ((channel, box) for box in _split_row((top, left, height, width), is_full=is_full))


def _split_row(box: _Box, *, is_full: bool) -> Iterator[_Box]:
    """The squares of a row or column of squares; any other box itself."""
    top, left, height, width = box
    ratio = max(height, width) / min(height, width)
    count = round(ratio)
    is_whole = abs(ratio - count) <= PARAMETERS.row_tolerance * count
    if not (is_full and count <= PARAMETERS.max_in_row and is_whole):
        yield box
        return
    for number in range(count):
        if height > width:
            yield top + number * height // count, left, height // count, width
        else:
            yield top, left + number * width // count, height, width // count


def _main_channel(template: Template) -> int:
    """The channel that is the highest where a sign has colours."""
    strong = template.image[np.ptp(template.image, axis=2) > TONES.min_chroma]
    return int(strong.mean(axis=0).argmax())
