"""A network that estimates which cells belong to a partial room, from everything that is known around it.

Chapter 9 of the thesis asks for knowledge of the building in predictions of partial rooms. The network sees the seen
part, other rooms, walls, unknown space, and where walls of the whole building are in line with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.layout.partial.scene import RoomScene
from pianta.models import MODELS

NETWORK = "partial_shapes.onnx"
# The constants belong to what the network was trained on (chosen by hand).
# Rows and columns of the patch that the network sees.
PATCH_SIZE = 80
# Smallest cells of a patch; metres.
PATCH_CELL = 0.25
# Metres that a patch has beyond the extent of the seen part, at least.
PATCH_MARGIN = 10.0
# Walls count as parallel to an axis if the tangent of the angle between them is less than this.
MAX_SLOPE = 0.12
# Distance beside the room over which the weight of a wall falls to 1/e; metres.
SUPPORT_DECAY = 15.0
# Walls in line of e - 1 metres have this level, of 255.
SUPPORT_LEVEL = 60.0
# Weights by which the support of a line spreads to its neighbours.
SUPPORT_BLUR = (0.25, 0.5, 0.25)
LAYERS = (
    "seen part",
    "whole rooms",
    "other partial rooms",
    "walls",
    "furniture",
    "unknown",
    "frontier",
    "walls in line with columns",
    "walls in line with rows",
    "lines of walls",
    "doors",
)
# Layers that the exchange of rows and columns exchanges.
COLUMNS_LAYER, ROWS_LAYER = (LAYERS.index(f"walls in line with {name}") for name in ("columns", "rows"))
# Sub-pixel bits of the coordinates of lines that are drawn with OpenCV.
SHIFT = 4
# Lines are cut off this far from a patch, so that their coordinates are small; cells.
LINE_MARGIN = 4.0


def expect_cells(scene: RoomScene) -> Floats:
    """The probability that each cell of a scene belongs to the room, shape (H, W).

    It is 1 in the seen part, 0 in other rooms and beyond the patch, and estimated by the network elsewhere.
    """
    layers, matrix = draw_patch(scene)
    # A building is the same in a mirror, so that eight answers of the network can be averaged
    answers = [symmetry.undo(_score_cells(symmetry.apply(layers))) for symmetry in SYMMETRIES]
    probability = 1 / (1 + np.exp(-np.mean(answers, axis=0)))
    height, width = scene.observed.shape
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    cells = cv2.warpAffine(probability, matrix, (width, height), flags=flags)
    return np.where(scene.observed, 1.0, np.where(scene.others, 0.0, cells))


@dataclass(frozen=True)
class Symmetry:
    """A symmetry of a square: the exchange of rows and columns, then mirrors. mirrored: axes, of rows and columns."""

    exchanged: bool
    mirrored: tuple[int, ...]

    def apply(self, layers: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The layers of a patch, shape (..., H, W), of which those that know the axes are exchanged too."""
        if self.exchanged:
            order = np.arange(len(LAYERS))
            order[[COLUMNS_LAYER, ROWS_LAYER]] = ROWS_LAYER, COLUMNS_LAYER
            layers = layers[..., order, :, :]
        return self.move(layers)

    def move(self, cells: NDArray[Any]) -> NDArray[Any]:
        """Cells of a patch, shape (..., H, W)."""
        return np.flip(cells.swapaxes(-1, -2) if self.exchanged else cells, self.mirrored)

    def undo(self, cells: NDArray[np.float32]) -> NDArray[np.float32]:
        """The cells of a patch, shape (H, W), as they were before."""
        mirrored = np.flip(cells, self.mirrored)
        return np.asarray(mirrored.T if self.exchanged else mirrored)


SYMMETRIES = tuple(
    Symmetry(exchanged, mirrored) for exchanged in (False, True) for mirrored in ((), (-1,), (-2,), (-2, -1))
)


def _score_cells(layers: NDArray[np.uint8]) -> NDArray[np.float32]:
    """The scores of the network for the cells of a patch, shape (80, 80)."""
    network = _read_network()
    network.setInput((layers.astype(np.float32) / 255)[None])
    scores: NDArray[np.float32] = np.asarray(network.forward(), np.float32)[0, 0]
    return scores


