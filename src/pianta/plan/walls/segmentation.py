"""Which spots of a plan are inside of rooms, wall, door or outside, by a convolutional network.

Section 3.3 of the thesis finds walls by a threshold, because its plans have thick ones. Other plans have lines of
every weight among furniture, hatching, dimensions and text, which no threshold separates; a small U-Net (Ronneberger
et al., 2015), trained on plans with their true layouts, does (docs/methods/plans.md).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Colors
from pianta.models import MODELS
from pianta.plan.network import run_network
from pianta.plan.sheets.binarization import compare_to_paper, invert_if_dark, max_channel, min_channel

Probabilities = NDArray[np.float32]

# The classes of the network, in its order
CLASSES = INSIDE, WALL, DOOR, OUTSIDE = range(4)
DOOR_CELLS = 8.0  # cells across a door of 0.9 m, as the network was trained
MIN_WALL_RATIO = 0.015  # cells of wall per cell of the inside: photos and noise have fewer. Chosen by hand
NETWORKS = ("plan_regions_0.onnx", "plan_regions_1.onnx")
# Which buildings each network was trained on
TRAINED_ON = MODELS / "plan_regions.json"


@dataclass(frozen=True, eq=False)
class ClassMap:
    """The class probabilities of each spot of a sheet.

    probabilities: shape (4, h, w), in the order INSIDE, WALL, DOOR, OUTSIDE. cell_px: side of a cell, in pixels of the
    sheet.
    """

    probabilities: Probabilities
    cell_px: float


def segment_sheet(colors: Colors, *, door_px: float, networks: Sequence[str] = NETWORKS) -> ClassMap:
    """The classes of each spot of a sheet, the mean of several networks.

    colors: shape (H, W, 3). door_px: pixels across a door, right within a factor of 1.6.
    """
    cell = door_px / DOOR_CELLS
    layers = input_layers(colors, cell_px=cell)
    return ClassMap(np.mean([run_network(name, layers) for name in networks], axis=0), cell)


def mean_entropy(class_map: ClassMap) -> float:
    """Mean entropy, nats, of the cells that are not outside; the highest possible one if all are outside."""
    probabilities = class_map.probabilities
    entropy = -(probabilities * np.log(np.maximum(probabilities, 1e-6))).sum(axis=0)
    within = probabilities[OUTSIDE] < 0.5
    return float(entropy[within].mean()) if within.any() else float(np.log(len(probabilities)))


def has_walls(class_map: ClassMap) -> bool:
    """Whether there are enough walls around the inside for the sheet to be a plan."""
    probabilities = class_map.probabilities
    walls, inside = (probabilities[WALL] > 0.5).sum(), (probabilities.argmax(axis=0) == INSIDE).sum()
    return bool(walls > MIN_WALL_RATIO * inside)


def input_layers(colors: Colors, *, cell_px: float) -> Probabilities:
    """What the network sees of a sheet, shape (4, h, w), 0 … 1: grey, darkest grey, chroma and contrast of each cell.

    The darkest grey and the contrast keep lines that are thinner than a cell.
    """
    paper = invert_if_dark(colors)
    size = tuple(max(1, round(side / cell_px)) for side in paper.shape[1::-1])
    grey = cv2.cvtColor(paper, cv2.COLOR_RGB2GRAY)
    contrast = compare_to_paper(paper).contrast_uint8
    if cell_px > 1:
        window = np.ones((round(cell_px), round(cell_px)), np.uint8)
        grey = np.asarray(cv2.erode(grey, window), np.uint8)
        contrast = np.asarray(cv2.dilate(contrast, window), np.uint8)
    method = cv2.INTER_AREA if cell_px > 1 else cv2.INTER_LINEAR
    mean, darkest, contrast = (
        np.asarray(cv2.resize(image, size, interpolation=method), np.uint8) for image in (paper, grey, contrast)
    )
    mean_grey = np.asarray(cv2.cvtColor(mean, cv2.COLOR_RGB2GRAY), np.uint8)
    chroma = cv2.subtract(max_channel(mean), min_channel(mean))
    layers = [mean_grey, darkest if cell_px > 1 else mean_grey, chroma, contrast]
    return np.stack(layers).astype(np.float32) / np.float32(255)


def networks_without(building: str) -> tuple[str, ...]:
    """The networks that were trained without plans of a building, to be evaluated on it.

    building: its name in the manifest of the data.
    """
    trained_on = json.loads(TRAINED_ON.read_text(encoding="utf-8"))["networks"]
    return tuple(name for name in NETWORKS if building not in trained_on[name])
