"""Where robots begin: at entrances, stairs and lifts, clear of walls."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from pianta._types import Mask
from pianta.errors import LabelError, OptionError
from pianta.exploration.routes import measure_distances
from pianta.exploration.world import Cells, World, clear_cells
from pianta.floor import Floor
from pianta.labels import standard_name

Point = tuple[float, float]

WAYS_IN = ("ENTRANCE", "STAIRS", "ELEVATOR")
CORRIDORS = ("CORRIDOR", "HALL", "LOBBY", "CONNECTION", "C", "H")
# Robots that share a start stand this far apart, m, from middle to middle, as one walks.
APART = 0.6


def find_starts(world: World, *, radius: float = 0.2) -> list[Point]:
    """Points x, y, metres of the map frame, where a robot of a radius may begin, those from which it gets far first.

    At every entrance; without one in every room of stairs, a lift or an entrance; else in the largest corridor, or
    room; and on a map without a floor in the widest place.
    Raises OptionError when there is no place that is clear of walls.
    """
    clear = clear_cells(world.blocked, radius / world.resolution)
    if not clear.any():
        raise OptionError(f"no place of the world is clear of walls by {radius} m, give a smaller radius")
    _, parts = cv2.connectedComponents(clear.astype(np.uint8), connectivity=4)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    cells = _entrance_cells(world, clear) or _room_cells(world, clear) or [_widest_cell(world.blocked, clear)]
    largest = [cell for cell in cells if sizes[parts[cell]] == sizes.max()]
    chosen = largest or [_widest_cell(world.blocked, parts == sizes.argmax())]
    return [world.point(cell) for cell in dict.fromkeys(chosen)]


def place_robots(world: World, starts: Sequence[Point], robots: int, *, radius: float) -> list[Point]:
    """A point for each robot: the starts in turn, and beside them for further robots.

    Raises OptionError for a start in a wall or outside, for more starts than robots, and when there is no place for so
    many robots.
    """
    if len(starts) > robots:
        raise OptionError(f"{len(starts)} starts are given for {robots} robots, give one for each at most")
    for start in starts:
        check_start(world, start, radius=radius)
    clear = clear_cells(world.blocked, radius / world.resolution)
    taken: list[tuple[int, int]] = []
    for robot in range(robots):
        start = world.cell(*starts[robot % len(starts)])
        taken.append(start if robot < len(starts) else _step_aside(clear, start, taken, world.resolution))
    return [starts[robot] if robot < len(starts) else world.point(cell) for robot, cell in enumerate(taken)]


def check_start(world: World, start: Point, *, radius: float) -> None:
    """Refuse a start, x, y in metres of the map frame, where a robot of a radius cannot stand.

    Raises OptionError, in one line.
    """
    x, y = start
    if not np.isfinite(start).all():
        raise OptionError(f"start is {x}, {y}, give finite metres of the map frame")
    row, col = cell = world.cell(x, y)
    height, width = world.blocked.shape
    what = None
    if not (0 <= row < height and 0 <= col < width):
        what = "outside of the world"
    elif world.blocked[cell]:
        what = "in a wall or outside of the building"
    elif not world.is_clear(cell, radius):
        what = f"nearer to a wall than the robot's radius of {radius} m"
    if what:
        x, y = find_starts(world, radius=radius)[0]
        raise OptionError(f"start {start[0]:g}, {start[1]:g} is {what}, give a free place such as {x:.2f}, {y:.2f}")


def find_rooms(floor: Floor | None, labels: Iterable[str]) -> list[int]:
    """Ids of the rooms that have one of the labels, in standard form."""
    wanted = set(labels)
    return [room.id for room in floor.rooms if _label_of(room.label) in wanted] if floor else []


def _label_of(label: str | None) -> str | None:
    try:
        return None if label is None else standard_name(label)
    except LabelError:
        return label


def _entrance_cells(world: World, clear: Mask) -> list[tuple[int, int]]:
    """For each entrance the clear cell of its room that is nearest to it."""
    cells = []
    for door in world.floor.doors if world.floor else ():
        inside = clear & (world.room_of_cell == door.rooms[0])
        if door.is_entrance and inside.any():
            middle = door.line.interpolate(0.5, normalized=True)
            row, col = world.place(middle.x, middle.y)
            candidates = np.argwhere(inside)
            cells.append(_pick(candidates, np.hypot(*(candidates + 0.5 - [row, col]).T)))
    return cells


def _room_cells(world: World, clear: Mask) -> list[tuple[int, int]]:
    """The widest place of every room of stairs, a lift or an entrance, else of the largest corridor or room."""
    if world.floor is None:
        return []
    areas = {room.id: room.polygon.area for room in world.floor.rooms}
    corridors = find_rooms(world.floor, CORRIDORS) or list(areas)
    for rooms in (find_rooms(world.floor, WAYS_IN), [max(corridors, key=lambda room: areas[room])]):
        inside = [clear & (world.room_of_cell == room) for room in rooms]
        if cells := [_widest_cell(world.blocked, mask) for mask in inside if mask.any()]:
            return cells
    return []


def _widest_cell(blocked: Mask, inside: Mask) -> tuple[int, int]:
    """Of the cells inside the one that is furthest from obstacles."""
    free = np.pad(~blocked, 1).astype(np.uint8)
    widths = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    candidates = np.argwhere(inside)
    return _pick(candidates, -widths[inside].astype(float))


def _pick(candidates: Cells, costs: NDArray[np.float64]) -> tuple[int, int]:
    row, col = candidates[int(np.argmin(costs))].tolist()
    return row, col


def _step_aside(
    clear: Mask, start: tuple[int, int], taken: Sequence[tuple[int, int]], resolution: float
) -> tuple[int, int]:
    """The cell nearest to the start that is apart from those that are taken."""
    distances = measure_distances(clear, [start], resolution=resolution)
    for row, col in taken:
        near = np.hypot(*np.ogrid[-row : clear.shape[0] - row, -col : clear.shape[1] - col]) * resolution < APART
        distances[near] = np.inf
    cell = np.unravel_index(int(np.argmin(distances)), distances.shape)
    if not np.isfinite(distances[cell]):
        raise OptionError(f"there is no place for robot {len(taken) + 1} at its start, give fewer robots")
    return int(cell[0]), int(cell[1])
