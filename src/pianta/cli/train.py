"""The verb train: models from buildings that people have labelled."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from pianta.cli.terminal import show_examples, tell_error, tell_result, track_items
from pianta.errors import BuildingWarning, LabelError, ModelError, OptionError, PiantaError
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.io._files import one_line_reason, short_repr
from pianta.io._folders import check_output_folder
from pianta.labels import SCHEMAS, LabelSchema
from pianta.reading._labelling import check_type_name

if TYPE_CHECKING:
    from pianta.building_types.model import BuildingModel, Verdict
    from pianta.generation.type_model import TypeModel
    from pianta.rooms.model import PlaceModel

SEGMENTATIONS = ("corr", "ncut")
PLACES_EXAMPLES = (
    "pianta train places buildings/school buildings/office -o places.npz",
    "pianta train places wards --labels hospital.yaml --type hospital -o hospital.npz",
    "pianta read map.yaml --model hospital.npz --type hospital -o building",
)
BUILDINGS_EXAMPLES = (
    "pianta train buildings buildings/school buildings/office -o types.json",
    "pianta train buildings buildings/school wards --labels hospital.yaml --type hospital -o types.json",
    "pianta read map.yaml --building-model types.json -o building",
)

TYPE_EXAMPLES = (
    "pianta train type buildings/school -o school.json",
    "pianta train type wards --labels hospital.yaml --type hospital --areas ncut -o hospital.json",
    "pianta generate school.json -n 24 -o schools",
)

app = typer.Typer(no_args_is_help=True, help="Train models on buildings that people have labelled.")

Buildings = Annotated[
    list[str], typer.Argument(metavar="BUILDING", help="Files of labelled buildings, or folders of them.")
]
Out = Annotated[Path, typer.Option("--out", "-o", help="File for the model; an older one is replaced.")]
Archive = Annotated[
    Path, typer.Option("--out", "-o", help="File for the model, which ends in .npz; an older one is replaced.")
]
Labels = Annotated[
    list[Path] | None, typer.Option(help="Label schema of a building type of yours, YAML; may be repeated.")
]
Type = Annotated[
    str | None, typer.Option("--type", help="Building type of the files that do not tell theirs.", metavar="NAME")
]
Simulate = Annotated[
    int, typer.Option(min=0, max=20, help="Simulated robot's maps of each building to learn from as well.")
]
Seed = Annotated[int, typer.Option(min=0, help="Of the trees and the simulation.")]
ChainSeed = Annotated[int, typer.Option(min=0, help="Of the chains by which iterations are counted.")]
Areas = Annotated[
    str,
    typer.Option(help=f"How functional areas are found: {', '.join(SEGMENTATIONS)}; by corridors, or where cuts are."),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but warnings and errors.")]


@app.callback()
def describe() -> None:
    """Train models on buildings that people have labelled."""


@app.command("places", epilog=show_examples(PLACES_EXAMPLES))
def train_places(
    buildings: Buildings,
    *,
    out: Archive,
    labels: Labels = None,
    building_type: Type = None,
    simulate: Simulate = 0,
    seed: Seed = 0,
    quiet: Quiet = False,
) -> None:
    """Train a model of what rooms are for, for `pianta read --model`.

    Takes layout XML, KTH XML, MIT XML and floor.geojson whose rooms have labels of the
    schema of their building type: school and office, and those given by --labels.

    Tells how often the model is wrong on buildings that were left out. A building
    that cannot be read does not stop the others; the exit code is then 1.
    """
    from pianta.rooms import training
    from pianta.rooms.model_file import check_model_path, save_place_model

    if not out.is_dir():
        check_model_path(out)
    _check_options(out, building_type)
    schemas = read_schemas(labels or ())
    floors, all_read = _read_floors(buildings, building_type, quiet=quiet)
    training.check_labels(floors, schemas)
    simulated = simulate_readings(floors, maps=simulate, seed=seed, quiet=quiet)
    model = training.train_rooms(floors, simulated=simulated, schemas=schemas, seed=seed)
    save_place_model(model, out)
    if not quiet:
        _tell_model(model, out)
    if not all_read:
        raise typer.Exit(1)


@app.command("buildings", epilog=show_examples(BUILDINGS_EXAMPLES))
def train_buildings(
    buildings: Buildings,
    *,
    out: Out,
    labels: Labels = None,
    building_type: Type = None,
    quiet: Quiet = False,
) -> None:
    """Train a model of building types, for `pianta read --building-model`.

    Takes the same files as `pianta train places`, of two types of buildings or more,
    and of two buildings of each type at least; dozens are better.

    Tells how often the model is wrong on buildings that were left out. A building
    that cannot be read does not stop the others; the exit code is then 1.
    """
    from pianta.building_types import model as building_types
    from pianta.building_types.model_file import save_building_model

    _check_options(out, building_type)
    schemas = read_schemas(labels or ())
    floors, all_read = _read_floors(buildings, building_type, quiet=quiet)
    model = building_types.train_building_types(floors, schemas=schemas)
    save_building_model(model, out)
    if not quiet:
        _tell_building_model(model, building_types.judge_held_out(model), out)
    if not all_read:
        raise typer.Exit(1)


@app.command("type", epilog=show_examples(TYPE_EXAMPLES))
def train_type(
    buildings: Buildings,
    *,
    out: Out,
    labels: Labels = None,
    building_type: Type = None,
    areas: Areas = "corr",
    seed: ChainSeed = 0,
    quiet: Quiet = False,
) -> None:
    """Train a model of one type of buildings, for `pianta generate`.

    Takes the same files as `pianta train places`, all of one type. Learns which groups
    of rooms the floors have, which groups are alike, and how they are joined.
    Two floors are the least; dozens are better.

    Rooms without a door do not count. A floor that cannot be read, that has rooms
    without a label, or that doors leave in parts does not stop the others; the exit
    code is then 1.
    """
    from pianta.generation import train as training

    _check_options(out, building_type)
    if areas not in SEGMENTATIONS:
        raise OptionError(f"areas is {areas!r}, give one of {', '.join(SEGMENTATIONS)}")
    schemas = read_schemas(labels or ())
    floors, all_read = _read_floors(buildings, building_type, quiet=quiet)
    schema = training.choose_schema(floors, schemas)
    usable, all_usable = _list_usable(floors, schema)
    track = partial(track_items, quiet=quiet)
    model = training.train_type(usable, schema=schema, areas=areas, seed=seed, track=track)
    model.save(out)
    if not quiet:
        _tell_type_model(model, out)
    if not (all_read and all_usable):
        raise typer.Exit(1)


def read_schemas(paths: Iterable[Path]) -> Mapping[str, LabelSchema]:
    """The schemas that come with pianta and those of files, by building type; a file's replaces ours.

    Raises LabelError for a file that is none, and for two files of one type.
    """
    from pianta.io.label_schemas import read_label_schema

    given: dict[str, LabelSchema] = {}
    for path in paths:
        schema = read_label_schema(path)
        if schema.building_type in given:
            raise LabelError(f"two schemas of building type {schema.building_type!r} are given, leave one out")
        given[schema.building_type] = schema
    return {**SCHEMAS, **given}


def simulate_readings(floors: Sequence[Floor], *, maps: int, seed: int, quiet: bool = False) -> list[Floor]:
    """Floors as read from so many simulated maps of each; a map on which nothing is found gives none."""
    from pianta.worlds.simulated_readings import simulate_reading

    runs = [*floors] * maps
    found = []
    names = track_items([floor.source for floor in runs], quiet=quiet)
    for number, (floor, _) in enumerate(zip(runs, names, strict=True)):
        try:
            found.append(simulate_reading(floor, seed=seed + number))
        except PiantaError as error:
            message = f"building {short_repr(floor.source)} is not learned from in simulation: {error}"
            warnings.warn(BuildingWarning(message), stacklevel=2)
    return found


def _check_options(out: Path, building_type: str | None) -> None:
    """Refuse, before any work, a model file that cannot be written, and a type that has no name."""
    if building_type is not None:
        check_type_name(building_type)
    check_output_folder(out.parent)
    if out.is_dir():
        raise OptionError(f"model file {short_repr(out)} is a folder, give the name of a file")
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as exception:
        raise OptionError(f"folder {short_repr(out.parent)} cannot be made: {one_line_reason(exception)}") from None


def _read_floors(paths: Sequence[str], building_type: str | None, *, quiet: bool) -> tuple[list[Floor], bool]:
    """The floors of files and folders, their type filled in, and whether all could be read.

    What cannot be read is told and left out, unless nothing is left.

    A type that pianta has guessed is none: it may be wrong, and a model does not learn from what a model has said.
    """
    from pianta.io.buildings.read import list_buildings, name_sources, read_building

    files = list(map(str, list_buildings(paths)))
    floors = []
    for file, source in zip(track_items(files, quiet=quiet), name_sources(files), strict=True):
        try:
            floor = read_building(file)
        except PiantaError as error:
            if len(files) == 1:
                raise
            tell_error(error)
            continue
        kind = floor.given_type or building_type
        floors.append(replace(floor, source=source, building_type={kind: 1.0} if kind else {}))
    if not floors:
        raise ModelError(f"none of {len(files)} buildings could be read, so there is nothing to train on")
    return floors, len(floors) == len(files)


def _list_usable(floors: Sequence[Floor], schema: LabelSchema) -> tuple[list[Floor], bool]:
    """The floors that a model can take, and whether it can take all; the others are told."""
    from pianta.generation.type_model import MIN_FLOORS, prepare_room_graph

    usable, faults = [], []
    for floor in floors:
        try:
            prepare_room_graph(floor.graph(), schema)
            usable.append(floor)
        except PiantaError as error:
            faults.append(f"floor {short_repr(floor.source)} is left out: {error}")
    if len(usable) < MIN_FLOORS:
        rest = f": {join_faults(faults)}" if faults else ""
        raise ModelError(
            f"a model takes two floors at least, better dozens, and {len(usable)} of {len(floors)} can be used{rest}"
        )
    for fault in faults:
        tell_error(ModelError(fault))
    return usable, not faults


def _tell_type_model(model: TypeModel, out: Path) -> None:
    """Print what a model knows, and how long its chains are."""
    sizes = sorted(int((model.clusters == cluster).sum()) for cluster in range(model.configurations.shape[1]))
    tell_result(f"trained on {model} of {sizes[0]} to {sizes[-1]}, type {model.building_type}")
    mixing = model.mixing
    steps = (
        {"sweeps": mixing.sweeps, "moves of edges": mixing.edge_moves, "moves of doors": mixing.door_moves}
        if mixing
        else {}
    )
    told = ", ".join(f"{found.iterations} {name} ({found.convergence:.2f})" for name, found in steps.items())
    tell_result(f"iterations of the chains, and their R-hat: {told}")
    if slow := [name for name, found in steps.items() if not found.has_mixed]:
        tell_result(
            f"the chains of {', '.join(slow)} had not mixed by then, R-hat is 1.1 or above: give more buildings"
        )
    tell_result(f"in {out}, {out.stat().st_size / 2**10:.0f} KB")
    tell_result(f"next: pianta generate {quote(str(out))} -n 24 -o {quote(str(out.with_suffix('')) + '-buildings')}")


def _tell_model(model: PlaceModel, out: Path) -> None:
    errors = ", ".join(f"{error:.1%} in {labels}" for labels, error in model.training.errors.items())
    tell_result(f"trained on {model.training}")
    tell_result(f"wrong labels on buildings left out: {errors}")
    tell_result(f"in {out}, {out.stat().st_size / 2**20:.1f} MB")


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


def _tell_building_model(model: BuildingModel, held_out: Sequence[Verdict], out: Path) -> None:
    """Print what a model knows, and how right it is of each floor when it does not know its building.

    held_out: what is said of each floor that it knows, by the model of all other buildings.
    """
    counts = []
    for kind in model.building_types:
        names = [name for name, other in zip(model.buildings, model.types, strict=True) if other == kind]
        counts.append(f"{_count(len(names), 'floor')} of {_count(len(set(names)), 'building')} of type {kind}")
    floors = len(model.known)
    said = [verdict.likeliest for verdict in held_out]
    wrong = sum(kind != right for kind, right in zip(said, model.types, strict=True))
    unknown = sum(not verdict.known for verdict in held_out)
    guessed = floors - max(model.types.count(kind) for kind in model.building_types)
    tell_result(f"trained on {_count(floors, 'floor')}: {', '.join(counts)}")
    tell_result(f"wrong types of floors whose building was left out: {wrong} of {floors}, {wrong / floors:.1%}")
    if wrong >= guessed:
        tell_result(
            f"guessing the commonest type errs on {guessed}: they are too few, or too alike; give more buildings"
        )
    tell_result(f"called unknown when left out: {unknown} of {floors}, {unknown / floors:.1%}")
    tell_result(f"in {out}, {out.stat().st_size / 2**10:.0f} KB")
