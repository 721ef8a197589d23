"""Frontiers: where known free space borders on the unknown (Yamauchi, 1997)."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Mask
from pianta.gridmap import FREE, UNKNOWN

# Shorter frontiers are slits between beams, and corners; longer ones are divided: no place is in the middle of them. m.
MIN_LENGTH, MAX_LENGTH = 0.4, 6.0
# A frontier along a wall is reached from so far beside it; m.
ARM = 0.4


@dataclass(frozen=True, eq=False)
class Frontier:
    """Free cells next to each other that border on the unknown.

    cells: row, col, shape (N, 2). target: a cell where a robot can stand, in their middle or close to it.
    length: metres, a cell counted as its side. id: of the target, the same while the frontier is.
    """

    cells: NDArray[np.int_]
    target: tuple[int, int]
    length: float
    id: int


def find_frontiers(
    known: NDArray[np.int8],
    reachable: Mask,
    *,
    resolution: float,
    min_length: float = MIN_LENGTH,
    given_up: Mask | None = None,
) -> list[Frontier]:
    """Frontiers that a robot can reach, from the top down.

    Cells that touch, also at corners, belong together; groups longer than 6 m are divided.

    known: shape (H, W), -1 unknown, 0 free, 100 occupied. reachable: shape (H, W), where robots can come to stand.
    resolution, min_length: metres. given_up: shape (H, W), cells that are no frontier any more.
    """
    edge = border_cells(known)
    if given_up is not None:
        edge &= ~given_up
    image = edge.astype(np.uint8)
    count, labels = cv2.connectedComponents(image, connectivity=8)
    found = cv2.findNonZero(image)
    cells = np.zeros((0, 2), int) if found is None else found.reshape(-1, 2)[:, ::-1].astype(int)
    groups = labels[cells[:, 0], cells[:, 1]]
    order = np.argsort(groups, kind="stable")
    ends = np.cumsum(np.bincount(groups, minlength=count)[1:])
    frontiers = []
    reach = round(ARM / resolution)
    groups_of_cells = np.split(cells[order], ends[:-1])
    parts = (part for group in groups_of_cells for part in _divide_group(group, round(MAX_LENGTH / resolution)))
    for group in parts:
        length = len(group) * resolution
        # A hundredth of a cell less: lengths are sums of cells.
        if length >= min_length - resolution / 100 and (target := _find_target(group, reachable, reach)):
            frontiers.append(Frontier(group, target, length, target[0] * known.shape[1] + target[1]))
    return frontiers


def border_cells(known: NDArray[np.int8]) -> Mask:
    """Free cells, shape (H, W), that share a side with an unknown one."""
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    beside = cv2.dilate((known == UNKNOWN).astype(np.uint8), cross, borderValue=0)
    return np.asarray((known == FREE) & (beside > 0))


def count_border(known: NDArray[np.int8], cells: NDArray[np.int_]) -> int:
    """How many of the cells, shape (N, 2), still are free and share a side with an unknown one."""
    rows, cols = cells.T
    beside = np.array([(-1, 0), (1, 0), (0, -1), (0, 1)])[:, None, :] + cells
    beside_rows, beside_cols = np.clip(beside, 0, np.array(known.shape) - 1).transpose(2, 0, 1)
    unknown = known[beside_rows, beside_cols] == UNKNOWN
    return int(np.count_nonzero((known[rows, cols] == FREE) & unknown.any(axis=0)))


def _divide_group(group: NDArray[np.int_], most: int) -> list[NDArray[np.int_]]:
    """Parts of a group of cells, shape (N, 2), that have no more than so many: halves along its longer side."""
    if len(group) <= most:
        return [group] if len(group) else []
    longer = int(np.argmax(np.ptp(group, axis=0)))
    order = np.argsort(group[:, longer], kind="stable")
    return [part for half in np.array_split(group[order], 2) for part in _divide_group(half, most)]


def _find_target(group: NDArray[np.int_], reachable: Mask, reach: int) -> tuple[int, int] | None:
    """The reachable cell nearest to the middle of a group, of its own cells or else of those within reach of them."""
    standing = group[reachable[group[:, 0], group[:, 1]]]
    if not len(standing):
        row, col = np.ogrid[-reach : reach + 1, -reach : reach + 1]
        disc = np.argwhere(row**2 + col**2 <= reach**2) - reach
        around = (group[:, None] + disc).reshape(-1, 2)
        around = around[((around >= 0) & (around < reachable.shape)).all(axis=1)]
        standing = around[reachable[around[:, 0], around[:, 1]]]
    if not len(standing):
        return None
    away = np.hypot(*(standing - group.mean(axis=0)).T)
    row, col = standing[int(np.argmin(away.round(6)))].tolist()
    return row, col
