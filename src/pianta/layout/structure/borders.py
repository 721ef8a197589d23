"""Straight borders between rooms: each stretch along which two rooms touch, from jamb to jamb."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.layout.structure.necks import Clearance, draw_critical_lines, measure_lengths
from pianta.layout.structure.regions import cut_into_regions, sample_image

# All constants of this module were chosen by hand on made worlds.
# A neck is the border if both of its ends are at most this far from the ends of the stretch; metres.
NECK_REACH = 0.6
# A border that deviates more from its chord stays as it is, because the room has a corner there; metres.
MAX_SAGITTA = 0.35
# The chord of a stretch is followed at most this far to the jambs; metres.
JAMB_REACH = 0.4
# Cells of a room beyond its straight borders belong to the other room if they are less than this share of it.
MAX_REST_SHARE = 0.2


@dataclass(frozen=True, eq=False)
class Borders:
    """Stretches along which two rooms touch.

    lines: shape (B, 2, 2), end, then row and col; cells. straight: shape (B,), whether the border follows its line.
    """

    lines: Floats
    straight: Mask


def straighten_borders(
    labels: LabelImage, space: Mask, clearance: Clearance, necks: Floats, *, min_clearance: float, resolution: float
) -> LabelImage:
    """The label image with straight borders between rooms.

    labels: shape (H, W), n > 0 for room n. space: the free cells. clearance: its distance transform, in cells.
    necks: lines from jamb to jamb, shape (N, 2, 2), which borders near them follow. min_clearance: as in
    cut_into_regions. resolution: metres per cell.
    """
    stretches = list_stretches(labels)
    borders = draw_borders(stretches, space, necks, resolution)
    lines = borders.lines[borders.straight]
    regions = cut_into_regions(space, clearance, lines, min_clearance=min_clearance, resolution=resolution)
    # What is left of a room in a region of another one, beside the straight border, belongs to the other
    count = int(labels.max(initial=0)) + 1
    keys = regions.labels.astype(np.int64) * count + labels
    overlap = np.bincount(keys.ravel(), minlength=len(regions.area) * count).reshape(-1, count)
    overlap[0] = overlap[:, 0] = 0
    rest = (overlap < MAX_REST_SHARE * np.bincount(labels.ravel())).ravel()[keys] & (regions.labels > 0) & (labels > 0)
    straight = np.where(rest, overlap.argmax(axis=1)[regions.labels], labels)
    return straight.astype(np.int32)


def list_stretches(labels: LabelImage) -> list[Indices]:
    """The cells on both sides of each stretch along which two rooms touch, row and col, shape (C, 2) each."""
    touching = []
    for one, other in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        rows, cols = np.nonzero((labels[one] != labels[other]) & (labels[one] > 0) & (labels[other] > 0))
        pair = np.sort(np.column_stack([labels[one][rows, cols], labels[other][rows, cols]]), axis=1)
        down, right = (1, 0) if one == np.s_[:-1] else (0, 1)
        touching += [np.column_stack([pair, rows, cols]), np.column_stack([pair, rows + down, cols + right])]
    contacts = np.concatenate(touching)
    index = np.unique(contacts[:, :2], axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(index, kind="stable")
    stretches = []
    for group in np.split(order, np.flatnonzero(np.diff(index[order])) + 1):
        if not len(group):
            continue
        cells = np.unique(contacts[group, 2:], axis=0)
        corner = cells.min(axis=0)
        image = np.zeros(np.ptp(cells, axis=0) + 1, np.uint8)
        image[tuple((cells - corner).T)] = 1
        number = cv2.connectedComponents(image, connectivity=8)[1][tuple((cells - corner).T)]
        stretches += [cells[number == i] for i in range(1, number.max() + 1)]
    return stretches


def draw_borders(stretches: list[Indices], space: Mask, necks: Floats, resolution: float) -> Borders:
    """The line of each stretch: a neck near it, the shortest line through its middle, or its chord."""
    lines, straight = [np.zeros((0, 2, 2))], []
    middles = [cells[np.hypot(*(cells - cells.mean(axis=0)).T).argmin()] for cells in stretches]
    shortest = draw_critical_lines(np.array(middles, float).reshape(-1, 2), space)
    for cells in stretches:
        chord, sagitta = _fit_chord(cells.astype(float))
        is_straight = sagitta * resolution <= MAX_SAGITTA
        near = [_find_nearest_line(chord, group, NECK_REACH / resolution) for group in (necks, shortest)]
        candidates = [line for line in near if line is not None]
        lines.append(
            candidates[0][None]
            if is_straight and candidates
            else _extend_to_jambs(chord, space, JAMB_REACH / resolution)[None]
        )
        straight.append(is_straight)
    return Borders(np.concatenate(lines), np.array(straight, bool))


def _find_nearest_line(chord: Floats, lines: Floats, reach: float) -> Floats | None:
    """The line of which both ends are nearest to those of a chord, in either order; None if none is within reach."""
    if not len(lines):
        return None
    distances = [np.hypot(*np.moveaxis(turned - chord, -1, 0)).max(axis=1) for turned in (lines, lines[:, ::-1])]
    distance = np.min(distances, axis=0)
    return lines[distance.argmin()] if distance.min() <= reach else None


def _fit_chord(cells: Floats) -> tuple[Floats, float]:
    """The line between the two ends of a stretch, shape (2, 2), and how far its cells are from it; cells."""
    middle = cells.mean(axis=0)
    first = cells[np.hypot(*(cells - middle).T).argmax()]
    second = cells[np.hypot(*(cells - first).T).argmax()]
    along = second - first
    length = max(float(np.hypot(*along)), 1e-9)
    across = np.abs((cells - first) @ np.array([along[1], -along[0]])) / length
    return np.stack([first, second]), float(across.max())


def _extend_to_jambs(chord: Floats, space: Mask, reach: float) -> Floats:
    """The chord, each end moved outwards to the first cell that is not free, if there is one within reach."""
    length = max(float(measure_lengths(chord[None])[0]), 1e-9)
    outward = (chord[1] - chord[0]) / length
    ends = []
    for end, step in ((chord[0], -outward), (chord[1], outward)):
        samples = end + np.arange(0, int(reach) + 1)[:, None] * step
        blocked = np.flatnonzero(~sample_image(space, samples).astype(bool))
        ends.append(samples[blocked[0]] if len(blocked) else end + step)
    return np.stack(ends)
