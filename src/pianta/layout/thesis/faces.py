"""Faces: the areas into which representative lines divide a map (Algorithm 1, fourth step)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import shapely

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.layout._label_images import SNAP_DISTANCE, Polygons
from pianta.layout._working_grid import WorkingGrid
from pianta.layout.thesis.lines import RepresentativeLine

# How far beyond the free space lines are followed; metres (chosen by hand).
FRINGE = 1.0
# Points at which an edge is sampled for free space.
SAMPLES = 32
# Sub-pixel bits of the coordinates of polygons that are drawn with OpenCV.
SHIFT = 4


@dataclass(frozen=True, eq=False)
class Faces:
    """Faces of the arrangement of representative lines, and the edges that they share; metres of the working grid.

    polygons: shape (F,), convex.
    first, second: shape (E,), the two faces of each shared edge.
    starts, ends: shape (E, 2), x, y of the ends of each shared edge.
    weight: shape (E,), w = cov(e) / len(e), the share of the edge that is wall.
    """

    polygons: Polygons
    first: Indices
    second: Indices
    starts: Floats
    ends: Floats
    weight: Floats


def find_faces(lines: Sequence[RepresentativeLine], working_grid: WorkingGrid) -> Faces:
    """F ← findFaces(lines): faces inside a frame around the free space, with the weights of their common edges."""
    rows, cols = np.nonzero(working_grid.free.any(axis=1))[0], np.nonzero(working_grid.free.any(axis=0))[0]
    corners = np.array([cols[0], rows[0], cols[-1] + 1, rows[-1] + 1]) * working_grid.resolution
    frame = shapely.box(*(corners + FRINGE * np.array([-1, -1, 1, 1])))
    # Intersections on a fine grid, so that nearly coincident lines leave no slivers.
    network = shapely.union_all([*cut_lines(lines, frame), frame.exterior], grid_size=SNAP_DISTANCE)
    polygons = np.array(shapely.get_parts(shapely.polygonize(shapely.get_parts(network))))
    first, second, starts, ends = _find_common_edges(polygons)
    return Faces(polygons, first, second, starts, ends, _compute_edge_weights(starts, ends, lines))


def cut_lines(lines: Sequence[RepresentativeLine], region: shapely.Geometry) -> list[shapely.LineString]:
    """The part of each representative line inside a convex region, if there is one; metres of the working grid."""
    reach = 2 * np.abs(shapely.total_bounds(region)).max() + 1
    ends = [
        [line.normal * line.offset - line.direction * reach, line.normal * line.offset + line.direction * reach]
        for line in lines
    ]
    inside = shapely.intersection(shapely.linestrings(np.reshape(ends, (-1, 2, 2))), region)
    return [part for part in inside if part.length > SNAP_DISTANCE]


def label_faces(faces: Faces, working_grid: WorkingGrid) -> LabelImage:
    """Index of the face of each cell, shape (H, W); -1 outside the frame."""
    labels = np.full(working_grid.free.shape, -1, np.int32)
    for i, polygon in enumerate(faces.polygons):
        corners = (shapely.get_coordinates(polygon) / working_grid.resolution - 0.5) * 2**SHIFT
        cv2.fillConvexPoly(labels, np.round(corners).astype(np.int32), i, shift=SHIFT)
    return labels


def share_inside(labels: LabelImage, inside: Mask, count: int) -> Floats:
    """Share of the cells of each face that are inside a mask, shape (F,); 0 for a face thinner than a cell."""
    cells = np.bincount(labels.ravel() + 1, minlength=count + 1)[1:]
    return np.asarray(np.bincount(labels[inside] + 1, minlength=count + 1)[1:] / np.maximum(cells, 1))


def share_free(faces: Faces, working_grid: WorkingGrid) -> Floats:
    """Share of each common edge that runs through free cells, shape (E,)."""
    along = (np.arange(SAMPLES) + 0.5) / SAMPLES
    points = faces.starts[:, None] + along[:, None] * (faces.ends - faces.starts)[:, None]
    cols, rows = np.moveaxis(np.floor(points / working_grid.resolution).astype(int), -1, 0)
    height, width = working_grid.free.shape
    inside = (rows >= 0) & (rows < height) & (cols >= 0) & (cols < width)
    return np.asarray((working_grid.free[rows.clip(0, height - 1), cols.clip(0, width - 1)] & inside).mean(axis=1))


def _find_common_edges(polygons: Polygons) -> tuple[Indices, Indices, Floats, Floats]:
    """The two faces, and the two ends, shape (E, 2), of every edge that two faces share."""
    xy, face = shapely.get_coordinates(shapely.get_exterior_ring(polygons), return_index=True)
    same = face[1:] == face[:-1]
    starts, ends, face = xy[:-1][same], xy[1:][same], face[:-1][same]
    # The rings of two faces run along their common edge in opposite directions.
    keys = np.round((starts + ends) / SNAP_DISTANCE).astype(np.int64)
    order = np.lexsort((keys[:, 1], keys[:, 0]))
    pair = np.flatnonzero((keys[order[1:]] == keys[order[:-1]]).all(axis=1))
    one, other = order[pair], order[pair + 1]
    return face[one], face[other], starts[one], ends[one]


def _compute_edge_weights(starts: Floats, ends: Floats, lines: Sequence[RepresentativeLine]) -> Floats:
    """Weight w = cov(e) / len(e): the share of each edge that the segments of its line project onto, shape (E,)."""
    weights = np.zeros(len(starts))
    if not (lines and len(starts)):
        return weights
    normals, offsets = np.array([line.normal for line in lines]), np.array([line.offset for line in lines])
    distance = np.maximum(np.abs(starts @ normals.T - offsets), np.abs(ends @ normals.T - offsets))
    owner = distance.argmin(axis=1)
    for i in np.unique(owner):
        own = owner == i
        along = np.sort(np.column_stack([starts[own] @ lines[i].direction, ends[own] @ lines[i].direction]), axis=1)
        lengths = np.maximum(along[:, 1] - along[:, 0], SNAP_DISTANCE)
        weights[own] = lines[i].cover(along[:, 0], along[:, 1]) / lengths
    return np.clip(weights, 0.0, 1.0)
