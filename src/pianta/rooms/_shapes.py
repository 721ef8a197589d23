"""Features of the shape of a room and of the positions of its doors, invariant to scale, rotation and translation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.floor import Floor
from pianta.rooms._outlines import Geometries

# The value of a feature that is undefined: below all defined values.
MISSING = -9.0
# Relative tolerance of lengths: each side of a square counts as its long side.
REL_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Rectangles:
    """The minimum-area rectangles around n outlines.

    corners: shape (n, 4, 2), m. sides: lengths of the sides from each corner to the next, shape (n, 4), m.
    along: directions of these sides, shape (n, 4, 2).
    """

    corners: Floats
    sides: Floats
    along: Floats

    @property
    def length(self) -> Floats:
        """Length of the long side, shape (n,), m."""
        return np.asarray(self.sides.max(axis=1))

    @property
    def width(self) -> Floats:
        """Length of the short side, shape (n,), m."""
        return np.asarray(self.sides.min(axis=1))

    def distance_to_ends(self, rooms: NDArray[np.int_], points: Floats) -> Floats:
        """Distance of each point to the nearer short side of the rectangle around its room, shape (m,), m.

        rooms: index of the room of each point, shape (m,). points: shape (m, 2), m.
        """
        offsets = np.einsum("mij,mij->mi", points[:, None] - self.corners[rooms], self.along[rooms])
        sides = self.sides[rooms]
        to_ends = np.minimum(np.abs(offsets), np.abs(sides - offsets))
        is_long = sides >= self.length[rooms][:, None] * (1 - REL_TOLERANCE)
        return np.asarray(np.where(is_long, to_ends, np.inf).min(axis=1))


@dataclass(frozen=True, eq=False)
class DoorEnds:
    """Pairs of a door and a room beside it: two for each door, one for each entrance.

    rooms: indices of the rooms, shape (m,). points: midpoints of the doors, m, shape (m, 2). openings: whether it is an
    opening instead of a door, shape (m,).
    """

    rooms: NDArray[np.int_]
    points: Floats
    openings: NDArray[np.bool_]


def fit_rectangles(outlines: Geometries) -> Rectangles:
    """The minimum-area rectangle around each outline; among equal ones, the one nearest to a square.

    It lies along an edge of the convex hull (Freeman and Shapira, 1975).
    """
    hulls = _pad_rings(shapely.convex_hull(outlines))
    edges = np.diff(hulls, axis=1)
    lengths = np.linalg.norm(edges, axis=2, keepdims=True)
    # An edge that is only a rounding error has no direction.
    is_edge = lengths > REL_TOLERANCE * lengths.max(axis=1, keepdims=True)
    along = np.divide(edges, lengths, out=np.zeros_like(edges), where=is_edge)
    across = along[..., ::-1] * (-1, 1)
    x, y = (np.einsum("nec,npc->nep", axes, hulls) for axes in (along, across))
    sizes = np.stack([np.ptp(x, axis=2), np.ptp(y, axis=2)])
    area = np.where(is_edge[..., 0], sizes.prod(axis=0), np.inf)
    is_least = area <= area.min(axis=1, keepdims=True) * (1 + REL_TOLERANCE)
    elongation = np.divide(sizes.max(axis=0), sizes.min(axis=0), out=np.full_like(area, np.inf), where=is_least)
    rows = np.arange(len(hulls))
    best = elongation.argmin(axis=1)
    x, y, along, across = (values[rows, best] for values in (x, y, along, across))
    left, right, low, high = x.min(axis=1), x.max(axis=1), y.min(axis=1), y.max(axis=1)
    around = [(left, low), (right, low), (right, high), (left, high)]
    corners = np.stack([a[:, None] * along + b[:, None] * across for a, b in around], axis=1)
    sides = np.column_stack([right - left, high - low] * 2)
    return Rectangles(corners, sides, np.stack([along, across, -along, -across], axis=1))


def list_door_ends(floor: Floor) -> DoorEnds:
    """The ends of all doors of a floor."""
    row_of = {room.id: row for row, room in enumerate(floor.rooms)}
    ends = [(row_of[room], index) for index, door in enumerate(floor.doors) for room in door.room_ids]
    rooms, doors = np.array(ends, int).reshape(-1, 2).T
    middles = shapely.line_interpolate_point([door.line for door in floor.doors], 0.5, normalized=True)
    openings = np.array([door.kind == "opening" for door in floor.doors], bool)
    return DoorEnds(rooms, shapely.get_coordinates(middles).reshape(-1, 2)[doors], openings[doors])


def measure_shapes(outlines: Geometries, rectangles: Rectangles) -> dict[str, Floats]:
    """Features of n outlines by name, each of shape (n,).

    They are compactness, spread and elongation, and the shares of the rectangle and of the convex hull that are filled.
    """
    area, perimeter = shapely.area(outlines), shapely.length(outlines)
    return {
        "compactness": 4 * np.pi * area / perimeter**2,
        "spread": _measure_spread(outlines),
        "elongation": rectangles.length / rectangles.width,
        "rectangularity": area / (rectangles.length * rectangles.width),
        "convexity": area / shapely.area(shapely.convex_hull(outlines)),
    }


def measure_doors(ends: DoorEnds, rectangles: Rectangles) -> dict[str, Floats]:
    """Features of the doors of n rooms by name, each of shape (n,).

    They are the number of doors and openings, the number of openings, the largest distance between two, and the
    smallest distance to an end of the room; distances are relative to the length of the room.
    """
    n = len(rectangles.sides)
    to_ends = np.full(n, np.inf)
    along = rectangles.distance_to_ends(ends.rooms, ends.points) / rectangles.length[ends.rooms]
    np.minimum.at(to_ends, ends.rooms, along)
    span = np.zeros(n)
    # Room by room: the distances of all pairs of doors of a campus would take gigabytes
    for room in np.flatnonzero(np.bincount(ends.rooms, minlength=n) > 1):
        points = ends.points[ends.rooms == room]
        span[room] = np.linalg.norm(points[:, None] - points, axis=2).max()
    return {
        "doors": np.bincount(ends.rooms, minlength=n).astype(float),
        "openings": np.bincount(ends.rooms[ends.openings], minlength=n).astype(float),
        "door_span": span / rectangles.length,
        "door_to_end": np.where(np.isinf(to_ends), MISSING, to_ends),
    }


def _pad_rings(polygons: Geometries) -> Floats:
    """Corners of rings, shape (n, longest, 2); shorter ones are padded with their last corner."""
    corners, rooms = shapely.get_coordinates(polygons, return_index=True)
    counts = np.bincount(rooms)
    indices = np.minimum(np.arange(counts.max()), counts[:, None] - 1)
    return np.asarray(corners[(np.cumsum(counts) - counts)[:, None] + indices])


def _measure_spread(outlines: Geometries) -> Floats:
    """Mean distance of the points of each outline from its centroid, divided by the largest; shape (n,), 0 … 1.

    The mean is an integral along the outline, so additional corners within a wall do not change it.
    """
    corners, rooms = shapely.get_coordinates(outlines, return_index=True)
    offsets = corners - shapely.get_coordinates(shapely.centroid(outlines))[rooms]
    inside = rooms[1:] == rooms[:-1]
    start, stop, room = offsets[:-1][inside], offsets[1:][inside], rooms[1:][inside]
    length = np.hypot(*(stop - start).T)
    start, stop, room, length = (values[length > 0] for values in (start, stop, room, length))
    along = (stop - start) / length[:, None]
    height = np.maximum(np.abs(start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]), 1e-12 * length)
    total = _integrate_distance((stop * along).sum(axis=1), height) - _integrate_distance(
        (start * along).sum(axis=1), height
    )
    farthest = np.zeros(len(outlines))
    np.maximum.at(farthest, rooms, np.hypot(*offsets.T))
    n = len(outlines)
    return np.asarray(np.bincount(room, total, n) / np.bincount(room, length, n) / farthest)


def _integrate_distance(x: Floats, height: Floats) -> Floats:
    """Integral along a line of the distance to a point; from the foot of the point to x, height is its distance."""
    return np.asarray((x * np.hypot(x, height) + height**2 * np.arcsinh(x / height)) / 2)
