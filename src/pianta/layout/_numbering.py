"""The last step of every layout method: the ids of rooms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import shapely
from shapely import LineString

from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap


def assemble_floor(
    rooms: Sequence[Room],
    doors: Sequence[Door],
    walls: Sequence[LineString],
    grid: GridMap,
    *,
    possible_doors: Sequence[Door] = (),
) -> Floor:
    """Floor with rooms renumbered in reading order of the map image: rows of 1 m from the top, then columns."""

    def corner(room: Room) -> tuple[int, float]:
        rows, cols = grid.map_to_pixel(*shapely.get_coordinates(room.polygon).T)
        return round(float(rows.min()) * grid.resolution), float(cols.min())

    ordered = sorted(rooms, key=corner)
    new_id = {room.id: i for i, room in enumerate(ordered, start=1)}

    def renumber(doors: Sequence[Door]) -> tuple[Door, ...]:
        renumbered = [door.renumber_rooms(new_id) for door in doors]
        return tuple(sorted(renumbered, key=lambda door: (door.room_ids, door.line.coords[0])))

    return Floor(
        rooms=tuple(replace(room, id=new_id[room.id]) for room in ordered),
        doors=renumber(doors),
        walls=tuple(walls),
        source=grid.source,
        possible_doors=renumber(possible_doors),
    )
