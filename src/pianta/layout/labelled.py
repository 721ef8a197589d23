"""A floor from a label image: what the methods of pianta.segmentation find, as rooms and doors."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta.errors import MapError
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.layout.canvas import MARGIN_PX, Canvas
from pianta.layout.doors import find_doors
from pianta.layout.numbering import assemble_floor
from pianta.layout.parameters import ThesisParameters

Labels = NDArray[np.integer]


def floor_from_labels(grid: GridMap, labels: Labels, *, source: str = "") -> Floor:
    """Floor whose rooms are the labels of a label image, with the doors of the topological map; it has no walls.

    labels: shape (H, W) of the grid; n > 0 is a room, anything else is none. Of a label in several parts, which do not
    touch by an edge, the largest is the room. Outlines run along the sides of cells, so that rooms never overlap.

    Rooms are numbered in reading order of the map image.
    Raises MapError when no cell has a label, or the shapes differ.
    """
    labels = np.maximum(np.asarray(labels), 0)
    if labels.shape != grid.shape:
        raise MapError(f"labels of shape {labels.shape} do not fit a map of shape {grid.shape}, give one label a cell")
    if not labels.any():
        raise MapError("the map shows no room, its free space is too small or too scattered; check the resolution")
    outlines, label = _outline_parts(labels)
    # The largest part of each label comes last among its own.
    order = np.lexsort((shapely.area(outlines), label))
    largest = order[np.append(np.diff(label[order]) > 0, True)]
    rooms = [
        Room(i, shapely.transform(outline, lambda xy: np.column_stack(grid.pixel_to_map(xy[:, 1], xy[:, 0]))))
        for i, outline in enumerate(outlines[largest], start=1)
    ]
    # Room n + 1 has number n on the canvas.
    number = np.full(labels.max() + 1, -1)
    number[label[largest]] = np.arange(len(largest))
    canvas = Canvas(np.pad(grid.free, MARGIN_PX), grid.resolution, _to_grid(), grid)
    doors = find_doors(canvas, np.pad(number[labels], MARGIN_PX, constant_values=-1), ThesisParameters())
    return assemble_floor(rooms, doors, (), grid, source)


def _to_grid() -> NDArray[np.float64]:
    """Canvas (row, col, 1) to grid (row, col, 1)."""
    return np.array([[1.0, 0.0, -MARGIN_PX], [0.0, 1.0, -MARGIN_PX], [0.0, 0.0, 1.0]])


def _outline_parts(labels: Labels) -> tuple[NDArray[np.object_], NDArray[np.integer]]:
    """Polygons, x = col and y = row, of all parts of all labels, and the label of each; both of shape (P,)."""
    around = np.pad(labels, 1)
    upright = _trace_sides(around[1:-1, :-1], around[1:-1, 1:])
    level = _trace_sides(around[:-1, 1:-1].T, around[1:, 1:-1].T)[:, :, ::-1]
    lines = shapely.linestrings(np.concatenate([upright, level]))
    parts = np.array(shapely.get_parts(shapely.polygonize(lines)))
    inside = shapely.get_coordinates(shapely.point_on_surface(parts))
    cols, rows = np.floor(inside).astype(int).T
    label = labels[rows, cols]
    return parts[label > 0], label[label > 0]


def _trace_sides(left: Labels, right: Labels) -> NDArray[np.float64]:
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
