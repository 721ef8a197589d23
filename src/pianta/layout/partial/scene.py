"""A partial room with what is around it, on cells that lie along its walls."""

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

Window: TypeAlias = tuple[slice, slice]

# Cells of a scene are this large at least, and a scene has no more than this many along a side; metres, number.
CELL, MOST_CELLS = 0.1, 900
# How far around a room one looks, and over which distance the walls of others tell less of its direction; metres.
REACH, DIRECTION_REACH = 20.0, 10.0
# Unknown cells this near to an obstacle are the grey of a wall; metres.
GREY = 0.25
# What is at most this far from a wall is at it, and obstacles less than this across are furniture; metres.
NEAR, FURNITURE = 0.3, 1.5
# Sub-pixel bits of polygons that are drawn with OpenCV.
SHIFT = 6


@dataclass(frozen=True, eq=False)
class View:
    """A window of cells that is turned against the map frame.

    angle: of its columns' direction against x; radians. corner: x, y of the outer corner of its first cell, turned back
    by the angle; metres. shape: rows, which go up, and columns. cell: metres.
    """

    angle: float
    corner: Floats
    shape: tuple[int, int]
    cell: float

    def turn(self, xy: Floats) -> Floats:
        """Col and row, shape (N, 2), continuous, of places in the map frame."""
        c, s = cos(self.angle), sin(self.angle)
        return np.asarray((xy @ np.array([[c, -s], [s, c]]) - self.corner) / self.cell)

    def to_map(self, places: Floats) -> Floats:
        """Places in the map frame, shape (N, 2), of col and row."""
        c, s = cos(self.angle), sin(self.angle)
        return np.asarray((places * self.cell + self.corner) @ np.array([[c, s], [-s, c]]))

    def draw(self, polygons: Sequence[Polygon]) -> Mask:
        """Cells in any of the polygons, which do not overlap, shape (H, W)."""
        image = np.zeros(self.shape, np.uint8)
        for polygon in polygons:
            rings = [
                np.rint((self.turn(shapely.get_coordinates(ring)) - 0.5) * 2**SHIFT).astype(np.int32)
                for ring in (polygon.exterior, *polygon.interiors)
            ]
            window = np.zeros(self.shape, np.uint8)
            cv2.fillPoly(window, rings, 1, shift=SHIFT)
            image |= window
        return image.astype(bool)

    def sample(self, cells: Mask, grid: GridMap) -> Mask:
        """Cells of a grid map at the centres of the cells of the view, shape (H, W); False beyond the map."""
        rows, cols = np.indices(self.shape) + 0.5
        xy = self.to_map(np.column_stack([cols.ravel(), rows.ravel()]))
        row, col = (np.floor(place).astype(np.intp) for place in grid.map_to_pixel(*xy.T))
        inside = (row >= 0) & (row < grid.shape[0]) & (col >= 0) & (col < grid.shape[1])
        found = np.zeros(len(xy), bool)
        found[inside] = cells[row[inside], col[inside]]
        return found.reshape(self.shape)


@dataclass(frozen=True, eq=False)
class Scene:
    """A partial room and its surroundings; masks have the shape (H, W) of the view.

    seen: the room. others: other rooms, and what is predicted of them. walls: obstacles but furniture. frontier: cells
    of the room beside space that nobody has seen. extents: shape (N, 2), of the rooms that were seen whole, along the
    columns and along the rows of the view, metres. lines: shape (L, 2, 2), walls of the building: end, then col, row.
    doors: how many the room has.
    """

    view: View
    seen: Mask
    others: Mask
    walls: Mask
    frontier: Mask
    extents: Floats
    lines: Floats
    doors: int

    @cached_property
    def blocked(self) -> Mask:
        """Where the room cannot go on."""
        return np.asarray((self.others | self.walls) & ~self.seen)

    @property
    def near(self) -> int:
        """How many cells from a wall is at it."""
        return max(1, round(NEAR / self.view.cell))

    @cached_property
    def near_walls(self) -> Mask:
        """Cells at walls, shape (H, W)."""
        return grow(self.walls, self.near)

    @cached_property
    def near_rooms(self) -> Mask:
        """Cells at other rooms, shape (H, W)."""
        return grow(self.others, self.near)

    def window(self, bounds: tuple[int, int, int, int]) -> Window:
        """Rows and columns that hold the room and bounds (first row and col, last row and col), and a margin."""
        rows, cols = np.flatnonzero(self.seen.any(axis=1)), np.flatnonzero(self.seen.any(axis=0))
        top, left, bottom, right = bounds
        first_row, first_col = (max(0, int(low) - self.near - 1) for low in (min(top, rows[0]), min(left, cols[0])))
        last_row, last_col = (int(high) + self.near + 2 for high in (max(bottom, rows[-1]), max(right, cols[-1])))
        height, width = self.seen.shape
        return slice(first_row, min(last_row, height)), slice(first_col, min(last_col, width))


