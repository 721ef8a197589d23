"""The path on which a round robot sweeps a room: lanes of a boustrophedon decomposition, and what they leave out."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import dist, inf

import cv2
import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.navigation.boustrophedon import Lane, Lanes, decompose
from pianta.navigation.free_space import FreeSpace, cross_cells
from pianta.navigation.lattice import build_lattice, straighten_way
from pianta.navigation.positions import Cell

# Of the robot's width, between lanes: a little less than 1, so that ends of lanes leave no gaps. Chosen by hand.
LANE_SPACING = 0.9
# Patches that the lanes leave out are visited if they are at least this large, square metres. Chosen by hand.
MIN_PATCH = 0.06
# Metres between points of a path from which a robot visits a patch.
INSERT_STEP = 0.5
# Where a way between two points is looked for, one after the other: metres around them, and the cells between points
# of the lattice. Chosen by hand.
SEARCHES = ((1.0, 1), (5.0, 4), (20.0, 4), (inf, 4), (inf, 1))


@dataclass(frozen=True, eq=False)
class SweepArea:
    """What is swept: the open cells of a room, in a window of the map.

    space: of the whole map. part: shape (h, w). corner: row, col of its first cell on the map.
    """

    space: FreeSpace
    part: Mask
    corner: Cell

    @property
    def radius_px(self) -> float:
        """Radius of the robot, cells."""
        return self.space.radius / self.space.grid.resolution


def sweep_room(area: SweepArea, start: Cell) -> Indices:
    """The corners of a path that sweeps an area, row and col in its window, shape (N, 2); start: where the robot is."""
    # 1. Lanes nearly a robot's width apart, in the cells of the decomposition.
    lanes = decompose(area.part, LANE_SPACING * 2 * area.radius_px)
    # 2. The nearest cell next, lane by lane.
    path = connect_points(area, order_lanes(lanes, start))
    # 3. What the lanes leave out, from where the path is nearest.
    patches = _choose_patch_visits(area, path)
    return _insert_visits(area, path, patches)


def sweep_once(area: SweepArea) -> Indices:
    """The path of a plain sweep: all lanes a robot's width apart, one after the other, and nothing else."""
    lanes = decompose(area.part, 2 * area.radius_px)
    ordered = sorted(lane for cell in lanes.cells for lane in cell)
    return connect_points(area, _follow_lanes(lanes, ordered, lanes.locate_ends(ordered[0])[0]))


def order_lanes(lanes: Lanes, start: Cell) -> list[Cell]:
    """The ends of all lanes in the order of the path: in each cell from one side to the other, nearest cell next."""
    left, points = [*lanes.cells], [start]
    while left:
        choices = [(index, cell) for index, lane in enumerate(left) for cell in (lane, lane[::-1])]

        distances = [min(dist(points[-1], end) for end in lanes.locate_ends(cell[0])) for _, cell in choices]
        index, cell = choices[distances.index(min(distances))]
        left.pop(index)
        points += _follow_lanes(lanes, cell, points[-1])
    return points[1:]


def find_swept_cells(paths: list[Indices], shape: tuple[int, int], radius_px: float) -> Mask:
    """The cells whose middles are at most the radius from a path, shape (H, W); paths: corners, row and col."""
    apart = np.ones(shape, np.uint8)
    for path in paths:
        for start, end in pairwise(path.astype(float) + 0.5) if len(path) > 1 else [(path[0] + 0.5, path[0] + 0.5)]:
            # Ways around obstacles may leave the window
            cells = cross_cells(start, end)[0]
            cells = cells[((cells >= 0) & (cells < shape)).all(axis=1)]
            apart[tuple(cells.T)] = 0
    return dilate(apart == 0, radius_px)


def dilate(mask: Mask, radius_px: float) -> Mask:
    """The cells whose middles are at most the radius from that of a cell of the mask."""
    distances = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(distances <= radius_px + 1e-3)


def measure_length(path: Floats | Indices) -> float:
    """The length of a path, in the unit of its corners, shape (N, 2)."""
    return float(np.hypot(*np.diff(np.asarray(path, float), axis=0).T).sum())


def connect_points(area: SweepArea, points: list[Cell]) -> Indices:
    """The corners of the path through points: straight where that is open, else the shortest way that keeps clear."""
    path = [points[0]]
    for point in (each for each, before in zip(points[1:], points, strict=False) if each != before):
        start, end = np.add(path[-1], area.corner), np.add(point, area.corner)
        if area.space.measure_cost(start, end) < inf and area.space.is_straight(start, end):
            path.append(point)
        else:
            path += [tuple(cell) for cell in (find_way(area, path[-1], point)[1:]).tolist()]
    return _drop_straight_points(np.array(path))


def find_way(area: SweepArea, start: Cell, end: Cell) -> Indices:
    """The corners of a way between two cells of the window; only its start where the floor has none."""
    space, corner = area.space, np.array(area.corner)
    ends = np.array([start, end]) + corner
    for margin, stride in SEARCHES:
        reach = min(margin / space.grid.resolution, max(space.open.shape))
        low, high = np.maximum(ends.min(axis=0) - reach, 0).astype(int), (ends.max(axis=0) + reach).astype(int) + 1
        window = slice(low[0], high[0]), slice(low[1], high[1])
        way = _find_way_in(space, (int(low[0]), int(low[1])), space.open[window], ends, stride)
        if way is not None:
            return np.asarray(way - corner, np.intp)
    return np.array([start])


