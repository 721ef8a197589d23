"""Notches of a room's outline that furniture along the walls leaves; the floor under it belongs to the room.

Chapter 9 of the thesis asks for layouts that stand large occlusions.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import shapely
from shapely import Polygon, STRtree

from pianta._types import Floats
from pianta.layout._outlines import Polygons

# Sine of the angle by which a corner may miss 90°.
SKEW = 0.3
# Area of another room that a notch may hold, because its corners are askew; the other room keeps it; m².
TOUCH = 0.01
# What is less deep is the wall between two doors; metres.
LEAST = 0.38
# Outlines are drawn to this many metres, so that corners on one straight line vanish.
GRID = 1e-6


def fill_notches(outlines: Polygons, *, depth: float, width: float) -> Polygons:
    """Outlines, shape (R,), in metres, with the notches filled that are no deeper and no wider than given, in metres.

    A notch is a rectangle that is missing in a corner of the room, or on one of its sides: there the wall goes on
    behind the furniture. One that holds part of another room stays, so that outlines that do not overlap never will.
    What is less deep than 0.38 m stays too.
    """
    filled = outlines.copy()
    tree = STRtree(outlines)
    for room, outline in enumerate(outlines):
        others = [other for other in tree.query(outline.buffer(width)) if other != room]
        filled[room] = _fill_outline(outline, filled[others], depth=depth, width=width)
    return filled


def _fill_outline(outline: Polygon, others: Polygons, *, depth: float, width: float) -> Polygon:
    """Outline with its notches filled one after the other, the smallest first; others are the rooms around it."""
    tried: set[bytes] = set()
    while True:
        corners = shapely.get_coordinates(shapely.orient_polygons(outline).exterior)[:-1]
        notches = [notch for notch in _find_notches(corners, depth=depth, width=width) if notch.wkb not in tried]
        if not notches:
            return outline
        notch = min(notches, key=lambda notch: (notch.area, notch.wkb))
        tried.add(notch.wkb)
        taken = shapely.union_all(shapely.intersection(notch, others))
        joined = shapely.union(outline, notch - taken, grid_size=GRID)
        # What holds another room or encloses a yard is no furniture.
        if taken.area <= TOUCH and isinstance(joined, Polygon) and len(joined.interiors) <= len(outline.interiors):
            outline = shapely.simplify(joined, 2 * GRID)


def _find_notches(corners: Floats, *, depth: float, width: float) -> Iterator[Polygon]:
    """Rectangles that are missing in the corners and on the sides of a counter-clockwise ring, shape (N, 2).

    In a corner of the room the ring goes a, b, c around a rectangle with its corner b in the room; on a side it goes
    a, b, c, d, with b and c in the room.
    """
    a, b, c, d = (np.roll(corners, -shift, axis=0) for shift in range(4))
    first, second, third = b - a, c - b, d - c
    lengths = [np.hypot(*side.T) for side in (first, second, third)]
    before = np.roll(first, 1, axis=0)
    turn = _turn(first, second)
    convex_before, convex_after = _turn(before, first) > 0, _turn(second, third) > 0
    square = (np.abs((first * second).sum(axis=1)) < SKEW * lengths[0] * lengths[1]) & (turn < 0)
    short, long = np.minimum(lengths[0], lengths[1]), np.maximum(lengths[0], lengths[1])
    in_corner = square & convex_before & convex_after & (short >= LEAST) & (short <= depth) & (long <= width)
    for i in np.flatnonzero(in_corner):
        yield Polygon([a[i], a[i] + c[i] - b[i], c[i], b[i]])
    square_after = np.roll(square, -1)
    convex_beyond = np.roll(convex_after, -1)
    # A narrow notch counts as wider, because one cell more on one of its sides would make it slant.
    level = np.abs(lengths[0] - lengths[2]) <= SKEW * np.maximum(lengths[1], depth / 2)
    deepest = np.maximum(lengths[0], lengths[2])
    shallow = (deepest <= depth) & (deepest >= LEAST)
    on_side = square & square_after & convex_before & convex_beyond & level & shallow & (lengths[1] <= width)
    for i in np.flatnonzero(on_side):
        yield Polygon([a[i], d[i], c[i], b[i]])


def _turn(one: Floats, other: Floats) -> Floats:
    """Cross products of vectors, shape (N, 2): positive where the ring turns left."""
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
