"""The picture of drawn predictions: plans beside each other, and the probability that a cell is free."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from PIL import Image

from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.io._files import count_noun
from pianta.labels import SCHEMAS, LabelSchema
from pianta.plot.figure import clean_legend, new_figure
from pianta.plot.floor import list_shared_samples, plot_floor
from pianta.plot.grid import add_image, plot_grid
from pianta.plot.picture import Extent, plot_scale_bar, show_extent
from pianta.plot.styles import DARK_INK, Schemas

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

    from pianta.prediction.continuation.continuations import Continuation, Continuations
    from pianta.prediction.continuation.shares import ShareGrid

COLORS = "viridis"
# Inches.
SIDE = 4.6  # longer side of a plan
GAP = 0.15
TITLE = 0.45
BAR = 0.12  # width of the colour bar
BAR_LABELS = 0.6
LEGEND_ROW = 0.21
LEGEND_COLUMNS = 4
FONT_SIZE = 9
MARGIN = 2.0  # m around the rooms
BAR_SPACE = 0.06  # below the rooms for the scale bar, over the longer side of all
COLUMNS = 2  # so that numbers of rooms can be read on a page


def draw_continuations_picture(
    continuations: Continuations, *, schema: LabelSchema, grid: GridMap | None = None, samples: int
) -> Figure:
    """Picture of drawn samples: up to three plans, and the free probability beyond the known part, over a legend.

    grid: the map of the known part, below the plans. samples: number of all.
    """
    schemas = {**SCHEMAS, schema.building_type: schema}
    extent = _find_extent([plan.floor for plan in continuations.plans])
    left, bottom, right, top = extent
    scale = SIDE / max(right - left, top - bottom)
    width, height = (right - left) * scale, (top - bottom) * scale
    handles, texts = zip(*list_shared_samples([plan.floor for plan in continuations.plans], schemas), strict=True)
    below = LEGEND_ROW * (ceil(len(handles) / LEGEND_COLUMNS) + 1)
    count = len(continuations.plans) + 1
    rows = ceil(count / COLUMNS)
    size = (COLUMNS * (width + GAP) + GAP + BAR + BAR_LABELS, rows * (height + TITLE) + below)
    figure = new_figure(*size)
    positions = (divmod(number, COLUMNS) for number in range(count))
    boxes = [
        (GAP + column * (width + GAP), below + (rows - 1 - row) * (height + TITLE), width, height)
        for row, column in positions
    ]
    axes = [figure.add_axes(_scale_box(box, size)) for box in boxes]
    for plan, ax in zip(continuations.plans, axes, strict=False):
        _plot_plan(plan, grid, schemas, samples, ax)
    bar = figure.add_axes(_scale_box((boxes[-1][0] + width + GAP / 2, boxes[-1][1], BAR, height), size))
    plot_free_probability(continuations.grid, ax=axes[-1], bar=bar)
    for ax in axes:
        ax.set_axis_off()
        show_extent(extent, ax)
    plot_scale_bar(ax=axes[0])
    look: dict[str, Any] = {"loc": "lower center", "ncols": LEGEND_COLUMNS, "frameon": False, "fontsize": FONT_SIZE}
    clean_legend(figure.legend(handles=handles, labels=texts, **look))
    return figure


def plot_free_probability(grid: ShareGrid, *, ax: Axes, bar: Axes | None = None) -> Axes:
    """Draw the probability that each cell is free; cells of the known part are white, known walls dark.

    bar: where its colours are explained.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    colors: Colormap = colormaps[COLORS]
    pixels = (255 * colors(grid.free_probability)).astype(np.uint8)
    pixels[grid.observed] = np.where(grid.free[grid.observed, None] > 0, (255, 255, 255, 255), (60, 60, 60, 255))
    add_image(Image.fromarray(pixels), "RGBA", grid.frame, ax, level=0)
    ax.set_title("probability that it is free", fontsize=FONT_SIZE, color=DARK_INK)
    if bar is not None:
        colorbar = ax.figure.colorbar(ScalarMappable(Normalize(0, 1), colors), cax=bar)
        colorbar.ax.tick_params(labelsize=FONT_SIZE - 1, labelcolor=DARK_INK)
    return ax


def _plot_plan(plan: Continuation, grid: GridMap | None, schemas: Schemas, samples: int, ax: Axes) -> None:
    if grid is not None:
        plot_grid(grid, ax=ax)
    plot_floor(plan.floor, ax=ax, furniture=False, schemas=schemas)
    missing = f", {count_noun(plan.unplaced, 'room')} without space" if plan.unplaced else ""
    title = f"sample {plan.sample + 1} of {samples}, which stands for {100 * plan.share:.0f} %{missing}"
    ax.set_title(title, fontsize=FONT_SIZE, color=DARK_INK)


def _find_extent(floors: Sequence[Floor]) -> Extent:
    """Left, bottom, right and top (m) of all rooms, with a margin, and space for a scale bar below."""
    shapes = [_outline(room) for floor in floors for room in floor]
    left, bottom, right, top = shapely.total_bounds(np.array(shapes, dtype=object)).tolist()
    below = MARGIN + BAR_SPACE * max(right - left, top - bottom)
    return left - MARGIN, bottom - below, right + MARGIN, top + MARGIN


def _outline(room: Room) -> shapely.Polygon:
    return room.predicted or room.polygon


def _scale_box(box: tuple[float, ...], size: tuple[float, float]) -> tuple[float, float, float, float]:
    """A box in inches as shares of the figure."""
    x, y, width, height = (np.array(box) / (*size, *size)).tolist()
    return x, y, width, height
