"""The floor cut into pieces at every line where two rooms may meet, and how strongly two pieces belong together."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.layout._label_images import list_contacts, shrink_mask
from pianta.layout._voronoi_doors import compute_clearance
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.evidence import DOOR, OFFSETS, WALL, Evidence, Probabilities
from pianta.layout.structure.necks import Clearance, find_necks
from pianta.layout.structure.regions import cut_into_regions

# The constants were chosen on simulated maps. A piece grows from cells that are less likely a border than this.
SEED_PROBABILITY = 0.35
# Probabilities are kept this far from 0 and 1, so that no single pair of cells decides.
MIN_PROBABILITY = 0.02
# Subtracted from the log odds of one room of each pair of cells, since the network is too sure of it on real maps:
# chosen among 0, 0.5, 0.75, 1 and 1.5 on survey, furniture, clutter and vacuum, each map by a network that its building
# was left out of, and by the number of rooms of three turned maps of survey.
CAUTION = 0.75
# Weight of two pieces that touch, if there is no pair of cells.
TOUCH_WEIGHT = 0.01


@dataclass(frozen=True, eq=False)
class Pieces:
    """The floor, cut into pieces.

    labels: shape (H, W) of the working grid, n > 0 for piece n, 0 no floor. clearance: of the floor, in cells.
    necks: lines from jamb to jamb, shape (N, 2, 2), end, then row and col.
    """

    labels: LabelImage
    clearance: Clearance
    necks: Floats


def cut_into_pieces(space: Mask, evidence: Evidence, parameters: StructureParameters, *, resolution: float) -> Pieces:
    """The floor, shape (H, W), cut at its necks, and along the ridges of the border probability.

    resolution: metres per cell.
    """
    from skimage.measure import label
    from skimage.segmentation import watershed

    clearance = compute_clearance(space)
    necks = find_necks(
        space,
        clearance,
        saddle_ratio=parameters.saddle_ratio,
        mouth_ratio=parameters.mouth_ratio,
        passage_width=parameters.passage_width / resolution,
        merge_distance=parameters.neck_distance / resolution,
    )
    min_clearance = parameters.passage_width / 2 / resolution
    regions = cut_into_regions(space, clearance, necks, min_clearance=min_clearance, resolution=resolution)
    border = evidence.enlarge(find_border_probability(evidence))
    seed_cells = (border < SEED_PROBABILITY) & space
    _, seeds = cv2.connectedComponents(seed_cells.astype(np.uint8), connectivity=4)
    # Cells inside seeds grow nowhere, and are left out for speed
    inner = shrink_mask(seed_cells, 1)
    basins = watershed((border * 255).astype(np.uint8), np.where(inner, 0, seeds), mask=space & ~inner)
    basins = np.where(inner, seeds, basins).astype(np.int64)
    # A cell is in both a region and a basin; either may be 0 in places that are too narrow
    both = basins * (int(regions.labels.max(initial=0)) + 1) + regions.labels
    return Pieces(label(np.where(space, both + 1, 0), connectivity=1).astype(np.int32), clearance, necks)


def find_border_probability(evidence: Evidence) -> Probabilities:
    """Probability that a cell lies between two rooms, on cells of the network, shape (h, w).

    It is in a wall or a doorway, or the cells on both sides of it are not in one room.
    """
    border = evidence.classes[WALL] + evidence.classes[DOOR]
    for (down, right), affinity in zip(OFFSETS[:2], evidence.affinities, strict=False):
        middle = np.zeros_like(border)
        rows, cols = down // 2, right // 2
        middle[rows:, cols:] = 1 - affinity[: affinity.shape[0] - rows, : affinity.shape[1] - cols]
        border = np.maximum(border, middle)
    return np.asarray(border)


def compute_pair_weights(pieces: LabelImage, evidence: Evidence) -> tuple[Indices, Floats, Mask]:
    """Pairs of pieces, shape (P, 2), their weights, positive for one room, and which touch; both shape (P,).

    The weight is the sum of the log odds of one room over all pairs of cells at OFFSETS that are in the two pieces.
    """
    shape = evidence.classes.shape[1:]
    labels = evidence.sample(pieces).astype(np.int64)
    count = int(pieces.max(initial=0)) + 1
    touching, _ = list_contacts(pieces)
    keys, log_odds = [touching[:, 0] * count + touching[:, 1]], [np.full(len(touching), TOUCH_WEIGHT)]
    for (down, right), affinity in zip(OFFSETS, evidence.affinities, strict=True):
        height, width = shape[0] - down, shape[1] - right
        if height <= 0 or width <= 0:
            continue
        one, other = labels[:height, :width], labels[down:, right:]
        apart = (one != other) & (one > 0) & (other > 0)
        one, other = np.minimum(one, other)[apart], np.maximum(one, other)[apart]
        probability = affinity[:height, :width][apart].clip(MIN_PROBABILITY, 1 - MIN_PROBABILITY).astype(float)
        keys.append(one * count + other)
        log_odds.append(np.log(probability / (1 - probability)) - CAUTION)
    unique, index = np.unique(np.concatenate(keys), return_inverse=True)
    weights = np.bincount(index.ravel(), np.concatenate(log_odds), len(unique)).astype(np.float64)
    pairs: Indices = np.column_stack(np.divmod(unique, count)).astype(np.intp)
    return pairs, weights, np.isin(unique, keys[0])
