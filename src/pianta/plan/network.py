"""Convolutional networks that see a whole sheet, run by OpenCV tile by tile."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta.models import MODELS

# Cells of a side that a network sees at once, multiples of BLOCK, since 768 × 768 take 0.4 GB
TILE = 768
TILE_OVERLAP = 96  # cells around a part of a larger sheet that the network sees, too
BLOCK = 32  # cells: networks take multiples, since they halve their input up to five times


def run_network(name: str, layers: NDArray[np.float32]) -> NDArray[np.float32]:
    """What a network gives for each cell of a sheet, shape (outputs, h, w).

    name: its file among the models. layers: shape (inputs, h, w). The network is read for each sheet, in a moment,
    since it would keep the memory of its largest input.
    """
    content = (MODELS / name).read_bytes()
    network = cv2.dnn.readNetFromONNX(np.frombuffer(content, np.uint8))
    height, width = layers.shape[1:]
    padded = np.pad(layers, ((0, 0), (0, -height % BLOCK), (0, -width % BLOCK)), mode="edge")[None]
    result: NDArray[np.float32] | None = None
    for rows, seen_rows in _list_tiles(padded.shape[2]):
        for cols, seen_cols in _list_tiles(padded.shape[3]):
            network.setInput(np.ascontiguousarray(padded[:, :, seen_rows, seen_cols]))
            values = network.forward()[0]
            inner = (
                slice(rows.start - seen_rows.start, rows.stop - seen_rows.start),
                slice(cols.start - seen_cols.start, cols.stop - seen_cols.start),
            )
            if result is None:
                result = np.empty((len(values), *padded.shape[2:]), np.float32)
            result[:, rows, cols] = values[:, *inner]
    return np.zeros((0, height, width), np.float32) if result is None else result[:, :height, :width]


def _list_tiles(length: int) -> list[tuple[slice, slice]]:
    """Parts of a length, cells, and what the network sees of each: the part and TILE_OVERLAP cells around it."""
    if length <= TILE:
        return [(slice(0, length), slice(0, length))]
    step = TILE - 2 * TILE_OVERLAP
    starts = range(0, length - 2 * TILE_OVERLAP, step)
    ends = [min(start + step + TILE_OVERLAP, length) for start in starts]
    ends[-1] = length
    begins = [0, *ends[:-1]]
    return [
        (slice(begin, end), slice(max(0, begin - TILE_OVERLAP), min(length, end + TILE_OVERLAP)))
        for begin, end in zip(begins, ends, strict=True)
    ]
