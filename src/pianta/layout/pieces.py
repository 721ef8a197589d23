"""Pieces of the free space: what remains between the necks, and the borders where two pieces meet."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from pianta.layout.canvas import Mask
from pianta.layout.necks import Clearance, Floats, measure_lengths

Labels = NDArray[np.int32]
Indices = NDArray[np.intp]
Hull = NDArray[np.int32]

# Metres beside a border's line at which the pieces beside it are looked for: walls are thinner than twice the last.
BESIDE = (0.1, 0.15, 0.2, 0.3, 0.4, 0.5)
# Metres by which a border's line may miss a wall that is in line with it.
ASTRAY = 0.1


@dataclass(frozen=True, eq=False)
class Pieces:
    """The free space, cut along the borders.

    labels: shape (H, W), n > 0 for piece n, 0 elsewhere and on the borders.
    width: shape (1 + P,), diameter of the largest circle in each piece; metres. area: shape (1 + P,); m².
    hulls: corners of the convex hull of each piece, col and row, shape (V, 1, 2); of number 0 there are none.
    resolution: metres per cell.
    """

    labels: Labels
    width: Floats
    area: Floats
    hulls: tuple[Hull, ...]
    resolution: float


@dataclass(frozen=True, eq=False)
class Borders:
    """Where two pieces meet, and what lies in line with it.

    lines: shape (B, 2, 2), end, then row and col. opening: shape (B,), length of each line; metres.
    sides: shape (B, 2), the pieces on the two sides.
    border, left, right, open, beyond: shape (S,) each, for samples every cell along the line of each border and what
    is in line with it: the border; the pieces to the left and to the right, 0 for none; whether no wall is there; and
    0 on the border itself, 1 beyond its first end, 2 beyond its second.
    """

    lines: Floats
    opening: Floats
    sides: Indices
    border: Indices
    left: Indices
    right: Indices
    open: Mask
    beyond: Indices


def cut_into_pieces(space: Mask, clearance: Clearance, lines: Floats, *, least: float, resolution: float) -> Pieces:
    """Pieces of the space, shape (H, W), that lines, shape (N, 2, 2), leave."""
    cut = (clearance > least).astype(np.uint8)
    for (row0, col0), (row1, col1) in np.rint(lines).astype(int).tolist():
        cv2.line(cut, (col0, row0), (col1, row1), 0)
    count, labels = cv2.connectedComponents(cut, connectivity=4)
    labels = spread_pieces(labels, space)
    radius = np.zeros(count)
    np.maximum.at(radius, labels[space], clearance[space])
    area = np.bincount(labels[space], minlength=count) * resolution**2
    return Pieces(labels, 2 * radius * resolution, area, (np.zeros((0, 1, 2), np.int32), *_list_hulls(labels)), resolution)


def find_borders(pieces: Pieces, space: Mask, lines: Floats, *, reach: float) -> Borders:
    """Borders along the lines that have different pieces on their two sides.

    reach: how far beyond both ends of a line the wall in line with it is followed; metres.
    """
    length = measure_lengths(lines)
    along = (lines[:, 1] - lines[:, 0]) / np.maximum(length, 1e-9)[:, None]
    across = np.column_stack([along[:, 1], -along[:, 0]])
    margin = ceil(reach / pieces.resolution)
    counts = np.ceil(length).astype(int) + 2 * margin + 1
    border = np.repeat(np.arange(len(lines)), counts)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) - margin
    place = lines[border, 0] + step[:, None] * along[border]
    beside = [round(distance / pieces.resolution) for distance in BESIDE]
    left = _first_piece(pieces.labels, place, across[border], beside)
    right = _first_piece(pieces.labels, place, -across[border], beside)
    within = (step >= 0) & (step <= length[border])
    band = round(ASTRAY / pieces.resolution)
    is_open = np.logical_and.reduce(
        [_look_up(space, place + miss * across[border]) for miss in range(-band, band + 1)]
    )
    sides = _find_sides(border, left, right, within, len(lines))
    real = sides[:, 0] > 0
    kept = real[border] & ((left > 0) | (right > 0))
    number = np.cumsum(real) - 1
    return Borders(
        lines=lines[real],
        opening=length[real] * pieces.resolution,
        sides=sides[real],
        border=number[border[kept]],
        left=left[kept],
        right=right[kept],
        open=(is_open | within)[kept],
        beyond=np.select([step < 0, step > length[border]], [1, 2], 0)[kept],
    )


def _find_sides(border: Indices, left: Indices, right: Indices, within: Mask, count: int) -> Indices:
    """The two pieces that lie opposite each other along most of each border, 0 where there are none; shape (N, 2)."""
    sides = np.zeros((count, 2), np.intp)
    opposite = within & (left > 0) & (right > 0) & (left != right)
    meetings, samples = np.unique(
        np.column_stack([border, left, right])[opposite], axis=0, return_counts=True
    )
    # The pair with the most samples comes last, and is what stays.
    order = np.argsort(samples, kind="stable")
    sides[meetings[order, 0]] = meetings[order, 1:]
    return sides


def _first_piece(labels: Labels, place: Floats, across: Floats, beside: list[int]) -> Indices:
    """The first piece beside each place, in the direction across; 0 for none."""
    found = np.zeros(len(place), np.intp)
    for distance in beside:
        found = np.where(found == 0, _look_up(labels, place + distance * across), found)
    return found


def _look_up(image: NDArray, place: Floats) -> NDArray:
    """Values of an image at row, col of places, shape (S, 2), in cells; 0 outside."""
    rows, cols = np.rint(place).astype(np.intp).T
    height, width = image.shape
    inside = (rows >= 0) & (rows < height) & (cols >= 0) & (cols < width)
    return np.where(inside, image[rows.clip(0, height - 1), cols.clip(0, width - 1)], 0)


def _list_hulls(labels: Labels) -> list[NDArray[np.int32]]:
    """Corners of the convex hull of pieces 1 … P, col and row."""
    hulls = []
    for number, window in enumerate(ndimage.find_objects(labels), start=1):
        rows = labels[window] == number
        first = rows.argmax(axis=1)
        last = rows.shape[1] - 1 - rows[:, ::-1].argmax(axis=1)
        row = np.arange(len(rows))
        ends = np.concatenate([np.column_stack([first, row]), np.column_stack([last, row])])
        corner = np.array([window[1].start, window[0].start])
        hulls.append(cv2.convexHull((ends + corner).astype(np.int32)))
    return hulls


def spread_pieces(labels: Labels, space: Mask) -> Labels:
    """Labels, shape (H, W), with every cell of the space in the nearest piece, and no other cell in any."""
    nobody = labels == 0
    _, nearest = cv2.distanceTransformWithLabels(
        nobody.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    piece_of_label = np.zeros(nearest.max() + 1, labels.dtype)
    piece_of_label[nearest[~nobody]] = labels[~nobody]
    return np.where(space, piece_of_label[nearest], 0)
