"""BuildingFloor: a labelled floor as all the models of bench buildings see it, from the data or from folders."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

from pianta.building_types.description import BuildingDescription, describe_building
from pianta.errors import BuildingWarning, DataError, LabelError, OptionError, PiantaError
from pianta.io._faults import join_faults
from pianta.io._files import one_line_reason, short_repr
from pianta.io.buildings.read import list_buildings, read_building
from pianta.io.label_schemas import read_label_schema
from pianta.labels import SCHEMAS, LabelConvention, LabelSchema, LabelSet, standard_building_type
from pianta.relational.facts import Fact, Interpretation
from pianta.relational.interpretation import LABEL, ROOM, interpret_floor, label_atom
from pianta.relational.kernels import ROOM_RELATIONS
from pianta.rooms.completion import LABELS, map_labels_upwards
from pianta.rooms.training import building_name
from pianta_bench.data.annotated_floors import KINDS, AnnotatedFloor, read_annotated_buildings, set_building_type
from pianta_bench.harness.table import Row
from pianta_bench.types.room_sets import USER_SCHEMA

# A building is left out, and another of those that are left is left out to calibrate.
LEAST_BUILDINGS = 3

Failed = Mapping[str, tuple[Row, ...]]


@dataclass(frozen=True, eq=False)
class BuildingFloor:
    """A floor whose rooms have labels.

    labels: of its rooms, by label set. facts: of its rooms, without labels. descriptions: by label set.
    """

    drawn: AnnotatedFloor
    labels: Mapping[LabelSet, tuple[str, ...]]
    facts: Interpretation
    descriptions: Mapping[LabelSet, BuildingDescription]

    @cached_property
    def told(self) -> Mapping[LabelSet, Interpretation]:
        """The facts with the labels of a set."""
        rooms = self.facts.entities(ROOM)
        return {
            label_set: replace(
                self.facts,
                facts=self.facts.facts
                + tuple(Fact(LABEL.name, (room, label_atom(label))) for room, label in zip(rooms, labels, strict=True)),
            )
            for label_set, labels in self.labels.items()
        }


def prepare_floor(drawn: AnnotatedFloor, schema: LabelSchema, split: LabelConvention) -> BuildingFloor:
    """The floor as all models see it.

    Raises LabelError for labels that the schema does not have, and for a floor without rooms.
    """
    floor = map_labels_upwards(drawn.floor, schema, convention=split)
    labels = {label_set: tuple(room.labels[str(label_set)] for room in floor.rooms) for label_set in LABELS}
    descriptions = {label_set: describe_building(floor, label_set) for label_set in LABELS}
    facts = interpret_floor(drawn.unlabelled, relations=ROOM_RELATIONS, label_set=None, name=drawn.item)
    return BuildingFloor(drawn, labels, facts, descriptions)


def read_building_floors(data: Path, *, split: LabelConvention) -> tuple[list[BuildingFloor], Failed]:
    """The schools and offices of the data, and by type those that could not be read.

    Raises DataError when there are no floors of a type, or too few buildings.
    """

    def prepare(drawn: AnnotatedFloor) -> BuildingFloor:
        typed = replace(drawn, floor=set_building_type(drawn.floor, drawn.kind))
        return prepare_floor(typed, SCHEMAS[drawn.kind], split)

    floors, failed = [], {}
    for kind in KINDS:
        of_kind, failed[f"{kind}s"] = read_annotated_buildings(data, kind, prepare)
        floors += of_kind
    _check_buildings(floors, KINDS, failed)
    return floors, failed


def read_type_folders(folders: Sequence[Path], *, split: LabelConvention) -> tuple[list[BuildingFloor], Failed]:
    """The floors of folders, each of one building type, and by folder those that could not be read.

    The type is that of the schema labels.yaml in the folder; else what the file tells; else the folder's name. Floors
    in one subfolder are of one building; others by building_name, and where that were one building only, each is one.
    Raises OptionError for what is no folder, and a folder whose name is no type; DataError for fewer than two types and
    too few buildings of one; what list_buildings and read_label_schema raise.
    """
    floors: list[BuildingFloor] = []
    failed: dict[str, tuple[Row, ...]] = {}
    kinds: dict[str, None] = {}
    for folder in folders:
        if not folder.is_dir():
            raise OptionError(f"{short_repr(folder)} is no folder, give a folder of buildings for each building type")
        schema = _read_schema(folder)
        kind = schema.building_type if schema else _name_type(folder)
        prepare = partial(_prepare_file, folder=folder, kind=kind, schema=schema, split=split)
        read, failed[short_repr(folder)] = _read_files(list_buildings([folder]), folder, prepare)
        kinds |= dict.fromkeys([floor.drawn.kind for floor in read] or [kind])
        floors += read
    floors = _divide_buildings(floors)
    if len(kinds) < 2:
        raise DataError(f"all buildings are of type {next(iter(kinds), '')!r}, give folders of two types at least")
    _check_buildings(floors, tuple(kinds), failed)
    return floors, failed


def _read_schema(folder: Path) -> LabelSchema | None:
    """The schema in a folder, if there is one."""
    file = folder / USER_SCHEMA
    return read_label_schema(file) if file.is_file() else None


def _name_type(folder: Path) -> str:
    """The building type that the name of a folder is."""
    try:
        return standard_building_type(folder.resolve().name)
    except LabelError as error:
        raise OptionError(
            f"the name of folder {short_repr(folder)} is no building type: {error}, or give {USER_SCHEMA} in the folder"
        ) from error


def _read_files(
    files: Sequence[Path], folder: Path, prepare: partial[BuildingFloor]
) -> tuple[list[BuildingFloor], tuple[Row, ...]]:
    read, failed = [], []
    for file in files:
        try:
            read.append(prepare(file))
        except PiantaError as error:
            failed.append(Row(_name_item(file, folder), {}, one_line_reason(error)))
    return read, tuple(failed)


def _prepare_file(
    file: Path, *, folder: Path, kind: str, schema: LabelSchema | None, split: LabelConvention
) -> BuildingFloor:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        floor = read_building(file)
    if schema is None:
        kind = floor.given_type or kind
        if kind not in SCHEMAS:
            raise LabelError(
                f"there is no schema of building type {kind!r}, give one as {USER_SCHEMA} in the folder, "
                f"or a folder whose name is one of {', '.join(SCHEMAS)}"
            )
        schema = SCHEMAS[kind]
    item = _name_item(file, folder)
    building = f"{kind}/{_name_building(file.relative_to(folder))}"
    drawn = AnnotatedFloor(item, kind, building, replace(floor, building_type={kind: 1.0}))
    return prepare_floor(drawn, schema, split)


def _name_building(file: Path) -> str:
    """The subfolder that a file of a type's folder is in; else what building_name tells of its name."""
    return building_name(file.name) if file.parent == Path() else file.parent.as_posix()


