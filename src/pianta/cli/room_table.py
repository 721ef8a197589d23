"""The table of rooms that `pianta read` prints."""

from __future__ import annotations

from collections import Counter

from rich.table import Table

from pianta.cli.terminal import make_table
from pianta.floor import Floor, Room


def tabulate_rooms(floor: Floor) -> Table:
    """Table of the rooms: id, area, doors, neighbours; openings, entrances, name, label and seen part if any has.

    An entrance counts as an entrance only, not as a door or an opening.
    """
    graph = floor.graph()
    counts = Counter((room_id, door.kind) for door in floor.doors if not door.is_entrance for room_id in door.room_ids)
    columns = {
        "room": [str(room.id) for room in floor.rooms],
        "area m²": [f"{room.polygon.area:.1f}" for room in floor.rooms],
        "doors": [str(counts[room.id, "door"]) for room in floor.rooms],
        "openings": [str(counts[room.id, "opening"] or "") for room in floor.rooms],
        "entrances": [str(graph.nodes[room.id]["entrances"] or "") for room in floor.rooms],
        "neighbours": [" ".join(map(str, sorted(graph[room.id]))) for room in floor.rooms],
        "name": [room.name or "" for room in floor.rooms],
        "label": [_describe_label(room) for room in floor.rooms],
        "seen": [_describe_observed_part(room) for room in floor.rooms],
    }
    wrapped = ("neighbours", "name", "label")
    return make_table(columns, left=(*wrapped, "seen"), wrapped=wrapped)


def _describe_observed_part(room: Room) -> str:
    """In part, with its share of the predicted room; empty if all of the room was observed."""
    if room.predicted is None:
        return "in part" if room.partial else ""
    return f"in part, ~{100 * min(1.0, room.polygon.area / room.predicted.area):.0f} %"


def _describe_label(room: Room) -> str:
    """The label with its probability, if these are known."""
    probability = room.label_probability
    return (room.label or "") if probability is None else f"{room.label} {probability:.2f}"
