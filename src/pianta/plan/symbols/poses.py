"""Symbols as they lie on a sheet, and the poses of templates that are matched with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np
from numpy.typing import ArrayLike

from pianta._types import Floats, Mask
from pianta.plan.symbols.drawings import SymbolKind
from pianta.plan.symbols.template_matching import Image
from pianta.plan.symbols.templates import Template


@dataclass(frozen=True, kw_only=True)
class ToneParameters:
    """Thresholds of colours and contrast of symbols; levels are of 8 bits. Chosen by hand, no fit is on record."""

    min_chroma: int = 45  # levels between the channels of the colours of signs
    min_dark_chroma: int = 20  # levels, for dark colours, if they also have:
    min_saturation: float = 0.4  # chroma as a share of the highest channel
    min_sign_share: float = 0.1  # share of coloured pixels in the template of a sign
    paper_percentile: float = 90.0  # of the greys of a template: its paper
    full_contrast: float = 60.0  # levels below the paper that are full contrast, the most that a sheet needs
    faintest_line: float = 0.06  # contrast that counts as none
    min_ink: float = 0.25  # contrast, boosted, from which on a pixel of a template is ink
    same_pose: float = 0.02  # mean difference of two poses that are the same


TONES = ToneParameters()


@dataclass(frozen=True, eq=False)
class PlacedSymbol:
    """A symbol on a sheet.

    corners: shape (4, 2), row and col in continuous pixels, from the upper left of the template clockwise, mirrored as
    it is. jambs: shape (2, 2), the ends of the gap of a door or window. score: 0 … 1, of the match.
    ink: which pixels are drawn, shape (H, W), as it lies on the sheet from the least row and col of its corners.
    """

    name: str
    kind: SymbolKind
    corners: Floats
    jambs: Floats | None
    score: float
    ink: Mask


@dataclass(frozen=True, eq=False)
class Pose:
    """A template turned: its image, and the matrix, shape (2, 3), from its row, col to those of the template turned."""

    template: Template
    image: Image
    matrix: Floats


def find_colored(highest: Image, lowest: Image) -> Mask:
    """Which pixels have a strong colour, by their highest and lowest channel, all of one shape."""
    chroma = cv2.subtract(highest, lowest)
    is_saturated = chroma > TONES.min_saturation * highest
    return np.asarray((chroma > TONES.min_chroma) | ((chroma > TONES.min_dark_chroma) & is_saturated))


def place_symbol(pose: Pose, scale: float, corner: Floats, score: float) -> PlacedSymbol:
    """The symbol of a pose at a scale, with its upper left corner at a row and col of the sheet."""
    template = pose.template
    height, width = template.image.shape[:2]

    def on_sheet(points: ArrayLike) -> Floats:
        turned: Floats = np.asarray(points, float) @ pose.matrix[:, :2].T + pose.matrix[:, 2]
        return turned * scale + corner

    jambs = None if template.jambs is None else on_sheet(template.jambs)
    corners = on_sheet([(0, 0), (0, width), (height, width), (height, 0)])
    image = resize(pose.image, scale)
    ink = image > TONES.min_ink if image.ndim == 2 else np.ones(image.shape[:2], bool)
    return PlacedSymbol(template.name, template.kind, corners, jambs, float(score), ink)


def is_sign(template: Template) -> bool:
    """Whether a template is recognised by its colours."""
    if template.image.ndim == 2 or template.kind != "object":
        return False
    return bool((np.ptp(template.image, axis=2) > TONES.min_chroma).mean() > TONES.min_sign_share)


def template_poses(template: Template) -> Iterator[Pose]:
    """A template in the rotations that differ; our own doors, windows and line drawings also mirrored."""
    image = template.image if is_sign(template) else _template_contrast(template.image)
    height, width = image.shape[:2]
    is_builtin = template.door_px is not None
    rotations = range(1 if is_builtin and is_sign(template) and template.name != "way out" else 4)
    mirrorings = (False, True) if is_builtin and not is_sign(template) else (False,)
    distinct: list[Image] = []
    for mirrored, quarters in product(mirrorings, rotations):
        pose = np.rot90(image[:, ::-1] if mirrored else image, quarters)
        if any(pose.shape == other.shape and np.abs(pose - other).mean() < TONES.same_pose for other in distinct):
            continue
        distinct.append(pose)
        yield Pose(template, np.ascontiguousarray(pose), _pose_matrix(height, width, mirrored, quarters))


def _pose_matrix(height: int, width: int, mirrored: bool, quarters: int) -> Floats:  # noqa: FBT001
    """From row, col of an image to those of the image mirrored left to right and turned by np.rot90; shape (2, 3)."""
    matrix = np.array([[1.0, 0, 0], [0, -1, width]] if mirrored else [[1.0, 0, 0], [0, 1, 0]])
    for _ in range(quarters):
        matrix = np.array([[0.0, -1], [1, 0]]) @ matrix + np.array([[0, 0, width], [0, 0, 0]])
        height, width = width, height
    return matrix


def _template_contrast(image: Image) -> Image:
    """How dark each pixel of a template is, as `Sheet.contrast`, boosted."""
    darkest = image if image.ndim == 2 else image.min(axis=2)
    paper = float(np.percentile(darkest, TONES.paper_percentile))
    return boost_faint_lines(np.clip((paper - darkest.astype(np.float32)) / TONES.full_contrast, 0, 1))


def boost_faint_lines(contrast: Image) -> Image:
    """The contrast with hair-light lines nearly as strong as black ones."""
    return np.sqrt(np.maximum(contrast - np.float32(TONES.faintest_line), 0)).astype(np.float32)


def resize(image: Image, factor: float) -> Image:
    """The image with its sides times a factor, at least a pixel."""
    method = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    height, width = (max(1, round(side * factor)) for side in image.shape[:2])
    return np.asarray(cv2.resize(image, (width, height), interpolation=method))
