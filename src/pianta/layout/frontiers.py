"""Frontiers: where free space ends at space that nobody has seen (thesis, section 8.2)."""

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
    """Cells of the space, shape (H, W) of the canvas, beside unknown ones with no obstacle near."""
    obstacle = canvas.sample(grid.occupied).astype(np.uint8)
    unknown = canvas.sample(grid.unknown) & ~space
    around = np.ones((2 * BLUR_PX + 1, 2 * BLUR_PX + 1), np.uint8)
    clear = ~cv2.dilate(obstacle, around).astype(bool)
    beside = cv2.dilate((unknown & clear).astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool)
    return np.asarray(space & clear & beside)


def measure_frontiers(labels: Labels, frontier: Mask, *, resolution: float) -> Floats:
    """Length of the frontier of each label 0 … max, in metres: cells times their size."""
    return np.bincount(labels[frontier], minlength=int(labels.max()) + 1) * resolution