def find_main_direction(floor: Floor, room: Room) -> float:
    """The direction of the walls around a room, in radians, -π/4 … π/4 against x; those nearer count for more.

    Sides of partial rooms are no walls, unless there is nothing else.
    """
    whole = [other.polygon for other in floor.rooms if not other.partial]
    rings = [polygon.exterior for polygon in whole or [room.polygon]]
    ends = np.concatenate([_list_sides([*floor.walls]), _list_sides(rings)])
    steps = ends[:, 1] - ends[:, 0]
    distance = shapely.distance(shapely.linestrings(ends), room.polygon)
    weight = np.hypot(*steps.T) * np.exp(-distance / DIRECTION_REACH)
    # Directions that differ by a right angle are one.
    fourfold = 4 * np.arctan2(steps[:, 1], steps[:, 0])
    return float(np.arctan2((weight * np.sin(fourfold)).sum(), (weight * np.cos(fourfold)).sum()) / 4)


def view_room(room: Room, angle: float, grid: GridMap) -> View:
    """The view around a room whose walls run along an angle; the room is in its middle."""
    view = View(angle, np.zeros(2), (1, 1), max(CELL, grid.resolution))
    places = view.turn(shapely.get_coordinates(room.polygon))
    low, high = places.min(axis=0), places.max(axis=0)
    reach = min(REACH / view.cell, max(0.0, (MOST_CELLS - float((high - low).max())) / 2))
    half = np.ceil((high - low) / 2 + reach).astype(int)
    corner = ((low + high) / 2 - half) * view.cell
    return View(angle, corner, (2 * int(half[1]), 2 * int(half[0])), view.cell)


@dataclass(frozen=True, eq=False)
class Sight:
    """What a robot has seen: obstacles, grown so that a view of larger cells meets them, and what it has not seen.

    occupied, walls, unknown: shape (H, W) of the grid; walls are obstacles that are no furniture.
    """

    grid: GridMap
    occupied: Mask
    walls: Mask
    unknown: Mask

    @classmethod
    def of(cls, grid: GridMap) -> Sight:
        """The sight of a grid map."""
        parts = round(max(CELL, grid.resolution) / grid.resolution) // 2
        occupied = grow(grid.occupied, parts)
        # Pieces of a wall that was seen through gaps are not far from each other
        joined = grow(grid.occupied, round(GREY / grid.resolution)).astype(np.uint8)
        _, groups, stats, _ = cv2.connectedComponentsWithStats(joined, connectivity=8)
        across = stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].max(axis=1) * grid.resolution
        is_wall = across >= FURNITURE + 2 * GREY
        is_wall[0] = False
        return cls(grid, occupied, occupied & is_wall[groups], grid.unknown)


def look_around(floor: Floor, room: Room, sight: Sight, *, claimed: Sequence[Polygon] = ()) -> Scene:
    """The scene of a partial room.

    claimed: what is predicted of other rooms, map frame.
    """
    view = view_room(room, find_main_direction(floor, room), sight.grid)
    seen = view.draw([room.polygon])
    height, width = view.shape
    window = Polygon(view.to_map(np.array([[0, 0], [width, 0], [width, height], [0, height]], float)))
    rest = [other for other in floor.rooms if other.id != room.id]
    near = [other.polygon for other in rest if other.polygon.intersects(window)]
    others = view.draw([*near, *claimed]) & ~seen
    occupied, walls = (view.sample(mask, sight.grid) for mask in (sight.occupied, sight.walls))
    # What lies beyond the map is unknown as well
    unknown = view.sample(sight.unknown, sight.grid) | ~view.sample(np.ones_like(sight.unknown), sight.grid)
    clear = ~grow(occupied, round(GREY / view.cell)) & ~others & ~seen
    frontier = seen & grow(unknown & clear, 1)
    whole = [other.polygon for other in rest if not other.partial]
    sizes = [np.ptp(view.turn(shapely.get_coordinates(polygon)), axis=0) * view.cell for polygon in whole]
    ends = np.concatenate([_list_sides([*floor.walls]), _list_sides([polygon.exterior for polygon in whole])])
    lines = view.turn(ends.reshape(-1, 2)).reshape(-1, 2, 2)
    doors = sum(room.id in door.room_ids for door in floor.doors)
    return Scene(view, seen, others, walls, frontier, np.reshape(sizes, (-1, 2)), lines, doors)


def grow(mask: Mask, reach: int) -> Mask:
    """The mask, shape (H, W), and all cells in a square of so many cells around its own."""
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    return np.asarray(cv2.dilate(mask.astype(np.uint8), square), bool)


def shrink(mask: Mask, reach: int) -> Mask:
    """The mask, shape (H, W), without cells that have another in a square of so many cells around them."""
    square = np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)
    return np.asarray(cv2.erode(mask.astype(np.uint8), square, borderValue=0, borderType=cv2.BORDER_CONSTANT), bool)


def _list_sides(lines: Sequence[shapely.LineString]) -> Floats:
    """Both ends of each straight piece of lines, shape (N, 2, 2)."""
    pieces = [np.zeros((0, 2, 2))]
    for line in lines:
        xy = shapely.get_coordinates(line)
        pieces.append(np.stack([xy[:-1], xy[1:]], axis=1))
    return np.concatenate(pieces)
