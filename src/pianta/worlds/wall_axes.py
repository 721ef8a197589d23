"""Axes and bodies of the walls around spaces that tile a floor."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise
from typing import TypeVar

import numpy as np
from shapely import LineString, Polygon, get_coordinates, get_parts, line_merge, transform, unary_union
from shapely.geometry.base import BaseGeometry

# Usual ones of offices and schools (chosen by hand); metres.
INNER_WALL = 0.15  # thickness of walls between rooms
OUTER_WALL = 0.3  # thickness of the walls around the floor

Seed = int | np.random.Generator
Range = tuple[float, float]
Shape = TypeVar("Shape", bound=BaseGeometry)


def find_wall_axes(spaces: Iterable[Polygon]) -> tuple[LineString, ...]:
    """Straight lines of maximal length along the sides of the spaces; those along x first."""
    sides = list(split_sides(unary_union([space.boundary for space in spaces])))
    along_x = [side for side in sides if side.bounds[1] == side.bounds[3]]
    along_y = [side for side in sides if side.bounds[0] == side.bounds[2]]
    lines = [line for group in (along_x, along_y) for line in get_parts(line_merge(unary_union(group)))]
    return tuple(line.simplify(0).normalize() for line in lines)


def find_wall_body(axes: Iterable[LineString], footprint: Polygon) -> BaseGeometry:
    """The body of all walls: inner thickness about the axes, outer thickness about the edge of the footprint."""
    inner = [axis.buffer(INNER_WALL / 2, cap_style="square") for axis in axes]
    outer = footprint.boundary.buffer(OUTER_WALL / 2, join_style="mitre")
    return unary_union([*inner, outer])


def find_shared_wall(first: Polygon, second: Polygon) -> LineString:
    """The longest straight axis of wall between two spaces; empty where they do not meet."""
    sides = split_sides(first.boundary.intersection(second.boundary))
    return max(sides, key=lambda side: side.length, default=LineString()).normalize()


def split_sides(lines: BaseGeometry) -> Iterator[LineString]:
    """The straight pieces of all lines; points are left out."""
    for part in get_parts(lines):
        yield from (LineString(ends) for ends in pairwise(get_coordinates(part)))


def round_to_mm(geometry: Shape) -> Shape:
    """The geometry with coordinates rounded to millimetres, in a canonical order."""
    rounded: Shape = transform(geometry.simplify(0), lambda xy: xy.round(3)).normalize()
    return rounded
