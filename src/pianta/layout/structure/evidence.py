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

from pianta._types import Floats, LabelImage, Mask
from pianta.layout._label_images import shrink_mask
from pianta.layout._working_grid import WorkingGrid
from pianta.models import MODELS

Probabilities = NDArray[np.float32]

# Side of the cells of the network; metres.
CELL = 0.1
# Classes, in the order of the network's outputs.
CLASSES = OUTSIDE, FLOOR, WALL, DOOR, FURNITURE = range(5)
# Offsets, row and col in cells, of the pairs of cells whose affinity the network gives.
OFFSETS = ((0, 4), (4, 0), (0, 10), (10, 0), (0, 20), (20, 0), (0, 40), (40, 0))
# Cells: the network takes multiples, since it halves its input five times.
BLOCK = 32
# Side of the squares in which large maps are evaluated, and how far these overlap; cells.
TILE = 1024
OVERLAP = 128
# The main direction is found from about this many edge cells, ...
MAX_EDGES = 4000
# ... by histograms with bins of this many cells, ...
EDGE_BIN = 2.0
# ... and a map is turned if its walls are turned by more; degrees (all chosen by hand).
MIN_TURN = 1.0
NETWORK = "map_regions.onnx"


@dataclass(frozen=True, eq=False)
class Evidence:
    """The outputs of the network, on cells of CELL metres along the main direction of the walls.

    classes: shape (5, h, w), probabilities in the order OUTSIDE, FLOOR, WALL, DOOR, FURNITURE.
    affinities: shape (len(OFFSETS), h, w), probability that the cell and the one at each offset are in one room.
    from_working: shape (2, 3), continuous col and row of the working grid to those of the network's cells.
    shape: of the working grid, (H, W).
    """

    classes: Probabilities
    affinities: Probabilities
    from_working: Floats
    shape: tuple[int, int]

    def enlarge(self, image: Probabilities) -> Probabilities:
        """An image of shape (h, w) on the working grid, shape (H, W)."""
        return _warp(image, self.from_working, self.shape)

    def sample(self, labels: LabelImage) -> LabelImage:
        """Labels of the working grid, shape (H, W), at the middles of the network's cells, shape (h, w); 0 beyond."""
        turned, shift = self.from_working[:, :2], self.from_working[:, 2]
        rows, cols = np.indices(self.classes.shape[1:]) + 0.5
        back = np.linalg.inv(turned)
        x, y = np.floor(np.tensordot(back, np.stack([cols - shift[0], rows - shift[1]]), axes=1)).astype(np.intp)
        inside = (x >= 0) & (y >= 0) & (x < self.shape[1]) & (y < self.shape[0])
        return np.where(inside, labels[y.clip(0, self.shape[0] - 1), x.clip(0, self.shape[1] - 1)], 0).astype(np.int32)


def evaluate_map(free: Mask, occupied: Mask, *, resolution: float) -> Evidence:
    """The evidence for a map; free, occupied: shape (H, W). resolution: metres per cell."""
    shares, matrix = align_shares(free, occupied, resolution=resolution)
    output = _evaluate(shares)
    return Evidence(output[: FURNITURE + 1], output[FURNITURE + 1 :], matrix, (free.shape[0], free.shape[1]))


def align_shares(free: Mask, occupied: Mask, *, resolution: float) -> tuple[Probabilities, Floats]:
    """What the network sees of a map: the share of each of its cells that is free, or an obstacle; shape (2, h, w).

    free, occupied: shape (H, W). resolution: metres per cell.
    Returns also the matrix, shape (2, 3), from col and row of the map to those of the network's cells.
    """
    shape = (free.shape[0], free.shape[1])
    matrix, size = _align_cells(shape, resolution / CELL, find_main_direction(free))
    if matrix[0, 1] == 0:
        return np.stack([_average(mask, size) for mask in (free, occupied)]), matrix
    block = max(1, round(CELL / resolution))
    back = np.linalg.inv(np.vstack([matrix, [0, 0, 1]]))[:2]
    blurred = (cv2.blur(mask.astype(np.float32), (block, block)) for mask in (free, occupied))
    return np.stack([_warp(np.asarray(mask, np.float32), back, size) for mask in blurred]), matrix


