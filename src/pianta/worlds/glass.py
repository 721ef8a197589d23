"""Glass walls of floors: facades and glazed fronts of rooms, which a lidar sees only in part."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely
from shapely import LineString, Point, Polygon, get_coordinates

from pianta._types import Floats
from pianta.floor import Floor

# The measures and shares were chosen by hand.
# Shorter sides of rooms have no glass; metres.
SHORTEST_GLASS = 1.5
# Thickest wall that may stand between two rooms; metres.
THICKEST_WALL = 0.45
# Body of a wall between rooms that touch; metres.
THINNEST_WALL = 0.1
# Share of the glass walls that are glass only in part.
PART_SHARE = 0.4
# How deep a facade is where no room is behind it; metres.
FACADE = 0.2
# Rooms with glass towards corridors and other rooms; those with any other label have it only towards the outside.
GLAZED_ROOMS = frozenset(
    {"CONFERENCE ROOM", "OFFICE", "SHARED OFFICE", "EXECUTIVE OFFICE", "LOBBY", "OPENSPACE", "CUBICULE", "RECEPTION"}
)


def draw_glass_walls(floor: Floor, *, rng: np.random.Generator, share: float = 0.15) -> list[Polygon]:
    """Bodies of the pieces of wall that are glass, from face to face, metres in the floor's frame.

    share: of the long sides of rooms that can be glass; some are glass in part.
    """
    polygons = [room.polygon for room in floor.rooms]
    tree = shapely.STRtree(polygons)
    glass: list[Polygon] = []
    for number, room in enumerate(floor.rooms):
        for start, end in pairwise(get_coordinates(room.polygon.exterior)):
            if np.hypot(*(end - start)) < SHORTEST_GLASS or rng.random() >= share:
                continue
            depth = _measure_wall(start, end, number, tree)
            if depth is not None and room.label not in GLAZED_ROOMS:
                continue
            pane = _draw_pane(start, end, rng)
            # A negative distance is on the right of a side, which is outside of its room.
            glass.append(pane.buffer(-(FACADE if depth is None else max(depth, THINNEST_WALL)), single_sided=True))
    return glass


def _measure_wall(start: Floats, end: Floats, number: int, tree: shapely.STRtree) -> float | None:
    """Thickness of the wall behind the middle of a side of a room, metres; None towards the outside."""
    along = (end - start) / np.hypot(*(end - start))
    middle, outward = (start + end) / 2, np.array([along[1], -along[0]])
    view = LineString([middle + 0.01 * outward, middle + THICKEST_WALL * outward])
    behind = [index for index in tree.query(view, predicate="intersects") if index != number]
    if not behind:
        return None
    return float(min(tree.geometries[index].distance(Point(middle)) for index in behind))


def _draw_pane(start: Floats, end: Floats, rng: np.random.Generator) -> LineString:
    """The side, or a part of it that is not shorter than SHORTEST_GLASS."""
    length = float(np.hypot(*(end - start)))
    if rng.random() >= PART_SHARE:
        return LineString([start, end])
    size = rng.uniform(SHORTEST_GLASS, length)
    first = rng.uniform(0, length - size)
    return LineString([start + first / length * (end - start), start + (first + size) / length * (end - start)])
