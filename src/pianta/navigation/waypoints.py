"""Poses for robots: one in each room, and one on each side of every door, which looks at the door."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, hypot

import numpy as np
from shapely import Point

from pianta.floor import Door, Floor, cells_of_polygon
from pianta.gridmap import GridMap
from pianta.navigation.free_space import FreeSpace, find_free_space
from pianta.navigation.positions import Cell, locate_doors, locate_rooms
from pianta.navigation.robot import ROBOT_RADIUS

# Metres between the rim of the robot and the line of the door, so that a leaf can open or people pass. By hand.
STAND_OFF = 0.5
# Cells that are tried, the nearest to that point first.
MAX_TRIED = 200
MAX_APPROACH = 2.0  # metres between the door and a pose; farther away it is no approach. Chosen by hand.


@dataclass(frozen=True)
class Pose:
    """A pose in the map frame. x, y: metres. yaw: radians, counter-clockwise from x."""

    x: float
    y: float
    yaw: float


@dataclass(frozen=True)
class Approach:
    """A pose in front of a door. door: its index on the floor. room: the id of the room in which the pose is."""

    door: int
    room: int
    pose: Pose


def find_room_poses(floor: Floor, grid: GridMap, *, robot_radius: float = ROBOT_RADIUS) -> dict[int, Pose]:
    """A pose in each room where the robot fits, by the id of the room; it looks at the nearest door of the room."""
    space = find_free_space(floor, grid, robot_radius)
    doors = locate_doors(space, floor)
    poses = {}
    for room, cell in locate_rooms(space, floor, doors).items():
        own = [door.line for door in floor.doors if room in door.room_ids]
        ((x, y),) = space.to_map([cell]).tolist()
        middles = [line.interpolate(0.5, normalized=True) for line in own]
        ahead = min(((point.x - x, point.y - y) for point in middles), key=lambda way: hypot(*way), default=(1.0, 0.0))
        poses[room] = Pose(x, y, atan2(ahead[1], ahead[0]))
    return poses


def find_approaches(floor: Floor, grid: GridMap, *, robot_radius: float = ROBOT_RADIUS) -> list[Approach]:
    """The poses on both sides of each door that the robot can pass; of an entrance the one inside."""
    space = find_free_space(floor, grid, robot_radius)
    approaches = []
    for index, (door, cell) in enumerate(zip(floor.doors, locate_doors(space, floor), strict=True)):
        for room in door.room_ids:
            pose = None if cell is None else _find_approach(space, floor, door, room, cell)
            approaches += [Approach(index, room, pose)] if pose else []
    return approaches


def _find_approach(space: FreeSpace, floor: Floor, door: Door, room: int, position: Cell) -> Pose | None:
    """In sight of the position in a door, the cell of a room nearest to a point STAND_OFF before its middle."""
    (x, y), target = _find_middle(door), _find_target(floor, door, room, space.radius + STAND_OFF)
    rows, cols, is_near = cells_of_polygon(Point(x, y).buffer(MAX_APPROACH), space.grid)
    near = np.argwhere(is_near & space.open[rows, cols] & (space.rooms[rows, cols] == room))
    cells = near + np.array([rows.start, cols.start])
    order = np.argsort(np.hypot(*(space.to_map(cells) - target).T), kind="stable")[:MAX_TRIED]
    cell = next((cell for cell in cells[order] if space.is_straight(position, cell)), None)
    if cell is None:
        return None
    ((at_x, at_y),) = space.to_map([cell]).tolist()
    return Pose(at_x, at_y, atan2(y - at_y, x - at_x))


def _find_middle(door: Door) -> tuple[float, float]:
    middle = door.line.interpolate(0.5, normalized=True)
    return middle.x, middle.y


def _find_target(floor: Floor, door: Door, room: int, distance: float) -> tuple[float, float]:
    """The point before the middle of a door, on the side of a room."""
    (x0, y0), *_, (x1, y1) = door.line.coords
    (x, y), length = _find_middle(door), hypot(x1 - x0, y1 - y0)
    # A door of no length: towards the middle of the room
    centroid = floor[room].polygon.centroid
    normal = (y0 - y1, x1 - x0) if length else (centroid.x - x, centroid.y - y)
    scale = distance / (hypot(*normal) or 1.0)
    sides = [(x + side * normal[0], y + side * normal[1]) for side in (scale, -scale)]
    return min(sides, key=lambda side: floor[room].polygon.distance(Point(side)))
