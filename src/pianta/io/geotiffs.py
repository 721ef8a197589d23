"""GeoTIFF: the resolution and the position of an image in its tags (OGC 19-008r4, GeoTIFF 1.1)."""

from __future__ import annotations

from math import atan2, hypot, isfinite
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from pianta.errors import MapError
from pianta.gridmap import OCCUPIED, UNKNOWN, GridMap
from pianta.io._files import short_repr
from pianta.io.images import DecodedImage

SCALE_TAG, TIEPOINT_TAG, MATRIX_TAG, KEYS_TAG = 33550, 33922, 34264, 34735
SAMPLE_FORMAT_TAG, SIGNED = 339, 2
# Keys of the directory: type of the model, which is geographic if 2; unit of length; type of the raster.
MODEL_KEY, UNIT_KEY, RASTER_KEY = 1024, 3076, 1025
GEOGRAPHIC, METRE, POINTS, USER_DEFINED = 2, 9001, 2, 32767
# Of the sides of a pixel, and of the angle between them, against a square; chosen by hand.
MAX_DEVIATION = 1e-4


def has_geotags(image: Image.Image) -> bool:
    """Whether an image says where its pixels lie."""
    tags = getattr(image, "tag_v2", {})
    return MATRIX_TAG in tags or (SCALE_TAG in tags and TIEPOINT_TAG in tags)


def read_geotiff(image: DecodedImage, read_greys: Any, *, max_cells: int) -> GridMap:  # noqa: ANN401
    """Map of a GeoTIFF of square pixels in metres.

    One band of signed bytes has the cell values of ROS; other images are read by read_greys, as those without tags.

    Raises MapError, in one line, for tags that contradict each other, degrees, and pixels that are no squares.
    """
    name = f"map {short_repr(image.path)}"
    tags = image.pixels.tag_v2  # type: ignore[attr-defined]
    try:
        matrix = _read_matrix(tags)
        keys = _read_keys(tags)
    except (ValueError, IndexError, TypeError) as exception:
        raise MapError(f"{name} has damaged tags of its position: {exception}") from None
    if keys.get(MODEL_KEY) == GEOGRAPHIC or keys.get(UNIT_KEY, METRE) not in (METRE, USER_DEFINED):
        raise MapError(f"{name} is in degrees or feet, transform it to metres, such as UTM: gdalwarp -t_srs EPSG:32632")
    resolution, origin = _read_frame(matrix, image.pixels.height, name, is_point=keys.get(RASTER_KEY) == POINTS)
    if tags.get(SAMPLE_FORMAT_TAG, (1,))[0] == SIGNED and image.pixels.mode == "L":
        cells = np.asarray(image.pixels).view(np.int8)
        if cells.max() > OCCUPIED:
            raise MapError(f"{name} has cells up to {cells.max()}, give -1 to 100")
        return GridMap(cells.clip(UNKNOWN), resolution, origin, Path(image.path).name)
    grid: GridMap = read_greys(image, resolution=resolution, origin=origin, max_cells=max_cells)
    return grid


def _read_matrix(tags: Any) -> np.ndarray[Any, np.dtype[np.float64]]:  # noqa: ANN401
    """The affine motion from column, row to x, y, shape (2, 3)."""
    if MATRIX_TAG in tags:
        return np.array(tags[MATRIX_TAG], float).reshape(4, 4)[:2][:, [0, 1, 3]]
    right, down = tags[SCALE_TAG][:2]
    col, row, _, x, y, _ = tags[TIEPOINT_TAG][:6]
    return np.array([[right, 0, x - col * right], [0, -down, y + row * down]], float)


def _read_keys(tags: Any) -> dict[int, int]:  # noqa: ANN401
    """The keys of the directory that have short values."""
    numbers = [int(number) for number in tags.get(KEYS_TAG, ())]
    entries = (numbers[at : at + 4] for at in range(4, len(numbers) - 3, 4))
    return {key: value for key, location, _, value in entries if location == 0}


def _read_frame(
    matrix: np.ndarray[Any, np.dtype[np.float64]], height: int, name: str, *, is_point: bool
) -> tuple[float, tuple[float, float, float]]:
    """Metres per cell, and x, y, yaw of the lower-left corner."""
    (xx, xy, _), (yx, yy, _) = matrix.tolist()
    resolution = hypot(xx, yx)
    # The way down an image is a quarter turn clockwise from the way to its right
    deviation = max(abs(xy - yx), abs(yy + xx))
    if not (isfinite(resolution) and resolution > 0 and deviation <= MAX_DEVIATION * resolution):
        raise MapError(f"{name} has pixels that are no squares or mirrored, save it with square pixels, north up")
    # The middle of a pixel, where the values are those of points
    shift = 0.5 if is_point else 0.0
    x, y = matrix @ (-shift, height - shift, 1.0)
    return resolution, (float(x), float(y), atan2(yx, xx))
