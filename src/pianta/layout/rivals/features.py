"""Feature-based segmentation of the survey (Bormann et al., ICRA 2016): rooms by simulated laser scans.

The survey follows Mozos et al. (ICRA 2005): AdaBoost predicts the class of a place from a scan taken there, and
connected cells of one class are a room.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from json import loads
from math import tau

import numpy as np

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters, check_parameters
from pianta.layout.rivals.patches import grow_labels, label_patches, measure_padded_clearance
from pianta.models import MODELS

PLACE_CLASSES = ("room", "corridor", "doorway")
DOORWAY = PLACE_CLASSES.index("doorway")
# Scans that are simulated at a time; a limit of memory.
BATCH = 4096

# The constants of a scan belong to the features that the classifier was trained on (chosen by hand).
# Beams of a scan, evenly over 360°.
BEAMS = 180
# Difference between two neighbouring beams that counts as a gap; metres.
GAP = 0.5
# The same as a share of the longer beam.
RELATIVE_GAP = 0.5
# Lengths to which beams are cut, for features of the near surroundings; metres.
NEAR_LIMITS = (2.0, 5.0)


@dataclass(frozen=True, kw_only=True)
class FeatureParameters(Parameters):
    """Thresholds of the feature-based segmentation; chosen on the survey's maps (docs/methods/segmentation.md).

    spacing: a scan is taken in one cell of each square of this side; metres (the survey scans every cell).
    smallest: area of the smallest room; m².
    """

    spacing: float = 0.2
    smallest: float = 1.0


@dataclass(frozen=True, eq=False)
class PlaceClassifier:
    """Gives a place a class of PLACE_CLASSES, from the features of a laser scan: boosted decision stumps that vote.

    feature: shape (S,), name of the feature of each stump.
    threshold: shape (S,).
    below, above: shape (S,), index in PLACE_CLASSES of the vote up to the threshold, and above it.
    weight: shape (S,), of the vote.
    """

    feature: tuple[str, ...]
    threshold: Floats
    below: Indices
    above: Indices
    weight: Floats

    def vote(self, features: dict[str, Floats]) -> Floats:
        """Votes for each of PLACE_CLASSES, shape (N, 3), given the features of N scans."""
        values = np.stack([features[name] for name in self.feature], axis=1)
        choice = np.where(values <= self.threshold, self.below, self.above)
        return np.stack([(choice == number) @ self.weight for number in range(len(PLACE_CLASSES))], axis=1)


@cache
def load_place_classifier() -> PlaceClassifier:
    """The classifier of places that comes with pianta.

    It was trained by training/train_laser_room_classifier.py on synthetic floors.
    """
    data = loads((MODELS / "laser_room_classifier.json").read_text(encoding="utf-8"))
    feature, threshold, below, above, weight = zip(*data["stumps"], strict=True)
    return PlaceClassifier(
        feature, np.array(threshold), np.array(below, np.intp), np.array(above, np.intp), np.array(weight)
    )


def segment_by_features(grid: GridMap, *, parameters: Parameters | None = None) -> LabelImage:
    """Segment a grid map into rooms; returns a label image, shape (H, W): 0 no room, 1 … N.

    A classifier gives each place a class of PLACE_CLASSES from a simulated laser scan; rooms are connected patches of
    one class.
    """
    thresholds = check_parameters(parameters, FeatureParameters)
    # Classify scans
    cells = choose_cells(grid.free, max(1, round(thresholds.spacing / grid.resolution)))
    batches = np.array_split(cells, len(cells) // BATCH + 1)
    votes = np.concatenate(
        [
            load_place_classifier().vote(describe_scans(scan_cells(grid.free, batch, grid.resolution)))
            for batch in batches
        ]
    )
    scanned = np.zeros(grid.shape, np.int32)
    scanned[tuple(cells.T)] = 1 + votes.argmax(axis=1)
    # Cells without a scan get the class of the nearest one
    class_of_cell = grow_labels(scanned, grid.free) - 1
    # Connected cells of one class are a room; doorways only divide
    rooms = np.zeros(grid.shape, np.int32)
    for number in range(len(PLACE_CLASSES)):
        patches, areas = label_patches(class_of_cell == number, grid.resolution)
        is_room = (areas >= thresholds.smallest) & (areas > 0) & (number != DOORWAY)
        rooms += np.where(is_room, rooms.max() + np.cumsum(is_room), 0).astype(np.int32)[patches]
    return grow_labels(rooms, grid.free)


def choose_cells(free: Mask, spacing: int) -> Indices:
    """Row and col of one free cell per square of spacing × spacing cells, the nearest to its middle; shape (N, 2)."""
    cells = np.argwhere(free)
    square, offset = np.divmod(cells, spacing)
    off_middle = np.abs(2 * offset - spacing + 1).sum(axis=1)
    order = np.lexsort((off_middle, square[:, 1], square[:, 0]))
    is_first = np.any(np.diff(square[order], axis=0, prepend=-1) != 0, axis=1)
    return np.asarray(cells[order][is_first], np.intp)


def scan_cells(free: Mask, cells: Indices, resolution: float) -> Floats:
    """Lengths of BEAMS beams from each cell (row, col) to the first cell that is not free; metres, shape (N, BEAMS)."""
    clearance = np.pad(measure_padded_clearance(free), 1).astype(np.float32)
    angle = tau * np.arange(BEAMS) / BEAMS
    down, right = np.sin(angle).astype(np.float32), np.cos(angle).astype(np.float32)
    lengths = np.zeros((len(cells), BEAMS), np.float32)
    going = np.arange(lengths.size)
    starts = cells.astype(np.float32) + 1.5
    while len(going):
        cell, beam = np.divmod(going, BEAMS)
        length = lengths.ravel()[going]
        row = starts[cell, 0] + down[beam] * length
        col = starts[cell, 1] + right[beam] * length
        clear = clearance[row.astype(np.intp), col.astype(np.intp)]
        # Nothing blocks the beam within the clearance, less the diagonal of a cell.
        lengths.ravel()[going] += np.where(clear > 0, np.maximum(clear - 1.5, 0.5), 0)
        going = going[clear > 0]
    return lengths.astype(np.float64) * resolution


def describe_scans(lengths: Floats) -> dict[str, Floats]:
    """Features of scans, shape (N, BEAMS), by name, each of shape (N,); independent of the orientation of the robot."""
    beside = np.roll(lengths, -1, axis=1)
    steps = np.abs(beside - lengths)
    features = {"mean length": lengths.mean(axis=1), "deviation of length": lengths.std(axis=1)}
    features |= {"mean step": steps.mean(axis=1), "deviation of steps": steps.std(axis=1)}
    for limit in NEAR_LIMITS:
        cut = np.minimum(lengths, limit)
        features[f"mean length to {limit:g} m"] = cut.mean(axis=1)
        features[f"mean step to {limit:g} m"] = np.abs(np.roll(cut, -1, axis=1) - cut).mean(axis=1)
        features[f"deviation of length to {limit:g} m"] = cut.std(axis=1)
    longer = np.maximum(np.maximum(lengths, beside), 1e-6)
    features["gaps"] = (steps > GAP).sum(axis=1).astype(float)
    features["relative gaps"] = (steps > RELATIVE_GAP * longer).sum(axis=1).astype(float)
    features["mean ratio of beams"] = (np.minimum(lengths, beside) / longer).mean(axis=1)
    features["median to longest"] = np.median(lengths, axis=1) / np.maximum(lengths.max(axis=1), 1e-6)
    return features | _describe_minima(lengths) | _describe_outlines(lengths)


def _describe_minima(lengths: Floats) -> dict[str, Floats]:
    """The nearest obstacle, and the nearest one on the opposite side: the two walls of a passage."""
    scans = np.arange(len(lengths))
    first = lengths.argmin(axis=1)
    away = (np.arange(BEAMS) - first[:, None]) % BEAMS
    other_side = np.abs(away - BEAMS / 2) <= BEAMS / 4
    second = np.where(other_side, lengths, np.inf).argmin(axis=1)
    near, far = lengths[scans, first], lengths[scans, second]
    turn = tau * np.abs(away[scans, second] - BEAMS / 2) / BEAMS
    across = near + far
    # Length of the view along the passage
    along = lengths[scans, (first + BEAMS // 4) % BEAMS] + lengths[scans, (first - BEAMS // 4) % BEAMS]
    return {
        "shortest beam": near,
        "width": across,
        "angle off opposite": turn,
        "length of view": along,
        "length to width": along / np.maximum(across, 1e-6),
    }


def _describe_outlines(lengths: Floats) -> dict[str, Floats]:
    """The shape of the polygon that joins the ends of the beams."""
    angle = tau * np.arange(BEAMS) / BEAMS
    ends = lengths * np.exp(1j * angle)
    following = np.roll(ends, -1, axis=1)
    area = np.maximum((ends.conj() * following).imag.sum(axis=1) / 2, 1e-6)
    perimeter = np.maximum(np.abs(following - ends).sum(axis=1), 1e-6)
    from_centre = ends - ends.mean(axis=1, keepdims=True)
    reach = np.abs(from_centre)
    # Axes of the ellipse with the same second moments
    spread, lean = (reach**2).mean(axis=1), np.abs((from_centre**2).mean(axis=1))
    major, minor = np.sqrt(spread + lean), np.sqrt(np.maximum(spread - lean, 0))
    return {
        "area": area,
        "perimeter": perimeter,
        "compactness": area / perimeter**2,
        "mean reach": reach.mean(axis=1),
        "deviation of reach": reach.std(axis=1),
        "relative deviation of reach": reach.std(axis=1) / np.maximum(reach.mean(axis=1), 1e-6),
        "major axis": major,
        "minor axis": minor,
        "elongation": minor / np.maximum(major, 1e-6),
    }
