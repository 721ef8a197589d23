"""Regions of a plan: which spots are inside of rooms, wall, door or outside, told by a convolutional network.

Section 3.3 of the thesis finds walls by a threshold, because its plans have thick ones. What people have are lines of
every weight among furniture, hatching, dimensions and text, which no threshold tells apart; a small U-Net
(Ronneberger et al., 2015) does, which has seen plans with their true layouts (docs/methods/plans.md).
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Colors
from pianta.models import MODELS
from pianta.plan.sheets.binarization import grade_contrast, straighten_tones, take_darkest, take_lightest

Probabilities = NDArray[np.float32]

# What the network tells apart, in its order.
INSIDE, WALL, DOOR, OUTSIDE = range(4)
# Cells that a door of 0.9 m spans where the network reads, and cells by whose multiples it takes sheets.
DOOR_CELLS, BLOCK = 8.0, 32
# Cells of wall that a plan has for each of the inside of rooms, at least: photos and noise have none.
LEAST_WALLS = 0.015
NETWORKS = ("plan_regions_0.onnx", "plan_regions_1.onnx")
# Which buildings each network was made with.
MADE_WITH = MODELS / "plan_regions.json"


@dataclass(frozen=True, eq=False)
class Regions:
    """What each spot of a sheet is.

    probabilities: shape (4, h, w), in the order INSIDE, WALL, DOOR, OUTSIDE. cell_px: side of its cells, in pixels of
    the sheet.
    """

    probabilities: Probabilities
    cell_px: float


def find_regions(colors: Colors, *, door_px: float, networks: Sequence[str] = NETWORKS) -> Regions:
    """What each spot of a sheet is, the mean of what the networks say.

    colors: shape (H, W, 3). door_px: pixels that a door spans, right within a factor of 1.6.
    """
    cell = door_px / DOOR_CELLS
    layers = describe_sheet(colors, cell_px=cell)
    height, width = layers.shape[1:]
    padded = np.pad(layers, ((0, 0), (0, -height % BLOCK), (0, -width % BLOCK)), mode="edge")[None]
    told = []
    for name in networks:
        network = _read_network(name)
        network.setInput(padded)
        told.append(np.asarray(network.forward())[0, :, :height, :width])
    return Regions(np.mean(told, axis=0), cell)


def measure_doubt(regions: Regions) -> float:
    """Mean entropy, nats, of what the network says where it does not say outside; the highest where it says no more."""
    probabilities = regions.probabilities
    entropy = -(probabilities * np.log(np.maximum(probabilities, 1e-6))).sum(axis=0)
    within = probabilities[OUTSIDE] < 0.5
    return float(entropy[within].mean()) if within.any() else float(np.log(len(probabilities)))


def has_walls(regions: Regions) -> bool:
    """Whether there are walls enough around what may be inside of rooms for the sheet to be a plan."""
    probabilities = regions.probabilities
    walls, inside = (probabilities[WALL] > 0.5).sum(), (probabilities.argmax(axis=0) == INSIDE).sum()
    return bool(walls > LEAST_WALLS * inside)


def describe_sheet(colors: Colors, *, cell_px: float) -> Probabilities:
    """What the network sees of a sheet, shape (4, h, w), 0 … 1: grey, darkest grey, chroma and contrast of each cell.

    The darkest grey and the contrast keep lines that are thinner than a cell.
    """
    paper = straighten_tones(colors)
    size = tuple(max(1, round(side / cell_px)) for side in paper.shape[1::-1])
    grey = cv2.cvtColor(paper, cv2.COLOR_RGB2GRAY)
    contrast = grade_contrast(paper)
    if cell_px > 1:
        window = np.ones((round(cell_px), round(cell_px)), np.uint8)
        grey = np.asarray(cv2.erode(grey, window), np.uint8)
        contrast = np.asarray(cv2.dilate(contrast, window), np.uint8)
    way = cv2.INTER_AREA if cell_px > 1 else cv2.INTER_LINEAR
    mean, darkest, clear = (
        np.asarray(cv2.resize(image, size, interpolation=way), np.uint8) for image in (paper, grey, contrast)
    )
    if cell_px <= 1:
        darkest = np.asarray(cv2.cvtColor(mean, cv2.COLOR_RGB2GRAY), np.uint8)
    chroma = cv2.subtract(take_lightest(mean), take_darkest(mean))
    layers = [cv2.cvtColor(mean, cv2.COLOR_RGB2GRAY), darkest, chroma, clear]
    return np.stack(layers).astype(np.float32) / np.float32(255)


def networks_without(building: str) -> tuple[str, ...]:
    """The networks that were made without plans of a building, to be judged on it.

    building: as the data's manifest calls it.
    """
    made_with = json.loads(MADE_WITH.read_text(encoding="utf-8"))["networks"]
    return tuple(name for name in NETWORKS if building not in made_with[name])


@cache
def _read_network(name: str) -> cv2.dnn.Net:
    content = (MODELS / name).read_bytes()
    return cv2.dnn.readNetFromONNX(np.frombuffer(content, np.uint8))