def _find_way_in(space: FreeSpace, corner: Cell, part: Mask, ends: Indices, stride: int) -> Indices | None:
    """The corners of the shortest way over every stride-th cell of a part of the map; None without one."""
    from scipy.sparse.csgraph import dijkstra

    near = [_find_lattice_cell(space, (int(row), int(col)), stride) for row, col in ends]
    if None in near:
        return None
    lattice = build_lattice(space, part, corner, stride)
    first, last = (lattice.find_point(cell) for cell in near if cell is not None)
    if -1 in (first, last):
        return None
    costs, previous = dijkstra(lattice.costs, directed=False, indices=first, return_predecessors=True)
    if costs[last] == inf:
        return None
    numbers = [last]
    while numbers[-1] != first:
        numbers.append(int(previous[numbers[-1]]))
    numbers.reverse()
    corners = straighten_way(space, lattice.points[numbers], costs[numbers])
    return np.concatenate([ends[:1], corners, ends[1:]])


def _find_lattice_cell(space: FreeSpace, cell: Cell, stride: int) -> Cell | None:
    """A cell whose row and col are multiples of a stride, in sight of a cell beside it; None without one."""
    rows, cols = ({index - index % stride, index + -index % stride} for index in cell)
    height, width = space.open.shape
    choices = [(row, col) for row in sorted(rows) for col in sorted(cols) if row < height and col < width]
    return next((choice for choice in choices if space.is_straight(cell, choice)), None)


def _follow_lanes(lanes: Lanes, ordered: list[Lane] | tuple[Lane, ...], start: Cell) -> list[Cell]:
    """The ends of lanes one after the other, each entered at its nearer end."""
    points = [start]
    for lane in ordered:
        points += sorted(lanes.locate_ends(lane), key=lambda end: dist(points[-1], end))
    return points[1:]


def _choose_patch_visits(area: SweepArea, path: Indices) -> list[list[Cell]]:
    """For each patch that a path leaves out the cells from which the robot sweeps it, in order along the patch."""
    missing = dilate(area.part, area.radius_px) & ~find_swept_cells([path], area.part.shape, area.radius_px)
    count, patches, stats, _ = cv2.connectedComponentsWithStats(missing.astype(np.uint8), connectivity=8)
    least = MIN_PATCH / area.space.grid.resolution**2
    inside = np.argwhere(area.part)
    large = [number for number in range(1, count) if stats[number, cv2.CC_STAT_AREA] >= least]
    return [_cover_patch(np.argwhere(patches == number), inside, area.radius_px, least) for number in large]


def _cover_patch(patch: Indices, inside: Indices, radius_px: float, least: float) -> list[Cell]:
    """Cells inside from which discs cover a patch, up to a remainder: each time the best for one end of it."""
    low, high = patch.min(axis=0) - radius_px, patch.max(axis=0) + radius_px
    near = inside[((inside >= low) & (inside <= high)).all(axis=1)]
    visits: list[Cell] = []
    axis = int(np.ptp(patch, axis=0).argmax())
    while len(patch) >= (least if visits else 1):
        first = patch[int(patch[:, axis].argmin())]
        able = near[np.hypot(*(near - first).T) <= radius_px + 1e-3]
        if not len(able):
            patch = patch[(patch != first).any(axis=1)]
            continue
        # Of the cells that reach the end of the patch the one from which most of it is reached
        cell = able[int(able[:, axis].argmax())]
        covered = np.hypot(*(patch - cell).T) <= radius_px + 1e-3
        visits.append((int(cell[0]), int(cell[1])))
        patch = patch[~covered]
    return visits


def _insert_visits(area: SweepArea, path: Indices, visits: list[list[Cell]]) -> Indices:
    """The path with the visits where they make it least longer; it comes back to where it was left."""
    step = INSERT_STEP / area.space.grid.resolution
    points: list[Cell] = []
    for start, end in pairwise(path.tolist()):
        # A slanting line would leave its cells by rounding
        is_lane = start[0] == end[0] or start[1] == end[1]
        pieces = max(round(dist(start, end) / step), 1) if is_lane else 1
        points += [(round(row), round(col)) for row, col in np.linspace(start, end, pieces + 1)[:-1].tolist()]
    points.append((int(path[-1][0]), int(path[-1][1])))
    inserts: dict[int, list[Cell]] = {}
    array = np.array(points, float)
    for visit in filter(None, visits):
        to_first, to_last = (np.hypot(*(array - end).T) for end in (visit[0], visit[-1]))
        index = int((to_first + to_last).argmin())
        inserts.setdefault(index, []).extend(visit if to_first[index] <= to_last[index] else visit[::-1])
    loops = [connect_points(area, [point, *inserts.get(index, []), point]) for index, point in enumerate(points)]
    return _drop_straight_points(np.concatenate(loops))


def _drop_straight_points(path: Indices) -> Indices:
    """The path without repeated corners and those at which it goes straight on."""
    path = path[np.concatenate([[True], (np.diff(path, axis=0) != 0).any(axis=1)])]
    if len(path) < 3:
        return path
    before, after = path[1:-1] - path[:-2], path[2:] - path[1:-1]
    turns = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    ahead = (before * after).sum(axis=1)
    keep = np.concatenate([[True], (turns != 0) | (ahead < 0), [True]])
    return np.asarray(path[keep])
