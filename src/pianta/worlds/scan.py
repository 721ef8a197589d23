"""The grid map that a robot with a lidar would make of a floor."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from math import ceil, cos, pi, sin

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon, unary_union
from shapely.geometry.base import BaseGeometry

from pianta.errors import OptionError
from pianta.floor import Floor, cells_of_polygon
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.worlds.floors import OUTER_WALL, Seed, make_l_floor
from pianta.worlds.furniture import furnish_floor

LIMITS = {
    "resolution": (0.005, 0.5, "metres per cell"),
    "margin": (0, 1000, "metres"),
    "wall_thickness": (0.01, 10, "metres"),
    "noise": (0, 1, ""),
    "furniture": (0, 10, ""),
    "yaw": (-2 * pi, 2 * pi, "radians"),
}

# Depth of wall that a lidar paints, m: it sees the face and never what is behind.
SKIN = 0.05

# Noise of level 1: how far walls are displaced at most, and how far apart displacements are unrelated, m.
DISPLACEMENTS = ((0.12, 6.0), (0.05, 0.5), (0.035, 0.0))
# Noise of level 1: shares of cells.
THICKENED, UNSEEN, SALT, HOLES = 0.5, 0.08, 0.0006, 0.001

# Spray: how far rays go beyond the glass, m; stations of the scanner; rays from each; share of rays with an echo.
SPRAY_REACH, STATIONS, RAYS, ECHOES = 6.0, 4, 25, 0.6
# How far inside the glass rays are drawn, so that they meet free space even where noise moved the wall, m.
STRETCH = 0.2

SAMPLE_SEED = 9


def map_floor(
    floor: Floor,
    *,
    resolution: float = 0.05,
    margin: float | None = None,
    wall_thickness: float = OUTER_WALL,
    solid_walls: bool = False,
    noise: float = 0.0,
    furniture: float = 0.0,
    glass_spray: bool = False,
    yaw: float = 0.0,
    seed: Seed = 0,
) -> GridMap:
    """Grid map of a floor in the floor's own frame: free rooms and door gaps, occupied wall faces, unknown elsewhere.

    resolution, yaw: metres per cell, and radians counter-clockwise from the floor's axes to those of the grid.
    margin: unknown space around the outer walls, metres; by default 1, and enough for the rays where there is spray.
    wall_thickness: of the outer walls, metres; inner walls are the gaps between the rooms.
    solid_walls: paint walls and furniture through, as on a plan, not only the face that a lidar sees.
    noise: 0 clean … 1 a bad map: drifting walls, rough faces, gaps in walls, specks in free space.
    furniture: 0 empty … 1 a busy office; corridors stay empty, and no piece closes a door or a passage.
    glass_spray: one outer wall is glass, and fans of rays leave the building through it.
    seed: of noise, furniture and spray, each with a stream of its own.
    Raises OptionError, with every fault in one message, when an option has no meaning.
    """
    margin = margin if margin is not None else SPRAY_REACH if glass_spray else 1.0
    lengths = {"resolution": resolution, "margin": margin, "wall_thickness": wall_thickness}
    _check_options(floor, **lengths, noise=noise, furniture=furniture, yaw=yaw)
    furnisher, shaker, sprayer = np.random.default_rng(seed).spawn(3)
    blank = _lay_grid(floor, resolution, margin + wall_thickness, yaw)
    obstacles = furnish_floor(floor, density=furniture, leg=max(0.05, resolution), rng=furnisher)
    inside, blocked = _sweep_floor(floor, blank), _fill_polygons(obstacles, blank)
    sources = _draw_sources(blank.shape, noise, resolution, shaker)
    inside, free = inside[sources], (inside & ~blocked)[sources]
    solid = _grow(inside, wall_thickness / resolution) if solid_walls else _grow(free, SKIN / resolution)
    cells = np.select([free, solid], [FREE, OCCUPIED], UNKNOWN).astype(np.int8)
    _roughen_cells(cells, noise, shaker)
    if glass_spray:
        _spray_rays(cells, floor, blank, wall_thickness, sprayer)
    return GridMap(cells, resolution, blank.origin)


def make_sample() -> tuple[Floor, GridMap]:
    """The sample that comes with pianta: an L-shaped floor of 20 rooms, and a mildly noisy, lightly furnished map."""
    floor = make_l_floor(seed=SAMPLE_SEED, room_width=(3.2, 7.5))
    return floor, map_floor(floor, noise=0.3, furniture=0.2, seed=SAMPLE_SEED)


def _check_options(floor: Floor, **options: float) -> None:
    """Raise OptionError naming every option out of its limits."""
    faults = [] if floor.rooms else ["the floor has no rooms, give one at least"]
    for name, value in options.items():
        least, most, unit = LIMITS[name]
        if not least <= value <= most:
            faults.append(f"{name} is {value}, give {least:g} … {most:g} {unit}".rstrip())
    if faults:
        raise OptionError("cannot map the floor: " + "; ".join(faults))


def _lay_grid(floor: Floor, resolution: float, margin: float, yaw: float) -> GridMap:
    """Unknown grid whose axes have the given yaw, and that holds all rooms with a margin around them."""
    x, y = shapely.get_coordinates([room.polygon for room in floor.rooms]).T
    right, up = x * cos(yaw) + y * sin(yaw), y * cos(yaw) - x * sin(yaw)
    left, low = right.min() - margin, up.min() - margin
    shape = (ceil((up.max() + margin - low) / resolution), ceil((right.max() + margin - left) / resolution))
    origin = (left * cos(yaw) - low * sin(yaw), left * sin(yaw) + low * cos(yaw), yaw)
    return GridMap(np.full(shape, UNKNOWN, np.int8), resolution, origin)


def _sweep_floor(floor: Floor, grid: GridMap) -> NDArray[np.bool_]:
    """Cells in rooms and door gaps."""
    rooms = {room.id: room.polygon for room in floor.rooms}
    gaps = []
    for door in floor.doors:
        # A cell more than the wall, so that rounding leaves no seam between gap and room.
        reach = max(door.line.distance(rooms[room]) for room in door.room_ids) + grid.resolution
        gaps.append(door.line.buffer(reach, cap_style="flat"))
    return _fill_polygons([*rooms.values(), *gaps], grid)


def _fill_polygons(polygons: Iterable[Polygon], grid: GridMap) -> NDArray[np.bool_]:
    """Cells whose centres lie in any of the polygons."""
    filled = np.zeros(grid.shape, bool)
    for polygon in polygons:
        if not polygon.is_empty:
            rows, cols, inside = cells_of_polygon(polygon, grid)
            filled[rows, cols] |= inside
    return filled


def _grow(mask: NDArray[np.bool_], radius_px: float) -> NDArray[np.bool_]:
    """The mask widened by a disc of at least one cell."""
    radius = max(1, round(radius_px))
    row, col = np.ogrid[-radius : radius + 1, -radius : radius + 1]
    disc = (row**2 + col**2 <= (radius + 0.5) ** 2).astype(np.uint8)
    return np.asarray(cv2.dilate(mask.astype(np.uint8), disc), bool)


def _draw_sources(
    shape: tuple[int, int], noise: float, resolution: float, rng: np.random.Generator
) -> tuple[NDArray[np.int_], ...]:
    """For each cell the row and col that a bad scan match shows there instead: slow drift, waves and grain."""
    sources = []
    for places in np.ogrid[: shape[0], : shape[1]]:
        shift = sum(reach * _draw_field(shape, wavelength / resolution, rng) for reach, wavelength in DISPLACEMENTS)
        shifted = np.floor(places + noise * shift / resolution + 0.5).astype(int)
        sources.append(np.clip(shifted, 0, places.size - 1))
    return tuple(sources)


def _draw_field(shape: tuple[int, int], wavelength_px: float, rng: np.random.Generator) -> NDArray[np.float64]:
    """Random values in -1 … 1 that vary smoothly over a wavelength; independent cells below one cell.

    Only plain sums and products of uniform draws: the same bits on every machine.
    """
    if wavelength_px <= 1:
        return 2 * rng.random(shape) - 1
    (row, down), (col, across) = (_split_steps(length, wavelength_px) for length in shape)
    knots = 2 * rng.random((row[-1] + 2, col[-1] + 2)) - 1
    rows = knots[row] * (1 - down[:, None]) + knots[row + 1] * down[:, None]
    return rows[:, col] * (1 - across) + rows[:, col + 1] * across


def _split_steps(length: int, step: float) -> tuple[NDArray[np.int_], NDArray[np.float64]]:
    """For each cell the knot before it, and how far it is on the way to the next, eased at both ends."""
    way = np.arange(length) / step
    knot = np.floor(way).astype(int)
    way -= knot
    return knot, way * way * (3 - 2 * way)


def _roughen_cells(cells: NDArray[np.int8], noise: float, rng: np.random.Generator) -> None:
    """Thicken walls here, leave gaps there, and put specks of dirt and holes into free space, in place."""
    chance = rng.random(cells.shape)
    free, wall = cells == FREE, cells == OCCUPIED
    cells[_grow(wall, 1) & ~free & ~wall & (chance < noise * THICKENED)] = OCCUPIED
    cells[wall & (chance < noise * UNSEEN)] = UNKNOWN
    cells[free & (chance < noise * SALT)] = OCCUPIED
    cells[free & (chance > 1 - noise * HOLES)] = UNKNOWN


def _spray_rays(
    cells: NDArray[np.int8], floor: Floor, grid: GridMap, wall_thickness: float, rng: np.random.Generator
) -> None:
    """Draw rays through one outer wall into the unknown, in place: free cells, and echoes where some of them end."""
    building = unary_union([room.polygon for room in floor.rooms]).buffer(wall_thickness, join_style="mitre")
    facades = _find_facades(floor, building, wall_thickness)
    if not facades:
        return
    rays = _cast_rays(facades[int(rng.integers(len(facades)))], building, rng)
    drawing = np.zeros(grid.shape, np.uint8)
    for ray, chance in zip(rays, rng.random(len(rays)), strict=True):
        rows, cols = (np.floor(places).astype(int).tolist() for places in grid.map_to_pixel(*ray.xy))
        cv2.line(drawing, (cols[0], rows[0]), (cols[1], rows[1]), 1)
        if chance < ECHOES:
            cv2.line(drawing, (cols[1], rows[1]), (cols[1], rows[1]), 2)
    cells[drawing == 1] = FREE
    cells[drawing == 2] = OCCUPIED


def _find_facades(floor: Floor, building: BaseGeometry, wall_thickness: float) -> list[NDArray[np.float64]]:
    """Ends, shape (2, 2), of room sides of at least 2 m from which nothing else of the building is in sight.

    The room lies on the left, outside is on the right.
    """
    facades = []
    for room in floor.rooms:
        for start, end in pairwise(shapely.get_coordinates(room.polygon.exterior)):
            length = float(np.hypot(*(end - start)))
            outward = np.array([end[1] - start[1], start[0] - end[0]]) / length
            middle = (start + end) / 2
            view = LineString(
                [middle + (wall_thickness + STRETCH) * outward, middle + (wall_thickness + SPRAY_REACH) * outward]
            )
            if length >= 2 and view.disjoint(building):
                facades.append(np.array([start, end]))
    return facades


def _cast_rays(facade: NDArray[np.float64], building: BaseGeometry, rng: np.random.Generator) -> list[LineString]:
    """Rays from just inside a facade to where they end outside; each fan comes from one place in the room."""
    start, along = facade[0], facade[1] - facade[0]
    inward = np.array([-along[1], along[0]]) / np.hypot(*along)
    rays = []
    for _ in range(STATIONS):
        station = start + along * (0.2 + 0.6 * rng.random()) + inward * (1 + 2 * rng.random())
        for place, reach in rng.random((RAYS, 2)):
            aim = start + along * (0.1 + 0.8 * place)
            direction = (aim - station) / np.hypot(*(aim - station))
            outside = LineString([aim, aim + SPRAY_REACH * reach * direction]).difference(building)
            if not outside.is_empty:
                end = shapely.get_coordinates(shapely.get_parts(outside)[0])[-1]
                rays.append(LineString([aim - STRETCH * direction, end]))
    return rays
