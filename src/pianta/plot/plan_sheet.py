"""The contact sheet of drawn floors."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, sqrt

from matplotlib.figure import Figure

from pianta.floor import Floor
from pianta.labels import SCHEMAS, LabelSchema
from pianta.plot.figure import new_figure
from pianta.plot.floor import plot_floor

MAX_FLOORS = 24  # of a sheet
COLUMNS = 6  # at most
CELL = 3.2  # inches, side of a floor
TITLE_SIZE = 8  # points
MARGIN = 0.02  # of the sheet, between floors


def draw_plan_sheet(floors: Sequence[Floor], titles: Sequence[str], *, schema: LabelSchema) -> Figure:
    """The first 24 floors side by side, each as large as its cell, in the colours of their labels."""
    first = [*zip(floors, titles, strict=True)][:MAX_FLOORS]
    columns = min(COLUMNS, ceil(sqrt(1.5 * len(first))))
    rows = ceil(len(first) / columns)
    figure = new_figure(columns * CELL, rows * CELL)
    schemas = {**SCHEMAS, schema.building_type: schema}
    for index, (floor, title) in enumerate(first):
        row, column = divmod(index, columns)
        left, bottom = (column + MARGIN) / columns, (rows - row - 1 + MARGIN) / rows
        ax = figure.add_axes((left, bottom, (1 - 2 * MARGIN) / columns, (1 - 6 * MARGIN) / rows))
        plot_floor(floor, ax=ax, schemas=schemas)
        ax.set_aspect("equal")
        ax.set_axis_off()
        ax.set_title(title, fontsize=TITLE_SIZE)
    return figure
