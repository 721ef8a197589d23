"""Notches of a room's outline that furniture along the walls leaves; the floor under it belongs to the room.

Chapter 9 of the thesis asks for layouts that tolerate large occlusions.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely import Polygon, STRtree

from pianta._types import Floats
from pianta.layout._label_images import SNAP_DISTANCE, Polygons

# The constants were chosen by hand on the maps of the benches.
# Sine of the angle by which a corner may deviate from 90°.
MAX_SKEW = 0.3
# Area of another room that a notch may overlap, because its corners are not square; the other room keeps it; m².
MAX_OVERLAP = 0.01
# Least depth of a notch; less deep is the wall between two doors, deeper are cupboards of 0.4 m; metres.
MIN_DEPTH = 0.38


def fill_notches(outlines: Polygons, *, depth: float, width: float) -> Polygons:
    """Outlines, shape (R,), in metres, without notches up to a depth and a width, in metres.

    A notch is a rectangle that is missing in a corner of the room, or on one of its sides, where the wall continues
    behind the furniture. A notch that overlaps another room stays, so that outlines never overlap. Notches of less than
    0.38 m in depth stay too.
    """
    filled = outlines.copy()
    tree = STRtree(outlines)
    for room, outline in enumerate(outlines):
        others = [other for other in tree.query(outline.buffer(width)) if other != room]
        filled[room] = _fill_outline(outline, filled[others], depth=depth, width=width)
    return filled


def _fill_outline(outline: Polygon, others: Polygons, *, depth: float, width: float) -> Polygon:
    """Outline with its notches filled one after the other, the smallest first; others: the rooms around it."""
    tried: set[bytes] = set()
    while True:
        corners = shapely.get_coordinates(shapely.orient_polygons(outline).exterior)[:-1]
        notches = [notch for notch in _find_notches(corners, depth=depth, width=width) if notch.wkb not in tried]
        if not notches:
            return outline
        notch = min(notches, key=lambda notch: (notch.area, notch.wkb))
        tried.add(notch.wkb)
        overlap = shapely.union_all(shapely.intersection(notch, others))
        joined = shapely.union(outline, notch - overlap, grid_size=SNAP_DISTANCE)
        # A notch that overlaps another room, or whose filling encloses a courtyard, is not furniture.
        if (
            overlap.area <= MAX_OVERLAP
            and isinstance(joined, Polygon)
            and len(joined.interiors) <= len(outline.interiors)
        ):
            # Corners on a straight line vanish.
            outline = shapely.simplify(joined, 2 * SNAP_DISTANCE)


def _find_notches(corners: Floats, *, depth: float, width: float) -> Iterator[Polygon]:
    """Rectangles that are missing in the corners and on the sides of a counter-clockwise ring, shape (N, 2).

    In a corner of the room the ring runs a, b, c around a rectangle whose corner b is in the room; on a side it runs
    a, b, c, d, with b and c in the room.
    """
    a, b, c, d = (np.roll(corners, -shift, axis=0) for shift in range(4))
    first, second, third = b - a, c - b, d - c
    lengths = [np.hypot(*side.T) for side in (first, second, third)]
    before = np.roll(first, 1, axis=0)
    turn = _cross(first, second)
    convex_before, convex_after = _cross(before, first) > 0, _cross(second, third) > 0
    square = (np.abs((first * second).sum(axis=1)) < MAX_SKEW * lengths[0] * lengths[1]) & (turn < 0)
    short, long = np.minimum(lengths[0], lengths[1]), np.maximum(lengths[0], lengths[1])
    in_corner = square & convex_before & convex_after & (short >= MIN_DEPTH) & (short <= depth) & (long <= width)
    for i in np.flatnonzero(in_corner):
        yield Polygon([a[i], a[i] + c[i] - b[i], c[i], b[i]])
    square_after = np.roll(square, -1)
    convex_beyond = np.roll(convex_after, -1)
    # A narrow notch is treated as wider, because one cell more on one of its sides would make it look slanted.
    parallel = np.abs(lengths[0] - lengths[2]) <= MAX_SKEW * np.maximum(lengths[1], depth / 2)
    deepest = np.maximum(lengths[0], lengths[2])
    shallow = (deepest <= depth) & (deepest >= MIN_DEPTH)
    on_side = square & square_after & convex_before & convex_beyond & parallel & shallow & (lengths[1] <= width)
    for i in np.flatnonzero(on_side):
        yield Polygon([a[i], d[i], c[i], b[i]])


def _cross(one: Floats, other: Floats) -> Floats:
    """Cross products of vectors, shape (N, 2): positive where the ring turns left."""
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
