"""Outlines of rooms, drawn alike whether walls have a thickness or are lines, and the length unit of a floor.

Rooms of a robot's map lie a wall apart, with notches of its cells; rooms of annotated buildings touch. Here all meet in
the middle of the wall, without niches, and every length is a share of the floor's own unit, so that a map of another
scale gives the same.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta.floor import Floor

Geometries = NDArray[np.object_]

# GEOS leaves a floating-point flag behind now and then when it buffers, of which numpy would warn; results are sound.
QUIET_BUFFERS = np.errstate(invalid="ignore")
# Shares of the unit, which is 6.5 m in the median school or office.
THICKEST_WALL = 0.1
NICHE = 0.08
NOTCH = 0.05
# An outline that loses more of the room than this is not the room any more.
LEAST_SHARE = 0.6


def measure_unit(floor: Floor) -> float:
    """The length that all others are compared with, m: the side of a square as large as the median room.

    Of all lengths of a floor it is the one that no method of finding rooms changes much: doors are measured from few
    cells, and annotated buildings do not have their width.
    """
    return float(np.sqrt(np.median(shapely.area([room.polygon for room in floor.rooms]))))


@QUIET_BUFFERS
def draw_outlines(floor: Floor, unit: float) -> Geometries:
    """Polygons without holes of all rooms, shape (n,), that meet in the middle of the walls between them."""
    rooms = np.array([room.polygon for room in floor.rooms], dtype=object)
    half_wall = _measure_wall(floor, unit) / 2
    niche = NICHE / 2 * unit
    # Closing fills niches, opening removes what sticks out of a door.
    closed = _offset(_offset(rooms, niche), -2 * niche)
    outlines = _without_holes(_largest_parts(_offset(closed, niche + half_wall), rooms))
    lost = shapely.area(outlines) < LEAST_SHARE * shapely.area(rooms)
    outlines[lost] = _without_holes(_largest_parts(_offset(rooms[lost], half_wall), rooms[lost]))
    smooth = _simplify(outlines, NOTCH * unit)
    kept = shapely.is_valid(smooth) & (shapely.area(smooth) >= LEAST_SHARE * shapely.area(outlines))
    return np.where(kept, smooth, outlines)


def _measure_wall(floor: Floor, unit: float) -> float:
    """Median distance of rooms that a door joins, m; 0 without doors. An opening has no wall to measure."""
    polygons = {room.id: room.polygon for room in floor.rooms}
    pairs = [door.room_ids for door in floor.doors if door.kind == "door" and not door.is_entrance]
    if not pairs:
        return 0.0
    firsts, seconds = zip(*pairs, strict=True)
    gaps = shapely.distance([polygons[one] for one in firsts], [polygons[one] for one in seconds])
    return min(float(np.median(gaps)), THICKEST_WALL * unit)


def _offset(polygons: Geometries, distance: float) -> Geometries:
    return np.asarray(shapely.buffer(polygons, distance, join_style="mitre"), dtype=object)


def _largest_parts(polygons: Geometries, otherwise: Geometries) -> Geometries:
    """The largest polygon of each; the other one where nothing is left."""
    parts, places = shapely.get_parts(polygons, return_index=True)
    by_area = np.argsort(shapely.area(parts), kind="stable")
    largest = otherwise.copy()
    for part in by_area:
        if not shapely.is_empty(parts[part]):
            largest[places[part]] = parts[part]
    return largest


def _without_holes(polygons: Geometries) -> Geometries:
    return np.asarray(shapely.polygons(shapely.get_exterior_ring(polygons)), dtype=object).reshape(len(polygons))


def _simplify(polygons: Geometries, tolerance: float) -> Geometries:
    """Outlines without corners nearer than the tolerance to the rest.

    Simplifying keeps the first corner of a ring, so that each ring starts at the corner farthest from its middle, which
    does not depend on how the building lies on its map.
    """
    return np.asarray(shapely.simplify(_start_at_far_corners(polygons), tolerance), dtype=object)


def _start_at_far_corners(polygons: Geometries) -> Geometries:
    middles = shapely.get_coordinates(shapely.centroid(polygons))
    rings = []
    for polygon, middle in zip(polygons, middles, strict=True):
        corners = shapely.get_coordinates(polygon)[:-1]
        away = np.hypot(*(corners - middle).T)
        start = int(np.argmax(away > away.max() * (1 - 1e-9)))
        rings.append(shapely.linearrings(np.roll(corners, -start, axis=0)))
    return np.asarray(shapely.polygons(rings), dtype=object).reshape(len(polygons))
