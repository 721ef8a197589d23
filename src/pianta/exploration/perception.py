"""What a robot has understood of the rooms that it saw: those, their labels, and the doors that nobody has opened.

Section 8.3 of the thesis assumes that what was explored is labelled correctly; so it is here, by the true floor.
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

# A room is recognised when this share of it has been seen.
SEEN_SHARE = 0.2
# A door is seen when this share of its passage is known to be free.
DOOR_SHARE = 0.5


@dataclass(frozen=True)
class SeenRoom:
    """A room that was recognised.

    area: what was seen of it, m². share: that of its free cells, 0 … 1, which a robot cannot know. entered: a robot was
    inside.
    """

    id: int
    label: str | None
    area: float
    share: float
    entered: bool


@dataclass(frozen=True)
class Perception:
    """The rooms that were recognised, and what leads on from them.

    rooms: ordered by id.
    floor: those rooms with their true polygons and labels, and the doors seen between them.
    unopened: (room, number of the door in the true floor) for each door seen that leads from one of the rooms to one
        that was not recognised; what that is remains unsaid. unopened_lines: where these doors are.
    """

    rooms: tuple[SeenRoom, ...]
    floor: Floor
    unopened: tuple[tuple[int, int], ...]
    unopened_lines: tuple[LineString, ...] = ()


def perceive_rooms(
    world: World, known: NDArray[np.int8], *, entered: Collection[int] = (), threshold: float = SEEN_SHARE
) -> Perception | None:
    """What is understood from a map, shape (H, W), in the frame of the world; None where the world has no floor.

    entered: ids of rooms that robots have been in; they are recognised in any case.
    threshold: the share of a room that must be known to be free.
    """
    counts = np.bincount(world.room_of_cell[known == FREE], minlength=len(world.room_cells))
    return perceive_counts(world, known, counts, entered=entered, threshold=threshold)


def perceive_counts(
    world: World,
    known: NDArray[np.int8],
    counts: NDArray[np.int_],
    *,
    entered: Collection[int] = (),
    threshold: float = SEEN_SHARE,
) -> Perception | None:
    """The same from how many cells of each room are known to be free, by its id."""
    if world.floor is None:
        return None
    shares = counts / np.maximum(world.room_cells, 1)
    here = [room for room in world.floor.rooms if shares[room.id] >= threshold or room.id in entered]
    ids = {room.id for room in here}
    opened, unopened = [], []
    for number, (door, cells) in enumerate(zip(world.floor.doors, world.door_cells, strict=True)):
        seen = [room for room in door.room_ids if room in ids]
        if door.is_entrance or not seen or _share_of_free(known, cells) < DOOR_SHARE:
            continue
        if len(seen) == 2:
            opened.append(door)
        else:
            unopened.append((seen[0], number))
    rooms = (
        SeenRoom(
            room.id,
            room.label,
            float(counts[room.id]) * world.resolution**2,
            float(shares[room.id]),
            room.id in entered,
        )
        for room in here
    )
    floor = replace(world.floor, rooms=tuple(here), doors=tuple(opened), walls=())
    lines = tuple(world.floor.doors[number].line for _, number in unopened)
    return Perception(tuple(sorted(rooms, key=lambda room: room.id)), floor, tuple(unopened), lines)


def _share_of_free(known: NDArray[np.int8], cells: NDArray[np.int_]) -> float:
    return float((known[cells[:, 0], cells[:, 1]] == FREE).mean()) if len(cells) else 1.0
