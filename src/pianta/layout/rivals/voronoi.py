"""Voronoi segmentation of the survey (Bormann et al., ICRA 2016): rooms between narrow passages.

The survey follows Thrun and Bücken (AAAI 1996): critical points, critical lines, and cells that are then merged.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from math import inf

import cv2
import numpy as np

from pianta._types import Floats, Indices, LabelImage, Mask
from pianta.gridmap import GridMap
from pianta.layout._label_images import grow_mask
from pianta.layout._voronoi_doors import draw_voronoi_diagram
from pianta.layout.parameters import Parameters, check_parameters
from pianta.layout.rivals.patches import grow_labels, label_patches, measure_padded_clearance

# A point of the diagram is equally far from its two base points; on the grid one may be this many times as far as the
# other (chosen by hand).
MAX_BASE_RATIO = 1.5
# Label of cells that are not free, and of those beyond the edge of the map.
WALL = 0


@dataclass(frozen=True, kw_only=True)
class MergeRule:
    """When a cell is merged into a neighbour; of several neighbours the one with the longest common border is chosen.

    area: the cell has at most this area, m².
    neighbours: it has at most this number of neighbours.
    wall: at most this share of its perimeter is wall.
    shared: more than this share of its perimeter is common border.
    shared_back: more than this share of the neighbour's perimeter is common border.
    """

    area: float = inf
    neighbours: float = inf
    wall: float = 1.0
    shared: float = 0.0
    shared_back: float = 0.0


@dataclass(frozen=True, kw_only=True)
class VoronoiParameters(Parameters):
    """Thresholds of the Voronoi segmentation.

    The defaults are those of the survey's program, except passage_width, which was chosen on the survey's maps, and the
    rules, which are quoted from memory of the paper (docs/methods/segmentation.md).

    passage_width: gaps up to this width are not passages, and the diagram does not lead through them; metres.
    neighbourhood: the stretch of the diagram in which a critical point has the least clearance is this long, divided
        by that clearance; m² (280 cells of 0.05 m squared).
    longest_walk: that stretch reaches no further to either side; metres (150 cells of 0.05 m).
    spacing: of two critical points less than this many clearances apart the wider one is dropped.
    smallest, largest: area of a cell between critical lines, m²; others are divided among the cells beside them.
    rules: when a cell is merged into another, applied in this order.
    """

    passage_width: float = 0.3
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


def segment_by_voronoi_diagram(grid: GridMap, *, parameters: Parameters | None = None) -> LabelImage:
    """Segment a grid map into rooms; returns a label image, shape (H, W): 0 no room, 1 … N.

    Critical lines through the narrow points of the Voronoi diagram cut the free space into cells, and rules merge cells
    into rooms.
    """
    thresholds = check_parameters(parameters, VoronoiParameters)
    clearance = measure_padded_clearance(grid.free)
    # The generalised Voronoi diagram, without the branches into corners
    passable = clearance > thresholds.passage_width / 2 / grid.resolution
    diagram = prune_diagram(draw_voronoi_diagram(grid.free) & passable, clearance)
    # Critical points: the narrowest of their stretch of the diagram
    critical = find_critical_points(diagram, clearance, grid.resolution, thresholds)
    # Critical lines: from each to the nearest obstacles on either side
    lines = draw_critical_lines(critical, clearance, thresholds.spacing)
    # Cells between the lines
    patches, areas = label_patches(grid.free & ~lines, grid.resolution)
    is_cell = (thresholds.smallest <= areas) & (areas <= thresholds.largest)
    cells = grow_labels(np.where(is_cell, np.cumsum(is_cell), 0).astype(np.int32)[patches], grid.free)
    # Rooms of one or more cells
    return merge_cells(cells, grid.resolution, thresholds.rules)


def prune_diagram(diagram: Mask, clearance: Floats) -> Mask:
    """The diagram, shape (H, W), without the branches that only run into corners, towards less and less clearance.

    A branch that leads through a passage into a room ends at the widest point of the room, and stays.
    """
    while (spurs := _find_spurs(diagram, clearance)).any():
        diagram = diagram & ~spurs
    return diagram


def _find_spurs(diagram: Mask, clearance: Floats) -> Mask:
    """Branches of the diagram from a fork to an end, shape (H, W), whose end has the least clearance."""
    around = cv2.boxFilter(diagram.astype(np.float32), -1, (3, 3), normalize=False, borderType=cv2.BORDER_CONSTANT)
    # A cell counts itself, too.
    forks, ends = diagram & (around > 3.5), diagram & (around < 2.5)
    count, components = cv2.connectedComponents((diagram & ~forks).astype(np.uint8), connectivity=8)
    branches = np.asarray(components, np.intp)
    at_fork = np.zeros(count, bool)
    at_fork[branches[grow_mask(forks, 1)]] = True
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
    # The neighbourhood of a narrow point is larger: a door is a minimum among whole rooms.
    reach = np.minimum(parameters.neighbourhood / 2 / (here * resolution), parameters.longest_walk) / resolution
    neighbours = _list_neighbours(diagram, points)
    least, is_least = here, np.ones(len(points), bool)
    for step in range(1, int(reach.max(initial=0)) + 1):
        # Widen the neighbourhoods by one cell along the diagram
        wider = least[neighbours].min(axis=1)
        if (wider == least).all():
            break
        least = wider
        is_least &= (step > reach) | (here <= least)
    return np.asarray(points[is_least][np.argsort(here[is_least], kind="stable")])


def _list_neighbours(diagram: Mask, points: Indices) -> Indices:
    """Index of each point and of its neighbours, or of the point itself instead of a missing one; shape (N, 9)."""
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
    selected = np.zeros((0, 2), np.intp)
    for point in critical:
        width = clearance[tuple(point)]
        if np.hypot(*(selected - point).T).min(initial=np.inf) < spacing * width:
            continue
        near = walls[tree.query_ball_point(point, MAX_BASE_RATIO * width + 1, return_sorted=True)] - point
        bases = _find_base_points(near)
        if bases is not None:
            selected = np.vstack([selected, point])
            for row, col in (bases + point).tolist():
                cv2.line(lines, point[::-1].tolist(), (col, row), 1)
    return lines > 0


def _find_base_points(near: Indices) -> Indices | None:
    """The nearest obstacle, and the nearest one more than 90° away from it; None if there is no such obstacle."""
    lengths = np.hypot(*near.T)
    first = near[lengths.argmin()]
    opposite = near @ first < 0
    if not opposite.any():
        return None
    return np.array([first, near[opposite][lengths[opposite].argmin()]])


@dataclass(frozen=True, eq=False)
class Cells:
    """Areas and common borders of cells; both change when cells are merged.

    area: m² of each cell, 0 for a cell that was merged into another.
    border: for each cell its neighbours, WALL among them, and the number of cell sides shared with each.
    """

    area: list[float]
    border: list[dict[int, float]]

    def merge(self, cell: int, into: int) -> None:
        """Make one cell of two."""
        self.area[into] += self.area[cell]
        self.area[cell] = 0.0
        for neighbour, sides in self.border[cell].items():
            del self.border[neighbour][cell]
            if neighbour != into:
                self.border[into][neighbour] = self.border[into].get(neighbour, 0) + sides
                self.border[neighbour][into] = self.border[neighbour].get(into, 0) + sides
        self.border[cell].clear()

    def find_partner(self, cell: int, rule: MergeRule) -> int | None:
        """The neighbour that a rule merges a cell into, if any."""
        border = self.border[cell]
        perimeter = sum(border.values())
        neighbours = sorted(border.keys() - {WALL})
        closed = border.get(WALL, 0) > rule.wall * perimeter
        if closed or self.area[cell] > rule.area or len(neighbours) > rule.neighbours:
            return None
        partners = [
            other
            for other in neighbours
            if border[other] > rule.shared * perimeter
            and border[other] > rule.shared_back * sum(self.border[other].values())
        ]
        return max(partners, key=lambda other: border[other], default=None)


def measure_cells(labels: LabelImage, resolution: float) -> Cells:
    """Areas and common borders of the cells of a label image, shape (H, W)."""
    count = int(labels.max()) + 1
    around = np.pad(labels, 1).astype(np.int64)
    steps = ((around[:-1], around[1:]), (around[:, :-1], around[:, 1:]))
    pairs = np.concatenate([(here * count + there)[here != there] for here, there in steps])
    border: list[dict[int, float]] = [{} for _ in range(count)]
    for pair, sides in zip(*(part.tolist() for part in np.unique(pairs, return_counts=True)), strict=True):
        for cell, other in (divmod(pair, count), divmod(pair, count)[::-1]):
            border[cell][other] = border[cell].get(other, 0) + sides
    area = np.bincount(labels.ravel(), minlength=count) * resolution**2
    return Cells(area.tolist(), border)


def merge_cells(labels: LabelImage, resolution: float, rules: Iterable[MergeRule]) -> LabelImage:
    """Rooms, shape (H, W), 1 … N: cells merged by the rules, which are applied one after the other."""
    cells = measure_cells(labels, resolution)
    owner = np.arange(len(cells.area))
    for rule in rules:
        for cell, partner in _apply_rule(cells, rule):
            owner[owner == cell] = partner
    rooms = np.unique(owner)
    return np.searchsorted(rooms, owner).astype(np.int32)[labels]


def _apply_rule(cells: Cells, rule: MergeRule) -> list[tuple[int, int]]:
    """Merge the smallest cell that the rule applies to, again and again; returns the pairs, in order."""
    merged = []
    queue = [(area, cell) for cell, area in enumerate(cells.area) if area > 0 and cell != WALL]
    heapify(queue)
    while queue:
        area, cell = heappop(queue)
        # A cell that has changed since is in the queue again, with its new area.
        partner = cells.find_partner(cell, rule) if area == cells.area[cell] else None
        if partner is None:
            continue
        cells.merge(cell, partner)
        merged.append((cell, partner))
        for changed in (partner, *cells.border[partner].keys() - {WALL}):
            heappush(queue, (cells.area[changed], changed))
    return merged
