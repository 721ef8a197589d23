"""Pictures of grids and floors: each plot_ function draws one thing on a matplotlib ax, in metres of the map frame.

matplotlib is imported when something is drawn, and pyplot never: no window, no state shared between pictures.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import ceil, hypot, log10, pi, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Point, Polygon, difference, get_parts

from pianta.floor import Floor, Room
from pianta.gridmap import UNKNOWN, GridMap
from pianta.labels import SCHEMAS
from pianta.layout._label_images import SNAP_DISTANCE
from pianta.plot._figure import encode_png, new_ax, save_png
from pianta.plot.grid import UNKNOWN_GREY, lay_pixels, paint_grid, plot_grid, plot_ink
from pianta.plot.styles import CERTAIN_FROM, DARK_INK, RoomStyle, Schemas, color_neighbours, list_labels, style_rooms

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

PARTIAL_COLOR, EDGE_COLOR, INK = "#cccccc", "#555555", DARK_INK
DOOR_COLOR, ENTRANCE_COLOR, WALL_COLOR = "#aa1133", "#117733", "#3355bb"
BACKGROUND = f"#{UNKNOWN_GREY:02x}{UNKNOWN_GREY:02x}{UNKNOWN_GREY:02x}"

LONG_SIDE_PX, DPI = 1600, 200
# Larger maps are sampled to find their extent.
SAMPLED_SIDE = 400
# The short side of the picture is at least this share of the long one.
MIN_ASPECT = 0.25
# Shares of the longest side of what is seen: the margin around it, and the strip for the scale bar below.
MARGIN, STRIP = 0.02, 0.05
# Share of the free cells that is seen, on x and on y; the rest may be spray through windows.
SEEN_SHARE = 0.99
# An id lies in a circle of this share of the radius that its room offers, and its font size is within these shares of
# the floor's longest side. It stands on the centroid where that offers this share of the largest circle in the room.
ID_IN_CIRCLE, ID_SIZES, WIDE_ENOUGH = 0.7, (0.012, 0.026), 0.75
# A label in the legend is cut to this many characters; the ids of its rooms are given when there are few of them.
LONGEST_LABEL, FEW_ROOMS = 30, 3
LEGEND_FONT_SIZE = 8
# Width and height of a digit of DejaVu Sans Bold, per font size; radius of a graph's node, per circle around its id.
DIGIT, NODE_RIM = (0.7, 0.73), 1.2
ROOM_LEVEL, WALL_LEVEL, GRAPH_LEVEL, DOOR_LEVEL, TEXT_LEVEL = range(1, 6)
HATCH_COLOR, OUTLINE_COLOR = "#999999", "#777777"
HATCH, DASHES, WIDTH = "\\\\", (0, (4, 2.5)), 0.9
# Below the rooms and above the map.
LEVEL = 0.5
# Smaller bits beyond what was seen are the walls, m².
LEAST_AREA = 0.05


def plot_floor(
    floor: Floor,
    grid: GridMap | None = None,
    *,
    ax: Axes | None = None,
    walls: bool = False,
    graph: bool = False,
    schemas: Schemas = SCHEMAS,
    paper: NDArray[np.uint8] | None = None,
) -> Axes:
    """Draw a floor: its rooms with their ids, in the colours of their labels if they have any, and its doors.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    grid
        The map below it; None for none.
    ax
        Where to draw; a new figure if None.
    walls, graph
        Whether to draw the wall lines and the topological graph too.
    schemas
        By building type, the labels whose colours are known.
    paper
        The sheet of a plan, RGB of shape (H, W, 3) on the cells of the grid, whose ink is drawn over the rooms.

    Returns
    -------
    Axes
        The ax that was drawn on; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_floor(floor, grid)
    """
    ax = new_ax(ax)
    if grid is not None:
        plot_grid(grid, ax=ax)
    _plot_layers(floor, grid, ax, walls=walls, graph=graph, schemas=schemas, paper=paper)
    if floor.rooms or grid is not None:
        left, bottom, right, top = _frame_building(floor, grid)
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

    When any room has a label, rooms have the colours of their labels, and a legend is below or right of the building.
    walls: the representative lines too. graph: the topological graph too.
    schemas: by building type, the labels whose colours are known. paper: the sheet of a plan, the colours of the
    cells of the grid, whose ink is drawn over the rooms.
    """
    from matplotlib.figure import Figure

    left, bottom, right, top = _frame_building(floor, grid)
    inches = LONG_SIDE_PX / DPI / max(right - left, top - bottom)
    size = ((right - left) * inches, (top - bottom) * inches)
    figure = Figure(figsize=size, dpi=DPI, facecolor=BACKGROUND)
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set_axis_off()
    ax.set(xlim=(left, right), ylim=(bottom, top))
    _plot_layers(floor, grid, ax, walls=walls, graph=graph, schemas=schemas, paper=paper)
    ax.set(xlim=(left, right), ylim=(bottom, top))
    plot_scale_bar(ax=ax)
    lift = _add_legend(floor, figure, graph=graph, schemas=schemas) if _has_labels(floor) else 0.0
    pixels = (round(size[0] * DPI), round(size[1] * DPI))
    lay_pixels(paint_grid(grid, (left, bottom, right, top), pixels), figure, bottom=round(lift * DPI))
    return figure


