"""Simulate furnished robot maps with true layouts, as lessons for the network of map regions.

    pip install '.[sim]'
    python training/map_lessons.py LESSONS --minutes 30 --seed 0 [--data DIR]

Each lesson is a floor of `data/buildings` or `pianta.worlds`, furnished, with doors open, half open and shut, and
mapped by a robot that drives through some of its rooms: a lidar with noise, drift, shifted scans (ghost walls), glass,
short reach and holes. A file has at CELL metres: the map (free and occupied share of each cell), the true class of
each cell, its true room, and where the loss counts. Floors of the benches' buildings are never used.
The shares and ranges of this module were chosen by hand.
"""

from __future__ import annotations

import argparse
import time
from math import pi
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
import shapely
from lesson_files import Lesson, write_lesson
from lesson_worlds import FINE, World, build_world, draw_floor, list_annotated_floors
from numba import njit
from numpy.typing import NDArray

from pianta._types import Floats, LabelImage, Mask
from pianta.errors import PiantaError
from pianta.floor import Floor
from pianta.layout.structure.evidence import CELL, DOOR, FLOOR, FURNITURE, OUTSIDE, WALL
from pianta_bench.data.folders import find_data

Cells = NDArray[np.uint8]

# Values of the cells of a simulated map.
UNKNOWN_CELL = 0
FREE_CELL = 1
OCCUPIED_CELL = 2
# Fine cells along a side of a cell of the lesson.
FACTOR = round(CELL / FINE)
# No lesson is made of a floor with longer sides; metres.
MAX_SIDE = 90.0
# Unobserved cells further than this from any observed cell do not count in the loss; metres.
UNOBSERVED_REACH = 0.8
# A room of which a smaller share of cells is free was not observed.
MIN_FREE_SHARE = 0.03
# Fine cells of an obstacle or wall in a cell of the lesson that make it one.
MIN_CLASS_CELLS = 2
# Lessons with fewer free cells are left out.
MIN_FREE_CELLS = 500
# Cells of a lesson around its free cells.
BORDER_CELLS = 12
# How often all cells of a map are observed, as on a drawing.
DRAWING_SHARE = 0.15
# How often a map has cells of CELL metres, not FINE ones.
COARSE_SHARE = 0.25
# Distance of a robot from obstacles, at least; metres.
CLEARANCE = 0.25
# Scans of a map, at most.
MAX_SCANS = 500
# Step along a beam; fine cells.
STEP = 0.7
# How far behind its end a beam is in the obstacle; fine cells.
HIT_DEPTH = 0.4
# Share of the scans in which beams can pass glass.
GLASS_SCANS = 0.6
# Standard deviation of the shift of all scans that make ghost walls; fine cells.
GHOST_SHIFT = 5.0
# Distance between the knots of the field of drift; fine cells.
DRIFT_KNOTS = 200


class Lidar(NamedTuple):
    """The lidar of a simulated robot: beams of a scan, and their reach and noise in fine cells.

    dropout: share of the beams without a result. passing: share of the beams that pass glass, in GLASS_SCANS.
    """

    beams: int
    reach: float
    noise: float
    dropout: float
    passing: float


class MappedFloor(NamedTuple):
    """A drawn floor, the furnished world that was made of it, and the world's map in fine cells, shape (H, W)."""

    floor: Floor
    world: World
    cells: Cells


