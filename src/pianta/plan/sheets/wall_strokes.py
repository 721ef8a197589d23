"""Walls of vector plans that name none: strokes that are much thicker than all others and divide the floor."""

from __future__ import annotations

import numpy as np

from pianta._types import Floats, Mask

# Chosen by hand on one plan of a flat:
MIN_RATIO = 2.5  # of the widths of walls and of the next thinner strokes
MIN_LINES = 12  # of walls: a frame of the sheet has four
MIN_EXTENT = 0.9  # of that of the drawing, along both axes
MIN_LENGTH = 1.2  # of all walls, of the perimeter of the drawing
MIN_INNER_SHARE = 0.3  # of that length that lies within the inner box: outer walls alone bound no rooms
INNER_MARGIN = 0.1  # of the extent around the inner box


def find_wall_strokes(lines: Floats, widths: Floats) -> Mask:
    """Which lines, shape (N, 2, 2), are walls by the widths of their strokes, shape (N,); none without a clear case."""
    none = np.zeros(len(lines), bool)
    distinct = np.unique(widths[widths > 0])
    if len(distinct) < 2 or len(lines) < MIN_LINES:
        return none
    # Walls begin above the widest gap between two widths
    ratios = distinct[1:] / distinct[:-1]
    is_wall = widths >= distinct[ratios.argmax() + 1]
    if ratios.max() < MIN_RATIO or is_wall.sum() < MIN_LINES:
        return none
    low, high = lines.reshape(-1, 2).min(axis=0), lines.reshape(-1, 2).max(axis=0)
    walls = lines[is_wall]
    lengths = np.hypot(*(walls[:, 1] - walls[:, 0]).T)
    margin = INNER_MARGIN * (high - low)
    middles = walls.mean(axis=1)
    inner = ((middles > low + margin) & (middles < high - margin)).all(axis=1)
    is_clear = (
        (np.ptp(walls.reshape(-1, 2), axis=0) >= MIN_EXTENT * (high - low)).all()
        and lengths.sum() >= MIN_LENGTH * 2 * (high - low).sum()
        and lengths[inner].sum() >= MIN_INNER_SHARE * lengths.sum()
    )
    return is_wall if is_clear else none