def _plot_layers(
    floor: Floor,
    grid: GridMap | None,
    ax: Axes,
    *,
    walls: bool,
    graph: bool,
    schemas: Schemas,
    paper: NDArray[np.uint8] | None,
) -> None:
    """What lies on the map of a floor."""
    labels = _has_labels(floor)
    plot_rooms(floor, ax=ax, labels=labels, schemas=schemas)
    if paper is not None and grid is not None:
        plot_ink(paper, grid, ax=ax)
    if walls:
        plot_walls(floor, ax=ax)
    if graph:
        plot_graph(floor, ax=ax, labels=labels, schemas=schemas)
    plot_doors(floor, ax=ax)


def _has_labels(floor: Floor) -> bool:
    return any(room.label is not None for room in floor.rooms)


def render_floor(floor: Floor) -> bytes:
    """The floor as a PNG, without a map below it."""
    left, bottom, right, top = _frame_building(floor, None)
    nothing = GridMap(np.full((1, 1), UNKNOWN, np.int8), max(right - left, top - bottom), (left, bottom, 0.0))
    return encode_png(draw_floor(floor, nothing))


def save_picture(
    floor: Floor,
    grid: GridMap,
    path: str | Path,
    *,
    walls: bool = False,
    graph: bool = False,
    schemas: Schemas = SCHEMAS,
    paper: NDArray[np.uint8] | None = None,
) -> None:
    """Write the picture of draw_floor as a PNG, the same bytes for the same floor.

    The building has a long side of 1600 pixels; a legend makes the picture larger.
    Raises PiantaError when the file cannot be written.
    """
    figure = draw_floor(floor, grid, walls=walls, graph=graph, schemas=schemas, paper=paper)
    save_png(figure, path)


def plot_rooms(floor: Floor, *, ax: Axes | None = None, labels: bool = False, schemas: Schemas = SCHEMAS) -> Axes:
    """Draw the rooms with their ids, and what is predicted of partial ones.

    Neighbours have different colours; partial rooms are grey and hatched.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    ax
        Where to draw; a new figure if None.
    labels
        Use the colours of the labels instead; partial rooms are light and hatched, and a `?` follows the id where the
        label has a probability below 0.6.
    schemas
        By building type, the labels whose colours are known.

    Returns
    -------
    Axes
        The ax that was drawn on; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_rooms(floor, labels=True)
    """
    from shapely.plotting import patch_from_polygon

    ax = new_ax(ax)
    styles = style_rooms(floor, schemas) if labels else _style_by_neighbours(floor.rooms)
    for room in floor.rooms:
        style = styles[room.id]
        edge = {"edgecolor": HATCH_COLOR, "hatch": "//"} if room.partial else {"edgecolor": EDGE_COLOR}
        face = (style.color, style.opacity)
        patch = patch_from_polygon(room.polygon, facecolor=face, **edge, linewidth=0.6, zorder=ROOM_LEVEL)
        ax.add_artist(patch)
    plot_predictions(floor, ax=ax)
    _plot_ids(floor, styles, ax)
    _extend_view(floor, ax)
    return ax


