"""Only what has changed on a map is read again: windows around changed cells, joined with the floor of before."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from math import ceil

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon, STRtree

from pianta._types import Floats, Indices, Mask
from pianta.errors import MapError
from pianta.floor import Floor
from pianta.gridmap import FREE, MAX_FREE, MIN_OCCUPIED, OCCUPIED, UNKNOWN, GridMap
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.frontiers import is_partial_room
from pianta.layout.structure.tiles import Tile, join_tiles, make_rectangle

# All chosen by hand.
MIN_GAP = 6.0  # m: changed cells further apart are in windows of their own
CORE_MARGIN = 1.0  # m around changed cells: a changed wall moves the outlines beside it
OVERLAP = 4.0  # m that a window sees around its core: what a room is depends on its surroundings
MAX_INSIDE = 15.0  # m: changed rooms up to this length are inside the core; longer ones are put together from parts
MAX_WIDE = 40.0  # m: also those up to this length that are no corridors, as halls are
LEAST_WIDTH = 0.4  # of their length
PART = 8.0  # m: sides of the squares of changed cells of which an update reads as many as it may
MAX_PARTS = 16  # such squares that an update tries
CUT_GAP = 0.15  # m between rooms that touch
MIN_CUT = 0.8  # m of border without a wall or a door, at which rooms may be parts of one
SAME_CELL = 0.01  # cells by which two frames may differ
COARSE_CELL = 0.2  # m: cells in which groups of changes, and walls that have moved, are looked for
BLOCK = 16.0  # m: walls in squares with this side move together
MAX_MOTION = 1.0  # m that a loop closure moves walls
EMPTY_FLOOR = Floor((), ())
# Free, occupied or unknown, as bytes, for each byte of a map's cells; a table is faster than comparisons
_VALUES = np.arange(256)
CLASSES = np.full(256, UNKNOWN, np.int8).view(np.uint8)
CLASSES[(_VALUES >= FREE) & (_VALUES <= MAX_FREE)] = FREE
CLASSES[(_VALUES >= MIN_OCCUPIED) & (_VALUES <= OCCUPIED)] = OCCUPIED

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
    cells: NDArray[np.uint8] = np.asarray(cv2.LUT(grid.cells.view(np.uint8), CLASSES))
    return cells.view(np.int8)


def list_windows(grid: GridMap, changed: Mask, floor: Floor) -> list[Box]:
    """The cores of windows around changed cells, shape (H, W): disjoint, with changed rooms that are not too long."""
    margin, size = (ceil(length / grid.resolution) for length in (CORE_MARGIN, COARSE_CELL))
    gap = ceil(MIN_GAP / (size * grid.resolution))
    squares = _shrink(changed, size)
    count, groups = cv2.connectedComponents(cv2.dilate(squares, np.ones((gap, gap))).astype(np.uint8))
    rows, cols = np.nonzero(squares)
    group_of_square = groups[rows, cols]
    boxes = []
    for group in range(1, count):
        own = group_of_square == group
        (top, bottom), (left, right) = (
            (int(each[own].min()) * size, (int(each[own].max()) + 1) * size) for each in (rows, cols)
        )
        boxes.append(_extend_to_rooms((top - margin, left - margin, bottom + margin, right + margin), grid, floor))
    return _join_boxes(boxes, grid.shape)


def choose_windows(grid: GridMap, changed: Mask, floor: Floor, windows: Sequence[Box], max_area: float) -> list[Box]:
    """The windows, or parts of them that see at most an area together, where most has changed; one part at least.

    If the first part sees more with its rooms, those that need most are left out, and put together from parts.

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
    for top, left, bottom, right, _ in squares[:MAX_PARTS]:
        box = (top - margin, left - margin, bottom + margin, right + margin)
        longer = _join_boxes([*chosen, _extend_to_rooms(box, grid, floor)], grid.shape)
        if counts.measure(longer) <= max_area:
            chosen = longer
        elif not chosen:
            chosen = _join_boxes([_extend_to_rooms(box, grid, floor, counts, max_area)], grid.shape)
    return chosen


def measure_seen_area(grid: GridMap, windows: Sequence[Box]) -> float:
    """The area that windows see with what is around them, m² of cells that are not unknown."""
    return _SeenCells(grid).measure(windows)


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
    floor = join_tiles(grid, tiles, floors)
    # A part that was partial may have met the one that was unknown then
    rooms = (
        replace(room, partial=is_partial_room(room.polygon, grid, StructureParameters()))
        if room.partial and room.polygon.intersects(cores.boundary)
        else room
        for room in floor
    )
    return replace(floor, rooms=tuple(rooms))


