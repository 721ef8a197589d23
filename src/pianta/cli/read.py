"""The verb read: the building of a map or a plan, or of several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from pianta.batch.inputs import is_collection
from pianta.batch.read_batch import read_batch
from pianta.batch.run_batch import BatchItem
from pianta.building import Link, Storey
from pianta.cli.batches import (
    BatchFlags,
    BatchWords,
    Jobs,
    Resume,
    RetryFailed,
    Scheduler,
    Shard,
    TimeLimit,
    exit_if_any_failed,
    refuse_batch,
    run_batch,
)
from pianta.cli.json_output import Json, check_json, describe_readings, write_json
from pianta.cli.reading_text import list_storey_lines, print_storey
from pianta.cli.terminal import (
    Quiet,
    counting_files,
    print_error,
    print_result,
)
from pianta.errors import OptionError
from pianta.io._files import MAX_CELLS, count_noun, short_repr
from pianta.io._folders import check_output_folder
from pianta.io.bags import Message
from pianta.layout.reconstruct import DEFAULT_METHOD, METHODS
from pianta.reading._reader import ReadOptions
from pianta.reading.read import Failure, read, read_all
from pianta.reading.reading import (
    EXPLANATION,
    OUTPUTS,
    Reading,
    check_clean_map,
    check_corrections,
    check_output,
)
from pianta.reading.series import read_series
from pianta.reading.storeys import parse_links, parse_storeys, save_storeys

if TYPE_CHECKING:
    from pianta.layout.explanation import Explanation

EXAMPLES = (
    "pianta read map.yaml -o building",
    "pianta read scan.png --resolution 0.05 -o building --walls --graph",
    "pianta read map.yaml -o building --type school",
    "pianta read larger.yaml --previous building -o building",
    "pianta read maps -o buildings --jobs 4",
    "pianta read 'maps/**/*.yaml' -o buildings --shard 2/8",
    "pianta read maps -o buildings --retry-failed",
    "pianta read plan.png -o building --type school",
    "pianta read drawings.pdf --page 3 -o building",
    "pianta read floor.dxf --room-layers 'A-AREA*' --door-layers A-DOOR -o building",
    "pianta read ground.yaml first.yaml -o house --storey ground:0 --storey first:3.1",
    "pianta read map.yaml -o building --clean clean.yaml --explain",
    "pianta read run.bag -o building --topic /map",
    "pianta read run.bag -o series --message all",
)

READ = BatchWords("file", "read", "reads")
MAX_DIGITS = 12  # of the number of a message

Maps = Annotated[
    list[str],
    typer.Argument(
        metavar="FILE",
        help="A map.yaml, NumPy archive (.npz), image, GeoTIFF, rosbag, Valetudo's JSON, PCD or PLY; a plan as image, "
        "DXF, SVG, PDF, IFC or .sh3d.",
    ),
]
Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for the results; created if necessary.")]
Previous = Annotated[
    Path | None, typer.Option(metavar="FLOOR", help="Older floor.geojson, or its folder; rooms keep its ids.")
]
Earlier = Annotated[
    list[Path] | None,
    typer.Option(
        metavar="FLOOR",
        help="Still older floor; rooms that --previous cuts differently get back its ids. May be repeated, the newest "
        "first.",
    ),
]
Method = Annotated[str, typer.Option(help=f"How rooms are found: {', '.join(METHODS)}.")]
AsPrinted = Annotated[
    bool, typer.Option("--as-printed", help="Method thesis as the thesis prints it, without our departures.")
]
As = Annotated[
    Literal["map", "plan"] | None,
    typer.Option("--as", help="Whether it is a robot's map or a plan; detected unless given."),
]
Page = Annotated[int | None, typer.Option(min=1, help="Page of a PDF; without it all that show a plan, as storeys.")]
Symbols = Annotated[
    Path | None, typer.Option(metavar="FOLDER", help="PNGs of further symbols of plans; door*.png are doors.")
]
WallLayers = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME", help="Layer of walls of a DXF, * for any letters; may be repeated."),
]
DoorLayers = Annotated[list[str] | None, typer.Option(metavar="NAME", help="The same for doors.")]
RoomLayers = Annotated[
    list[str] | None, typer.Option(metavar="NAME", help="The same for closed outlines, which then are the rooms.")
]
Words = Annotated[Path | None, typer.Option(metavar="FILE", help="JSON with further words in names of rooms.")]
Resolution = Annotated[
    float | None,
    typer.Option(help="Metres per cell of an image without map.yaml, per pixel of a plan, per unit of a DXF or SVG."),
]
TrustThresholds = Annotated[
    bool, typer.Option("--trust-thresholds", help="Read greys of unknown, such as 205, as the thresholds say.")
]
Topic = Annotated[str | None, typer.Option(metavar="NAME", help="Topic of a bag, if several have maps.")]
MessageChoice = Annotated[
    str, typer.Option("--message", metavar="last|N|all", help="Which map of a bag; all as a series, ids kept.")
]
MaxCells = Annotated[int, typer.Option(min=1, help="Largest map that is read.")]
Walls = Annotated[bool, typer.Option("--walls", help="Draw lines of walls into the picture, if the method has them.")]
Graph = Annotated[bool, typer.Option("--graph", help="Draw the topological graph into the picture.")]
Model = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Model of `pianta train places`; else the included one.")
]
Type = Annotated[
    str | None,
    typer.Option("--type", metavar="NAME", help="Building type, such as school or office, if you know it."),
]
BuildingModelFile = Annotated[
    Path | None,
    typer.Option("--building-model", metavar="FILE", help="Model of `pianta train buildings`; else the included one."),
]
LabelUnknown = Annotated[
    bool, typer.Option("--label-unknown", help="Label rooms fully even if the building is of no known type.")
]
NoPredictions = Annotated[
    bool, typer.Option("--no-predictions", help="Leave out the predicted shapes of rooms that were seen in part.")
]
Clean = Annotated[
    Path | None,
    typer.Option(metavar="MAP", help="Write the map without furniture, spray and people as a map.yaml or .npz."),
]
Explain = Annotated[
    bool, typer.Option("--explain", help="Draw explain.png, and print why each room was divided or not.")
]
Storeys = Annotated[
    list[str] | None,
    typer.Option("--storey", metavar="NAME[:M]", help="The files are storeys: the name and the height of each."),
]
Stairs = Annotated[
    list[str] | None, typer.Option(metavar="ENDS", help="Rooms that stairs join, 'ground:3 first:7'; may be repeated.")
]
Lifts = Annotated[list[str] | None, typer.Option("--lift", metavar="ENDS", help="The same of a lift.")]
NoLabels = Annotated[bool, typer.Option("--no-labels", help="Leave out the labels of rooms and the building type.")]


def read_maps(
    maps: Maps,
    *,
    out: Out,
    previous: Previous = None,
    earlier: Earlier = None,
    method: Method = DEFAULT_METHOD,
    as_printed: AsPrinted = False,
    as_kind: As = None,
    resolution: Resolution = None,
    trust_thresholds: TrustThresholds = False,
    topic: Topic = None,
    message: MessageChoice = "last",
    max_cells: MaxCells = MAX_CELLS,
    page: Page = None,
    symbols: Symbols = None,
    wall_layers: WallLayers = None,
    door_layers: DoorLayers = None,
    room_layers: RoomLayers = None,
    words: Words = None,
    walls: Walls = False,
    graph: Graph = False,
    building_type: Type = None,
    model: Model = None,
    building_model: BuildingModelFile = None,
    no_labels: NoLabels = False,
    label_unknown: LabelUnknown = False,
    no_predictions: NoPredictions = False,
    clean: Clean = None,
    explain: Explain = False,
    storeys: Storeys = None,
    stairs: Stairs = None,
    lifts: Lifts = None,
    jobs: Jobs = 1,
    resume: Resume = True,
    retry_failed: RetryFailed = False,
    shard: Shard = None,
    time_limit: TimeLimit = None,
    scheduler: Scheduler = None,
    json_file: Json = None,
    quiet: Quiet = False,
) -> None:
    """Read a robot's map, or a plan, into a building: its type, rooms and doors.

    Writes floor.geojson (metres of the map frame), rooms.png (16 bits: 0 is no
    room, n the room with id n), graph.json (networkx node-link), picture.png,
    and grid.npz, the map for `pianta view` and others.

    Several files get a folder each in OUT, as do the maps and plans of a folder.
    If one cannot be read, the others are still read; the exit code is then 1.
    Files that the journal in OUT has as read are not read again.

    Rooms of plans get the names that are written in them, from which their labels
    follow; several floors on a plan get a folder each, floor-1, floor-2, ….

    Closed outlines with a text inside are the rooms of a DXF, exactly; what was
    taken from which layer is printed, and --room-layers, --wall-layers and
    --door-layers correct it.

    With --storey the files are storeys of one building, and building.json joins
    their folders. Stairs and lifts with one name on two storeys join these.

    Rooms are labelled ROOM or CORRIDOR; FUNCTIONAL, CONNECTION, ENTRANCE or
    SERVICE; and with --type by the labels of that building type. In a building
    of no known type they are ROOM or CORRIDOR where that is certain.

    With --previous rooms keep their ids, and manual labels and a manual type
    stay; the map may have grown, and its origin may have moved.

    With --message all every map of a bag is read with the rooms of the one
    before, in folders 001, 002, …; rooms keep their ids.
    """
    quiet = check_json(json_file, quiet=quiet)
    options: ReadOptions = {
        "previous": previous,
        "earlier": earlier or (),
        "method": method,
        "as_printed": as_printed,
        "input_kind": as_kind,
        "resolution": resolution,
        "trust_thresholds": trust_thresholds,
        "topic": topic,
        "max_cells": max_cells,
        "page": page,
        "symbols": symbols,
        "wall_layers": _split_layers(wall_layers),
        "door_layers": _split_layers(door_layers),
        "room_layers": _split_layers(room_layers),
        "words": words,
        "building_type": building_type,
        "room_model": model,
        "building_model": building_model,
        "labels": not no_labels,
        "label_unknown": label_unknown,
        "predict_partial": not no_predictions,
    }
    if message == "all":
        _refuse_with_all({"clean": clean, "explain": explain, "storey": storeys, "stairs": stairs, "lift": lifts})
        _finish(_read_series(maps, out, options, walls=walls, graph=graph, quiet=quiet), out, json_file, expected=1)
        return
    options["message"] = _parse_message(message)
    extras = _Extras(clean, explain)
    extras.check(maps, method)
    named, links = _parse_building(storeys, stairs, lifts, len(maps))
    picture, flags = _PictureOptions(walls, graph), BatchFlags(jobs, resume, retry_failed, shard, time_limit, scheduler)
    if named is None and (len(maps) > 1 or is_collection(maps[0]) or flags.batch_only):
        _read_several(maps, out, options, picture, flags=flags, json_file=json_file, quiet=quiet)
    elif named is None:
        _finish([_read_one(maps[0], out, options, extras, picture, quiet=quiet)], out, json_file, expected=1)
    else:
        storeys_read = _read_storeys(maps, out, options, named, links, picture=picture, flags=flags, quiet=quiet)
        _finish(storeys_read, out, json_file, expected=len(maps))


def _parse_building(
    storeys: Sequence[str] | None, stairs: Sequence[str] | None, lifts: Sequence[str] | None, count: int
) -> tuple[list[tuple[str, float | None]] | None, list[Link]]:
    """The names and heights of `count` storeys, None without names, and what joins them. Raises OptionError."""
    named = list(parse_storeys(storeys, count)) if storeys else None
    links = [*parse_links(stairs or (), "stairs"), *parse_links(lifts or (), "lift")]
    if links and named is None:
        raise OptionError("--stairs and --lift join storeys, give --storey for each file")
    return named, links


def _split_layers(names: Sequence[str] | None) -> tuple[str, ...]:
    """Names of layers, which a comma separates too: layers have none in their names."""
    return tuple(name.strip() for text in names or () for name in text.split(",") if name.strip())


def _finish(readings: Sequence[Reading], out: Path, json_file: Path | None, *, expected: int) -> None:
    """Write the JSON of what was read; the exit code is 1 if that is less than expected."""
    write_json(describe_readings([(reading, reading.folder or out) for reading in readings]), json_file)
    if len(readings) < expected:
        raise typer.Exit(1)


@dataclass(frozen=True)
class _PictureOptions:
    """What is shown in pictures, as of `Reading.save`."""

    walls: bool
    graph: bool


def _read_several(
    maps: Sequence[str],
    out: Path,
    options: ReadOptions,
    picture: _PictureOptions,
    *,
    flags: BatchFlags,
    json_file: Path | None,
    quiet: bool,
) -> None:
    """Read each file that the journal does not have as read; the exit code is 1 if any has failed."""
    items = run_batch(
        lambda bar: read_batch(
            maps,
            out=out,
            walls=picture.walls,
            graph=picture.graph,
            describe=describe_for_journal,
            progress=bar.move,
            **flags.arguments,
            **options,
        ),
        READ,
        lambda item: item.description["lines"],
        quiet=quiet,
        keep=lambda item: replace(item, description=item.description if json_file else None),
    )
    # Processes end in any order
    described = [_describe_item(item) for item in sorted(items, key=lambda item: item.path) if item.description]
    write_json({"files": described}, json_file)
    exit_if_any_failed(items)


def _describe_item(item: BatchItem) -> dict[str, object]:
    """The part of the JSON of a file that was read; the paths as they are given now."""
    file = item.description["file"]
    storeys = [{**storey, "folder": str(item.folder / storey["name"])} for storey in file["storeys"]]
    return {**file, "file": str(item.path), "storeys": storeys}


def describe_for_journal(reading: Reading) -> dict[str, object]:
    """The lines that are printed for a file, and its part of the JSON."""
    (described,) = describe_readings([(reading, reading.folder or Path())])["files"]
    return {"lines": list_storey_lines(reading), "file": described}


def _read_storeys(
    maps: Sequence[str],
    out: Path,
    options: ReadOptions,
    named: Sequence[tuple[str, float | None]],
    links: Sequence[Link],
    *,
    picture: _PictureOptions,
    flags: BatchFlags,
    quiet: bool,
) -> list[Reading]:
    """Read each file, a storey, and print a line for it; join them to a building, if all are read."""
    if flags.batch_only:
        raise OptionError(f"storeys are read together, leave out {' and '.join(flags.batch_only)}")
    refuse_batch(out, "building")
    with counting_files(maps, quiet=quiet) as progress:
        names = [name for name, _ in named]
        results = read_all(
            maps,
            out=out,
            names=names,
            walls=picture.walls,
            graph=picture.graph,
            jobs=flags.jobs,
            progress=progress,
            **options,
        )
        readings = [each for each in results if _print_one_of_several(each, quiet=quiet) and isinstance(each, Reading)]
    if not quiet:
        print_result(f"{len(readings)} of {len(maps)} files read")
    if len(readings) == len(maps):
        as_storeys = [
            Storey(reading.floor, name, elevation, reading.grid, area_trust=reading.storeys[0].area_trust)
            for reading, (name, elevation) in zip(readings, named, strict=True)
        ]
        building = save_storeys(as_storeys, out, links)
        if not quiet:
            joined = count_noun(len(building.links), "link")
            print_result(f"{count_noun(len(building), 'storey')}, {joined} by stairs and lifts, in {out}")
    return readings


def _refuse_with_all(flags: Mapping[str, object]) -> None:
    """Raise OptionError for flags that a series of maps does not have."""
    surplus = [f"--{flag}" for flag, value in flags.items() if value]
    if surplus:
        raise OptionError(f"--message all is a series of maps, leave out {' and '.join(surplus)}")


def _parse_message(text: str) -> Message:
    """The message that is meant; raises OptionError."""
    if text == "last":
        return "last"
    if not text.isdecimal() or len(text) > MAX_DIGITS:
        raise OptionError(f"message is {short_repr(text)}, give last, all, or a number from 1")
    return int(text)


def _read_series(
    maps: Sequence[str], out: Path, options: ReadOptions, *, walls: bool, graph: bool, quiet: bool
) -> list[Reading]:
    """Read all maps of a bag, and print a line for each; those that can be read."""
    if len(maps) > 1:
        raise OptionError(f"--message all is for one bag and {len(maps)} files are given, read each bag on its own")
    refuse_batch(out, maps[0])
    results = read_series(maps[0], out=out, walls=walls, graph=graph, **options)
    done = [(each, _print_one_of_several(each, quiet=quiet)) for each in results]
    readings = [each for each, _ in done if isinstance(each, Reading)]
    if not quiet:
        print_result(f"{len(readings)} of {count_noun(len(done), 'map')} read")
    return readings


@dataclass(frozen=True)
class _Extras:
    """What is written for a single map besides its building.

    clean: the file of the clean map, if any. explain: whether to draw and print the explanation.
    """

    clean: Path | None
    explain: bool

    def check(self, maps: Sequence[str], method: str) -> None:
        """Raise OptionError for several maps, and for the explanation of a method that gives none."""
        for flag, is_given in (("--clean", self.clean is not None), ("--explain", self.explain)):
            if is_given and len(maps) > 1:
                raise OptionError(f"{flag} is for one map and {len(maps)} files are given, read each file on its own")
            if is_given and is_collection(maps[0]):
                raise OptionError(f"{flag} is for one map and {short_repr(maps[0])} stands for several, give a file")
        if self.explain and method != DEFAULT_METHOD:
            raise OptionError(f"method {method} has no explanation, leave out --explain or give {DEFAULT_METHOD}")

    def check_files(self, path: str, out: Path) -> None:
        """Raise OptionError if a file cannot be written, or would replace the map or a result."""
        check_output(path, out, names=(*OUTPUTS, EXPLANATION) if self.explain else OUTPUTS)
        if self.clean is not None:
            check_clean_map(path, self.clean, out)


def _read_one(
    path: str, out: Path, options: ReadOptions, extras: _Extras, picture: _PictureOptions, *, quiet: bool
) -> Reading:
    """Read a file; print its rooms, its messages, and where the results are."""
    check_output_folder(out)
    refuse_batch(out, path)
    extras.check_files(path, out)
    check_corrections(out, options["previous"])
    reading = read(path, **options)
    clean_map = reading.clean_map() if extras.clean else None
    explanation = reading.explain() if extras.explain else None
    folders = reading.save(out, walls=picture.walls, graph=picture.graph)
    if explanation:
        save_explanation(explanation, out / EXPLANATION)
    if clean_map and extras.clean:
        clean_map.save(extras.clean)
    if quiet:
        return reading
    for storey, folder in zip(reading.storeys, folders, strict=True):
        print_storey(storey, folder, label_unknown=options["label_unknown"])
    if explanation:
        for room in reading.floor:
            print_result(explanation.describe_room(room.id))
    if extras.clean:
        print_result(f"clean map in {extras.clean}")
    return reading


def save_explanation(explanation: Explanation, path: Path) -> None:
    """Write the picture of an explanation; raises PiantaError if it cannot be written."""
    from pianta.plot.explanation import draw_explanation
    from pianta.plot.figure import save_figure

    save_figure(draw_explanation(explanation), path)


def _print_one_of_several(result: Reading | Failure, *, quiet: bool) -> bool:
    """Print a line for each storey, or why the file could not be read; whether it was read."""
    if isinstance(result, Failure):
        print_error(result.error)
        return False
    for line in () if quiet else list_storey_lines(result):
        print_result(line)
    return True
