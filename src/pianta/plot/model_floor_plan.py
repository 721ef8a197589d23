"""Pictures of model floor plans: the occurrences of each pattern in one colour."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely

from pianta.floor import Floor
from pianta.floor.polygons import list_polygons
from pianta.patterns.model_floor_plan import ModelFloorPlan, Occurrence, Pattern
from pianta.plot.figure import GRAPH_LEVEL, ROOM_LEVEL, TEXT_LEVEL, new_ax
from pianta.plot.floor_parts import plot_doors
from pianta.plot.picture import add_legend, find_extent, new_picture, plot_scale_bar, show_extent
from pianta.plot.styles import DARK_INK, EDGE_COLOR

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Of patterns, those that save most rooms first: Paul Tol's "bright" and "vibrant" schemes.
COLORS = ("#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#ee7733", "#009988", "#cc3311", "#bbbbbb")
OTHER_COLOR = "#f7f7f7"  # rooms in no pattern
# Share of white in the colours of the rooms of a pattern, from its first room to its last.
TINTS = (0.15, 0.6)
HATCHES = ("////", "\\\\\\\\", "....", "xxxx")  # of patterns within a pattern, by their order
MODEL_WIDTH = 2.0  # points, of the outline of the first occurrence
NAME_SIZE = 8  # points
ID_SIZE = 5  # points
WIDE = 3.0  # width over height of a room, from which its id is to the right of a name and not below; chosen by hand
# Units of the floor: outlines of rooms that are nearer are one.
JOIN_SHARE = 0.01


def plot_model_floor_plan(floor: Floor, plan: ModelFloorPlan, *, storey: int = 0, ax: Axes | None = None) -> Axes:
    """Draw a floor with the occurrences of each pattern in one colour; corresponding rooms have one tint.

    The first occurrence of a pattern has a thick outline. Patterns within it are hatched.

    Parameters
    ----------
    floor
        A floor of the plan.
    plan
        The result of `find_model_floor_plan`.
    storey
        The index of the floor among those that were given.
    ax
        Where to draw, metres of the map frame; a new figure if None.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, _ = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_model_floor_plan(floor, pianta.find_model_floor_plan(floor, shuffles=0))
    """
    ax = new_ax(ax)
    colors: dict[int, str | tuple[float, ...]] = {
        room: tint for pattern, color in _color(plan) for room, tint in _tint_rooms(pattern, color, storey)
    }
    for room in floor.rooms:
        fill = colors.get(room.id, OTHER_COLOR)
        _add_patch(room.polygon, ax, zorder=ROOM_LEVEL, facecolor=fill, edgecolor=EDGE_COLOR, linewidth=0.6)
    plot_doors(floor, ax=ax)
    for pattern, color in _color(plan):
        for number, occurrence in enumerate(pattern.occurrences, start=1):
            if occurrence.storey == storey:
                _plot_occurrence(floor, occurrence, f"{pattern.name}{number}", color, ax)
        _plot_inner(floor, pattern.inner, storey, ax)
    _plot_ids(floor, plan, storey, ax)
    show_extent(find_extent(floor, None), ax)
    return ax


def draw_model_floor_plan(floor: Floor, plan: ModelFloorPlan, *, storey: int = 0) -> Figure:
    """Picture of a floor with its patterns, a legend and a scale bar; arguments as in plot_model_floor_plan."""
    extent = find_extent(floor, None)
    figure, ax = new_picture(extent)
    plot_model_floor_plan(floor, plan, storey=storey, ax=ax)
    plot_scale_bar(ax=ax)
    add_legend(figure, [*_list_samples(plan, storey)])
    return figure


def _color(plan: ModelFloorPlan) -> list[tuple[Pattern, str]]:
    """The patterns with their colours."""
    return [(pattern, COLORS[number % len(COLORS)]) for number, pattern in enumerate(plan.patterns)]


def _tint_rooms(pattern: Pattern, color: str, storey: int) -> Iterator[tuple[int, tuple[float, ...]]]:
    """The rooms of a pattern on a storey with their colours."""
    from matplotlib.colors import to_rgb

    tints = np.linspace(*TINTS, len(pattern.occurrences[0].rooms))
    for occurrence in pattern.occurrences:
        if occurrence.storey == storey:
            for room, tint in zip(occurrence.rooms, tints, strict=True):
                yield room, tuple(tint + (1 - tint) * part for part in to_rgb(color))


def _plot_occurrence(floor: Floor, occurrence: Occurrence, name: str, color: str, ax: Axes) -> None:
    """The name of an occurrence in its largest room, and the outline of the first one."""
    polygons = [floor[room].polygon for room in occurrence.rooms]
    largest = floor[_find_largest(floor, occurrence)].polygon
    middle = largest.representative_point()
    text: dict[str, Any] = {"ha": "center", "va": "center", "zorder": TEXT_LEVEL, "color": DARK_INK}
    ax.text(middle.x, middle.y, name, fontsize=NAME_SIZE, fontweight="bold", **text)
    if occurrence.motion is None:
        reach = JOIN_SHARE * float(np.sqrt(largest.area))
        joined = shapely.union_all(shapely.buffer(polygons, reach, join_style="mitre"))
        for part in list_polygons(joined):
            look = {"facecolor": "none", "edgecolor": color, "linewidth": MODEL_WIDTH}
            _add_patch(part, ax, zorder=GRAPH_LEVEL, **look)


def _find_largest(floor: Floor, occurrence: Occurrence) -> int:
    """The id of the largest room of an occurrence, which has its name."""
    return max(occurrence.rooms, key=lambda room: floor[room].polygon.area)


def _plot_ids(floor: Floor, plan: ModelFloorPlan, storey: int, ax: Axes) -> None:
    """The id of each room inside it, beside the name of an occurrence where there is one."""
    named = {
        _find_largest(floor, occurrence)
        for pattern in plan.patterns
        for occurrence in pattern.occurrences
        if occurrence.storey == storey
    }
    for room in floor.rooms:
        middle = room.polygon.representative_point()
        left, bottom, right, top = room.polygon.bounds
        beside = (2 * NAME_SIZE, 0) if right - left > WIDE * (top - bottom) else (0, -NAME_SIZE)
        ax.annotate(
            str(room.id),
            (middle.x, middle.y),
            xytext=beside if room.id in named else (0, 0),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=ID_SIZE,
            color=DARK_INK,
            zorder=TEXT_LEVEL,
        )


def _plot_inner(floor: Floor, patterns: Sequence[Pattern], storey: int, ax: Axes) -> None:
    """Hatch the rooms of patterns within a pattern."""
    for number, pattern in enumerate(patterns):
        look = {"facecolor": "none", "edgecolor": DARK_INK, "linewidth": 0, "hatch": HATCHES[number % len(HATCHES)]}
        for occurrence in pattern.occurrences:
            for room in occurrence.rooms if occurrence.storey == storey else ():
                _add_patch(floor[room].polygon, ax, zorder=GRAPH_LEVEL, alpha=0.35, **look)


def _add_patch(polygon: shapely.Polygon, ax: Axes, **look: object) -> None:
    from shapely.plotting import patch_from_polygon

    ax.add_patch(patch_from_polygon(polygon, **look))


def _list_samples(plan: ModelFloorPlan, storey: int) -> Iterator[tuple[Artist, str]]:
    """Handles and texts of the legend."""
    from matplotlib.patches import Patch

    for pattern, color in _color(plan):
        if any(occurrence.storey == storey for occurrence in pattern.occurrences):
            rooms, times = len(pattern.occurrences[0].rooms), len(pattern.occurrences)
            yield Patch(facecolor=color), f"{pattern.name}: {rooms} rooms, {times} times"
            for number, inner in enumerate(pattern.inner):
                rooms, times = len(inner.occurrences[0].rooms), len(inner.occurrences)
                hatch = Patch(facecolor="white", edgecolor=DARK_INK, hatch=HATCHES[number % len(HATCHES)])
                yield hatch, f"{inner.name}: {rooms} rooms, {times} times"
    yield Patch(facecolor=OTHER_COLOR, edgecolor=EDGE_COLOR), "in no pattern"
