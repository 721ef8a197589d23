"""What verbs print as tables, as JSON: in a file, or on stdout, which then has nothing else."""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from pianta import __version__
from pianta.batch.journal import is_reserved
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_output_file
from pianta.reading.reading import OUTPUTS, Reading, StoreyReading

Json = Annotated[
    Path | None,
    typer.Option("--json", metavar="FILE", help="File for all results, JSON; - is stdout, without the tables."),
]
# The name of stdout.
STDOUT = Path("-")
HEAD_BYTES = 64  # of a file, in which ours name pianta
DIGITS = 4  # of metres and square metres


def check_json(file: Path | None, *, quiet: bool) -> bool:
    """Refuse a file that cannot be written, before any work; whether nothing else is printed.

    Raises OptionError, also for the name of a result or of a journal.
    """
    if file is not None and file != STDOUT:
        check_output_file(file, "JSON file")
        if file.name in OUTPUTS or is_reserved(file.name):
            raise OptionError(f"JSON file {short_repr(file)} has the name of another result, give another name")
        if file.is_file() and not _is_own(file):
            raise OptionError(
                f"JSON file {short_repr(file)} is there and not of pianta, give another name or remove it"
            )
    return quiet or file == STDOUT


def _is_own(file: Path) -> bool:
    """Whether a file is empty, or was written by `write_json`; a map, for one, would be lost."""
    with file.open("rb") as opened:
        head = opened.read(HEAD_BYTES)
    return not head.strip() or (head.lstrip().startswith(b"{") and b'"pianta"' in head)


def write_json(content: Mapping[str, Any], file: Path | None) -> None:
    """Write an object with the version of pianta into a file, or on stdout; nothing without a file."""
    if file is None:
        return
    text = json.dumps({"pianta": __version__, **content}, indent=1, allow_nan=False, ensure_ascii=file == STDOUT) + "\n"
    if file == STDOUT:
        sys.stdout.write(text)
        sys.stdout.flush()
        return
    with atomic_folder(file.parent) as new:
        (new / file.name).write_text(text, encoding="utf-8")


def describe_readings(readings: Sequence[tuple[Reading, Path]]) -> dict[str, Any]:
    """The rooms and doors of files, each with the folder of its results."""
    return {
        "files": [
            {"file": str(reading.path), "storeys": [_describe_storey(storey, out) for storey in reading.storeys]}
            for reading, out in readings
        ]
    }


def _describe_storey(storey: StoreyReading, out: Path) -> dict[str, Any]:
    floor = storey.floor
    return {
        "folder": str(out / storey.name),
        "name": storey.name,
        "title": storey.title,
        "elevation": storey.elevation,
        "global_id": floor.global_id,
        "building_type": dict(floor.building_type),
        "area": round(sum(room.polygon.area for room in floor), DIGITS),
        "scale": storey.scale and storey.scale.as_json(),
        "messages": [*storey.messages],
        "rooms": _list_rooms(floor),
        "doors": [
            {
                "rooms": [*door.rooms],
                "kind": door.kind,
                "width": round(door.width, DIGITS),
                "probability": door.probability,
                "leads_out": door.is_entrance,
                "global_id": door.global_id,
            }
            for door in floor.doors
        ],
    }


def _list_rooms(floor: Floor) -> list[dict[str, Any]]:
    """A row for each room: its values in the graph, and the numbers of its doors."""
    graph = floor.graph()
    counts = Counter((room_id, door.kind) for door in floor.doors if not door.is_entrance for room_id in door.room_ids)
    return [
        {
            "id": room.id,
            "number": room.number,
            "name": room.name,
            "flag": room.flag,
            "global_id": room.global_id,
            "label": room.label,
            "label_probability": room.label_probability,
            "probability": room.probability,
            "area": round(room.polygon.area, DIGITS),
            "perimeter": round(room.polygon.length, DIGITS),
            "doors": counts[room.id, "door"],
            "openings": counts[room.id, "opening"],
            "entrances": graph.nodes[room.id]["entrances"],
            "neighbours": sorted(graph[room.id]),
            "partial": room.partial,
            "predicted_area": room.predicted and round(room.predicted.area, DIGITS),
            "confidence": room.confidence,
        }
        for room in floor
    ]
