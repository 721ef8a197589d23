"""Masks for Nav2's costmap filters: maps with one value in some rooms and 0 elsewhere.

They have no yaw, as Nav2 asks; where the map has one, the mask has a grid of its own that covers it.
"""

from __future__ import annotations

from collections.abc import Collection
from math import ceil

import numpy as np

from pianta.floor import Floor
from pianta.gridmap import FREE, OCCUPIED, GridMap

# A robot never enters these cells of a keep-out mask.
FORBIDDEN = OCCUPIED


def make_mask(floor: Floor, grid: GridMap, rooms: Collection[int], value: int) -> GridMap:
    """A mask with a value, 0 … 100, in rooms with these ids and 0 elsewhere; on the cells of the map if it has no yaw.

    A cell is in the room that contains its middle.
    """
    frame = _make_upright(grid) if grid.origin[2] else grid
    is_chosen = np.isin(floor.label_image(frame), [*rooms])
    return GridMap(np.where(is_chosen, value, FREE).astype(np.int8), frame.resolution, frame.origin, grid.source)


def _make_upright(grid: GridMap) -> GridMap:
    """A grid of free cells without yaw that covers a map with yaw."""
    height, width = grid.shape
    x, y = grid.pixel_to_map([0, 0, height, height], [0, width, 0, width])
    left, bottom = float(x.min()), float(y.min())
    shape = (ceil((y.max() - bottom) / grid.resolution), ceil((x.max() - left) / grid.resolution))
    return GridMap(np.zeros(shape, np.int8), grid.resolution, (left, bottom, 0.0), grid.source)
