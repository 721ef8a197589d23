"""The verb generate: new buildings of a type."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pianta.cli.terminal import tell_result, track_items
from pianta.errors import OptionError
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_leftovers, check_output_folder

if TYPE_CHECKING:
    import networkx as nx

    from pianta.generation.type_model import TypeModel

EXAMPLES = (
    "pianta generate school.json -n 24 -o schools",
    "pianta generate school.json -n 200 -o schools --jobs 4 --seed 7",
    "pianta generate school.json --rooms 30-50 --at-least CLASSROOM=12 --at-least GYM -o large",
    "pianta generate school.json --like building/floor.geojson -o alike",
    "pianta generate school.json --keep explored/floor.geojson -o continued",
)
SHEET = "sheet.png"

Model = Annotated[Path, typer.Argument(metavar="MODEL", help="Model of a building type, of `pianta train type`.")]
Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for the buildings; it is made when there is none.")]
Count = Annotated[int, typer.Option("--count", "-n", help="How many buildings.", min=1, max=100_000)]
Seed = Annotated[int, typer.Option(min=0, help="The same seed gives the same buildings.")]
Jobs = Annotated[int, typer.Option(min=1, max=256, help="Processes; the buildings are the same for any number.")]
Rooms = Annotated[str | None, typer.Option(metavar="N or N-M", help="Rooms of each building, corridors included.")]
AtLeast = Annotated[
    list[str] | None,
    typer.Option(metavar="LABEL[=N]", help="So many rooms of a label or more, one unless given; may be repeated."),
]
AtMost = Annotated[
    list[str] | None, typer.Option(metavar="LABEL=N", help="So many rooms of a label or fewer; may be repeated.")
]
Like = Annotated[
    Path | None, typer.Option(metavar="FLOOR", help="A floor that the buildings shall be like, and about as large.")
]
Keep = Annotated[
    Path | None, typer.Option(metavar="FLOOR", help="A floor whose rooms and doors each building has, and others.")
]
ChosenCosts = Annotated[
    str, typer.Option("--costs", help="What the steps follow: density, or thesis, as in section 7.4.3.", metavar="NAME")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")]


def generate(
    model: Model,
    *,
    out: Out,
    count: Count = 24,
    seed: Seed = 0,
    jobs: Jobs = 1,
    rooms: Rooms = None,
    at_least: AtLeast = None,
    at_most: AtMost = None,
    like: Like = None,
    keep: Keep = None,
    costs: ChosenCosts = "density",
    quiet: Quiet = False,
) -> None:
    """Make new buildings of a type, as graphs of labelled rooms joined by doors.

    Writes building-001.json (networkx node-link), .graphml and so on, and sheet.png.

    FLOOR is a folder of `pianta read --type`, or a floor.geojson, layout XML, graph.json or
    GraphML whose rooms have labels of the type. With --keep its rooms have their ids
    as `room` in the new graphs; those without a door are left out.
    """
    from pianta.generation import generate as generation
    from pianta.generation.type_model_file import read_type_model
    from pianta.io.graphs import read_floor_graph

    check_output_folder(out)
    names = [f"building-{number:0{max(3, len(str(count)))}}" for number in range(1, count + 1)]
    check_leftovers(out, names, stem="building")
    limits = _read_numbers(at_least or (), "--at-least", unless_given=1), _read_numbers(at_most or (), "--at-most")
    size = None if rooms is None else read_range(rooms)
    known = read_type_model(model)
    buildings = generation.generate(
        known,
        count,
        rooms=size,
        at_least=limits[0],
        at_most=limits[1],
        similar_to=None if like is None else read_floor_graph(like),
        keep=None if keep is None else read_floor_graph(keep),
        costs=costs,
        seed=seed,
        jobs=jobs,
        track=partial(track_items, quiet=quiet),
    )
    save_buildings(buildings, names, known, out)
    if not quiet:
        _tell_buildings(buildings, known, out)


def save_buildings(buildings: Sequence[nx.Graph], names: Sequence[str], model: TypeModel, out: Path) -> None:
    """Write the graphs as NAME.json and NAME.graphml, and their contact sheet, all or none."""
    from pianta.io.graphml import save_graphml
    from pianta.io.graphs import save_graph
    from pianta.plot.graphs import save_contact_sheet

    kept = [[node for node, room in building.nodes(data="room") if room is not None] for building in buildings]
    with atomic_folder(out) as new:
        for name, building in zip(names, buildings, strict=True):
            building.graph.update(source=name, building_type=model.building_type)
            save_graph(building, new / f"{name}.json")
            save_graphml(building, new / f"{name}.graphml")
        save_contact_sheet(buildings, new / SHEET, schema=model.schema, fixed=kept)


def read_range(text: str) -> tuple[int, int]:
    """The numbers of N or N-M.

    Raises OptionError for anything else.
    """
    found = re.fullmatch(r"\s*(\d{1,6})\s*(?:-\s*(\d{1,6})\s*)?", text, re.ASCII)
    if found is None:
        raise OptionError(f"--rooms is {short_repr(text)}, give a number such as 40, or two such as 30-50")
    return int(found[1]), int(found[2] or found[1])


def _read_numbers(texts: Sequence[str], option: str, *, unless_given: int | None = None) -> Mapping[str, int]:
    """Label -> number of LABEL=N, or of LABEL where a number is known without."""
    numbers: dict[str, int] = {}
    for text in texts:
        label, equals, number = text.partition("=")
        if (not equals and unless_given is None) or (equals and not re.fullmatch(r"\d{1,6}", number.strip(), re.ASCII)):
            raise OptionError(f"{option} is {short_repr(text)}, give a label and a number such as CLASSROOM=12")
        key = label.strip().upper()
        if key in numbers:
            raise OptionError(f"{option} gives {key} twice, leave one out")
        numbers[key] = int(number) if equals else int(unless_given or 0)
    return numbers


def _tell_buildings(buildings: Sequence[nx.Graph], model: TypeModel, out: Path) -> None:
    """Print how large the buildings are beside those of the model, how new, and where they are."""
    from pianta.evaluation.graph_sets import find_copies, find_repeats

    known = [floor.graph for floor in model.floors]
    made, copies, repeats = len(buildings), sum(find_copies(buildings, known)), sum(find_repeats(buildings))
    noun = f"building{'s' * (made != 1)} of type {model.building_type}"
    tell_result(f"{made} {noun}, {_describe_sizes(buildings)}; the {len(known)} of the model {_describe_sizes(known)}")
    tell_result(f"copies of a floor of the model: {copies}; of another new building: {repeats}")
    tell_result(f"in {out}: building-*.json, building-*.graphml, {SHEET}")


def _describe_sizes(graphs: Sequence[nx.Graph]) -> str:
    sizes = [len(graph) for graph in graphs]
    return f"{min(sizes)} to {max(sizes)} rooms, {sum(sizes) / len(sizes):.1f} on average"
