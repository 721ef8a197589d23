"""What pictures of buildings share: the extent that they show, their size, the scale bar, and a strip with a legend."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, log10
from textwrap import wrap
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import shapely

from pianta._types import Floats
from pianta.floor import Floor
from pianta.floor.area_trust import AreaTrust
from pianta.gridmap import GridMap
from pianta.plot.figure import DPI, TEXT_LEVEL, clean_legend, new_figure
from pianta.plot.grid import UNKNOWN_GREY
from pianta.plot.styles import DARK_INK

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Left, bottom, right and top, metres of the map frame.
Extent: TypeAlias = tuple[float, float, float, float]

BACKGROUND = f"#{UNKNOWN_GREY:02x}{UNKNOWN_GREY:02x}{UNKNOWN_GREY:02x}"
LONG_SIDE_PX = 1600
# Least ratio of the short side of a picture to its long side.
MIN_ASPECT = 0.25
# Margin around the building and strip for the scale bar below it, per long side of the building.
MARGIN = 0.02
STRIP = 0.05
# Cells on the longer side of a map from which its extent is found; larger maps are sampled.
SAMPLED_SIDE = 400
# The picture shows free cells between this quantile of x and of y and its complement; beyond may be spray of windows.
FREE_CELLS_QUANTILE = 0.99
LEGEND_FONT_SIZE = 8
# Of a sentence below the building, and the mean width of its letters per font size, rounded up.
NOTE_FONT_SIZE = 6
NOTE_LETTER = 0.6


def find_extent(floor: Floor, grid: GridMap | None) -> Extent:
    """Left, bottom, right and top (m) of the picture: rooms and free cells, a margin, and a strip below.

    A prediction is a guess, so it may end at the frame, but does not widen it.
    """
    rooms = [shapely.get_coordinates(room.polygon) for room in floor.rooms]
    xy = np.concatenate([*([] if grid is None else [_find_extent_of_free(grid)]), *rooms])
    low, high = xy.min(axis=0), xy.max(axis=0)
    longest = (high - low).max()
    half = np.maximum(high - low, MIN_ASPECT * longest) / 2 + MARGIN * longest
    middle = (low + high) / 2
    left, bottom = middle - half - (0, STRIP * longest)
    right, top = middle + half
    return left, bottom, right, top


def _find_extent_of_free(grid: GridMap) -> Floats:
    """Least and largest x, y (m), shape (2, 2), of nearly all free cells; of the whole grid if no cell is free."""
    step = -(-max(grid.shape) // SAMPLED_SIDE)
    rows, cols = np.nonzero(grid.free[::step, ::step])
    if not rows.size:
        height, width = grid.shape
        return np.column_stack(grid.pixel_to_map([0, 0, height, height], [0, width, 0, width]))
    xy = np.column_stack(grid.pixel_to_map(rows * step + 0.5, cols * step + 0.5))
    # Half a cell more, so that even a single cell has an extent.
    margin = np.array([[-0.5], [0.5]]) * grid.resolution
    return np.asarray(np.quantile(xy, (1 - FREE_CELLS_QUANTILE, FREE_CELLS_QUANTILE), axis=0) + margin)


def new_picture(extent: Extent) -> tuple[Figure, Axes]:
    """A figure with a long side of 1600 pixels, and the ax that fills it; extent: what it will show, m."""
    left, bottom, right, top = extent
    inches = LONG_SIDE_PX / DPI / max(right - left, top - bottom)
    figure = new_figure((right - left) * inches, (top - bottom) * inches, color=BACKGROUND)
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set_axis_off()
    return figure, ax


def show_extent(extent: Extent, ax: Axes) -> None:
    """Set the limits of an ax, and equal scales of x and y, which are metres."""
    left, bottom, right, top = extent
    ax.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")


def plot_scale_bar(*, ax: Axes, area_trust: AreaTrust = AreaTrust.EXACT) -> Axes:
    """Draw a scale bar of 1, 2 or 5 times a power of ten metres in the lower left corner of what the ax shows.

    area_trust: of the floor; a rough bar has a mark, and in place of an unknown one stands why it is.
    """
    from matplotlib.lines import Line2D

    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    length = _round_length((right - left) / 4)
    margin = MARGIN * max(right - left, top - bottom)
    x, y = left + margin, bottom + margin
    if area_trust is AreaTrust.UNKNOWN:
        return _write_note(area_trust.note, (x, y), ax)
    line: dict[str, Any] = {
        "color": DARK_INK,
        "linewidth": 1.5,
        "marker": "|",
        "markeredgewidth": 1.5,
        "zorder": TEXT_LEVEL,
    }
    ax.add_line(Line2D([x, x + length], [y, y], **line))
    text: dict[str, Any] = {"color": DARK_INK, "fontsize": 9, "va": "center_baseline", "zorder": TEXT_LEVEL}
    ax.text(x + length + margin / 2, y, area_trust.mark_size(f"{length:g} m"), **text)
    return ax


def _write_note(note: str, corner: tuple[float, float], ax: Axes) -> Axes:
    """Write a sentence into the strip below a building, from its lower left corner, in as many lines as it needs."""
    width = ax.get_window_extent().width / DPI - 2 * MARGIN * LONG_SIDE_PX / DPI
    letters = max(1, int(width / (NOTE_LETTER * NOTE_FONT_SIZE / 72)))
    look: dict[str, Any] = {"color": DARK_INK, "fontsize": NOTE_FONT_SIZE, "va": "bottom", "zorder": TEXT_LEVEL}
    ax.text(*corner, "\n".join(wrap(note, letters)), **look)
    return ax


def _round_length(longest: float) -> float:
    """The largest 1, 2 or 5 times a power of ten up to a length."""
    power: float = 10.0 ** (log10(longest) // 1)
    return power * max(step for step in (1, 2, 5) if step * power <= longest)


def add_legend(figure: Figure, samples: Sequence[tuple[Artist, str]]) -> float:
    """Enlarge the figure of a building by a strip with the legend: below a wide building, right of a tall one.

    Returns how far the building has moved up, inches.
    """
    (building,) = figure.axes
    width, height = figure.get_size_inches()
    margin = MARGIN * LONG_SIDE_PX / DPI
    strip = figure.add_axes((0, 0, 1, 1))
    column_width, column_height = plot_samples(samples, strip)
    if width >= height:
        columns = max(1, int((width - 2 * margin) / column_width))
        _, legend_height = plot_samples(samples, strip, columns=columns)
        below, right, corner = legend_height + margin, 0.0, (margin, legend_height + margin)
    else:
        columns = ceil(column_height / (height - 2 * margin))
        legend_width, _ = plot_samples(samples, strip, columns=columns)
        below, right, corner = 0.0, legend_width + margin, (width, height - margin)
    total_width, total_height = width + right, height + below
    figure.set_size_inches(total_width, total_height)
    building.set_position((0, below / total_height, width / total_width, height / total_height))
    strip.set_position((corner[0] / total_width, 0, 1 - corner[0] / total_width, corner[1] / total_height))
    return below


def plot_samples(samples: Sequence[tuple[Artist, str]], ax: Axes, *, columns: int = 1) -> tuple[float, float]:
    """Draw a legend on an ax, in place of an older one; its width and height, inches."""
    from matplotlib.font_manager import FontProperties

    ax.set_axis_off()
    legend = ax.legend(
        handles=[handle for handle, _ in samples],
        labels=[text for _, text in samples],
        loc="upper left",
        ncols=columns,
        frameon=False,
        borderaxespad=0,
        handlelength=1.6,
        handleheight=1,
        prop=FontProperties(family="DejaVu Sans", size=LEGEND_FONT_SIZE),
    )
    clean_legend(legend)
    extent = legend.get_window_extent()
    return extent.width / DPI, extent.height / DPI
