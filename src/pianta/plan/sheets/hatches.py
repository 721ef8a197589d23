"""Hatches of vector plans: runs of parallel, evenly spaced lines, which fill areas and bound none."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from shapely import STRtree

from pianta._types import Floats, Mask

# Limits against hostile files.
MAX_LINES = 200_000
MAX_PAIRS = 4_000_000  # of lines and their neighbours

# Chosen by hand on one plan of departments:
MIN_RUN = 8  # lines; a flight of stairs or a grid of tiles may be one, too, and bounds no room either
MAX_SPACING = 0.01  # of the longer side of the drawing
SPACING_TOLERANCE = 0.1  # share of the spacing by which lines are off
ANGLE_TOLERANCE = 0.25  # degrees
MIN_LENGTH = 1e-6  # of the longer side: shorter lines have no direction


def find_hatches(lines: Floats, widths: Floats) -> Mask:
    """Which lines belong to a hatch, shape (N,); none on plans with too many lines.

    lines: shape (N, 2, 2). widths: of their strokes, shape (N,).

    A line belongs to a hatch if it is one of a run of parallel lines of one width, each beside the middle of the one
    before and at the same spacing, or if it lies among them, on the same raster.
    """
    is_hatch = np.zeros(len(lines), bool)
    if not MIN_RUN <= len(lines) <= MAX_LINES:
        return is_hatch
    longest = float(np.ptp(lines.reshape(-1, 2), axis=0).max())
    steps = lines[:, 1] - lines[:, 0]
    lengths = np.hypot(*steps.T)
    angles = np.round(np.degrees(np.arctan2(steps[:, 1], steps[:, 0])) % 180 / ANGLE_TOLERANCE) % (
        180 / ANGLE_TOLERANCE
    )
    kinds = np.unique(np.column_stack([angles, np.float32(widths)]), axis=0, return_inverse=True)[1].ravel()
    kinds[lengths <= MIN_LENGTH * longest] = -1
    order = np.argsort(kinds, kind="stable")
    for parallel in np.split(order, np.flatnonzero(np.diff(kinds[order])) + 1):
        if len(parallel) >= MIN_RUN and kinds[parallel[0]] >= 0:
            is_hatch[parallel] = _hatches_of_direction(lines[parallel], MAX_SPACING * longest)
    return is_hatch


def _hatches_of_direction(lines: Floats, max_spacing: float) -> Mask:
    """Which parallel lines, shape (N, 2, 2), belong to a hatch, shape (N,)."""
    steps = lines[:, 1] - lines[:, 0]
    steps *= np.sign(steps[:, :1] + (steps[:, :1] == 0) * steps[:, 1:])
    along = steps.sum(axis=0) / np.hypot(*steps.sum(axis=0))
    across = np.array([-along[1], along[0]])
    offsets = lines.mean(axis=1) @ across
    following, spacings = _next_lines(lines, offsets, across, max_spacing)
    # Lines at the same spacing from each other are a run
    first = np.flatnonzero(following >= 0)
    second = following[first]
    even = np.abs(spacings[second] / spacings[first] - 1) <= SPACING_TOLERANCE
    last = following[second] < 0
    first, second = first[even | last], second[even | last]
    graph = coo_array((np.ones(len(first), bool), (first, second)), shape=(len(lines),) * 2)
    runs = connected_components(graph, directed=False)[1]
    is_hatch = np.zeros(len(lines), bool)
    tree = STRtree(shapely.linestrings(lines))
    for run in np.flatnonzero(np.bincount(runs) >= MIN_RUN):
        members = np.flatnonzero(runs == run)
        spacing = float(np.nanmedian(spacings[members]))
        if np.ptp(offsets[members]) < (MIN_RUN - 1) * spacing * (1 - SPACING_TOLERANCE):
            continue
        # Short lines in the corners of the hatched area are on the same raster
        hull = shapely.convex_hull(shapely.multilinestrings(lines[members])).buffer(spacing * (1 + SPACING_TOLERANCE))
        near = tree.query(hull, predicate="contains")
        phases = (offsets[near] - offsets[members[0]]) / spacing
        is_hatch[near[np.abs(phases - np.round(phases)) <= SPACING_TOLERANCE]] = True
        is_hatch[members] = True
    return is_hatch


def _next_lines(lines: Floats, offsets: Floats, across: Floats, max_spacing: float) -> tuple[NDArray[np.intp], Floats]:
    """The nearest line across the middle of each one, -1 without one, and the distance, NaN without one; shape (N,)."""
    following, spacings = np.full(len(lines), -1), np.full(len(lines), np.nan)
    middles = lines.mean(axis=1)
    least = SPACING_TOLERANCE * max_spacing * SPACING_TOLERANCE
    probes = shapely.linestrings(np.stack([middles + least * across, middles + max_spacing * across], axis=1))
    pairs = _find_pairs(lines, probes, offsets, max_spacing)
    if pairs is None:
        return following, spacings
    distances = offsets[pairs[1]] - offsets[pairs[0]]
    ahead = distances > least
    (start, end), distances = pairs[:, ahead], distances[ahead]
    order = np.lexsort([distances, start])
    nearest = order[np.unique(start[order], return_index=True)[1]]
    following[start[nearest]], spacings[start[nearest]] = end[nearest], distances[nearest]
    return following, spacings


def _find_pairs(
    lines: Floats, probes: NDArray[np.object_], offsets: Floats, max_spacing: float
) -> NDArray[np.intp] | None:
    """Pairs of probes and lines that they meet, shape (2, N); None for more than MAX_PAIRS."""
    # No probe meets more lines than have offsets within its reach, so that each chunk has few pairs
    in_order = np.sort(offsets)
    most = int((np.searchsorted(in_order, in_order + max_spacing, side="right") - np.arange(len(lines))).max())
    chunk = max(1, MAX_PAIRS // most)
    tree, parts, count = STRtree(shapely.linestrings(lines)), list[NDArray[np.intp]](), 0
    for start in range(0, len(probes), chunk):
        part = tree.query(probes[start : start + chunk], predicate="intersects")
        part[0] += start
        parts.append(part)
        count += part.shape[1]
        if count > MAX_PAIRS:
            return None
    return np.concatenate(parts, axis=1)
