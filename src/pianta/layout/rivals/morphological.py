"""Morphological segmentation of the survey (Bormann et al., ICRA 2016): rooms by erosion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pianta._types import LabelImage
from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters, check_parameters
from pianta.layout.rivals.patches import grow_labels, label_patches, measure_padded_clearance


@dataclass(frozen=True, kw_only=True)
class MorphologicalParameters(Parameters):
    """Thresholds of the morphological segmentation; the defaults are those of the survey's program.

    erosion: thickness of the layer that each erosion removes; metres (one cell of the survey's maps).
    smallest, largest: area of a patch of the eroded map that counts as a room; m².
    """

    erosion: float = 0.05
    smallest: float = 0.8
    largest: float = 47.0


def segment_by_erosion(grid: GridMap, *, parameters: Parameters | None = None) -> LabelImage:
    """Segment a grid map into rooms; returns a label image, shape (H, W): 0 no room, 1 … N.

    The free space is eroded cell layer by cell layer. A connected patch that has the area of a room becomes a room, and
    is eroded no further. Last, the eroded cells are added to the rooms near them.
    """
    thresholds = check_parameters(parameters, MorphologicalParameters)
    clearance = measure_padded_clearance(grid.free, chessboard=True)
    layer = max(thresholds.erosion / grid.resolution, 1.0)
    rooms = np.zeros(grid.shape, np.int32)
    remaining = grid.free
    depth = 0.0
    while remaining.any():
        # A disconnected patch of the size of a room is a room, and is eroded no further.
        patches, areas = label_patches(remaining, grid.resolution)
        is_room = (thresholds.smallest <= areas) & (areas <= thresholds.largest)
        ids = np.where(is_room, rooms.max() + np.cumsum(is_room), 0)[patches]
        rooms[ids > 0] = ids[ids > 0]
        depth += layer
        remaining = (clearance > depth) & (rooms == 0) & remaining
    # Give the eroded cells back to the rooms.
    return grow_labels(rooms, grid.free)
