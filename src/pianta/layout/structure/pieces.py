"""Pieces of the free space: what remains between the necks, and the borders where two pieces meet.

Section 2.2 of the thesis: critical points segment the map into regions, which are then merged with their neighbours
(Thrun 1998; Bormann et al. 2016).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from pianta._types import Floats, Indices, Mask
from pianta.layout.structure.necks import Clearance, measure_lengths

Labels = NDArray[np.int32]
Hull = NDArray[np.int32]

# Metres beside a border's line at which the pieces beside it are looked for: walls are thinner than twice the last.
BESIDE = (0.1, 0.15, 0.2, 0.3, 0.4, 0.5)
# Metres by which a border's line may miss a wall that is in line with it.
ASTRAY = 0.1


@dataclass(frozen=True, eq=False)
class Pieces:
    """The free space, cut along the borders.

    labels: shape (H, W), n > 0 for piece n, 0 outside the space and where it is too narrow to pass and joined to no
    piece; a cell on a border is in the nearest piece.
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

    lines: shape (B, 2, 2), end, then row and col of a cell. opening: shape (B,), length of each line; metres.
    sides: shape (B, 2), the pieces on the left and on the right, as one looks from the first end to the second with row
    0 at the top.
    border, left, right, open, beyond: shape (S,) each, for samples every cell along the line of each border and what
    is in line with it, where a piece is beside it: the border; the pieces to the left and to the right, 0 for none;
    whether no wall is there; and 0 on the border itself, 1 beyond its first end, 2 beyond its second.
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
    """Pieces of the space that the lines leave.

    space: shape (H, W). clearance: its distance transform, in cells. lines: shape (N, 2, 2), end, then row and col.
    least: what has no more clearance, in cells, joins nothing and belongs to the nearest piece.
    resolution: metres per cell.
    """
    cut = (clearance > least).astype(np.uint8)
    for (row0, col0), (row1, col1) in np.rint(lines).astype(int).tolist():
        cv2.line(cut, (col0, row0), (col1, row1), 0)
    # A line of cells that touch by their corners parts what is joined by sides.
    count, parts = cv2.connectedComponents(cut, connectivity=4)
    labels = spread_pieces(parts.astype(np.int32), space)
    radius = np.zeros(count)
    inside = labels > 0
    np.maximum.at(radius, labels[inside], clearance[inside])
    area = np.bincount(labels[inside], minlength=count) * resolution**2
    hulls = (np.zeros((0, 1, 2), np.int32), *_list_hulls(labels))
    return Pieces(labels, 2 * radius * resolution, area.astype(float), hulls, resolution)


def find_borders(pieces: Pieces, space: Mask, lines: Floats, *, reach: float) -> Borders:
    """Borders along the lines that have different pieces on their two sides.

    space: shape (H, W). lines: shape (N, 2, 2), end, then row and col of a cell.
    reach: how far beyond both ends of a line the wall in line with it is followed; metres.
    """
    length = measure_lengths(lines)
    along = (lines[:, 1] - lines[:, 0]) / np.maximum(length, 1e-9)[:, None]
    # To the left, because rows count downwards.
    across = np.column_stack([-along[:, 1], along[:, 0]])
    margin = ceil(reach / pieces.resolution)
    counts = np.ceil(length).astype(int) + 2 * margin + 1
    border = np.repeat(np.arange(len(lines)), counts)
    step = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts) - margin
    place = lines[border, 0] + step[:, None] * along[border]
    # At no distance there would be one piece on both sides.
    beside = [max(round(distance / pieces.resolution), 1) for distance in BESIDE]
    left = _first_piece(pieces.labels, place, across[border], beside)
    right = _first_piece(pieces.labels, place, -across[border], beside)
    within = (step >= 0) & (step <= length[border])
    band = round(ASTRAY / pieces.resolution)
    is_open = np.logical_and.reduce([look_up(space, place + miss * across[border]) for miss in range(-band, band + 1)])
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
    """The pieces left and right of most of each border, where they differ; 0 where none do; shape (N, 2)."""
    sides = np.zeros((count, 2), np.intp)
    opposite = within & (left > 0) & (right > 0) & (left != right)
    meetings, samples = np.unique(np.column_stack([border, left, right])[opposite], axis=0, return_counts=True)
    # The pair with the most samples comes last, and is what stays.
    order = np.argsort(samples, kind="stable")
    sides[meetings[order, 0]] = meetings[order, 1:]
    return sides


def _first_piece(labels: Labels, place: Floats, across: Floats, beside: list[int]) -> Indices:
    """The first piece beside each place, shape (S,), 0 for none.

    place, across: shape (S, 2), row and col; across of length 1. beside: distances to look at, nearest first; cells.
    """
    found = np.zeros(len(place), np.intp)
    for distance in beside:
        found = np.where(found == 0, look_up(labels, place + distance * across), found)
    return found


def look_up(image: NDArray[Any], places: Floats) -> NDArray[Any]:
    """Values of an image at row, col of places, shape (..., 2), in cells; 0 outside."""
    cells = np.rint(places).astype(np.intp)
    rows, cols = cells[..., 0], cells[..., 1]
    outside = (rows < 0) | (rows >= image.shape[0]) | (cols < 0) | (cols >= image.shape[1])
    rows[outside] = cols[outside] = 0
    values = np.asarray(image[rows, cols])
    values[outside] = 0
    return values


def _list_hulls(labels: Labels) -> list[Hull]:
    """Corners of the convex hull of the cells of pieces 1 … P, col and row, shape (V, 1, 2) each."""
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
    """Labels, shape (H, W), with every cell of the space in the nearest piece, and no other cell in any.

    Behind a wall the nearest piece is the one nearest on foot; space that no piece is joined to is in none.
    """
    nobody = labels == 0
    _, nearest = cv2.distanceTransformWithLabels(
        nobody.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5, labelType=cv2.DIST_LABEL_PIXEL
    )
    piece_of_label = np.zeros(nearest.max() + 1, labels.dtype)
    piece_of_label[nearest[~nobody]] = labels[~nobody]
    spread = np.where(space, piece_of_label[nearest], 0)
    # Parts that are not joined to their piece lie behind a wall
    for number, window in enumerate(ndimage.find_objects(spread), start=1):
        if window is None:
            continue
        count, parts = cv2.connectedComponents((spread[window] == number).astype(np.uint8), connectivity=4)
        joined = np.bincount(parts[labels[window] == number], minlength=count) > 0
        joined[0] = True
        spread[window][~joined[parts]] = 0
    _spread_step_by_step(spread, space)
    return np.asarray(spread, np.int32)


def _spread_step_by_step(labels: Labels, space: Mask) -> None:
    """Give cells of the space that are in no piece to the one that reaches them first, cell by cell, if any does."""
    from skimage.segmentation import watershed

    count, _, stats, _ = cv2.connectedComponentsWithStats((space & (labels == 0)).astype(np.uint8), connectivity=4)
    for left, top, width, height, _ in stats[1:count].tolist():
        window = np.s_[max(top - 1, 0) : top + height + 1, max(left - 1, 0) : left + width + 1]
        if labels[window].any():
            flat = np.zeros(labels[window].shape, np.uint8)
            labels[window] = watershed(flat, labels[window], mask=space[window])
