"""Pictures of grids and floors: each plot_ function draws one thing on a matplotlib ax, in metres of the map frame.

matplotlib is imported when something is drawn, and pyplot never: no window, no state shared between pictures.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from math import hypot, log10
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from PIL import Image
from shapely import MultiPolygon, Point, Polygon, STRtree

from pianta.floor import Floor, Room
from pianta.formats.files import written_atomically
from pianta.gridmap import GridMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Paul Tol's "light" scheme, made for areas with dark labels and for colour-blind readers.
ROOM_COLORS = ("#77aadd", "#ee8866", "#eedd88", "#ffaabb", "#99ddff", "#44bb99", "#bbcc33", "#ccaadd")
PARTIAL_COLOR, HATCH_COLOR, EDGE_COLOR, INK = "#cccccc", "#999999", "#555555", "#222222"
DOOR_COLOR, ENTRANCE_COLOR, WALL_COLOR = "#aa1133", "#117733", "#3355bb"
FREE_GREY, UNKNOWN_GREY, OCCUPIED_GREY = 255, 228, 110
BACKGROUND = f"#{UNKNOWN_GREY:02x}{UNKNOWN_GREY:02x}{UNKNOWN_GREY:02x}"

# Rooms no further apart, m, are neighbours and differ in colour: the thickest wall between two rooms.
NEIGHBOUR_DISTANCE = 0.5
LONG_SIDE_PX, DPI = 1600, 200
# Larger maps are averaged down for the picture, and sampled to find their extent.
MAX_IMAGE_SIDE_PX, SAMPLED_SIDE = 4096, 1000
# The short side of the picture is at least this share of the long one.
MIN_ASPECT = 0.25
# Shares of the longest side of what is seen: the margin around it, and the strip for the scale bar below.
MARGIN, STRIP = 0.02, 0.05
# Share of the free cells that is seen, on x and on y; the rest may be spray through windows.
SEEN_SHARE = 0.99
# An id lies in a circle of this share of the radius that its room offers, and its font size is within these shares of
# the floor's longest side. It stands on the centroid where that offers this share of the largest circle in the room.
ID_IN_CIRCLE, ID_SIZES, WIDE_ENOUGH = 0.7, (0.012, 0.026), 0.75
# Width and height of a digit of DejaVu Sans Bold, per font size; radius of a graph's node, per circle around its id.
DIGIT, NODE_RIM = (0.7, 0.73), 1.2
ROOM_LEVEL, WALL_LEVEL, GRAPH_LEVEL, DOOR_LEVEL, TEXT_LEVEL = range(1, 6)


def draw_floor(floor: Floor, grid: GridMap, *, walls: bool = False, graph: bool = False) -> Figure:
    """Picture of a floor on its map, cropped to the building: rooms with their ids, doors, and a scale bar.

    walls: the representative lines too. graph: the topological graph too.
    """
    from matplotlib.figure import Figure

    left, bottom, right, top = _frame_building(floor, grid)
    inches = LONG_SIDE_PX / DPI / max(right - left, top - bottom)
    size = ((right - left) * inches, (top - bottom) * inches)
    figure = Figure(figsize=size, dpi=DPI, facecolor=BACKGROUND)
    ax = figure.add_axes((0, 0, 1, 1))
    ax.set_axis_off()
    plot_grid(grid, ax=ax)
    plot_rooms(floor, ax=ax)
    if walls:
        plot_walls(floor, ax=ax)
    if graph:
        plot_graph(floor, ax=ax)
    plot_doors(floor, ax=ax)
    ax.set(xlim=(left, right), ylim=(bottom, top))
    plot_scale_bar(ax=ax)
    return figure


def save_picture(floor: Floor, grid: GridMap, path: str | Path, *, walls: bool = False, graph: bool = False) -> None:
    """Write the picture of draw_floor as a PNG with a long side of 1600 pixels; the same floor gives the same bytes.

    Raises PiantaError when the file cannot be written.
    """
    figure = draw_floor(floor, grid, walls=walls, graph=graph)
    with written_atomically(path) as temporary:
        figure.savefig(temporary, format="png", dpi=DPI, metadata={"Software": None})


def plot_grid(grid: GridMap, *, ax: Axes) -> Axes:
    """Draw the map in soft greys where it lies in the map frame: free white, unknown light, occupied dark."""
    from matplotlib.transforms import Affine2D

    greys = np.full(grid.shape, UNKNOWN_GREY, np.uint8)
    greys[grid.free] = FREE_GREY
    greys[grid.occupied] = OCCUPIED_GREY
    factor = -(-max(grid.shape) // MAX_IMAGE_SIDE_PX)
    image = np.asarray(Image.fromarray(greys).reduce(factor).convert("RGB"))
    height, width = (side * factor * grid.resolution for side in image.shape[:2])
    top = grid.shape[0] * grid.resolution
    x0, y0, yaw = grid.origin
    placed = Affine2D().rotate(yaw).translate(x0, y0) + ax.transData
    ax.imshow(image, extent=(0, width, top - height, top), transform=placed, zorder=0)
    return ax


def plot_rooms(floor: Floor, *, ax: Axes) -> Axes:
    """Draw the rooms with their ids, neighbours in different colours, partial ones grey and hatched."""
    from shapely.plotting import patch_from_polygon

    for room, color in zip(floor.rooms, _color_rooms(floor.rooms), strict=True):
        style = {"facecolor": (color, 0.75), "edgecolor": EDGE_COLOR}
        if room.partial:
            style = {"facecolor": (PARTIAL_COLOR, 0.75), "edgecolor": HATCH_COLOR, "hatch": "//"}
        ax.add_patch(patch_from_polygon(room.polygon, **style, linewidth=0.6, zorder=ROOM_LEVEL))
    _plot_ids(floor, ax)
    return ax


def plot_doors(floor: Floor, *, ax: Axes) -> Axes:
    """Draw the doors as strokes from jamb to jamb, openings dashed, entrances in another colour with a diamond."""
    from matplotlib.lines import Line2D

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


def plot_walls(floor: Floor, *, ax: Axes) -> Axes:
    """Draw the representative lines."""
    for wall in floor.walls:
        ax.plot(*wall.xy, color=WALL_COLOR, linewidth=0.8, zorder=WALL_LEVEL)
    return ax


def plot_graph(floor: Floor, *, ax: Axes) -> Axes:
    """Draw the topological graph: a node where the id of its room stands, edges through the middles of the doors."""
    from matplotlib.patches import Circle

    places = _place_ids(floor)
    for first, second, door in floor.graph().edges(data=True):
        stops = (places[first][:2], (door["x"], door["y"]), places[second][:2])
        ax.plot(*zip(*stops, strict=True), color=INK, linewidth=0.9, zorder=GRAPH_LEVEL)
    radius = NODE_RIM * _radius_of_ids(floor)
    for x, y, size in places.values():
        ax.add_patch(Circle((x, y), radius * size, facecolor="white", edgecolor=INK, linewidth=0.9, zorder=GRAPH_LEVEL))
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


def _plot_ids(floor: Floor, ax: Axes) -> None:
    from matplotlib.font_manager import FontProperties
    from matplotlib.patches import PathPatch
    from matplotlib.textpath import TextPath
    from matplotlib.transforms import Affine2D

    bold = FontProperties(family="DejaVu Sans", weight="bold")
    for room_id, (x, y, size) in _place_ids(floor).items():
        # An outline in metres, not a text in points: it stays in its room at any zoom.
        digits = TextPath((0, 0), str(room_id), size=size, prop=bold)
        box = digits.get_extents()
        centred = Affine2D().translate(x - (box.x0 + box.x1) / 2, y - (box.y0 + box.y1) / 2).transform_path(digits)
        ax.add_patch(PathPatch(centred, facecolor=INK, linewidth=0, zorder=TEXT_LEVEL))


def _place_ids(floor: Floor) -> dict[int, tuple[float, float, float]]:
    """For each room x, y (m) of its id, and the font size (m) with which the id fits there."""
    left, bottom, right, top = MultiPolygon([room.polygon for room in floor.rooms]).bounds
    least, most = (share * max(right - left, top - bottom) for share in ID_SIZES)
    radius_of_ids = _radius_of_ids(floor)
    places = {}
    for room in floor.rooms:
        place, radius = _find_wide_place(room.polygon)
        fitting = ID_IN_CIRCLE * radius / radius_of_ids
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


def _radius_of_ids(floor: Floor) -> float:
    """Radius of a circle around any id of the floor, per font size."""
    digits = max((len(str(room.id)) for room in floor.rooms), default=1)
    width, height = DIGIT
    return hypot(digits * width, height) / 2


def _color_rooms(rooms: Sequence[Room]) -> list[str]:
    """A colour for each room: the least used that no neighbour has; rooms with the most neighbours choose first."""
    polygons = np.array([room.polygon for room in rooms], dtype=object)
    first, second = STRtree(polygons).query(polygons, predicate="dwithin", distance=NEIGHBOUR_DISTANCE)
    neighbours = [second[first == index] for index in range(len(rooms))]
    colors = [""] * len(rooms)
    for index in sorted(range(len(rooms)), key=lambda index: -len(neighbours[index])):
        near = {colors[other] for other in neighbours[index]}
        used = Counter(colors)
        colors[index] = min(ROOM_COLORS, key=lambda color: (color in near, used[color]))
    return colors


def _round_length(longest: float) -> float:
    """The largest 1, 2 or 5 times a power of ten up to a length."""
    power: float = 10.0 ** (log10(longest) // 1)
    return power * max(step for step in (1, 2, 5) if step * power <= longest)


def _frame_building(floor: Floor, grid: GridMap) -> NDArray[np.float64]:
    """Left, bottom, right and top (m) of the picture: rooms and free cells, a margin, and a strip below."""
    rooms = [shapely.get_coordinates(room.polygon) for room in floor.rooms]
    seen = np.concatenate([_find_extent_of_free(grid), *rooms])
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
