"""The outline of a building from a file: a GeoJSON polygon, or a floor."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from shapely import Polygon

from pianta._types import Floats
from pianta.errors import FloorError
from pianta.floor.polygons import list_polygons
from pianta.io._checked import read_checked
from pianta.io.floors import MAX_COORDINATE
from pianta.io.graphs import FLOOR_FILE

MAX_FILE_BYTES = 64 * 2**20
MAX_LENGTH = 1e5  # m; longer ones are degrees, millimetres or damaged
PARTS = ("coordinates", "features", "geometries")  # of GeoJSON, that are lists
LEAST_CORNERS = 3
LEAST_AREA = 4.0  # m²
WIDEST_WALL = 0.8  # m, between rooms
HALF_WALL = 0.15  # m, from rooms to the axes of outer walls
LEAST_COURT = 10.0  # m²; smaller holes are shafts


def read_outline(path: str | Path) -> Polygon:
    """The outline in a GeoJSON file, in metres; of several polygons, such as the rooms of a floor, that around all.

    path: also a folder with a floor.geojson.
    Raises FloorError, in one line, for a file without polygons, and with some that lie apart.
    """
    file = Path(path)
    file = file / FLOOR_FILE if file.is_dir() else file
    return read_checked(file, "outline", FloorError, _parse_outline, max_bytes=MAX_FILE_BYTES)


def _parse_outline(content: bytes) -> Polygon:
    try:
        tree = json.loads(content)
    except (ValueError, RecursionError):
        raise FloorError("it is no GeoJSON, give a file with a polygon") from None
    if not (isinstance(tree, dict) and "type" in tree):
        raise FloorError("it is no GeoJSON, give a file with a polygon")
    try:
        polygons = [Polygon(rings[0], rings[1:]) for rings in map(_read_rings, _list_coordinates(tree)) if rings]
    except (ValueError, TypeError, LookupError, OverflowError):
        raise FloorError("it has a polygon without rings of 3 or more corners, give them as [[x, y], …]") from None
    if not polygons:
        raise FloorError("it has no polygon, give one, in metres")
    corners = shapely.get_coordinates(polygons)
    if not (np.isfinite(corners).all() and (np.ptp(corners, axis=0) < MAX_LENGTH).all()):
        raise FloorError(f"its corners are more than {MAX_LENGTH:g} m apart, give metres")
    if np.abs(corners).max() > MAX_COORDINATE - MAX_LENGTH:
        raise FloorError(f"its corners are more than {MAX_COORDINATE - MAX_LENGTH:g} m from the origin, move it there")
    if not all(polygon.is_valid for polygon in polygons):
        raise FloorError("its sides cross each other, give the corners in order")
    outline = polygons[0] if len(polygons) == 1 else _surround(polygons)
    if not isinstance(outline, Polygon):
        raise FloorError(f"its polygons are in {len(outline.geoms)} parts that do not touch, give one polygon")
    if outline.area < LEAST_AREA:
        raise FloorError(f"it has {outline.area:.3g} m², and {LEAST_AREA:g} at least are needed; give metres")
    return outline


def _list_coordinates(tree: dict[str, Any]) -> list[Any]:
    """The coordinates of each polygon of a GeoJSON; what has none is left out, such as rooms without an outline."""
    coordinates: list[Any] = []
    unread: list[Any] = [tree]
    while unread:
        part = unread.pop()
        if not isinstance(part, dict):
            continue
        if part.get("type") == "Polygon":
            coordinates.append(part.get("coordinates"))
        lists = {name: part[name] for name in PARTS if isinstance(part.get(name), list)}
        if part.get("type") == "MultiPolygon":
            coordinates.extend(lists.get("coordinates", []))
        unread.extend([part.get("geometry"), *lists.get("features", []), *lists.get("geometries", [])])
    return coordinates


def _read_rings(rings: Any) -> list[Floats]:  # noqa: ANN401  # of a file
    """The corners of each ring, (n, 2), without heights.

    Raises ValueError, TypeError, LookupError or OverflowError for anything else.
    """
    corners = [[[*map(_read_number, corner[:2])] for corner in ring] for ring in rings]
    if any(len(ring) < LEAST_CORNERS for ring in corners):
        raise ValueError
    return [np.array(ring, float) for ring in corners]


def _read_number(value: Any) -> float:  # noqa: ANN401  # of a file
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError
    return float(value)


def _surround(polygons: list[Polygon]) -> shapely.Geometry:
    """The outline of all polygons with the walls between and around them."""
    wide = shapely.union_all(shapely.buffer(polygons, WIDEST_WALL / 2, join_style="mitre"))
    joined = wide.buffer(HALF_WALL - WIDEST_WALL / 2, join_style="mitre")
    parts = [
        Polygon(part.exterior, [hole for hole in part.interiors if Polygon(hole).area >= LEAST_COURT])
        for part in list_polygons(joined)
    ]
    return parts[0] if len(parts) == 1 else shapely.MultiPolygon(parts)
