"""Class maps that are drawn by hand, rectangle by rectangle, for the tests of plan reading."""

import numpy as np
from numpy.typing import NDArray

from pianta.plan.walls.segmentation import DOOR, INSIDE, OUTSIDE, WALL, ClassMap
from tests.drawn_maps import Rectangle

CellClasses = NDArray[np.int64]

# Metres per cell, pixels per cell, and metres per pixel
CELL, CELL_PX = 0.1, 4.0
RESOLUTION = CELL / CELL_PX
# Two rooms of 4 m × 4 m beside each other, and the door of 0.8 m between them.
ROOMS: tuple[Rectangle, ...] = ((10, 50, 10, 50), (10, 50, 52, 92))
DOORWAY: Rectangle = (28, 36, 50, 52)


def draw_classes(
    shape: tuple[int, int], *rooms: Rectangle, doors: tuple[Rectangle, ...] = (), margin: int = 2
) -> CellClasses:
    """The class of each cell: rooms top, bottom, left, right in walls as thick as the margin, doors, and outside."""
    classes = np.full(shape, OUTSIDE)
    for top, bottom, left, right in rooms:
        classes[top - margin : bottom + margin, left - margin : right + margin] = WALL
    for cell_class, rectangles in ((INSIDE, rooms), (DOOR, doors)):
        for top, bottom, left, right in rectangles:
            classes[top:bottom, left:right] = cell_class
    return classes


def two_rooms(*, doors: tuple[Rectangle, ...] = (DOORWAY,)) -> CellClasses:
    """The two rooms with a metre of outside around them."""
    return draw_classes((60, 102), *ROOMS, doors=doors)


def as_class_map(classes: CellClasses, *, probability: float = 0.94) -> ClassMap:
    """The map of a network that gives each cell's class a probability, and the other three equal shares of the rest."""
    probabilities = np.full((4, *classes.shape), (1 - probability) / 3, np.float32)
    np.put_along_axis(probabilities, classes[None], probability, axis=0)
    return ClassMap(probabilities, CELL_PX)


def sheet_shape(classes: CellClasses) -> tuple[int, int]:
    """Rows and columns of the sheet of such a map, pixels."""
    rows, cols = (round(side * CELL_PX) for side in classes.shape)
    return rows, cols
