"""Steps shared by the methods of the survey: clearance, connected groups of cells, and growing of labels."""

from __future__ import annotations

import cv2
import numpy as np

from pianta._types import Floats, LabelImage, Mask


def measure_padded_clearance(free: Mask, *, chessboard: bool = False) -> Floats:
    """Distance of each free cell to the nearest other cell, in cells, centre to centre; shape (H, W).

    Cells beyond the edge of the map are not free. chessboard: a diagonal step counts as one, as in erosion by 3 × 3.
    """
    norm, size = (cv2.DIST_C, cv2.DIST_MASK_3) if chessboard else (cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    padded = np.pad(free, 1).astype(np.uint8)
    return np.asarray(cv2.distanceTransform(padded, norm, size)[1:-1, 1:-1], np.float64)


def label_patches(mask: Mask, resolution: float) -> tuple[LabelImage, Floats]:
    """Groups of cells that touch by an edge, shape (H, W), 1 … N; and the area of each label in m², 0 for label 0."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    areas = np.asarray(stats[:, cv2.CC_STAT_AREA] * resolution**2, np.float64)
    areas[0] = 0.0
    return np.asarray(labels, np.int32), areas


def grow_labels(seeds: LabelImage, free: Mask) -> LabelImage:
    """Labels of free cells, shape (H, W): a wavefront starts at the seeds and advances cell by cell, around walls.

    A cell gets the label that reaches it first; free cells that no front reaches stay 0.
    """
    from skimage.segmentation import watershed

    # On an image of equal values the watershed floods in the order of arrival.
    return np.asarray(watershed(np.zeros(seeds.shape, np.uint8), seeds, mask=free, connectivity=1), np.int32)
