"""What `pianta read` prints of a reading: a table of its rooms, or a line for each storey."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from rich.table import Table

from pianta.cli.terminal import describe_floor, format_area, make_table, print_result, print_table
from pianta.floor import Floor, Room
from pianta.floor.area_trust import AreaTrust
from pianta.reading._labelling import describe_type
from pianta.reading.reading import Reading, StoreyReading

LABELS_LEFT_OUT = "labels: ROOM and CORRIDOR alone, where they are certain; --label-unknown shows the others"
# A prediction of which a larger share was seen adds nothing: about 100 %.
LARGEST_SHARE = 0.995


def print_storey(storey: StoreyReading, folder: Path, *, label_unknown: bool) -> None:
    """Print the rooms of a storey, the type of its building, its messages, and where the results are."""
    print_table(tabulate_rooms(storey.floor, storey.area_trust))
    if storey.area_trust is AreaTrust.UNKNOWN:
        print_result(storey.area_trust.note)
    if storey.candidate_types:
        print_result(f"building: {describe_type(storey.floor, storey.candidate_types)}")
        if not storey.floor.building_type and not label_unknown:
            print_result(LABELS_LEFT_OUT)
    for line in storey.messages:
        print_result(line)
    print_result(f"{describe_floor(storey.floor, storey.area_trust)}, in {folder}")


def list_storey_lines(reading: Reading) -> list[str]:
    """A line for each storey of one of several files."""
    lines = []
    for storey in reading.storeys:
        building_type = f", {_name_type(storey.floor)}" if storey.candidate_types else ""
        folder = (reading.folder or Path()) / storey.name
        described = f"{describe_floor(storey.floor, storey.area_trust)}{building_type}, in {folder}"
        lines.append("; ".join([described, *storey.messages]))
    return lines


def _name_type(floor: Floor) -> str:
    """The most probable type of a floor's building with its probability, in a few words."""
    types = floor.building_types
    return f"{types[0]} {floor.building_type[types[0]]:.2f}" if types else "unknown type"


def tabulate_rooms(floor: Floor, area_trust: AreaTrust = AreaTrust.EXACT) -> Table:
    """Table of the rooms: id, area, doors, neighbours, openings, entrances, number, name, flag, label, seen, sure.

    Those from openings on are columns if any room has them. area_trust: whether areas are marked, or left out.
    An entrance counts as an entrance only, not as a door or an opening.
    """
    graph = floor.graph()
    counts = Counter((room_id, door.kind) for door in floor.doors if not door.is_entrance for room_id in door.room_ids)
    columns = {
        "room": [str(room.id) for room in floor.rooms],
        "area m²": [format_area(room.polygon.area, area_trust) for room in floor.rooms],
        "doors": [str(counts[room.id, "door"]) for room in floor.rooms],
        "openings": [str(counts[room.id, "opening"] or "") for room in floor.rooms],
        "entrances": [str(graph.nodes[room.id]["entrances"] or "") for room in floor.rooms],
        "neighbours": [" ".join(map(str, sorted(graph[room.id]))) for room in floor.rooms],
        "number": [room.number or "" for room in floor.rooms],
        "name": [room.name or "" for room in floor.rooms],
        "flag": [room.flag or "" for room in floor.rooms],
        "label": [_describe_label(room) for room in floor.rooms],
        "seen": [_describe_observed_part(room) for room in floor.rooms],
        "sure": ["" if room.probability is None else f"{room.probability:.2f}" for room in floor.rooms],
    }
    wrapped = ("neighbours", "name", "label")
    return make_table(columns, left=(*wrapped, "seen"), wrapped=wrapped)


def _describe_observed_part(room: Room) -> str:
    """In part, with its share of a larger predicted room; empty if all of the room was observed."""
    share = 1.0 if room.predicted is None else room.polygon.area / room.predicted.area
    if share < LARGEST_SHARE:
        return f"in part, ~{100 * share:.0f} %"
    return "in part" if room.partial else ""


def _describe_label(room: Room) -> str:
    """The label with its probability, if these are known."""
    probability = room.label_probability
    return (room.label or "") if probability is None else f"{room.label} {probability:.2f}"
