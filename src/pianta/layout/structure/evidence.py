"""Evidence of a small network: what each cell of a map is, and which cells are in one room.

Walls are long, straight, in line with other walls; furniture is short, in groups, on legs. Rules for this fail in
furnished places, so a U-Net (Ronneberger et al., 2015) learned it from simulated maps (training/fit_map_regions.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Mask
from pianta.layout._working_grid import WorkingGrid
from pianta.models import MODELS

Probabilities = NDArray[np.float32]

# Side of the cells of the network; metres.
CELL = 0.1
# Classes, in the order of the network's outputs.
OUTSIDE, FLOOR, WALL, DOOR, FURNITURE = range(5)
# Offsets, row and col in cells, of the pairs of cells whose affinity the network gives.
OFFSETS = ((0, 4), (4, 0), (0, 10), (10, 0), (0, 20), (20, 0), (0, 40), (40, 0))
# Cells: the network takes multiples, since it halves its input five times.
BLOCK = 32
# Side of the squares in which large maps are evaluated, and how far these overlap; cells.
TILE = 1024
OVERLAP = 128
NETWORK = "map_regions.onnx"


@dataclass(frozen=True, eq=False)
class Evidence:
    """What the network saw, on cells of CELL metres.

    classes: shape (5, h, w), probabilities in the order OUTSIDE, FLOOR, WALL, DOOR, FURNITURE.
    affinities: shape (len(OFFSETS), h, w), probability that the cell and the one at each offset are in one room.
    shape: of the working grid, (H, W).
    """

    classes: Probabilities
    affinities: Probabilities
    shape: tuple[int, int]

    def enlarge(self, image: Probabilities) -> Probabilities:
        """An image of shape (h, w) on the working grid, shape (H, W)."""
        return np.asarray(cv2.resize(image, self.shape[::-1], interpolation=cv2.INTER_LINEAR), np.float32)


def evaluate_map(free: Mask, occupied: Mask, *, resolution: float) -> Evidence:
    """The evidence for a map; free, occupied: shape (H, W). resolution: metres per cell."""
    size = [max(1, round(side * resolution / CELL)) for side in free.shape]
    shares = [_average(mask, size) for mask in (free, occupied)]
    output = _evaluate(np.stack(shares))
    return Evidence(output[: FURNITURE + 1], output[FURNITURE + 1 :], (free.shape[0], free.shape[1]))


def sample_classes(evidence: Evidence, working_grid: WorkingGrid) -> NDArray[np.float32]:
    """Class probabilities of each cell of the map, shape (H, W, 5)."""
    to_working = np.linalg.inv(working_grid.to_grid)
    scale = np.array(evidence.classes.shape[1:]) / evidence.shape
    # From continuous map coordinates, col and row, to the cells of the network; cv2 counts from the centres of cells
    (a, b, c), (d, e, f) = to_working[:2] * scale[:, None]
    matrix = np.array([[e, d, f + (d + e) / 2 - 0.5], [b, a, c + (a + b) / 2 - 0.5]])
    size = working_grid.grid.shape[::-1]
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    images = [cv2.warpAffine(image, matrix, size, flags=flags) for image in evidence.classes]
    classes = np.stack(images, axis=-1).astype(np.float32)
    classes[..., OUTSIDE] += 1 - classes.sum(axis=-1)
    return classes


def _average(mask: Mask, size: list[int]) -> Probabilities:
    """Share of each coarse cell that a mask covers."""
    return np.asarray(cv2.resize(mask.astype(np.float32), size[::-1], interpolation=cv2.INTER_AREA), np.float32)


def _evaluate(layers: Probabilities) -> Probabilities:
    """Outputs of the network for layers, shape (2, h, w): shape (5 + len(OFFSETS), h, w); large maps tile by tile."""
    height, width = layers.shape[1:]
    if max(height, width) <= TILE:
        return _evaluate_tile(layers)
    output = np.zeros((FURNITURE + 1 + len(OFFSETS), height, width), np.float32)
    step = TILE - 2 * OVERLAP
    for top in range(0, height, step):
        for left in range(0, width, step):
            rows, cols = (slice(max(first - OVERLAP, 0), first + step + OVERLAP) for first in (top, left))
            part = _evaluate_tile(layers[:, rows, cols])
            down, right = top - rows.start, left - cols.start
            inner = part[:, down : down + step, right : right + step]
            output[:, top : top + inner.shape[1], left : left + inner.shape[2]] = inner
    return output


def _evaluate_tile(layers: Probabilities) -> Probabilities:
    height, width = layers.shape[1:]
    output = np.zeros((FURNITURE + 1 + len(OFFSETS), height, width), np.float32)
    output[OUTSIDE] = 1.0
    if not layers.any():
        return output
    padded = np.pad(layers, ((0, 0), (0, -height % BLOCK), (0, -width % BLOCK)))[None]
    network = _read_network()
    network.setInput(padded)
    return np.asarray(network.forward(), np.float32)[0, :, :height, :width]


@cache
def _read_network() -> cv2.dnn.Net:
    content = (MODELS / NETWORK).read_bytes()
    return cv2.dnn.readNetFromONNX(np.frombuffer(content, np.uint8))
