"""The regions of a plan as the map that the layout method takes, with the doors remembered and their gaps closed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.plan.walls.inside import find_inside, grow_labels
from pianta.plan.walls.regions import DOOR, DOOR_CELLS, INSIDE, OUTSIDE, WALL, Regions

# The map of a floor is drawn finer than the regions by this factor.
FINER = 2
# A barrier is wall by more than this probability; where doors are closed, that of a door counts by this share.
BARRIER, DOOR_SHARE = 0.55, 0.5
# Gaps in barriers are closed where they are so short, metres, and a wall has this probability.
LONGEST_GAP, WEAK = 0.6, 0.45
# Shorter pieces of barriers are none, metres.
SHORTEST_WALL = 0.6
# Shorter walls that end in a room are furniture, metres; what is so near to another line touches it, cells.
SHORTEST_STUB, TOUCHING = 1.2, 5
# The two lines of a wall are no further apart than this; metres of a door.
THICKEST, DOOR_METRES = 0.4, 0.9
# The middle of a wall is no farther from its room than this, metres.
FARTHEST = 2.0


@dataclass(frozen=True, eq=False)
class FloorMap:
    """A map of the floors on a sheet, in metres with y up and the origin in the lower left corner of the sheet.

    grid: walls occupied, outside unknown. inside: shape (H, W) of the grid. resolution: metres per pixel of the sheet.
    height: of the sheet, metres.
    """

    grid: GridMap
    inside: Mask
    resolution: float
    height: float


def draw_floor_map(
    regions: Regions,
    doors: Floats,
    *,
    sheet_shape: tuple[int, int],
    resolution: float,
    sweeps: Sequence[Floats] = (),
) -> FloorMap:
    """The map of the floors on a sheet: thin walls along the middle of what is wall, gaps at doors closed.

    doors: shape (D, 2, 2), from jamb to jamb, row and col in pixels of the sheet. sheet_shape: its rows and columns.
    resolution: metres per pixel of the sheet. sweeps: corners of what leaves of doors sweep, each shape (N, 2), row and
    col in pixels of the sheet; no wall stands there.
    """
    cell_px = regions.cell_px / FINER
    shape = tuple(max(1, round(side / cell_px)) for side in sheet_shape)
    layers = [cv2.resize(layer, shape[::-1], interpolation=cv2.INTER_LINEAR) for layer in regions.probabilities]
    cell = cell_px * resolution
    # Doors are closed where the network sees them, and by lines from jamb to jamb
    barrier = layers[WALL] + DOOR_SHARE * layers[DOOR] if len(doors) else layers[WALL].copy()
    for corners in sweeps:
        cv2.fillConvexPoly(barrier, np.rint(corners[:, ::-1] / cell_px - 0.5).astype(np.int32), 0.0)
    for ends in doors / cell_px - 0.5:
        (row0, col0), (row1, col1) = np.rint(ends).astype(int).tolist()
        cv2.line(barrier, (col0, row0), (col1, row1), 1.0, 2)
    barrier = _close_gaps(barrier, longest=max(1, round(LONGEST_GAP / cell)))
    # What removed symbols leave of lines is too small for a wall
    barrier = _erode(barrier, least=SHORTEST_WALL / cell)
    # A gap in an outer wall, or a yard, makes no room
    inside = find_inside(barrier < BARRIER, layers[OUTSIDE] - layers[INSIDE], cell)
    # Rooms grow to the middle of the walls, which become lines; what is far from all rooms stays outside
    near = _frame(inside, margin=round(FARTHEST / cell))
    walls, grown = np.zeros(shape, bool), np.zeros(shape, bool)
    walls[near], grown[near] = _thin_barriers(barrier[near], inside[near], least=SHORTEST_STUB / cell)
    cells = np.where(walls, np.int8(OCCUPIED), np.where(grown, np.int8(FREE), np.int8(UNKNOWN)))
    height = sheet_shape[0] * resolution
    return FloorMap(GridMap(cells, cell, (0.0, height - shape[0] * cell, 0.0)), grown, resolution, height)


def trust_walls(regions: Regions, walls: Mask) -> Regions:
    """Regions in which wall is what the file of a plan calls wall, shape (H, W) of the sheet, and nothing else.

    Between the two lines of a wall is wall, too.
    """
    height, width = regions.probabilities.shape[1:]
    thickest = max(3, round(THICKEST / DOOR_METRES * DOOR_CELLS * regions.cell_px)) | 1
    filled = cv2.morphologyEx(walls.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((thickest, thickest), np.uint8))
    share = cv2.resize(filled.astype(np.float32), (width, height), interpolation=cv2.INTER_AREA)
    wall = np.minimum(share * 2, 1)
    others = regions.probabilities.copy()
    others[WALL] = 0
    others *= (1 - wall) / np.maximum(others.sum(axis=0), 1e-6)
    others[WALL] = wall
    return Regions(others, regions.cell_px)


def _close_gaps(barrier: NDArray[np.float32], *, longest: int) -> NDArray[np.float32]:
    """The barriers with short gaps along rows and columns closed, cells, where something like a wall is."""
    strong = (barrier >= BARRIER).astype(np.uint8)
    closed = np.zeros_like(strong)
    for line in (np.ones((1, longest), np.uint8), np.ones((longest, 1), np.uint8)):
        closed |= np.asarray(cv2.morphologyEx(strong, cv2.MORPH_CLOSE, line), np.uint8)
    return np.where((closed > 0) & (barrier >= WEAK), np.maximum(barrier, np.float32(BARRIER)), barrier)


def _erode(barrier: NDArray[np.float32], *, least: float) -> NDArray[np.float32]:
    """The barriers without pieces that are shorter than least, cells, in both directions."""
    _, pieces, stats, _ = cv2.connectedComponentsWithStats((barrier >= BARRIER).astype(np.uint8), connectivity=8)
    small = np.maximum(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT]) < least
    small[0] = False
    return np.where(small[pieces], np.float32(0), barrier)


def _thin_barriers(barrier: NDArray[np.float32], inside: Mask, *, least: float) -> tuple[Mask, Mask]:
    """Barriers as lines along their highest places, and the rooms grown up to them; shapes (H, W).

    Where a barrier parts no patches, as a wall that ends in a room, its line is the skeleton, when that is as long as
    least, cells: what is shorter stands along a wall, as furniture does.
    """
    from skimage.morphology import skeletonize

    blocked = barrier >= BARRIER
    count, patches = cv2.connectedComponents(inside.view(np.uint8), connectivity=4)
    beyond = count
    basins = grow_labels(barrier, np.where(blocked | inside, patches, beyond), np.ones_like(inside))
    grown = (basins != beyond) & (basins > 0)
    lines = np.zeros(grown.shape, bool)
    lines[1:] |= basins[1:] != basins[:-1]
    lines[:, 1:] |= basins[:, 1:] != basins[:, :-1]
    near = _widen(lines, TOUCHING)
    skeleton = skeletonize(blocked) & grown
    _, numbers, stats, _ = cv2.connectedComponentsWithStats((skeleton & ~near).view(np.uint8), connectivity=8)
    long = stats[:, cv2.CC_STAT_AREA] >= least
    long[0] = False
    ends = long[numbers]
    lines |= ends | (skeleton & near & _widen(ends, TOUCHING + 2))
    # Two cells wide, so that no way leads through between diagonal neighbours
    return _widen(lines, 2), grown


def _frame(mask: Mask, *, margin: int) -> tuple[slice, slice]:
    """Rows and columns of what is so near to a mask, cells."""
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    return slice(max(0, top - margin), top + height + margin), slice(max(0, left - margin), left + width + margin)


def _widen(mask: Mask, cells: int) -> Mask:
    return cv2.dilate(mask.astype(np.uint8), np.ones((cells, cells), np.uint8)) > 0
