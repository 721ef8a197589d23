"""The path on which a round robot sweeps a room: lanes of a boustrophedon decomposition, and what they leave out."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import ceil, dist, inf

import cv2
import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.navigation.boustrophedon import Lane, Lanes, decompose
from pianta.navigation.free_space import FreeSpace
from pianta.navigation.lattice import Lattice, build_lattice, find_stride, straighten_way, trace_back
from pianta.navigation.positions import Cell

# Of the robot's width, between lanes: a little less than 1, so that ends of lanes leave no gaps. Chosen by hand.
LANE_SPACING = 0.9
# Patches that the lanes leave out are visited if they are at least this large, square metres. Chosen by hand.
MIN_PATCH = 0.06
# Metres between points of a path from which a robot visits a patch.
INSERT_STEP = 0.25
# Points of a path that are tried as the start of a straight visit, the nearest ones. Chosen by hand.
MAX_STARTS = 16
# Costs up to which ways in a room are looked for, one after the other: most are short. Chosen by hand.
LIMITS = (2.0, 8.0, inf)
# Ways times points of a lattice that are searched at once: 50 MB. Chosen by hand.
MAX_SEARCHED = 4_000_000
# Where a way that the lattice of the room lacks is looked for, one after the other: metres around its ends, and the
# cells between points of the lattice. Chosen by hand.
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

    @cached_property
    def lattice(self) -> Lattice:
        """The lattice of its cells, on which ways are looked for first."""
        return build_lattice(self.space, self.part, self.corner, find_stride(self.space.grid.resolution))

    @cached_property
    def fine_lattice(self) -> Lattice:
        """The lattice of all its cells, for passages that the other lacks."""
        return build_lattice(self.space, self.part, self.corner, 1)


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
        # A path of one point is a line too
        corners = np.concatenate([path, path[-1:]])[:, ::-1].astype(np.int32)
        cv2.polylines(apart, [corners], isClosed=False, color=0)
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
    return _drop_straight_points(_connect_routes(area, [points])[0])


def _connect_routes(area: SweepArea, routes: list[list[Cell]]) -> list[Indices]:
    """The corners of the path through the points of each route."""
    steps = {step for route in routes for step in pairwise(route) if step[0] != step[1]}
    # There and back on the same way
    closed = {min(step, step[::-1]) for step in steps if not _is_straight(area, *step)}
    ways = _find_ways(area, sorted(closed))
    ways |= {(end, start): way[::-1] for (start, end), way in ways.items()}
    paths = []
    for route in routes:
        pieces = [ways[step][1:] if step in ways else np.array([step[1]]) for step in pairwise(route)]
        paths.append(np.concatenate([np.array(route[:1]), *pieces]))
    return paths


def _is_straight(area: SweepArea, start: Cell, end: Cell) -> bool:
    top, left = area.corner
    return area.space.is_straight((start[0] + top, start[1] + left), (end[0] + top, end[1] + left))


def _find_ways(area: SweepArea, pairs: list[tuple[Cell, Cell]]) -> dict[tuple[Cell, Cell], Indices]:
    """The corners of a way between the cells of each pair, in the window: in the room, else elsewhere on the floor."""
    ways: dict[tuple[Cell, Cell], Indices] = {}
    for fine in (False, True):
        left = [pair for pair in pairs if pair not in ways]
        if left:
            ways |= _find_ways_on(area, area.fine_lattice if fine else area.lattice, left)
    return ways | {pair: find_way(area, *pair) for pair in pairs if pair not in ways}


def _find_ways_on(
    area: SweepArea, lattice: Lattice, pairs: list[tuple[Cell, Cell]]
) -> dict[tuple[Cell, Cell], Indices]:
    """The corners of the ways between those pairs of cells that a lattice of an area joins."""
    numbers = {cell: _find_lattice_point(area, lattice, cell) for cell in {cell for pair in pairs for cell in pair}}
    joined = {pair: (numbers[pair[0]], numbers[pair[1]]) for pair in pairs}
    traced = _trace_ways(lattice, {each for each in joined.values() if -1 not in each})
    corner = np.array(area.corner)
    ways = {}
    for (start, end), each in ((pair, each) for pair, each in joined.items() if each in traced):
        cells = np.concatenate([[start + corner], traced[each][0], [end + corner]])
        ways[start, end] = straighten_way(area.space, cells) - corner
    return ways


def _find_lattice_point(area: SweepArea, lattice: Lattice, cell: Cell) -> int:
    """The number of a point of a lattice, in sight of a cell of the window of an area beside it; -1 without one."""
    on_map = cell[0] + area.corner[0], cell[1] + area.corner[1]
    choices = map(lattice.find_point, _list_sights(area.space, on_map, lattice.stride))
    return next((number for number in choices if number >= 0), -1)


def _trace_ways(lattice: Lattice, pairs: Iterable[tuple[int, int]]) -> dict[tuple[int, int], tuple[Indices, Floats]]:
    """For each pair of points that a lattice joins the cells of the shortest way, and the cost up to each of them."""
    from scipy.sparse.csgraph import dijkstra

    left, traced = sorted(pairs), {}
    most = max(MAX_SEARCHED // max(len(lattice.points), 1), 1)
    for limit in LIMITS:
        starts = sorted({start for start, _ in left})
        for chosen in (starts[index : index + most] for index in range(0, len(starts), most)):
            costs, previous = dijkstra(lattice.costs, indices=chosen, limit=limit, return_predecessors=True)
            rows = {start: row for row, start in enumerate(chosen)}
            for start, end in (pair for pair in left if pair[0] in rows and costs[rows[pair[0]], pair[1]] < inf):
                numbers = trace_back(previous[rows[start]], end)
                traced[start, end] = lattice.points[numbers], costs[rows[start], numbers]
        left = [pair for pair in left if pair not in traced]
    return traced


def find_way(area: SweepArea, start: Cell, end: Cell) -> Indices:
    """The corners of a way between two cells of the window, anywhere on the floor; only its start without one."""
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
    near = [next(_list_sights(space, (int(row), int(col)), stride), None) for row, col in ends]
    if None in near:
        return None
    lattice = build_lattice(space, part, corner, stride)
    first, last = (lattice.find_point(cell) for cell in near if cell is not None)
    if -1 in (first, last):
        return None
    traced = _trace_ways(lattice, [(first, last)])
    if not traced:
        return None
    return np.concatenate([ends[:1], straighten_way(space, *traced[first, last]), ends[1:]])


def _list_sights(space: FreeSpace, cell: Cell, stride: int) -> Iterator[Cell]:
    """The cells whose row and col are multiples of a stride that are beside a cell and in sight of it."""
    rows, cols = ({index - index % stride, index + -index % stride} for index in cell)
    height, width = space.open.shape
    choices = [(row, col) for row in sorted(rows) for col in sorted(cols) if row < height and col < width]
    return (choice for choice in choices if space.is_straight(cell, choice))


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
    large = [number for number in range(1, count) if stats[number, cv2.CC_STAT_AREA] >= least]
    reach = ceil(area.radius_px)
    visits = []
    for number in large:
        left, top, width, height = stats[number, :4].tolist()
        row, col = max(top - reach, 0), max(left - reach, 0)
        window = slice(row, top + height + reach), slice(col, left + width + reach)
        patch = np.argwhere((patches[window] == number) & missing[window])
        near, corner = np.argwhere(area.part[window]), np.array([row, col])
        if len(patch) < least:
            continue
        visits.append(_cover_patch(patch + corner, near + corner, area.radius_px, least))
        for cell in visits[-1]:
            # What other patches have there is swept too
            cv2.circle(missing.view(np.uint8), cell[::-1], int(area.radius_px), 0, cv2.FILLED)
    return visits


def _cover_patch(patch: Indices, near: Indices, radius_px: float, least: float) -> list[Cell]:
    """Cells near a patch from which discs cover it, up to a remainder: each time the best for one end of it."""
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
        index, ordered = _choose_start(area, array, visit)
        inserts.setdefault(index, []).extend(ordered)
    loops = _connect_routes(area, [[points[index], *visit, points[index]] for index, visit in inserts.items()])
    visited = dict(zip(inserts, loops, strict=True))
    chosen = [visited.get(index, array[index : index + 1].astype(np.intp)) for index in range(len(points))]
    return _drop_straight_points(np.concatenate(chosen))


def _choose_start(area: SweepArea, points: Floats, visit: list[Cell]) -> tuple[int, list[Cell]]:
    """The number of the point from which a visit makes a path least longer, and the visit from its nearer end.

    Points in sight come first.
    """
    to_first, to_last = (np.hypot(*(points - end).T) for end in (visit[0], visit[-1]))
    order = np.argsort(to_first + to_last, kind="stable")[:MAX_STARTS].tolist()
    ordered = [(index, visit if to_first[index] <= to_last[index] else visit[::-1]) for index in order]
    in_sight = (each for each in ordered if _is_straight(area, tuple(points[each[0]].astype(int)), each[1][0]))
    return next(in_sight, ordered[0])


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