def find_main_direction(free: Mask) -> float:
    """Direction of most edges of the free cells, shape (H, W): radians from the columns, -π/4 … π/4; 0 if near 0.

    Along the walls the edges lie on few lines, so that their positions across have the sharpest histogram.
    """
    rows, cols = np.nonzero(free & ~shrink_mask(free, 1))
    step = max(1, len(rows) // MAX_EDGES)
    points = np.stack([cols[::step], rows[::step]]).astype(float)
    coarse = max(range(-45, 45), key=lambda degrees: (_measure_sharpness(points, degrees), -abs(degrees)))
    fine = [coarse + part / 4 for part in range(-4, 5)]
    degrees = max(fine, key=lambda degrees: (_measure_sharpness(points, degrees), -abs(degrees)))
    return 0.0 if abs(degrees) < MIN_TURN else float(np.radians(degrees))


def _measure_sharpness(points: Floats, degrees: float) -> float:
    """Sum of the squared histograms of points, shape (2, N), along and across a direction."""
    turn = np.radians(degrees)
    along = np.cos(turn) * points[0] + np.sin(turn) * points[1]
    across = np.cos(turn) * points[1] - np.sin(turn) * points[0]
    bins = [np.floor((axis - axis.min(initial=0)) / EDGE_BIN).astype(np.intp) for axis in (along, across)]
    return float(sum((np.bincount(axis).astype(float) ** 2).sum() for axis in bins))


def _align_cells(shape: tuple[int, int], scale: float, turn: float) -> tuple[Floats, tuple[int, int]]:
    """Matrix (2, 3) from col and row of the working grid to cells of the network, turned by an angle; and their shape.

    scale: working cells per cell of the network. turn: radians.
    """
    if turn == 0:
        size = tuple(max(1, round(side * scale)) for side in shape)
        return np.diag([size[1] / shape[1], size[0] / shape[0], 1.0])[:2], (size[0], size[1])
    turned = scale * np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    corners = turned @ np.array([[0, 0, shape[1], shape[1]], [0, shape[0], 0, shape[0]]], float)
    low, high = corners.min(axis=1), corners.max(axis=1)
    width, height = np.ceil(high - low).astype(int).tolist()
    return np.column_stack([turned, -low]), (height, width)


def _warp(
    image: Probabilities, matrix: Floats, shape: tuple[int, int], *, border: int = cv2.BORDER_REPLICATE
) -> Probabilities:
    """The image on cells of another shape; matrix: shape (2, 3), their col and row to those of the image."""
    # Matrices count from the corners of cells, and cv2 from their middles
    centred = matrix.copy()
    centred[:, 2] += matrix[:, :2].sum(axis=1) / 2 - 0.5
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    warped = cv2.warpAffine(image, centred, shape[::-1], flags=flags, borderMode=border)
    return np.asarray(warped, np.float32)


def sample_class(evidence: Evidence, working_grid: WorkingGrid, cell_class: int) -> Probabilities:
    """Probability of a class, such as WALL, for each cell of the map, shape (H, W); all around is OUTSIDE."""
    # From col and row of the map to those of the working grid, and on to the cells of the network
    to_working = np.linalg.inv(working_grid.to_grid)[:2]
    swapped = to_working[[1, 0]][:, [1, 0, 2]]
    matrix = evidence.from_working[:, :2] @ swapped
    matrix[:, 2] += evidence.from_working[:, 2]
    shape, image = working_grid.grid.shape, evidence.classes[cell_class]
    if cell_class == OUTSIDE:
        return 1 - _warp(1 - image, matrix, shape, border=cv2.BORDER_CONSTANT)
    return _warp(image, matrix, shape, border=cv2.BORDER_CONSTANT)


def _average(mask: Mask, size: tuple[int, int]) -> Probabilities:
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
