"""What all pictures share: the ax that is drawn on, and PNGs that are the same bytes for the same figure."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from pianta.io._files import atomic_file

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# zlib's level, without a filter: a quarter of the usual time, and few more bytes, as these pictures are flat.
COMPRESSION = 2


def new_ax(ax: Axes | None, *, equal: bool = True) -> Axes:
    """The ax that is given, or that of a new figure of pyplot, which notebooks show.

    equal: whether x and y of the new one have the same scale.
    """
    if ax is not None:
        return ax
    from matplotlib import pyplot

    new: Axes = pyplot.figure(layout="constrained").add_subplot()
    if equal:
        new.set_aspect("equal")
    return new


def encode_png(figure: Figure) -> bytes:
    """The figure as a PNG, RGB."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = cv2.cvtColor(np.asarray(canvas.buffer_rgba()), cv2.COLOR_RGBA2BGR)
    # Figure and canvas hold each other; of many pictures the pixels at least go at once.
    del canvas.renderer
    options = [cv2.IMWRITE_PNG_COMPRESSION, COMPRESSION, cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_NONE]
    return bytes(cv2.imencode(".png", pixels, options)[1])


def save_png(figure: Figure, path: str | Path) -> None:
    """Write the figure as a PNG, whole or not at all.

    Raises PiantaError when the file cannot be written.
    """
    with atomic_file(path) as temporary:
        temporary.write_bytes(encode_png(figure))
