"""Picture of an evacuation: rooms by the length of their ways out, the ways, exits, dead ends and shut doors."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise
from math import ceil, inf
from typing import TYPE_CHECKING, Any

from pianta.evacuation.evacuation import Evacuation
from pianta.plot.figure import DOOR_LEVEL, GRAPH_LEVEL, ROOM_LEVEL, WALL_LEVEL, new_ax
from pianta.plot.floor_parts import HATCH_COLOR, draw_door, draw_entrance, plot_doors
from pianta.plot.picture import add_legend, find_extent, new_picture, plot_scale_bar, show_extent
from pianta.plot.room_marks import plot_ids
from pianta.plot.styles import EDGE_COLOR, RoomStyle

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

# Near to far: a sequence of ColorBrewer, "YlOrBr", readable without colour by its lightness.
DISTANCE_COLORS = ("#ffffe5", "#fff0b3", "#fed676", "#feb43f", "#ee8d20", "#cc5e0a")
EXIT_COLOR = "#99ddbb"
CUT_OFF_COLOR = "#cccccc"
WAY_COLOR = "#224488"
ALARM_COLOR = "#bb0000"
# Hatches of rooms that a shut door elsewhere cuts off, and of those without a way out.
DEAD_END_HATCH = "////"
CUT_OFF_HATCH = "xxxx"
# Line widths of a way of one person, and of all people.
WAY_WIDTHS = (0.5, 3.0)


def plot_evacuation(evacuation: Evacuation, *, ax: Axes | None = None) -> Axes:
    """Draw the rooms by the length of their ways out, the ways from their middles, exits, shut doors and dead ends.

    A way is as wide as the number of people on it. The ring is the door that costs most if it is shut.

    Parameters
    ----------
    evacuation
        The result of `evacuate`.
    ax
        Where to draw, in metres of the map frame; a new figure if None.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, _ = pianta.make_world("corridor")
    >>> evacuation = pianta.evacuate(floor, exits=[2])
    >>> ax = pianta.plot.plot_evacuation(evacuation)
    """
    from shapely.plotting import patch_from_polygon

    ax = new_ax(ax)
    floor, step = evacuation.floor, _choose_step(evacuation)
    styles = {way.room: RoomStyle(_color_room(evacuation, way.room, way.longest, step), 1.0) for way in evacuation.ways}
    for room in floor.rooms:
        look: dict[str, Any] = {"facecolor": styles[room.id].color, "edgecolor": EDGE_COLOR, "linewidth": 0.6}
        ax.add_artist(patch_from_polygon(room.polygon, **look, zorder=ROOM_LEVEL))
        mark = _mark_room(evacuation, room.id)
        if mark:
            ax.add_artist(patch_from_polygon(room.polygon, **mark, zorder=WALL_LEVEL))
    _plot_ways(evacuation, ax)
    plot_doors(floor, ax=ax)
    plot_ids(floor, styles, ax)
    _plot_marked_doors(evacuation, ax)
    show_extent(find_extent(floor, None), ax)
    return ax


def draw_evacuation(evacuation: Evacuation) -> Figure:
    """Picture of an evacuation with a scale bar and a legend."""
    figure, ax = new_picture(find_extent(evacuation.floor, None))
    plot_evacuation(evacuation, ax=ax)
    plot_scale_bar(ax=ax)
    add_legend(figure, _list_samples(evacuation))
    return figure


def _choose_step(evacuation: Evacuation) -> int:
    """Metres of each class of distances, a multiple of five unless they are short, so that the colours are enough."""
    needed = max(ceil(evacuation.longest.longest / len(DISTANCE_COLORS)), 1)
    return needed if needed <= 5 else 5 * ceil(needed / 5)


def _color_room(evacuation: Evacuation, room: int, longest: float, step: int) -> str:
    if room in evacuation.exit_rooms:
        return EXIT_COLOR
    return CUT_OFF_COLOR if longest == inf else DISTANCE_COLORS[min(int(longest / step), len(DISTANCE_COLORS) - 1)]


def _mark_room(evacuation: Evacuation, room: int) -> dict[str, Any]:
    """The hatch of a dead end, or of a room without a way out; empty for other rooms."""
    hatch: dict[str, Any] = {"facecolor": "none", "linewidth": 0}
    if room in evacuation.cut_off:
        return hatch | {"edgecolor": HATCH_COLOR, "hatch": CUT_OFF_HATCH}
    return hatch | {"edgecolor": ALARM_COLOR, "hatch": DEAD_END_HATCH} if room in evacuation.dead_ends else {}


def _plot_ways(evacuation: Evacuation, ax: Axes) -> None:
    """Draw each piece of a way once, as wide as the people on it; all are on the way from the middle of their room."""
    from matplotlib.collections import LineCollection

    pieces: Counter[tuple[tuple[float, float], tuple[float, float]]] = Counter()
    for way in evacuation.ways:
        points = [(float(x), float(y)) for x, y in way.line]
        for start, end in pairwise(points):
            pieces[start, end] += way.people
    thin, wide = WAY_WIDTHS
    widths = [thin + (wide - thin) * (count / max(evacuation.people, 1)) ** 0.5 for count in pieces.values()]
    ways = LineCollection([*pieces], linewidths=widths, colors=WAY_COLOR, capstyle="round", zorder=GRAPH_LEVEL)
    ax.add_collection(ways, autolim=False)


def _plot_marked_doors(evacuation: Evacuation, ax: Axes) -> None:
    """Draw a cross on each door that is shut, and a ring around the one that costs most if it is."""
    marked = {door.number: "X" for door in evacuation.doors if door.is_shut}
    if ranked := evacuation.rank_doors():
        marked[ranked[0].number] = "o"
    for number, marker in marked.items():
        middle = evacuation.floor.doors[number - 1].line.interpolate(0.5, normalized=True)
        ax.plot(*middle.xy, zorder=DOOR_LEVEL, **_style_mark(marker))


def _style_mark(marker: str) -> dict[str, Any]:
    face = ALARM_COLOR if marker == "X" else "none"
    size = 8 if marker == "X" else 13
    edge = "white" if marker == "X" else ALARM_COLOR
    return {
        "marker": marker,
        "markersize": size,
        "markerfacecolor": face,
        "markeredgecolor": edge,
        "markeredgewidth": 1.6 if marker == "o" else 0.8,
        "linestyle": "",
    }


def _list_samples(evacuation: Evacuation) -> list[tuple[Artist, str]]:
    """Handles and texts of the legend."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    def fill(color: str, edge: str = EDGE_COLOR, hatch: str = "") -> Patch:
        return Patch(facecolor=color, edgecolor=edge, hatch=hatch, linewidth=0.6)

    step = _choose_step(evacuation)
    classes = min(ceil(evacuation.longest.longest / step + 1e-9), len(DISTANCE_COLORS))
    samples: list[tuple[Artist, str]] = [
        (fill(DISTANCE_COLORS[index]), f"farthest point {index * step} to {(index + 1) * step} m from an exit")
        for index in range(classes)
    ]
    if evacuation.exit_rooms:
        samples.append((fill(EXIT_COLOR), "exit"))
    if evacuation.exit_doors:
        samples.append((draw_entrance([], []), "entrance, an exit"))
    samples.append((Line2D([], [], color=WAY_COLOR, linewidth=1.5), "way, as wide as its people"))
    samples.append((draw_door([], []), "door"))
    if evacuation.dead_ends:
        mark = fill("white", ALARM_COLOR, DEAD_END_HATCH)
        samples.append((mark, "dead end: one way behind its own door"))
    if evacuation.cut_off:
        samples.append((fill(CUT_OFF_COLOR, HATCH_COLOR, CUT_OFF_HATCH), "no way out"))
    if evacuation.rank_doors():
        samples.append((Line2D([], [], **_style_mark("o") | {"markersize": 8}), "costs most if shut"))
    if any(door.is_shut for door in evacuation.doors):
        samples.append((Line2D([], [], **_style_mark("X")), "shut"))
    return samples
