"""The floor of a map: the free cells, and those under furniture, without what lies outside the building."""

from __future__ import annotations

import cv2
import numpy as np

from pianta._types import Mask
from pianta.layout._label_images import grow_mask
from pianta.layout._working_grid import WorkingGrid
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.evidence import FLOOR, FURNITURE, OUTSIDE, WALL, Evidence

# The probabilities were chosen on simulated maps. Cells that are not free belong to the floor from this on, ...
FLOOR_PROBABILITY = 0.65
# ... and free cells lie outside, as rays through a window do, from this on.
OUTSIDE_PROBABILITY = 0.8
# Of obstacles, those cells that are furniture with less than this are walls or unknown space drawn as wall.
FURNITURE_PROBABILITY = 0.3
# Rows of obstacles of fewer cells are no furniture that the network may take away; working cells (chosen by hand).
THIN_CELLS = 5
# They are at most this far from a free cell, since the network also draws rooms behind walls; metres.
FLOOR_REACH = 0.6
# A small group of other cells is a piece of wall if its mean probability of wall is at least this.
WALL_PROBABILITY = 0.5
# What the network adds is no floor if it borders on unknown cells along more than this (chosen by hand); metres.
MAX_OPEN_LENGTH = 0.5
# A larger group is no piece of furniture; m².
MAX_FURNITURE_AREA = 1.5


def find_floor_space(
    working_grid: WorkingGrid, occupied: Mask, evidence: Evidence, parameters: StructureParameters
) -> tuple[Mask, Mask]:
    """Cells of the floor, and those of them that were seen or are small furniture; shape (H, W) of the working grid.

    occupied: cells with an obstacle, shape (H, W). The outermost cells are no floor.

    Small groups of other cells are furniture (section 3.2 of the thesis), unless they are pieces of wall. Of the larger
    groups, those cells are floor that the network takes for furniture or floor.
    """
    free = working_grid.free
    small = _find_small_groups(~free, parameters.clutter_size / working_grid.resolution)
    count, group = cv2.connectedComponents(small.astype(np.uint8), connectivity=8)
    wall = np.bincount(group.ravel(), evidence.enlarge(evidence.classes[WALL]).ravel(), count)
    is_wall = wall >= WALL_PROBABILITY * np.bincount(group.ravel(), minlength=count)
    furniture = small & ~is_wall[group]
    floor = evidence.enlarge(evidence.classes[FLOOR] + evidence.classes[FURNITURE]) > FLOOR_PROBABILITY
    floor &= grow_mask(free, round(FLOOR_REACH / working_grid.resolution))
    floor &= ~occupied | (evidence.enlarge(evidence.classes[FURNITURE]) > FURNITURE_PROBABILITY)
    # A thin row of obstacles is a wall, even if the network takes it for furniture
    thick = cv2.morphologyEx(
        (floor & ~free).astype(np.uint8), cv2.MORPH_OPEN, np.ones((THIN_CELLS, THIN_CELLS), np.uint8)
    )
    floor &= ~occupied | (thick > 0)
    outside = evidence.enlarge(evidence.classes[OUTSIDE]) > OUTSIDE_PROBABILITY
    certain = (free | furniture) & ~outside
    space = certain | _keep_enclosed(floor & ~certain & ~outside, certain, working_grid)
    space[[0, -1]] = space[:, [0, -1]] = False
    space = _drop_patches(space, parameters.patch_area / working_grid.resolution**2)
    return space, space & (free | furniture)


def _find_small_groups(others: Mask, size: float) -> Mask:
    """8-connected groups of cells less than `size` across, in cells, that do not reach the edge; shape (H, W)."""
    framed = np.pad(others, 1, constant_values=True).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(framed, connectivity=8)
    small = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT]) < size
    small[[0, labels[0, 0]]] = False
    return np.asarray(small[labels[1:-1, 1:-1]])


def _drop_patches(free: Mask, min_cells: float) -> Mask:
    """Free cells, shape (H, W), without connected groups of fewer than min_cells."""
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free.astype(np.uint8), connectivity=4)
    large = stats[:, cv2.CC_STAT_AREA] >= min_cells
    large[0] = False
    return np.asarray(large[labels])


def _keep_enclosed(added: Mask, certain: Mask, working_grid: WorkingGrid) -> Mask:
    """The groups of cells, shape (H, W), that hardly touch unknown cells that are no floor: furniture seen whole.

    Of the others, such as a shelf whose back was not seen, the notch of the outline is filled later.
    """
    unknown = working_grid.sample(working_grid.grid.unknown)
    _, groups = cv2.connectedComponents(added.astype(np.uint8), connectivity=4)
    beyond = grow_mask(unknown & ~added & ~certain, 1) & added
    length = np.bincount(groups[beyond], minlength=int(groups.max()) + 1) * working_grid.resolution
    # Between sparse rays one large group connects the observed parts of a room
    area = np.bincount(groups.ravel()) * working_grid.resolution**2
    keep = (length < MAX_OPEN_LENGTH) | (area > MAX_FURNITURE_AREA)
    keep[0] = False
    return np.asarray(keep[groups])
