"""Pictures of floors: all parts of a floor on its map, and the legend of their colours and marks.

matplotlib is imported when something is drawn; pyplot only for a new ax that a user asks for.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pianta.floor import PREDICTED_FLAG, Floor
from pianta.floor.area_trust import AreaTrust
from pianta.gridmap import UNKNOWN, GridMap
from pianta.labels import SCHEMAS
from pianta.plot.figure import DPI, encode_png, new_ax, shorten
from pianta.plot.floor_parts import (
    FURNITURE_COLOR,
    FURNITURE_OPACITY,
    HATCH,
    HATCH_COLOR,
    OUTLINE_COLOR,
    draw_door,
    draw_entrance,
    draw_possible_door,
    list_predicted_parts,
    plot_doors,
    plot_furniture,
    plot_rooms,
    plot_walls,
)
from pianta.plot.grid import add_background, paint_grid, plot_grid, plot_ink
from pianta.plot.picture import add_legend, find_extent, new_picture, plot_samples, plot_scale_bar, show_extent
from pianta.plot.room_marks import plot_graph
from pianta.plot.styles import CERTAIN_FROM, DARK_INK, EDGE_COLOR, RoomStyle, Schemas, list_labels, style_rooms

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# The legend gives the ids of the rooms of a label if they are no more than these.
FEW_ROOMS = 3


def plot_floor(
    floor: Floor,
    grid: GridMap | None = None,
    *,
    ax: Axes | None = None,
    walls: bool = False,
    graph: bool = False,
    furniture: bool = True,
    schemas: Schemas = SCHEMAS,
    paper: NDArray[np.uint8] | None = None,
) -> Axes:
    """Draw a floor: its rooms with their ids, in the colours of their labels if they have any, and its doors.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    grid
        The map below it, if any.
    ax
        Where to draw; a new figure if None.
    walls, graph
        Whether to draw the wall lines and the topological graph too.
    furniture
        Whether to draw the furniture.
    schemas
        By building type, the labels whose colours are known.
    paper
        The sheet of a plan, RGB of shape (H, W, 3) on the cells of the grid; its ink is drawn over the rooms.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_floor(floor, grid)
    """
    ax = new_ax(ax)
    if grid is not None:
        plot_grid(grid, ax=ax)
        if paper is not None:
            plot_ink(paper, grid, ax=ax)
    labels = _has_labels(floor)
    plot_rooms(floor, ax=ax, labels=labels, schemas=schemas)
    if furniture:
        plot_furniture(floor, ax=ax)
    if walls:
        plot_walls(floor, ax=ax)
    if graph:
        plot_graph(floor, ax=ax, labels=labels, schemas=schemas)
    plot_doors(floor, ax=ax)
    if floor.rooms or grid is not None:
        show_extent(find_extent(floor, grid), ax)
    return ax


def draw_floor(
    floor: Floor,
    grid: GridMap,
    *,
    walls: bool = False,
    graph: bool = False,
    schemas: Schemas = SCHEMAS,
    paper: NDArray[np.uint8] | None = None,
    area_trust: AreaTrust = AreaTrust.EXACT,
) -> Figure:
    """Picture of a floor on its map, cropped to the building: rooms with their ids, doors, and a scale bar.

    The building has a long side of 1600 pixels. If any room has a label, rooms have the colours of their labels, and
    the picture is larger by a legend below or right of the building. Options as in plot_floor. area_trust: whether the
    scale bar is certain.
    """
    extent = find_extent(floor, grid)
    figure, ax = new_picture(extent)
    width, height = (round(side * DPI) for side in figure.get_size_inches())
    if paper is not None:
        plot_ink(paper, grid, ax=ax)
    plot_floor(floor, ax=ax, walls=walls, graph=graph, schemas=schemas)
    show_extent(extent, ax)
    plot_scale_bar(ax=ax, area_trust=area_trust)
    legend_height = add_legend(figure, list_samples(floor, schemas, graph=graph)) if _has_labels(floor) else 0.0
    add_background(paint_grid(grid, extent, (width, height)), figure, bottom=round(legend_height * DPI))
    return figure


def render_floor(floor: Floor) -> bytes:
    """The floor as a PNG, without a map below it."""
    left, bottom, right, top = find_extent(floor, None)
    empty = GridMap(np.full((1, 1), UNKNOWN, np.int8), max(right - left, top - bottom), (left, bottom, 0.0))
    return encode_png(draw_floor(floor, empty))


def plot_legend(floor: Floor, *, ax: Axes | None = None, graph: bool = False, schemas: Schemas = SCHEMAS) -> Axes:
    """Draw the labels that rooms have, in the upper left of an ax: colour, number of rooms, and their ids if few.

    Below them stand the other marks of labels: uncertain ones, partial rooms, and with graph the shapes of nodes.
    """
    ax = new_ax(ax)
    plot_samples(list_samples(floor, schemas, graph=graph), ax)
    return ax


def list_samples(floor: Floor, schemas: Schemas, *, graph: bool = False) -> list[tuple[Artist, str]]:
    """Handles and texts of a legend: one for each label of the floor, if any, then one for each other mark."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    samples: list[tuple[Artist, str]] = []
    for label, color, ids in list_labels(floor, schemas) if _has_labels(floor) else ():
        name = "no label" if label is None else shorten(" ".join(label.split()))
        listed = f" ({' '.join(map(str, ids))})" if len(ids) <= FEW_ROOMS else ""
        handle = Patch(facecolor=RoomStyle(color).fill, edgecolor=EDGE_COLOR, linewidth=0.6)
        samples.append((handle, f"{len(ids)} × {name}{listed}"))
    if any(style.is_uncertain for style in style_rooms(floor, schemas).values()):
        mark = Line2D([], [], linestyle="", marker="$?$", color=DARK_INK)
        samples.append((mark, f"probability below {CERTAIN_FROM:g}"))
    if any(list_predicted_parts(room) for room in floor.rooms):
        outline: dict[str, Any] = {"edgecolor": HATCH_COLOR, "linestyle": (0, (2, 1.5)), "linewidth": 0.6}
        samples.append((Patch(facecolor="none", hatch=2 * HATCH, **outline), "predicted"))
    if any(room.partial for room in floor.rooms):
        samples.append((Patch(facecolor="white", edgecolor=HATCH_COLOR, hatch="////", linewidth=0.6), "seen in part"))
    if any(room.flag == PREDICTED_FLAG for room in floor.rooms):
        unseen: dict[str, Any] = {"edgecolor": OUTLINE_COLOR, "linestyle": (0, (2, 1.5)), "linewidth": 0.9}
        samples.append((Patch(facecolor="white", **unseen), "unseen room, predicted"))
    samples += _list_passages(floor)
    if floor.furniture:
        samples.append((Patch(facecolor=(FURNITURE_COLOR, FURNITURE_OPACITY), linewidth=0), "furniture"))
    if floor.possible_doors:
        samples.append((draw_possible_door([], []), "possible door, shut"))
    for marker, name in (("s", "corridor"), ("o", "room")) if graph else ():
        node = Line2D([], [], linestyle="", marker=marker, markersize=7, color=DARK_INK, markerfacecolor="white")
        samples.append((node, name))
    return samples


def list_shared_samples(floors: Sequence[Floor], schemas: Schemas) -> list[tuple[Artist, str]]:
    """Handles and texts for what any of the floors has; labels without the numbers of their rooms."""
    labels: dict[str, Artist] = {}
    marks: dict[str, Artist] = {}
    for floor in floors:
        for handle, text in list_samples(floor, schemas):
            _, is_label, label = text.partition(" × ")
            (labels if is_label else marks).setdefault(label.partition(" (")[0] or text, handle)
    return [(handle, text) for entries in (labels, marks) for text, handle in entries.items()]


def _list_passages(floor: Floor) -> list[tuple[Artist, str]]:
    """Handles and texts of a legend for the kinds of passages of a floor."""
    inner = {door.kind for door in floor.doors if not door.is_entrance}
    samples: list[tuple[Artist, str]] = []
    if "door" in inner:
        samples.append((draw_door([], []), "door"))
    if "opening" in inner:
        samples.append((draw_door([], [], is_opening=True), "opening"))
    if any(door.is_entrance for door in floor.doors):
        samples.append((draw_entrance([], []), "entrance"))
    return samples


def _has_labels(floor: Floor) -> bool:
    return any(room.label is not None for room in floor.rooms)
