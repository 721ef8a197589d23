"""Thin strokes are replaced by what is around them."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from pianta._types import Mask
from pianta.plan.sheets.sheet import Sheet


def erase_strokes(sheet: Sheet, strokes: Mask, *, reach: int) -> Sheet:
    """The sheet with paper, or the colour of the room, where strokes and their soft edges were drawn.

    strokes: shape (H, W). reach: pixels, more than the thickness of the strokes.
    """
    soft = (cv2.dilate(strokes.view(np.uint8), np.ones((3, 3), np.uint8)) > 0) & ~sheet.ink
    # Light strokes on dark paper are removed by the opposite operation
    operation = cv2.MORPH_CLOSE if sheet.paper is sheet.colors else cv2.MORPH_OPEN
    background = cv2.morphologyEx(sheet.colors, operation, np.ones((2 * reach + 1,) * 2, np.uint8))
    return replace(sheet, colors=np.where((strokes | soft)[:, :, None], background, sheet.colors))
