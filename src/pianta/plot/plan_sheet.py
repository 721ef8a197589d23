"""The contact sheet of drawn floors."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, sqrt
from typing import Any

from matplotlib.figure import Figure

from pianta.floor import Floor
from pianta.labels import SCHEMAS, LabelSchema
from pianta.plot.figure import clean_legend, new_figure
from pianta.plot.floor import list_shared_samples, plot_floor

MAX_FLOORS = 24  # of a sheet
COLUMNS = 6  # at most
CELL = 3.2  # inches, side of a floor
TITLE_SIZE = 8  # points
LEGEND_COLUMN = 1.9  # inches
LEGEND_ROW = 0.19  # inches
MARGIN = 0.02  # of the sheet, between floors


def draw_plan_sheet(floors: Sequence[Floor], titles: Sequence[str], *, schema: LabelSchema) -> Figure:
    """The first 24 floors side by side, each as large as its cell, over a legend of their labels."""
    first = [*zip(floors, titles, strict=True)][:MAX_FLOORS]
    columns = min(COLUMNS, ceil(sqrt(1.5 * len(first))), len(first))
    rows = ceil(len(first) / columns)
    schemas = {**SCHEMAS, schema.building_type: schema}
    handles, texts = zip(*list_shared_samples([floor for floor, _ in first], schemas), strict=True)
    legend_columns = max(1, int(columns * CELL / LEGEND_COLUMN))
    below = LEGEND_ROW * (ceil(len(handles) / legend_columns) + 1)
    figure = new_figure(columns * CELL, rows * CELL + below)
    share = rows * CELL / (rows * CELL + below)
    for index, (floor, title) in enumerate(first):
        row, column = divmod(index, columns)
        left, bottom = (column + MARGIN) / columns, 1 - share + (rows - row - 1 + MARGIN) / rows * share
        ax = figure.add_axes((left, bottom, (1 - 2 * MARGIN) / columns, (1 - 6 * MARGIN) / rows * share))
        plot_floor(floor, ax=ax, schemas=schemas)
        ax.set_aspect("equal")
        ax.set_axis_off()
        ax.set_title(title, fontsize=TITLE_SIZE)
    look: dict[str, Any] = {"loc": "lower center", "frameon": False, "fontsize": TITLE_SIZE}
    clean_legend(figure.legend(handles=handles, labels=texts, ncols=min(legend_columns, len(handles)), **look))
    return figure
