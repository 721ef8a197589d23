"""Picture of how realistic a floor is: the floor with its unusual rooms marked, beside all that is unusual."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from shapely import MultiPolygon

from pianta.floor import Floor
from pianta.labels import SCHEMAS
from pianta.plot.figure import GRAPH_LEVEL, new_ax, new_figure
from pianta.plot.floor import plot_legend
from pianta.plot.floor_parts import plot_doors, plot_rooms
from pianta.plot.picture import plot_scale_bar
from pianta.plot.styles import DARK_INK, Schemas
from pianta.realism.model import Realism
from pianta.realism.patterns import UnusualPattern

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Reference floors; this floor and the outlines of its unusual rooms. Paul Tol's "bright" scheme.
REFERENCE_COLOR = "#4477aa"
FLOOR_COLOR = "#cc3311"
HATCHES = ("////", "\\\\\\\\", "....")
# Inches: widths of the floor and of the strips.
FLOOR_WIDTH = 6.4
STRIPS_WIDTH = 4.4
# Inches: height of a strip with its title, and of its axis alone; heights of legend and title.
STRIP_HEIGHT = 0.82
AXIS_HEIGHT = 0.3
LEGEND_HEIGHT = 0.7
TITLE_HEIGHT = 0.5
# Inches: space between parts, and right of the strips.
GAP = 0.3
RIGHT_GAP = 0.7
# Largest height of the floor, per width.
MAX_ASPECT = 1.5
# Characters in a line of the title, and of the title of a strip.
TITLE_LENGTH = 130
STRIP_TITLE_LENGTH = 74
# Largest offset of the dot of a reference floor across its strip, so that equal values do not cover each other.
DOT_OFFSET = 0.3
# Margin around the floor, per longest side.
MARGIN = 0.03
KEY = "dots: reference floors, line: their median, diamond: this floor"


def draw_realism(floor: Floor, realism: Realism, *, schemas: Schemas = SCHEMAS) -> Figure:
    """Picture of a floor and of its realism.

    Left the floor in the colours of its labels; rooms of patterns that are too frequent are outlined, with one hatch
    for each pattern. Right a strip for the likeness to reference floors and for each unusual measure and pattern: a dot
    for each reference floor, a diamond for this floor.
    schemas: as in plot_floor.
    """
    strips = 1 + len(realism.measures) + len(realism.patterns)
    left, bottom, right, top = MultiPolygon([room.polygon for room in floor.rooms]).bounds
    floor_height = FLOOR_WIDTH * min((top - bottom) / (right - left), MAX_ASPECT)
    height = max(floor_height + LEGEND_HEIGHT, STRIP_HEIGHT * strips) + TITLE_HEIGHT + GAP / 2
    width = GAP + FLOOR_WIDTH + GAP + STRIPS_WIDTH + RIGHT_GAP
    figure = new_figure(width, height)

    def add_ax(x: float, y: float, ax_width: float, ax_height: float) -> Axes:
        """An ax by the offset of its upper left corner from that of the figure, and its size, inches."""
        return figure.add_axes((x / width, 1 - (y + ax_height) / height, ax_width / width, ax_height / height))

    title = _wrap(f"{floor.source}: {realism.verdict}", TITLE_LENGTH)
    figure.text(GAP / width, 1 - 0.15 / height, title, fontsize=11, color=DARK_INK, va="top", parse_math=False)
    floor_ax = add_ax(GAP, TITLE_HEIGHT, FLOOR_WIDTH, floor_height)
    plot_unusual_rooms(floor, realism.patterns, ax=floor_ax, schemas=schemas)
    legend_ax = add_ax(GAP, TITLE_HEIGHT + floor_height, FLOOR_WIDTH, LEGEND_HEIGHT)
    plot_legend(floor, ax=legend_ax, schemas=schemas)
    bottoms = [TITLE_HEIGHT + STRIP_HEIGHT * (index + 0.8) for index in range(strips)]
    strips_left = FLOOR_WIDTH + 2 * GAP
    figure.text(strips_left / width, 1 - TITLE_HEIGHT / height, KEY, fontsize=7.5, color=REFERENCE_COLOR, va="top")
    _plot_strips(realism, [add_ax(strips_left, y - AXIS_HEIGHT, STRIPS_WIDTH, AXIS_HEIGHT) for y in bottoms])
    return figure


def plot_unusual_rooms(
    floor: Floor, patterns: Sequence[UnusualPattern], *, ax: Axes | None = None, schemas: Schemas = SCHEMAS
) -> Axes:
    """Draw a floor with the rooms of patterns that are too frequent marked."""
    from shapely.plotting import patch_from_polygon

    ax = new_ax(ax)
    plot_rooms(floor, ax=ax, labels=True, schemas=schemas)
    plot_doors(floor, ax=ax)
    polygons = {room.id: room.polygon for room in floor.rooms}
    for hatch, pattern in zip(_hatch(patterns), patterns, strict=True):
        for room_id in pattern.rooms if hatch else ():
            mark = {"facecolor": "none", "edgecolor": FLOOR_COLOR, "hatch": hatch, "linewidth": 1.6}
            ax.add_patch(patch_from_polygon(polygons[room_id], **mark, zorder=GRAPH_LEVEL))
    left, bottom, right, top = MultiPolygon([*polygons.values()]).bounds
    margin = MARGIN * max(right - left, top - bottom)
    ax.set(xlim=(left - margin, right + margin), ylim=(bottom - 3 * margin, top + margin), aspect="equal", anchor="N")
    ax.set_axis_off()
    return plot_scale_bar(ax=ax)


def plot_strip(
    reference: Sequence[float], value: float, title: str, *, ax: Axes | None = None, percent: bool = False
) -> Axes:
    """Draw a figure of a floor, a diamond, among those of the reference floors, dots."""
    from matplotlib.ticker import MaxNLocator, PercentFormatter

    ax = new_ax(ax, equal=False)
    # Offsets that differ as much as possible between neighbours (golden ratio).
    order = np.arange(len(reference))
    across = DOT_OFFSET * (2 * ((order * 0.618) % 1) - 1)
    ax.scatter(reference, across, s=20, color=REFERENCE_COLOR, alpha=0.6, linewidths=0, zorder=2)
    ax.plot([float(np.median(reference))] * 2, [-0.6, 0.6], color=REFERENCE_COLOR, linewidth=1.2, zorder=1)
    ax.plot([value], [0], marker="D", markersize=7, color=FLOOR_COLOR, markeredgecolor="white", clip_on=False, zorder=3)
    ax.set_title(_wrap(title, STRIP_TITLE_LENGTH), fontsize=7.5, loc="left", color=DARK_INK, pad=2, parse_math=False)
    ax.set_ylim(-0.8, 0.8)
    ax.set_yticks([])
    ax.xaxis.set_major_locator(MaxNLocator(5, steps=(1, 2, 5, 10)))
    if percent:
        ax.xaxis.set_major_formatter(PercentFormatter(1))
    ax.tick_params(axis="x", labelsize=7, length=2)
    ax.spines[["top", "left", "right"]].set_visible(False)
    ax.margins(x=0.06)
    return ax


def _plot_strips(realism: Realism, axes: Sequence[Axes]) -> None:
    """Draw a strip for the likeness, then one for each unusual measure and pattern; axes: one for each strip."""
    from matplotlib.patches import Patch

    title = "likeness to the three reference floors that it is most like"
    plot_strip(realism.usual, realism.likeness, title, ax=axes[0])
    first_pattern = 1 + len(realism.measures)
    for ax, unusual in zip(axes[1:first_pattern], realism.measures, strict=True):
        title, is_share = f"{unusual.meaning}: {unusual.measure.name}", unusual.measure.digits is None
        plot_strip(unusual.usual, unusual.value, title, ax=ax, percent=is_share)
    for ax, pattern, hatch in zip(axes[first_pattern:], realism.patterns, _hatch(realism.patterns), strict=True):
        title = f"{'often' if pattern.is_frequent else 'seldom'} a {pattern.pattern}: share of the rooms"
        plot_strip(pattern.usual, pattern.share, title, ax=ax, percent=True)
        if hatch:
            mark = Patch(facecolor="white", edgecolor=FLOOR_COLOR, hatch=hatch)
            ax.legend([mark], [""], loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handleheight=1.4)


def _hatch(patterns: Sequence[UnusualPattern]) -> list[str]:
    """The hatch of each pattern; empty if it is too rare, as no room shows that."""
    hatches = iter(HATCHES)
    return [next(hatches) if pattern.is_frequent else "" for pattern in patterns]


def _wrap(text: str, width: int) -> str:
    return "\n".join(textwrap.wrap(text, width))
