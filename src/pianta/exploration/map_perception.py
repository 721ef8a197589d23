"""Rooms as robots read them from the map while they explore."""

from __future__ import annotations

import warnings
from contextlib import suppress
from dataclasses import dataclass, field

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.errors import MapError, MapWarning
from pianta.exploration.perception import Percept
from pianta.exploration.recognised_rooms import RECOGNISED_SHARE, RecognisedRoom, RecognisedRooms
from pianta.exploration.record import Record
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.mapping.beliefs import measure_trust
from pianta.mapping.mapper import Mapper

# Both chosen by hand.
UPDATE_DISTANCE = 3.0  # m that all robots drive between two updates of the building
OUTLINE_MARGIN = 0.3  # m from a room: cells of a frontier here belong to it, as outlines are straightened


@dataclass(eq=False)
class MapPerception:
    """Rooms are what a mapper reads from the map, every few metres."""

    mapper: Mapper
    _updated_at: float = field(init=False, default=-np.inf)
    _room_of_cell: NDArray[np.uint16] = field(init=False, default_factory=lambda: np.zeros((0, 0), np.uint16))

    def perceive(self, grid: GridMap, record: Record) -> Percept:
        """The rooms of the last update of the mapper, which is not older than UPDATE_DISTANCE."""
        if record.distance - self._updated_at >= UPDATE_DISTANCE:
            self._update(grid, record.distance)
        floor = self.mapper.floor
        if not floor.rooms:
            return Percept(None, np.zeros(grid.shape, np.uint16))
        return Percept(recognise_read_rooms(floor, record.list_positions()), self._room_of_cell)

    def _update(self, grid: GridMap, distance: float) -> None:
        self._updated_at = distance
        # A robot that has just started sees no room yet
        with suppress(MapError), warnings.catch_warnings():
            warnings.simplefilter("ignore", MapWarning)
            self.mapper.update(grid)
            reach = 2 * round(OUTLINE_MARGIN / grid.resolution) + 1
            image = self.mapper.floor.label_image(grid)
            around = np.asarray(cv2.dilate(image, np.ones((reach, reach), np.uint8)), np.uint16)
            self._room_of_cell = np.where(image > 0, image, around)


def recognise_read_rooms(floor: Floor, positions: Floats) -> RecognisedRooms:
    """The rooms of a reading of which enough was seen, or in which a robot was; doors to others are not open yet.

    positions: x, y of all robots until now, shape (N, 2).
    """
    entered = {room.id for room in floor if shapely.contains_xy(room.polygon, positions).any()}
    trusts = {room.id: measure_trust(room) for room in floor}
    is_recognised = {room: trust >= RECOGNISED_SHARE or room in entered for room, trust in trusts.items()}
    opened, unopened = [], []
    for number, door in enumerate(floor.doors):
        near = [room for room in door.room_ids if is_recognised[room]]
        if len(near) == 2:
            opened.append(door)
        elif near and door.joins_rooms:
            unopened.append((near[0], number))
    rooms = [room for room in floor if is_recognised[room.id]]

    def describe(room: Room) -> RecognisedRoom:
        return RecognisedRoom(room.id, room.label, room.polygon.area, trusts[room.id], room.id in entered)

    return RecognisedRooms(
        tuple(sorted(map(describe, rooms), key=lambda room: room.id)),
        Floor(tuple(rooms), tuple(opened), building_type=floor.building_type),
        tuple(unopened),
        tuple(floor.doors[number].line for _, number in unopened),
    )
