"""The inner area of a map, inside its contour (Algorithm 1, second step)."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from pianta._types import Mask
from pianta.layout._working_grid import WorkingGrid
from pianta.layout.parameters import ThesisParameters


def compute_map_contour(working_grid: WorkingGrid, parameters: ThesisParameters) -> Mask:
    """Inner ← computeMapContour(M''): cells inside the contours of the free space, shape (H, W).

    Contours are traced by Suzuki's algorithm. Holes as large as a courtyard, and patches of free space smaller than a
    room, are outside; walls and small unknown spots are inside.
    """
    cell_area = working_grid.resolution**2
    contours, hierarchy = cv2.findContours(working_grid.free.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    parents = np.asarray(hierarchy).reshape(-1, 4)[:, 3]
    areas = np.array([cv2.contourArea(contour) for contour in contours]) * cell_area
    is_patch = (parents < 0) & (areas >= (parameters.room_area if parameters.drop_small_rooms else 0.0))
    is_courtyard = (parents >= 0) & (areas >= parameters.courtyard_area)
    inner, holes = (_fill_contours(contours, chosen, working_grid.free.shape) for chosen in (is_patch, is_courtyard))
    return inner & ~(holes & ~working_grid.free)


def _fill_contours(contours: Sequence[cv2.typing.MatLike], chosen: Mask, shape: tuple[int, ...]) -> Mask:
    """Cells inside any of the chosen contours, shape (H, W)."""
    filled = np.zeros(shape, np.uint8)
    # One call each: in a common call OpenCV omits a patch inside another.
    for i in np.flatnonzero(chosen):
        cv2.drawContours(filled, contours, int(i), 1, cv2.FILLED)
    return filled > 0
