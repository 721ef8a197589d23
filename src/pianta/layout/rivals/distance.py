"""Distance transform segmentation of the survey (Bormann et al., ICRA 2016): rooms by clearance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pianta._types import LabelImage
from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters, check_parameters
from pianta.layout.rivals.patches import grow_labels, label_patches, measure_padded_clearance


@dataclass(frozen=True, kw_only=True)
class DistanceParameters(Parameters):
    """Thresholds of the distance transform segmentation; the defaults are those of the survey's program.

    step: between one threshold on the clearance and the next; metres (one cell of the survey's maps).
    smallest, largest: area of a patch above the threshold that counts as a room; m².
    """

    step: float = 0.05
    smallest: float = 0.35
    largest: float = 163.0


def segment_by_clearance(grid: GridMap, *, parameters: Parameters | None = None) -> LabelImage:
    """Segment a grid map into rooms; returns a label image, shape (H, W): 0 no room, 1 … N.

    The rooms are the connected patches of cells with a clearance above a threshold. The threshold is the one that gives
    most rooms. Last, the other free cells are added to the rooms near them.
    """
    thresholds = check_parameters(parameters, DistanceParameters)
    clearance = measure_padded_clearance(grid.free)
    step = max(thresholds.step / grid.resolution, 1.0)
    best, most = np.zeros(grid.shape, np.int32), 0
    # From the lowest threshold up, so that of two equally good ones the one that removes less is chosen.
    for threshold in step * np.arange(int(clearance.max() / step) + 1):
        patches, areas = label_patches(clearance > threshold, grid.resolution)
        is_room = (thresholds.smallest <= areas) & (areas <= thresholds.largest)
        if is_room.sum() > most:
            best, most = np.where(is_room, np.cumsum(is_room), 0).astype(np.int32)[patches], int(is_room.sum())
    return grow_labels(best, grid.free)
