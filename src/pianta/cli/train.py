"""The verb train: models of labelled buildings."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from functools import partial
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Annotated

import typer

from pianta.cli.terminal import Quiet, print_error, print_result, show_examples, track_items
from pianta.errors import BuildingWarning, LabelError, ModelError, OptionError, PiantaError
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.io._files import count_noun, one_line_reason, short_repr
from pianta.io._folders import check_output_file
from pianta.io.buildings._findings import DefectWarning
from pianta.labels import ALL_SCHEMAS, LabelSchema
from pianta.reading._labelling import check_type_name

if TYPE_CHECKING:
    from pianta.building_types.model import BuildingTypeModel, TypePrediction
    from pianta.generation.type_model import TypeModel
    from pianta.rooms.model import RoomModel

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

app = typer.Typer(no_args_is_help=True, help="Train models on labelled buildings.")

Buildings = Annotated[
    list[str], typer.Argument(metavar="BUILDING", help="Files of labelled buildings, or folders of them.")
]
Out = Annotated[Path, typer.Option("--out", "-o", help="File for the model; an older one is replaced.")]
Archive = Annotated[
    Path, typer.Option("--out", "-o", help="File for the model, which ends in .npz; an older one is replaced.")
]
Labels = Annotated[
    list[Path] | None, typer.Option(help="Label schema of another building type, YAML; may be repeated.")
]
Type = Annotated[
    str | None, typer.Option("--type", help="Building type of files that do not name theirs.", metavar="NAME")
]
Simulate = Annotated[int, typer.Option(min=0, max=20, help="Simulated robots' maps of each building to train on, too.")]
ListDefects = Annotated[
    bool, typer.Option("--list-defects", help="Print the defects of each drawing, not only how many have some.")
]
Seed = Annotated[int, typer.Option(min=0, help="Of the trees and of the simulation.")]
ChainSeed = Annotated[int, typer.Option(min=0, help="Of the chains that determine the iterations.")]
Areas = Annotated[
    str,
    typer.Option(help=f"How functional areas are found: {', '.join(SEGMENTATIONS)}; by corridors, or by cuts."),
]


@app.callback()
def describe() -> None:
    """Train models on labelled buildings."""


@app.command("places", epilog=show_examples(PLACES_EXAMPLES))
def train_places(
    buildings: Buildings,
    *,
    out: Archive,
    labels: Labels = None,
    building_type: Type = None,
    simulate: Simulate = 0,
    seed: Seed = 0,
    list_defects: ListDefects = False,
    quiet: Quiet = False,
) -> None:
    """Train a model of room labels, for `pianta read --model`.

    Reads layout XML, KTH XML, MIT XML and floor.geojson whose rooms have labels
    of the schema of their building type: school, office, house and hospital, and
    those given by --labels.

    Prints the error rate on buildings that were left out of the training. If a
    building cannot be read, the others are still used; the exit code is then 1.
    """
    from pianta.rooms import training
    from pianta.rooms.model_file import check_model_path, save_room_model

    if not out.is_dir():
        check_model_path(out)
    _check_options(out, building_type)
    schemas = _read_schemas(labels or ())
    floors, all_read = _read_floors(buildings, building_type, list_defects=list_defects, quiet=quiet)
    training.check_labels(floors, schemas)
    simulated = _simulate_readings(floors, maps=simulate, seed=seed, quiet=quiet)
    model = training.train_rooms(floors, simulated=simulated, schemas=schemas, seed=seed)
    _make_folder(out)
    save_room_model(model, out)
    if not quiet:
        _print_room_model(model, out)
    if not all_read:
        raise typer.Exit(1)


@app.command("buildings", epilog=show_examples(BUILDINGS_EXAMPLES))
def train_buildings(
    buildings: Buildings,
    *,
    out: Out,
    labels: Labels = None,
    building_type: Type = None,
    list_defects: ListDefects = False,
    quiet: Quiet = False,
) -> None:
    """Train a model of building types, for `pianta read --building-model`.

    Reads the same files as `pianta train places`, of two types of buildings or
    more, and at least two buildings of each type; dozens are better.

    Prints the error rate on buildings that were left out of the training. If a
    building cannot be read, the others are still used; the exit code is then 1.
    """
    from pianta.building_types import model as building_types
    from pianta.building_types.model_file import save_building_type_model

    _check_options(out, building_type)
    schemas = _read_schemas(labels or ())
    floors, all_read = _read_floors(buildings, building_type, list_defects=list_defects, quiet=quiet)
    model = building_types.train_building_types(floors, schemas=schemas)
    _make_folder(out)
    save_building_type_model(model, out)
    if not quiet:
        _print_building_model(model, building_types.predict_held_out(model), out)
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
    list_defects: ListDefects = False,
    quiet: Quiet = False,
) -> None:
    """Train a model of one type of buildings, for `pianta generate`.

    Reads the same files as `pianta train places`, all of one type. Learns which
    groups of rooms the floors have, which groups are similar, and how they are
    joined. Two floors are the minimum; dozens are better.

    Rooms without a door do not count. A floor that cannot be read, that has rooms
    without a label, or whose doors do not connect all rooms is left out; the exit
    code is then 1.
    """
    from pianta.generation import train as training

    _check_options(out, building_type)
    if areas not in SEGMENTATIONS:
        raise OptionError(f"areas is {areas!r}, give one of {', '.join(SEGMENTATIONS)}")
    schemas = _read_schemas(labels or ())
    floors, all_read = _read_floors(buildings, building_type, list_defects=list_defects, quiet=quiet)
    schema = training.choose_schema(floors, schemas)
    usable, all_usable = _list_usable(floors, schema)
    track = partial(track_items, quiet=quiet)
    model = training.train_type(usable, schema=schema, areas=areas, seed=seed, track=track)
    _make_folder(out)
    model.save(out)
    if not quiet:
        _print_type_model(model, out)
    if not (all_read and all_usable):
        raise typer.Exit(1)


def _read_schemas(paths: Iterable[Path]) -> Mapping[str, LabelSchema]:
    """The included schemas and those of files, by building type; a schema of a file replaces an included one.

    Raises LabelError for a file without a valid schema, and for two files of one type.
    """
    from pianta.io.label_schemas import read_label_schema

    schemas: dict[str, LabelSchema] = {}
    for path in paths:
        schema = read_label_schema(path)
        if schema.building_type in schemas:
            raise LabelError(f"two schemas of building type {schema.building_type!r} are given, leave one out")
        schemas[schema.building_type] = schema
    return {**ALL_SCHEMAS, **schemas}


def _simulate_readings(floors: Sequence[Floor], *, maps: int, seed: int, quiet: bool) -> list[Floor]:
    """Floors as read from a number of simulated maps of each floor; maps without any room are left out."""
    from pianta.worlds.simulated_readings import simulate_and_reconstruct

    runs = [*floors] * maps
    readings = []
    names = track_items([floor.source for floor in runs], quiet=quiet)
    for number, (floor, _) in enumerate(zip(runs, names, strict=True)):
        try:
            readings.append(simulate_and_reconstruct(floor, seed=seed + number))
        except PiantaError as error:
            message = f"a simulated map of building {short_repr(floor.source)} is left out: {error}"
            warnings.warn(BuildingWarning(message), stacklevel=2)
    return readings


def _check_options(out: Path, building_type: str | None) -> None:
    """Raise OptionError, before any work, for an unwritable model file and for an invalid building type."""
    if building_type is not None:
        check_type_name(building_type)
    check_output_file(out, "model file")


def _make_folder(out: Path) -> None:
    """Make the folder of the model file, once there is a model: bad buildings must not leave an empty folder.

    Raises OptionError, in one line.
    """
    try:
        out.parent.mkdir(parents=True, exist_ok=True)
    except OSError as exception:
        raise OptionError(f"folder {short_repr(out.parent)} cannot be made: {one_line_reason(exception)}") from None


def _read_floors(
    paths: Sequence[str], building_type: str | None, *, list_defects: bool, quiet: bool
) -> tuple[list[Floor], bool]:
    """The floors of files and folders with their types, and whether all could be read.

    Errors are printed, unless there is a single file. A predicted building type does not count: it may be wrong, and a
    model must not learn from predictions.
    list_defects: whether each floor with small defects has a warning.
    """
    from pianta.io.buildings.read import list_buildings, read_buildings

    files, floors = list_buildings(paths), []
    with nullcontext() if list_defects or len(files) == 1 else _counting_defects(len(files)):
        for _, result in read_buildings(files, track=partial(track_items, quiet=quiet)):
            if isinstance(result, Floor):
                type_name = result.given_type or building_type
                floors.append(replace(result, building_type={type_name: 1.0} if type_name else {}))
            elif len(files) == 1:
                raise result
            else:
                print_error(result)
    if not floors:
        raise ModelError(f"none of {len(files)} buildings could be read, so there is nothing to train on")
    return floors, len(floors) == len(files)


@contextmanager
def _counting_defects(total: int) -> Iterator[None]:
    """A block of whose warnings of small defects, in some of a total of drawings, a single one is issued."""
    caught: list[warnings.WarningMessage] = []
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield
    finally:
        defects = [each.message for each in caught if isinstance(each.message, DefectWarning)]
        for each in caught:
            if not isinstance(each.message, DefectWarning):
                warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)
        if defects:
            warnings.warn(BuildingWarning(_describe_defects(defects, total)), stacklevel=3)


def _describe_defects(defects: Sequence[DefectWarning], total: int) -> str:
    """What was repaired in drawings, and what stays."""
    repairs, remarks = sum(each.repairs for each in defects), sum(each.remarks for each in defects)
    parts = [f"{repairs} repaired (outlines that meet themselves, doors without a position)"] if repairs else []
    parts += [f"{remarks} that stay (rooms that overlap, are tiny, or have no door)"] if remarks else []
    described = " and ".join(parts)
    return f"{len(defects)} of {total} buildings have small defects, {described}; --list-defects prints them"


def _list_usable(floors: Sequence[Floor], schema: LabelSchema) -> tuple[list[Floor], bool]:
    """The floors that a model can use, and whether that are all; the faults of the others are printed."""
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
        total = f"{len(usable)} of {len(floors)} can be used"
        raise ModelError(f"a model takes two floors at least, better dozens, and {total}{rest}")
    for fault in faults:
        print_error(ModelError(fault))
    return usable, not faults


def _print_type_model(model: TypeModel, out: Path) -> None:
    """Print the size of a model, and the lengths of its chains."""
    sizes = sorted(int((model.clusters == cluster).sum()) for cluster in range(model.configurations.shape[1]))
    print_result(f"trained on {model} of {sizes[0]} to {sizes[-1]}, type {model.building_type}")
    if mixing := model.mixing:
        chains = {"sweeps": mixing.sweeps, "moves of edges": mixing.edge_moves, "moves of doors": mixing.door_moves}
        lengths = ", ".join(f"{chain.iterations} {name} ({chain.convergence:.2f})" for name, chain in chains.items())
        print_result(f"iterations of the chains, and the highest R-hat of their targets: {lengths}")
        if unmixed := ", ".join(name for name, chain in chains.items() if not chain.has_mixed):
            print_result(f"the chains of {unmixed} did not mix, R-hat stays at 1.1 or above: give more buildings")
    _print_file(out)
    print_result(f"next: pianta generate {quote(str(out))} -n 24 -o {quote(str(out.with_suffix('')) + '-buildings')}")


def _print_room_model(model: RoomModel, out: Path) -> None:
    errors = ", ".join(f"{error:.1%} in {labels}" for labels, error in model.training.errors.items())
    print_result(f"trained on {model.training}")
    print_result(f"wrong labels on buildings left out: {errors}")
    _print_file(out)


def _print_building_model(model: BuildingTypeModel, held_out: Sequence[TypePrediction], out: Path) -> None:
    """Print the size of a model, and its error rate.

    held_out: the prediction for each training floor, by the model without its building.
    """
    counts = []
    for name in model.building_types:
        buildings = [building for building, other in zip(model.buildings, model.types, strict=True) if other == name]
        sizes = count_noun(len(buildings), "floor"), count_noun(len(set(buildings)), "building")
        counts.append(f"{' of '.join(sizes)} of type {name}")
    total = len(model.training_floors)
    wrong = sum(each.likeliest != true for each, true in zip(held_out, model.types, strict=True))
    unknown = sum(not prediction.is_known for prediction in held_out)
    wrong_by_commonest = total - max(model.types.count(name) for name in model.building_types)
    print_result(f"trained on {count_noun(total, 'floor')}: {', '.join(counts)}")
    print_result(f"wrong types of floors whose building was left out: {wrong} of {total}, {wrong / total:.1%}")
    if wrong >= wrong_by_commonest:
        print_result(
            f"always the commonest type would be wrong on {wrong_by_commonest}: the buildings are too few, or too "
            "similar; give more"
        )
    print_result(f"called unknown when left out: {unknown} of {total}, {unknown / total:.1%}")
    _print_file(out)


def _print_file(out: Path) -> None:
    print_result(f"in {out}, {out.stat().st_size / 2**10:.0f} KB")
