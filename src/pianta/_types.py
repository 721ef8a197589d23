"""Types of arrays that many modules share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
Mask = NDArray[np.bool_]
Colors = NDArray[np.uint8]  # shape (H, W, 3) RGB
LabelImage = NDArray[np.int32]  # shape (H, W), n > 0 for the cells of number n
