"""Picture of how realistic a floor is: the floor with its strangest rooms marked, beside what is off."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from shapely import MultiPolygon

from pianta.floor import Floor
from pianta.labels import SCHEMAS
from pianta.plot._figure import new_ax, save_png
from pianta.plot.floor import DPI, GRAPH_LEVEL, INK, plot_doors, plot_legend, plot_rooms, plot_scale_bar
from pianta.plot.styles import Schemas
from pianta.realism.model import Realism
from pianta.realism.patterns import UnusualPattern

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Reference floors, this floor, and the outlines of strange rooms: Paul Tol's "bright" scheme.
USUAL_COLOR, OWN_COLOR = "#4477aa", "#cc3311"
HATCHES = ("////", "\\\\\\\\", "....")
# Inches: width of the floor's part and of the strips, height of all that belongs to a strip and of its axis alone, of
# the legend and of the title; between parts.
FLOOR_WIDTH, STRIPS_WIDTH, STRIP_HEIGHT, AXIS_HEIGHT, LEGEND_HEIGHT, TITLE_HEIGHT = 6.4, 4.4, 0.82, 0.3, 0.7, 0.5
GAP, RIGHT_GAP = 0.3, 0.7
# Height over width of the floor's part is no more than this.
TALLEST = 1.5
# Characters in a line of a title.
TITLE_WIDTH, STRIP_TITLE_WIDTH = 130, 74
# Dots of reference floors lie so far apart across their strip at most.
SPREAD = 0.3
MARGIN = 0.03
KEY = "dots: reference floors, line: their median, diamond: this floor"


def draw_realism(floor: Floor, realism: Realism, *, schemas: Schemas = SCHEMAS) -> Figure:
    """Picture of a floor and of its realism.

    Left the floor in the colours of its labels; rooms of patterns that are too frequent are outlined and hatched, a
    hatch a pattern. Right a strip for the likeness to reference floors and for all that is off: a dot a reference
    floor, a diamond this one.
    schemas: as in draw_floor.
    """
    from matplotlib.figure import Figure

    strips = 1 + len(realism.measures) + len(realism.patterns)
    left, bottom, right, top = MultiPolygon([room.polygon for room in floor.rooms]).bounds
    of_floor = FLOOR_WIDTH * min((top - bottom) / (right - left), TALLEST)
    height = max(of_floor + LEGEND_HEIGHT, STRIP_HEIGHT * strips) + TITLE_HEIGHT + GAP / 2
    width = GAP + FLOOR_WIDTH + GAP + STRIPS_WIDTH + RIGHT_GAP
    figure = Figure(figsize=(width, height), dpi=DPI, facecolor="white")

    def add_part(x: float, y: float, wide: float, high: float) -> Axes:
        """An ax whose upper left corner is so many inches from that of the figure."""
        return figure.add_axes((x / width, 1 - (y + high) / height, wide / width, high / height))

    title = _wrap(f"{floor.source}: {realism.verdict}", TITLE_WIDTH)
    figure.text(GAP / width, 1 - 0.15 / height, title, fontsize=11, color=INK, va="top", parse_math=False)
    building = add_part(GAP, TITLE_HEIGHT, FLOOR_WIDTH, of_floor)
    plot_strange_floor(floor, realism.patterns, ax=building, schemas=schemas)
    plot_legend(floor, ax=add_part(GAP, TITLE_HEIGHT + of_floor, FLOOR_WIDTH, LEGEND_HEIGHT), schemas=schemas)
    lowest = [TITLE_HEIGHT + STRIP_HEIGHT * (place + 0.8) for place in range(strips)]
    at_left = FLOOR_WIDTH + 2 * GAP
    figure.text(at_left / width, 1 - TITLE_HEIGHT / height, KEY, fontsize=7.5, color=USUAL_COLOR, va="top")
    _plot_strips(realism, [add_part(at_left, y - AXIS_HEIGHT, STRIPS_WIDTH, AXIS_HEIGHT) for y in lowest])
    return figure


def save_realism_picture(floor: Floor, realism: Realism, path: str | Path, *, schemas: Schemas = SCHEMAS) -> None:
    """Write the picture of draw_realism as a PNG, the same bytes for the same floor.

    Raises PiantaError when the file cannot be written.
    """
    figure = draw_realism(floor, realism, schemas=schemas)
    save_png(figure, path)


def plot_strange_floor(
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
            mark = {"facecolor": "none", "edgecolor": OWN_COLOR, "hatch": hatch, "linewidth": 1.6}
            ax.add_patch(patch_from_polygon(polygons[room_id], **mark, zorder=GRAPH_LEVEL))
    left, bottom, right, top = MultiPolygon([*polygons.values()]).bounds
    margin = MARGIN * max(right - left, top - bottom)
    ax.set(xlim=(left - margin, right + margin), ylim=(bottom - 3 * margin, top + margin), aspect="equal", anchor="N")
    ax.set_axis_off()
    return plot_scale_bar(ax=ax)


def plot_strip(
    usual: Sequence[float], value: float, title: str, *, ax: Axes | None = None, percent: bool = False
) -> Axes:
    """Draw a number of a floor as a diamond among those of the reference floors, dots."""
    from matplotlib.ticker import MaxNLocator, PercentFormatter

    ax = new_ax(ax, equal=False)
    # Equal numbers lie beside each other.
    order = np.arange(len(usual))
    across = SPREAD * (2 * ((order * 0.618) % 1) - 1)
    ax.scatter(usual, across, s=20, color=USUAL_COLOR, alpha=0.6, linewidths=0, zorder=2)
    ax.plot([float(np.median(usual))] * 2, [-0.6, 0.6], color=USUAL_COLOR, linewidth=1.2, zorder=1)
    ax.plot([value], [0], marker="D", markersize=7, color=OWN_COLOR, markeredgecolor="white", clip_on=False, zorder=3)
    ax.set_title(_wrap(title, STRIP_TITLE_WIDTH), fontsize=7.5, loc="left", color=INK, pad=2, parse_math=False)
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
    from matplotlib.patches import Patch

    title = "likeness to the three reference floors that it is most like"
    plot_strip(realism.usual, realism.likeness, title, ax=axes[0])
    of_measures, of_patterns = np.split(np.array(axes[1:], dtype=object), [len(realism.measures)])
    for ax, off in zip(of_measures, realism.measures, strict=True):
        share = off.measure.digits is None
        plot_strip(off.usual, off.value, f"{off.meaning}: {off.measure.name}", ax=ax, percent=share)
    for ax, strange, hatch in zip(of_patterns, realism.patterns, _hatch(realism.patterns), strict=True):
        often = "often" if strange.is_frequent else "seldom"
        title = f"{often} a {strange.pattern}: share of the rooms"
        plot_strip(strange.usual, strange.share, title, ax=ax, percent=True)
        if hatch:
            mark = Patch(facecolor="white", edgecolor=OWN_COLOR, hatch=hatch)
            ax.legend([mark], [""], loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handleheight=1.4)


def _hatch(patterns: Sequence[UnusualPattern]) -> list[str]:
    """The hatch of each pattern; empty for one that is too rare, whose rooms are not strange."""
    hatches = iter(HATCHES)
    return [next(hatches) if pattern.is_frequent else "" for pattern in patterns]


def _wrap(text: str, width: int) -> str:
    return "\n".join(textwrap.wrap(text, width))
