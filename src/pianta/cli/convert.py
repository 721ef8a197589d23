"""The verb convert: give a floor to other programs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from pianta.cli.terminal import Quiet, print_result
from pianta.errors import OptionError
from pianta.io._files import short_repr
from pianta.io._folders import check_output_file, check_output_folder
from pianta.io.georeference import read_georeference
from pianta.io.writers._formats import FORMATS, WriteOptions
from pianta.io.writers.convert import check_options, convert, find_format, find_format_name

EXAMPLES = (
    "pianta convert building --to csv",
    "pianta convert building -o rooms.xlsx",
    "pianta convert building --to gpkg --georeference anchor.yaml",
    "pianta convert building --to map-card --robot-map map.json",
)

Out = Annotated[
    Path, typer.Argument(metavar="OUT", help="A folder that `pianta read` has written, or a floor.geojson.")
]
To = Annotated[
    str | None,
    typer.Option("--to", metavar="FORMAT", help=f"One of {', '.join(FORMATS)}; by the suffix of --out unless given."),
]
Target = Annotated[Path | None, typer.Option("--out", "-o", help="The file or folder to write; in OUT unless given.")]
RobotRadius = Annotated[float | None, typer.Option(metavar="M", help="Radius of the robot, metres; 0.22 unless given.")]
Rooms = Annotated[list[str] | None, typer.Option("--rooms", metavar="ROOM", help="Id, name or label; may be repeated.")]
Speed = Annotated[float | None, typer.Option(metavar="PERCENT", help="Of a speed mask; 50 unless given.")]
RobotMap = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Valetudo's map JSON of the robot, whose ids rooms get.")
]
Straight = Annotated[bool, typer.Option("--straight", help="Right angles where the building has them.")]
GeoreferenceFile = Annotated[
    Path | None,
    typer.Option("--georeference", metavar="FILE", help="Control points or an anchor on the earth, YAML or JSON."),
]


def convert_floor(
    out: Out,
    *,
    to: To = None,
    target: Target = None,
    robot_radius: RobotRadius = None,
    rooms: Rooms = None,
    speed: Speed = None,
    straight: Straight = False,
    georeference: GeoreferenceFile = None,
    robot_map: RobotMap = None,
    quiet: Quiet = False,
) -> None:
    """Write a floor or a building in a format of other programs.

    What a format cannot hold is named, a line each.
    """
    if to is None:
        if target is None:
            raise OptionError("no format, give --to FORMAT")
        to = find_format_name(target)
    chosen = find_format(to)
    reference = read_georeference(georeference) if georeference else None
    values: dict[str, Any] = {
        "robot_radius": robot_radius,
        "speed": speed,
        "robot_map": robot_map,
        "rooms": rooms and tuple(rooms),
        "straight": straight or None,
        "georeference": reference,
    }
    options = {name: value for name, value in values.items() if value is not None}
    check_options(to, WriteOptions(**options))
    path = target or (out if out.is_dir() else out.parent) / chosen.file
    if str(path) == "-":
        raise OptionError("output is -, and convert does not write to stdout; give the name of a file")
    if chosen.is_folder:
        check_output_folder(path)
    else:
        check_output_file(path, "output")
        if not path.parent.exists():
            raise OptionError(f"output {short_repr(path)}: folder {short_repr(path.parent)} does not exist, create it")
    notes = convert(out, path, to=to, **options)
    if not quiet:
        if reference:
            print_result(reference.describe())
        for note in notes:
            print_result(note)
        print_result(f"{chosen.title}, in {path}")
