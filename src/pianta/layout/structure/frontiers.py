"""Frontiers: where free space ends at space that nobody has seen.

Section 8.2 of the thesis calls a face partial that is adjacent to an external one with hardly any wall between them;
here a room is partial by the length of its frontier.
"""

from __future__ import annotations

import cv2
import numpy as np

from pianta._types import Floats, Mask
from pianta.gridmap import GridMap
from pianta.layout._canvas import Canvas
from pianta.layout.structure.pieces import Labels

# Cells between free and unknown that may be the blurred side of a wall.
BLUR_PX = 2


def find_frontiers(grid: GridMap, canvas: Canvas, space: Mask, *, thinnest: float = 0.0) -> Mask:
    """Cells of the space, shape (H, W) of the canvas, beside unknown ones with no obstacle near.

    grid: the map of the canvas. space: shape (H, W), free cells of the canvas.
    thinnest: thinner unknown space is none, but a wall in the grey of unknown cells, or between two beams; metres.
    """
    # A cell of the canvas is an obstacle when any part of it is: a wall may be thinner than that cell.
    reach = round(canvas.resolution / grid.resolution) // 2
    parts = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    occupied = cv2.dilate(grid.occupied.astype(np.uint8), parts).astype(bool)
    obstacle = canvas.sample(occupied).astype(np.uint8)
    unknown = _drop_thin(canvas.sample(grid.unknown) & ~space, round(thinnest / canvas.resolution / 2))
    around = np.ones((2 * BLUR_PX + 1, 2 * BLUR_PX + 1), np.uint8)
    clear = ~cv2.dilate(obstacle, around).astype(bool)
    beside = cv2.dilate((unknown & clear).astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    return np.asarray(space & clear & beside)


def _drop_thin(unknown: Mask, reach: int) -> Mask:
    """Unknown cells, shape (H, W), that a square of reach cells to every side of its middle fits into."""
    if reach < 1:
        return unknown
    # The canvas ends close behind the free space; what is unknown there goes on.
    around = np.pad(unknown, 2 * reach, mode="edge").astype(np.uint8)
    block = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    thick = cv2.morphologyEx(around, cv2.MORPH_OPEN, block)[2 * reach : -2 * reach, 2 * reach : -2 * reach]
    return np.asarray(thick > 0)


def measure_frontiers(labels: Labels, frontier: Mask, *, resolution: float) -> Floats:
    """Length of the frontier of each label 0 … max, metres; shape (1 + max,).

    labels, frontier: shape (H, W). resolution: metres per cell. A cell counts as its side, so that a slanting frontier
    is up to √2 times as long as measured.
    """
    return np.asarray(np.bincount(labels[frontier], minlength=int(labels.max()) + 1) * resolution, float)


def drop_spray(labels: Labels, unseen: Floats, *, width: float, resolution: float) -> Labels:
    """Labels, shape (H, W), without those narrower than width between their frontiers: rays that left through glass.

    unseen: length of the frontier of each label, shape (1 + max,). width, unseen, resolution: metres.
    """
    area = np.bincount(labels.ravel(), minlength=len(unseen)) * resolution**2
    # A strip has a frontier on both sides, so that its width is twice its area for each metre of frontier.
    return np.where((area < width / 2 * unseen)[labels], 0, labels)