def plot_doors(floor: Floor, *, ax: Axes | None = None) -> Axes:
    """Draw the doors as strokes from jamb to jamb, openings dashed, entrances in another colour with a diamond.

    Parameters
    ----------
    floor
        The floor, metres of the map frame.
    ax
        Where to draw; a new figure if None.

    Returns
    -------
    Axes
        The ax that was drawn on; nothing is shown.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> ax = pianta.plot.plot_rooms(floor)
    >>> ax = pianta.plot.plot_doors(floor, ax=ax)
    """
    from matplotlib.lines import Line2D

    ax = new_ax(ax)
    for door in floor.doors:
        color = ENTRANCE_COLOR if door.is_entrance else DOOR_COLOR
        stroke = Line2D(*door.line.xy, color=color, linewidth=3, solid_capstyle="butt", zorder=DOOR_LEVEL)
        if door.kind == "opening":
            stroke.set_linestyle((0, (0.8, 0.5)))
        ax.add_line(stroke)
        if door.is_entrance:
            # Whoever cannot tell the two colours apart sees the shape.
            middle = door.line.interpolate(0.5, normalized=True)
            ax.plot(*middle.xy, marker="D", markersize=7, color=color, markeredgecolor="white", zorder=DOOR_LEVEL)
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
        The ax that was drawn on; nothing is shown.

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
        The ax that was drawn on; nothing is shown.

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
    places = _place_ids(floor, styles)
    for first, second, door in floor.graph().edges(data=True):
        stops = (places[first][:2], (door["x"], door["y"]), places[second][:2])
        ax.plot(*zip(*stops, strict=True), color=INK, linewidth=0.9, zorder=GRAPH_LEVEL)
    for room_id, place in places.items():
        style = styles.get(room_id, RoomStyle("#ffffff"))
        radius = NODE_RIM * _radius_of_id(floor, style) * place[2]
        ax.add_artist(_make_node(place[:2], radius, style))
    return ax


def plot_legend(floor: Floor, *, ax: Axes | None = None, graph: bool = False, schemas: Schemas = SCHEMAS) -> Axes:
    """Draw the labels that rooms have, in the upper left of an ax: colour, number of rooms, and their ids when few.

    Below them stands what else is drawn of labels: uncertain ones, partial rooms, and with graph the shapes of nodes.
    """
    ax = new_ax(ax)
    _draw_legend(floor, ax, columns=1, graph=graph, schemas=schemas)
    return ax


def plot_scale_bar(*, ax: Axes) -> Axes:
    """Draw a scale bar of 1, 2 or 5 times a power of ten metres in the lower left corner of what the ax shows."""
    from matplotlib.lines import Line2D

    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    length = _round_length((right - left) / 4)
    margin = MARGIN * max(right - left, top - bottom)
    x, y = left + margin, bottom + margin
    bar = Line2D([x, x + length], [y, y], color=INK, linewidth=1.5, marker="|", markeredgewidth=1.5, zorder=TEXT_LEVEL)
    ax.add_line(bar)
    ax.text(x + length + margin / 2, y, f"{length:g} m", color=INK, fontsize=9, va="center_baseline", zorder=TEXT_LEVEL)
    return ax


def _sample_labels(floor: Floor, schemas: Schemas) -> list[tuple[Artist, str]]:
    """For each label of the floor a handle of the legend and its text."""
    from matplotlib.patches import Patch

    samples: list[tuple[Artist, str]] = []
    for entry in list_labels(floor, schemas):
        name = "no label" if entry.label is None else " ".join(entry.label.split())
        name = name if len(name) <= LONGEST_LABEL else f"{name[: LONGEST_LABEL - 1]}…"
        ids = entry.room_ids
        which = f" ({' '.join(map(str, ids))})" if len(ids) <= FEW_ROOMS else ""
        handle = Patch(facecolor=entry.style.fill, edgecolor=EDGE_COLOR, linewidth=0.6)
        samples.append((handle, f"{len(ids)} × {name}{which}"))
    return samples


