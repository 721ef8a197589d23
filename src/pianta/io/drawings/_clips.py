"""Clip paths of vector plans: what lies outside of them is not drawn."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from typing import TypeAlias

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from pianta._types import Floats

# None where nothing is clipped.
Clip: TypeAlias = BaseGeometry | None


def area_of_rings(rings: Sequence[Floats]) -> BaseGeometry:
    """The area within an odd number of rings, each shape (N, 2)."""
    polygons = (shapely.make_valid(shapely.Polygon(ring)) for ring in rings if len(ring) > 2)
    return reduce(shapely.symmetric_difference, polygons, shapely.Polygon())


def join_clips(outer: Clip, areas: Iterable[BaseGeometry]) -> Clip:
    """What lies in a clip and in all areas; outer: None for no clip."""
    clip = outer
    for area in areas:
        clip = area if clip is None else shapely.intersection(clip, area)
    if clip is not None:
        shapely.prepare(clip)
    return clip


def clip_chain(chain: Floats, clip: Clip) -> list[Floats]:
    """The parts of lines along points, shape (N, 2), within a clip; the same points if all are."""
    if clip is None or len(chain) < 2:
        return [chain]
    line = shapely.LineString(chain)
    if shapely.covers(clip, line):
        return [chain]
    parts = shapely.get_parts(shapely.line_merge(shapely.intersection(line, clip)))
    return [np.asarray(shapely.get_coordinates(part)) for part in parts if part.geom_type == "LineString"]


def clip_rings(rings: Sequence[Floats], clip: Clip) -> list[Floats]:
    """Rings around what lies within an odd number of rings and within a clip; the same rings if the clip holds all."""
    if clip is None or all(shapely.covers(clip, shapely.LineString(ring)) for ring in rings if len(ring) > 1):
        return list(rings)
    parts = shapely.get_parts(shapely.intersection(area_of_rings(rings), clip))
    polygons = [part for part in parts if part.geom_type == "Polygon"]
    return [np.asarray(shapely.get_coordinates(ring)) for each in polygons for ring in (each.exterior, *each.interiors)]
