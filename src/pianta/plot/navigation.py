"""Pictures of where robots go: a route graph over its map, and the paths of a plan to clean a floor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import networkx as nx

from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.navigation.cleaning import CleaningPlan
from pianta.plot.figure import GRAPH_LEVEL, TEXT_LEVEL, new_ax
from pianta.plot.floor_parts import plot_rooms
from pianta.plot.grid import plot_grid
from pianta.plot.picture import find_extent, show_extent

if TYPE_CHECKING:
    from matplotlib.axes import Axes

EDGE_COLOR = "#224488"
# Colours of nodes, of a palette that colour-blind people see (Wong, Nature Methods 2011), and their sizes, points².
NODE_LOOKS = {"room": ("#d55e00", 34), "door": ("#009e73", 20), "way": (EDGE_COLOR, 5)}
PATH_COLOR = "#224488"
WAY_COLOR = "#d55e00"
PATH_WIDTH = 0.7
MAX_LABEL = 4  # characters of the number of a stop that fit beside its point


def plot_route_graph(graph: nx.DiGraph, floor: Floor, *, grid: GridMap | None = None, ax: Axes | None = None) -> Axes:
    """Draw a route graph: positions in rooms and doors, and the straight edges that a robot can drive.

    Parameters
    ----------
    graph
        The result of `build_route_graph` or `read_route_graph`.
    floor
        Its floor.
    grid
        The map to draw below; None for no map.
    ax
        Where to draw, in metres of the map frame; a new figure if None.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_route_graph(pianta.build_route_graph(floor, grid), floor, grid=grid)
    """
    from matplotlib.collections import LineCollection

    ax = _draw_below(floor, grid, ax)
    points = {node: (data["x"], data["y"]) for node, data in graph.nodes(data=True)}
    lines = [(points[start], points[end]) for start, end in graph.edges if start < end]
    ax.add_collection(
        LineCollection(lines, colors=EDGE_COLOR, linewidths=PATH_WIDTH, zorder=GRAPH_LEVEL), autolim=False
    )
    for node_type, (color, size) in NODE_LOOKS.items():
        chosen = [points[node] for node, data in graph.nodes(data=True) if data["metadata"].get("type") == node_type]
        if chosen:
            x, y = zip(*chosen, strict=True)
            ax.scatter(x, y, s=size, c=color, linewidths=0, zorder=TEXT_LEVEL, label=node_type)
    show_extent(find_extent(floor, grid), ax)
    return ax


def plot_cleaning(plan: CleaningPlan, floor: Floor, *, grid: GridMap | None = None, ax: Axes | None = None) -> Axes:
    """Draw a plan to clean a floor: the path in each room, the ways between them, and the order of the rooms.

    Parameters
    ----------
    plan
        The result of `plan_cleaning`.
    floor
        Its floor.
    grid
        The map to draw below; None for no map.
    ax
        Where to draw, in metres of the map frame; a new figure if None.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_cleaning(pianta.plan_cleaning(floor, grid), floor, grid=grid)
    """
    ax = _draw_below(floor, grid, ax)
    for number, room in enumerate(plan.rooms, start=1):
        ax.plot(*plan.ways[room].T, color=WAY_COLOR, linewidth=PATH_WIDTH, zorder=GRAPH_LEVEL)
        ax.plot(*plan.paths[room].T, color=PATH_COLOR, linewidth=PATH_WIDTH, zorder=GRAPH_LEVEL)
        x, y = plan.paths[room][0]
        ax.text(x, y, str(number)[:MAX_LABEL], ha="center", va="center", zorder=TEXT_LEVEL, **_style_number())
    show_extent(find_extent(floor, grid), ax)
    return ax


def _draw_below(floor: Floor, grid: GridMap | None, ax: Axes | None) -> Axes:
    ax = new_ax(ax)
    if grid is not None:
        plot_grid(grid, ax=ax)
    plot_rooms(floor, ax=ax)
    return ax


def _style_number() -> dict[str, Any]:
    return {"fontsize": 7, "color": "white", "bbox": {"boxstyle": "circle,pad=0.15", "fc": WAY_COLOR, "ec": "none"}}
