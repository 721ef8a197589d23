"""The verb evacuate: ways out of a floor, rooms with one way out, times with queues, and what a shut door costs."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from pianta import __version__
from pianta.cli.json_output import Json, check_json, write_json
from pianta.cli.terminal import Quiet, make_table, print_result, print_table
from pianta.errors import OptionError, PiantaError
from pianta.io._files import count_noun, short_repr
from pianta.io._folders import atomic_folder, check_output_folder

if TYPE_CHECKING:
    from pianta.evacuation.evacuation import DoorUse, Evacuation, WayOut
    from pianta.floor import Floor

EXAMPLES = (
    "pianta evacuate school.xml -o evacuated",
    "pianta evacuate building/floor.geojson --exit 3 --exit 8",
    "pianta evacuate school.xml --shut 3-7 --people 12=40 --density CLASSROOM=0.6",
)
RESULT = "evacuation.json"
PICTURE = "picture.png"
# Doors that are printed, those that cost most if they are shut.
MAX_DOORS = 10
OUTSIDE = "out"

FloorFile = Annotated[
    Path, typer.Argument(metavar="FLOOR", help="A floor: a folder of `pianta read`, a floor.geojson or a building XML.")
]
Out = Annotated[Path | None, typer.Option("--out", "-o", help=f"Folder for {RESULT} and {PICTURE}.")]
Exit = Annotated[
    list[int] | None,
    typer.Option(
        "--exit",
        metavar="ROOM",
        help="People are out in this room, may be repeated. Unless given: the entrances, or rooms ENTRANCE and STAIRS.",
    ),
]
Shut = Annotated[
    list[str] | None,
    typer.Option(metavar="DOOR", help="A shut door: its number, or its rooms, 3-7 or 3-out; may be repeated."),
]
People = Annotated[list[str] | None, typer.Option(metavar="ROOM=NUMBER", help="People in a room, may be repeated.")]
Density = Annotated[
    list[str] | None,
    typer.Option(
        metavar="[LABEL=]NUMBER", help="People per m² of rooms with a label, or of all other rooms; may be repeated."
    ),
]


def evacuate_floor(
    floor: FloorFile,
    *,
    out: Out = None,
    exits: Exit = None,
    shut: Shut = None,
    people: People = None,
    density: Density = None,
    json_file: Json = None,
    quiet: Quiet = False,
) -> None:
    """Evacuate a floor: ways to the exits, rooms with one way out, and times with queues.

    Prints for each room the people in it, the metres to the nearest exit and
    the time until all are out, and for the doors what it costs if one is
    shut. With -o writes evacuation.json and picture.png.

    People follow from labels and areas, as building codes count them. This is
    an estimate for comparing floors and doors, not a certified simulation:
    all people start at once and walk the shortest way as healthy adults.
    """
    from pianta.evacuation.evacuate import evacuate

    quiet = check_json(json_file, quiet=quiet)
    if out is not None:
        check_output_folder(out)
    densities = _split_numbers(density or (), "--density", "CLASSROOM=0.5, or 0.1 for all other rooms")
    try:
        evacuation = evacuate(
            _read_floor(floor),
            exits=exits or None,
            shut=[_parse_door(name) for name in shut or ()],
            people={
                _parse_whole(room, "--people"): _parse_whole(count, "--people")
                for room, count in _split_pairs(people or ())
            },
            densities={label: value for label, value in densities if label},
            density=next((value for label, value in reversed(densities) if not label), None),
        )
    except PiantaError as error:
        raise type(error)(f"floor {short_repr(floor)}: {error}") from error
    if out is not None:
        _save(evacuation, out)
    write_json(evacuation.as_json(), json_file)
    if not quiet:
        _print_evacuation(evacuation)
        if out is not None:
            print_result(f"in {out}: {RESULT}, {PICTURE}")


def _read_floor(path: Path) -> Floor:
    from pianta.io.buildings.read import read_building
    from pianta.io.graphs import FLOOR_FILE

    return read_building(path / FLOOR_FILE if path.is_dir() else path)


def _parse_door(name: str) -> int | tuple[int, int | None]:
    """A door by its number, or by its two rooms, of which one may be the outside."""
    ends = name.split("-")
    numbers = [None if end == OUTSIDE else _parse_whole(end, "--shut") for end in ends]
    first = numbers[0]
    if len(numbers) == 1 and first is not None:
        return first
    rooms = [number for number in numbers if number is not None]
    if len(numbers) != 2 or not rooms:
        raise OptionError(f"--shut is {short_repr(name)}, give the number of a door, or its rooms, 3-7 or 3-{OUTSIDE}")
    return (rooms[0], rooms[1] if len(rooms) == 2 else None)


def _split_pairs(texts: Sequence[str]) -> list[tuple[str, str]]:
    pairs = [text.partition("=") for text in texts]
    for text, (_, equals, _) in zip(texts, pairs, strict=True):
        if not equals:
            raise OptionError(f"--people is {short_repr(text)}, give a room and a number, 12=40")
    return [(room, count) for room, _, count in pairs]


def _split_numbers(texts: Sequence[str], flag: str, example: str) -> list[tuple[str, float]]:
    """Labels, empty for all, and their numbers."""
    values = []
    for text in texts:
        label, _, number = text.rpartition("=")
        try:
            values.append((label, float(number)))
        except ValueError:
            raise OptionError(f"{flag} is {short_repr(text)}, give {example}") from None
    return values


def _parse_whole(text: str, flag: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise OptionError(f"{flag} has {short_repr(text)}, give a whole number") from None


def _save(evacuation: Evacuation, out: Path) -> None:
    from pianta.plot.evacuation import draw_evacuation
    from pianta.plot.figure import save_figure

    with atomic_folder(out) as new:
        content = {"pianta": __version__, **evacuation.as_json()}
        text = json.dumps(content, indent=1, allow_nan=False, ensure_ascii=False) + "\n"
        (new / RESULT).write_text(text, encoding="utf-8")
        save_figure(draw_evacuation(evacuation), new / PICTURE)


def _print_evacuation(evacuation: Evacuation) -> None:
    """Print the summary, the table of rooms and that of doors."""
    rooms, longest = len(evacuation.floor), evacuation.longest
    print_result(f"{count_noun(rooms, 'room')}, {evacuation.people} people, exits: {_describe_exits(evacuation)}")
    queues = f"without queues {_describe_time(evacuation.time_without_queues)}"
    print_result(f"all out after {_describe_time(evacuation.time)}, {queues}")
    print_result(f"longest way {longest.longest:.1f} m, from room {longest.room}")
    dead_ends = f"{len(evacuation.dead_ends)} of them dead ends (behind their own door there is still one way)"
    print_result(f"one way out: {len(evacuation.one_way)} of {rooms} rooms, {dead_ends}")
    print_table(tabulate_ways(evacuation))
    print_result("shared doors: on every way out of the room; dead end: from the farthest point until ways divide")
    print_table(tabulate_doors(evacuation.rank_doors()[:MAX_DOORS], evacuation.people))


def _describe_exits(evacuation: Evacuation) -> str:
    if evacuation.exit_doors:
        return count_noun(len(evacuation.exit_doors), "entrance")
    return f"rooms {', '.join(map(str, evacuation.exit_rooms))}"


def _describe_time(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest} s" if minutes else f"{rest} s"


def tabulate_ways(evacuation: Evacuation) -> Table:
    """Table of the rooms: people, metres to an exit from the middle and the farthest point, time, and ways out."""
    labels = {room.id: room.label or "" for room in evacuation.floor.rooms}
    ways = evacuation.ways
    has_way = [way.room not in evacuation.cut_off for way in ways]
    columns = {
        "room": [str(way.room) for way in ways],
        "label": [labels[way.room] for way in ways],
        "people": [str(way.people) for way in ways],
        "middle\nm": [f"{way.distance:.1f}" if ok else "" for way, ok in zip(ways, has_way, strict=True)],
        "farthest\nm": [f"{way.longest:.1f}" if ok else "" for way, ok in zip(ways, has_way, strict=True)],
        "out\nafter\ns": ["" if way.time is None else f"{way.time:.0f}" for way in ways],
        "ways\nout": [_describe_ways(evacuation, way) for way in ways],
        "shared\ndoors": [" ".join(map(str, way.shared_doors)) for way in ways],
        "dead\nend m": ["" if way.dead_end is None else f"{way.dead_end:.1f}" for way in ways],
    }
    return make_table(columns, left=("label", "ways\nout"), wrapped=("label", "shared\ndoors"))


def _describe_ways(evacuation: Evacuation, way: WayOut) -> str:
    if way.room in evacuation.exit_rooms:
        return "exit"
    if way.room in evacuation.cut_off:
        return "none"
    return "one" if way.has_one_way else "several"


def tabulate_doors(doors: Sequence[DoorUse], people: int) -> Table:
    """Table of doors: who passes, and rooms and people cut off and time of the others if one is shut.

    people: on the floor; where a door cuts off all of them, the last column has no time.
    """
    columns = {
        "door": [str(door.number) for door in doors],
        "rooms": ["-".join(OUTSIDE if room is None else str(room) for room in door.rooms) for door in doors],
        "people": [str(door.people) for door in doors],
        "waiting s": [f"{door.wait:.0f}" for door in doors],
        "if shut: rooms cut off": [str(len(door.cut_off)) for door in doors],
        "people cut off": [str(door.people_cut_off) for door in doors],
        "others out after s": ["–" if door.people_cut_off == people else f"{door.time_if_shut:.0f}" for door in doors],
    }
    return make_table(columns, left=("rooms",), wrapped=("if shut: rooms cut off", "others out after s"))
