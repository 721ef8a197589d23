"""Symbols as they lie on a sheet, and the poses of templates that are matched with it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pianta._types import Floats
from pianta.plan.symbols.drawings import Kind
from pianta.plan.symbols.templates import Template

Image = NDArray[Any]
# Colours of signs are so far from grey; dark ones need less, if it is so much of their lightest channel.
LEAST_CHROMA, LEAST_DARK_CHROMA, LEAST_SATURATION = 45, 20, 0.4


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
class Pose:
    """A template turned: its image, and the matrix, shape (2, 3), from its row, col to those of the template turned."""

    template: Template
    image: Image
    matrix: Floats


def find_colored(lightest: Image, darkest: Image) -> NDArray[np.bool_]:
    """What has a strong colour, by the lightest and darkest channel of each pixel, all of one shape."""
    chroma = cv2.subtract(lightest, darkest)
    return np.asarray((chroma > LEAST_CHROMA) | ((chroma > LEAST_DARK_CHROMA) & (chroma > LEAST_SATURATION * lightest)))


def place_symbol(pose: Pose, scale: float, corner: Floats, score: float) -> PlacedSymbol:
    """The symbol of a pose at a scale, with its upper left corner at a row and col of the sheet."""
    template = pose.template
    height, width = template.image.shape[:2]

    def on_sheet(points: ArrayLike) -> Floats:
        turned: Floats = np.asarray(points, float) @ pose.matrix[:, :2].T + pose.matrix[:, 2]
        return turned * scale + corner

    jambs = None if template.jambs is None else on_sheet(template.jambs)
    corners = on_sheet([(0, 0), (0, width), (height, width), (height, 0)])
    drawn = resize(pose.image, scale) > 0.25 if pose.image.ndim == 2 else np.ones(_scaled(pose.image, scale), bool)
    return PlacedSymbol(template.name, template.kind, corners, jambs, float(score), drawn)


def is_sign(template: Template) -> bool:
    """Whether a template is told by its colours."""
    if template.image.ndim == 2 or template.kind != "object":
        return False
    return bool((np.ptp(template.image, axis=2) > LEAST_CHROMA).mean() > 0.1)


def turn_template(template: Template) -> Iterator[Pose]:
    """A template in the rotations that differ; doors, windows and what is drawn by lines mirrored, too."""
    image = template.image if is_sign(template) else _contrast_of(template.image)
    height, width = image.shape[:2]
    own = template.door_px is not None
    turns = range(1 if own and is_sign(template) and template.name != "way out" else 4)
    seen: list[Image] = []
    for mirrored, quarter in product((False, True) if own and not is_sign(template) else (False,), turns):
        pose = np.rot90(image[:, ::-1] if mirrored else image, quarter)
        if any(pose.shape == other.shape and np.abs(pose - other).mean() < 0.02 for other in seen):
            continue
        seen.append(pose)
        yield Pose(template, np.ascontiguousarray(pose), _turn_matrix(height, width, mirrored, quarter))


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
    return lift(np.clip((paper - darkest.astype(np.float32)) / 60, 0, 1))


def lift(contrast: Image) -> Image:
    """Hair-light lines count nearly as much as black ones."""
    return np.sqrt(np.maximum(contrast - np.float32(0.06), 0)).astype(np.float32)


def _scaled(image: Image, factor: float) -> tuple[int, int]:
    height, width = (max(1, round(side * factor)) for side in image.shape[:2])
    return height, width


def resize(image: Image, factor: float) -> Image:
    """The image with its sides times a factor, at least a pixel."""
    way = cv2.INTER_AREA if factor < 1 else cv2.INTER_LINEAR
    return np.asarray(cv2.resize(image, _scaled(image, factor)[::-1], interpolation=way))
