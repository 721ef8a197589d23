"""Outlines of the rooms of a label image: polygons along the sides of its cells, which never overlap."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, STRtree

from pianta._types import Floats

# Corners nearer to each other than this are one; metres.
GRID = 1e-6

Labels = NDArray[np.integer]
Polygons = NDArray[np.object_]


def outline_labels(labels: Labels) -> tuple[Polygons, Labels]:
    """Outline of the largest part of each label, in cells, x = col and y = row; and the label. Both of shape (R,).

    labels: shape (H, W); n > 0 is a room, anything else is none. Cells of one part are joined by their sides.
    The labels ascend. The outlines are a valid coverage: neighbours share all corners on their common side.
    """
    outlines, label = _outline_parts(labels)
    # The largest part of each label comes last among its own.
    order = np.lexsort((shapely.area(outlines), label))
    largest = order[np.append(np.diff(label[order]) > 0, True)] if len(order) else order
    return outlines[largest], label[largest]


def join_outlines(outlines: Polygons) -> Polygons:
    """Outlines, shape (R,), in metres, as a valid coverage: neighbours share all corners on their common side.

    What two of them cover, because they are rounded, belongs to the first.
    """
    lines = shapely.union_all(shapely.boundary(outlines), grid_size=GRID)
    faces = np.array(shapely.get_parts(shapely.polygonize(shapely.get_parts(lines))))
    face, outline = STRtree(outlines).query(shapely.point_on_surface(faces), predicate="intersects")
    order = np.lexsort((outline, face))
    face, first = np.unique(face[order], return_index=True)
    outline = outline[order][first]
    return np.array([largest_part(shapely.coverage_union_all(faces[face[outline == i]])) for i in range(len(outlines))])


def largest_part(shape: shapely.Geometry) -> Polygon:
    """The largest polygon of a geometry, which need not be valid; an empty one where there is none."""
    parts = shapely.get_parts(shapely.make_valid(shape, method="structure", keep_collapsed=False))
    return max((part for part in parts if isinstance(part, Polygon)), key=lambda part: part.area, default=Polygon())


def _outline_parts(labels: Labels) -> tuple[Polygons, Labels]:
    """Polygons, x = col and y = row, of all parts of all labels n > 0, and the label of each; both of shape (P,)."""
    around = np.pad(labels, 1)
    upright = _trace_sides(around[1:-1, :-1], around[1:-1, 1:])
    level = _trace_sides(around[:-1, 1:-1].T, around[1:, 1:-1].T)[:, :, ::-1]
    lines = shapely.linestrings(np.concatenate([upright, level]))
    parts = np.array(shapely.get_parts(shapely.polygonize(lines)))
    inside = shapely.get_coordinates(shapely.point_on_surface(parts))
    cols, rows = np.floor(inside).astype(int).T
    label = labels[rows, cols]
    return parts[label > 0], label[label > 0]


def _trace_sides(left: Labels, right: Labels) -> Floats:
    """Ends, shape (N, 2, 2), as (col, row), of the upright lines between two cells beside each other that differ.

    left, right: shape (H, W + 1). A line goes on while the same two labels lie beside it, so that it ends wherever
    another line meets it.
    """
    differs = left != right
    above, below = np.zeros_like(differs), np.zeros_like(differs)
    same = (left[1:] == left[:-1]) & (right[1:] == right[:-1])
    above[1:], below[:-1] = same, same
    cols, first = np.nonzero((differs & ~above).T)
    _, last = np.nonzero((differs & ~below).T)
    return np.stack([np.column_stack([cols, first]), np.column_stack([cols, last + 1])], axis=1).astype(float)
