"""Necks of the free space: the narrow points of its medial axis, where there may be a door.

Thrun (Learning metric-topological maps for indoor mobile robot navigation, 1998) calls them critical lines; Bormann et
al. (Room segmentation: survey, implementation, and analysis, 2016) cut rooms along them, see section 2.2 of the thesis.
Its chapter 9 asks for such local features beside its wall lines.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.graphs.components import number_components
from pianta.layout._label_images import grow_mask, highest_of_labels

Clearance = NDArray[np.float32]

# The constants of this module were chosen by hand on the maps of the benches (docs/methods/structure.md).
# Side of the blocks of cells on which the basins are computed, for speed; cells.
BLOCK_PX = 2
# Cosine of the angle between the two jambs of a neck, seen from its middle, at most: 120° or more.
MAX_JAMB_COSINE = -0.5
# Distance of the second jamb from the middle over that of the first, at most.
MAX_JAMB_RATIO = 1.8
# Distance by which a middle may miss the medial axis, because blocks and obstacles are made of cells; cells.
MIDDLE_TOLERANCE_PX = 3
# Necks of the same two basins are one door if their middles are nearer than the wider one's width and this; cells.
NECK_GAP_PX = 4
# Blocks from each contact of two basins to the next along the same stretch, at most.
CONTACT_SPACING = 2.0


def find_necks(
    space: Mask,
    clearance: Clearance,
    *,
    saddle_ratio: float,
    mouth_ratio: float,
    passage_width: float,
    merge_distance: float,
) -> Floats:
    """Necks as straight lines from jamb to jamb, shape (N, 2, 2): end, then row and col of an obstacle cell.

    space: shape (H, W), the free cells; the outermost cells are not free. clearance: its distance transform, in cells.
    saddle_ratio, mouth_ratio: two basins of the clearance are merged if the saddle between them has at least
        saddle_ratio of the lower peak, and the lower peak at least mouth_ratio of the higher. The second condition
        keeps the mouth of a corridor at a hall, which has no saddle.
    passage_width: narrower passages are closed; cells.
    merge_distance: of two necks whose ends are nearer than this the shorter one stays; cells.

    The basins of the clearance meet at its saddles, and a saddle is the middle of a neck: one jamb is the nearest
    obstacle, the other the nearest one on the opposite side (Thrun 1998). The shortest neck comes first.
    """
    basins, pooled = _find_basins(clearance, passage_width / 2)
    saddles = find_saddles(basins, pooled)
    owner = _merge_basins(basins, pooled, saddles, saddle_ratio=saddle_ratio, mouth_ratio=mouth_ratio)
    middles = _find_neck_middles(saddles, owner)
    return drop_repeated_lines(draw_critical_lines(middles, space), merge_distance)


def _find_basins(clearance: Clearance, min_clearance: float) -> tuple[LabelImage, Clearance]:
    """Label image of the basins of the clearance, 0 where it is at most min_clearance; and the clearance of each block.

    A block has BLOCK_PX × BLOCK_PX cells; both results have an element for each block, and clearances are in cells.
    """
    from skimage.segmentation import watershed

    height, width = (size - size % BLOCK_PX for size in clearance.shape)
    blocks = clearance[:height, :width].reshape(height // BLOCK_PX, BLOCK_PX, width // BLOCK_PX, BLOCK_PX)
    pooled = blocks.max(axis=(1, 3))
    is_peak = (pooled == cv2.dilate(pooled, np.ones((3, 3), np.uint8))) & (pooled > min_clearance)
    peaks = cv2.connectedComponents(is_peak.astype(np.uint8), connectivity=8)[1]
    return watershed(-pooled, peaks, mask=pooled > min_clearance, connectivity=2).astype(np.int32), pooled


def find_saddles(basins: LabelImage, pooled: Clearance) -> Floats:
    """The saddles: the highest point of every stretch along which two basins meet; the highest saddle comes first.

    basins, pooled: of _find_basins. Two basins may meet along several stretches, as two rooms may have several doors.
    Returns shape (S, 5): both basins, the smaller number first, clearance in cells, row and col in blocks.
    """
    stretches = []
    height, width = basins.shape
    for row_step, col_step in ((0, 1), (1, 0), (1, 1), (1, -1)):
        left = max(-col_step, 0)
        here = np.s_[: height - row_step, left : width - max(col_step, 0)]
        there = np.s_[row_step:, left + col_step : width + min(col_step, 0)]
        rows, cols = np.nonzero((basins[here] != basins[there]) & (basins[here] > 0) & (basins[there] > 0))
        pair = np.sort(np.column_stack([basins[here][rows, cols], basins[there][rows, cols]]), axis=1)
        saddle_height = np.minimum(pooled[here][rows, cols], pooled[there][rows, cols])
        stretches.append(np.column_stack([pair, saddle_height, rows, cols + left]))
    contacts = np.concatenate(stretches).astype(float)
    contacts = contacts[np.lexsort((contacts[:, 4], contacts[:, 3], -contacts[:, 2]))]
    _, first = np.unique(_number_stretches(contacts), return_index=True)
    return contacts[np.sort(first)]


def _number_stretches(contacts: Floats) -> Indices:
    """Number of the stretch of each contact, shape (N,): neighbouring contacts of the same two basins share one."""
    if not len(contacts):
        return np.zeros(0, np.intp)
    _, pair = np.unique(contacts[:, :2], axis=0, return_inverse=True)
    # The first coordinate moves contacts of different basins out of each other's reach.
    points = np.column_stack([pair.ravel() * 2 * CONTACT_SPACING, contacts[:, 3:]])
    links = KDTree(points).query_pairs(CONTACT_SPACING, output_type="ndarray")
    return number_components(links, len(contacts))


def _merge_basins(
    basins: LabelImage, pooled: Clearance, saddles: Floats, *, saddle_ratio: float, mouth_ratio: float
) -> Indices:
    """Basin that each basin belongs to, shape (1 + basins), after those without a real neck between them are merged.

    The higher one of two basins stays. Each saddle is visited once, from the highest to the lowest.
    """
    peak = highest_of_labels(pooled, basins, int(basins.max(initial=0)))
    owner = np.arange(len(peak))

    def find(basin: int) -> int:
        while owner[basin] != basin:
            owner[basin] = owner[owner[basin]]
            basin = int(owner[basin])
        return basin

    for first, second, height in saddles[:, :3]:
        one, other = sorted((find(int(first)), find(int(second))), key=lambda basin: (-peak[basin], basin))
        no_neck = height >= saddle_ratio * peak[other] and peak[other] >= mouth_ratio * peak[one]
        if one != other and no_neck:
            owner[other] = one
    return np.array([find(basin) for basin in range(len(owner))])


def _find_neck_middles(saddles: Floats, owner: Indices) -> Floats:
    """Middles of the necks, shape (N, 2), row and col in cells: the saddles between basins that were not merged.

    saddles: of find_saddles, the highest first. owner: of _merge_basins. Of two saddles between the same two basins
    that are nearer to each other than the width of the higher one and NECK_GAP_PX, the higher one stays.
    """
    pairs = owner[saddles[:, :2].astype(int)]
    selected: dict[tuple[int, int], list[Floats]] = {}
    for (one, other), saddle in zip(pairs, saddles, strict=True):
        if one == other:
            continue
        others = selected.setdefault((min(one, other), max(one, other)), [])
        if all(np.hypot(*(saddle[3:] - rest[3:])) * BLOCK_PX >= 2 * rest[2] + NECK_GAP_PX for rest in others):
            others.append(saddle)
    middles = [saddle[3:] * BLOCK_PX + (BLOCK_PX - 1) / 2 for group in selected.values() for saddle in group]
    return np.array(middles, float).reshape(-1, 2)


def draw_critical_lines(middles: Floats, space: Mask) -> Floats:
    """Line from the obstacle nearest to each middle to the nearest one opposite, if there is one; shape (N, 2, 2)."""
    obstacles = np.argwhere(grow_mask(space, 1) & ~space).astype(float)
    if not (len(middles) and len(obstacles)):
        return np.zeros((0, 2, 2))
    tree = KDTree(obstacles)
    distances, nearest = tree.query(middles)
    lines = []
    for middle, distance, first in zip(middles, distances, nearest, strict=True):
        near = np.sort(tree.query_ball_point(middle, MAX_JAMB_RATIO * distance + MIDDLE_TOLERANCE_PX))
        steps = obstacles[near] - middle
        lengths = np.maximum(np.hypot(*steps.T), 1e-9)
        opposite = steps @ (obstacles[first] - middle) <= MAX_JAMB_COSINE * lengths * distance
        if opposite.any():
            second = near[opposite][lengths[opposite].argmin()]
            lines.append(obstacles[[first, second]])
    return np.array(lines).reshape(-1, 2, 2)


def drop_repeated_lines(lines: Floats, distance: float) -> Floats:
    """Lines, shape (N, 2, 2), the shortest first, without those that repeat a shorter one.

    A line repeats a shorter one if both pairs of ends, in either order, are nearer than distance.
    """
    lines = lines[np.argsort(measure_lengths(lines), kind="stable")]
    ends, reverse = lines.reshape(-1, 4), lines[:, ::-1].reshape(-1, 4)
    tree = KDTree(ends)
    selected = np.ones(len(lines), bool)
    for i in range(len(lines)):
        # If each end is nearer than distance, the four coordinates together are nearer than √2 times that.
        others = np.array(sorted(set(tree.query_ball_point([ends[i], reverse[i]], distance * 2**0.5).sum())), int)
        others = others[others > i]
        offsets = np.minimum(_measure_offsets(lines[others], lines[i]), _measure_offsets(lines[others], lines[i, ::-1]))
        selected[others[offsets < distance]] &= not selected[i]
    return lines[selected]


def _measure_offsets(lines: Floats, other: Floats) -> Floats:
    """Distance between the first ends of each line and the other, or between the second if larger; shape (N,)."""
    return np.asarray(np.hypot(*np.moveaxis(lines - other, -1, 0)).max(axis=1, initial=0))


def measure_lengths(lines: Floats) -> Floats:
    """Lengths of lines of shape (N, 2, 2), in the unit of their ends; shape (N,)."""
    return np.asarray(np.hypot(*(lines[:, 1] - lines[:, 0]).T))
