"""The verb patterns: groups of rooms that floors repeat."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pianta.cli.json_output import Json, check_json, write_json
from pianta.cli.terminal import Quiet, print_error, print_result, track_items
from pianta.errors import OptionError, PiantaError
from pianta.floor import Floor
from pianta.io._folders import atomic_folder, check_output_folder, choose_names
from pianta.io.buildings.read import list_buildings, read_buildings
from pianta.patterns.model_floor_plan import SHUFFLES, ModelFloorPlan, Occurrence, Pattern, find_model_floor_plan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXAMPLES = (
    "pianta patterns office.xml -o patterns",
    "pianta patterns building/floor.geojson --no-labels",
    "pianta patterns ground.xml first.xml second.xml --storeys -o patterns",
)
MAX_ROOMS_SHOWN = 8  # ids of an occurrence in a line
MAX_COPIES_SHOWN = 6  # occurrences in a line, without the first

Floors = Annotated[list[str], typer.Argument(metavar="FLOOR", help="Files of floors, or folders of them.")]
Out = Annotated[
    Path | None, typer.Option("--out", "-o", help="Folder for NAME.png and NAME.json, the patterns of every floor.")
]
Storeys = Annotated[bool, typer.Option("--storeys", help="The floors are the storeys of one building.")]
Labels = Annotated[
    bool, typer.Option("--labels/--no-labels", help="Whether rooms that correspond must have the same label.")
]
Shuffles = Annotated[
    int, typer.Option(min=0, max=10000, metavar="N", help="How often rooms are shuffled, to know what chance gives.")
]
Seed = Annotated[int, typer.Option(help="Of the shuffles.", min=0, max=2**31)]


def find_patterns(
    floors: Floors,
    *,
    out: Out = None,
    storeys: Storeys = False,
    labels: Labels = True,
    shuffles: Shuffles = SHUFFLES,
    seed: Seed = 0,
    json_file: Json = None,
    quiet: Quiet = False,
) -> None:
    """Find the model floor plan: groups of rooms that a floor repeats.

    Patterns are rooms in the same order along two stretches of corridors, or
    parts of the floor that are moved, turned or mirrored. The score is the
    share of the rooms that follow from the others; beside it is the score of
    the same rooms in random places.

    Floors are layout XML, KTH XML, MIT XML, HouseExpo JSON or floor.geojson of
    `pianta read`. If a floor cannot be read, the others still are; the exit
    code is then 1.
    """
    quiet = check_json(json_file, quiet=quiet)
    if out:
        check_output_folder(out)
    files = list_buildings(floors)
    if storeys and len(files) < 2:
        raise OptionError(f"--storeys needs two floors, give more than {files[0]}")
    search = partial(find_model_floor_plan, labels=labels, shuffles=shuffles, seed=seed)
    read = _read_floors(files, quiet=quiet)
    buildings = [read] if storeys else [[floor] for floor in read]
    plans: list[tuple[list[Floor], ModelFloorPlan]] = []
    for building in buildings:
        try:
            plans.append((building, search(building)))
        except PiantaError as error:
            _refuse(error, files, building[0].source)
            continue
        if not quiet:
            _print_plan(", ".join(floor.source for floor in building), plans[-1][1], building)
    write_json({"buildings": [_describe(building, plan) for building, plan in plans]}, json_file)
    if out:
        _save(plans, out)
    if len(read) < len(files) or len(plans) < len(buildings):
        raise typer.Exit(1)


def _read_floors(files: Sequence[Path], *, quiet: bool) -> list[Floor]:
    """The floors that can be read; an error of one of several files is printed, one of the only file is raised."""
    floors = []
    for _, result in read_buildings(files, track=partial(track_items, quiet=quiet)):
        if isinstance(result, PiantaError):
            _refuse(result, files)
        else:
            floors.append(result)
    if not floors:
        raise PiantaError(f"none of {len(files)} floors could be read, the first of them is {str(files[0])!r}")
    return floors


def _refuse(error: PiantaError, files: Sequence[Path], source: str = "") -> None:
    """Print an error, with the floor's name; raise it if there is one file only."""
    if len(files) == 1:
        raise error
    print_error(type(error)(f"{source}: {error}") if source else error)


def _print_plan(name: str, plan: ModelFloorPlan, storeys: Sequence[Floor]) -> None:
    """Print a line for the floor and one for each pattern."""
    chance = plan.chance
    shuffled = f" (shuffled {100 * chance.saved:.0f} ± {100 * chance.saved_sd:.0f} %)" if chance else ""
    repeated = f"{100 * plan.repeated:.0f} % of {plan.rooms} rooms are in a pattern"
    print_result(f"{name}: {repeated}, {100 * plan.saved:.0f} % follow from the others{shuffled}")
    for pattern in plan.patterns:
        _print_pattern(pattern, storeys, indent=2)


def _print_pattern(pattern: Pattern, storeys: Sequence[Floor], indent: int) -> None:
    """Print a line for a pattern, and one for each within it."""
    first, *others = pattern.occurrences
    rooms = f"{len(first.rooms)} rooms {_list_rooms(first)}"
    copies = [
        each.motion.name + (f" on {storeys[each.storey].source}" if len(storeys) > 1 else "") + f" {_list_rooms(each)}"
        for each in others[:MAX_COPIES_SHOWN]
        if each.motion
    ]
    if len(others) > MAX_COPIES_SHOWN:
        copies.append(f"and {len(others) - MAX_COPIES_SHOWN} more")
    if len(storeys) > 1:
        rooms += f" of {storeys[first.storey].source}"
    where = "in a row" if pattern.kind == "row" else "in a part"
    print_result(f"{' ' * indent}{pattern.name}: {rooms} {where}, {len(others) + 1} times: {', '.join(copies)}")
    for inner in pattern.inner:
        _print_pattern(inner, storeys, indent + 2)


def _list_rooms(occurrence: Occurrence) -> str:
    """Ids of the rooms of an occurrence, in the order in which they correspond to those of the others."""
    listed = ", ".join(map(str, occurrence.rooms[:MAX_ROOMS_SHOWN]))
    return f"({listed}{', …' if len(occurrence.rooms) > MAX_ROOMS_SHOWN else ''})"


def _save(plans: Sequence[tuple[list[Floor], ModelFloorPlan]], out: Path) -> None:
    """Write the JSON file of each building and the picture of each of its floors."""
    from pianta.plot.figure import save_figure

    sources = [floor.source.replace("/", "_") for building, _ in plans for floor in building]
    names = iter(choose_names([source.rpartition(".")[0] or source for source in sources], sources))
    with atomic_folder(out) as new:
        for building, plan in plans:
            floor_names = [next(names) for _ in building]
            write_json(_describe(building, plan), new / f"{floor_names[0]}.json")
            for storey, (floor, name) in enumerate(zip(building, floor_names, strict=True)):
                if floor.rooms:
                    save_figure(_draw(floor, plan, storey), new / f"{name}.png")


def _describe(building: Sequence[Floor], plan: ModelFloorPlan) -> dict[str, object]:
    return {"floors": [floor.source for floor in building], **plan.as_json()}


def _draw(floor: Floor, plan: ModelFloorPlan, storey: int) -> Figure:
    from pianta.plot.model_floor_plan import draw_model_floor_plan

    return draw_model_floor_plan(floor, plan, storey=storey)
