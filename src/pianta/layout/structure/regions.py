"""Regions of the free space between the necks, and the separators where two regions meet.

Section 2.2 of the thesis: critical points segment the map into regions (Thrun 1998; Bormann et al. 2016).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.layout._label_images import grow_mask, highest_of_labels, nearest_labels
from pianta.layout.structure.necks import Clearance, measure_lengths

# Distances from a separator's line at which the regions on its two sides are searched, nearest first: walls are thinner
# than twice the last; metres (chosen by hand).
SIDE_DISTANCES = (0.1, 0.15, 0.2, 0.3, 0.4, 0.5)


@dataclass(frozen=True, eq=False)
class Regions:
    """The free space, cut along lines.

    labels: shape (H, W), n > 0 for region n; 0 outside the free space, and where it is too narrow to pass and not
        connected to any region. A cell on a line is in the nearest region.
    width: shape (1 + R,), diameter of the largest circle in each region; metres.
    area: shape (1 + R,); m².
    resolution: metres per cell.
    """

    labels: LabelImage
    width: Floats
    area: Floats
    resolution: float


@dataclass(frozen=True, eq=False)
class Separators:
    """Lines where two regions meet.

    lines: shape (B, 2, 2), end, then row and col of a cell. opening: shape (B,), length of each line; metres.
    sides: shape (B, 2), the regions to the left and to the right, seen from the first end with row 0 at the top.
    """

    lines: Floats
    opening: Floats
    sides: Indices


def cut_into_regions(
    space: Mask, clearance: Clearance, lines: Floats, *, min_clearance: float, resolution: float
) -> Regions:
    """Regions of the free space that remain between lines.

    space: shape (H, W). clearance: its distance transform, in cells. lines: shape (N, 2, 2), end, then row and col.
    min_clearance: cells of no more clearance connect nothing, and belong to the nearest region; cells.
    resolution: metres per cell.
    """
    passable = (clearance > min_clearance).astype(np.uint8)
    for (row0, col0), (row1, col1) in np.rint(lines).astype(int).tolist():
        cv2.line(passable, (col0, row0), (col1, row1), 0)
    # Connectivity 4: the cells of a slanting line touch by corners only, and must still separate its two sides.
    _, components = cv2.connectedComponents(passable, connectivity=4)
    return describe_regions(grow_regions(components.astype(np.int32), space), clearance, resolution=resolution)


def describe_regions(labels: LabelImage, clearance: Clearance, *, resolution: float) -> Regions:
    """The regions of a label image, shape (H, W).

    clearance: of the free space, in cells. resolution: metres per cell.
    """
    radius = highest_of_labels(clearance, labels, int(labels.max(initial=0)))
    area = np.bincount(labels.ravel()) * resolution**2
    radius[0] = area[0] = 0
    return Regions(labels, 2 * radius * resolution, area.astype(float), resolution)


def find_separators(regions: Regions, lines: Floats) -> Separators:
    """Separators along those lines that have different regions on their two sides.

    lines: shape (N, 2, 2), end, then row and col of a cell.
    """
    length = measure_lengths(lines)
    along = (lines[:, 1] - lines[:, 0]) / np.maximum(length, 1e-9)[:, None]
    # To the left, because rows count downwards.
    across = np.column_stack([-along[:, 1], along[:, 0]])
    counts = np.floor(length).astype(int) + 1
    separator = np.repeat(np.arange(len(lines)), counts)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    samples = lines[separator, 0] + step[:, None] * along[separator]
    # At distance 0 both sides would be in the same region.
    distances = [max(round(distance / regions.resolution), 1) for distance in SIDE_DISTANCES]
    left = _first_region(regions.labels, samples, across[separator], distances)
    right = _first_region(regions.labels, samples, -across[separator], distances)
    sides = _find_sides(separator, left, right, len(lines))
    valid = sides[:, 0] > 0
    return Separators(lines[valid], length[valid] * regions.resolution, sides[valid])


def _find_sides(separator: Indices, left: Indices, right: Indices, count: int) -> Indices:
    """The regions to the left and right of most samples of each line, if they differ, else 0; shape (N, 2)."""
    sides = np.zeros((count, 2), np.intp)
    opposite = (left > 0) & (right > 0) & (left != right)
    triples, samples = np.unique(np.column_stack([separator, left, right])[opposite], axis=0, return_counts=True)
    # The pair with the most samples comes last, and overwrites the others.
    order = np.argsort(samples, kind="stable")
    sides[triples[order, 0]] = triples[order, 1:]
    return sides


def _first_region(labels: LabelImage, samples: Floats, across: Floats, distances: list[int]) -> Indices:
    """The region nearest to each sample on one side, shape (S,), 0 if none.

    samples, across: shape (S, 2), row and col; across of length 1. distances: to search, nearest first; cells.
    """
    regions = np.zeros(len(samples), np.intp)
    for distance in distances:
        regions = np.where(regions == 0, sample_image(labels, samples + distance * across), regions)
    return regions


def sample_image(image: NDArray[Any], positions: Floats) -> NDArray[Any]:
    """Values of an image at positions (row, col), shape (..., 2), in cells; 0 outside."""
    cells = np.rint(positions).astype(np.intp)
    rows, cols = cells[..., 0], cells[..., 1]
    outside = (rows < 0) | (rows >= image.shape[0]) | (cols < 0) | (cols >= image.shape[1])
    rows[outside] = cols[outside] = 0
    values = np.asarray(image[rows, cols])
    values[outside] = 0
    return values


def grow_regions(labels: LabelImage, space: Mask) -> LabelImage:
    """Labels, shape (H, W), with every cell of the free space in the nearest region, and no other cell in any.

    Behind a wall the region with the shortest path counts; free space that is connected to no region stays 0.
    """
    grown = np.where(space, nearest_labels(labels, background=0)[0], 0)
    # Parts that are not connected to their region lie behind a wall.
    for number, window in enumerate(ndimage.find_objects(grown), start=1):
        if window is None:
            continue
        count, parts = cv2.connectedComponents((grown[window] == number).astype(np.uint8), connectivity=4)
        connected = np.bincount(parts[labels[window] == number], minlength=count) > 0
        connected[0] = True
        grown[window][~connected[parts]] = 0
    _flood_rest(grown, space)
    return np.asarray(grown, np.int32)


def _flood_rest(labels: LabelImage, space: Mask) -> None:
    """Label the free cells of label 0 by the region that reaches them first, cell by cell, if any does; in place."""
    from skimage.segmentation import watershed

    rest = space & (labels == 0)
    if rest.any():
        near = grow_mask(rest, 1) & space
        flooded = watershed(np.zeros(labels.shape, np.uint8), np.where(near, labels, 0), mask=near)
        labels[rest] = flooded[rest]
