"""The true world of a simulated robot: obstacles on a grid, and their floor."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import ceil, hypot, isfinite
from pathlib import Path

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.affinity import scale
from shapely.geometry.base import BaseGeometry

from pianta._types import Mask
from pianta.errors import MapError, OptionError
from pianta.floor import Door, Floor, cells_of_polygon
from pianta.gridmap import FREE, OCCUPIED, GridMap
from pianta.io._files import short_repr

Cells = NDArray[np.int_]

MAX_CELLS = 50_000_000
# Free cells this far from those under a robot count as explorable, m. Chosen by hand.
EXPLORABLE_MARGIN = 0.5
SMALLEST_MAP = 1.0  # m across: smaller ones have no space for a robot
# Minimum thickness of a wall between two rooms, cells, so that no beam passes it.
MIN_WALL_PX = 1.5
# The floor of a folder, in this order.
FLOOR_FILES = ("truth.geojson", "floor.geojson")


@dataclass(frozen=True, eq=False)
class World:
    """Obstacles on a grid, and the floor if there is one.

    blocked: shape (H, W), obstacles and all cells outside the building.
    resolution, origin: metres per cell, and the frame, as in GridMap.
    floor: the true floor, None for a grid map.
    room_of_cell: shape (H, W), uint16; room ids on their free cells, 0 elsewhere.
    door_cells: for each door of the floor the free cells, shape (N, 2), of its passage through the wall.
    """

    blocked: Mask
    resolution: float
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    floor: Floor | None = None
    room_of_cell: NDArray[np.uint16] = field(default_factory=lambda: np.zeros((0, 0), np.uint16))
    door_cells: tuple[Cells, ...] = ()

    def __post_init__(self) -> None:
        blocked = np.ascontiguousarray(self.blocked, bool)
        rooms = self.room_of_cell if self.room_of_cell.size else np.zeros(blocked.shape, np.uint16)
        object.__setattr__(self, "blocked", blocked)
        object.__setattr__(self, "room_of_cell", np.where(blocked, 0, rooms).astype(np.uint16))
        for cells in (self.blocked, self.room_of_cell):
            cells.setflags(write=False)

    @property
    def free(self) -> Mask:
        """Cells without an obstacle; shape (H, W)."""
        return ~self.blocked

    @cached_property
    def grid(self) -> GridMap:
        """The world as a grid map of free and occupied cells."""
        return GridMap(np.where(self.blocked, OCCUPIED, FREE), self.resolution, self.origin)

    @cached_property
    def room_cells(self) -> NDArray[np.int_]:
        """Number of free cells of each room, by its id, shape (1 + highest id,)."""
        highest = max((room.id for room in self.floor.rooms), default=0) if self.floor else 0
        return np.bincount(self.room_of_cell.ravel(), minlength=highest + 1)

    def pixel(self, x: float, y: float) -> tuple[float, float]:
        """Continuous row, col of a point, metres of the map frame."""
        row, col = self.grid.map_to_pixel(x, y)
        return float(row), float(col)

    def cell(self, x: float, y: float) -> tuple[int, int]:
        """Row, col of the cell of a point, metres of the map frame; it may be off the grid."""
        row, col = np.floor(self.pixel(x, y))
        return int(row), int(col)

    def point(self, cell: tuple[int, int]) -> tuple[float, float]:
        """x, y, metres of the map frame, of the middle of a cell."""
        x, y = self.grid.pixel_to_map(cell[0] + 0.5, cell[1] + 0.5)
        return float(x), float(y)


def build_world(floor: Floor, *, resolution: float = 0.1, wall: float = 0.2, door: float = 0.9) -> World:
    """Build the world of a floor; wall: thickness between rooms; door: minimum width. All lengths in metres.

    A gap between two rooms, as in pianta.worlds, is part of their wall. If outlines touch, as in drawn buildings, the
    wall takes half of its thickness from each room. Entrances stay closed.
    Raises OptionError for lengths out of range, a floor without rooms, and one that needs too many cells.
    """
    for name, value in (("resolution", resolution), ("wall", wall), ("door", door)):
        if not (isfinite(value) and value > 0):
            raise OptionError(f"{name} is {value}, give positive metres")
    blank = _empty_grid(floor, resolution, margin=wall + 2 * resolution)
    rooms = floor.label_image(blank)
    blocked = (rooms == 0) | _wall_cells(rooms, max(wall / resolution, MIN_WALL_PX))
    door_cells = tuple(
        _open_door(passage, floor, blank, rooms, blocked=blocked, wall=wall, width=door) for passage in floor.doors
    )
    return World(blocked, resolution, blank.origin, floor, rooms, door_cells)


def read_world(grid: GridMap) -> World:
    """The world of a grid map; occupied and unknown cells are obstacles.

    Raises MapError for a map whose cells are too coarse, or too small all together, for a robot to drive on.
    """
    from pianta.layout._working_grid import check_resolution

    check_resolution(grid.resolution)
    across = max(grid.shape) * grid.resolution
    if across < SMALLEST_MAP:
        raise MapError(f"the map is {across:g} m across; check the resolution of {grid.resolution:g} m")
    return World(~grid.free, grid.resolution, grid.origin)


def as_world(world: World | Floor | GridMap | str | Path, *, seed: int = 0) -> World:
    """Convert a floor, a grid map, or an argument of `open_world`; seed: of a synthetic world."""
    if isinstance(world, Floor):
        return build_world(world)
    if isinstance(world, GridMap):
        return read_world(world)
    return open_world(world, seed=seed) if isinstance(world, str | Path) else world


def open_world(name: str | Path, *, seed: int = 0) -> World:
    """Open a folder with a floor, a building file, a map file, or a floor type of `pianta world`.

    An existing path takes precedence over a floor type. Raises OptionError for a folder without a floor, a plain image,
    and a missing file; and what the readers raise.
    """
    from pianta.io.buildings.read import SUFFIXES, read_building
    from pianta.io.images import IMAGE_SUFFIXES
    from pianta.io.maps import read_map
    from pianta.worlds.make import SAMPLE, WORLD_NAMES, make_synthetic_world

    path = Path(name)
    if name in WORLD_NAMES and not path.exists():
        return build_world(make_synthetic_world(str(name), seed=None if name == SAMPLE else seed)[0])
    if path.is_dir():
        files = [path / file for file in FLOOR_FILES if (path / file).is_file()]
        if not files:
            raise OptionError(
                f"folder {short_repr(path)} has no {' or '.join(FLOOR_FILES)}, give a file or another folder"
            )
        path = files[0]
    if path.suffix.lower() in SUFFIXES:
        return build_world(read_building(path))
    if not path.suffix and not path.exists():
        raise OptionError(f"world is {short_repr(name)}, give a file, a folder, or one of {', '.join(WORLD_NAMES)}")
    if path.suffix.lower() in IMAGE_SUFFIXES:
        raise OptionError(f"world {short_repr(name)} is an image without a resolution, give its map.yaml")
    try:
        return read_world(read_map(path))
    except MapError as error:
        raise error if str(error).startswith("map ") else MapError(f"map {short_repr(path)}: {error}") from None


def reachable_cells(world: World, starts: list[tuple[int, int]], *, radius: float) -> Mask:
    """Cells, shape (H, W), that the middle of a robot of a radius, metres, can reach from any of the starts."""
    clear = clear_cells(world.blocked, radius / world.resolution)
    # 4-connected, because a diagonal step needs both cells beside it.
    _, parts = cv2.connectedComponents(clear.astype(np.uint8), connectivity=4)
    return np.isin(parts, sorted({int(parts[start]) for start in starts} - {0}))


def explorable_cells(world: World, reachable: Mask, *, radius: float) -> Mask:
    """Free cells, shape (H, W), that count as the area to explore: those near the reachable cells.

    Near is within radius + EXPLORABLE_MARGIN over free cells, so that corners of rooms count and space behind a slit
    does not.
    """
    near = reachable.copy()
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    for _ in range(ceil((radius + EXPLORABLE_MARGIN) / world.resolution)):
        near = world.free & (cv2.dilate(near.astype(np.uint8), cross) > 0)
    return near


def clear_cells(blocked: Mask, radius_px: float) -> Mask:
    """Cells, shape (H, W), further than a radius, in cells, from all blocked ones; outside the grid all is blocked."""
    reach = int(radius_px)
    around = np.pad(blocked, reach + 1, constant_values=True).astype(np.uint8)
    near = cv2.dilate(around, _disc(radius_px).astype(np.uint8))
    inner = slice(reach + 1, -reach - 1)
    return np.asarray(near[inner, inner] == 0)


def _disc(radius_px: float) -> Mask:
    """A disc of a radius, in cells, shape (N, N)."""
    reach = int(radius_px)
    row, col = np.ogrid[-reach : reach + 1, -reach : reach + 1]
    return np.asarray(row**2 + col**2 <= radius_px**2)


def _empty_grid(floor: Floor, resolution: float, margin: float) -> GridMap:
    """An empty grid around all rooms, with a margin, metres."""
    if not floor.rooms:
        raise OptionError("the floor has no rooms, give one at least")
    left, bottom, right, top = shapely.total_bounds([room.polygon for room in floor.rooms])
    width, height = (ceil((length + 2 * margin) / resolution) for length in (right - left, top - bottom))
    if width * height > MAX_CELLS:
        size = f"{right - left:.0f} × {top - bottom:.0f} m"
        raise OptionError(f"a floor of {size} has more than {MAX_CELLS} cells of {resolution} m, give larger cells")
    return GridMap(np.zeros((height, width), np.int8), resolution, (left - margin, bottom - margin, 0))


def _wall_cells(rooms: NDArray[np.uint16], thickness_px: float) -> Mask:
    """Cells of rooms that belong to the wall to another room; a gap between the rooms is part of its thickness."""
    walls = np.zeros(rooms.shape, bool)
    reach = ceil(thickness_px) + 1
    for room in np.unique(rooms[rooms > 0]).tolist():
        rows, cols = np.nonzero(rooms == room)
        window = (
            slice(max(rows.min() - reach, 0), rows.max() + reach + 1),
            slice(max(cols.min() - reach, 0), cols.max() + reach + 1),
        )
        own = rooms[window] == room
        others = (rooms[window] > 0) & ~own
        if others.any():
            # Distances from each cell to the outline of its room, and to the outline of the nearest other room.
            to_outline, to_other = (_distance_to(mask) - 0.5 for mask in (~own, others))
            walls[window] |= own & (to_outline + to_other < thickness_px)
    return walls


def _distance_to(mask: Mask) -> NDArray[np.float64]:
    """Distance from each cell to the nearest cell of the mask, cells."""
    from scipy.ndimage import distance_transform_edt

    return np.asarray(distance_transform_edt(~mask), float)


def _open_door(
    passage: Door, floor: Floor, grid: GridMap, rooms: NDArray[np.uint16], *, blocked: Mask, wall: float, width: float
) -> Cells:
    """Free the cells of a door between two rooms in `blocked`, and return them; none for an entrance."""
    if passage.is_entrance:
        return np.zeros((0, 2), int)
    polygons = [room.polygon for room in floor.rooms if room.id in passage.room_ids]
    gap = max(passage.line.distance(polygon) for polygon in polygons)
    area = _door_area(passage, width, half_depth=max(gap, wall / 2) + grid.resolution)
    window_rows, window_cols, inside = cells_of_polygon(area, grid)
    window = window_rows, window_cols
    # Only cells of the two rooms and of the gap between them.
    inside &= np.isin(rooms[window], [0, *passage.room_ids])
    opened = inside & blocked[window]
    blocked[window] &= ~inside
    rows, cols = np.nonzero(opened)
    return np.column_stack([rows + window_rows.start, cols + window_cols.start])


def _door_area(passage: Door, width: float, half_depth: float) -> BaseGeometry:
    """The passage of a door: its line, stretched to the width, and the depth on both sides; metres."""
    (x0, y0), (x1, y1) = passage.line.coords[0], passage.line.coords[-1]
    length = hypot(x1 - x0, y1 - y0)
    if length == 0:
        return shapely.Point(x0, y0).buffer(max(half_depth, width / 2), cap_style="square")
    stretch = max(width / length, 1)
    return scale(passage.line, stretch, stretch).buffer(half_depth, cap_style="flat")
