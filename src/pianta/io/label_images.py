"""rooms.png: a label image, 16 bits of grey; 0 is no room, n the room with id n."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from PIL.PngImagePlugin import PngImageFile

from pianta.errors import FloorError
from pianta.io._files import MAX_CELLS, checked_input, reason_of, shown, written_atomically


def save_label_image(labels: NDArray[np.uint16], path: str | Path) -> None:
    """Write labels, shape (H, W), as a PNG of 16-bit grey.

    Raises FloorError when they are not a non-empty uint16 image, PiantaError when the file cannot be written.
    """
    if labels.dtype != np.uint16 or labels.ndim != 2 or labels.size == 0:
        raise FloorError(f"labels are {labels.dtype} of shape {labels.shape}, give a non-empty 2-D uint16 array")
    with written_atomically(path) as temporary:
        Image.fromarray(np.ascontiguousarray(labels)).save(temporary, format="PNG")


def read_label_image(path: str | Path, *, max_cells: int = MAX_CELLS) -> NDArray[np.uint16]:
    """Labels of a PNG of 16-bit grey, shape (H, W).

    Raises FloorError for a file that is no such image or has more than max_cells pixels.
    """
    file = checked_input(path, "label image", FloorError)
    try:
        # Image.open has a size limit of its own, which is global.
        with PngImageFile(file) as image:
            return _decode_labels(image, max_cells)
    # Pillow raises whatever a hostile file drives it to.
    except Exception as exception:
        raise FloorError(f"cannot read the label image {shown(file)}: {reason_of(exception)}") from exception


def _decode_labels(image: PngImageFile, max_cells: int) -> NDArray[np.uint16]:
    width, height = image.size
    if width * height > max_cells:
        raise FloorError(f"it has {width} × {height} pixels, the limit is {max_cells}; raise it with max_cells=")
    if image.mode != "I;16":
        raise FloorError(f"its pixels are of mode {image.mode}, give a PNG of 16-bit grey")
    return np.array(image, np.uint16)
