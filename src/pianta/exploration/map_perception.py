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
from pianta.errors import MapError, MapWarning, OptionError
from pianta.exploration.perception import Percept, WantedRoom
from pianta.exploration.recognised_rooms import RECOGNISED_SHARE, RecognisedRoom, RecognisedRooms
from pianta.exploration.record import Record
from pianta.exploration.starts import standard_label
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.labels import FCES, RC, SCHEMAS, LabelSet
from pianta.mapping.beliefs import measure_trust
from pianta.mapping.mapper import Mapper
from pianta.rooms.model_file import read_default_room_model

# All chosen by hand.
UPDATE_DISTANCE = 3.0  # m that all robots drive between two updates of the building
FOUND_PROBABILITY = 0.5  # of the wanted label, at which a search ends: at least as probable as all others together
LEAST_PROBABILITY = 0.01  # of the wanted label in a room that is named; less is as good as ruled out
OUTLINE_MARGIN = 0.3  # m from a room: cells of a frontier here belong to it, as outlines are straightened


@dataclass(eq=False)
class MapPerception:
    """Rooms are what a mapper reads from the map, every few metres. true_floor: to compare with; None without one."""

    mapper: Mapper
    true_floor: Floor | None = None
    _updated_at: float = field(init=False, default=-np.inf)
    _room_of_cell: NDArray[np.uint16] = field(init=False, default_factory=lambda: np.zeros((0, 0), np.uint16))
    _recognised: RecognisedRooms | None = field(init=False, default=None)

    def check_label(self, label: str) -> None:
        """Raise OptionError for a label that the mapper gives to no room."""
        if not self.mapper.labels:
            raise OptionError(f"the mapper gives no room the label {label}, leave out labels=False")
        schemas = (self.mapper.room_model or read_default_room_model()).schemas
        chosen_types = [self.mapper.building_type] if self.mapper.building_type in schemas else [*schemas]
        names = {name for building_type in chosen_types for name in schemas[str(building_type)].by_name}
        if label not in names | {*map(str, RC), *map(str, FCES)}:
            possible = ", ".join(sorted(names))
            raise OptionError(f"rooms that are read from a map are never labelled {label}, give one of {possible}")

    def find_room(self, label: str, record: Record) -> WantedRoom | None:  # noqa: ARG002
        """A room that the mapper labels so with a probability of a half, as of the last call of `perceive`.

        A label of R/C or F/C/E/S is that of a room with a finer one too.
        """
        for recognised in self._recognised.rooms if self._recognised else ():
            room = self.mapper.floor[recognised.id]
            if room.label is None or label not in map(standard_label, (room.label, *room.labels.values())):
                continue
            probability = measure_label_probability(room, label)
            if probability >= FOUND_PROBABILITY:
                return WantedRoom(room.id, label, self._is_right(room.id, label), probability)
        return None

    def find_likeliest_room(self, label: str, grid: GridMap) -> WantedRoom | None:
        """The likeliest room of the whole map, read to the end; None if the label is hardly probable anywhere."""
        with suppress(MapError), warnings.catch_warnings():
            warnings.simplefilter("ignore", MapWarning)
            self.mapper.update(grid)
            self.mapper.finish()
        probability, best = choose_likeliest_room(self.mapper.floor, label)
        if best is None or probability < LEAST_PROBABILITY:
            return None
        return WantedRoom(best, label, self._is_right(best, label), probability)

    def _is_right(self, room: int, label: str) -> bool | None:
        """Whether the true room that a read one overlaps most has the label; None if its own is missing or coarser.

        A label of R/C or F/C/E/S is compared with what the true label is in that set.
        """
        if self.true_floor is None:
            return None
        polygon = self.mapper.floor[room].polygon
        overlaps = [(polygon.intersection(true.polygon).area, standard_label(true.label)) for true in self.true_floor]
        area, true_label = max(overlaps, key=lambda overlap: overlap[0], default=(0.0, None))
        if not area or true_label == label:
            return area > 0
        if true_label is None or (true_label == RC.ROOM and label not in [*RC]):
            return None
        label_set = LabelSet.R_C if label in [*RC] else LabelSet.F_C_E_S if label in [*FCES] else None
        if label_set is None:
            return False
        schemas = [SCHEMAS[name] for name in self.true_floor.building_types if name in SCHEMAS] or [*SCHEMAS.values()]
        schema = next((each for each in schemas if true_label in each.by_name), None)
        return None if schema is None else label in map(str, schema.map_labels([true_label], label_set))

    def perceive(self, grid: GridMap, record: Record) -> Percept:
        """The rooms of the last update of the mapper, which is not older than UPDATE_DISTANCE."""
        if record.distance - self._updated_at >= UPDATE_DISTANCE:
            self._update(grid, record.distance)
        floor = self.mapper.floor
        if not floor.rooms:
            return Percept(None, np.zeros(grid.shape, np.uint16))
        self._recognised = recognise_read_rooms(floor, record.list_positions())
        return Percept(self._recognised, self._room_of_cell)

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


def measure_label_probability(room: Room, label: str) -> float:
    """The belief that a room has a label in standard form, by the finest label set with it; 1 for a label alone."""
    for probabilities in reversed([*room.label_probabilities.values()]):
        names = {standard_label(str(name)): probability for name, probability in probabilities.items()}
        if label in names:
            return names[label]
    return float(not room.label_probabilities and standard_label(room.label) == label)


def choose_likeliest_room(floor: Floor, label: str) -> tuple[float, int | None]:
    """The highest probability of a label in standard form, and the id of its room; None without rooms."""
    rooms = ((measure_label_probability(room, label), room.id) for room in floor)
    return max(rooms, key=lambda room: room[0], default=(0.0, None))


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
