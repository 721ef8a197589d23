"""Frontiers: where free space ends at space that nobody has seen.

Section 8.2 of the thesis calls a face partial that is adjacent to an external one with hardly any wall between them;
here a room is partial by the length of its frontier.
"""

from __future__ import annotations

import cv2
import numpy as np

from pianta.gridmap import GridMap
from pianta.layout.canvas import Canvas, Mask
from pianta.layout.necks import Floats
from pianta.layout.pieces import Labels

# Cells between free and unknown that may be the blurred side of a wall.
BLUR_PX = 2


def find_frontiers(grid: GridMap, canvas: Canvas, space: Mask) -> Mask:
    """Cells of the space, shape (H, W) of the canvas, beside unknown ones with no obstacle near.

    grid: the map of the canvas. space: shape (H, W), free cells of the canvas.
    """
    # A cell of the canvas is an obstacle when any part of it is: a wall may be thinner than that cell.
    reach = round(canvas.resolution / grid.resolution) // 2
    parts = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    occupied = cv2.dilate(grid.occupied.astype(np.uint8), parts).astype(bool)
    obstacle = canvas.sample(occupied).astype(np.uint8)
    unknown = canvas.sample(grid.unknown) & ~space
    around = np.ones((2 * BLUR_PX + 1, 2 * BLUR_PX + 1), np.uint8)
    clear = ~cv2.dilate(obstacle, around).astype(bool)
    beside = cv2.dilate((unknown & clear).astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    return np.asarray(space & clear & beside)


def measure_frontiers(labels: Labels, frontier: Mask, *, resolution: float) -> Floats:
    """Length of the frontier of each label 0 … max, metres; shape (1 + max,).

    labels, frontier: shape (H, W). resolution: metres per cell. A cell counts as its side, so that a slanting frontier
    is up to √2 times as long as measured.
    """
    return np.asarray(np.bincount(labels[frontier], minlength=int(labels.max()) + 1) * resolution, float)
