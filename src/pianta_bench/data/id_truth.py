"""NAME_gt.png with a grey value per room: the true rooms of maps of vacuum robots."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta.errors import MapError
from pianta.io._files import short_repr
from pianta.io.images import open_image


def read_id_truth(path: str | Path) -> NDArray[np.int32]:
    """True rooms of a map, shape (H, W): the pixels of a grey image of 8 or 16 bits are ids, 0 is no room.

    Raises MapError for what is no grey image.
    """
    ids = np.asarray(open_image(path).pixels)
    if ids.ndim != 2 or ids.dtype.kind not in "iu":
        raise MapError(f"{short_repr(path)} is no grey image of room ids, save it as a PNG of 16 bits")
    return ids.astype(np.int32)
