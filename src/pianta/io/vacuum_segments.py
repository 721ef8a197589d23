"""The rooms of a floor as segments of a robot vacuum: which are which, and the names that the robot has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pianta.floor import Floor
from pianta.io.valetudo import VacuumMap, list_pixels

# A room and a segment are the same if each has more than this share of the other; so one segment cannot be two rooms.
SAME_SHARE = 0.5


def match_segments(floor: Floor, robot: VacuumMap) -> dict[int, str]:
    """The id of the robot's segment that each room is; other rooms are left out."""
    labels = floor.label_image(robot.grid)
    counts = dict(zip(*np.unique(labels, return_counts=True), strict=True))
    numbers: dict[int, str] = {}
    for segment in robot.segments:
        inside = labels[list_pixels(segment.runs - (*robot.corner, 0))]
        rooms, shared = np.unique(inside[inside > 0], return_counts=True)
        if not len(rooms):
            continue
        room, common = int(rooms[shared.argmax()]), int(shared.max())
        if common > SAME_SHARE * len(inside) and common > SAME_SHARE * counts[room]:
            numbers[room] = segment.id
    return numbers


def name_rooms(floor: Floor, robot: VacuumMap) -> Floor:
    """The floor with the names of the robot's segments, where a room has none."""
    names = {segment.id: segment.name for segment in robot.segments}
    numbers = match_segments(floor, robot)
    rooms = (replace(room, name=room.name or names.get(numbers.get(room.id, ""))) for room in floor)
    return replace(floor, rooms=tuple(rooms))