def _name_item(file: Path, folder: Path) -> str:
    return file.relative_to(folder).with_suffix("").as_posix()


def _divide_buildings(floors: Sequence[BuildingFloor]) -> list[BuildingFloor]:
    """The floors, each a building of its own where all of a type would be one by their names."""
    of_type: dict[str, set[str]] = {}
    for floor in floors:
        of_type.setdefault(floor.drawn.kind, set()).add(floor.drawn.building)
    return [
        replace(floor, drawn=replace(floor.drawn, building=f"{floor.drawn.kind}/{floor.drawn.item}"))
        if len(of_type[floor.drawn.kind]) == 1 and "/" not in floor.drawn.item
        else floor
        for floor in floors
    ]


def _check_buildings(floors: Sequence[BuildingFloor], kinds: Sequence[str], failed: Failed) -> None:
    counts = {kind: len({floor.drawn.building for floor in floors if floor.drawn.kind == kind}) for kind in kinds}
    few = [
        f"{kind} has {count} building{'s' * (count != 1)}" for kind, count in counts.items() if count < LEAST_BUILDINGS
    ]
    if few:
        reasons = [f"{row.item} failed: {row.failure}" for rows in failed.values() for row in rows]
        told = f" ({reasons[0]}{f'; {len(reasons) - 1} more failed' if len(reasons) > 1 else ''})" if reasons else ""
        raise DataError(f"{join_faults(few)}, give {LEAST_BUILDINGS} of each type at least{told}")
