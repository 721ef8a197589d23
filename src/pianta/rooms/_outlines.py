"""Outlines of rooms that do not depend on the thickness of walls, and the length unit of a floor.

Rooms of a robot's map lie a wall apart and have notches from its cells; rooms of annotated buildings touch. Here all
meet in the middle of the wall, without niches. Every length is a share of the floor's own unit, so that the result does
not depend on the scale of the map.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta.floor import Floor

Geometries = NDArray[np.object_]

# GEOS sometimes leaves floating-point flags set when it buffers, and numpy would warn of them; the results are correct.
QUIET_BUFFERS = np.errstate(invalid="ignore", divide="ignore")
# Lengths as shares of the unit, which is 6.5 m in the median school or office; chosen by hand.
MAX_WALL_THICKNESS = 0.1
NICHE_WIDTH = 0.08
NOTCH_DEPTH = 0.05
# An outline with a smaller share of the area of the room is replaced by one with niches; chosen by hand.
MIN_AREA_SHARE = 0.6


def measure_unit(floor: Floor) -> float:
    """The unit of length of a floor, m: the side of a square with the area of the median room.

    Of all lengths of a floor it depends least on the method that detects rooms; widths of doors, for example, come from
    few cells, and annotated buildings do not have them.
    """
    return float(np.sqrt(np.median(shapely.area([room.polygon for room in floor.rooms]))))


@QUIET_BUFFERS
def draw_outlines(floor: Floor, unit: float) -> Geometries:
    """Polygons without holes of all rooms, shape (n,), that meet in the middle of the walls between them."""
    rooms = np.array([room.polygon for room in floor.rooms], dtype=object)
    half_wall = _measure_wall(floor, unit) / 2
    niche = NICHE_WIDTH / 2 * unit
    # Closing fills niches; opening removes spurs, such as cells within a door.
    closed = _offset(_offset(rooms, niche), -2 * niche)
    outlines = _without_holes(_largest_parts(_offset(closed, niche + half_wall), rooms))
    lost = shapely.area(outlines) < MIN_AREA_SHARE * shapely.area(rooms)
    outlines[lost] = _without_holes(_largest_parts(_offset(rooms[lost], half_wall), rooms[lost]))
    smooth = _simplify(outlines, NOTCH_DEPTH * unit)
    is_good = shapely.is_valid(smooth) & (shapely.area(smooth) >= MIN_AREA_SHARE * shapely.area(outlines))
    return np.where(is_good, smooth, outlines)


def _measure_wall(floor: Floor, unit: float) -> float:
    """Median distance of two rooms with a door between them, m; 0 without doors. Openings have no wall."""
    polygons = {room.id: room.polygon for room in floor.rooms}
    pairs = [door.room_ids for door in floor.doors if door.kind == "door" and door.joins_rooms]
    if not pairs:
        return 0.0
    firsts, seconds = zip(*pairs, strict=True)
    gaps = shapely.distance([polygons[one] for one in firsts], [polygons[one] for one in seconds])
    return min(float(np.median(gaps)), MAX_WALL_THICKNESS * unit)


def _offset(polygons: Geometries, distance: float) -> Geometries:
    return np.asarray(shapely.buffer(polygons, distance, join_style="mitre"), dtype=object)


def _largest_parts(polygons: Geometries, fallback: Geometries) -> Geometries:
    """The largest polygon of each geometry; the fallback for an empty one."""
    parts, rooms = shapely.get_parts(polygons, return_index=True)
    by_area = np.argsort(shapely.area(parts), kind="stable")
    largest = fallback.copy()
    for part in by_area:
        if not shapely.is_empty(parts[part]):
            largest[rooms[part]] = parts[part]
    return largest


def _without_holes(polygons: Geometries) -> Geometries:
    return np.asarray(shapely.polygons(shapely.get_exterior_ring(polygons)), dtype=object).reshape(len(polygons))


def _simplify(polygons: Geometries, tolerance: float) -> Geometries:
    """Outlines without the corners that are within the tolerance of the line through the others.

    Simplification keeps the first corner of a ring. So that it is always the same corner, however the building is
    oriented on its map, each ring starts at the corner farthest from its centroid.
    """
    return np.asarray(shapely.simplify(_start_at_far_corners(polygons), tolerance), dtype=object)


def _start_at_far_corners(polygons: Geometries) -> Geometries:
    """Polygons whose rings start at the corner farthest from the centroid; polygons: without holes, shape (n,)."""
    middles = shapely.get_coordinates(shapely.centroid(polygons))
    rings = []
    for polygon, middle in zip(polygons, middles, strict=True):
        corners = shapely.get_coordinates(polygon)[:-1]
        away = np.hypot(*(corners - middle).T)
        start = int(np.argmax(away > away.max() * (1 - 1e-9)))
        rings.append(shapely.linearrings(np.roll(corners, -start, axis=0)))
    return np.asarray(shapely.polygons(rings), dtype=object).reshape(len(polygons))
