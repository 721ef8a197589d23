"""Rooms by what a laser sees: the feature-based segmentation of the survey (Bormann et al., ICRA 2016).

The survey follows Mozos et al. (ICRA 2005): AdaBoost tells from a scan what kind of place it was taken in, and places
of one kind that hang together are a room.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from json import loads

import numpy as np

from pianta._types import Floats, Mask
from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters, check_parameters
from pianta.layout.rivals.laser import describe_scans, scan_cells
from pianta.layout.rivals.patches import Labels, label_patches, spread_labels
from pianta.models import MODELS

PLACES = ("room", "corridor", "doorway")
DOORWAY = PLACES.index("doorway")
# Scans at a time, which bounds the memory.
BATCH = 4096


@dataclass(frozen=True, kw_only=True)
class FeatureParameters(Parameters):
    """Thresholds of the feature-based segmentation.

    spacing: a scan is taken in one cell of a square of this side; metres (the survey scans every cell).
    smallest: area of the smallest room, m².
    """

    spacing: float = 0.2
    smallest: float = 1.0


@dataclass(frozen=True, eq=False)
class Stumps:
    """A boosted classifier: decision stumps that vote for places.

    feature: shape (S,), name of the feature that each looks at.
    threshold: shape (S,).
    below, above: shape (S,), index in PLACES of what each votes for, up to its threshold and beyond.
    weight: shape (S,), of its vote.
    """

    feature: tuple[str, ...]
    threshold: Floats
    below: Labels
    above: Labels
    weight: Floats

    def vote(self, features: dict[str, Floats]) -> Floats:
        """Votes for each of PLACES, shape (N, 3), given the features of N scans."""
        values = np.stack([features[name] for name in self.feature], axis=1)
        choice = np.where(values <= self.threshold, self.below, self.above)
        return np.stack([(choice == place) @ self.weight for place in range(len(PLACES))], axis=1)


@cache
def load_stumps() -> Stumps:
    """The classifier that comes with pianta, trained by training/train_laser_room_classifier.py on synthetic floors."""
    data = loads((MODELS / "laser_room_classifier.json").read_text(encoding="utf-8"))
    feature, threshold, below, above, weight = zip(*data["stumps"], strict=True)
    return Stumps(feature, np.array(threshold), np.array(below, np.int32), np.array(above, np.int32), np.array(weight))


def segment_by_features(grid: GridMap, *, parameters: Parameters | None = None) -> Labels:
    """Rooms of a grid map, shape (H, W): 0 no room, 1 … N."""
    thresholds = check_parameters(parameters, FeatureParameters)
    # What kind of place the scans were taken in
    cells = choose_cells(grid.free, max(1, round(thresholds.spacing / grid.resolution)))
    batches = np.array_split(cells, len(cells) // BATCH + 1)
    votes = np.concatenate(
        [load_stumps().vote(describe_scans(scan_cells(grid.free, batch, grid.resolution))) for batch in batches]
    )
    scanned = np.zeros(grid.shape, np.int32)
    scanned[tuple(cells.T)] = 1 + votes.argmax(axis=1)
    # Cells without a scan of their own take that of the nearest
    places = spread_labels(scanned, grid.free) - 1
    # Places of one kind that hang together are a room; doorways only divide
    rooms = np.zeros(grid.shape, np.int32)
    for place in range(len(PLACES)):
        patches, areas = label_patches(places == place, grid.resolution)
        is_room = (areas >= thresholds.smallest) & (areas > 0) & (place != DOORWAY)
        rooms += np.where(is_room, rooms.max() + np.cumsum(is_room), 0).astype(np.int32)[patches]
    return spread_labels(rooms, grid.free)


def choose_cells(free: Mask, spacing: int) -> Labels:
    """Row and col of one free cell a square of spacing × spacing cells, the one nearest to its middle; shape (N, 2)."""
    cells = np.argwhere(free)
    square, place = np.divmod(cells, spacing)
    off_middle = np.abs(2 * place - spacing + 1).sum(axis=1)
    order = np.lexsort((off_middle, square[:, 1], square[:, 0]))
    is_first = np.any(np.diff(square[order], axis=0, prepend=-1) != 0, axis=1)
    return np.asarray(cells[order][is_first], np.int32)