def list_cuts(
    floor: Floor, grid: GridMap, windows: Sequence[Box], *, without: Collection[tuple[int, int]]
) -> dict[tuple[int, int], Floats]:
    """Borders of rooms at the edges of windows without a wall or a door: x, y, shape (N, 2), by the ids of both rooms.

    There one room may have been read as two, since no window had all of it. The smaller id is the first. without: ids
    of rooms that may be two.
    """
    edges = shapely.union_all([make_rectangle(grid, window).boundary for window in windows])
    polygons = [room.polygon for room in floor]
    joined = {frozenset(door.room_ids) for door in floor.doors}
    walls = cv2.dilate(grid.occupied.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    cuts = {}
    pairs: Indices = STRtree(polygons).query(polygons, predicate="dwithin", distance=CUT_GAP).T
    for one, other in pairs[pairs[:, 0] < pairs[:, 1]].tolist():
        first, second = sorted((floor.rooms[one].id, floor.rooms[other].id))
        if frozenset({first, second}) in joined or (first, second) in without:
            continue
        border = polygons[other].exterior.intersection(polygons[one].buffer(CUT_GAP))
        if border.distance(edges) > OVERLAP:
            continue
        points = shapely.get_coordinates(border.segmentize(grid.resolution))
        rows, cols = (np.floor(each).astype(int) for each in grid.map_to_pixel(*points.T))
        is_inside = (rows >= 0) & (rows < grid.shape[0]) & (cols >= 0) & (cols < grid.shape[1])
        points, rows, cols = points[is_inside], rows[is_inside], cols[is_inside]
        is_open = grid.free[rows, cols] & ~walls[rows, cols]
        if np.count_nonzero(is_open) * grid.resolution >= MIN_CUT:
            cuts[first, second] = points[is_open]
    return cuts


def forget_cells(grid: GridMap, points: Floats) -> GridMap:
    """The map with unknown cells at points, x, y, shape (N, 2), so that they count as changed."""
    cells = grid.cells.copy()
    rows, cols = (np.floor(each).astype(int) for each in grid.map_to_pixel(*points.T))
    cells[rows, cols] = UNKNOWN
    return replace(grid, cells=cells)


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
    # Each cell has the maximum of the square that begins there
    squares = cv2.dilate(cells.astype(np.uint8), np.ones((size, size), np.uint8), anchor=(0, 0))
    return squares[::size, ::size].astype(np.float32)


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
            part = changed[top : top + side, left : left + side]
            count = int(np.count_nonzero(part))
            if count:
                rows, cols = (np.flatnonzero(part.any(axis=axis)) for axis in (1, 0))
                ends = top + int(rows[0]), left + int(cols[0]), top + int(rows[-1]) + 1, left + int(cols[-1]) + 1
                squares.append((*ends, count))
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


def _extend_to_rooms(
    box: Box, grid: GridMap, floor: Floor, counts: _SeenCells | None = None, max_area: float = np.inf
) -> Box:
    """A box that has all of the rooms that it meets, but for long ones.

    With counts, as long as it sees at most an area, m²; the rooms that need least come first.
    """
    rectangle = make_rectangle(grid, box)
    margin = ceil(CORE_MARGIN / grid.resolution)
    larger = []
    for room in floor:
        if _is_inside(room.polygon) and room.polygon.intersects(rectangle):
            rows, cols = grid.map_to_pixel(*shapely.get_coordinates(room.polygon).T)
            top, left = int(rows.min()) - margin, int(cols.min()) - margin
            larger.append(_surround(box, (top, left, ceil(rows.max()) + margin, ceil(cols.max()) + margin)))
    for each in sorted(larger, key=_count_cells):
        extended = _surround(box, each)
        if counts is None or counts.measure([extended]) <= max_area:
            box = extended
    return box


def _surround(box: Box, other: Box) -> Box:
    """The smallest box with both boxes."""
    return min(box[0], other[0]), min(box[1], other[1]), max(box[2], other[2]), max(box[3], other[3])


def _count_cells(box: Box) -> int:
    return (box[2] - box[0]) * (box[3] - box[1])


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
            pending.append(_surround(box, other))
    return sorted(separate)


def _overlap(box: Box, other: Box) -> bool:
    return box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]
