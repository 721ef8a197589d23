"""What lies below and above the rooms of a picture: the cells of a map, and the ink of a plan."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pianta.gridmap import GridMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FREE_GREY, UNKNOWN_GREY, OCCUPIED_GREY = 255, 228, 110
# Larger maps are averaged down for the picture.
MAX_IMAGE_SIDE_PX = 4096
# Ink covers the colours of rooms with this much of its darkness.
INK_OPACITY = 0.75
# Above the rooms, below the walls.
INK_LEVEL = 1.5


def plot_grid(grid: GridMap, *, ax: Axes) -> Axes:
    """Draw the map in soft greys where it lies in the map frame: free white, unknown light, occupied dark."""
    greys = np.full(grid.shape, UNKNOWN_GREY, np.uint8)
    greys[grid.free] = FREE_GREY
    greys[grid.occupied] = OCCUPIED_GREY
    _place_image(Image.fromarray(greys), "RGB", grid, ax, level=0)
    return ax


def plot_ink(paper: NDArray[np.uint8], grid: GridMap, *, ax: Axes) -> Axes:
    """Draw what is dark on the sheet of a plan, shape (H, W, 3), over what lies below, where its grid lies."""
    opacity = ((255 - paper.min(axis=2)) * INK_OPACITY).astype(np.uint8)
    _place_image(Image.fromarray(np.dstack([paper, opacity])), "RGBA", grid, ax, level=INK_LEVEL)
    return ax


def _place_image(image: Image.Image, mode: str, grid: GridMap, ax: Axes, *, level: float) -> None:
    from matplotlib.transforms import Affine2D

    factor = -(-max(grid.shape) // MAX_IMAGE_SIDE_PX)
    pixels = np.asarray(image.reduce(factor).convert(mode))
    height, width = (side * factor * grid.resolution for side in pixels.shape[:2])
    top = grid.shape[0] * grid.resolution
    x0, y0, yaw = grid.origin
    placed = Affine2D().rotate(yaw).translate(x0, y0) + ax.transData
    ax.imshow(pixels, extent=(0, width, top - height, top), transform=placed, zorder=level)
