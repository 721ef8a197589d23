"""Pictures of floors: each plot_ function draws one thing on a matplotlib ax, in metres of the map frame.

matplotlib is imported when something is drawn; pyplot only for a new ax that a user asks for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, hypot, log10, pi, sqrt
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Point, Polygon, difference, get_parts

from pianta._types import Floats
from pianta.floor import Floor, Room
from pianta.gridmap import UNKNOWN, GridMap
from pianta.labels import SCHEMAS
from pianta.layout._label_images import SNAP_DISTANCE
from pianta.plot.figure import DPI, clean_legend, encode_png, make_square, new_ax, new_figure, shorten
from pianta.plot.grid import UNKNOWN_GREY, add_background, paint_grid, plot_grid, plot_ink
from pianta.plot.styles import CERTAIN_FROM, DARK_INK, RoomStyle, Schemas, color_neighbours, list_labels, style_rooms

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

DOOR_COLOR = "#aa1133"
# Dashes of a possible door, in line widths.
POSSIBLE_DASHES = (0, (2.5, 1.5))
ENTRANCE_COLOR = "#117733"
WALL_COLOR = "#3355bb"
EDGE_COLOR = "#555555"
# Fill of furniture over the colours of rooms, and its opacity.
FURNITURE_COLOR = "#6b5d4a"
FURNITURE_OPACITY = 0.45
# Fill, hatch and predicted outline of partial rooms.
PARTIAL_COLOR = "#cccccc"
HATCH_COLOR = "#999999"
OUTLINE_COLOR = "#777777"
BACKGROUND = f"#{UNKNOWN_GREY:02x}{UNKNOWN_GREY:02x}{UNKNOWN_GREY:02x}"
# Hatch of the predicted part of a room, and dashes of its outline, in line widths.
HATCH = "\\\\"
DASHES = (0, (4, 2.5))

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
# Radius of an id per radius of the largest circle around it in its room.
ID_IN_CIRCLE = 0.7
# Least and largest font size of an id, per longest side of the floor.
ID_SIZES = (0.012, 0.026)
# An id stands on the centroid if the circle around that has this share of the radius of the largest circle.
WIDE_ENOUGH = 0.75
# Width and height of a digit of DejaVu Sans Bold, per font size.
DIGIT_SIZE = (0.7, 0.73)
# Radius of a graph's node, per radius of the id in it.
NODE_RIM = 1.2
# The legend gives the ids of the rooms of a label if they are no more than these.
FEW_ROOMS = 3
LEGEND_FONT_SIZE = 8
# Smaller predicted parts of a room are its walls, m².
MIN_PREDICTED_AREA = 0.05
PREDICTION_LEVEL = 0.5
ROOM_LEVEL, WALL_LEVEL, GRAPH_LEVEL, DOOR_LEVEL, TEXT_LEVEL = range(1, 6)
# Above the rooms and the ink of a plan, below the walls.
FURNITURE_LEVEL = 1.7


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
        left, bottom, right, top = find_extent(floor, grid)
        ax.set(xlim=(left, right), ylim=(bottom, top))
    return ax


def draw_floor(
    floor: Floor,
    grid: GridMap,
    *,
    walls: bool = False,
    graph: bool = False,
    schemas: Schemas = SCHEMAS,
    paper: NDArray[np.uint8] | None = None,
) -> Figure:
    """Picture of a floor on its map, cropped to the building: rooms with their ids, doors, and a scale bar.

    The building has a long side of 1600 pixels. If any room has a label, rooms have the colours of their labels, and
    the picture is larger by a legend below or right of the building. Options as in plot_floor.
    """
    left, bottom, right, top = find_extent(floor, grid)
    inches = LONG_SIDE_PX / DPI / max(right - left, top - bottom)
    size = ((right - left) * inches, (top - bottom) * inches)
    figure = new_figure(*size, color=BACKGROUND)
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set_axis_off()
    if paper is not None:
        plot_ink(paper, grid, ax=ax)
    plot_floor(floor, ax=ax, walls=walls, graph=graph, schemas=schemas)
    ax.set(xlim=(left, right), ylim=(bottom, top))
    plot_scale_bar(ax=ax)
    legend_height = add_legend(figure, _list_samples(floor, schemas, graph=graph)) if _has_labels(floor) else 0.0
    pixels = (round(size[0] * DPI), round(size[1] * DPI))
    add_background(paint_grid(grid, (left, bottom, right, top), pixels), figure, bottom=round(legend_height * DPI))
    return figure


def _has_labels(floor: Floor) -> bool:
    return any(room.label is not None for room in floor.rooms)


def render_floor(floor: Floor) -> bytes:
    """The floor as a PNG, without a map below it."""
    left, bottom, right, top = find_extent(floor, None)
    empty = GridMap(np.full((1, 1), UNKNOWN, np.int8), max(right - left, top - bottom), (left, bottom, 0.0))
    return encode_png(draw_floor(floor, empty))


def plot_rooms(floor: Floor, *, ax: Axes | None = None, labels: bool = False, schemas: Schemas = SCHEMAS) -> Axes:
    """Draw the rooms with their ids, and the predicted extent of partial rooms.

    Neighbours have different colours; partial rooms are grey and hatched.

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
        edge = {"edgecolor": HATCH_COLOR, "hatch": "//"} if room.partial else {"edgecolor": EDGE_COLOR}
        face = (style.color, style.opacity)
        patch = patch_from_polygon(room.polygon, facecolor=face, **edge, linewidth=0.6, zorder=ROOM_LEVEL)
        ax.add_artist(patch)
    _plot_predictions(floor, ax)
    plot_ids(floor, styles, ax)
    _extend_view(floor, ax)
    return ax


