"""ClassMap that are drawn by hand, rectangle by rectangle, for the tests of plan reading."""

import numpy as np
from numpy.typing import NDArray

from pianta.plan.walls.segmentation import DOOR, INSIDE, OUTSIDE, WALL, ClassMap
from tests.drawn_maps import Rectangle

CellClasses = NDArray[np.int64]

# Metres of a cell, pixels of a cell, and metres of a pixel.
CELL, CELL_PX = 0.1, 4.0
RESOLUTION = CELL / CELL_PX
# Two rooms of 4 m × 4 m beside each other, and the door of 0.8 m between them.
ROOMS: tuple[Rectangle, ...] = ((10, 50, 10, 50), (10, 50, 52, 92))
DOORWAY: Rectangle = (28, 36, 50, 52)


def draw_classes(
    shape: tuple[int, int], *rooms: Rectangle, doors: tuple[Rectangle, ...] = (), margin: int = 2
) -> CellClasses:
    """What each cell is: rooms top, bottom, left, right in walls as thick as the margin, doors, and outside."""
    kinds = np.full(shape, OUTSIDE)
    for top, bottom, left, right in rooms:
        kinds[top - margin : bottom + margin, left - margin : right + margin] = WALL
    for kind, rectangles in ((INSIDE, rooms), (DOOR, doors)):
        for top, bottom, left, right in rectangles:
            kinds[top:bottom, left:right] = kind
    return kinds


def two_rooms(*, doors: tuple[Rectangle, ...] = (DOORWAY,)) -> CellClasses:
    """The two rooms in an outside of a metre."""
    return draw_classes((60, 102), *ROOMS, doors=doors)


def as_class_map(kinds: CellClasses, *, sure: float = 0.94) -> ClassMap:
    """ClassMap of a network that is so sure of each cell, and finds the other three alike."""
    probabilities = np.full((4, *kinds.shape), (1 - sure) / 3, np.float32)
    np.put_along_axis(probabilities, kinds[None], sure, axis=0)
    return ClassMap(probabilities, CELL_PX)


def sheet_shape(kinds: CellClasses) -> tuple[int, int]:
    """Rows and columns of the sheet of such regions, pixels."""
    rows, cols = (round(side * CELL_PX) for side in kinds.shape)
    return rows, cols
