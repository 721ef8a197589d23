"""The label image of a rival method as a floor with rooms and doors."""

from __future__ import annotations

import numpy as np
import shapely

from pianta.errors import MapError
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.layout._label_images import Labels, outline_labels
from pianta.layout._numbering import assemble_floor
from pianta.layout._voronoi_doors import find_doors
from pianta.layout._working_grid import MARGIN_PX, NO_ROOM, WorkingGrid
from pianta.layout.parameters import ThesisParameters


def floor_from_labels(grid: GridMap, labels: Labels) -> Floor:
    """Floor with a room for each label of a label image, and the doors of the topological map; it has no walls.

    labels: shape (H, W) of the grid; n > 0 is a room, other values are not. If the cells of a label are not connected
    by edges, the largest part is the room. Outlines run along the sides of cells, so that rooms never overlap.

    Rooms are numbered in reading order of the map image.
    Raises MapError when no cell has a label, or the shapes differ.
    """
    labels = np.maximum(np.asarray(labels), 0)
    if labels.shape != grid.shape:
        raise MapError(f"labels of shape {labels.shape} do not fit a map of shape {grid.shape}, give one label a cell")
    if not labels.any():
        raise MapError(NO_ROOM)
    outlines, label = outline_labels(labels)
    rooms = [
        Room(i, shapely.transform(outline, lambda xy: np.column_stack(grid.pixel_to_map(xy[:, 1], xy[:, 0]))))
        for i, outline in enumerate(outlines, start=1)
    ]
    # Room n + 1 has index n on the working grid.
    index = np.full(labels.max() + 1, -1)
    index[label] = np.arange(len(label))
    to_grid = np.array([[1.0, 0.0, -MARGIN_PX], [0.0, 1.0, -MARGIN_PX], [0.0, 0.0, 1.0]])
    working_grid = WorkingGrid(np.pad(grid.free, MARGIN_PX), grid.resolution, to_grid, grid)
    doors = find_doors(working_grid, np.pad(index[labels], MARGIN_PX, constant_values=-1), ThesisParameters())
    return assemble_floor(rooms, doors, (), grid)
