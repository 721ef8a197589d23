"""The room features of the thesis: geometry and centrality (sections 5.2 and 4.2.3).

The polygon P of the thesis is the outline of a room. Holes of a room are not part of its area, and their edges and
corners belong to its boundary.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from math import pi, sqrt
from types import MappingProxyType

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from pianta.floor import Floor
from pianta.graphs.centrality import Centrality, drop_isolated, measure_betweenness, measure_closeness

# Relative tolerance of equal areas of rectangles.
AREA_TOLERANCE = 1e-6


def area(polygon: Polygon) -> float:
    """½ Σ (x_i y_i+1 - x_i+1 y_i), m² (section 5.2)."""
    return float(polygon.area)


def perimeter(polygon: Polygon) -> float:
    """Σ dist(v_i, v_i+1), m (section 5.2)."""
    return float(polygon.length)


def area_over_perimeter(polygon: Polygon) -> float:
    """A / P, m (section 5.2)."""
    return area(polygon) / perimeter(polygon)


def mean_distance(polygon: Polygon) -> float:
    """1/N Σ dist(v_i, c), m, from the corners to the centroid c of the area (section 5.2).

    It depends on additional corners within a wall: annotated outlines have one at each door.
    """
    return float(_distances_to_centroid(polygon).mean())


def form_factor(polygon: Polygon) -> float:
    """4πA / √P, as section 5.2 prints it; it grows with the power 1.5 of lengths.

    The usual form factor is 4πA / P², which the thesis calls normalised circularity.
    """
    return 4 * pi * area(polygon) / sqrt(perimeter(polygon))


def circularity(polygon: Polygon) -> float:
    """P² / A, without unit, 4π for a circle and more for all others (section 5.2)."""
    return perimeter(polygon) ** 2 / area(polygon)


def normalised_circularity(polygon: Polygon) -> float:
    """4πA / P², without unit, 1 for a circle and less for all others (section 5.2)."""
    return 4 * pi * area(polygon) / perimeter(polygon) ** 2


def normalised_mean_distance(polygon: Polygon) -> float:
    """1/N Σ dist(v_i, c) / max dist(v_i, c), without unit, at most 1 (section 5.2)."""
    distances = _distances_to_centroid(polygon)
    return float(distances.mean() / distances.max())


def axes_ratio(polygon: Polygon) -> float:
    """Long over short side of the bounding box, without unit, at least 1 (section 4.2.3).

    The box is the minimum-area rectangle, so that the ratio does not depend on the orientation of the building; among
    several, which a triangle has, the one nearest to a square.
    """
    hull = shapely.get_coordinates(polygon.convex_hull)
    along = np.diff(hull, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # The minimum-area rectangle lies along an edge of the convex hull (Freeman and Shapira, 1975).
    across = along[:, ::-1] * (-1, 1)
    lengths, widths = np.ptp(hull @ along.T, axis=0), np.ptp(hull @ across.T, axis=0)
    areas, ratios = lengths * widths, np.maximum(lengths, widths) / np.minimum(lengths, widths)
    return float(ratios[areas <= areas.min() * (1 + AREA_TOLERANCE)].min())


GEOMETRIC: MappingProxyType[str, Callable[[Polygon], float]] = MappingProxyType(
    {
        "area": area,
        "perimeter": perimeter,
        "area_over_perimeter": area_over_perimeter,
        "mean_distance": mean_distance,
        "form_factor": form_factor,
        "circularity": circularity,
        "normalised_circularity": normalised_circularity,
        "normalised_mean_distance": normalised_mean_distance,
    }
)
ROOM_FEATURES: tuple[str, ...] = (*GEOMETRIC, "doors", "closeness", "betweenness")
GENERAL_FEATURES: tuple[str, ...] = ("area", "doors", "axes_ratio")


def compute_room_features(floor: Floor) -> NDArray[np.float64]:
    """V_n of every room, shape (rooms, 11): ROOM_FEATURES in the order of `floor.rooms`, in metres (section 5.2).

    doors counts every Door of a room: openings too, and entrances, which annotated buildings do not have.
    closeness and betweenness are those of Table 5.1, in the graph without isolated rooms, which have 0.
    """
    doors = _count_doors(floor)
    closeness, betweenness = _measure_roles(floor)
    rows = [
        [
            *(measure(room.polygon) for measure in GEOMETRIC.values()),
            doors[room.id],
            closeness.get(room.id, 0.0),
            betweenness.get(room.id, 0.0),
        ]
        for room in floor.rooms
    ]
    return np.array(rows, np.float64).reshape(-1, len(ROOM_FEATURES))


def compute_general_features(floor: Floor) -> NDArray[np.float64]:
    """Area (m²), doors and axes ratio of every room, shape (rooms, 3), in the order of `floor.rooms` (section 4.2.3).

    doors is that of compute_room_features.
    """
    doors = _count_doors(floor)
    rows = [[area(room.polygon), doors[room.id], axes_ratio(room.polygon)] for room in floor.rooms]
    return np.array(rows, np.float64).reshape(-1, len(GENERAL_FEATURES))


def _count_doors(floor: Floor) -> Counter[int]:
    return Counter(room_id for door in floor.doors for room_id in door.room_ids)


def _measure_roles(floor: Floor) -> tuple[Centrality, Centrality]:
    graph = drop_isolated(floor.graph())
    return measure_closeness(graph), measure_betweenness(graph)


def _distances_to_centroid(polygon: Polygon) -> NDArray[np.float64]:
    """From each corner, the last of a ring not repeated, to the centroid of the area."""
    rings = (polygon.exterior, *polygon.interiors)
    corners = np.concatenate([shapely.get_coordinates(ring)[:-1] for ring in rings])
    centre = shapely.get_coordinates(polygon.centroid)
    return np.asarray(np.linalg.norm(corners - centre, axis=1))
