"""The verb read: the building of a map or a plan, or of several."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from typing import Annotated, Literal

import typer

from pianta.cli.labelling import Labelling, describe_type, label_floor, name_type, read_labelling
from pianta.cli.opening import OpenedFloor, Opening
from pianta.cli.outputs import check_output_folder, written_together
from pianta.cli.room_table import tabulate_rooms
from pianta.cli.terminal import describe_floor, stdout, tell_error, tell_result, track_items
from pianta.errors import MapWarning, OptionError, PiantaError
from pianta.floor import Floor
from pianta.io._files import MAX_CELLS, shown
from pianta.io.floors import read_floor, save_floor, save_label_image
from pianta.io.graphs import save_graph
from pianta.labels import SCHEMAS
from pianta.layout.reconstruct import DEFAULT_METHOD, METHODS, check_method
from pianta.plot.floor import save_picture

OUTPUTS = ("floor.geojson", "rooms.png", "graph.json", "picture.png")
MAX_GONE_TOLD = 10
EXAMPLES = (
    "pianta read map.yaml -o building",
    "pianta read scan.png --resolution 0.05 -o building --walls --graph",
    "pianta read map.yaml -o building --type school",
    "pianta read larger.yaml --previous building -o building",
    "pianta read maps/*.yaml -o buildings",
    "pianta read plan.png -o building --type school",
    "pianta read drawings.pdf --page 3 -o building",
)

Maps = Annotated[
    list[str],
    typer.Argument(
        metavar="FILE", help="A map.yaml, NumPy archive (.npz) or image; a plan as image, DXF, SVG, PDF or IFC."
    ),
]
Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for the results; made when there is none.")]
Previous = Annotated[
    Path | None, typer.Option(metavar="FLOOR", help="Older floor.geojson, or its folder, whose room ids are kept.")
]
Method = Annotated[str, typer.Option(help=f"How rooms are found: {', '.join(METHODS)}.")]
As = Annotated[
    Literal["map", "plan"] | None,
    typer.Option("--as", help="Whether it is a robot's map or a plan; seen in the file unless given."),
]
Page = Annotated[int | None, typer.Option(min=1, help="Page of a PDF.")]
Symbols = Annotated[
    Path | None, typer.Option(metavar="FOLDER", help="PNGs of symbols of plans, besides our own; door*.png are doors.")
]
Words = Annotated[
    Path | None, typer.Option(metavar="FILE", help="JSON with words that names of rooms have, besides our own.")
]
Resolution = Annotated[
    float | None,
    typer.Option(help="Metres per cell of an image without map.yaml, per pixel of a plan, per unit of a DXF or SVG."),
]
TrustThresholds = Annotated[
    bool, typer.Option("--trust-thresholds", help="Keep grey 205 free where free_thresh makes it so.")
]
MaxCells = Annotated[int, typer.Option(min=1, help="Largest map that is read.")]
Walls = Annotated[bool, typer.Option("--walls", help="Draw the lines of walls into the picture; the rivals find none.")]
Graph = Annotated[bool, typer.Option("--graph", help="Draw the topological graph into the picture.")]
Model = Annotated[Path | None, typer.Option(metavar="FILE", help="Model of `pianta train places`; ours unless given.")]
Type = Annotated[
    str | None,
    typer.Option("--type", metavar="NAME", help="Building type, such as school or office, where you know it."),
]
BuildingModelFile = Annotated[
    Path | None,
    typer.Option("--building-model", metavar="FILE", help="Model of `pianta train buildings`; ours unless given."),
]
NoLabels = Annotated[bool, typer.Option("--no-labels", help="Do not say what rooms are for, nor the building.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")]


def read_maps(
    maps: Maps,
    *,
    out: Out,
    previous: Previous = None,
    method: Method = DEFAULT_METHOD,
    as_kind: As = None,
    resolution: Resolution = None,
    trust_thresholds: TrustThresholds = False,
    max_cells: MaxCells = MAX_CELLS,
    page: Page = None,
    symbols: Symbols = None,
    words: Words = None,
    walls: Walls = False,
    graph: Graph = False,
    building_type: Type = None,
    model: Model = None,
    building_model: BuildingModelFile = None,
    no_labels: NoLabels = False,
    quiet: Quiet = False,
) -> None:
    """Read a robot's map, or a plan, into a building: its type, rooms and doors.

    Writes floor.geojson (metres of the map frame), rooms.png (16 bits: 0 is no
    room, n the room with id n), graph.json (networkx node-link), picture.png.

    Several files get a folder each in OUT. One that cannot be read does not
    stop the others; the exit code is then 1.

    Rooms of plans get the names that are written in them, which tell what they
    are for; several floors on a plan get a folder each, floor-1, floor-2, ….

    Rooms are labelled ROOM or CORRIDOR; FUNCTIONAL, CONNECTION, ENTRANCE or
    SERVICE; and with --type by the names of that building type.

    With --previous rooms keep their ids, and labels and a type that somebody
    has given stay; the map may have grown, and its origin may have moved.
    """
    check_output_folder(out)
    check_method(method)
    older = _read_older(previous, maps)
    labelling = read_labelling(model, building_model, building_type, words, no_labels=no_labels)
    opening = Opening(
        method=method,
        kind=as_kind,
        resolution=resolution,
        trust_thresholds=trust_thresholds,
        max_cells=max_cells,
        page=page,
        symbols=symbols,
    )
    reading = Reading(opening, older, labelling, walls=walls, graph=graph)
    (_read_several if len(maps) > 1 else _read_one)(maps, out, reading, quiet=quiet)


@dataclass(frozen=True)
class Reading:
    """How files are read.

    older: the floor whose ids and given labels stay. labelling: None for no labels. walls, graph: what to draw into the
    picture.
    """

    opening: Opening
    older: Floor | None
    labelling: Labelling | None
    walls: bool
    graph: bool

    def read(self, path: str, folder: Path) -> list[ReadFloor]:
        """Read a map or a plan and write the results into a folder, those of several floors into a folder each.

        All are made before the first takes the place of an older one, so that one that fails leaves none.
        """
        _refuse_overwriting(Path(path), folder)
        opened = self.opening.open(path)
        if self.older and len(opened) > 1:
            raise OptionError(f"--previous is one floor and plan {shown(path)} shows {len(opened)}, leave it out")
        _refuse_folders_in_the_way([folder / one.folder for one in opened])
        read = []
        with ExitStack() as together:
            for one in opened:
                floor = _keep_ids(one.floor, self.older, path) if self.older else one.floor
                floor = label_floor(floor, self.labelling, self.older)
                into = folder / one.folder
                self._write(floor, one, together.enter_context(written_together(into)))
                read.append(ReadFloor(floor, into, one.told))
        return read

    def _write(self, floor: Floor, opened: OpenedFloor, folder: Path) -> None:
        """Write floor.geojson, rooms.png, graph.json and picture.png into a folder."""
        geojson, labels, node_link, picture = (folder / name for name in OUTPUTS)
        schemas = self.labelling.schemas if self.labelling else SCHEMAS
        save_floor(floor, geojson)
        save_label_image(floor.label_image(opened.grid), labels)
        save_graph(floor.graph(), node_link)
        save_picture(
            floor, opened.grid, picture, walls=self.walls, graph=self.graph, schemas=schemas, paper=opened.paper
        )


@dataclass(frozen=True)
class ReadFloor:
    """A floor, the folder of its results, and what else is worth a line each."""

    floor: Floor
    folder: Path
    told: tuple[str, ...]


def read_previous(path: str | Path) -> Floor:
    """Floor of a floor.geojson or of a folder that holds one.

    Raises FloorError, in one line.
    """
    is_folder = False
    with suppress(OSError, ValueError):  # read_floor says what is wrong with the path
        is_folder = Path(path).is_dir()
    return read_floor(Path(path) / OUTPUTS[0] if is_folder else path)


def describe_ids(floor: Floor, previous: Floor) -> str:
    """How many rooms kept their ids, how many are new, and which are gone."""
    ids, old_ids = ({room.id for room in each.rooms} for each in (floor, previous))
    kept, new, gone = len(ids & old_ids), len(ids - old_ids), sorted(old_ids - ids)
    told = f"{kept} room{'s' * (kept != 1)} kept {'its id' if kept == 1 else 'their ids'}"
    told += f", {new} {'is' if new == 1 else 'are'} new, {len(gone)} {'is' if len(gone) == 1 else 'are'} gone"
    names = " ".join(map(str, gone[:MAX_GONE_TOLD])) + (" …" if len(gone) > MAX_GONE_TOLD else "")
    return f"{told} ({names})" if gone else told


def name_folders(maps: Sequence[str | Path]) -> list[str]:
    """A folder name for each map, all different: its stem; where stems repeat its folder and stem; then a number."""
    files = [Path(path).absolute() for path in maps]
    # A file can be called "...yaml", and its stem is the parent folder.
    stems = [file.stem.lstrip(".") or "map" for file in files]
    occurrences = Counter(stem.casefold() for stem in stems)
    names: dict[str, str] = {}
    for file, stem in zip(files, stems, strict=True):
        name = stem if occurrences[stem.casefold()] == 1 else f"{file.parent.name}-{stem}".lstrip("-.")
        numbered = (name if number == 1 else f"{name}-{number}" for number in count(1))
        free = next(candidate for candidate in numbered if candidate.casefold() not in names)
        names[free.casefold()] = free
    return list(names.values())


def _read_one(maps: Sequence[str], out: Path, reading: Reading, *, quiet: bool) -> None:
    """Read a file; print its rooms, the kind of its building, what became of older ids, and where the results are."""
    for read in reading.read(maps[0], out):
        if quiet:
            continue
        stdout.print(tabulate_rooms(read.floor))
        if reading.labelling and reading.labelling.judges(read.floor):
            tell_result(f"building: {describe_type(read.floor, reading.labelling.buildings.building_types)}")
        if reading.older:
            tell_result(describe_ids(read.floor, reading.older))
        for line in read.told:
            tell_result(line)
        tell_result(f"{describe_floor(read.floor)}, in {read.folder}")


def _read_several(maps: Sequence[str], out: Path, reading: Reading, *, quiet: bool) -> None:
    """Read files into a folder each, with a progress bar; raise typer.Exit(1) at the end when one has failed."""
    failed = 0
    for path, name in zip(track_items(maps, quiet=quiet), name_folders(maps), strict=True):
        try:
            floors = reading.read(path, out / name)
        except PiantaError as error:
            tell_error(error)
            failed += 1
            continue
        for read in floors if not quiet else ():
            judged = reading.labelling and reading.labelling.judges(read.floor)
            kind = f", {name_type(read.floor)}" if judged else ""
            told = "".join(f"; {line}" for line in read.told)
            tell_result(f"{describe_floor(read.floor)}{kind}, in {read.folder}{told}")
    if not quiet:
        tell_result(f"{len(maps) - failed} of {len(maps)} files read")
    if failed:
        raise typer.Exit(1)


def _read_older(previous: Path | None, maps: Sequence[str]) -> Floor | None:
    """The floor of --previous, if there is one; raises OptionError when it is given for several maps."""
    if previous is None:
        return None
    if len(maps) > 1:
        raise OptionError(f"--previous is one floor and {len(maps)} maps are given, read each map on its own")
    return read_previous(previous)


def _keep_ids(floor: Floor, previous: Floor, path: str) -> Floor:
    """The floor with the ids of the previous one; warns when they have no room in common."""
    from pianta.layout.room_ids import keep_room_ids

    floor = keep_room_ids(floor, previous)
    old_ids = {room.id for room in previous.rooms}
    if old_ids.isdisjoint(room.id for room in floor.rooms):
        told = f"map {shown(path)} has no room in common with the floor of --previous, every room got a new id"
        warnings.warn(MapWarning(f"{told}; check that both are of one building"), stacklevel=2)
    return floor


def _refuse_folders_in_the_way(folders: Sequence[Path]) -> None:
    """Raise OptionError when a result has the name of a folder, before any floor takes its place."""
    for target in (folder / name for folder in folders for name in OUTPUTS):
        if target.is_dir():
            raise OptionError(f"cannot write {shown(target)}: it is a folder, give another output folder")


def _refuse_overwriting(map_file: Path, folder: Path) -> None:
    """Raise OptionError when a result would take the place of the map."""
    if map_file.name in OUTPUTS and map_file.resolve().parent == folder.resolve():
        raise OptionError(f"map {shown(map_file)} would be replaced by a result, give another output folder")
