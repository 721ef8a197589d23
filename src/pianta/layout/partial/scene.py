"""A partial room with its surroundings, on cells aligned with its walls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import cos, sin
from typing import TypeAlias

import cv2
import numpy as np
import shapely
from shapely import Polygon

from pianta._types import Floats, Mask
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.layout._label_images import grow_mask

Window: TypeAlias = tuple[slice, slice]

# The constants of a scene belong to the features that the model was fitted to (chosen by hand).
# Smallest cells of a scene; metres.
MIN_CELL = 0.1
# Cells along a side of a scene, at most; a limit of memory.
MAX_CELLS = 900
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
            filled = np.zeros(self.shape, np.uint8)
            cv2.fillPoly(filled, rings, 1, shift=SHIFT)
            image |= filled
        return image.astype(bool)

    def sample(self, cells: Mask, grid: GridMap) -> Mask:
        """Cells of a grid map at the centres of the cells of the view, shape (H, W); False beyond the map."""
        rows, cols = np.indices(self.shape) + 0.5
        xy = self.to_map(np.column_stack([cols.ravel(), rows.ravel()]))
        row, col = (np.floor(pixel).astype(np.intp) for pixel in grid.map_to_pixel(*xy.T))
        inside = (row >= 0) & (row < grid.shape[0]) & (col >= 0) & (col < grid.shape[1])
        values = np.zeros(len(xy), bool)
        values[inside] = cells[row[inside], col[inside]]
        return values.reshape(self.shape)


@dataclass(frozen=True, eq=False)
class RoomScene:
    """A partial room and its surroundings; masks have the shape (H, W) of the view.

    observed: the room as it was observed. others: other rooms, and predictions for them. walls: obstacles without
    furniture. frontier: cells of the room beside unknown space. extents: shape (N, 2), of the complete rooms, along the
    columns and along the rows of the view, metres. lines: shape (L, 2, 2), walls of the building: end, then col, row.
    doors: number of doors of the room.
    """

    view: View
    observed: Mask
    others: Mask
    walls: Mask
    frontier: Mask
    extents: Floats
    lines: Floats
    doors: int

    @cached_property
    def blocked(self) -> Mask:
        """Cells that the room cannot contain."""
        return np.asarray((self.others | self.walls) & ~self.observed)

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

    def window(self, bounds: tuple[int, int, int, int]) -> Window:
        """Rows and columns of the room and of bounds (first row and col, last row and col), with a margin."""
        rows, cols = np.flatnonzero(self.observed.any(axis=1)), np.flatnonzero(self.observed.any(axis=0))
        top, left, bottom, right = bounds
        first_row, first_col = (max(0, int(low) - self.near - 1) for low in (min(top, rows[0]), min(left, cols[0])))
        last_row, last_col = (int(high) + self.near + 2 for high in (max(bottom, rows[-1]), max(right, cols[-1])))
        height, width = self.observed.shape
        return slice(first_row, min(last_row, height)), slice(first_col, min(last_col, width))


def find_main_direction(floor: Floor, room: Room) -> float:
    """The direction of the walls around a room, radians, -π/4 … π/4 against x; nearer walls have more weight.

    The sides of partial rooms are used only if there is no complete room.
    """
    complete = [other.polygon for other in floor.rooms if not other.partial]
    rings = [polygon.exterior for polygon in complete or [room.polygon]]
    ends = np.concatenate([_list_sides([*floor.walls]), _list_sides(rings)])
    steps = ends[:, 1] - ends[:, 0]
    distance = shapely.distance(shapely.linestrings(ends), room.polygon)
    weight = np.hypot(*steps.T) * np.exp(-distance / DIRECTION_DECAY)
    # The factor 4 makes directions that differ by a right angle equal.
    fourfold = 4 * np.arctan2(steps[:, 1], steps[:, 0])
    return float(np.arctan2((weight * np.sin(fourfold)).sum(), (weight * np.cos(fourfold)).sum()) / 4)


def make_view(room: Room, angle: float, grid: GridMap) -> View:
    """The view around a room whose walls have the direction of an angle; the room is in its middle."""
    view = View(angle, np.zeros(2), (1, 1), max(MIN_CELL, grid.resolution))
    pixels = view.from_map(shapely.get_coordinates(room.polygon))
    low, high = pixels.min(axis=0), pixels.max(axis=0)
    reach = min(SURROUNDINGS / view.cell, max(0.0, (MAX_CELLS - float((high - low).max())) / 2))
    half = np.ceil((high - low) / 2 + reach).astype(int)
    corner = ((low + high) / 2 - half) * view.cell
    return View(angle, corner, (2 * int(half[1]), 2 * int(half[0])), view.cell)


@dataclass(frozen=True, eq=False)
class ObservedCells:
    """The cells of a grid map that scenes are sampled from, shape (H, W) each.

    occupied: obstacles, grown so that a view with larger cells does not miss them. walls: occupied cells that are not
    furniture. unknown: cells that were not observed.
    """

    grid: GridMap
    occupied: Mask
    walls: Mask
    unknown: Mask

    @classmethod
    def from_grid(cls, grid: GridMap) -> ObservedCells:
        """The cells of a grid map."""
        reach = round(max(MIN_CELL, grid.resolution) / grid.resolution) // 2
        occupied = grow_mask(grid.occupied, reach)
        # The pieces of a wall that was observed through gaps are near each other, so groups are formed across gaps
        joined = grow_mask(grid.occupied, round(GREY_WIDTH / grid.resolution)).astype(np.uint8)
        _, groups, stats, _ = cv2.connectedComponentsWithStats(joined, connectivity=8)
        extent = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1) * grid.resolution
        is_wall = extent >= FURNITURE_SIZE + 2 * GREY_WIDTH
        is_wall[0] = False
        return cls(grid, occupied, occupied & is_wall[groups], grid.unknown)


def build_scene(floor: Floor, room: Room, cells: ObservedCells, *, predictions: Sequence[Polygon] = ()) -> RoomScene:
    """The scene of a partial room.

    predictions: for other rooms, map frame.
    """
    view = make_view(room, find_main_direction(floor, room), cells.grid)
    observed = view.draw([room.polygon])
    height, width = view.shape
    window = Polygon(view.to_map(np.array([[0, 0], [width, 0], [width, height], [0, height]], float)))
    rest = [other for other in floor.rooms if other.id != room.id]
    near = [other.polygon for other in rest if other.polygon.intersects(window)]
    others = view.draw([*near, *predictions]) & ~observed
    occupied, walls = (view.sample(mask, cells.grid) for mask in (cells.occupied, cells.walls))
    # Cells beyond the map are unknown as well
    unknown = view.sample(cells.unknown, cells.grid) | ~view.sample(np.ones_like(cells.unknown), cells.grid)
    clear = ~grow_mask(occupied, round(GREY_WIDTH / view.cell)) & ~others & ~observed
    frontier = observed & grow_mask(unknown & clear, 1)
    complete = [other.polygon for other in rest if not other.partial]
    extents = [np.ptp(view.from_map(shapely.get_coordinates(polygon)), axis=0) * view.cell for polygon in complete]
    ends = np.concatenate([_list_sides([*floor.walls]), _list_sides([polygon.exterior for polygon in complete])])
    lines = view.from_map(ends.reshape(-1, 2)).reshape(-1, 2, 2)
    doors = sum(room.id in door.room_ids for door in floor.doors)
    return RoomScene(view, observed, others, walls, frontier, np.reshape(extents, (-1, 2)), lines, doors)


def _list_sides(lines: Sequence[shapely.LineString]) -> Floats:
    """Both ends of each straight segment of lines, shape (N, 2, 2)."""
    segments = [np.zeros((0, 2, 2))]
    for line in lines:
        xy = shapely.get_coordinates(line)
        segments.append(np.stack([xy[:-1], xy[1:]], axis=1))
    return np.concatenate(segments)
