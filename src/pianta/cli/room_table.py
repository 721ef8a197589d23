"""The table of rooms that `pianta read` prints."""

from __future__ import annotations

from collections import Counter

from rich import box
from rich.console import JustifyMethod
from rich.markup import escape
from rich.table import Table

from pianta.floor import Floor, Room


def tabulate_rooms(floor: Floor) -> Table:
    """Table of the rooms: id, area, doors, neighbours; openings, entrances, name, label and partial when one has any.

    An entrance is counted as such only.
    """
    graph = floor.graph()
    kinds = Counter((room_id, door.kind) for door in floor.doors if not door.is_entrance for room_id in door.room_ids)
    columns = {
        "room": [str(room.id) for room in floor.rooms],
        "area m²": [f"{room.polygon.area:.1f}" for room in floor.rooms],
        "doors": [str(kinds[room.id, "door"]) for room in floor.rooms],
        "openings": [str(kinds[room.id, "opening"] or "") for room in floor.rooms],
        "entrances": [str(graph.nodes[room.id]["entrances"] or "") for room in floor.rooms],
        "neighbours": [" ".join(map(str, sorted(graph[room.id]))) for room in floor.rooms],
        "name": [escape(room.name or "") for room in floor.rooms],
        "label": [_describe_label(room) for room in floor.rooms],
        "seen": [_describe_sight(room) for room in floor.rooms],
    }
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    shown_columns = {name: cells for name, cells in columns.items() if any(cells)}
    for name in shown_columns:
        # Only what has several words becomes several lines on a narrow terminal.
        justify: JustifyMethod = "left" if name in ("neighbours", "name", "label", "seen") else "right"
        table.add_column(name, justify=justify, no_wrap=name not in ("neighbours", "name", "label"), overflow="fold")
    for cells in zip(*shown_columns.values(), strict=True):
        table.add_row(*cells)
    return table


def _describe_sight(room: Room) -> str:
    """In part, with the share of what is predicted of a partial room."""
    if room.predicted is None:
        return "in part" if room.partial else ""
    return f"in part, ~{100 * min(1.0, room.polygon.area / room.predicted.area):.0f} %"


def _describe_label(room: Room) -> str:
    """The label with its probability, where they are known."""
    probability = room.label_probability
    return (room.label or "") if probability is None else f"{room.label} {probability:.2f}"
