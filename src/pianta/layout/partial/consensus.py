"""Which cells belong to a partial room, by the network of cells and by all hypotheses together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from pianta._types import Floats, Mask
from pianta.layout._label_images import grow_mask
from pianta.layout.partial.hypotheses import Hypothesis
from pianta.layout.partial.scene import RoomScene, Window, find_bounds

# Both were chosen on real maps of four buildings (VALIDATION of training/partial_maps.py), of which a simulated
# robot explored a part. Weight of the network against the hypotheses.
NETWORK_WEIGHT = 0.8
# Difference of the expected IoU by which a hypothesis has e times the weight of another.
TEMPERATURE = 0.06
# Hypotheses with a smaller share of the weight are left out; a limit of time.
MIN_WEIGHT = 1e-3
# Cells belong to the room if they are more probable than this.
MIN_PROBABILITY = 0.5
# Narrower parts of what is added are left out; metres (chosen by hand).
SLIVER_WIDTH = 0.5
# The observed part, or a hypothesis, whose sides are straight, is taken if its IoU with the probable cells is at least
# this (chosen as the two above).
SAME_IOU = 0.95
# Half a wall; metres (chosen by hand). Hypotheses end at walls, the network's cells in the middle of them.
HALF_WALL = 0.1


def mix_cells(scene: RoomScene, cells: Floats, hypotheses: Sequence[Hypothesis], expected: Floats) -> Floats:
    """The probability that each cell of a scene belongs to the room, shape (H, W).

    cells: the probability by the network. expected: IoU of the hypotheses, shape (N,), by which they are weighted.
    """
    weights = np.exp((expected - expected.max()) / TEMPERATURE)
    weights /= weights.sum()
    mean = np.zeros(scene.observed.shape)
    for weight, hypothesis in zip(weights, hypotheses, strict=True):
        if weight >= MIN_WEIGHT:
            mean[hypothesis.window] += weight * _reach_walls(scene, hypothesis)
    mixed = NETWORK_WEIGHT * cells + (1 - NETWORK_WEIGHT) * mean
    return np.where(scene.observed, 1.0, np.where(scene.others, 0.0, mixed))


@dataclass(frozen=True, eq=False)
class Shape:
    """Cells that a room may have. cells: in a window of the scene. expected_iou: with the true room, 0 … 1.

    reaches_walls: whether they end in the middle of walls, not at their faces.
    """

    cells: Mask
    window: Window
    expected_iou: float
    reaches_walls: bool = False


def choose_shape(scene: RoomScene, hypotheses: Sequence[Hypothesis], probability: Floats) -> Shape:
    """The probable cells; but the observed part, or the most similar hypothesis, if these are nearly the same.

    probability: of each cell of the scene. The first of the hypotheses is the observed part.
    """
    probable = find_probable_cells(scene, probability)
    similarity = np.array([_measure_similarity(scene, probable, each) for each in hypotheses])
    best = 0 if similarity[0] >= SAME_IOU else int(similarity.argmax())
    if similarity[best] < SAME_IOU:
        return probable
    chosen = hypotheses[best]
    return Shape(chosen.cells, chosen.window, expect_iou(probability, _reach_walls(scene, chosen), chosen.window))


def _measure_similarity(scene: RoomScene, probable: Shape, hypothesis: Hypothesis) -> float:
    """IoU of a hypothesis, which reaches walls, with the probable cells; 0 if it is too large for the least one."""
    if np.count_nonzero(hypothesis.cells) * SAME_IOU > np.count_nonzero(probable.cells):
        return 0.0
    return _measure_iou(probable, _reach_walls(scene, hypothesis), hypothesis.window)


def find_probable_cells(scene: RoomScene, probability: Floats) -> Shape:
    """The observed cells, and the probable ones that are joined to them."""
    reach = max(1, round(SLIVER_WIDTH / scene.view.cell / 2))
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    probable = (probability > MIN_PROBABILITY).astype(np.uint8)
    chosen = cv2.morphologyEx(probable, cv2.MORPH_OPEN, square).astype(bool) | scene.observed
    _, parts = cv2.connectedComponents(chosen.astype(np.uint8), connectivity=4)
    chosen = np.isin(parts, np.unique(parts[scene.observed]))
    window = scene.window(find_bounds(chosen))
    return Shape(chosen[window], window, expect_iou(probability, chosen[window], window), reaches_walls=True)


def expect_iou(probability: Floats, cells: Mask, window: Window) -> float:
    """Expected IoU of cells in a window with a room to which each cell of the scene belongs with a probability.

    The IoU of the expected counts: of the room's cells in the window, over those in either of them.
    """
    inside = float(probability[window][cells].sum())
    return inside / max(1.0, float(probability.sum()) + float(np.count_nonzero(cells)) - inside)


def _measure_iou(shape: Shape, cells: Mask, window: Window) -> float:
    """IoU of a shape with cells in a window of the same scene."""
    offsets = [(own.start, own.stop, other.start, other.stop) for own, other in zip(shape.window, window, strict=True)]
    own, other = (
        tuple(slice(max(o[0], o[2]) - o[start], max(min(o[1], o[3]), o[0], o[2]) - o[start]) for o in offsets)
        for start in (0, 2)
    )
    shared = int(np.count_nonzero(shape.cells[own] & cells[other]))
    return shared / max(1, int(np.count_nonzero(shape.cells)) + int(np.count_nonzero(cells)) - shared)


def _reach_walls(scene: RoomScene, hypothesis: Hypothesis) -> Mask:
    """The cells of a hypothesis, grown by half a wall but not into other rooms, in its window."""
    reach = max(1, round(HALF_WALL / scene.view.cell))
    return np.asarray(hypothesis.cells | (grow_mask(hypothesis.cells, reach) & ~scene.others[hypothesis.window]))
