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
PART = 8.0  # m: sides of the squares of changed cells of which an update reads as many as it may
SAME_CELL = 0.01  # cells by which two frames may differ
COARSE_CELL = 0.2  # m: cells in which groups of changes, and walls that have moved, are looked for
BLOCK = 16.0  # m: walls in squares with this side move together
MAX_MOTION = 1.0  # m that a loop closure moves walls
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
    margin, size = (ceil(length / grid.resolution) for length in (CORE_MARGIN, COARSE_CELL))
    gap = ceil(MIN_GAP / (size * grid.resolution))
    count, groups = cv2.connectedComponents(cv2.dilate(_shrink(changed, size), np.ones((gap, gap))).astype(np.uint8))
    rows, cols = np.nonzero(changed)
    group_of_cell = groups[rows // size, cols // size]
    boxes = []
    for group in range(1, count):
        own = group_of_cell == group
        (top, bottom), (left, right) = ((each[own].min(), each[own].max() + 1) for each in (rows, cols))
        box = (int(top) - margin, int(left) - margin, int(bottom) + margin, int(right) + margin)
        boxes.append(_extend_to_rooms(box, grid, floor))
    return _join_boxes(boxes, grid.shape)


def choose_windows(grid: GridMap, changed: Mask, floor: Floor, windows: Sequence[Box], max_area: float) -> list[Box]:
    """The windows, or parts of them that see at most an area together, where most has changed; one part at least.

    changed: cells, shape (H, W). windows: those of `list_windows`. max_area: m² of cells that are not unknown.
    """
    counts = _SeenCells(grid)
    if counts.measure(windows) <= max_area:
        return list(windows)
    margin = ceil(CORE_MARGIN / grid.resolution)
    squares = _list_squares(grid, changed)
    top, left, bottom, right, _ = max(squares, key=lambda square: square[4])
    # Parts beside each other see the same cells around them
    squares.sort(
        key=lambda square: abs(square[0] + square[2] - top - bottom) + abs(square[1] + square[3] - left - right)
    )
    chosen: list[Box] = []
    for top, left, bottom, right, _ in squares:
        box = (top - margin, left - margin, bottom + margin, right + margin)
        longer = _join_boxes([*chosen, _extend_to_rooms(box, grid, floor)], grid.shape)
        if not chosen or counts.measure(longer) <= max_area:
            chosen = longer
    return chosen


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
    around = bounds.difference(cores)
    tiles.append(Tile(grid, around, around, cores.boundary.difference(bounds.boundary)))
    floors.append(previous)
    return join_tiles(grid, tiles, floors)


def measure_wall_agreement(cells: NDArray[np.int8], before: NDArray[np.int8], resolution: float) -> float:
    """The share of the walls before that are on the map still, if all within a square move together by up to a metre.

    cells, before: free, occupied or unknown, in one frame, shape (H, W). 0 without walls.
    """
    size = max(round(COARSE_CELL / resolution), 1)
    walls = _shrink(cells == OCCUPIED, size)
    # Walls that the map does not show any more, or not yet, say nothing
    walls_before = _shrink((before == OCCUPIED) & (cells != UNKNOWN), size)
    reach, side = (round(length / (size * resolution)) for length in (MAX_MOTION, BLOCK))
    around = np.pad(walls, reach)
    shared = total = 0.0
    for top in range(0, walls.shape[0], side):
        for left in range(0, walls.shape[1], side):
            block = walls_before[top : top + side, left : left + side]
            count = float(block.sum())
            if count:
                rows, cols = block.shape
                near = around[top : top + rows + 2 * reach, left : left + cols + 2 * reach]
                shared += float(cv2.matchTemplate(near, block, cv2.TM_CCORR).max())
                total += count
    return shared / total if total else 0.0


def _shrink(cells: Mask, size: int) -> NDArray[np.float32]:
    """1 for squares of cells of which one is set, else 0."""
    rows, cols = (-length % size for length in cells.shape)
    padded = np.pad(cells, ((0, rows), (0, cols)))
    parts = padded.reshape(padded.shape[0] // size, size, padded.shape[1] // size, size)
    return np.asarray(parts.any(axis=(1, 3)), np.float32)


class _SeenCells:
    """Counts cells that windows see, with what is around them, by an integral image."""

    def __init__(self, grid: GridMap) -> None:
        self.shape, self.margin = grid.shape, ceil(OVERLAP / grid.resolution)
        self.cell_area = grid.resolution**2
        self.sums = cv2.integral((grid.free | grid.occupied).astype(np.uint8))

    def measure(self, windows: Sequence[Box]) -> float:
        """The area, m², of the cells that are not unknown; those that two windows see count twice."""
        height, width = self.shape
        count = 0
        for top, left, bottom, right in windows:
            rows = max(0, top - self.margin), min(height, bottom + self.margin)
            cols = max(0, left - self.margin), min(width, right + self.margin)
            corners = self.sums[np.ix_(rows, cols)]
            count += int(corners[1, 1] - corners[0, 1] - corners[1, 0] + corners[0, 0])
        return count * self.cell_area


def _list_squares(grid: GridMap, changed: Mask) -> list[tuple[int, int, int, int, int]]:
    """The changed cells of each square of a map: their bounding box, and how many they are."""
    side = round(PART / grid.resolution)
    squares = []
    for top in range(0, grid.shape[0], side):
        for left in range(0, grid.shape[1], side):
            rows, cols = np.nonzero(changed[top : top + side, left : left + side])
            if len(rows):
                (first_row, last_row), (first_col, last_col) = (
                    (int(each.min()), int(each.max())) for each in (rows, cols)
                )
                squares.append((top + first_row, left + first_col, top + last_row + 1, left + last_col + 1, len(rows)))
    return squares


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
