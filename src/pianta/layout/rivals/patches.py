"""Free space as patches: how far cells are from walls, and the connected groups of cells with their areas."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask

Labels = NDArray[np.int32]


def measure_clearance(free: Mask, *, chessboard: bool = False) -> Floats:
    """Distance of each free cell to the nearest other cell, in cells, centre to centre; shape (H, W).

    What is beyond the edge of the map is not free. chessboard: a diagonal step counts as one, as in erosion by 3 × 3.
    """
    norm, size = (cv2.DIST_C, cv2.DIST_MASK_3) if chessboard else (cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    padded = np.pad(free, 1).astype(np.uint8)
    return np.asarray(cv2.distanceTransform(padded, norm, size)[1:-1, 1:-1], np.float64)


def label_patches(mask: Mask, resolution: float) -> tuple[Labels, Floats]:
    """Groups of cells that touch by an edge, shape (H, W), 1 … N; and the area of each label in m², that of 0 zero."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    areas = np.asarray(stats[:, cv2.CC_STAT_AREA] * resolution**2, np.float64)
    areas[0] = 0.0
    return np.asarray(labels, np.int32), areas


def spread_labels(seeds: Labels, free: Mask) -> Labels:
    """Labels of free cells, shape (H, W): a wavefront starts at the seeds and walks cell by cell, around walls.

    A cell goes to the label that reaches it first; free cells that no front reaches stay 0.
    """
    from skimage.segmentation import watershed

    # On flat ground the watershed floods in the order of arrival.
    return np.asarray(watershed(np.zeros(seeds.shape, np.uint8), seeds, mask=free, connectivity=1), np.int32)
