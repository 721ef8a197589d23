"""NAME_gt.png with one colour per room: the true rooms of cluttered and of growing maps (Luperto et al., ROSE²)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta.io.images import read_colors

MIN_COLOR_PX = 100  # pixels: 0.25 m² at 0.05 m per pixel; the colours of blended edges have fewer


def read_color_truth(path: str | Path) -> NDArray[np.int32]:
    """True rooms of a map, shape (H, W): 1 … N by colour, 0 elsewhere.

    Raises MapError for what is no image.
    """
    return label_colors(read_colors(path))


def label_colors(colors: NDArray[np.uint8]) -> NDArray[np.int32]:
    """Rooms of a coloured truth, shape (H, W), of red, green and blue, shape (H, W, 3).

    Black is no room. Every other colour of at least 100 pixels is a room; rarer colours are blends at edges.
    """
    red, green, blue = np.moveaxis(colors.astype(np.int32), 2, 0)
    codes, color, counts = np.unique(red << 16 | green << 8 | blue, return_inverse=True, return_counts=True)
    is_room = (counts >= MIN_COLOR_PX) & (codes > 0)
    ids = np.where(is_room, np.cumsum(is_room), 0).astype(np.int32)
    return np.asarray(ids[color.reshape(red.shape)])
