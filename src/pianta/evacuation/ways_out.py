"""Which doors and rooms all ways out share: what shutting one of them cuts off."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from pianta.evacuation.exits import Exits
from pianta.floor import Floor
from pianta.graphs.components import number_components


def find_cut_off(
    floor: Floor, exits: Exits, *, shut_doors: Collection[int] = (), shut_rooms: Collection[int] = ()
) -> frozenset[int]:
    """Ids of the rooms from which no door leads on to an exit; shut rooms are not among them.

    shut_doors: indices of doors. shut_rooms: ids of rooms that cannot be passed.
    """
    index = {room.id: number for number, room in enumerate(floor.rooms, start=1)}
    # Node 0 is the outside; exit rooms are part of it.
    index |= dict.fromkeys(exits.rooms, 0)
    pairs = []
    for number, door in enumerate(floor.doors):
        is_exit = number in exits.doors
        if number in shut_doors or {*shut_rooms} & {*door.room_ids} or (not door.joins_rooms and not is_exit):
            continue
        first, second = door.rooms
        pairs.append((index[first], 0 if second is None else index[second]))
    parts = number_components(np.array(pairs, int).reshape(-1, 2), len(floor.rooms) + 1)
    return frozenset(room for room, node in index.items() if parts[node] != parts[0] and room not in shut_rooms)


def find_shared_doors(floor: Floor, exits: Exits, shut: Collection[int] = ()) -> dict[int, frozenset[int]]:
    """For each door by its index the rooms that lose their way out without it."""
    before = find_cut_off(floor, exits, shut_doors=shut)
    doors = [index for index in range(len(floor.doors)) if index not in shut]
    return {door: find_cut_off(floor, exits, shut_doors={*shut, door}) - before for door in doors}


def find_shared_rooms(floor: Floor, exits: Exits, shut: Collection[int] = ()) -> dict[int, frozenset[int]]:
    """For each room by its id the other rooms that lose their way out without it."""
    before = find_cut_off(floor, exits, shut_doors=shut)
    rooms = [room.id for room in floor.rooms if room.id not in exits.rooms]
    return {room: find_cut_off(floor, exits, shut_doors=shut, shut_rooms={room}) - before for room in rooms}
