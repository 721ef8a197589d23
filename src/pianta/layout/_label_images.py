"""Label images: growing labels over free cells, the contacts between labels, and outlines that never overlap."""

from __future__ import annotations

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, STRtree

from pianta._types import Floats, Indices, Mask
from pianta.floor.polygons import find_largest_polygon

# Corners nearer to each other than this are one; metres. Well below a cell, well above the rounding of float64.
SNAP_DISTANCE = 1e-6

# Shape (H, W), n > 0 for the cells of room n; or a list of labels.
Labels = NDArray[np.integer]
Polygons = NDArray[np.object_]


def grow_mask(mask: Mask, reach: int) -> Mask:
    """The mask, shape (H, W), and all cells at most reach rows and columns away from it."""
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    return np.asarray(cv2.dilate(mask.view(np.uint8), square)).view(bool)


def shrink_mask(mask: Mask, reach: int) -> Mask:
    """The mask, shape (H, W), without cells at most reach rows and columns away from one outside it, or the edge."""
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    shrunk = cv2.erode(mask.view(np.uint8), square, borderValue=0, borderType=cv2.BORDER_CONSTANT)
    return np.asarray(shrunk).view(bool)


def nearest_labels(labels: Labels, *, background: int) -> tuple[Labels, NDArray[np.float32]]:
    """The nearest label that is not background, and about how many cells away it is; both of shape (H, W)."""
    unlabelled = labels == background
    distance, nearest = cv2.distanceTransformWithLabels(
        unlabelled.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    label_of_pixel = np.full(nearest.max() + 1, background, labels.dtype)
    label_of_pixel[nearest[~unlabelled]] = labels[~unlabelled]
    return label_of_pixel[nearest], np.asarray(distance, np.float32)


def list_contacts(labels: Labels) -> tuple[Indices, Indices]:
    """Pairs of labels > 0 that touch by an edge, the smaller first, shape (N, 2), sorted; and the edges they share."""
    touching = []
    for one, other in ((labels[:-1], labels[1:]), (labels[:, :-1], labels[:, 1:])):
        meet = (one != other) & (one > 0) & (other > 0)
        touching.append(np.column_stack([one[meet], other[meet]]))
    pairs, lengths = np.unique(np.sort(np.concatenate(touching), axis=1), axis=0, return_counts=True)
    return pairs.astype(np.intp), lengths


def highest_of_labels(values: NDArray[np.number], labels: Labels, count: int, *, lowest: float = 0) -> Floats:
    """The highest value of the cells of each label from 0 to count, and at least the lowest; shape (count + 1,).

    values, labels: of the same shape.
    """
    highest = np.full(count + 1, lowest, float)
    # With equal types this is ten times faster.
    np.maximum.at(highest, labels.ravel().astype(np.intp), values.ravel().astype(float))
    return highest


def outline_labels(labels: Labels) -> tuple[Polygons, Labels]:
    """Outline of the largest part of each label, in cells, x = col and y = row; and the label. Both of shape (R,).

    labels: shape (H, W); n > 0 is a room, other values are not. Cells of one part are joined by their sides.
    The labels ascend. The outlines are a valid coverage: neighbours share all corners on their common side.
    """
    outlines, label = _outline_parts(labels)
    # Sort the parts by label and area, so that the largest part of each label comes last.
    order = np.lexsort((shapely.area(outlines), label))
    largest = order[np.append(np.diff(label[order]) > 0, True)] if len(order) else order
    return outlines[largest], label[largest]


def join_outlines(outlines: Polygons) -> Polygons:
    """Outlines, shape (R,), in metres, as a valid coverage: neighbours share all corners on their common side.

    Where two outlines overlap because of rounding, the overlap belongs to the first.
    """
    lines = shapely.union_all(shapely.boundary(outlines), grid_size=SNAP_DISTANCE)
    faces = np.array(shapely.get_parts(shapely.polygonize(shapely.get_parts(lines))))
    face, outline = STRtree(outlines).query(shapely.point_on_surface(faces), predicate="intersects")
    order = np.lexsort((outline, face))
    face, first = np.unique(face[order], return_index=True)
    outline = outline[order][first]
    return np.array([largest_part(shapely.coverage_union_all(faces[face[outline == i]])) for i in range(len(outlines))])


def largest_part(shape: shapely.Geometry) -> Polygon:
    """The largest polygon of a geometry, which need not be valid; an empty polygon if there is no polygon."""
    return find_largest_polygon(shapely.make_valid(shape, method="structure", keep_collapsed=False))


def _outline_parts(labels: Labels) -> tuple[Polygons, Labels]:
    """Polygons, x = col and y = row, of all parts of all labels n > 0, and the label of each; both of shape (P,)."""
    around = np.pad(labels, 1)
    vertical = _trace_sides(around[1:-1, :-1], around[1:-1, 1:])
    horizontal = _trace_sides(around[:-1, 1:-1].T, around[1:, 1:-1].T)[:, :, ::-1]
    lines = shapely.linestrings(np.concatenate([vertical, horizontal]))
    parts = np.array(shapely.get_parts(shapely.polygonize(lines)))
    inside = shapely.get_coordinates(shapely.point_on_surface(parts))
    cols, rows = np.floor(inside).astype(int).T
    label = labels[rows, cols]
    return parts[label > 0], label[label > 0]


def _trace_sides(left: Labels, right: Labels) -> Floats:
    """Ends, shape (N, 2, 2), as (col, row), of the vertical lines between cells side by side that differ.

    left, right: shape (H, W + 1). A line goes on while the same two labels lie beside it, so that it ends at every
    point where another line meets it.
    """
    differs = left != right
    above, below = np.zeros_like(differs), np.zeros_like(differs)
    same = (left[1:] == left[:-1]) & (right[1:] == right[:-1])
    above[1:], below[:-1] = same, same
    cols, first = np.nonzero((differs & ~above).T)
    _, last = np.nonzero((differs & ~below).T)
    return np.stack([np.column_stack([cols, first]), np.column_stack([cols, last + 1])], axis=1).astype(float)
