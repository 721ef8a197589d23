"""Maps that are drawn by hand, rectangle by rectangle, for the tests of the layout."""

import numpy as np

from pianta._types import Mask
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout._working_grid import WorkingGrid

Rectangle = tuple[int, int, int, int]


def carve(shape: tuple[int, int], *rectangles: Rectangle) -> Mask:
    """Mask of a shape, true in the rectangles top, bottom, left, right (bottom and right not included)."""
    mask = np.zeros(shape, bool)
    for top, bottom, left, right in rectangles:
        mask[top:bottom, left:right] = True
    return mask


def make_grid(free: Mask, *, resolution: float = 0.05, yaw: float = 0.0, walls: bool = True) -> GridMap:
    """Grid map of free cells in the occupied, or the unknown, with an odd origin."""
    return GridMap(np.where(free, FREE, OCCUPIED if walls else UNKNOWN), resolution, (1.5, -2.0, yaw))


def make_working_grid(free: Mask, *, resolution: float = 0.05) -> WorkingGrid:
    """WorkingGrid whose cells are those of its grid map."""
    return WorkingGrid(free, resolution, np.eye(3), GridMap(np.where(free, FREE, OCCUPIED), resolution))
