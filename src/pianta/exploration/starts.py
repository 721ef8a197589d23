"""The start points of robots: at entrances, stairs and lifts, clear of walls."""

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

ENTRY_LABELS = ("ENTRANCE", "STAIRS", "ELEVATOR")
CORRIDOR_LABELS = ("CORRIDOR", "HALL", "LOBBY", "CONNECTION", "C", "H")
# Distance between the middles of robots that share a start, m; chosen by hand.
START_GAP = 0.6


def find_starts(world: World, *, radius: float = 0.2) -> list[Point]:
    """Find start points x, y, metres of the map frame, for a robot of a radius, metres.

    One at every entrance; without entrances one in every entry room, stairs or lift; else in the largest corridor, or
    room; without a floor in the widest part of the map. Only points in the largest connected area count.
    Raises OptionError if no cell is clear of walls.
    """
    clear = clear_cells(world.blocked, radius / world.resolution)
    if not clear.any():
        raise OptionError(f"no cell of the world is clear of walls by {radius} m, give a smaller radius")
    _, parts = cv2.connectedComponents(clear.astype(np.uint8), connectivity=4)
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    cells = _entrance_cells(world, clear) or _room_cells(world, clear) or [_widest_cell(world.blocked, clear)]
    largest = [cell for cell in cells if sizes[parts[cell]] == sizes.max()]
    chosen = largest or [_widest_cell(world.blocked, parts == sizes.argmax())]
    return [world.point(cell) for cell in dict.fromkeys(chosen)]


def place_robots(world: World, starts: Sequence[Point], robots: int, *, radius: float) -> list[Point]:
    """Return a point for each robot: the starts in turn, and free cells near them for further robots.

    Raises OptionError for a start in a wall or outside, for more starts than robots, and for too many robots.
    """
    if len(starts) > robots:
        raise OptionError(f"{len(starts)} starts are given for {robots} robots, give one for each at most")
    for start in starts:
        check_start(world, start, radius=radius)
    clear = clear_cells(world.blocked, radius / world.resolution)
    occupied: list[tuple[int, int]] = []
    for robot in range(robots):
        start = world.cell(*starts[robot % len(starts)])
        occupied.append(start if robot < len(starts) else _free_cell_near(clear, start, occupied, world.resolution))
    return [starts[robot] if robot < len(starts) else world.point(cell) for robot, cell in enumerate(occupied)]


def check_start(world: World, start: Point, *, radius: float) -> None:
    """Raise OptionError if a robot of a radius cannot stand at a start, x, y in metres of the map frame."""
    x, y = start
    if not np.isfinite(start).all():
        raise OptionError(f"start is {x}, {y}, give finite metres of the map frame")
    row, col = cell = world.cell(x, y)
    height, width = world.blocked.shape
    fault = None
    if not (0 <= row < height and 0 <= col < width):
        fault = "outside of the world"
    elif world.blocked[cell]:
        fault = "in a wall or outside of the building"
    elif not clear_cells(world.blocked, radius / world.resolution)[cell]:
        fault = f"nearer to a wall than the robot's radius of {radius} m"
    if fault:
        x, y = find_starts(world, radius=radius)[0]
        raise OptionError(f"start {start[0]:g}, {start[1]:g} is {fault}, give a free point such as {x:.2f}, {y:.2f}")


def find_rooms(floor: Floor | None, labels: Iterable[str]) -> list[int]:
    """Ids of the rooms that have one of the labels, in standard form."""
    wanted = set(labels)
    return [room.id for room in floor.rooms if standard_label(room.label) in wanted] if floor else []


def standard_label(label: str | None) -> str | None:
    """The standard form of a label, or the label itself if it is invalid."""
    try:
        return None if label is None else standard_name(label)
    except LabelError:
        return label


def _entrance_cells(world: World, clear: Mask) -> list[tuple[int, int]]:
    """The nearest clear cell of the room of each entrance."""
    cells = []
    for door in world.floor.doors if world.floor else ():
        inside = clear & (world.room_of_cell == door.rooms[0])
        if door.is_entrance and inside.any():
            middle = door.line.interpolate(0.5, normalized=True)
            candidates = np.argwhere(inside)
            gaps = np.hypot(*(candidates + 0.5 - world.pixel(middle.x, middle.y)).T)
            cells.append(_cheapest_cell(candidates, gaps))
    return cells


def _room_cells(world: World, clear: Mask) -> list[tuple[int, int]]:
    """The widest cell of every entry room, stairs or lift; else of the largest corridor or room."""
    if world.floor is None:
        return []
    areas = {room.id: room.polygon.area for room in world.floor.rooms}
    corridors = find_rooms(world.floor, CORRIDOR_LABELS) or list(areas)
    for rooms in (find_rooms(world.floor, ENTRY_LABELS), [max(corridors, key=lambda room: areas[room])]):
        inside = [clear & (world.room_of_cell == room) for room in rooms]
        if cells := [_widest_cell(world.blocked, mask) for mask in inside if mask.any()]:
            return cells
    return []


def _widest_cell(blocked: Mask, inside: Mask) -> tuple[int, int]:
    """The cell inside that is furthest from obstacles."""
    free = np.pad(~blocked, 1).astype(np.uint8)
    widths = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    candidates = np.argwhere(inside)
    return _cheapest_cell(candidates, -widths[inside].astype(float))


def _cheapest_cell(candidates: Cells, costs: NDArray[np.float64]) -> tuple[int, int]:
    row, col = candidates[int(np.argmin(costs))].tolist()
    return row, col


def _free_cell_near(
    clear: Mask, start: tuple[int, int], occupied: Sequence[tuple[int, int]], resolution: float
) -> tuple[int, int]:
    """The cell nearest to the start that is START_GAP away from all occupied ones."""
    distances = measure_distances(clear, [start], resolution=resolution)
    for row, col in occupied:
        near = np.hypot(*np.ogrid[-row : clear.shape[0] - row, -col : clear.shape[1] - col]) * resolution < START_GAP
        distances[near] = np.inf
    cell = np.unravel_index(int(np.argmin(distances)), distances.shape)
    if not np.isfinite(distances[cell]):
        raise OptionError(f"there is no space for robot {len(occupied) + 1} at its start, give fewer robots")
    return int(cell[0]), int(cell[1])
