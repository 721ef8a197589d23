"""Scenes of partial rooms on few cells."""

import numpy as np

from pianta._types import Floats, Mask
from pianta.layout.partial.scene import RoomScene, View

NO_LINES = np.zeros((0, 2, 2))


def make_scene(
    observed: Mask, others: Mask | None = None, *, lines: Floats = NO_LINES, doors: Floats = NO_LINES
) -> RoomScene:
    """A scene of cells of 0.1 m without obstacles and other extents."""
    none = np.zeros_like(observed)
    view = View(0.0, np.zeros(2), observed.shape, 0.1)
    others = none if others is None else others
    masks = (observed, others, others, none, none, none, none)
    return RoomScene(view, *masks, np.zeros((0, 2)), lines, 1, doors)


def fill_cells(top: int, left: int, bottom: int, right: int) -> Mask:
    """Cells of a rectangle, of 40 x 60."""
    cells = np.zeros((40, 60), bool)
    cells[top:bottom, left:right] = True
    return cells
