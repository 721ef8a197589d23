"""Rooms between narrow passages: the Voronoi segmentation of the survey (Bormann et al., ICRA 2016).

The survey follows Thrun and Bücken (AAAI 1996): critical points, critical lines, and cells that are then merged.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.gridmap import GridMap
from pianta.layout.parameters import Parameters, check_parameters
from pianta.layout.rivals.cells import MergeRule, merge_cells
from pianta.layout.rivals.patches import Labels, label_patches, measure_clearance, spread_labels

# A point of the diagram is as far from one base point as from the other; on the grid at most this many times as far.
LOPSIDED = 1.5
SQUARE = np.ones((3, 3), np.uint8)


@dataclass(frozen=True, kw_only=True)
class VoronoiParameters(Parameters):
    """Thresholds of the Voronoi segmentation; the defaults are those of the survey's program, but for narrowest.

    narrowest: gaps up to this width are no passage, and the diagram does not lead through them; metres.
    neighbourhood: the stretch of the diagram in which a critical point has the least clearance is this long, divided
        by that clearance; m² (280 cells of 0.05 m squared).
    longest_walk: that stretch reaches no further to either side; metres (150 cells).
    spacing: of two critical points less than this many clearances apart the wider one is dropped.
    smallest, largest: area of a cell between critical lines, m²; others go to the cells beside them.
    rules: when a cell is merged into another, applied in this order.
    """

    narrowest: float = 0.3
    neighbourhood: float = 280 * 0.05**2
    longest_walk: float = 150 * 0.05
    spacing: float = 0.5
    smallest: float = 0.1
    largest: float = 1e6
    rules: tuple[MergeRule, ...] = (
        MergeRule(area=12.5, neighbours=1, wall=0.75),
        MergeRule(area=2.0, shared=0.2),
        MergeRule(neighbours=2, wall=0.5),
        MergeRule(shared=0.2, shared_back=0.1),
        MergeRule(shared=0.4),
    )


def segment_by_voronoi_diagram(grid: GridMap, *, parameters: Parameters | None = None) -> Labels:
    """Rooms of a grid map, shape (H, W): 0 no room, 1 … N."""
    thresholds = check_parameters(parameters, VoronoiParameters)
    clearance = measure_clearance(grid.free)
    # The generalised Voronoi diagram, without the branches into corners
    passable = clearance > thresholds.narrowest / 2 / grid.resolution
    diagram = prune_diagram(draw_diagram(grid.free) & passable, clearance)
    # Critical points: the narrowest of their stretch of the diagram
    critical = find_critical_points(diagram, clearance, grid.resolution, thresholds)
    # Critical lines: from each to the nearest obstacles on either side
    lines = draw_critical_lines(critical, clearance, thresholds.spacing)
    # Cells between the lines
    patches, areas = label_patches(grid.free & ~lines, grid.resolution)
    is_cell = (thresholds.smallest <= areas) & (areas <= thresholds.largest)
    cells = spread_labels(np.where(is_cell, np.cumsum(is_cell), 0).astype(np.int32)[patches], grid.free)
    # Rooms of one or more cells
    return merge_cells(cells, grid.resolution, thresholds.rules)


def draw_diagram(free: Mask) -> Mask:
    """The Voronoi diagram of the obstacles on the grid: the one cell wide skeleton of the free space, shape (H, W)."""
    from skimage.morphology import skeletonize

    return np.asarray(skeletonize(free))


def prune_diagram(diagram: Mask, clearance: Floats) -> Mask:
    """The diagram, shape (H, W), without the branches that only run into corners, towards ever less clearance.

    A branch that leads through a passage into a room ends in the widest place of the room, and stays.
    """
    while (spurs := _find_spurs(diagram, clearance)).any():
        diagram = diagram & ~spurs
    return diagram


def _find_spurs(diagram: Mask, clearance: Floats) -> Mask:
    """Branches of the diagram from a fork to an end, shape (H, W), where the end has the least clearance."""
    around = cv2.boxFilter(diagram.astype(np.float32), -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
    # A cell counts itself, too.
    forks, ends = diagram & (around > 3.5), diagram & (around < 2.5)
    count, numbered = cv2.connectedComponents((diagram & ~forks).astype(np.uint8), connectivity=8)
    branches = np.asarray(numbered, np.intp)
    at_fork = np.zeros(count, bool)
    at_fork[branches[cv2.dilate(forks.astype(np.uint8), SQUARE) > 0]] = True
    least, at_end = np.full(count, np.inf), np.full(count, np.inf)
    np.minimum.at(least, branches[diagram], clearance[diagram])
    np.minimum.at(at_end, branches[ends], clearance[ends])
    is_spur = at_fork & (at_end <= least) & np.isfinite(at_end)
    is_spur[0] = False
    return np.asarray(is_spur[branches])


def find_critical_points(diagram: Mask, clearance: Floats, resolution: float, parameters: VoronoiParameters) -> Indices:
    """Row and col of the critical points, shape (N, 2), the narrowest first."""
    points = np.argwhere(diagram)
    here = clearance[diagram]
    # The narrower the place, the wider it looks around: a door is a minimum among rooms.
    reach = np.minimum(parameters.neighbourhood / 2 / (here * resolution), parameters.longest_walk) / resolution
    beside = _list_neighbours(diagram, points)
    least, is_least = here, np.ones(len(points), bool)
    for step in range(1, int(reach.max(initial=0)) + 1):
        # One more cell along the diagram, to all sides
        wider = least[beside].min(axis=1)
        if (wider == least).all():
            break
        least = wider
        is_least &= (step > reach) | (here <= least)
    return np.asarray(points[is_least][np.argsort(here[is_least], kind="stable")])


def _list_neighbours(diagram: Mask, points: Indices) -> Indices:
    """Index of each point and of the points beside it, the point itself where there is none; shape (N, 9)."""
    own = np.arange(len(points))
    index = np.full(np.add(diagram.shape, 2), -1, np.intp)
    rows, cols = points.T + 1
    index[rows, cols] = own
    beside = np.column_stack([index[rows + down, cols + right] for down in (-1, 0, 1) for right in (-1, 0, 1)])
    return np.where(beside < 0, own[:, None], beside)


def draw_critical_lines(critical: Indices, clearance: Floats, spacing: float) -> Mask:
    """Cells on the critical lines, shape (H, W): each from obstacle to obstacle, one cell wide."""
    from scipy.spatial import KDTree

    # The edge of the map is an obstacle.
    walls = np.argwhere(np.pad(clearance, 1) == 0) - 1
    tree = KDTree(walls)
    lines = np.zeros(clearance.shape, np.uint8)
    kept = np.zeros((0, 2), np.intp)
    for point in critical:
        width = clearance[tuple(point)]
        if np.hypot(*(kept - point).T).min(initial=np.inf) < spacing * width:
            continue
        near = walls[tree.query_ball_point(point, LOPSIDED * width + 1, return_sorted=True)] - point
        bases = _find_base_points(near)
        if bases is not None:
            kept = np.vstack([kept, point])
            for row, col in (bases + point).tolist():
                cv2.line(lines, point[::-1].tolist(), (col, row), 1)
    return lines > 0


def _find_base_points(near: Indices) -> Indices | None:
    """The nearest of some obstacles, and the nearest one more than 90° away from it; None where there is none."""
    lengths = np.hypot(*near.T)
    first = near[lengths.argmin()]
    opposite = near @ first < 0
    if not opposite.any():
        return None
    return np.array([first, near[opposite][lengths[opposite].argmin()]])
