"""Shapes of merged and split rooms."""

from __future__ import annotations

from collections.abc import Sequence

import networkx as nx
import numpy as np
import shapely
from shapely import LineString, Polygon
from shapely.ops import linemerge, split

from pianta.floor.polygons import find_largest_polygon, list_polygons

# The constants were chosen by hand.
# Rooms further apart than this are not one room: thicker than walls.
MAX_GAP = 1.0  # metres
# Shapes to be joined are grown by this more than half their distance, so that they overlap.
OVERLAP = 0.02  # metres
# A border may end this far before the wall.
MAX_EXTENSION = 0.6  # metres
# Smaller parts of a divided room are no rooms.
MIN_ROOM = 0.25  # m²
# Coordinates of a merged room are rounded to this.
SNAP_DISTANCE = 1e-6  # metres
# A border crosses the outline by this, so that it divides the room in spite of rounding.
CROSSING = 1e-4  # metres
# A piece of a border that is nearer to the line than this belongs to it.
TOUCH_DISTANCE = 1e-6  # metres


def measure_gap(shapes: Sequence[Polygon]) -> float:
    """The widest gap that has to be closed so that all shapes are one, metres."""
    distances = nx.Graph()
    distances.add_nodes_from(range(len(shapes)))
    for i, shape in enumerate(shapes):
        for j in range(i):
            distances.add_edge(i, j, weight=shape.distance(shapes[j]))
    tree = nx.minimum_spanning_edges(distances, data=True)
    return max((edge["weight"] for *_, edge in tree), default=0.0)


def join_shapes(shapes: Sequence[Polygon], others: Sequence[Polygon]) -> Polygon:
    """One shape of several, with the walls between them but without other rooms.

    The shapes are at most MAX_GAP apart. The result contains all of them, or the largest part if others divide it.
    """
    reach = measure_gap(shapes) / 2 + OVERLAP
    grown = shapely.union_all(shapely.buffer(np.array(shapes, dtype=object), reach, join_style="mitre", mitre_limit=2))
    closed = grown.buffer(-reach, join_style="mitre", mitre_limit=2)
    own = shapely.union_all(shapes)
    near = [other for other in others if other.intersects(closed)]
    joined = shapely.union(shapely.difference(closed, shapely.union_all(near)), own)
    largest = find_largest_polygon(joined)
    # Slits along the walls of the rooms are no holes of the new one
    filled = Polygon(largest.exterior, [hole for hole in largest.interiors if Polygon(hole).area >= MIN_ROOM])
    # Without the slivers and the corners that growing and shrinking leave
    clean = shapely.simplify(shapely.set_precision(filled, SNAP_DISTANCE), SNAP_DISTANCE)
    return clean if isinstance(clean, Polygon) and clean.is_valid else largest


def split_shape(shape: Polygon, line: LineString) -> tuple[list[Polygon], list[LineString]]:
    """The parts of a shape on both sides of a line, the largest first; and the pieces of the line between them.

    A line that ends just before the outline is extended. Parts that are too small to be rooms stay with the part that
    they border on. One part alone means that the line does not divide the shape.
    """
    inside = shapely.get_parts(shapely.intersection(shape, extend_line(line, MAX_EXTENSION)))
    pieces = [piece for piece in inside if isinstance(piece, LineString) and piece.distance(line) < TOUCH_DISTANCE]
    if not pieces:
        return [shape], []
    # The ends of the pieces are on the outline but for rounding
    border = linemerge([extend_line(piece, CROSSING) for piece in pieces])
    parts = sorted(list_polygons(split(shape, border)), key=lambda part: -part.area)
    rooms = [part for part in parts if part.area >= MIN_ROOM]
    for small in parts[len(rooms) :]:
        nearest = max(range(len(rooms)), key=lambda i: shapely.intersection(small, rooms[i]).length, default=None)
        if nearest is not None:
            rooms[nearest] = shapely.union(rooms[nearest], small)
    return rooms or [shape], [shapely.simplify(piece, 0) for piece in pieces]


def extend_line(line: LineString, distance: float) -> LineString:
    """The line, straight on beyond both its ends by a distance, metres."""
    points = shapely.get_coordinates(shapely.remove_repeated_points(line))
    first, last = points[0] - points[1], points[-1] - points[-2]
    start = points[0] + first / np.hypot(*first) * distance
    end = points[-1] + last / np.hypot(*last) * distance
    return LineString([start, *points, end])
