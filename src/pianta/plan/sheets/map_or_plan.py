"""Whether a file is a robot's map or a plan, and whether a picture can be a plan at all."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from pianta._types import Colors
from pianta.io._files import MAX_CELLS
from pianta.io.images import (
    IMAGE_SUFFIXES,
    PICTURE_SUFFIXES,
    DecodedImage,
    Source,
    open_image,
    path_of,
    read_colors,
    read_grey,
)

Kind = Literal["map", "plan"]
VECTOR_SUFFIXES = (".dxf", ".svg", ".pdf", ".ifc")
PLAN_SUFFIXES = (*PICTURE_SUFFIXES, *VECTOR_SUFFIXES)

# A map is grey. Colours of at least this chroma on more than this share of an image make it a plan,
CHROMA, COLORED = 40, 0.003
# and so does paper: greys from here on along most of its border,
PAPER, BORDER = 245, 0.5
# or so many greys that the three most frequent ones are less than this share, as on photos and scans.
FEW_GREYS = 0.5
# A drawing has few colours: this share of it at least has one of the most frequent TONES of 8 × 8 × 8 colours.
TONES, FREQUENT = 12, 0.45
# It is mostly paper, its ink seldom begins or ends from one pixel to the next, and some piece of it, which letters and
# specks are not, is as long as this share of its longer side. The plans of the data have 0.86 at least (0.60 where they
# are photographed in uneven light), 0.18 and 0.18 at most, 0.16 at least.
MOST_INK, MOST_CHANGES, LEAST_PIECE = 0.5, 0.5, 0.05
# Where floors are hatched, which looks like noise, some wall goes straight along this share of the longer side.
LEAST_WALL = 0.1
# Pixels of the shorter side of the smallest plan, and of the longer side by which pictures are judged.
LEAST_PX, JUDGED_PX = 16, 2000
# A transparent image is a map, whose unknown cells are left out, when this share of it is white.
WHITE = 0.05


def detect_input_kind(path: Source, *, max_cells: int = MAX_CELLS) -> Kind:
    """Whether a file is a robot's map or a plan: by its suffix, images by what they show.

    Maps are grey, have few greys, and do not end in free space; plans have paper, colours, or are photos.
    Raises MapError, in one line, for an image that cannot be read; other files are maps, whose reader says what is
    wrong with them.
    """
    suffix = Path(path_of(path)).suffix.lower()
    if suffix in VECTOR_SUFFIXES or suffix in set(PICTURE_SUFFIXES) - set(IMAGE_SUFFIXES):
        return "plan"
    if suffix not in IMAGE_SUFFIXES or suffix == ".pgm":
        return "map"
    image = path if isinstance(path, DecodedImage) else open_image(path, max_cells=max_cells)
    greys, transparent = read_grey(image)
    colors = read_colors(image)
    opaque = np.ones(greys.shape, bool) if transparent is None else ~transparent
    if ((colors.max(axis=2) - colors.min(axis=2) > CHROMA) & opaque).mean() > COLORED:
        return "plan"
    if transparent is not None:
        return "map" if ((greys >= PAPER) & opaque).mean() >= WHITE else "plan"
    border = np.concatenate([greys[0], greys[-1], greys[:, 0], greys[:, -1]])
    frequent = np.sort(np.bincount(greys.ravel(), minlength=256))[-3:].sum() / greys.size
    return "plan" if (border >= PAPER).mean() > BORDER or frequent < FEW_GREYS else "map"


def looks_like_drawing(colors: Colors) -> bool:
    """Whether a picture has what drawings have, and blank sheets, noise, photos and pages of text have not.

    colors: shape (H, W, 3). It takes no network and no reading of text, which both are slow.
    """
    import cv2

    from pianta.plan.sheets.binarization import binarise, straighten_tones

    if min(colors.shape[:2]) < LEAST_PX:
        return False
    red, green, blue = np.moveaxis(colors // 32, 2, 0).astype(np.int32)
    tones = np.sort(np.bincount(((red * 8 + green) * 8 + blue).ravel()))[-TONES:]
    if tones.sum() < FREQUENT * red.size:
        return False
    paper = straighten_tones(colors)
    step = -(-max(colors.shape) // JUDGED_PX)
    # The darkest of each block, so that thin lines stay.
    darkest = cv2.erode(paper, np.ones((step, step), np.uint8))[step // 2 :: step, step // 2 :: step]
    ink = binarise(np.asarray(darkest, np.uint8))
    changes = (ink[1:] != ink[:-1]).mean() + (ink[:, 1:] != ink[:, :-1]).mean()
    pieces = cv2.connectedComponentsWithStats(ink.astype(np.uint8), connectivity=8)[2][1:]
    longest = pieces[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(initial=0)
    if ink.mean() <= MOST_INK and changes <= MOST_CHANGES:
        return bool(longest >= LEAST_PIECE * max(ink.shape))
    sampled = binarise(paper[::step, ::step]).astype(np.uint8)
    wall = max(LEAST_PX, round(LEAST_WALL * max(sampled.shape)))
    return any(cv2.erode(sampled, np.ones(line, np.uint8)).any() for line in ((1, wall), (wall, 1)))
