"""The rooms that robots have recognised, with their labels and their doors that are not open yet.

Section 8.3 of the thesis assumes correct labels of explored rooms; here they come from the true floor.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from shapely import LineString

from pianta.exploration.world import World
from pianta.floor import Floor
from pianta.gridmap import FREE

# A room is recognised when this share of its cells is mapped as free. Chosen by hand; not in the thesis.
RECOGNISED_SHARE = 0.2
# A door is recognised when this share of the cells of its passage is mapped as free. Chosen by hand.
RECOGNISED_DOOR_SHARE = 0.5


@dataclass(frozen=True)
class RecognisedRoom:
    """A recognised room.

    area: of its observed part, m². share: of its free cells that are observed, 0 … 1; a robot cannot know it.
    entered: a robot was inside.
    """

    id: int
    label: str | None
    area: float
    share: float
    entered: bool


@dataclass(frozen=True)
class RecognisedRooms:
    """The recognised rooms, and the doors that lead on from them.

    rooms: ordered by id.
    floor: these rooms with their true polygons and labels, and the recognised doors between them.
    unopened: (room, index of the door in the true floor) for each recognised door to a room that is not recognised.
    unopened_lines: the lines of these doors.
    """

    rooms: tuple[RecognisedRoom, ...]
    floor: Floor
    unopened: tuple[tuple[int, int], ...]
    unopened_lines: tuple[LineString, ...] = ()


def recognise_rooms(
    world: World,
    cells: NDArray[np.int8],
    *,
    counts: NDArray[np.int_] | None = None,
    entered: Collection[int] = (),
    threshold: float = RECOGNISED_SHARE,
) -> RecognisedRooms | None:
    """Find the recognised rooms on a map, shape (H, W), in the frame of the world; None if the world has no floor.

    counts: free cells of each room on the map, by its id; None to count them. entered: ids of rooms in which a robot
    was; they are recognised in any case. threshold: the share of a room that must be free.
    """
    if world.floor is None:
        return None
    if counts is None:
        counts = np.bincount(world.room_of_cell[cells == FREE], minlength=len(world.room_cells))
    shares = counts / np.maximum(world.room_cells, 1)
    recognised = [room for room in world.floor.rooms if shares[room.id] >= threshold or room.id in entered]
    ids = {room.id for room in recognised}
    opened, unopened = [], []
    for number, (door, passage) in enumerate(zip(world.floor.doors, world.door_cells, strict=True)):
        near = [room for room in door.room_ids if room in ids]
        if not door.joins_rooms or not near or _measure_free_share(cells, passage) < RECOGNISED_DOOR_SHARE:
            continue
        if len(near) == 2:
            opened.append(door)
        else:
            unopened.append((near[0], number))
    rooms = [
        RecognisedRoom(
            room.id,
            room.label,
            float(counts[room.id]) * world.resolution**2,
            float(shares[room.id]),
            room.id in entered,
        )
        for room in recognised
    ]
    return RecognisedRooms(
        tuple(sorted(rooms, key=lambda room: room.id)),
        replace(world.floor, rooms=tuple(recognised), doors=tuple(opened), walls=()),
        tuple(unopened),
        tuple(world.floor.doors[number].line for _, number in unopened),
    )


def _measure_free_share(cells: NDArray[np.int8], passage: NDArray[np.int_]) -> float:
    """Share of the cells of a door's passage that are mapped as free, 0 … 1; 1 for a passage without cells.

    cells: of the map, shape (H, W). passage: row and col of its cells, shape (N, 2).
    """
    return float((cells[passage[:, 0], passage[:, 1]] == FREE).mean()) if len(passage) else 1.0
