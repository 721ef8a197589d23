"""The picture below a floor: the cells of its map, or the sheet of its plan, as PNG."""

from __future__ import annotations

from io import BytesIO

import numpy as np
from PIL import Image

from pianta.reading.saved_reading import SavedReading

# Grey of free, unknown and occupied cells; unknown is lighter than half, so that colours over it differ.
FREE, UNKNOWN, OCCUPIED = 255, 205, 0
# Of zlib: the picture goes no further than this machine, so that time counts more than size.
COMPRESSION = 1


def draw_background(reading: SavedReading) -> bytes | None:
    """The sheet of a plan, else the map; None in a folder that has neither."""
    if reading.paper is not None:
        return _encode(Image.fromarray(reading.paper))
    if reading.grid is None:
        return None
    grid = reading.grid
    grey = np.full(grid.shape, UNKNOWN, np.uint8)
    grey[grid.free] = FREE
    grey[grid.occupied] = OCCUPIED
    return _encode(Image.fromarray(grey))


def _encode(picture: Image.Image) -> bytes:
    with BytesIO() as file:
        picture.save(file, "PNG", compress_level=COMPRESSION)
        return file.getvalue()