def plot_doors(floor: Floor, *, ax: Axes | None = None) -> Axes:
    """Draw the doors as strokes from jamb to jamb, openings dashed, entrances in another colour with a diamond.

    Possible doors are thin dashed lines.

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
    from matplotlib.lines import Line2D

    ax = new_ax(ax)
    for door in floor.possible_doors:
        ax.add_line(_draw_possible_door(*door.line.xy))
    for door in floor.doors:
        color = ENTRANCE_COLOR if door.is_entrance else DOOR_COLOR
        stroke = Line2D(*door.line.xy, color=color, linewidth=3, solid_capstyle="butt", zorder=DOOR_LEVEL)
        if door.kind == "opening":
            stroke.set_linestyle((0, (0.8, 0.5)))
        ax.add_line(stroke)
        if door.is_entrance:
            # The diamond is for readers who cannot distinguish the two colours.
            middle = door.line.interpolate(0.5, normalized=True)
            ax.plot(*middle.xy, marker="D", markersize=7, color=color, markeredgecolor="white", zorder=DOOR_LEVEL)
    return ax


def _draw_possible_door(x: Sequence[float], y: Sequence[float]) -> Line2D:
    """The line of a possible door, or its sample in a legend."""
    from matplotlib.lines import Line2D

    return Line2D(x, y, color=DOOR_COLOR, linewidth=1.2, linestyle=POSSIBLE_DASHES, zorder=DOOR_LEVEL)


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


def plot_graph(floor: Floor, *, ax: Axes | None = None, labels: bool = False, schemas: Schemas = SCHEMAS) -> Axes:
    """Draw the topological graph: a node where the id of its room stands, edges through the middles of the doors.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    ax
        Where to draw; a new figure if None.
    labels
        Draw squares for corridors and circles for rooms, in the colours of their labels.
    schemas
        By building type, the labels whose colours are known.

    Returns
    -------
    Axes
        The ax with the drawing; nothing is shown.

    References
    ----------
    M. Luperto, PhD thesis, Fig. 5.2.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_graph(floor, labels=True)
    """
    ax = new_ax(ax)
    styles = style_rooms(floor, schemas) if labels else {}
    positions = _position_ids(floor, styles)
    for first, second, door in floor.graph().edges(data=True):
        path = (positions[first][:2], (door["x"], door["y"]), positions[second][:2])
        ax.plot(*zip(*path, strict=True), color=DARK_INK, linewidth=0.9, zorder=GRAPH_LEVEL)
    for room_id, (x, y, size) in positions.items():
        style = styles.get(room_id, RoomStyle("#ffffff"))
        radius = NODE_RIM * _radius_of_id(floor, style) * size
        # A square has the area of a circle.
        half_side = sqrt(pi) / 2 * radius
        ax.add_artist(make_node((x, y), style, radius, half_side, edgecolor=style.ink, linewidth=0.9))
    return ax


def make_node(
    center: tuple[float, float], style: RoomStyle, radius: float, half_side: float, *, edgecolor: str, linewidth: float
) -> Patch:
    """The node of a room in a graph: a square for a corridor, a circle for any other room."""
    from matplotlib.patches import Circle

    look: dict[str, Any] = {"facecolor": style.fill, "edgecolor": edgecolor, "linewidth": linewidth}
    look["zorder"] = GRAPH_LEVEL
    return make_square(center, half_side, look) if style.is_corridor else Circle(center, radius, **look)


def plot_legend(floor: Floor, *, ax: Axes | None = None, graph: bool = False, schemas: Schemas = SCHEMAS) -> Axes:
    """Draw the labels that rooms have, in the upper left of an ax: colour, number of rooms, and their ids if few.

    Below them stand the other marks of labels: uncertain ones, partial rooms, and with graph the shapes of nodes.
    """
    ax = new_ax(ax)
    _plot_samples(_list_samples(floor, schemas, graph=graph), ax)
    return ax


def plot_scale_bar(*, ax: Axes) -> Axes:
    """Draw a scale bar of 1, 2 or 5 times a power of ten metres in the lower left corner of what the ax shows."""
    from matplotlib.lines import Line2D

    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    length = _round_length((right - left) / 4)
    margin = MARGIN * max(right - left, top - bottom)
    x, y = left + margin, bottom + margin
    line: dict[str, Any] = {
        "color": DARK_INK,
        "linewidth": 1.5,
        "marker": "|",
        "markeredgewidth": 1.5,
        "zorder": TEXT_LEVEL,
    }
    ax.add_line(Line2D([x, x + length], [y, y], **line))
    text: dict[str, Any] = {"color": DARK_INK, "fontsize": 9, "va": "center_baseline", "zorder": TEXT_LEVEL}
    ax.text(x + length + margin / 2, y, f"{length:g} m", **text)
    return ax


def _list_samples(floor: Floor, schemas: Schemas, *, graph: bool) -> list[tuple[Artist, str]]:
    """Handles and texts of a legend: one for each label of the floor, then one for each other mark that occurs."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    samples: list[tuple[Artist, str]] = []
    for label, color, ids in list_labels(floor, schemas):
        name = "no label" if label is None else shorten(" ".join(label.split()))
        listed = f" ({' '.join(map(str, ids))})" if len(ids) <= FEW_ROOMS else ""
        handle = Patch(facecolor=RoomStyle(color).fill, edgecolor=EDGE_COLOR, linewidth=0.6)
        samples.append((handle, f"{len(ids)} × {name}{listed}"))
    if any(style.is_uncertain for style in style_rooms(floor, schemas).values()):
        mark = Line2D([], [], linestyle="", marker="$?$", color=DARK_INK)
        samples.append((mark, f"probability below {CERTAIN_FROM:g}"))
    if any(room.predicted for room in floor.rooms):
        outline: dict[str, Any] = {"edgecolor": HATCH_COLOR, "linestyle": (0, (2, 1.5)), "linewidth": 0.6}
        samples.append((Patch(facecolor="none", hatch=2 * HATCH, **outline), "predicted"))
    if any(room.partial for room in floor.rooms):
        samples.append((Patch(facecolor="white", edgecolor=HATCH_COLOR, hatch="////", linewidth=0.6), "seen in part"))
    if floor.possible_doors:
        samples.append((_draw_possible_door([], []), "possible door, shut"))
    for marker, name in (("s", "corridor"), ("o", "room")) if graph else ():
        node = Line2D([], [], linestyle="", marker=marker, markersize=7, color=DARK_INK, markerfacecolor="white")
        samples.append((node, name))
    return samples


