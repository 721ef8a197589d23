"""What all pictures share: axes, legends and marks, and PNGs that are the same bytes for the same figure."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from pianta.io._files import atomic_file
from pianta.plot.styles import DARK_INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.legend import Legend
    from matplotlib.patches import Rectangle

DPI = 200
# zlib's level, used without a filter: a quarter of the usual time, and hardly more bytes, as these pictures are flat.
PNG_COMPRESSION = 2
# Characters of a label in a legend, or of a title; longer ones are cut.
MAX_LABEL_LENGTH = 30
# What covers what, from below; the ink of a plan is between the rooms and the furniture.
PREDICTION_LEVEL = 0.5
ROOM_LEVEL, WALL_LEVEL, GRAPH_LEVEL, DOOR_LEVEL, TEXT_LEVEL = range(1, 6)
FURNITURE_LEVEL = 1.7


def new_ax(ax: Axes | None, *, equal: bool = True) -> Axes:
    """The given ax, or that of a new pyplot figure, which notebooks show.

    equal: whether x and y of a new ax have the same scale.
    """
    if ax is not None:
        return ax
    from matplotlib import pyplot

    created: Axes = pyplot.figure(layout="constrained").add_subplot()
    if equal:
        created.set_aspect("equal")
    return created


def new_figure(width: float, height: float, *, color: str = "white") -> Figure:
    """An empty figure of a size in inches, unknown to pyplot: no window, and no state shared between pictures."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), dpi=DPI, facecolor=color)


def clean_legend(legend: Legend) -> None:
    """Give the texts of a legend the colour of ink, and print labels from files as they are, without TeX."""
    for text in legend.get_texts():
        text.set(color=DARK_INK, parse_math=False)


def shorten(text: str) -> str:
    """A label or title, cut if it is too long for a picture."""
    return text if len(text) <= MAX_LABEL_LENGTH else f"{text[: MAX_LABEL_LENGTH - 1]}…"


def make_square(center: tuple[float, float], half_side: float, look: Mapping[str, Any]) -> Rectangle:
    """An upright square; look: properties of the patch."""
    from matplotlib.patches import Rectangle

    x, y = center
    return Rectangle((x - half_side, y - half_side), 2 * half_side, 2 * half_side, **look)


def encode_png(figure: Figure) -> bytes:
    """The figure as a PNG, RGB."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    pixels = cv2.cvtColor(np.asarray(canvas.buffer_rgba()), cv2.COLOR_RGBA2BGR)
    # Figure and canvas refer to each other and are freed late; the pixels, most of their memory, are freed now.
    del canvas.renderer
    options = [cv2.IMWRITE_PNG_COMPRESSION, PNG_COMPRESSION, cv2.IMWRITE_PNG_FILTER, cv2.IMWRITE_PNG_FILTER_NONE]
    return bytes(cv2.imencode(".png", pixels, options)[1])


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write the figure as a PNG, whole or not at all; the same figure gives the same bytes.

    Raises PiantaError if the file cannot be written.
    """
    with atomic_file(path) as temporary:
        temporary.write_bytes(encode_png(figure))
