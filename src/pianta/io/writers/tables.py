"""Tables of rooms: CSV, and Excel with doors and totals."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

from pianta.building import Building, Storey
from pianta.floor import Room
from pianta.io.writers._formats import WriteOptions

COLUMNS = (
    *("id", "number", "name", "label", "probability", "area_m2", "perimeter_m", "doors", "storey", "neighbours"),
)


def write_csv(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """A row for each room; the fields of a cell with several values are separated by blanks."""
    with target.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(COLUMNS)
        writer.writerows(list_room_rows(building))
    return []


def list_room_rows(building: Building) -> Iterator[list[object]]:
    """The values of the columns, room by room."""
    for storey, room in building.list_rooms():
        yield _make_row(storey, room)


def _make_row(storey: Storey, room: Room) -> list[object]:
    doors = [door for door in storey.floor.doors if room.id in door.room_ids]
    neighbours = sorted({other for door in doors for other in door.room_ids} - {room.id})
    return [
        room.id,
        None,
        room.name,
        room.label,
        room.label_probability,
        round(room.polygon.area, 2),
        round(room.polygon.length, 2),
        len(doors),
        storey.name or None,
        " ".join(map(str, neighbours)),
    ]