def add_legend(figure: Figure, samples: Sequence[tuple[Artist, str]]) -> float:
    """Enlarge the figure of a building by a strip with the legend: below a wide building, right of a tall one.

    Returns how far the building has moved up, inches.
    """
    (building,) = figure.axes
    width, height = figure.get_size_inches()
    margin = MARGIN * LONG_SIDE_PX / DPI
    strip = figure.add_axes((0, 0, 1, 1))
    column_width, column_height = _plot_samples(samples, strip)
    if width >= height:
        columns = max(1, int((width - 2 * margin) / column_width))
        _, legend_height = _plot_samples(samples, strip, columns=columns)
        below, right, corner = legend_height + margin, 0.0, (margin, legend_height + margin)
    else:
        columns = ceil(column_height / (height - 2 * margin))
        legend_width, _ = _plot_samples(samples, strip, columns=columns)
        below, right, corner = 0.0, legend_width + margin, (width, height - margin)
    total_width, total_height = width + right, height + below
    figure.set_size_inches(total_width, total_height)
    building.set_position((0, below / total_height, width / total_width, height / total_height))
    strip.set_position((corner[0] / total_width, 0, 1 - corner[0] / total_width, corner[1] / total_height))
    return below


def _plot_samples(samples: Sequence[tuple[Artist, str]], ax: Axes, *, columns: int = 1) -> tuple[float, float]:
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


def _extend_view(floor: Floor, ax: Axes) -> None:
    """Let an ax show all rooms, unless its limits are set.

    Axes.add_patch would do so too, but takes longer than drawing the patches.
    """
    if floor.rooms:
        ax.update_datalim(np.reshape(shapely.total_bounds([room.polygon for room in floor.rooms]), (2, 2)))
        ax.autoscale_view()


