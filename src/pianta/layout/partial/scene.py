"""A partial room with its surroundings, on cells aligned with its walls."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import ceil, cos, sin
from typing import TypeAlias

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, STRtree

from pianta._types import Floats, Indices, Mask
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.layout._label_images import grow_mask

Window: TypeAlias = tuple[slice, slice]
# First row and column, last row and column, inclusive.
Bounds: TypeAlias = tuple[int, int, int, int]

# The constants of a scene belong to the features that the model was fitted to (chosen by hand).
# Smallest cells of a scene; metres.
MIN_CELL = 0.1
# Cells along a side of a scene, at most; a limit of memory.
MAX_CELLS = 900
# Cells along a side of the room; longer ones are drawn in larger cells, a limit of time.
MAX_ROOM_CELLS = 300
# Surroundings of the room in a scene; metres.
SURROUNDINGS = 20.0
# Distance from the room over which the weight of a wall for the main direction falls to 1/e; metres.
DIRECTION_DECAY = 10.0
# Unknown cells this near to an obstacle are the grey of a wall; metres.
GREY_WIDTH = 0.25
# Cells at most this far from a wall or a room are at it; metres.
NEAR_DISTANCE = 0.3
# Obstacles of a smaller extent are furniture; metres.
FURNITURE_SIZE = 1.5
# Walls at most this far from a room count for the main direction, and for the lines of its scene: four times the
# distances over which their weights fall to 1/e, beyond which less than 2 % is left; metres, limits of time.
DIRECTION_REACH = 40.0
LINES_REACH = 60.0
# Nearest complete rooms with which a room is compared, at most; a limit of time.
MAX_COMPARED_ROOMS = 200
# Extents of other rooms, if no complete room was observed; metres.
USUAL_EXTENT = np.array([[4.0, 5.0]])
# Bits of observed cells.
OCCUPIED = 1
WALL = 2
UNKNOWN = 4
# Sub-pixel bits of the coordinates of polygons that are drawn with OpenCV.
SHIFT = 6


@dataclass(frozen=True, eq=False)
class View:
    """A rectangular window of cells, rotated against the map frame.

    angle: of the direction of growing columns against x; radians. corner: x, y of the outer corner of the first cell,
    rotated by -angle; metres. shape: number of rows, which count upwards, and of columns. cell: metres.
    """

    angle: float
    corner: Floats
    shape: tuple[int, int]
    cell: float

    @property
    def window(self) -> Polygon:
        """Its outline in the map frame."""
        height, width = self.shape
        return Polygon(self.to_map(np.array([[0, 0], [width, 0], [width, height], [0, height]], float)))

    def from_map(self, xy: Floats) -> Floats:
        """Col and row, shape (N, 2), continuous, of points in the map frame."""
        c, s = cos(self.angle), sin(self.angle)
        return np.asarray((xy @ np.array([[c, -s], [s, c]]) - self.corner) / self.cell)

    def to_map(self, pixels: Floats) -> Floats:
        """Points in the map frame, shape (N, 2), of col and row."""
        c, s = cos(self.angle), sin(self.angle)
        return np.asarray((pixels * self.cell + self.corner) @ np.array([[c, s], [-s, c]]))

    def draw(self, polygons: Sequence[Polygon]) -> Mask:
        """Cells in any of the polygons, which do not overlap, shape (H, W)."""
        image = np.zeros(self.shape, np.uint8)
        for polygon in polygons:
            rings = [
                np.rint((self.from_map(shapely.get_coordinates(ring)) - 0.5) * 2**SHIFT).astype(np.int32)
                for ring in (polygon.exterior, *polygon.interiors)
            ]
            cv2.fillPoly(image, rings, 1, shift=SHIFT)
        return image.astype(bool)

    def sample(self, cells: NDArray[np.uint8], grid: GridMap, *, beyond: int) -> NDArray[np.uint8]:
        """Values of a grid map's cells at the centres of the cells of the view, shape (H, W).

        beyond: the value beyond the map.
        """
        # The pixel is an affine function of the cell, so three corners give those of all cells
        corners = self.to_map(np.array([[0.5, 0.5], [1.5, 0.5], [0.5, 1.5]]))
        pixels = [np.asarray(pixel) for pixel in grid.map_to_pixel(*corners.T)]
        rows, cols = np.arange(self.shape[0]), np.arange(self.shape[1])
        row, col = (
            np.floor(np.add.outer(first + rows * (below - first), cols * (beside - first))).astype(np.int32)
            for first, beside, below in pixels
        )
        inside = (row >= 0) & (row < grid.shape[0]) & (col >= 0) & (col < grid.shape[1])
        values = cells[row.clip(0, grid.shape[0] - 1), col.clip(0, grid.shape[1] - 1)]
        values[~inside] = beyond
        return np.asarray(values)


@dataclass(frozen=True, eq=False)
class RoomScene:
    """A partial room and its surroundings; masks have the shape (H, W) of the view.

    observed: the room as it was observed. others: other rooms, and predictions for them. complete: those of them that
    were seen whole. occupied: obstacles. walls: those of them that are no furniture. unknown: cells that were not seen.
    frontier: cells of the room beside unknown space. extents: shape (N, 2), of the complete rooms, along the
    columns and along the rows of the view, metres. lines: shape (L, 2, 2), walls of the building: end, then col, row.
    doors: number of doors of the room. door_lines: shape (D, 2, 2), passages of the building, as lines.
    """

    view: View
    observed: Mask
    others: Mask
    complete: Mask
    occupied: Mask
    walls: Mask
    unknown: Mask
    frontier: Mask
    extents: Floats
    lines: Floats
    doors: int
    door_lines: Floats

    @cached_property
    def blocked(self) -> Mask:
        """Cells that the room cannot contain."""
        return np.asarray((self.others | self.walls) & ~self.observed)

    @cached_property
    def possible(self) -> Mask:
        """Cells beyond the observed ones that the room can contain."""
        return ~(self.blocked | self.observed)

    @cached_property
    def near_frontier(self) -> Mask:
        """The frontier and the cells beside it, shape (H, W)."""
        return grow_mask(self.frontier, 1)

    @property
    def near(self) -> int:
        """Number of cells up to which a cell counts as at a wall."""
        return max(1, round(NEAR_DISTANCE / self.view.cell))

    @cached_property
    def near_walls(self) -> Mask:
        """Cells at walls, shape (H, W)."""
        return grow_mask(self.walls, self.near)

    @cached_property
    def near_rooms(self) -> Mask:
        """Cells at other rooms, shape (H, W)."""
        return grow_mask(self.others, self.near)

    @cached_property
    def bounds(self) -> Bounds:
        """Bounds of the observed cells."""
        return find_bounds(self.observed)

    @cached_property
    def observed_count(self) -> int:
        """Number of observed cells."""
        return int(np.count_nonzero(self.observed))

    @property
    def observed_area(self) -> float:
        """Area of the observed cells, m²."""
        return self.observed_count * self.view.cell**2

    @cached_property
    def log_extents(self) -> Floats:
        """Logarithms of the shorter and the longer extent of the complete rooms, or of a usual one; shape (N, 2)."""
        return np.asarray(np.log(np.sort(self.extents if len(self.extents) else USUAL_EXTENT, axis=1)))

    @cached_property
    def median_log_area(self) -> float:
        """The median of the logarithms of their areas, m²."""
        return float(np.median(self.log_extents.sum(axis=1)))

    @cached_property
    def frontier_count(self) -> int:
        """Number of frontier cells."""
        return int(np.count_nonzero(self.frontier))

    def window(self, bounds: Bounds) -> Window:
        """Rows and columns of the room and of bounds, with a margin."""
        lows = (max(0, min(pair) - self.near - 1) for pair in zip(bounds[:2], self.bounds[:2], strict=True))
        highs = (max(pair) + self.near + 2 for pair in zip(bounds[2:], self.bounds[2:], strict=True))
        ends = (min(high, size) for high, size in zip(highs, self.observed.shape, strict=True))
        rows, cols = (slice(low, end) for low, end in zip(lows, ends, strict=True))
        return rows, cols


def find_bounds(mask: Mask) -> Bounds:
    """Bounds of the True cells of a mask, of which there is one at least."""
    rows, cols = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return int(rows[0]), int(cols[0]), int(rows[-1]), int(cols[-1])


@dataclass(frozen=True, eq=False)
class FloorIndex:
    """The rooms and walls of a floor, indexed by position, so that a scene costs the same on a floor of any size.

    rooms: indexed by `tree`. sides: shape (L, 2, 2), both ends of each segment of the walls and of the outlines of
    complete rooms; `side_tree` has them as lines. hulls: coordinates of the convex hull of each complete room.
    centers: shape (N, 2), of the complete rooms. doors: number of doors by room id. passages: shape (D, 2, 2), both
    ends of each segment of the doors; `passage_tree` has them as lines.
    """

    rooms: tuple[Room, ...]
    tree: STRtree
    sides: Floats
    side_tree: STRtree
    hulls: tuple[Floats, ...]
    centers: Floats
    doors: Counter[int]
    passages: Floats
    passage_tree: STRtree

    @classmethod
    def from_floor(cls, floor: Floor) -> FloorIndex:
        """The index of a floor."""
        complete = [room.polygon for room in floor.rooms if not room.partial]
        sides = _list_sides([*floor.walls, *(polygon.exterior for polygon in complete)])
        hulls = tuple(shapely.get_coordinates(polygon.convex_hull) for polygon in complete)
        centers = np.reshape([np.mean(np.reshape(polygon.bounds, (2, 2)), axis=0) for polygon in complete], (-1, 2))
        doors = Counter(room_id for door in floor.doors for room_id in door.room_ids)
        tree = STRtree([room.polygon for room in floor.rooms])
        passages = _list_sides([door.line for door in floor.doors])
        trees = [STRtree(shapely.linestrings(each)) for each in (sides, passages)]
        return cls(floor.rooms, tree, sides, trees[0], hulls, centers, doors, passages, trees[1])

    def find_sides(self, room: Room, reach: float) -> Indices:
        """Which sides of walls and of complete rooms are within reach of a room, metres; shape (N,)."""
        left, bottom, right, top = room.polygon.bounds
        around = shapely.box(left - reach, bottom - reach, right + reach, top + reach)
        return np.sort(self.side_tree.query(around))

    def measure_extents(self, room: Room, view: View) -> Floats:
        """Extents of the nearest complete rooms along the columns and the rows of a view, metres, shape (N, 2)."""
        distances = np.hypot(*(self.centers - np.mean(np.reshape(room.polygon.bounds, (2, 2)), axis=0)).T)
        chosen = [self.hulls[i] for i in np.sort(np.argsort(distances, kind="stable")[:MAX_COMPARED_ROOMS])]
        if not chosen:
            return np.zeros((0, 2))
        corners = view.from_map(np.concatenate(chosen))
        starts = np.cumsum([0, *map(len, chosen[:-1])])
        return np.asarray((np.maximum.reduceat(corners, starts) - np.minimum.reduceat(corners, starts)) * view.cell)


def find_main_direction(floor: Floor | FloorIndex, room: Room) -> float:
    """The direction of the walls around a room, radians, -π/4 … π/4 against x; nearer walls have more weight.

    The sides of partial rooms are used only if there is no complete room near.
    """
    index = floor if isinstance(floor, FloorIndex) else FloorIndex.from_floor(floor)
    near = index.find_sides(room, DIRECTION_REACH)
    ends, distance = index.sides[near], shapely.distance(index.side_tree.geometries[near], room.polygon)
    if not index.hulls or not len(ends):
        own = _list_sides([room.polygon.exterior])
        ends, distance = np.concatenate([ends, own]), np.concatenate([distance, np.zeros(len(own))])
    steps = ends[:, 1] - ends[:, 0]
    weight = np.hypot(*steps.T) * np.exp(-distance / DIRECTION_DECAY)
    # The factor 4 makes directions that differ by a right angle equal.
    fourfold = 4 * np.arctan2(steps[:, 1], steps[:, 0])
    return float(np.arctan2((weight * np.sin(fourfold)).sum(), (weight * np.cos(fourfold)).sum()) / 4)


def make_view(room: Room, angle: float, grid: GridMap) -> View:
    """The view around a room whose walls have the direction of an angle; the room is in its middle."""
    metres = View(angle, np.zeros(2), (1, 1), 1.0).from_map(shapely.get_coordinates(room.polygon))
    extent = float(np.ptp(metres, axis=0).max())
    view = View(angle, np.zeros(2), (1, 1), max(MIN_CELL, grid.resolution, extent / MAX_ROOM_CELLS))
    low, high = metres.min(axis=0) / view.cell, metres.max(axis=0) / view.cell
    reach = min(SURROUNDINGS / view.cell, max(0.0, (MAX_CELLS - float((high - low).max())) / 2))
    half = np.ceil((high - low) / 2 + reach).astype(int)
    corner = ((low + high) / 2 - half) * view.cell
    return View(angle, corner, (2 * int(half[1]), 2 * int(half[0])), view.cell)


@dataclass(frozen=True, eq=False)
class ObservedCells:
    """The cells of a grid map that scenes are sampled from.

    bits: shape (H, W), the sum of OCCUPIED for obstacles, grown so that a view with larger cells does not miss them,
    WALL for occupied cells that are not furniture, and UNKNOWN for cells that were not observed.
    """

    grid: GridMap
    bits: NDArray[np.uint8]

    @classmethod
    def from_grid(cls, grid: GridMap, views: Sequence[View]) -> ObservedCells:
        """The cells of the part of a grid map that views sample."""
        grid = _cut_to_views(grid, views)
        reach = round(max(MIN_CELL, grid.resolution) / grid.resolution) // 2
        occupied = grow_mask(grid.occupied, reach)
        # The pieces of a wall that was observed through gaps are near each other, so groups are formed across gaps
        joined = grow_mask(grid.occupied, round(GREY_WIDTH / grid.resolution)).astype(np.uint8)
        _, groups, stats, _ = cv2.connectedComponentsWithStats(joined, connectivity=8)
        extent = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1) * grid.resolution
        is_wall = extent >= FURNITURE_SIZE + 2 * GREY_WIDTH
        is_wall[0] = False
        # In place: a sum of products would take 24 bytes a cell
        bits = np.zeros(grid.shape, np.uint8)
        bits[occupied] = OCCUPIED
        bits[occupied & is_wall[groups]] |= WALL
        bits[grid.unknown] |= UNKNOWN
        return cls(grid, bits)

    def sample(self, view: View) -> tuple[Mask, Mask, Mask]:
        """Occupied, wall and unknown cells in a view, shape (H, W) each; those beyond the map are unknown."""
        cells, base = self.bits, max(MIN_CELL, self.grid.resolution)
        # The obstacles are grown for cells of the smallest size
        reach = round((view.cell - base) / 2 / self.grid.resolution)
        if reach:
            cells = np.bitwise_and(cells, UNKNOWN, dtype=np.uint8)
            for bit in (OCCUPIED, WALL):
                cells[grow_mask((self.bits & bit) > 0, reach)] |= bit
        bits = view.sample(cells, self.grid, beyond=UNKNOWN)
        return (bits & OCCUPIED).astype(bool), (bits & WALL).astype(bool), (bits & UNKNOWN).astype(bool)


def _cut_to_views(grid: GridMap, views: Sequence[View]) -> GridMap:
    """The part of a grid map that has all views, with surroundings by which walls at their edge are known as such."""
    corners = shapely.get_coordinates([view.window for view in views])
    rows, cols = (np.asarray(each) for each in grid.map_to_pixel(*corners.T))
    margin = ceil((FURNITURE_SIZE + 2 * GREY_WIDTH) / grid.resolution)
    (top, bottom), (left, right) = (
        (int(np.clip(each.min() - margin, 0, size - 1)), int(np.clip(each.max() + margin, 1, size)))
        for each, size in zip((rows, cols), grid.shape, strict=True)
    )
    x, y = grid.pixel_to_map(bottom, left)
    return replace(grid, cells=grid.cells[top:bottom, left:right], origin=(float(x), float(y), grid.origin[2]))


def build_scene(
    index: FloorIndex, room: Room, cells: ObservedCells, view: View, *, predictions: Sequence[Polygon] = ()
) -> RoomScene:
    """The scene of a partial room.

    index: of its floor. view: of `make_view`. predictions: for other rooms, map frame.
    """
    observed = view.draw([room.polygon])
    near = [index.rooms[i] for i in np.sort(index.tree.query(view.window, predicate="intersects"))]
    others = view.draw([*(other.polygon for other in near if other.id != room.id), *predictions]) & ~observed
    complete = view.draw([other.polygon for other in near if other.id != room.id and not other.partial])
    occupied, walls, unknown = cells.sample(view)
    frontier = _find_frontier(observed, others, occupied, unknown, view.cell)
    ends = index.sides[index.find_sides(room, LINES_REACH)]
    lines = view.from_map(ends.reshape(-1, 2)).reshape(-1, 2, 2)
    extents = index.measure_extents(room, view)
    passages = index.passages[np.sort(index.passage_tree.query(view.window))]
    door_lines = view.from_map(passages.reshape(-1, 2)).reshape(-1, 2, 2)
    masks = (observed, others, complete, occupied, walls, unknown, frontier)
    return RoomScene(view, *masks, extents, lines, index.doors[room.id], door_lines)


def _find_frontier(observed: Mask, others: Mask, occupied: Mask, unknown: Mask, cell: float) -> Mask:
    """Observed cells beside unknown ones that are in no other room and have no obstacle near, shape (H, W)."""
    reach = round(GREY_WIDTH / cell)
    top, left, bottom, right = find_bounds(observed)
    # Nothing further away matters
    margin = reach + 2
    window = slice(max(0, top - margin), bottom + margin + 1), slice(max(0, left - margin), right + margin + 1)
    inside = observed[window]
    clear = ~grow_mask(occupied[window], reach) & ~others[window] & ~inside
    frontier = np.zeros_like(observed)
    frontier[window] = inside & grow_mask(unknown[window] & clear, 1)
    return frontier


def _list_sides(lines: Sequence[shapely.LineString]) -> Floats:
    """Both ends of each straight segment of lines, shape (N, 2, 2)."""
    segments = [np.zeros((0, 2, 2))]
    for line in lines:
        xy = shapely.get_coordinates(line)
        segments.append(np.stack([xy[:-1], xy[1:]], axis=1))
    return np.concatenate(segments)
