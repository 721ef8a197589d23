"""Simulation of the grid map that a robot with a lidar would make of a floor."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from math import ceil, cos, pi, sin

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon, unary_union
from shapely.geometry.base import BaseGeometry

from pianta._types import Floats, LabelImage, Mask
from pianta.errors import OptionError
from pianta.floor import Floor, cells_of_polygon
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.worlds.door_leaves import draw_door_leaves
from pianta.worlds.floors import make_l_floor
from pianta.worlds.furnish import place_obstacles
from pianta.worlds.wall_axes import OUTER_WALL, Seed

# Least and greatest value of each option, and its unit.
LIMITS = {
    "resolution": (0.005, 0.5, "metres per cell"),
    "margin": (0, 1000, "metres"),
    "wall_thickness": (0.01, 10, "metres"),
    "noise": (0, 1, ""),
    "drift": (0, 10, "metres"),
    "furniture": (0, 10, ""),
    "yaw": (-2 * pi, 2 * pi, "radians"),
}

# The constants of the noise and of the rays were chosen by hand.
# Depth of wall that a lidar marks as occupied: the face, without the space behind; metres.
FACE_DEPTH = 0.05
# Noise of level 1, as drift, waves and grain: greatest displacement of walls, and its wavelength; metres.
DISPLACEMENTS = ((0.12, 6.0), (0.05, 0.5), (0.035, 0.0))
# Noise of level 1, share of the cells beside walls that become occupied.
THICKENED_SHARE = 0.5
# Noise of level 1, share of the occupied cells that become unknown.
MISSED_SHARE = 0.08
# Noise of level 1, share of the free cells that become occupied.
SPECK_SHARE = 0.0006
# Noise of level 1, share of the free cells that become unknown.
HOLE_SHARE = 0.001

# Length of rays beyond the glass, at most; metres.
RAY_REACH = 6.0
# Positions of the scanner from which rays leave through the glass.
STATIONS = 4
# Rays from each position.
RAYS = 25
# Share of the rays that end at an echo.
ECHO_SHARE = 0.6
# How far inside the glass rays begin, so that they meet free space even if noise has moved the wall; metres.
RAY_OVERLAP = 0.2
# Shorter sides of rooms are no glass walls; metres.
MIN_FACADE = 2

SAMPLE_SEED = 9


def simulate_map(
    floor: Floor,
    *,
    resolution: float = 0.05,
    margin: float | None = None,
    wall_thickness: float = OUTER_WALL,
    solid_walls: bool = False,
    noise: float = 0.0,
    drift: float | None = None,
    furniture: float = 0.0,
    dense_furniture: bool = False,
    door_leaves: bool = False,
    glass_spray: bool = False,
    yaw: float = 0.0,
    seed: Seed = 0,
) -> GridMap:
    """Grid map of a floor in the floor's own frame: free rooms and door gaps, occupied wall faces, unknown elsewhere.

    The furniture that the floor has is on the map; the options add more.
    resolution, yaw: metres per cell, and radians counter-clockwise from the floor's axes to those of the grid.
    margin: unknown space around the outer walls, metres; by default 1, or the reach of the rays with glass_spray.
    wall_thickness: of the outer walls, metres; inner walls are the gaps between the rooms.
    solid_walls: whether walls and furniture are occupied in full depth, as on a plan, not only their faces.
    noise: 0 clean … 1 a bad map: drifting walls, rough faces, gaps in walls, specks in free space.
    drift: greatest displacement of walls by the slow drift, metres; None for that of the noise.
    furniture: 0 empty … 1 a busy office; corridors stay empty, and no piece closes a door or a passage.
    dense_furniture: furniture by the labels of rooms, also in corridors, which may nearly close passages.
    door_leaves: doors are open, half open or shut; otherwise all are gaps.
    glass_spray: one outer wall is glass, and fans of rays leave the building through it.
    seed: of noise, furniture, rays and leaves, each with a random stream of its own.
    Raises OptionError, with every fault in one message, when an option is out of range.
    """
    margin = margin if margin is not None else RAY_REACH if glass_spray else 1.0
    lengths = {"resolution": resolution, "margin": margin, "wall_thickness": wall_thickness}
    check_map_options(floor, **lengths, noise=noise, drift=drift or 0, furniture=furniture, yaw=yaw)
    rng = np.random.default_rng(seed)
    furniture_rng, noise_rng, ray_rng = rng.spawn(3)
    blank = _make_blank_grid(floor, resolution, margin + wall_thickness, yaw)
    obstacles = place_obstacles(floor, furniture, resolution, furniture_rng, by_label=dense_furniture)
    if dense_furniture:
        obstacles = _widen(obstacles, resolution)
    obstacles += _widen([piece.polygon for piece in floor.furniture], resolution)
    if door_leaves:
        obstacles += _widen(draw_door_leaves(floor, rng=rng.spawn(1)[0])[0], resolution)
    inside, blocked = _fill_floor(floor, blank), _fill_polygons(obstacles, blank)
    sources = _draw_sources(blank.shape, noise, drift, resolution, noise_rng)
    inside, free = inside[sources], (inside & ~blocked)[sources]
    solid = _grow(inside, wall_thickness / resolution) if solid_walls else _grow(free, FACE_DEPTH / resolution)
    cells = np.select([free, solid], [FREE, OCCUPIED], UNKNOWN).astype(np.int8)
    _roughen_cells(cells, noise, noise_rng)
    if glass_spray:
        _draw_rays(cells, floor, blank, wall_thickness, ray_rng)
    return GridMap(cells, resolution, blank.origin)


def list_shut_doors(floor: Floor, *, seed: int) -> list[int]:
    """Indices of the doors of a floor that are shut on its map by `simulate_map` with door_leaves and this seed."""
    return draw_door_leaves(floor, rng=np.random.default_rng(seed).spawn(4)[3])[1]


def label_displaced_rooms(floor: Floor, grid: GridMap, *, noise: float, drift: float | None, seed: Seed) -> LabelImage:
    """Ids of the rooms of a floor, shape (H, W), displaced like the walls of its map; 0 elsewhere.

    grid: made by `simulate_map` with this noise, drift and seed, without yaw.
    """
    noise_rng = np.random.default_rng(seed).spawn(3)[1]
    sources = _draw_sources(grid.shape, noise, drift, grid.resolution, noise_rng)
    return np.asarray(floor.label_image(grid)[sources], np.int32)


def make_sample() -> tuple[Floor, GridMap]:
    """The sample of pianta: an L-shaped floor of 20 rooms, and a map of it with little noise and furniture."""
    floor = make_l_floor(seed=SAMPLE_SEED, room_width=(3.2, 7.5))
    return floor, simulate_map(floor, noise=0.3, furniture=0.2, seed=SAMPLE_SEED)


def check_map_options(floor: Floor | None = None, **options: float) -> None:
    """Raise OptionError naming all options that are out of their limits; floor: the one to map, which needs rooms."""
    faults = ["the floor has no rooms, give one at least"] if floor is not None and not floor.rooms else []
    for name, value in options.items():
        least, most, unit = LIMITS[name]
        if not least <= value <= most:
            faults.append(f"{name} is {value}, give {least:g} … {most:g} {unit}".rstrip())
    if faults:
        raise OptionError("cannot map the floor: " + "; ".join(faults))


def _make_blank_grid(floor: Floor, resolution: float, margin: float, yaw: float) -> GridMap:
    """Unknown grid with a yaw that contains all rooms with a margin around them."""
    x, y = shapely.get_coordinates([room.polygon for room in floor.rooms]).T
    right, up = x * cos(yaw) + y * sin(yaw), y * cos(yaw) - x * sin(yaw)
    left, low = right.min() - margin, up.min() - margin
    shape = (ceil((up.max() + margin - low) / resolution), ceil((right.max() + margin - left) / resolution))
    origin = (left * cos(yaw) - low * sin(yaw), left * sin(yaw) + low * cos(yaw), yaw)
    return GridMap(np.full(shape, UNKNOWN, np.int8), resolution, origin)


def _fill_floor(floor: Floor, grid: GridMap) -> Mask:
    """Cells in rooms and door gaps."""
    rooms = {room.id: room.polygon for room in floor.rooms}
    gaps = []
    for door in floor.doors:
        # One cell more than the wall, so that no unknown cells remain between gap and room.
        reach = max(door.line.distance(rooms[room]) for room in door.room_ids) + grid.resolution
        gaps.append(door.line.buffer(reach, cap_style="flat"))
    return _fill_polygons([*rooms.values(), *gaps], grid)


def _fill_polygons(polygons: Iterable[Polygon], grid: GridMap) -> Mask:
    """Cells whose centres lie in any of the polygons."""
    filled = np.zeros(grid.shape, bool)
    for polygon in polygons:
        if not polygon.is_empty:
            rows, cols, inside = cells_of_polygon(polygon, grid)
            filled[rows, cols] |= inside
    return filled


def _widen(polygons: Sequence[Polygon], resolution: float) -> list[Polygon]:
    """The polygons; those that could slip between the centres of cells are widened to the diagonal of a cell."""
    thin = resolution * 2**0.5
    return [
        polygon.buffer(thin / 2, join_style="mitre") if polygon.buffer(-thin / 2).is_empty else polygon
        for polygon in polygons
    ]


def _grow(mask: Mask, radius_px: float) -> Mask:
    """The mask widened by a disc of at least one cell."""
    radius = max(1, round(radius_px))
    row, col = np.ogrid[-radius : radius + 1, -radius : radius + 1]
    disc = (row**2 + col**2 <= (radius + 0.5) ** 2).astype(np.uint8)
    return np.asarray(cv2.dilate(mask.astype(np.uint8), disc), bool)


def _draw_sources(
    shape: tuple[int, int], noise: float, drift: float | None, resolution: float, rng: np.random.Generator
) -> tuple[NDArray[np.int_], ...]:
    """For each cell the row and col that a bad scan match shows there instead: slow drift, waves and grain."""
    if not (noise or drift):
        return np.ix_(*map(np.arange, shape))
    sources = []
    for positions in np.ogrid[: shape[0], : shape[1]]:
        slow, *rough = (reach * _draw_field(shape, wavelength / resolution, rng) for reach, wavelength in DISPLACEMENTS)
        shift = noise * sum(rough, slow) if drift is None else drift / DISPLACEMENTS[0][0] * slow + noise * sum(rough)
        shifted = np.floor(positions + shift / resolution + 0.5).astype(int)
        sources.append(np.clip(shifted, 0, positions.size - 1))
    return tuple(sources)


def _draw_field(shape: tuple[int, int], wavelength_px: float, rng: np.random.Generator) -> Floats:
    """Random values in -1 … 1 that vary smoothly over a wavelength; cells are independent if it is below one cell.

    Only sums and products of uniform random numbers, so that the bits are the same on every machine.
    """
    if wavelength_px <= 1:
        return 2 * rng.random(shape) - 1
    (row, down), (col, across) = (_locate_knots(length, wavelength_px) for length in shape)
    knots = 2 * rng.random((row[-1] + 2, col[-1] + 2)) - 1
    rows = knots[row] * (1 - down[:, None]) + knots[row + 1] * down[:, None]
    return rows[:, col] * (1 - across) + rows[:, col + 1] * across


def _locate_knots(length: int, step: float) -> tuple[NDArray[np.int_], Floats]:
    """For each cell the knot before it, and the weight 0 … 1 of the next one, smooth at both ends."""
    position = np.arange(length) / step
    knot = np.floor(position).astype(int)
    position -= knot
    return knot, position * position * (3 - 2 * position)


def _roughen_cells(cells: NDArray[np.int8], noise: float, rng: np.random.Generator) -> None:
    """Thicken some walls, leave gaps in others, and add occupied and unknown specks to free space, in place."""
    chance = rng.random(cells.shape)
    free, wall = cells == FREE, cells == OCCUPIED
    cells[_grow(wall, 1) & ~free & ~wall & (chance < noise * THICKENED_SHARE)] = OCCUPIED
    cells[wall & (chance < noise * MISSED_SHARE)] = UNKNOWN
    cells[free & (chance < noise * SPECK_SHARE)] = OCCUPIED
    cells[free & (chance > 1 - noise * HOLE_SHARE)] = UNKNOWN


def _draw_rays(
    cells: NDArray[np.int8], floor: Floor, grid: GridMap, wall_thickness: float, rng: np.random.Generator
) -> None:
    """Draw rays through one outer wall into unknown space, in place: free cells, and echoes at the ends of some."""
    building = unary_union([room.polygon for room in floor.rooms]).buffer(wall_thickness, join_style="mitre")
    facades = _find_facades(floor, building, wall_thickness)
    if not facades:
        return
    rays = _cast_rays(facades[int(rng.integers(len(facades)))], building, rng)
    drawing = np.zeros(grid.shape, np.uint8)
    for ray, chance in zip(rays, rng.random(len(rays)), strict=True):
        rows, cols = (np.floor(pixels).astype(int).tolist() for pixels in grid.map_to_pixel(*ray.xy))
        cv2.line(drawing, (cols[0], rows[0]), (cols[1], rows[1]), 1)
        if chance < ECHO_SHARE:
            cv2.line(drawing, (cols[1], rows[1]), (cols[1], rows[1]), 2)
    cells[drawing == 1] = FREE
    cells[drawing == 2] = OCCUPIED


def _find_facades(floor: Floor, building: BaseGeometry, wall_thickness: float) -> list[Floats]:
    """Ends, shape (2, 2), of room sides of at least MIN_FACADE from which no other part of the building is visible.

    The room lies on the left, outside is on the right.
    """
    facades = []
    for room in floor.rooms:
        for start, end in pairwise(shapely.get_coordinates(room.polygon.exterior)):
            length = float(np.hypot(*(end - start)))
            outward = np.array([end[1] - start[1], start[0] - end[0]]) / length
            middle = (start + end) / 2
            view = LineString(
                [middle + (wall_thickness + RAY_OVERLAP) * outward, middle + (wall_thickness + RAY_REACH) * outward]
            )
            if length >= MIN_FACADE and view.disjoint(building):
                facades.append(np.array([start, end]))
    return facades


def _cast_rays(facade: Floats, building: BaseGeometry, rng: np.random.Generator) -> list[LineString]:
    """Rays from just inside a facade to their ends outside; each fan has one station in the room."""
    start, along = facade[0], facade[1] - facade[0]
    inward = np.array([-along[1], along[0]]) / np.hypot(*along)
    rays = []
    for _ in range(STATIONS):
        station = start + along * (0.2 + 0.6 * rng.random()) + inward * (1 + 2 * rng.random())
        for position, reach in rng.random((RAYS, 2)):
            aim = start + along * (0.1 + 0.8 * position)
            direction = (aim - station) / np.hypot(*(aim - station))
            outside = LineString([aim, aim + RAY_REACH * reach * direction]).difference(building)
            if not outside.is_empty:
                end = shapely.get_coordinates(shapely.get_parts(outside)[0])[-1]
                rays.append(LineString([aim - RAY_OVERLAP * direction, end]))
    return rays
