"""Small groups of cells that are furniture and not building (thesis, section 3.2)."""

from __future__ import annotations

import cv2
import numpy as np

from pianta.layout.canvas import Mask


def remove_clutter(free: Mask, *, size_px: float) -> Mask:
    """Free cells, shape (H, W), where every group of other cells less than size_px across has become free.

    Groups are 8-connected; across is the diagonal of the bounding box.
    """
    _, labels, stats, _ = cv2.connectedComponentsWithStats((~free).astype(np.uint8), connectivity=8)
    across = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT])
    small = across < size_px
    # The free space itself carries label 0.
    small[0] = False
    return np.asarray(free | small[labels])