def _sample_marks(floor: Floor, schemas: Schemas, *, graph: bool) -> list[tuple[Artist, str]]:
    """Handles of the legend and texts for what else than colours the picture says of labels, where it occurs."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    samples: list[tuple[Artist, str]] = []
    if any(style.is_uncertain for style in style_rooms(floor, schemas).values()):
        samples.append((Line2D([], [], linestyle="", marker="$?$", color=INK), f"probability below {CERTAIN_FROM:g}"))
    if any(room.predicted for room in floor.rooms):
        samples.append(sample_prediction())
    if any(room.partial for room in floor.rooms):
        samples.append((Patch(facecolor="white", edgecolor=HATCH_COLOR, hatch="////", linewidth=0.6), "seen in part"))
    for marker, name in (("s", "corridor"), ("o", "room")) if graph else ():
        node = Line2D([], [], linestyle="", marker=marker, markersize=7, color=INK, markerfacecolor="white")
        samples.append((node, name))
    return samples


def _add_legend(floor: Floor, figure: Figure, *, graph: bool, schemas: Schemas) -> float:
    """Make a figure of a building larger by a strip with the legend: below what is wide, right of what is tall.

    Returns how far the building has moved up, inches.
    """
    (building,) = figure.axes
    width, height = figure.get_size_inches()
    margin = MARGIN * LONG_SIDE_PX / DPI
    strip = figure.add_axes((0, 0, 1, 1))
    column_width, column_height = _draw_legend(floor, strip, columns=1, graph=graph, schemas=schemas)
    if width >= height:
        columns = max(1, int((width - 2 * margin) / column_width))
        _, tall = _draw_legend(floor, strip, columns=columns, graph=graph, schemas=schemas)
        below, right, corner = tall + margin, 0.0, (margin, tall + margin)
    else:
        columns = ceil(column_height / (height - 2 * margin))
        wide, _ = _draw_legend(floor, strip, columns=columns, graph=graph, schemas=schemas)
        below, right, corner = 0.0, wide + margin, (width, height - margin)
    whole = width + right, height + below
    figure.set_size_inches(whole)
    building.set_position((0, below / whole[1], width / whole[0], height / whole[1]))
    strip.set_position((corner[0] / whole[0], 0, 1 - corner[0] / whole[0], corner[1] / whole[1]))
    return below


def _draw_legend(floor: Floor, ax: Axes, *, columns: int, graph: bool, schemas: Schemas) -> tuple[float, float]:
    """Draw the legend on an ax and give its width and height, inches."""
    from matplotlib.font_manager import FontProperties

    samples = _sample_labels(floor, schemas) + _sample_marks(floor, schemas, graph=graph)
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
    for text in legend.get_texts():
        text.set(color=INK, parse_math=False)
    extent = legend.get_window_extent()
    return extent.width / DPI, extent.height / DPI


def _extend_view(floor: Floor, ax: Axes) -> None:
    """Let an ax show all rooms, unless its limits are set.

    Axes.add_patch does so too, and takes longer for it than to draw the patches.
    """
    if floor.rooms:
        ax.update_datalim(np.reshape(shapely.total_bounds([room.polygon for room in floor.rooms]), (2, 2)))
        ax.autoscale_view()


def _style_by_neighbours(rooms: Sequence[Room]) -> dict[int, RoomStyle]:
    """Styles of rooms by their ids without labels: neighbours differ in colour, partial rooms are grey."""
    colors = zip(rooms, color_neighbours(rooms), strict=True)
    return {room.id: RoomStyle(PARTIAL_COLOR if room.partial else color) for room, color in colors}


def _make_node(place: tuple[float, float], radius: float, style: RoomStyle) -> Patch:
    """A circle, or a square of the same area."""
    from matplotlib.patches import Circle, Rectangle

    look: dict[str, Any] = {"facecolor": style.fill, "edgecolor": style.ink, "linewidth": 0.9, "zorder": GRAPH_LEVEL}
    if not style.is_corridor:
        return Circle(place, radius, **look)
    half = sqrt(pi) / 2 * radius
    return Rectangle((place[0] - half, place[1] - half), 2 * half, 2 * half, **look)


def _plot_ids(floor: Floor, styles: Mapping[int, RoomStyle], ax: Axes) -> None:
    from matplotlib.font_manager import FontProperties
    from matplotlib.patches import PathPatch
    from matplotlib.textpath import TextPath
    from matplotlib.transforms import Affine2D

    bold = FontProperties(family="DejaVu Sans", weight="bold")
    for room_id, (x, y, size) in _place_ids(floor, styles).items():
        style = styles[room_id]
        # An outline in metres, not a text in points: it stays in its room at any zoom.
        digits = TextPath((0, 0), f"{room_id}?" if style.is_uncertain else f"{room_id}", size=size, prop=bold)
        box = digits.get_extents()
        centred = Affine2D().translate(x - (box.x0 + box.x1) / 2, y - (box.y0 + box.y1) / 2).transform_path(digits)
        ax.add_artist(PathPatch(centred, facecolor=style.ink, linewidth=0, zorder=TEXT_LEVEL))


def _place_ids(floor: Floor, styles: Mapping[int, RoomStyle]) -> dict[int, tuple[float, float, float]]:
    """For each room x, y (m) of its id, and the font size (m) with which the id fits there."""
    left, bottom, right, top = MultiPolygon([room.polygon for room in floor.rooms]).bounds
    least, most = (share * max(right - left, top - bottom) for share in ID_SIZES)
    places = {}
    for room in floor.rooms:
        place, radius = _find_wide_place(room.polygon)
        fitting = ID_IN_CIRCLE * radius / _radius_of_id(floor, styles.get(room.id))
        places[room.id] = place.x, place.y, min(max(fitting, least), most)
    return places


def _find_wide_place(polygon: Polygon) -> tuple[Point, float]:
    """A place in the polygon with much room around it, and how much, m: the centroid where that is good enough."""
    largest = shapely.maximum_inscribed_circle(polygon)
    centroid = polygon.centroid
    clearance = polygon.boundary.distance(centroid)
    if polygon.contains(centroid) and clearance >= WIDE_ENOUGH * largest.length:
        return centroid, clearance
    return Point(largest.coords[0]), largest.length


def _radius_of_id(floor: Floor, style: RoomStyle | None = None) -> float:
    """Radius of a circle around any id of the floor in a style, per font size."""
    digits = max(len(str(room.id)) for room in floor.rooms) + (style is not None and style.is_uncertain)
    width, height = DIGIT
    return hypot(digits * width, height) / 2


def _round_length(longest: float) -> float:
    """The largest 1, 2 or 5 times a power of ten up to a length."""
    power: float = 10.0 ** (log10(longest) // 1)
    return power * max(step for step in (1, 2, 5) if step * power <= longest)


def _frame_building(floor: Floor, grid: GridMap | None) -> NDArray[np.float64]:
    """Left, bottom, right and top (m) of the picture: rooms and free cells, a margin, and a strip below."""
    rooms = [shapely.get_coordinates(room.predicted or room.polygon) for room in floor.rooms]
    seen = np.concatenate([*([] if grid is None else [_find_extent_of_free(grid)]), *rooms])
    low, high = seen.min(axis=0), seen.max(axis=0)
    longest = (high - low).max()
    half = np.maximum(high - low, MIN_ASPECT * longest) / 2 + MARGIN * longest
    middle = (low + high) / 2
    return np.concatenate([middle - half - (0, STRIP * longest), middle + half])


def _find_extent_of_free(grid: GridMap) -> NDArray[np.float64]:
    """Least and largest x, y (m), shape (2, 2), of nearly all free cells; corners of the whole grid when none is."""
    step = -(-max(grid.shape) // SAMPLED_SIDE)
    rows, cols = np.nonzero(grid.free[::step, ::step])
    if not rows.size:
        height, width = grid.shape
        return np.column_stack(grid.pixel_to_map([0, 0, height, height], [0, width, 0, width]))
    xy = np.column_stack(grid.pixel_to_map(rows * step + 0.5, cols * step + 0.5))
    # Half a cell more, so that even a single cell has an extent.
    margin = np.array([[-0.5], [0.5]]) * grid.resolution
    return np.asarray(np.quantile(xy, (1 - SEEN_SHARE, SEEN_SHARE), axis=0) + margin)


def plot_predictions(floor: Floor, *, ax: Axes | None = None) -> Axes:
    """Draw what is predicted of partial rooms: what was not seen hatched, around the whole a dashed outline."""
    from shapely.plotting import patch_from_polygon

    ax = new_ax(ax)
    for room in floor.rooms:
        if room.predicted is None:
            continue
        for part in get_parts(difference(room.predicted, room.polygon, grid_size=SNAP_DISTANCE)):
            if part.area >= LEAST_AREA:
                look = {"facecolor": "none", "edgecolor": HATCH_COLOR, "hatch": HATCH, "linewidth": 0, "zorder": LEVEL}
                ax.add_artist(patch_from_polygon(part, **look))
        outline = {"facecolor": "none", "edgecolor": OUTLINE_COLOR, "linestyle": DASHES, "linewidth": WIDTH}
        ax.add_artist(patch_from_polygon(room.predicted, **outline, zorder=LEVEL))
    return ax


def sample_prediction() -> tuple[Patch, str]:
    """Handle of a legend for predictions, and its text."""
    from matplotlib.patches import Patch

    handle = Patch(facecolor="none", edgecolor=HATCH_COLOR, hatch=2 * HATCH, linestyle=(0, (2, 1.5)), linewidth=0.6)
    return handle, "predicted"
