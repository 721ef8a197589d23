"""Whether a file is a robot's map or a plan, and whether a picture can be a plan at all."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from pianta._types import Colors
from pianta.io._files import MAX_CELLS
from pianta.io.geotiffs import has_geotags
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
from pianta.io.valetudo import is_wrapped

InputKind = Literal["map", "plan"]
VECTOR_SUFFIXES = (".dxf", ".svg", ".pdf", ".ifc", ".sh3d")
PLAN_SUFFIXES = (*PICTURE_SUFFIXES, *VECTOR_SUFFIXES)


@dataclass(frozen=True, kw_only=True)
class MapOrPlanParameters:
    """Thresholds between maps and plans; shares are of all pixels. Chosen by hand, no fit is on record."""

    min_chroma: int = 40  # levels between the channels of a coloured pixel
    max_colored_share: float = 0.003  # more coloured pixels make a plan
    paper: int = 245  # grey level from which on a pixel is white paper
    max_paper_border: float = 0.5  # share of the border; more paper makes a plan
    min_frequent_share: float = 0.5  # share of the three most frequent greys; less makes a plan, as of photos and scans
    min_white_share: float = 0.05  # of a transparent image; more is free space, so the image is a map


@dataclass(frozen=True, kw_only=True)
class DrawingParameters:
    """Thresholds between drawings and other pictures; shares are of all pixels.

    Chosen on the plans of the data, which have a share of frequent colors of 0.86 at least (0.60 where photographed in
    uneven light), of ink of 0.18 and of changes of 0.18 at most, and a longest piece of 0.16 at least.
    """

    min_side_px: int = 16  # pixels of the shorter side
    max_working_px: int = 2000  # pixels of the longer side; larger pictures are reduced
    n_frequent_colors: int = 12  # of 8 × 8 × 8
    min_frequent_share: float = 0.45  # share of the most frequent colors
    max_ink_share: float = 0.5
    max_change_share: float = 0.5  # neighbours of which one is ink and the other paper
    min_piece: float = 0.05  # longest piece of ink, share of the longer side: letters and specks are shorter
    min_wall: float = 0.1  # longest straight line where floors are hatched, share of the longer side


MAP_OR_PLAN = MapOrPlanParameters()
DRAWING = DrawingParameters()


def detect_input_kind(path: Source, *, max_cells: int = MAX_CELLS) -> InputKind:
    """Whether a file is a robot's map or a plan: by its suffix, images by their pixels.

    Maps are grey, have few greys, and do not end in free space; plans have paper, colours, or are photos.
    Raises MapError, in one line, for an image that cannot be read; all other files count as maps, whose reader reports
    what is wrong with them.
    """
    suffix = Path(path_of(path)).suffix.lower()
    if suffix in VECTOR_SUFFIXES or suffix in set(PICTURE_SUFFIXES) - set(IMAGE_SUFFIXES):
        return "plan"
    if suffix not in IMAGE_SUFFIXES or suffix == ".pgm":
        return "map"
    image = path if isinstance(path, DecodedImage) else open_image(path, max_cells=max_cells)
    # Maps that say so: with their position on the earth, or of a vacuum
    if has_geotags(image.pixels) or (suffix == ".png" and is_wrapped(path_of(path))):
        return "map"
    greys, transparent = read_grey(image)
    colors = read_colors(image)
    opaque = np.ones(greys.shape, bool) if transparent is None else ~transparent
    colored = (colors.max(axis=2) - colors.min(axis=2) > MAP_OR_PLAN.min_chroma) & opaque
    if colored.mean() > MAP_OR_PLAN.max_colored_share:
        return "plan"
    paper = greys >= MAP_OR_PLAN.paper
    if transparent is not None:
        return "map" if (paper & opaque).mean() >= MAP_OR_PLAN.min_white_share else "plan"
    border = np.concatenate([paper[0], paper[-1], paper[:, 0], paper[:, -1]])
    frequent = np.sort(np.bincount(greys.ravel(), minlength=256))[-3:].sum() / greys.size
    is_plan = border.mean() > MAP_OR_PLAN.max_paper_border or frequent < MAP_OR_PLAN.min_frequent_share
    return "plan" if is_plan else "map"


def looks_like_drawing(colors: Colors) -> bool:
    """Whether a picture has what drawings have, and blank sheets, noise, photos and pages of text lack.

    colors: shape (H, W, 3). Neither the network nor the text reader is asked, which both are slow.
    """
    import cv2

    from pianta.plan.sheets.binarization import binarise, invert_if_dark

    if min(colors.shape[:2]) < DRAWING.min_side_px:
        return False
    red, green, blue = np.moveaxis(colors // 32, 2, 0).astype(np.int32)
    frequent = np.sort(np.bincount(((red * 8 + green) * 8 + blue).ravel()))[-DRAWING.n_frequent_colors :]
    if frequent.sum() < DRAWING.min_frequent_share * red.size:
        return False
    paper = invert_if_dark(colors)
    step = -(-max(colors.shape) // DRAWING.max_working_px)
    # The darkest pixel of each block, so that thin lines stay
    darkest = cv2.erode(paper, np.ones((step, step), np.uint8))[step // 2 :: step, step // 2 :: step]
    ink = binarise(np.asarray(darkest, np.uint8))
    changes = (ink[1:] != ink[:-1]).mean() + (ink[:, 1:] != ink[:, :-1]).mean()
    if ink.mean() <= DRAWING.max_ink_share and changes <= DRAWING.max_change_share:
        pieces = cv2.connectedComponentsWithStats(ink.astype(np.uint8), connectivity=8)[2][1:]
        longest = pieces[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(initial=0)
        return bool(longest >= DRAWING.min_piece * max(ink.shape))
    # Hatched floors look like noise, but walls between them are long and straight
    sampled = binarise(paper[::step, ::step]).astype(np.uint8)
    wall = max(DRAWING.min_side_px, round(DRAWING.min_wall * max(sampled.shape)))
    return any(cv2.erode(sampled, np.ones(line, np.uint8)).any() for line in ((1, wall), (wall, 1)))
