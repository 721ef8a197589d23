"""The parts of a floor, each by a function of its own: rooms, doors, walls and furniture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from shapely import Polygon, difference

from pianta.floor import PREDICTED_FLAG, Floor, Room
from pianta.floor.polygons import list_polygons
from pianta.labels import SCHEMAS
from pianta.layout._label_images import SNAP_DISTANCE
from pianta.plot.figure import DOOR_LEVEL, FURNITURE_LEVEL, PREDICTION_LEVEL, ROOM_LEVEL, WALL_LEVEL, new_ax
from pianta.plot.room_marks import plot_ids
from pianta.plot.styles import EDGE_COLOR, RoomStyle, Schemas, color_neighbours, style_rooms

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

DOOR_COLOR = "#aa1133"
# Dashes of an opening and of a possible door, in line widths.
OPENING_DASHES = (0, (0.8, 0.5))
POSSIBLE_DASHES = (0, (2.5, 1.5))
ENTRANCE_COLOR = "#117733"
WALL_COLOR = "#3355bb"
# Fill of furniture over the colours of rooms, and its opacity.
FURNITURE_COLOR = "#6b5d4a"
FURNITURE_OPACITY = 0.45
# Fill, hatch and predicted outline of partial rooms.
PARTIAL_COLOR = "#cccccc"
HATCH_COLOR = "#999999"
OUTLINE_COLOR = "#777777"
# Hatch of the predicted part of a room, and dashes of its outline, in line widths.
HATCH = "\\\\"
DASHES = (0, (4, 2.5))
# Smaller predicted parts of a room are its walls, m².
MIN_PREDICTED_AREA = 0.05


def plot_rooms(floor: Floor, *, ax: Axes | None = None, labels: bool = False, schemas: Schemas = SCHEMAS) -> Axes:
    """Draw the rooms with their ids, and the predicted extent of partial rooms.

    Neighbours have different colours; partial rooms are grey and hatched, those with the flag "predicted" are dashed.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    ax
        Where to draw; a new figure if None.
    labels
        Use the colours of the labels instead; partial rooms are light and hatched, and a `?` follows the id if the
        label has a probability below 0.6.
    schemas
        By building type, the labels whose colours are known.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_rooms(floor, labels=True)
    """
    from shapely.plotting import patch_from_polygon

    ax = new_ax(ax)
    styles = style_rooms(floor, schemas) if labels else style_by_neighbours(floor.rooms)
    for room in floor.rooms:
        style = styles[room.id]
        edge: dict[str, Any] = {"edgecolor": EDGE_COLOR}
        if room.flag == PREDICTED_FLAG:
            edge = {"edgecolor": OUTLINE_COLOR, "linestyle": DASHES}
        elif room.partial:
            edge = {"edgecolor": HATCH_COLOR, "hatch": "//"}
        face = (style.color, style.opacity)
        patch = patch_from_polygon(room.polygon, facecolor=face, **edge, linewidth=0.6, zorder=ROOM_LEVEL)
        ax.add_artist(patch)
    _plot_predictions(floor, ax)
    plot_ids(floor, styles, ax)
    _extend_view(floor, ax)
    return ax


def style_by_neighbours(rooms: Sequence[Room]) -> dict[int, RoomStyle]:
    """Styles of rooms by their ids, without labels: neighbours differ in colour, partial rooms are grey."""
    colors = zip(rooms, color_neighbours(rooms), strict=True)
    return {room.id: RoomStyle(PARTIAL_COLOR if room.partial else color) for room, color in colors}


def _plot_predictions(floor: Floor, ax: Axes) -> None:
    """Draw the predicted extent of partial rooms: a dashed outline, and a hatch where the room was not observed."""
    from shapely.plotting import patch_from_polygon

    for room in floor.rooms:
        if room.predicted is None:
            continue
        for part in list_predicted_parts(room):
            hatch = {"facecolor": "none", "edgecolor": HATCH_COLOR, "hatch": HATCH, "linewidth": 0}
            ax.add_artist(patch_from_polygon(part, **hatch, zorder=PREDICTION_LEVEL))
        outline = {"facecolor": "none", "edgecolor": OUTLINE_COLOR, "linestyle": DASHES, "linewidth": 0.9}
        ax.add_artist(patch_from_polygon(room.predicted, **outline, zorder=PREDICTION_LEVEL))


def list_predicted_parts(room: Room) -> list[Polygon]:
    """The parts of a room that are predicted, without thin ones, which are its walls."""
    if room.predicted is None:
        return []
    parts = list_polygons(difference(room.predicted, room.polygon, grid_size=SNAP_DISTANCE))
    return [part for part in parts if part.area >= MIN_PREDICTED_AREA]


def _extend_view(floor: Floor, ax: Axes) -> None:
    """Let an ax show all rooms, unless its limits are set.

    Axes.add_patch would do so too, but takes longer than drawing the patches.
    """
    if floor.rooms:
        ax.update_datalim(np.reshape(shapely.total_bounds([room.polygon for room in floor.rooms]), (2, 2)))
        ax.autoscale_view()


def plot_doors(floor: Floor, *, ax: Axes | None = None) -> Axes:
    """Draw the doors as strokes from jamb to jamb, openings dashed, entrances in another colour with a diamond.

    The larger the scale of the ax, the wider the strokes, within limits. Possible doors are thin dashed lines.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    ax
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_rooms(floor)
    >>> ax = pianta.plot.plot_doors(floor, ax=ax)
    """
    ax = new_ax(ax)
    for door in floor.possible_doors:
        ax.add_line(draw_possible_door(*door.line.xy))
    for door in floor.doors:
        color = ENTRANCE_COLOR if door.is_entrance else DOOR_COLOR
        ax.add_line(draw_door(*door.line.xy, color=color, is_opening=door.kind == "opening"))
        if door.is_entrance:
            ax.add_line(draw_entrance(*door.line.interpolate(0.5, normalized=True).xy))
    return ax


def draw_door(x: Sequence[float], y: Sequence[float], *, color: str = DOOR_COLOR, is_opening: bool = False) -> Line2D:
    """The line of a door, or its sample in a legend."""
    from pianta.plot.strokes import DIAMOND_LIMITS, LIMITS, DoorStroke

    style: Any = OPENING_DASHES if is_opening else "-"
    size = {"linewidth": LIMITS[1], "markersize": DIAMOND_LIMITS[1]}
    look: dict[str, Any] = {**size, "linestyle": style, "solid_capstyle": "butt"}
    return DoorStroke(x, y, color=color, zorder=DOOR_LEVEL, **look)


def draw_entrance(x: Sequence[float], y: Sequence[float]) -> Line2D:
    """The diamond at an entrance, for readers who cannot distinguish the colours of doors, or its legend sample."""
    line = draw_door(x, y, color=ENTRANCE_COLOR)
    line.set(marker="D", markeredgecolor="white")
    return line


def draw_possible_door(x: Sequence[float], y: Sequence[float]) -> Line2D:
    """The line of a possible door, or its sample in a legend."""
    from matplotlib.lines import Line2D

    return Line2D(x, y, color=DOOR_COLOR, linewidth=1.2, linestyle=POSSIBLE_DASHES, zorder=DOOR_LEVEL)


def plot_walls(floor: Floor, *, ax: Axes | None = None) -> Axes:
    """Draw the representative lines of the walls.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    ax
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_walls(pianta.reconstruct(grid))
    """
    ax = new_ax(ax)
    for wall in floor.walls:
        ax.plot(*wall.xy, color=WALL_COLOR, linewidth=0.8, zorder=WALL_LEVEL)
    return ax


def plot_furniture(floor: Floor, *, ax: Axes | None = None) -> Axes:
    """Draw the furniture in a muted brown.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    ax
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> _, grid = pianta.make_world("corridor", furniture=0.5)
    >>> floor = pianta.reconstruct(grid)
    >>> ax = pianta.plot.plot_rooms(floor)
    >>> ax = pianta.plot.plot_furniture(floor, ax=ax)
    """
    from shapely.plotting import patch_from_polygon

    ax = new_ax(ax)
    look = {"facecolor": (FURNITURE_COLOR, FURNITURE_OPACITY), "linewidth": 0, "zorder": FURNITURE_LEVEL}
    for piece in floor.furniture:
        ax.add_artist(patch_from_polygon(piece.polygon, **look))
    return ax
