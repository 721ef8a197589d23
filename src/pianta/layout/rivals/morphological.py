"""Rooms by erosion: the morphological segmentation of the survey (Bormann et al., ICRA 2016)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters, check_parameters
from pianta.layout.rivals.patches import Labels, label_patches, measure_clearance, spread_labels


@dataclass(frozen=True, kw_only=True)
class MorphologicalParameters(Parameters):
    """Thresholds of the morphological segmentation; the defaults are those of the survey's program.

    erosion: thickness of the layer that each erosion takes off, metres; a cell of the survey's maps.
    smallest, largest: area that a patch of the eroded map has when it becomes a room, m².
    """

    erosion: float = 0.05
    smallest: float = 0.8
    largest: float = 47.0


def segment_by_erosion(grid: GridMap, *, parameters: Parameters | None = None) -> Labels:
    """Rooms of a grid map, shape (H, W): 0 no room, 1 … N."""
    thresholds = check_parameters(parameters, MorphologicalParameters)
    clearance = measure_clearance(grid.free, chessboard=True)
    layer = max(thresholds.erosion / grid.resolution, 1.0)
    rooms = np.zeros(grid.shape, np.int32)
    left = grid.free
    depth = 0.0
    while left.any():
        # A patch that has fallen off the rest, and is as large as a room, is one, and is eroded no further.
        patches, areas = label_patches(left, grid.resolution)
        is_room = (thresholds.smallest <= areas) & (areas <= thresholds.largest)
        ids = np.where(is_room, rooms.max() + np.cumsum(is_room), 0)[patches]
        rooms[ids > 0] = ids[ids > 0]
        depth += layer
        left = (clearance > depth) & (rooms == 0) & left
    # What the erosion took off is given back.
    return spread_labels(rooms, grid.free)
