"""Only what has changed on a map is read again: windows around changed cells, joined with the floor of before."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import ceil

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from pianta._types import Mask
from pianta.errors import MapError
from pianta.floor import Floor
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout.structure.tiles import Tile, join_tiles, make_rectangle

# All chosen by hand.
MIN_GAP = 6.0  # m: changed cells further apart are in windows of their own
CORE_MARGIN = 1.0  # m around changed cells: a changed wall moves the outlines beside it
OVERLAP = 4.0  # m that a window sees around its core: what a room is depends on its surroundings
MAX_INSIDE = 15.0  # m: changed rooms up to this length are inside the core; longer ones are put together from parts
MAX_WIDE = 40.0  # m: also those up to this length that are no corridors, as halls are
LEAST_WIDTH = 0.4  # of their length
SAME_CELL = 0.01  # cells by which two frames may differ
EMPTY_FLOOR = Floor((), ())

Box = tuple[int, int, int, int]  # top, left, bottom, right, cells


def have_same_frame(grid: GridMap, previous: GridMap) -> bool:
    """Whether the cells of two maps coincide; either may reach further."""
    if not np.isclose(grid.resolution, previous.resolution) or grid.origin[2] != previous.origin[2]:
        return False
    corner = np.array(grid.map_to_pixel(*previous.pixel_to_map(0.0, 0.0)))
    return bool((np.abs(corner - corner.round()) < SAME_CELL).all())


def put_on_grid(previous: GridMap, grid: GridMap) -> NDArray[np.int8]:
    """Free, occupied or unknown, for each cell of a map, by a previous map in the same frame; shape (H, W)."""
    row, col = (round(float(each)) for each in grid.map_to_pixel(*previous.pixel_to_map(0.0, 0.0)))
    cells = np.full(grid.shape, UNKNOWN, np.int8)
    (top, bottom), (left, right) = (
        (max(first, 0), min(first + size, limit))
        for first, size, limit in zip((row, col), previous.shape, grid.shape, strict=True)
    )
    if bottom > top and right > left:
        before = classify_cells(previous)
        cells[top:bottom, left:right] = before[top - row : bottom - row, left - col : right - col]
    return cells


def classify_cells(grid: GridMap) -> NDArray[np.int8]:
    """Free, occupied or unknown, for each cell; shape (H, W)."""
    return np.select([grid.free, grid.occupied], [FREE, OCCUPIED], UNKNOWN).astype(np.int8)


def list_windows(grid: GridMap, changed: Mask, floor: Floor) -> list[Box]:
    """The cores of windows around changed cells, shape (H, W): disjoint, with changed rooms that are not too long."""
    margin, gap = (ceil(length / grid.resolution) for length in (CORE_MARGIN, MIN_GAP))
    count, groups = cv2.connectedComponents(cv2.dilate(changed.astype(np.uint8), np.ones((gap, gap), np.uint8)))
    boxes = []
    for group in range(1, count):
        rows, cols = np.nonzero((groups == group) & changed)
        box = (rows.min() - margin, cols.min() - margin, rows.max() + 1 + margin, cols.max() + 1 + margin)
        boxes.append(_extend_to_rooms(box, grid, floor))
    return _join_boxes(boxes, grid.shape)


def read_windows(grid: GridMap, windows: Sequence[Box], previous: Floor, read: Callable[[GridMap], Floor]) -> Floor:
    """The floor of a map, in whose windows it is read again, and which is that of before elsewhere.

    windows: cores, disjoint. previous: in the frame of the map. Raises MapError if no room is left.
    """
    bounds = make_rectangle(grid, (0, 0, *grid.shape))
    tiles, floors = [], []
    for window in windows:
        tile = _cut_tile(grid, window, bounds)
        tiles.append(tile)
        try:
            floors.append(read(tile.grid))
        except MapError:  # no room is there any more
            floors.append(EMPTY_FLOOR)
    cores = shapely.union_all([tile.core for tile in tiles])
    # What was read before is a tile too, that ends at the cores of the windows
    tiles.append(Tile(grid, bounds.difference(cores), bounds, cores.boundary.difference(bounds.boundary)))
    floors.append(previous)
    return join_tiles(grid, tiles, floors)


def _cut_tile(grid: GridMap, window: Box, bounds: Polygon) -> Tile:
    """The part of a map that a window sees. bounds: the rectangle of the map."""
    margin = ceil(OVERLAP / grid.resolution)
    top, left, bottom, right = window
    extent = (max(0, top - margin), max(0, left - margin), bottom + margin, right + margin)
    cells = grid.cells[extent[0] : extent[2], extent[1] : extent[3]]
    rows, cols = cells.shape
    x, y = grid.pixel_to_map(extent[0] + rows, extent[1])
    part = GridMap(cells, grid.resolution, (float(x), float(y), grid.origin[2]), grid.source)
    rectangle = make_rectangle(grid, (extent[0], extent[1], extent[0] + rows, extent[1] + cols))
    return Tile(part, make_rectangle(grid, window), rectangle, rectangle.boundary.difference(bounds.boundary))


def _extend_to_rooms(box: Box, grid: GridMap, floor: Floor) -> Box:
    """A box that has all of the rooms that it meets, but for long ones."""
    rectangle = make_rectangle(grid, box)
    margin = ceil(CORE_MARGIN / grid.resolution)
    top, left, bottom, right = box
    for room in floor:
        if _is_inside(room.polygon) and room.polygon.intersects(rectangle):
            rows, cols = grid.map_to_pixel(*shapely.get_coordinates(room.polygon).T)
            top, left = min(top, int(rows.min()) - margin), min(left, int(cols.min()) - margin)
            bottom, right = max(bottom, ceil(rows.max()) + margin), max(right, ceil(cols.max()) + margin)
    return top, left, bottom, right


def _is_inside(outline: Polygon) -> bool:
    """Whether a changed room is read as a whole."""
    x0, y0, x1, y1 = outline.bounds
    width, length = sorted((x1 - x0, y1 - y0))
    return bool(length <= MAX_INSIDE or (length <= MAX_WIDE and width >= LEAST_WIDTH * length))


def _join_boxes(boxes: Sequence[Box], shape: tuple[int, int]) -> list[Box]:
    """The boxes on a map of a shape; those that overlap are one."""
    height, width = shape
    separate: list[Box] = []
    pending = [
        (max(0, top), max(0, left), min(height, bottom), min(width, right)) for top, left, bottom, right in boxes
    ]
    while pending:
        box = pending.pop()
        other = next((each for each in separate if _overlap(box, each)), None)
        if other is None:
            separate.append(box)
        else:
            separate.remove(other)
            first, last = (np.array([box, other])[:, part] for part in (slice(2), slice(2, None)))
            pending.append((*first.min(axis=0).tolist(), *last.max(axis=0).tolist()))
    return sorted(separate)


def _overlap(box: Box, other: Box) -> bool:
    return box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]
