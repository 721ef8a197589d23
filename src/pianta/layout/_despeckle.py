"""Noise of single cells of a map, which would move borders of rooms."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Mask
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN

Cells = NDArray[np.int8]

# The constants were chosen by hand. The eight neighbours of a cell by their bits, clockwise from the top left.
NEIGHBOUR_BITS = np.array([[1, 2, 4], [128, 0, 8], [64, 32, 16]], np.float32)
# The three neighbours above, to the right, below and to the left.
SIDES = (0b111, 0b11100, 0b1110000, 0b11000001)
# An obstacle with no other beside it is noise if at least this number of its neighbours are alike.
MIN_ALIKE = 7
# Free groups of at most this number of cells are noise.
MAX_GROUP = 4


def despeckle(cells: Cells) -> Cells:
    """The cells FREE, OCCUPIED and UNKNOWN without noise of single ones; both of shape (H, W).

    A cell is noise if it differs from all cells around it, or from all but the three on one side of it, as a bump does.
    It becomes what most of the others are. Obstacles at the end of a line are no noise, nor are those between free and
    unknown space, since a wall may be seen by single beams. Free cells in a wall become a part of the wall. Furniture
    and walls of two cells and more stay.
    """
    free, occupied, unknown = cells == FREE, cells == OCCUPIED, cells == UNKNOWN
    # Beyond the map is unknown space
    framed = np.pad(free, 1), np.pad(occupied, 1), np.pad(unknown, 1, constant_values=True)
    free_around, occupied_around, unknown_around = map(_find_neighbours, framed)
    near_free, near_occupied, near_unknown = (
        cv2.LUT(around, COUNT) for around in (free_around, occupied_around, unknown_around)
    )
    clean = cells.copy()
    # Each cell is compared with the cells of the map, not with those that were changed before
    single = occupied & (near_occupied == 0)
    bump = occupied & _apply_table(occupied_around, ON_ONE_SIDE) & (near_occupied >= 2)
    clean[(single & (near_free >= MIN_ALIKE)) | (bump & (near_free >= 5))] = FREE
    clean[(single & (near_unknown >= MIN_ALIKE)) | (bump & (near_unknown >= 5))] = UNKNOWN
    clean[unknown & (near_unknown == 0) & (near_free >= MIN_ALIKE)] = FREE
    bump = (free & _apply_table(free_around, ON_ONE_SIDE)) | _find_small_groups(free)
    in_wall = (near_occupied >= near_unknown) | _apply_table(occupied_around, OPPOSITE)
    clean[bump & in_wall] = OCCUPIED
    clean[bump & ~in_wall] = UNKNOWN
    return clean


def _find_neighbours(mask: Mask) -> NDArray[np.uint8]:
    """Which neighbours of each inner cell of a mask, shape (H + 2, W + 2), are in it: bits, shape (H, W)."""
    bits = cv2.filter2D(mask.astype(np.uint8), cv2.CV_8U, NEIGHBOUR_BITS, borderType=cv2.BORDER_CONSTANT)
    return np.ascontiguousarray(bits[1:-1, 1:-1])


def _apply_table(codes: NDArray[np.uint8], table: NDArray[np.uint8]) -> Mask:
    return np.asarray(cv2.LUT(codes, table), bool)


def _find_small_groups(mask: Mask) -> Mask:
    """8-connected groups of few cells, shape (H, W)."""
    _, groups, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=8)
    small = stats[:, cv2.CC_STAT_AREA] <= MAX_GROUP
    small[0] = False
    return np.asarray(small[groups])


_CODES = np.arange(256)
# By the bits of the neighbours: their number, whether all are on one side, and whether two are opposite each other.
COUNT = np.array([bin(code).count("1") for code in _CODES], np.uint8)
ON_ONE_SIDE = np.array([any(code & ~side == 0 for side in SIDES) for code in _CODES], np.uint8)
OPPOSITE = np.array((_CODES & (_CODES >> 4) & 0b1111) > 0, np.uint8)
