"""The contact sheet of drawn floors."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, sqrt
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pianta.floor import Floor
from pianta.labels import SCHEMAS, LabelSchema
from pianta.plot.figure import clean_legend, new_figure
from pianta.plot.floor import list_shared_samples, plot_floor
from pianta.plot.picture import Extent, plot_scale_bar, show_extent
from pianta.plot.styles import Schemas

MAX_FLOORS = 24  # of a sheet
COLUMNS = 6  # at most
CELL = 3.2  # inches, side of a floor
TITLE_SIZE = 8  # points
LEGEND_COLUMN = 1.9  # inches
LEGEND_ROW = 0.19  # inches
MARGIN = 0.02  # of the sheet, between floors
STRIP = 0.06  # of a floor, below it, for its scale


def draw_plan_sheet(floors: Sequence[Floor], titles: Sequence[str], *, schema: LabelSchema) -> Figure:
    """The first 24 floors side by side, each as large as its cell, over a legend of their labels."""
    first = [*zip(floors, titles, strict=True)][:MAX_FLOORS]
    columns = min(COLUMNS, ceil(sqrt(1.5 * len(first))), len(first))
    rows = ceil(len(first) / columns)
    schemas = {**SCHEMAS, schema.building_type: schema}
    figure = new_figure(columns * CELL, rows * CELL)
    below = add_shared_legend(figure, [floor for floor, _ in first], schemas=schemas)
    figure.set_figheight(rows * CELL + below)
    share = rows * CELL / (rows * CELL + below)
    for index, (floor, title) in enumerate(first):
        row, column = divmod(index, columns)
        left, bottom = (column + MARGIN) / columns, 1 - share + (rows - row - 1 + MARGIN) / rows * share
        ax = figure.add_axes((left, bottom, (1 - 2 * MARGIN) / columns, (1 - 6 * MARGIN) / rows * share))
        plot_scaled_floor(floor, ax=ax, schemas=schemas)
        ax.set_title(title, fontsize=TITLE_SIZE)
    return figure


def add_shared_legend(figure: Figure, floors: Sequence[Floor], *, schemas: Schemas = SCHEMAS) -> float:
    """Add the legend of the labels of all floors at the bottom of a figure; returns its height, inches."""
    handles, texts = zip(*list_shared_samples(floors, schemas), strict=True)
    columns = max(1, min(int(figure.get_figwidth() / LEGEND_COLUMN), len(handles)))
    look: dict[str, Any] = {"loc": "lower center", "frameon": False, "fontsize": TITLE_SIZE}
    clean_legend(figure.legend(handles=handles, labels=texts, ncols=columns, **look))
    return LEGEND_ROW * (ceil(len(handles) / columns) + 1)


def plot_scaled_floor(floor: Floor, *, ax: Axes, schemas: Schemas = SCHEMAS) -> Axes:
    """Draw a floor above a scale bar, without axes."""
    plot_floor(floor, ax=ax, schemas=schemas)
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    return show_with_scale((left, bottom, right, top), ax)


def show_with_scale(extent: Extent, ax: Axes) -> Axes:
    """Show an extent, metres, above a scale bar, without axes."""
    left, bottom, right, top = extent
    show_extent((left, bottom - STRIP * max(right - left, top - bottom), right, top), ax)
    ax.set_axis_off()
    return plot_scale_bar(ax=ax)
