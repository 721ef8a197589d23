"""The inner area of a map, inside its contour (Algorithm 1, second step)."""

from __future__ import annotations

import cv2
import numpy as np

from pianta.layout.canvas import Canvas, Mask
from pianta.layout.parameters import ThesisParameters


def compute_map_contour(canvas: Canvas, parameters: ThesisParameters) -> Mask:
    """Inner ← computeMapContour(M''): cells inside the contours of the free space, shape (H, W).

    Contours are followed with Suzuki's algorithm. Holes as large as a courtyard are outside; walls and small unknown
    spots are inside. Patches of free space smaller than a room are outside.
    """
    cell_area = canvas.resolution**2
    contours, hierarchy = cv2.findContours(canvas.free.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    parents = np.asarray(hierarchy).reshape(-1, 4)[:, 3]
    areas = np.array([cv2.contourArea(contour) for contour in contours]) * cell_area
    is_patch = (parents < 0) & (areas >= parameters.room_area)
    is_courtyard = (parents >= 0) & (areas >= parameters.courtyard_area)
    inner = np.zeros(canvas.free.shape, np.uint8)
    holes = np.zeros(canvas.free.shape, np.uint8)
    cv2.drawContours(
        inner, [contour for contour, chosen in zip(contours, is_patch, strict=True) if chosen], -1, 1, cv2.FILLED
    )
    for i in np.flatnonzero(is_courtyard):
        cv2.drawContours(holes, contours, int(i), 1, cv2.FILLED)
    return np.asarray((inner > 0) & ~((holes > 0) & ~canvas.free))
