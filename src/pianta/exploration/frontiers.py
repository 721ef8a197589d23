"""Frontiers: free cells of a map at the border to the unknown (Yamauchi, 1997)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Mask
from pianta.gridmap import FREE, UNKNOWN

# Shorter frontiers are gaps between beams, and corners; m. Chosen by hand.
MIN_LENGTH = 0.4
# Longer frontiers are divided, because one target does not stand for all of their cells; m. Chosen by hand.
MAX_LENGTH = 6.0
# A frontier whose cells are all too near to a wall has its target at most this far from them; m. Chosen by hand.
TARGET_DISTANCE = 0.4
# Lengths are sums of cells: this share of a cell is rounding error.
TOLERANCE_PX = 0.01


@dataclass(frozen=True, eq=False)
class Frontier:
    """Adjacent free cells at the border to the unknown.

    cells: row, col, shape (N, 2). target: a cell where a robot can stand, in their middle or close to it.
    length: metres, counting the side of each cell. id: index of the target in the flattened map.
    """

    cells: NDArray[np.int_]
    target: tuple[int, int]
    length: float
    id: int


def find_frontiers(
    cells: NDArray[np.int8],
    reachable: Mask,
    *,
    resolution: float,
    min_length: float = MIN_LENGTH,
    given_up: Mask | None = None,
) -> list[Frontier]:
    """Find the frontiers that a robot can reach, ordered from the top down.

    Cells that touch, also at corners, belong to one frontier.

    cells: shape (H, W), -1 unknown, 0 free, 100 occupied. reachable: shape (H, W), where robots can stand.
    resolution, min_length: metres. given_up: shape (H, W), cells that do not count.
    """
    border = border_cells(cells)
    if given_up is not None:
        border &= ~given_up
    image = border.astype(np.uint8)
    count, labels = cv2.connectedComponents(image, connectivity=8)
    pixels = cv2.findNonZero(image)
    candidates = np.zeros((0, 2), int) if pixels is None else pixels.reshape(-1, 2)[:, ::-1].astype(int)
    groups = labels[candidates[:, 0], candidates[:, 1]]
    order = np.argsort(groups, kind="stable")
    ends = np.cumsum(np.bincount(groups, minlength=count)[1:])
    frontiers = []
    for group in np.split(candidates[order], ends[:-1]):
        for part in _divide_group(group, round(MAX_LENGTH / resolution)):
            length = len(part) * resolution
            if length < min_length - TOLERANCE_PX * resolution:
                continue
            if target := _find_target(part, reachable, round(TARGET_DISTANCE / resolution)):
                frontiers.append(Frontier(part, target, length, target[0] * cells.shape[1] + target[1]))
    return frontiers


def border_cells(cells: NDArray[np.int8]) -> Mask:
    """Free cells, shape (H, W), that share a side with an unknown one."""
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    beside = cv2.dilate((cells == UNKNOWN).astype(np.uint8), cross, borderValue=0)
    return np.asarray((cells == FREE) & (beside > 0))


def count_border(cells: NDArray[np.int8], candidates: NDArray[np.int_]) -> int:
    """Count the candidates, row, col, shape (N, 2), that are free and share a side with an unknown cell."""
    rows, cols = candidates.T
    beside = np.array([(-1, 0), (1, 0), (0, -1), (0, 1)])[:, None, :] + candidates
    beside_rows, beside_cols = np.clip(beside, 0, np.array(cells.shape) - 1).transpose(2, 0, 1)
    unknown = cells[beside_rows, beside_cols] == UNKNOWN
    return int(np.count_nonzero((cells[rows, cols] == FREE) & unknown.any(axis=0)))


def _divide_group(group: NDArray[np.int_], most: int) -> list[NDArray[np.int_]]:
    """Halve a group of cells, shape (N, 2), along its longer side until each part has at most `most` cells."""
    if len(group) <= most:
        return [group] if len(group) else []
    longer = int(np.argmax(np.ptp(group, axis=0)))
    order = np.argsort(group[:, longer], kind="stable")
    return [part for half in np.array_split(group[order], 2) for part in _divide_group(half, most)]


def _find_target(group: NDArray[np.int_], reachable: Mask, reach: int) -> tuple[int, int] | None:
    """The reachable cell nearest to the middle of a group: one of its cells, or one within reach, cells, of them."""
    candidates = group[reachable[group[:, 0], group[:, 1]]]
    if not len(candidates):
        row, col = np.ogrid[-reach : reach + 1, -reach : reach + 1]
        disc = np.argwhere(row**2 + col**2 <= reach**2) - reach
        around = (group[:, None] + disc).reshape(-1, 2)
        around = around[((around >= 0) & (around < reachable.shape)).all(axis=1)]
        candidates = around[reachable[around[:, 0], around[:, 1]]]
    if not len(candidates):
        return None
    distances = np.hypot(*(candidates - group.mean(axis=0)).T)
    row, col = candidates[int(np.argmin(distances.round(6)))].tolist()
    return row, col
