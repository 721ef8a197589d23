"""A floor from a label image: what the rival methods find, as rooms and doors."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta.errors import MapError
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.layout._canvas import MARGIN_PX, Canvas
from pianta.layout._numbering import assemble_floor
from pianta.layout._outlines import Labels, outline_labels
from pianta.layout._voronoi_doors import find_doors
from pianta.layout.parameters import ThesisParameters


def floor_from_labels(grid: GridMap, labels: Labels) -> Floor:
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
    outlines, label = outline_labels(labels)
    rooms = [
        Room(i, shapely.transform(outline, lambda xy: np.column_stack(grid.pixel_to_map(xy[:, 1], xy[:, 0]))))
        for i, outline in enumerate(outlines, start=1)
    ]
    # Room n + 1 has number n on the canvas.
    number = np.full(labels.max() + 1, -1)
    number[label] = np.arange(len(label))
    canvas = Canvas(np.pad(grid.free, MARGIN_PX), grid.resolution, _to_grid(), grid)
    doors = find_doors(canvas, np.pad(number[labels], MARGIN_PX, constant_values=-1), ThesisParameters())
    return assemble_floor(rooms, doors, (), grid)


def _to_grid() -> NDArray[np.float64]:
    """Canvas (row, col, 1) to grid (row, col, 1)."""
    return np.array([[1.0, 0.0, -MARGIN_PX], [0.0, 1.0, -MARGIN_PX], [0.0, 0.0, 1.0]])
