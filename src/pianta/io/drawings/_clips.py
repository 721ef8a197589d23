"""Clip paths of vector plans: what lies outside of them is not drawn."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import reduce
from typing import TypeAlias

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from pianta._types import Floats
from pianta.floor.polygons import list_polygons

# None where nothing is clipped.
Clip: TypeAlias = BaseGeometry | None


# Most corners of a clip path: all crossings of its sides are computed, so larger ones are ignored.
MAX_CORNERS = 5000


def area_of_rings(rings: Sequence[Floats]) -> BaseGeometry:
    """The area within an odd number of rings, each shape (N, 2)."""
    polygons = (
        shapely.make_valid(shapely.Polygon(ring), method="structure", keep_collapsed=False)
        for ring in rings
        if len(ring) > 2
    )
    return reduce(
        lambda one, other: _polygons_of(shapely.symmetric_difference(one, other)), polygons, shapely.Polygon()
    )


def make_clip(outer: Clip, paths: Iterable[Sequence[Floats]]) -> Clip:
    """What lies in a clip and within an odd number of rings of each path; outer: None for no clip."""
    small = (rings for rings in paths if sum(map(len, rings)) <= MAX_CORNERS)
    return join_clips(outer, map(area_of_rings, small))


def join_clips(outer: Clip, areas: Iterable[BaseGeometry]) -> Clip:
    """What lies in a clip and in all areas; outer: None for no clip."""
    clip = outer
    for area in areas:
        clip = area if clip is None else _polygons_of(shapely.intersection(clip, area))
    if clip is not None:
        shapely.prepare(clip)
    return clip


def _polygons_of(area: BaseGeometry) -> BaseGeometry:
    """An area without the lines and points where two areas merely touch."""
    if area.geom_type in {"Polygon", "MultiPolygon"}:
        return area
    return shapely.union_all(list_polygons(area))


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
    polygons = list_polygons(shapely.intersection(area_of_rings(rings), clip))
    return [np.asarray(shapely.get_coordinates(ring)) for each in polygons for ring in (each.exterior, *each.interiors)]
