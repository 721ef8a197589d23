"""BuildingFloor: a labelled floor with the inputs of all models of bench buildings, from the data or from folders."""

from __future__ import annotations

import warnings
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
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
from pianta_bench.harness.records import Item
from pianta_bench.types.room_sets import USER_SCHEMA

MIN_BUILDINGS = 3  # of each type: one is left out, one more is used for calibration, and one for training


@dataclass(frozen=True, eq=False)
class BuildingFloor:
    """A floor whose rooms have labels.

    labels: of its rooms, by label set. facts: of its rooms, without labels. descriptions: by label set.
    """

    annotated: AnnotatedFloor
    labels: Mapping[LabelSet, tuple[str, ...]]
    facts: Interpretation
    descriptions: Mapping[LabelSet, BuildingDescription]

    @cached_property
    def labelled_facts(self) -> Mapping[LabelSet, Interpretation]:
        """The facts with the labels of a set."""
        rooms = self.facts.entities(ROOM)
        labelled = {}
        for label_set, labels in self.labels.items():
            facts = [Fact(LABEL.name, (room, label_atom(label))) for room, label in zip(rooms, labels, strict=True)]
            labelled[label_set] = replace(self.facts, facts=self.facts.facts + tuple(facts))
        return labelled


def prepare_floor(annotated: AnnotatedFloor, schema: LabelSchema, convention: LabelConvention) -> BuildingFloor:
    """The floor as all models use it.

    Raises LabelError for labels that the schema does not have, and for a floor without rooms.
    """
    floor = map_labels_upwards(annotated.floor, schema, convention=convention)
    labels = {label_set: tuple(room.labels[str(label_set)] for room in floor.rooms) for label_set in LABELS}
    descriptions = {label_set: describe_building(floor, label_set) for label_set in LABELS}
    facts = interpret_floor(annotated.unlabelled, relations=ROOM_RELATIONS, label_set=None, name=annotated.item)
    return BuildingFloor(annotated, labels, facts, descriptions)


def read_building_floors(data: Path, *, convention: LabelConvention) -> tuple[list[BuildingFloor], list[Item]]:
    """The schools and offices of the data, and those that could not be read.

    Raises DataError if there are no floors of a type, or too few buildings.
    """

    def prepare(annotated: AnnotatedFloor) -> BuildingFloor:
        typed = replace(annotated, floor=set_building_type(annotated.floor, annotated.kind))
        return prepare_floor(typed, SCHEMAS[annotated.kind], convention)

    floors, failed = [], []
    for building_type in KINDS:
        read, rows = read_annotated_buildings(data, building_type, prepare)
        floors += read
        failed += [Item(f"{building_type}s", row.item, row.failure) for row in rows]
    _check_buildings(floors, KINDS, failed)
    return floors, failed


def read_type_folders(
    folders: Sequence[Path], *, convention: LabelConvention
) -> tuple[list[BuildingFloor], list[Item]]:
    """The floors of folders, each of one building type, and those that could not be read.

    The type is that of the schema labels.yaml in the folder; else that of the file; else the name of the folder. Floors
    in one subfolder are of one building; for others building_name decides. If that makes all floors of a type one
    building, each of them is a building instead.
    Raises OptionError for a path that is no folder, or a folder whose name is no type; DataError for fewer than two
    types or too few buildings of one; and the errors of list_buildings and read_label_schema.
    """
    floors: list[BuildingFloor] = []
    failed: list[Item] = []
    types: dict[str, None] = {}
    for folder in folders:
        if not folder.is_dir():
            raise OptionError(f"{short_repr(folder)} is no folder, give a folder of buildings for each building type")
        schema = _read_schema(folder)
        building_type = schema.building_type if schema else _folder_type(folder)
        read = []
        for file in list_buildings([folder]):
            try:
                annotated, file_schema = _read_annotated(file, folder, building_type, schema)
                read.append(prepare_floor(annotated, file_schema, convention))
            except PiantaError as error:
                failed.append(Item(short_repr(folder), _item_name(file, folder), one_line_reason(error)))
        types |= dict.fromkeys([floor.annotated.kind for floor in read] or [building_type])
        floors += read
    floors = _divide_buildings(floors)
    if len(types) < 2:
        raise DataError(f"all buildings are of type {next(iter(types), '')!r}, give folders of two types at least")
    _check_buildings(floors, tuple(types), failed)
    return floors, failed


def _read_schema(folder: Path) -> LabelSchema | None:
    """The schema in a folder, if there is one."""
    file = folder / USER_SCHEMA
    return read_label_schema(file) if file.is_file() else None


def _folder_type(folder: Path) -> str:
    """The building type that a folder is named after."""
    try:
        return standard_building_type(folder.resolve().name)
    except LabelError as error:
        raise OptionError(
            f"the name of folder {short_repr(folder)} is no building type: {error}, or give {USER_SCHEMA} in the folder"
        ) from error


def _read_annotated(
    file: Path, folder: Path, building_type: str, schema: LabelSchema | None
) -> tuple[AnnotatedFloor, LabelSchema]:
    """The floor of a file in the folder of a type, and its schema. schema: that of the folder, if there is one."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        floor = read_building(file)
    if schema is None:
        building_type = floor.given_type or building_type
        if building_type not in SCHEMAS:
            raise LabelError(
                f"there is no schema of building type {building_type!r}, give one as {USER_SCHEMA} in the folder, "
                f"or a folder whose name is one of {', '.join(SCHEMAS)}"
            )
        schema = SCHEMAS[building_type]
    inside = file.relative_to(folder)
    building = building_name(file.name) if inside.parent == Path() else inside.parent.as_posix()
    typed = replace(floor, building_type={building_type: 1.0})
    return AnnotatedFloor(_item_name(file, folder), building_type, f"{building_type}/{building}", typed), schema


def _item_name(file: Path, folder: Path) -> str:
    return file.relative_to(folder).with_suffix("").as_posix()


def _divide_buildings(floors: Sequence[BuildingFloor]) -> list[BuildingFloor]:
    """The floors; if all floors of a type have one building by their names, each becomes a building of its own."""
    buildings = _group_buildings(floors)
    return [
        replace(floor, annotated=replace(annotated, building=f"{annotated.kind}/{annotated.item}"))
        if len(buildings[annotated.kind]) == 1 and "/" not in annotated.item
        else floor
        for floor in floors
        for annotated in [floor.annotated]
    ]


def _check_buildings(floors: Sequence[BuildingFloor], types: Sequence[str], failed: Sequence[Item]) -> None:
    """Raise DataError if a type has fewer than MIN_BUILDINGS buildings."""
    counts = {name: len(_group_buildings(floors)[name]) for name in types}
    few = [
        f"{name} has {count} building{'s' * (count != 1)}" for name, count in counts.items() if count < MIN_BUILDINGS
    ]
    if few:
        reasons = [f"{item.item} failed: {item.failure}" for item in failed]
        reasons = reasons[:1] + [f"{len(failed) - 1} more failed"] * (len(failed) > 1)
        failures = f" ({'; '.join(reasons)})" if reasons else ""
        raise DataError(f"{join_faults(few)}, give {MIN_BUILDINGS} of each type at least{failures}")


def _group_buildings(floors: Sequence[BuildingFloor]) -> Mapping[str, set[str]]:
    """The names of the buildings of each type."""
    buildings: defaultdict[str, set[str]] = defaultdict(set)
    for floor in floors:
        buildings[floor.annotated.kind].add(floor.annotated.building)
    return buildings
