"""The verb generate: new buildings of a type."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypedDict

import typer

from pianta.batch.generate_batch import (
    PLAN_SHEET,
    SHEET,
    count_repeats,
    draw_plans,
    generate_batch,
    refuse_parts,
    save_buildings,
)
from pianta.batch.journal import has_journal
from pianta.batch.world_folders import FURNITURE, NOISE, RESOLUTION, SCAN_FILES, WORLD_FILES, WorldOptions
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
    run_batch,
)
from pianta.cli.terminal import Quiet, print_result, track_items
from pianta.errors import OptionError
from pianta.io._files import count_noun, short_repr
from pianta.io._folders import number_outputs

if TYPE_CHECKING:
    import networkx as nx
    from shapely import Polygon

    from pianta.generation.type_model import TypeModel

EXAMPLES = (
    "pianta generate school.json -n 24 -o schools",
    "pianta generate school.json -n 200 -o schools --jobs 4 --seed 7",
    "pianta generate school.json -n 24 -o schools --plans",
    "pianta generate school.json -n 24 -o schools --worlds --furniture 0.5",
    "pianta generate school.json -n 24 -o schools --scan --noise 0.5 --jobs 2",
    "pianta generate school.json -n 100000 -o schools --jobs 8",
    "pianta generate school.json --rooms 30-50 --at-least CLASSROOM=12 --at-least GYM -o large",
    "pianta generate school.json --like building/floor.geojson -o alike",
    "pianta generate school.json --keep explored/floor.geojson -o continued",
)
GENERATED = BatchWords("part", "generated", "generates")
MAX_FLAT = 1000  # buildings that are written into OUT itself

Model = Annotated[Path, typer.Argument(metavar="MODEL", help="Model of a building type, of `pianta train type`.")]
Out = Annotated[Path, typer.Option("--out", "-o", help="Folder for the buildings; created if necessary.")]
Count = Annotated[int, typer.Option("--count", "-n", help="How many buildings.", min=1, max=100_000)]
Seed = Annotated[int, typer.Option(min=0, help="The same seed gives the same buildings.")]
Rooms = Annotated[str | None, typer.Option(metavar="N or N-M", help="Rooms of each building, corridors included.")]
AtLeast = Annotated[
    list[str] | None,
    typer.Option(metavar="LABEL[=N]", help="At least N rooms of a label, one unless given; may be repeated."),
]
AtMost = Annotated[
    list[str] | None, typer.Option(metavar="LABEL=N", help="At most N rooms of a label; may be repeated.")
]
SimilarTo = Annotated[
    Path | None,
    typer.Option("--like", metavar="FLOOR", help="A floor to which the buildings are similar, also in size."),
]
Keep = Annotated[
    Path | None, typer.Option(metavar="FLOOR", help="A floor whose rooms and doors each building has, and others.")
]
Plans = Annotated[bool, typer.Option("--plans", help="Draw the buildings as floors, too: rooms with walls and doors.")]
Outline = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Draw the buildings inside an outline: a GeoJSON polygon in metres, or a floor; implies --plans.",
    ),
]
Worlds = Annotated[
    bool,
    typer.Option("--worlds", help="Furnish the floors, and write a world for robot simulators each; implies --plans."),
]
Scan = Annotated[
    bool, typer.Option("--scan", help="Also make the map that a robot would make of each world; implies --worlds.")
]
Furniture = Annotated[
    float | None, typer.Option(help=f"Of worlds: 0 for empty rooms … 1 for rooms in use; {FURNITURE:g} unless given.")
]
Noise = Annotated[
    float | None, typer.Option(help=f"Of scans: 0 for a clean map … 1 for a bad one; {NOISE:g} unless given.")
]
Resolution = Annotated[
    float | None, typer.Option(help=f"Of maps of worlds: metres per cell; {RESOLUTION:g} unless given.")
]
ChosenCosts = Annotated[
    str, typer.Option("--costs", help="What the steps follow: density, or thesis, as in section 7.4.3.", metavar="NAME")
]
Recombine = Annotated[
    bool,
    typer.Option(
        "--recombine/--no-recombine",
        help="Whether rooms of functional areas change; or areas of real floors as they are.",
    ),
]
Kernel = Annotated[
    str,
    typer.Option(help="Compares graphs in steps 2 and 4: weisfeiler-lehman, or graph-hopper, slower.", metavar="NAME"),
]


def generate(
    model: Model,
    *,
    out: Out,
    count: Count = 24,
    seed: Seed = 0,
    plans: Plans = False,
    outline: Outline = None,
    worlds: Worlds = False,
    scan: Scan = False,
    furniture: Furniture = None,
    noise: Noise = None,
    resolution: Resolution = None,
    jobs: Jobs = 1,
    rooms: Rooms = None,
    at_least: AtLeast = None,
    at_most: AtMost = None,
    similar_to: SimilarTo = None,
    keep: Keep = None,
    costs: ChosenCosts = "density",
    recombine: Recombine = True,
    kernel: Kernel = "weisfeiler-lehman",
    resume: Resume = True,
    retry_failed: RetryFailed = False,
    shard: Shard = None,
    time_limit: TimeLimit = None,
    scheduler: Scheduler = None,
    quiet: Quiet = False,
) -> None:
    """Generate new buildings of a type, as graphs of labelled rooms joined by doors.

    Writes building-001.json (networkx node-link), .graphml and so on, and
    sheet.png.

    With --plans also their floors, building-001.geojson and .png and so on, and
    plans.png. Doors of a graph, and buildings, that could not be drawn are
    warnings. With --outline buildings have about as many rooms as there is space
    for, unless --rooms is given.

    With --worlds also a folder building-001 and so on, with map.yaml and map.png,
    the true map; world.sdf and rooms.json, a world of Gazebo; and truth.geojson,
    the floor with its furniture. With --scan also a folder scan-001 and so on,
    with the map.yaml and map.png that a robot would make, for `pianta read`.

    More than 1,000 buildings are written in parts of 1,000, into folders
    part-0001, part-0002, …; those that the journal in OUT has are not generated
    again.

    FLOOR is a folder of `pianta read --type`, or a floor.geojson, layout XML,
    graph.json or GraphML whose rooms have labels of the type. With --keep its
    rooms have their ids as `room` in the new graphs; rooms without a door are
    left out.
    """
    from pianta.generation import generate as generation
    from pianta.generation.drawing.site import choose_rooms
    from pianta.generation.type_model_file import read_type_model
    from pianta.io.graphs import read_floor_graph

    world_options = _choose_worlds(worlds=worlds, scan=scan, furniture=furniture, noise=noise, resolution=resolution)
    drawing = _choose_drawing(outline, world_options, plans=plans)
    fewest, most = _read_numbers(at_least or (), "--at-least", default=1), _read_numbers(at_most or (), "--at-most")
    room_range = None if rooms is None else read_range(rooms)
    flags = BatchFlags(jobs, resume, retry_failed, shard, time_limit, scheduler)
    is_large = count > MAX_FLAT or flags.batch_only or has_journal(out)
    names = [] if is_large else _number_buildings(count, out)
    type_model = read_type_model(model)
    options: _Options = {
        "rooms": choose_rooms(drawing.outline, type_model) if drawing.outline and room_range is None else room_range,
        "at_least": fewest,
        "at_most": most,
        "similar_to": None if similar_to is None else read_floor_graph(similar_to),
        "keep": None if keep is None else read_floor_graph(keep),
        "costs": costs,
        "recombine": recombine,
        "kernel": kernel,
        "seed": seed,
    }
    if not names:
        _generate_parts(type_model, count, out, options, flags=flags, drawing=drawing, quiet=quiet)
        return
    track = partial(track_items, quiet=quiet)
    buildings = generation.generate(type_model, count, jobs=jobs, track=track, **options)
    how: _How = {"seed": seed, "jobs": jobs, "track": track}
    drawn_plans = draw_plans(buildings, type_model, outline=drawing.outline, **how) if drawing.plans else None
    save_buildings(buildings, names, type_model, out, plans=drawn_plans, worlds=drawing.worlds, **how)
    if not quiet:
        _print_buildings(buildings, type_model, out, drawing.list_files())


@dataclass(frozen=True)
class _Drawing:
    """What is drawn of buildings: plans, inside an outline if it is given, and worlds."""

    plans: bool
    outline: Polygon | None
    worlds: WorldOptions | None

    @property
    def arguments(self) -> dict[str, Any]:
        """Arguments of `generate_batch`."""
        worlds = {} if self.worlds is None else {"worlds": True, **asdict(self.worlds)}
        return {"plans": self.plans, "outline": self.outline, **worlds}

    def list_files(self) -> str:
        """The files that are written, for people."""
        files = ["building-*.json", "building-*.graphml", SHEET]
        files += ["building-*.geojson", "building-*.png", PLAN_SHEET] if self.plans else []
        if self.worlds:
            files.append(f"building-*/ with {', '.join(WORLD_FILES)}")
        if self.worlds and self.worlds.scan:
            files.append(f"scan-*/ with {', '.join(SCAN_FILES)}")
        return ", ".join(files)


def _choose_drawing(outline: Path | None, worlds: WorldOptions | None, *, plans: bool) -> _Drawing:
    """What is drawn. Raises FloorError for a file without outline."""
    from pianta.io.outlines import read_outline

    shape = None if outline is None else read_outline(outline)
    return _Drawing(plans or worlds is not None or shape is not None, shape, worlds)


def _choose_worlds(*, worlds: bool, scan: bool, **options: float | None) -> WorldOptions | None:
    """The options of worlds, None without worlds; raises OptionError for options that need worlds, or scans."""
    chosen = {name: value for name, value in options.items() if value is not None}
    if "noise" in chosen and not scan:
        raise OptionError("--noise is of the maps of robots, give --scan, too")
    if chosen and not (worlds or scan):
        raise OptionError(f"--{min(chosen)} is of worlds, give --worlds or --scan, too")
    return WorldOptions(scan=scan, **chosen) if worlds or scan else None


def _number_buildings(count: int, out: Path) -> list[str]:
    """Names of buildings in a folder. Raises OptionError if it has others."""
    names = number_outputs("building", count, out)
    refuse_parts(out)
    return names


class _Options(TypedDict):
    """Options of `generate` and `generate_batch`."""

    rooms: tuple[int, int] | None
    at_least: Mapping[str, int]
    at_most: Mapping[str, int]
    similar_to: nx.Graph | None
    keep: nx.Graph | None
    costs: str
    recombine: bool
    kernel: str
    seed: int


class _How(TypedDict):
    """How buildings are drawn and written."""

    seed: int
    jobs: int
    track: Callable[[Sequence[str]], Iterator[str]]


def _generate_parts(
    model: TypeModel,
    count: int,
    out: Path,
    options: _Options,
    *,
    flags: BatchFlags,
    drawing: _Drawing,
    quiet: bool,
) -> None:
    """Generate many buildings in parts; print their sizes, and how many are copies."""
    parts = run_batch(
        lambda bar: generate_batch(
            model, count, out=out, progress=bar.move, track=bar.track, **drawing.arguments, **flags.arguments, **options
        ),
        GENERATED,
        lambda part: [f"{part.folder}: {_describe_numbers(part.description['rooms'])}"],
        quiet=quiet,
    )
    described = [part.description for part in parts if part.description]
    if described and not quiet:
        sizes = list(chain.from_iterable(part["rooms"] for part in described))
        copies = sum(sum(part["copies"]) for part in described)
        _print_counts(sizes, model, copies=copies, repeats=count_repeats(parts))
        print_result(f"in {out}: part-*, each with {drawing.list_files()}")
    exit_if_any_failed(parts)


def read_range(text: str) -> tuple[int, int]:
    """The numbers of N or N-M.

    Raises OptionError for anything else.
    """
    match = re.fullmatch(r"\s*(\d{1,6})\s*(?:-\s*(\d{1,6})\s*)?", text, re.ASCII)
    if match is None:
        raise OptionError(f"--rooms is {short_repr(text)}, give a number such as 40, or two such as 30-50")
    return int(match[1]), int(match[2] or match[1])


def _read_numbers(texts: Sequence[str], option: str, *, default: int | None = None) -> Mapping[str, int]:
    """Label -> number of LABEL=N, or of LABEL alone if there is a default."""
    numbers: dict[str, int] = {}
    for text in texts:
        label, equals, number = text.partition("=")
        if (not equals and default is None) or (equals and not re.fullmatch(r"\d{1,6}", number.strip(), re.ASCII)):
            raise OptionError(f"{option} is {short_repr(text)}, give a label and a number such as CLASSROOM=12")
        key = label.strip().upper()
        if key in numbers:
            raise OptionError(f"{option} gives {key} twice, leave one out")
        numbers[key] = int(number) if equals else int(default or 0)
    return numbers


def _print_buildings(buildings: Sequence[nx.Graph], model: TypeModel, out: Path, files: str) -> None:
    """Print the sizes of the buildings beside those of the model's floors, how many are copies, and where they are."""
    from pianta.evaluation.graph_sets import find_copies, find_repeats

    copies = sum(find_copies(buildings, [floor.graph for floor in model.floors]))
    _print_counts(list(map(len, buildings)), model, copies=copies, repeats=sum(find_repeats(buildings)))
    print_result(f"in {out}: {files}")


def _print_counts(sizes: Sequence[int], model: TypeModel, *, copies: int, repeats: int) -> None:
    total = f"{count_noun(len(sizes), 'building')} of type {model.building_type}"
    floors = [len(floor.graph) for floor in model.floors]
    print_result(f"{total}, {_describe_sizes(sizes)}; the {len(floors)} of the model {_describe_sizes(floors)}")
    print_result(f"copies of a floor of the model: {copies}; of another new building: {repeats}")


def _describe_numbers(sizes: Sequence[int]) -> str:
    return f"{count_noun(len(sizes), 'building')}, {_describe_sizes(sizes)}"


def _describe_sizes(sizes: Sequence[int]) -> str:
    if min(sizes) == max(sizes):
        return count_noun(min(sizes), "room") + (" each" if len(sizes) > 1 else "")
    return f"{min(sizes)} to {max(sizes)} rooms, {sum(sizes) / len(sizes):.1f} on average"
