"""Small groups of cells that are furniture and not building (thesis, section 3.2)."""

from __future__ import annotations

import cv2
import numpy as np

from pianta._types import Mask


def remove_clutter(free: Mask, *, size_px: float) -> Mask:
    """Free cells, shape (H, W), where every group of other cells less than size_px across has become free.

    Groups are 8-connected; across is the diagonal of the bounding box. Groups at the edge of the map are outside.
    """
    # A frame joins the groups at the edge, as a map with more cells around it does.
    others = np.pad(~free, 1, constant_values=True).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(others, connectivity=8)
    across = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT])
    small = across < size_px
    # The free space itself carries label 0.
    small[[0, labels[0, 0]]] = False
    return np.asarray(free | small[labels[1:-1, 1:-1]])
