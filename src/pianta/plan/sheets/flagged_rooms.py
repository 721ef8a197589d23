"""Rooms of a sheet that people may not count: balconies, gardens and courtyards, by their names or their size."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pianta.floor import BALCONY_FLAG, OUTSIDE_FLAG, Floor, Room
from pianta.io.drawings._flags_by_name import find_flag_in_name, names_garden


@dataclass(frozen=True, kw_only=True)
class FlagParameters:
    """Thresholds of `flag_rooms`.

    Chosen on the plans of `floorplans`: none of the six unnamed areas without a door there that are larger is a room,
    and the largest of the others that is one has 9.1 times the median.
    """

    outside_size: float = 9.5  # times the median area of the rooms of a floor
    min_doors: int = 3  # drawn on a floor, so that a room without one is no usual room


PARAMETERS = FlagParameters()


def flag_rooms(floor: Floor) -> Floor:
    """The floor whose rooms have a flag if they are outside by their name, or very large and without name and door.

    A balcony or terrace may be upstairs, so that it is no way out: its flag is "balcony".
    """
    doors = [door for door in floor.doors if door.kind == "door"]
    reached = {room for door in doors for room in door.room_ids}
    largest = PARAMETERS.outside_size * float(np.median([room.polygon.area for room in floor]))

    def find_flag(room: Room) -> str | None:
        if room.name:
            flag = find_flag_in_name(room.name)
            return BALCONY_FLAG if flag == OUTSIDE_FLAG and not names_garden(room.name) else flag
        is_shut = len(doors) >= PARAMETERS.min_doors and room.id not in reached
        return OUTSIDE_FLAG if not room.number and is_shut and room.polygon.area > largest else None

    return replace(floor, rooms=tuple(replace(room, flag=room.flag or find_flag(room)) for room in floor))
