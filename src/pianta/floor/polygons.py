"""Only the polygons of a geometry: differences and unions also have lines and points where shapes just touch.

GEOS cannot intersect or subtract a collection of polygons and lines.
"""

from __future__ import annotations

from collections.abc import Sequence

import shapely
from shapely import Geometry, Polygon


def list_polygons(shape: Geometry | Sequence[Geometry]) -> list[Polygon]:
    """The polygons of a geometry, or of several, also those of multipolygons, without empty ones, lines and points."""
    # A collection, as GEOS returns it, may have multipolygons, whose parts are polygons
    parts = shapely.get_parts(shapely.get_parts(shape))
    return [part for part in parts if isinstance(part, Polygon) and not part.is_empty]


def find_largest_polygon(shape: Geometry | Sequence[Geometry]) -> Polygon:
    """The largest polygon of a geometry; an empty one if it has none."""
    return max(list_polygons(shape), key=lambda part: part.area, default=Polygon())