@njit(cache=True)
def scan(
    stops: Mask, glass: Mask, poses: Floats, lidar: Lidar, seed: int
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Beams that pass each cell, and beams that end in it; poses: row, col, shift of row, shift of col."""
    # Compiled functions have only this generator.
    np.random.seed(seed)  # noqa: NPY002
    passes, hits = np.zeros(stops.shape, np.int32), np.zeros(stops.shape, np.int32)
    for row, col, row_shift, col_shift in poses:
        first_angle = np.random.random() * 2 * pi  # noqa: NPY002
        passes_glass = np.random.random() < GLASS_SCANS  # noqa: NPY002
        for beam in range(lidar.beams):
            if np.random.random() < lidar.dropout:  # noqa: NPY002
                continue
            angle = first_angle + beam * 2 * pi / lidar.beams
            direction = (np.sin(angle), np.cos(angle))
            # A beam passes all glass, or no glass.
            passing = np.random.random() < lidar.passing and passes_glass  # noqa: NPY002
            length, is_hit = _measure_beam(stops, glass, (row, col), direction, (lidar.reach, passing))
            if is_hit:
                length += np.random.normal() * lidar.noise  # noqa: NPY002
            _count_beam(passes, hits, (row + row_shift, col + col_shift), direction, (length, is_hit))
    return passes, hits


@njit(cache=True)
def _measure_beam(
    stops: Mask, glass: Mask, start: tuple[float, float], direction: tuple[float, float], limits: tuple[float, bool]
) -> tuple[float, bool]:
    """Length of a beam, and whether an obstacle ends it; limits: its reach, and whether it passes glass."""
    length = 0.0
    for step in range(int(limits[0] / STEP)):
        length = step * STEP
        row, col = int(start[0] + direction[0] * length), int(start[1] + direction[1] * length)
        if row < 0 or col < 0 or row >= stops.shape[0] or col >= stops.shape[1]:
            break
        if stops[row, col] and not (limits[1] and glass[row, col]):
            return length, True
    return length, False


@njit(cache=True)
def _count_beam(
    passes: NDArray[np.int32],
    hits: NDArray[np.int32],
    start: tuple[float, float],
    direction: tuple[float, float],
    end: tuple[float, bool],
) -> None:
    """Count the cells that a beam passes, each once, and the one in which it ends; end: length, whether a hit."""
    height, width = passes.shape
    last = (-1, -1)
    for step in range(int(end[0] / STEP)):
        row, col = int(start[0] + direction[0] * step * STEP), int(start[1] + direction[1] * step * STEP)
        if 0 <= row < height and 0 <= col < width and (row, col) != last:
            passes[row, col] += 1
            last = (row, col)
    depth = end[0] + HIT_DEPTH
    row, col = int(start[0] + direction[0] * depth), int(start[1] + direction[1] * depth)
    if end[1] and 0 <= row < height and 0 <= col < width:
        hits[row, col] += 1


def map_world(world: World, rng: np.random.Generator) -> Cells:
    """The map of a world: UNKNOWN_CELL, FREE_CELL or OCCUPIED_CELL on fine cells, shape (H, W)."""
    if rng.random() < DRAWING_SHARE:
        return _map_completely(world, rng)
    poses = _draw_poses(world, rng)
    passes, hits = scan(world.stops, world.glass, poses, _draw_lidar(rng), int(rng.integers(2**31)))
    threshold = rng.uniform(0.1, 0.5)
    observed = passes + hits >= int(rng.choice([1, 1, 2, 4]))
    occupied = observed & (hits > 0) & (hits >= threshold * (passes + hits))
    cells = np.select([occupied, observed & (passes > 0)], [OCCUPIED_CELL, FREE_CELL], UNKNOWN_CELL)
    return cells.astype(np.uint8)


def _find_clear_floor(world: World) -> Mask:
    return np.asarray(((world.classes == FLOOR) | (world.classes == DOOR)) & ~world.stops)


def _map_completely(world: World, rng: np.random.Generator) -> Cells:
    """All cells as they are; walls and furniture in full depth, or only their faces."""
    clear = _find_clear_floor(world)
    cells = np.select([clear, world.stops & (world.classes != OUTSIDE)], [FREE_CELL, OCCUPIED_CELL], UNKNOWN_CELL)
    if rng.random() < 0.5:
        near = cv2.dilate(clear.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        cells[(cells == OCCUPIED_CELL) & ~near] = UNKNOWN_CELL
    return cells.astype(np.uint8)


def _draw_poses(world: World, rng: np.random.Generator) -> Floats:
    """Positions of a robot that enters most rooms, and the shifts of its scans: row, col, shifts; shape (N, 4)."""
    clearance = cv2.distanceTransform(_find_clear_floor(world).astype(np.uint8), cv2.DIST_L2, 3)
    rows, cols = np.nonzero(clearance > CLEARANCE / FINE)
    entered = rng.random(world.rooms.max() + 1) < rng.choice([1.0, 0.9, 0.6], p=[0.55, 0.25, 0.2])
    # Doors.
    entered[0] = True
    positions = np.column_stack([rows, cols])[entered[world.rooms[rows, cols]]]
    if not len(positions):
        return np.zeros((0, 4))
    spacing = rng.uniform(0.8, 2.5) / FINE
    count = int(np.clip(len(positions) / spacing**2, 5, MAX_SCANS))
    shifts = rng.normal(0, rng.choice([0.0, 0.3, 0.8], p=[0.4, 0.4, 0.2]), (count, 2))
    ghosts = rng.random(count) < (0.06 if rng.random() < 0.15 else 0)
    shifts[ghosts] += rng.normal(0, GHOST_SHIFT, 2)
    return np.column_stack([positions[rng.integers(len(positions), size=count)] + 0.5, shifts])


def _draw_lidar(rng: np.random.Generator) -> Lidar:
    reach = rng.uniform(3.5, 8) if rng.random() < 0.35 else rng.uniform(8, 30)
    return Lidar(
        beams=int(rng.choice([180, 360, 720, 1080], p=[0.1, 0.35, 0.35, 0.2])),
        reach=float(reach / FINE),
        noise=float(rng.choice([0.1, 0.4, 1.0], p=[0.4, 0.4, 0.2])),
        dropout=float(rng.choice([0.0, 0.1, 0.4], p=[0.6, 0.3, 0.1])),
        passing=float(rng.choice([0.1, 0.5, 0.95])),
    )


def degrade(cells: Cells, rng: np.random.Generator) -> Cells:
    """Add specks, holes and thick walls, remove parts of walls, and change what unknown cells are."""
    cells = cells.copy()
    chance = rng.random(cells.shape)
    if rng.random() < 0.4:
        cells[(cells == FREE_CELL) & (chance < 10 ** rng.uniform(-4, -2.0))] = OCCUPIED_CELL
    if rng.random() < 0.3:
        cells[(cells == FREE_CELL) & (chance > 1 - 10 ** rng.uniform(-4, -1.3))] = UNKNOWN_CELL
    if rng.random() < 0.3:
        cells[(cells == OCCUPIED_CELL) & (chance < rng.uniform(0, 0.35))] = rng.choice([FREE_CELL, UNKNOWN_CELL])
    if rng.random() < 0.3:
        thick = cv2.dilate((cells == OCCUPIED_CELL).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
        cells[thick & ((cells != FREE_CELL) | (rng.random(cells.shape) < 0.5))] = OCCUPIED_CELL
    style = rng.random()
    if style < 0.1:
        cells[cells == UNKNOWN_CELL] = OCCUPIED_CELL
    elif style < 0.15:
        cells[cells == OCCUPIED_CELL] = UNKNOWN_CELL
    elif style < 0.25:
        _fill_spots(cells, rng.uniform(4, 200))
    return cells


def _fill_spots(cells: Cells, size: float) -> None:
    """Make unknown spots of less than a size free; fine cells."""
    spots = (cells == UNKNOWN_CELL).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(spots, connectivity=4)
    small = stats[:, cv2.CC_STAT_AREA] < size
    small[0] = False
    cells[small[labels]] = FREE_CELL


def warp(images: list[NDArray], rng: np.random.Generator) -> list[NDArray]:
    """The images moved alike by a smooth field: the drift of the robot."""
    strength = rng.choice([0.0, rng.uniform(0, 3), rng.uniform(2, 8)], p=[0.4, 0.4, 0.2])
    height, width = images[0].shape
    knots = [max(3, side // DRIFT_KNOTS + 2) for side in (height, width)]
    fields = [rng.normal(0, strength, knots).astype(np.float32) for _ in range(2)]
    down, right = (cv2.resize(field, (width, height), interpolation=cv2.INTER_CUBIC) for field in fields)
    rows, cols = np.indices((height, width), np.float32)
    return [cv2.remap(image, cols + right, rows + down, cv2.INTER_NEAREST) for image in images]


def to_lesson(cells: Cells, classes: Cells, rooms: LabelImage, *, coarse: bool) -> Lesson:
    """A lesson of a map and its truth on fine cells.

    coarse: a cell is occupied if any of its fine cells is, as on a map with cells of CELL metres.
    """
    parts, true = _split_blocks(cells), _split_blocks(classes)
    occupied, free = (parts == OCCUPIED_CELL).sum(-1), (parts == FREE_CELL).sum(-1)
    if coarse:
        occupied = (occupied > 0) * FACTOR**2
        free = ((occupied == 0) & (free > 0)) * FACTOR**2
    pooled = true[..., 0].copy()
    for value in (FURNITURE, WALL, DOOR):
        # So that thin walls are not lost among floor.
        pooled[(true == value).sum(-1) >= MIN_CLASS_CELLS] = value
    numbers = _split_blocks(rooms).max(-1)
    numbers[(pooled != FLOOR) & (pooled != FURNITURE)] = 0
    # A room that the robot did not observe is outside of the map.
    size = np.bincount(numbers.ravel())
    hidden = np.bincount(numbers.ravel(), free.ravel() > 0, len(size)) < MIN_FREE_SHARE * size
    hidden[0] = False
    pooled[hidden[numbers]] = OUTSIDE
    numbers[hidden[numbers]] = 0
    unobserved = (occupied + free == 0).astype(np.uint8)
    near = cv2.distanceTransform(unobserved, cv2.DIST_L2, 3) <= UNOBSERVED_REACH / CELL
    return {
        "free": free.astype(np.uint8),
        "occupied": occupied.astype(np.uint8),
        "classes": pooled,
        "rooms": numbers.astype(np.uint16),
        "counts": near | (pooled == OUTSIDE),
    }


def _split_blocks(image: NDArray) -> NDArray:
    """The fine cells of each cell of a lesson, shape (h, w, FACTOR²)."""
    height, width = (side // FACTOR for side in image.shape)
    blocks = image[: height * FACTOR, : width * FACTOR].reshape(height, FACTOR, width, FACTOR)
    return blocks.swapaxes(1, 2).reshape(height, width, FACTOR**2)


def map_random_floor(annotated: list[Floor], rng: np.random.Generator) -> MappedFloor | None:
    """A random floor, furnished and mapped; None if it is too large."""
    floor, scale = draw_floor(annotated, rng)
    west, south, east, north = shapely.total_bounds([room.polygon for room in floor.rooms])
    if max(east - west, north - south) * scale > MAX_SIDE:
        return None
    world = build_world(floor, scale, rng)
    return MappedFloor(floor, world, degrade(map_world(world, rng), rng))


def make_lesson(annotated: list[Floor], rng: np.random.Generator) -> Lesson | None:
    """A lesson, cut to what is free; None if the floor is too large, or little of it is free."""
    mapped = map_random_floor(annotated, rng)
    if mapped is None:
        return None
    world = mapped.world
    # OpenCV moves no int32.
    cells, classes, rooms = warp([mapped.cells, world.classes, world.rooms.astype(np.float32)], rng)
    lesson = to_lesson(cells, classes, rooms.astype(np.int32), coarse=bool(rng.random() < COARSE_SHARE))
    rows, cols = np.nonzero(lesson["free"])
    if len(rows) < MIN_FREE_CELLS:
        return None
    window = tuple(slice(max(i.min() - BORDER_CELLS, 0), i.max() + BORDER_CELLS + 1) for i in (rows, cols))
    return {name: image[window] for name, image in lesson.items()}


def main() -> None:
    """Make lessons for some minutes."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--data", type=Path)
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    annotated = list_annotated_floors(find_data(options.data))
    stop, number = time.monotonic() + 60 * options.minutes, 0
    while time.monotonic() < stop:
        number += 1
        try:
            lesson = make_lesson(annotated, np.random.default_rng([options.seed, number]))
        except (PiantaError, shapely.errors.GEOSException):
            # Some floors are no floors any more when they are turned, or furnished.
            continue
        if lesson is not None:
            write_lesson(options.folder / f"{options.seed:03d}_{number:06d}.npz", lesson)


if __name__ == "__main__":
    main()