def draw_patch(scene: RoomScene) -> tuple[NDArray[np.uint8], Floats]:
    """What the network sees, shape (11, 80, 80), in the order of LAYERS; and the matrix to it from cells of the scene.

    The matrix, shape (2, 3), takes col and row of a cell to those of the patch.
    """
    top, left, bottom, right = scene.bounds
    extent = max(bottom - top + 1, right - left + 1) * scene.view.cell
    scale = max(PATCH_CELL, (extent + PATCH_MARGIN) / PATCH_SIZE) / scene.view.cell
    middle = np.array([(left + right + 1) / 2, (top + bottom + 1) / 2])
    corner = middle - PATCH_SIZE * scale / 2
    matrix = np.column_stack([np.eye(2) / scale, (0.5 - corner) / scale - 0.5])

    masks = (scene.observed, scene.complete, scene.others & ~scene.complete, scene.walls, scene.occupied & ~scene.walls)
    layers = [shrink_mask(mask, matrix) for mask in masks]
    layers += [shrink_mask(scene.unknown, matrix, beyond=255), shrink_mask(scene.frontier, matrix)]
    support = [_measure_support(scene, axis, corner[axis], scale, middle[1 - axis]) for axis in (0, 1)]
    layers += [np.broadcast_to(support[0], layers[0].shape), np.broadcast_to(support[1][:, None], layers[0].shape)]
    layers += [draw_lines(scene.lines, matrix), draw_lines(scene.door_lines, matrix)]
    return np.clip(layers, 0, 255).astype(np.uint8), matrix


def shrink_mask(mask: Mask, matrix: Floats, *, beyond: int = 0) -> NDArray[np.float32]:
    """A mask of the scene as levels, 0 … 255, of a patch, shape (80, 80); beyond: the level outside of the scene."""
    size = max(1, round(1 / float(matrix[0, 0])))
    means = cv2.blur(mask.astype(np.float32) * 255, (size, size), borderType=cv2.BORDER_REPLICATE)
    return np.asarray(
        cv2.warpAffine(
            means, matrix, (PATCH_SIZE, PATCH_SIZE), borderMode=cv2.BORDER_CONSTANT, borderValue=float(beyond)
        ),
        np.float32,
    )


def draw_lines(lines: Floats, matrix: Floats) -> NDArray[np.float32]:
    """Lines of the scene, shape (L, 2, 2), as levels, 0 … 255, of a patch, shape (80, 80)."""
    ends = (lines - 0.5) @ matrix[:, :2].T + matrix[:, 2]
    low, high = -LINE_MARGIN, PATCH_SIZE + LINE_MARGIN
    image = np.zeros((PATCH_SIZE, PATCH_SIZE), np.uint8)
    for line in shapely.clip_by_rect(shapely.linestrings(ends), low, low, high, high):
        corners = np.rint(shapely.get_coordinates(line) * 2**SHIFT).astype(np.int32)
        cv2.polylines(image, [corners], isClosed=False, color=255, lineType=cv2.LINE_AA, shift=SHIFT)
    return image.astype(np.float32)


def _measure_support(scene: RoomScene, axis: int, corner: float, scale: float, middle: float) -> Floats:
    """Level of the walls in line with each column (axis 0) or row (axis 1) of a patch, shape (80,)."""
    steps = np.abs(scene.lines[:, 1] - scene.lines[:, 0])
    parallel = scene.lines[steps[:, axis] < MAX_SLOPE * steps[:, 1 - axis]]
    lengths = np.hypot(*(parallel[:, 1] - parallel[:, 0]).T) * scene.view.cell
    beside = np.abs(parallel[..., 1 - axis].mean(axis=1) - middle) * scene.view.cell
    position = (parallel[..., axis].mean(axis=1) - corner) / scale
    inside = (position >= 0) & (position < PATCH_SIZE)
    weights = lengths * np.exp(-beside / SUPPORT_DECAY)
    metres = np.bincount(position[inside].astype(int), weights[inside], minlength=PATCH_SIZE)
    return np.asarray(np.log1p(np.convolve(metres, SUPPORT_BLUR, "same")) * SUPPORT_LEVEL)


@cache
def _read_network() -> cv2.dnn.Net:
    content = (MODELS / NETWORK).read_bytes()
    return cv2.dnn.readNetFromONNX(np.frombuffer(content, np.uint8))
