"""The segmented plan as the map that the layout method takes: thin walls, and the gaps of doors closed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.plan.sheets.sheet import DOOR_WIDTH
from pianta.plan.walls.indoor_mask import grow_labels, indoor_mask
from pianta.plan.walls.segmentation import DOOR, DOOR_CELLS, INSIDE, OUTSIDE, WALL, ClassMap

# Cells of the map per cell of the class map, along each side
FINER = 2


@dataclass(frozen=True, kw_only=True)
class FloorMapParameters:
    """Thresholds of `draw_floor_map` and `use_named_walls`. Chosen by hand, no fit is on record."""

    barrier: float = 0.55  # probability of a wall from which on a cell is a barrier
    door_share: float = 0.5  # of the probability of a door, which adds to that of a wall where doors are closed
    longest_gap: float = 0.6  # m: longer gaps in barriers stay
    gap_barrier: float = 0.45  # probability of a wall from which on a gap is closed
    min_wall_length: float = 0.6  # m: shorter barriers are dropped, as what symbols leave of lines
    min_stub_length: float = 1.2  # m: shorter walls that end in a room are furniture along a wall
    touching_cells: int = 5  # cells between a stub and the line that it touches
    max_wall_thickness: float = 0.4  # m between the two lines of a wall that the file names
    max_half_wall: float = 2.0  # m from a room to the middle of its wall


PARAMETERS = FloorMapParameters()


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
    class_map: ClassMap,
    doors: Floats,
    *,
    sheet_shape: tuple[int, int],
    resolution: float,
    sweeps: Sequence[Floats] = (),
) -> FloorMap:
    """The map of the floors on a sheet: thin walls along the middle of barriers, gaps at doors closed.

    doors: shape (D, 2, 2), from jamb to jamb, row and col in pixels of the sheet. sheet_shape: its rows and columns.
    resolution: metres per pixel of the sheet. sweeps: corners of what leaves of doors sweep, each shape (N, 2), row and
    col in pixels of the sheet; no wall stands there.
    """
    p = PARAMETERS
    cell_px = class_map.cell_px / FINER
    shape = tuple(max(1, round(side / cell_px)) for side in sheet_shape)
    layers = [cv2.resize(layer, shape[::-1], interpolation=cv2.INTER_LINEAR) for layer in class_map.probabilities]
    cell = cell_px * resolution
    # Doors are closed where the network sees them, and by lines from jamb to jamb
    barrier = layers[WALL] + p.door_share * layers[DOOR] if len(doors) else layers[WALL].copy()
    for corners in sweeps:
        cv2.fillConvexPoly(barrier, np.rint(corners[:, ::-1] / cell_px - 0.5).astype(np.int32), 0.0)
    for ends in doors / cell_px - 0.5:
        (row0, col0), (row1, col1) = np.rint(ends).astype(int).tolist()
        cv2.line(barrier, (col0, row0), (col1, row1), 1.0, 2)
    barrier = _close_gaps(barrier, longest=max(1, round(p.longest_gap / cell)))
    barrier = _drop_short(barrier, least=p.min_wall_length / cell)
    # A gap in an outer wall, or a yard, makes no room
    inside = indoor_mask(barrier < p.barrier, layers[OUTSIDE] - layers[INSIDE], cell)
    # Rooms grow to the middle of the walls, which become lines; what is far from all rooms stays outside
    near = _frame(inside, margin=round(p.max_half_wall / cell))
    walls, grown = np.zeros(shape, bool), np.zeros(shape, bool)
    walls[near], grown[near] = _thin_barriers(barrier[near], inside[near], least=p.min_stub_length / cell)
    cells = np.where(walls, np.int8(OCCUPIED), np.where(grown, np.int8(FREE), np.int8(UNKNOWN)))
    height = sheet_shape[0] * resolution
    return FloorMap(GridMap(cells, cell, (0.0, height - shape[0] * cell, 0.0)), grown, resolution, height)


def use_named_walls(class_map: ClassMap, walls: Mask) -> ClassMap:
    """The class map with the walls that the file of a plan names, shape (H, W) of the sheet, and no others.

    The space between the two lines of a wall is wall, too.
    """
    height, width = class_map.probabilities.shape[1:]
    thickest = max(3, round(PARAMETERS.max_wall_thickness / DOOR_WIDTH * DOOR_CELLS * class_map.cell_px)) | 1
    filled = cv2.morphologyEx(walls.astype(np.uint8), cv2.MORPH_CLOSE, np.ones((thickest, thickest), np.uint8))
    share = cv2.resize(filled.astype(np.float32), (width, height), interpolation=cv2.INTER_AREA)
    wall = np.minimum(share * 2, 1)
    probabilities = class_map.probabilities.copy()
    probabilities[WALL] = 0
    probabilities *= (1 - wall) / np.maximum(probabilities.sum(axis=0), 1e-6)
    probabilities[WALL] = wall
    return ClassMap(probabilities, class_map.cell_px)


def _close_gaps(barrier: NDArray[np.float32], *, longest: int) -> NDArray[np.float32]:
    """The barriers with gaps along rows and columns closed, up to a length, cells, where a wall is not unlikely."""
    strong = (barrier >= PARAMETERS.barrier).astype(np.uint8)
    closed = np.zeros_like(strong)
    for line in (np.ones((1, longest), np.uint8), np.ones((longest, 1), np.uint8)):
        closed |= np.asarray(cv2.morphologyEx(strong, cv2.MORPH_CLOSE, line), np.uint8)
    is_gap = (closed > 0) & (barrier >= PARAMETERS.gap_barrier)
    return np.where(is_gap, np.maximum(barrier, np.float32(PARAMETERS.barrier)), barrier)


def _drop_short(barrier: NDArray[np.float32], *, least: float) -> NDArray[np.float32]:
    """The barriers without pieces that are shorter than least, cells, in both directions."""
    strong = (barrier >= PARAMETERS.barrier).astype(np.uint8)
    _, pieces, stats, _ = cv2.connectedComponentsWithStats(strong, connectivity=8)
    short = np.maximum(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT]) < least
    short[0] = False
    return np.where(short[pieces], np.float32(0), barrier)


def _thin_barriers(barrier: NDArray[np.float32], inside: Mask, *, least: float) -> tuple[Mask, Mask]:
    """Barriers as lines along their highest cells, and the rooms grown up to them; shapes (H, W).

    Where a barrier separates no patches, as a wall that ends in a room, its line is the skeleton, if that is at least
    as long as least, cells.
    """
    from skimage.morphology import skeletonize

    blocked = barrier >= PARAMETERS.barrier
    count, patches = cv2.connectedComponents(inside.view(np.uint8), connectivity=4)
    beyond = count
    basins = grow_labels(barrier, np.where(blocked | inside, patches, beyond), np.ones_like(inside))
    grown = (basins != beyond) & (basins > 0)
    lines = np.zeros(grown.shape, bool)
    lines[1:] |= basins[1:] != basins[:-1]
    lines[:, 1:] |= basins[:, 1:] != basins[:, :-1]
    near = _dilate(lines, PARAMETERS.touching_cells)
    skeleton = skeletonize(blocked) & grown
    _, numbers, stats, _ = cv2.connectedComponentsWithStats((skeleton & ~near).view(np.uint8), connectivity=8)
    long = stats[:, cv2.CC_STAT_AREA] >= least
    long[0] = False
    stubs = long[numbers]
    lines |= stubs | (skeleton & near & _dilate(stubs, PARAMETERS.touching_cells + 2))
    # Two cells wide, so that no way leads through between diagonal neighbours
    return _dilate(lines, 2), grown


def _frame(mask: Mask, *, margin: int) -> tuple[slice, slice]:
    """Rows and columns of a mask with a margin, cells."""
    left, top, width, height = cv2.boundingRect(mask.view(np.uint8))
    return slice(max(0, top - margin), top + height + margin), slice(max(0, left - margin), left + width + margin)


def _dilate(mask: Mask, cells: int) -> Mask:
    return cv2.dilate(mask.astype(np.uint8), np.ones((cells, cells), np.uint8)) > 0