def style_by_neighbours(rooms: Sequence[Room]) -> dict[int, RoomStyle]:
    """Styles of rooms by their ids, without labels: neighbours differ in colour, partial rooms are grey."""
    colors = zip(rooms, color_neighbours(rooms), strict=True)
    return {room.id: RoomStyle(PARTIAL_COLOR if room.partial else color) for room, color in colors}


def plot_ids(floor: Floor, styles: Mapping[int, RoomStyle], ax: Axes) -> None:
    """Draw the id of each room inside it, with a question mark if its label is uncertain."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.patches import PathPatch
    from matplotlib.textpath import TextPath
    from matplotlib.transforms import Affine2D

    bold = FontProperties(family="DejaVu Sans", weight="bold")
    for room_id, (x, y, size) in _position_ids(floor, styles).items():
        style = styles[room_id]
        # An outline in metres, not a text in points: it stays in its room at any zoom.
        digits = TextPath((0, 0), f"{room_id}?" if style.is_uncertain else f"{room_id}", size=size, prop=bold)
        box = digits.get_extents()
        centred = Affine2D().translate(x - (box.x0 + box.x1) / 2, y - (box.y0 + box.y1) / 2).transform_path(digits)
        ax.add_artist(PathPatch(centred, facecolor=style.ink, linewidth=0, zorder=TEXT_LEVEL))


def _position_ids(floor: Floor, styles: Mapping[int, RoomStyle]) -> dict[int, tuple[float, float, float]]:
    """For each room x, y (m) of its id, and the font size (m) with which the id fits there."""
    left, bottom, right, top = MultiPolygon([room.polygon for room in floor.rooms]).bounds
    smallest, largest = (share * max(right - left, top - bottom) for share in ID_SIZES)
    positions = {}
    for room in floor.rooms:
        point, radius = _find_wide_point(room.polygon)
        fitting = ID_IN_CIRCLE * radius / _radius_of_id(floor, styles.get(room.id))
        positions[room.id] = point.x, point.y, min(max(fitting, smallest), largest)
    return positions


def _find_wide_point(polygon: Polygon) -> tuple[Point, float]:
    """A point of the polygon far from its boundary, the centroid if that is far enough; and its distance, m."""
    largest = shapely.maximum_inscribed_circle(polygon)
    centroid = polygon.centroid
    clearance = polygon.boundary.distance(centroid)
    if polygon.contains(centroid) and clearance >= WIDE_ENOUGH * largest.length:
        return centroid, clearance
    return Point(largest.coords[0]), largest.length


def _radius_of_id(floor: Floor, style: RoomStyle | None = None) -> float:
    """Radius of a circle around the longest id of the floor in a style, per font size."""
    digits = max(len(str(room.id)) for room in floor.rooms) + (style is not None and style.is_uncertain)
    width, height = DIGIT_SIZE
    return hypot(digits * width, height) / 2


def _round_length(longest: float) -> float:
    """The largest 1, 2 or 5 times a power of ten up to a length."""
    power: float = 10.0 ** (log10(longest) // 1)
    return power * max(step for step in (1, 2, 5) if step * power <= longest)


def find_extent(floor: Floor, grid: GridMap | None) -> Floats:
    """Left, bottom, right and top (m) of the picture: rooms and free cells, a margin, and a strip below.

    A prediction is a guess, so it may end at the frame, but does not widen it.
    """
    rooms = [shapely.get_coordinates(room.polygon) for room in floor.rooms]
    xy = np.concatenate([*([] if grid is None else [_find_extent_of_free(grid)]), *rooms])
    low, high = xy.min(axis=0), xy.max(axis=0)
    longest = (high - low).max()
    half = np.maximum(high - low, MIN_ASPECT * longest) / 2 + MARGIN * longest
    middle = (low + high) / 2
    return np.concatenate([middle - half - (0, STRIP * longest), middle + half])


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


def _plot_predictions(floor: Floor, ax: Axes) -> None:
    """Draw the predicted extent of partial rooms: a dashed outline, and a hatch where the room was not observed."""
    from shapely.plotting import patch_from_polygon

    for room in floor.rooms:
        if room.predicted is None:
            continue
        for part in get_parts(difference(room.predicted, room.polygon, grid_size=SNAP_DISTANCE)):
            if part.area >= MIN_PREDICTED_AREA:
                hatch = {"facecolor": "none", "edgecolor": HATCH_COLOR, "hatch": HATCH, "linewidth": 0}
                ax.add_artist(patch_from_polygon(part, **hatch, zorder=PREDICTION_LEVEL))
        outline = {"facecolor": "none", "edgecolor": OUTLINE_COLOR, "linestyle": DASHES, "linewidth": 0.9}
        ax.add_artist(patch_from_polygon(room.predicted, **outline, zorder=PREDICTION_LEVEL))
