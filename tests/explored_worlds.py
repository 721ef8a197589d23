"""Tiny worlds for robots: a picture with a character for each cell, and a floor of two rooms."""

import numpy as np
from shapely import LineString, box

from pianta.exploration.world import World, build_world
from pianta.floor import Door, Floor, Room

CELLS = {"#": 100, ".": 0, "?": -1}


def draw_cells(picture: str) -> np.ndarray:
    """Cells of a picture: # occupied, . free, ? unknown."""
    return np.array([[CELLS[character] for character in line] for line in picture.split()], np.int8)


def draw_world(picture: str, *, resolution: float = 1.0) -> World:
    """A world of a picture, # for obstacles, whose lower left corner is at 0, 0."""
    return World(draw_cells(picture) != 0, resolution)


def two_rooms(*, door: bool = True) -> Floor:
    """A classroom of 4 × 4 m with stairs of 3 × 4 m to the right of it, whose outlines meet."""
    rooms = (Room(1, box(0, 0, 4, 4), "CLASSROOM"), Room(2, box(4, 0, 7, 4), "STAIRS"))
    doors = (Door((1, 2), LineString([(4, 1.5), (4, 2.4)]), 0.9),) if door else ()
    return Floor(rooms, doors)


def two_room_world(*, door: bool = True) -> World:
    """The world of two_rooms, in cells of 0.1 m."""
    return build_world(two_rooms(door=door))
