"""What lies below and above the rooms of a picture: the cells of a map, and the ink of a plan."""

from __future__ import annotations

from io import BytesIO
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pianta.gridmap import MAX_FREE, MIN_OCCUPIED, GridMap
from pianta.plot.figure import new_ax

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.backend_bases import RendererBase
    from matplotlib.figure import Figure

FREE_GREY = 255
UNKNOWN_GREY = 228
OCCUPIED_GREY = 110
# Cells on the longer side of an image; larger maps are averaged down.
MAX_IMAGE_SIDE_PX = 4096
# The same for a map in a notebook.
MAX_RENDERED_SIDE_PX = 1000
# Opacity of black ink over the colours of rooms.
INK_OPACITY = 0.75
# Above the rooms, below the walls.
INK_LEVEL = 1.5


def plot_grid(grid: GridMap, *, ax: Axes | None = None) -> Axes:
    """Draw a map in soft greys where it lies in the map frame: free white, unknown light, occupied dark.

    Parameters
    ----------
    grid
        The map.
    ax
        Where to draw, metres; a new figure if None.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_grid(grid)
    """
    ax = new_ax(ax)
    add_image(Image.fromarray(shade_cells(grid.cells)), "RGB", grid, ax, level=0)
    # An image that is moved or turned into the map frame does not set the limits itself
    height, width = grid.shape
    x, y = grid.pixel_to_map([0, 0, height, height], [0, width, 0, width])
    ax.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()), aspect="equal")
    return ax


def plot_ink(paper: NDArray[np.uint8], grid: GridMap, *, ax: Axes | None = None) -> Axes:
    """Draw the dark pixels of a plan's sheet, RGB of shape (H, W, 3) on the cells of the grid, over what lies below."""
    ax = new_ax(ax)
    opacity = ((255 - paper.min(axis=2)) * INK_OPACITY).astype(np.uint8)
    add_image(Image.fromarray(np.dstack([paper, opacity])), "RGBA", grid, ax, level=INK_LEVEL)
    return ax


def render_grid(grid: GridMap) -> bytes:
    """The map as a PNG, a pixel a cell; a large one is averaged down."""
    content = BytesIO()
    Image.fromarray(shade_cells(grid.cells)).reduce(-(-max(grid.shape) // MAX_RENDERED_SIDE_PX)).save(content, "png")
    return content.getvalue()


def shade_cells(cells: NDArray[np.int8]) -> NDArray[np.uint8]:
    """The grey of each cell of a map, the shape of the cells."""
    table = np.full(256, UNKNOWN_GREY, np.uint8)
    table[: MAX_FREE + 1] = FREE_GREY
    table[MIN_OCCUPIED:101] = OCCUPIED_GREY
    return np.asarray(cv2.LUT(np.ascontiguousarray(cells).view(np.uint8), table))


def paint_grid(grid: GridMap, view: tuple[float, float, float, float], size: tuple[int, int]) -> NDArray[np.uint8]:
    """The map as pixels of a picture, RGBA, shape (height, width, 4), much faster than by matplotlib.

    view: left, bottom, right and top of the picture, metres of the map frame. size: its width and height, pixels.
    """
    left, bottom, right, top = view
    width, height = size
    corners = np.array([[0, 0], [width, 0], [0, height]], np.float32)
    rows, cols = grid.map_to_pixel([left, right, left], [top, top, bottom])
    # Cells per pixel.
    step, factor = np.hypot(rows[1] - rows[0], cols[1] - cols[0]) / width, 1
    greys = shade_cells(grid.cells)
    if step >= 2:
        # Each pixel of the picture is the mean of the cells below it.
        factor = int(step)
        greys = np.asarray(Image.fromarray(greys).reduce(factor))
    # From centres of pixels to centres of cells.
    targets = (np.column_stack([cols, rows]) / factor).astype(np.float32)
    to_cells = cv2.getAffineTransform(corners - np.float32(0.5), targets - np.float32(0.5))
    painted = cv2.warpAffine(
        greys,
        to_cells,
        size,
        flags=cv2.WARP_INVERSE_MAP | (cv2.INTER_NEAREST if step < 1 else cv2.INTER_LINEAR),
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=UNKNOWN_GREY,
    )
    return np.asarray(cv2.cvtColor(painted, cv2.COLOR_GRAY2RGBA))


def add_background(pixels: NDArray[np.uint8], figure: Figure, *, bottom: int) -> None:
    """Add opaque pixels, RGBA, shape (height, width, 4), to a figure, below all else.

    They are at the left side of the figure, `bottom` pixels above its lower side.
    """
    from matplotlib.artist import Artist
    from matplotlib.backends.backend_agg import RendererAgg

    class Pixels(Artist):
        """Pixels that are not resampled, as Figure.figimage would do."""

        def draw(self, renderer: RendererBase) -> None:
            """Copy the pixels into the picture of Agg, which is fast; other renderers draw them as an image."""
            if isinstance(renderer, RendererAgg):
                # They are opaque and drawn first, so they can be copied instead of blended.
                canvas = np.asarray(renderer.buffer_rgba())  # type: ignore[no-untyped-call]
                height, width = (min(sides) for sides in zip(pixels.shape, canvas.shape[:2], strict=False))
                top = max(canvas.shape[0] - bottom - height, 0)
                canvas[top : top + height, :width] = pixels[:height, :width]
                return
            context = renderer.new_gc()
            renderer.draw_image(context, 0, bottom, pixels[::-1])
            context.restore()

    background = Pixels()
    background.set_zorder(-1)
    figure.add_artist(background)


def add_image(image: Image.Image, mode: str, grid: GridMap, ax: Axes, *, level: float) -> None:
    """Draw an image with a pixel a cell where its grid lies in the map frame."""
    from matplotlib.transforms import Affine2D

    factor = -(-max(grid.shape) // MAX_IMAGE_SIDE_PX)
    pixels = np.asarray(image.reduce(factor).convert(mode))
    height, width = (side * factor * grid.resolution for side in pixels.shape[:2])
    top = grid.shape[0] * grid.resolution
    x0, y0, yaw = grid.origin
    transform = Affine2D().rotate(yaw).translate(x0, y0) + ax.transData
    ax.imshow(pixels, extent=(0, width, top - height, top), transform=transform, zorder=level)
