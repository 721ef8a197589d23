"""Doors that may be there but are shut: places in a wall where the network sees a door and no way leads through.

The leaf of a shut door is an obstacle in line with the wall, often in a niche. In the simulated maps from which the
network has learned the cells of such a gap are those of a door (training/lesson_worlds.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from scipy import ndimage
from shapely import LineString

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.floor import Door
from pianta.layout._label_images import grow_mask, list_contacts
from pianta.layout._working_grid import WorkingGrid
from pianta.layout.structure.evidence import Probabilities
from pianta.layout.structure.regions import sample_image


class Thresholds(NamedTuple):
    """Least probabilities of possible doors.

    cell: of each cell. inner, outer: mean of the cells between two rooms, and between a room and what was not seen.
    """

    cell: float
    inner: float
    outer: float


# Chosen by benchmarks/score_possible_doors.py --choose, for few wrong ones; the outer one also by looking at real maps.
THRESHOLDS = Thresholds(cell=0.5, inner=0.6, outer=0.75)
# Least and greatest width of a door with one leaf; metres (chosen by hand: doors are 0.7 to 1.1 m wide, and the width
# of the cells differs from that by up to 0.2 m).
WIDTHS = (0.6, 1.3)
# A door is at least this many times as long as it is thick, else its direction is uncertain (chosen by hand).
MIN_ELONGATION = 1.3
# Its two rooms begin at most this far from its cells; metres (chosen by hand).
ROOM_REACH = 0.4
# Positions along a door at which its sides are looked up, ...
SAMPLES = np.linspace(0.1, 0.9, 9)
# ... and least share of them that are in the room of a side (chosen by hand).
MIN_SIDE_SHARE = 0.5
# At least this share of the positions is blocked by an obstacle, where the leaf is (chosen by hand).
MIN_BLOCKED_SHARE = 0.7
# Another door of its rooms is at least this far away; metres (chosen by hand).
MIN_DISTANCE = 0.5


class Leaf(NamedTuple):
    """Connected cells that are likely a door: row and col of both ends, shape (2, 2), and the extent across; cells."""

    ends: Floats
    thickness: float


def find_possible_doors(
    probability: Probabilities,
    rooms: LabelImage,
    occupied: Mask,
    doors: Sequence[Door],
    working_grid: WorkingGrid,
    *,
    thresholds: Thresholds = THRESHOLDS,
) -> list[Door]:
    """Doors in the map frame that may be there but are shut, with the mean probability of their cells.

    probability: of a door, of each cell. rooms: n > 0 for room n. occupied: cells with an obstacle. All have shape
    (H, W) of the working grid. doors: those that are open, in the map frame, between rooms with these numbers.
    """
    cell = working_grid.resolution
    _, groups = cv2.connectedComponents((probability >= thresholds.cell).astype(np.uint8), connectivity=8)
    unseen = working_grid.sample(working_grid.grid.unknown)
    possible: list[Door] = []
    for number, window in enumerate(ndimage.find_objects(groups), start=1):
        cells = np.argwhere(groups[window] == number) + [axis.start for axis in window]
        weights = probability[tuple(cells.T)].astype(float)
        leaf = fit_leaf(cells, weights)
        if not _is_door(leaf, cell) or not _is_blocked(leaf, occupied) or _leads_through(cells, rooms):
            continue
        one, other = find_sides(leaf, rooms, unseen, reach=leaf.thickness / 2 + ROOM_REACH / cell)
        least = thresholds.inner if one and other else thresholds.outer
        if one is None or other is None or one == other or weights.mean() < least:
            continue
        line = LineString(working_grid.to_map(LineString((leaf.ends[:, ::-1] + 0.5) * cell)))
        pair = max(one, other), min(one, other) or None
        possible.append(Door(pair, line, line.length, probability=float(weights.mean())))
    return [door for door in possible if not _is_near_another(door, doors)]


def fit_leaf(cells: Indices, weights: Floats) -> Leaf:
    """The leaf along the main axis of cells, row and col of shape (N, 2); weights: shape (N,)."""
    middle = np.average(cells, axis=0, weights=weights)
    offsets = cells - middle
    _, axes = np.linalg.eigh((offsets * weights[:, None]).T @ offsets)
    along, across = offsets @ axes[:, 1], offsets @ axes[:, 0]
    # From outer side to outer side of the first and the last cell
    ends = middle + np.outer([along.min() - 0.5, along.max() + 0.5], axes[:, 1])
    return Leaf(ends, float(np.ptp(across)) + 1)


def find_sides(leaf: Leaf, rooms: LabelImage, unseen: Mask, *, reach: float) -> tuple[int | None, int | None]:
    """What is on each side of a leaf: a room, 0 for what was not seen, None for anything else.

    rooms, unseen: shape (H, W). reach: how far from the middle of the leaf a room is looked for; cells.
    """
    positions, across = _sample_leaf(leaf)
    one, other = (_find_side(positions, side * across, rooms, unseen, reach) for side in (1, -1))
    return one, other


def _sample_leaf(leaf: Leaf) -> tuple[Floats, Floats]:
    """Positions along a leaf, row and col, shape (S, 2), and the direction across it, shape (2,)."""
    start, end = leaf.ends
    along = (end - start) / np.hypot(*(end - start))
    return start + SAMPLES[:, None] * (end - start), np.array([-along[1], along[0]])


def _find_side(positions: Floats, across: Floats, rooms: LabelImage, unseen: Mask, reach: float) -> int | None:
    """The room that most positions, row and col of shape (N, 2), have on one side, 0 if it is unseen, else None."""
    nearest = np.zeros(len(positions), np.intp)
    for distance in np.arange(1.0, reach + 1):
        nearest = np.where(nearest == 0, sample_image(rooms, positions + distance * across), nearest)
    counts = np.bincount(nearest, minlength=1)
    room = int(counts.argmax())
    if counts[room] < MIN_SIDE_SHARE * len(positions):
        return None
    is_unseen = sample_image(unseen, positions + reach * across).mean() >= MIN_SIDE_SHARE
    return room if room or is_unseen else None


def _is_door(leaf: Leaf, cell: float) -> bool:
    """Whether a leaf is as wide as a door and long enough to have a direction; cell: metres."""
    length = float(np.hypot(*(leaf.ends[1] - leaf.ends[0])))
    return WIDTHS[0] <= length * cell <= WIDTHS[1] and length >= MIN_ELONGATION * leaf.thickness


def _is_blocked(leaf: Leaf, occupied: Mask) -> bool:
    """Whether obstacles, cells of shape (H, W), stand at most positions along a leaf."""
    positions, across = _sample_leaf(leaf)
    offsets = np.arange(-leaf.thickness / 2, leaf.thickness / 2 + 1)
    hits = sample_image(occupied, positions[:, None] + offsets[:, None] * across).any(axis=1)
    return bool(hits.mean() >= MIN_BLOCKED_SHARE)


def _leads_through(cells: Indices, rooms: LabelImage) -> bool:
    """Whether two rooms touch in or beside the cells, row and col of shape (N, 2)."""
    low = np.maximum(cells.min(axis=0) - 1, 0)
    around = rooms[tuple(map(slice, low, cells.max(axis=0) + 2))]
    mask = np.zeros(around.shape, bool)
    mask[tuple((cells - low).T)] = True
    pairs, _ = list_contacts(np.where(grow_mask(mask, 1), around, 0))
    return len(pairs) > 0


def _is_near_another(door: Door, doors: Sequence[Door]) -> bool:
    """Whether one of the doors joins the same rooms, near this one."""
    return any(door.rooms == other.rooms and door.line.distance(other.line) < MIN_DISTANCE for other in doors)
