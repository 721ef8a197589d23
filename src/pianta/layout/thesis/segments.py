"""Walls as line segments: Canny edges and the probabilistic Hough transform (Algorithm 1, first step)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta.layout._canvas import Canvas
from pianta.layout.parameters import ThesisParameters

Segments = NDArray[np.float64]

# Width of the stroke that takes an explained edge off the image: the edge pixel and its neighbours.
STROKE_PX = 3


def detect_edges(canvas: Canvas, parameters: ThesisParameters) -> NDArray[np.uint8]:
    """M' ← CannyEdgeDetection(M): 255 on the edges of the free space, 0 elsewhere; shape (H, W)."""
    image = np.where(canvas.free, 255, 0).astype(np.uint8)
    return np.asarray(cv2.Canny(image, parameters.canny_low, parameters.canny_high), dtype=np.uint8)


def detect_segments(edges: NDArray[np.uint8], resolution: float, parameters: ThesisParameters) -> Segments:
    """S ← pHoughLineTransform(M'): segments x0, y0, x1, y1 in metres of the canvas; shape (N, 4).

    The transform discards the edges it walks along in vain, and loses short walls beside doors with them. So it is
    run again on the edges that no segment explains yet.
    """
    left = edges.copy()
    found = [np.zeros((0, 4), np.int32)]
    for _ in range(parameters.hough_passes):
        lines = cv2.HoughLinesP(
            left,
            rho=1,
            theta=np.radians(parameters.hough_angle),
            threshold=max(1, round(parameters.hough_votes / resolution)),
            minLineLength=parameters.segment_length / resolution,
            maxLineGap=parameters.segment_gap / resolution,
        )
        if lines is None:
            break
        found.append(np.asarray(lines, np.int32).reshape(-1, 4))
        for col0, row0, col1, row1 in found[-1].tolist():
            cv2.line(left, (col0, row0), (col1, row1), 0, STROKE_PX)
    return np.asarray((np.concatenate(found) + 0.5) * resolution)
