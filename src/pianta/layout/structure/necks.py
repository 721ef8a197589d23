"""Necks of the free space: the narrow places of its medial axis, where a door may be.

Thrun (Learning metric-topological maps for indoor mobile robot navigation, 1998) calls them critical lines; Bormann et
al. (Room segmentation: survey, implementation, and analysis, 2016) cut rooms along them, and so does section 2.2 of the
thesis tell it. Its chapter 9 asks for such local features beside its wall lines.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from pianta._types import Floats, Mask
from pianta.graphs.components import number_components

Clearance = NDArray[np.float32]

# The basins are found on blocks of so many cells: a ridge of the clearance is no finer.
BLOCK = 2
# Cosine of the angle between the two jambs of a neck, seen from its middle, at most.
OPPOSITE = -0.5
# The second jamb is at most this many times as far away as the first.
LOPSIDED = 1.8
# Cells by which a middle may miss the medial axis, because it is the corner of a block and obstacles are whole cells.
ROUNDING = 3
# Cells between two necks of the same two basins, beside the width of the wider one: with less they are one door.
APART = 4
# Blocks from each meeting of two basins to the next along the same stretch, at most.
NEIGHBOURS = 2.0


def find_necks(
    space: Mask, clearance: Clearance, *, saddle_ratio: float, mouth_ratio: float, passage: float, merge_distance: float
) -> Floats:
    """Necks as straight lines from jamb to jamb, shape (N, 2, 2): end, then row and col of an obstacle cell.

    space: shape (H, W), where a robot may be; the outermost cells are not. clearance: its distance transform, in cells.
    saddle_ratio: basins of the clearance are one where the saddle between them is this share of the lower peak,
    mouth_ratio: and the lower peak this share of the higher: the mouth of a corridor at a hall has no saddle.
    passage: narrower passages are closed; cells.
    merge_distance: of two necks whose ends are nearer than this the shorter one stays; cells.

    The basins of the clearance meet at its saddles, and a saddle is the middle of a neck: one jamb is the nearest
    obstacle, the other the nearest one on the opposite side (Thrun 1998). The shortest neck comes first.
    """
    basins, pooled = _find_basins(clearance, passage / 2)
    saddles = find_saddles(basins, pooled)
    basin_of_peak = _merge_basins(basins, pooled, saddles, saddle_ratio=saddle_ratio, mouth_ratio=mouth_ratio)
    middles = _select_middles(saddles, basin_of_peak)
    necks = draw_critical_lines(middles, space)
    return drop_repeated_lines(necks, merge_distance)


def _find_basins(clearance: Clearance, least: float) -> tuple[NDArray[np.int32], Clearance]:
    """Basins of the clearance, 0 where it is least or less, and the clearance itself, both by the block; in cells."""
    from skimage.segmentation import watershed

    height, width = (size - size % BLOCK for size in clearance.shape)
    blocks = clearance[:height, :width].reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK)
    pooled = blocks.max(axis=(1, 3))
    is_peak = (pooled == cv2.dilate(pooled, np.ones((3, 3), np.uint8))) & (pooled > least)
    peaks = cv2.connectedComponents(is_peak.astype(np.uint8), connectivity=8)[1]
    return watershed(-pooled, peaks, mask=pooled > least, connectivity=2).astype(np.int32), pooled


def find_saddles(basins: NDArray[np.int32], pooled: Clearance) -> Floats:
    """The highest place of every stretch along which two basins meet; two rooms may have several doors between them.

    Shape (S, 5): both basins, the smaller first, clearance in cells, block row and col; the highest first.
    """
    found = []
    height, width = basins.shape
    for row_step, col_step in ((0, 1), (1, 0), (1, 1), (1, -1)):
        left = max(-col_step, 0)
        here = np.s_[: height - row_step, left : width - max(col_step, 0)]
        there = np.s_[row_step:, left + col_step : width + min(col_step, 0)]
        rows, cols = np.nonzero((basins[here] != basins[there]) & (basins[here] > 0) & (basins[there] > 0))
        pair = np.sort(np.column_stack([basins[here][rows, cols], basins[there][rows, cols]]), axis=1)
        height_of = np.minimum(pooled[here][rows, cols], pooled[there][rows, cols])
        found.append(np.column_stack([pair, height_of, rows, cols + left]))
    meetings = np.concatenate(found).astype(float)
    meetings = meetings[np.lexsort((meetings[:, 4], meetings[:, 3], -meetings[:, 2]))]
    stretch = _number_stretches(meetings)
    _, first = np.unique(stretch, return_index=True)
    return meetings[np.sort(first)]


def _number_stretches(meetings: Floats) -> NDArray[np.intp]:
    """Number of the stretch of each meeting, shape (N,): neighbours, between the same two basins, are of one."""
    if not len(meetings):
        return np.zeros(0, np.intp)
    _, pair = np.unique(meetings[:, :2], axis=0, return_inverse=True)
    # Meetings of different basins are moved out of each other's reach.
    places = np.column_stack([pair.ravel() * 2 * NEIGHBOURS, meetings[:, 3:]])
    links = KDTree(places).query_pairs(NEIGHBOURS, output_type="ndarray")
    return number_components(links, len(meetings))


def _merge_basins(
    basins: NDArray[np.int32], pooled: Clearance, saddles: Floats, *, saddle_ratio: float, mouth_ratio: float
) -> NDArray[np.intp]:
    """Basin that each basin belongs to, shape (1 + basins), once those without a real neck between them are one.

    The higher one of two basins stays, and from the highest saddle to the lowest each is looked at once.
    """
    peak = np.zeros(basins.max(initial=0) + 1)
    np.maximum.at(peak, basins, pooled)
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


def _select_middles(saddles: Floats, owner: NDArray[np.intp]) -> Floats:
    """Row and col, in cells, of the saddles between different basins, shape (N, 2).

    saddles: the highest first. Of those between the same two basins that are too near each other the highest stays.
    """
    pairs = owner[saddles[:, :2].astype(int)]
    kept: dict[tuple[int, int], list[Floats]] = {}
    for (one, other), saddle in zip(pairs, saddles, strict=True):
        if one == other:
            continue
        others = kept.setdefault((min(one, other), max(one, other)), [])
        if all(np.hypot(*(saddle[3:] - rest[3:])) * BLOCK >= 2 * rest[2] + APART for rest in others):
            others.append(saddle)
    middles = [saddle[3:] * BLOCK + (BLOCK - 1) / 2 for group in kept.values() for saddle in group]
    return np.array(middles, float).reshape(-1, 2)


def draw_critical_lines(middles: Floats, space: Mask) -> Floats:
    """Line from the obstacle nearest to each middle to the nearest one opposite, where there is one; (N, 2, 2)."""
    beside = cv2.dilate(space.astype(np.uint8), np.ones((3, 3), np.uint8)).astype(bool) & ~space
    obstacles = np.argwhere(beside).astype(float)
    if not (len(middles) and len(obstacles)):
        return np.zeros((0, 2, 2))
    tree = KDTree(obstacles)
    distances, nearest = tree.query(middles)
    lines = []
    for middle, distance, first in zip(middles, distances, nearest, strict=True):
        near = np.sort(tree.query_ball_point(middle, LOPSIDED * distance + ROUNDING))
        steps = obstacles[near] - middle
        lengths = np.maximum(np.hypot(*steps.T), 1e-9)
        opposite = steps @ (obstacles[first] - middle) <= OPPOSITE * lengths * distance
        if opposite.any():
            second = near[opposite][lengths[opposite].argmin()]
            lines.append(obstacles[[first, second]])
    return np.array(lines).reshape(-1, 2, 2)


def drop_repeated_lines(lines: Floats, distance: float) -> Floats:
    """Lines, shape (N, 2, 2), the shortest first, without those that repeat a shorter one.

    Both ends of a line that is left out are nearer than distance to those of a shorter one, in either order.
    """
    lines = lines[np.argsort(measure_lengths(lines), kind="stable")]
    ends, turned = lines.reshape(-1, 4), lines[:, ::-1].reshape(-1, 4)
    tree = KDTree(ends)
    kept = np.ones(len(lines), bool)
    for i in range(len(lines)):
        # Each end is nearer than distance, so both together are nearer than this.
        others = np.array(sorted(set(tree.query_ball_point([ends[i], turned[i]], distance * 2**0.5).sum())), int)
        others = others[others > i]
        repeats = np.minimum(_measure_apart(lines[others], lines[i]), _measure_apart(lines[others], lines[i, ::-1]))
        kept[others[repeats < distance]] &= not kept[i]
    return lines[kept]


def _measure_apart(lines: Floats, other: Floats) -> Floats:
    """How far the first ends, or the second ends, are apart, whichever is more; shape (N,)."""
    return np.asarray(np.hypot(*np.moveaxis(lines - other, -1, 0)).max(axis=1, initial=0))


def measure_lengths(lines: Floats) -> Floats:
    """Lengths of lines of shape (N, 2, 2), in the unit of their ends; shape (N,)."""
    return np.asarray(np.hypot(*(lines[:, 1] - lines[:, 0]).T))
