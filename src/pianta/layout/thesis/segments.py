"""Walls as line segments: Canny edges and the probabilistic Hough transform (Algorithm 1, first step)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.layout._working_grid import WorkingGrid
from pianta.layout.parameters import ThesisParameters

# Shape (N, 4): x0, y0, x1, y1.
Segments = Floats

# Width of the stroke that erases an explained edge: the edge pixel and its neighbours.
STROKE_PX = 3


def detect_edges(working_grid: WorkingGrid, parameters: ThesisParameters) -> NDArray[np.uint8]:
    """M' ← CannyEdgeDetection(M): 255 on the edges of the free space, 0 elsewhere; shape (H, W)."""
    image = np.where(working_grid.free, 255, 0).astype(np.uint8)
    return np.asarray(cv2.Canny(image, parameters.canny_low, parameters.canny_high), dtype=np.uint8)


def detect_segments(edges: NDArray[np.uint8], resolution: float, parameters: ThesisParameters) -> Segments:
    """S ← pHoughLineTransform(M'): segments x0, y0, x1, y1 in metres of the working grid; shape (N, 4).

    The transform discards the edges that it follows without success, and with them short walls beside doors. So it is
    run again on the edges that no segment explains yet.
    """
    remaining = edges.copy()
    segments = [np.zeros((0, 4), np.int32)]
    for _ in range(parameters.hough_passes):
        lines = cv2.HoughLinesP(
            remaining,
            rho=1,
            theta=np.radians(parameters.hough_angle),
            threshold=max(1, round(parameters.hough_votes / resolution)),
            minLineLength=parameters.segment_length / resolution,
            maxLineGap=parameters.segment_gap / resolution,
        )
        if lines is None:
            break
        segments.append(np.asarray(lines, np.int32).reshape(-1, 4))
        for col0, row0, col1, row1 in segments[-1].tolist():
            cv2.line(remaining, (col0, row0), (col1, row1), 0, STROKE_PX)
    return np.asarray((np.concatenate(segments) + 0.5) * resolution)
