"""Marks of rooms inside them: their ids, and the nodes of the topological graph, which stand where the ids do."""

from __future__ import annotations

from collections.abc import Mapping
from math import hypot, pi, sqrt
from typing import TYPE_CHECKING, Any

import shapely
from shapely import LineString, MultiPolygon, Point, Polygon

from pianta.floor import Floor
from pianta.labels import SCHEMAS
from pianta.plot.figure import GRAPH_LEVEL, TEXT_LEVEL, make_square, new_ax, shorten
from pianta.plot.styles import DARK_INK, RoomStyle, Schemas, style_rooms

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Patch

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
# A name below an id: its largest size and its distance per size of the id, and the share of its room's width there.
NAME_SIZE = 0.6
NAME_BELOW = 0.55
NAME_WIDTH = 0.92


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


def plot_names(floor: Floor, ax: Axes, *, schemas: Schemas = SCHEMAS) -> None:
    """Draw the name of each room that has one, below its id."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.patches import PathPatch
    from matplotlib.textpath import TextPath
    from matplotlib.transforms import Affine2D

    styles = style_rooms(floor, schemas)
    font = FontProperties(family="DejaVu Sans")
    positions = _position_ids(floor, styles) if floor.rooms else {}
    for room in floor:
        if not room.name or not room.name.strip():
            continue
        x, y, size = positions[room.id]
        # A dollar would begin a formula
        text = shorten(" ".join(room.name.split())).replace("$", r"\$")
        letters = TextPath((0, 0), text, size=1, prop=font)
        box = letters.get_extents()
        middle = Point(x, y - (NAME_BELOW + NAME_SIZE / 2) * size)
        scale = min(NAME_SIZE * size, NAME_WIDTH * _measure_width(room.polygon, middle) / max(box.width, 1e-9))
        placed = Affine2D().translate(-(box.x0 + box.x1) / 2, -box.y1).scale(scale)
        placed = placed.translate(x, y - NAME_BELOW * size - (NAME_SIZE * size - scale) / 4)
        ink = styles[room.id].ink
        ax.add_artist(PathPatch(placed.transform_path(letters), facecolor=ink, linewidth=0, zorder=TEXT_LEVEL))


def _measure_width(polygon: Polygon, point: Point) -> float:
    """The length of the longest level line with its middle at a point that is in the polygon; 0 if the point is not."""
    left, _, right, _ = polygon.bounds
    level = LineString([(left, point.y), (right, point.y)]).intersection(polygon)
    parts = (part for part in shapely.get_parts(level) if part.distance(point) == 0)
    reach = [min(point.x - part.bounds[0], part.bounds[2] - point.x) for part in parts]
    return 2 * max(reach, default=0.0)


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
