"""AnnotatedFloor: a floor that was drawn and labelled by hand, its building, and the building's type."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from pianta._types import Floats
from pianta.errors import BuildingWarning, PiantaError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._files import one_line_reason
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.labels import LabelSet, schema_of
from pianta.rooms.thesis_features import compute_room_features
from pianta_bench.data.building_of import building_of
from pianta_bench.data.folders import list_maps
from pianta_bench.harness.records import Item

KINDS = ("school", "office")

Prepared = TypeVar("Prepared")


@dataclass(frozen=True, eq=False)
class AnnotatedFloor:
    """A floor as its file has it.

    item: name of its file. kind: the building type: school, office or house. building: all floors of one building are
    left out of a training together; such as school/plans.
    """

    item: str
    kind: str
    building: str
    floor: Floor

    @cached_property
    def features(self) -> Floats:
        """V_n of its rooms, shape (rooms, 11)."""
        return compute_room_features(self.floor)

    @cached_property
    def unlabelled(self) -> Floor:
        """The floor as input of a model: without labels of rooms and without a building type."""
        rooms = tuple(replace(room, label=None, labels={}, label_probabilities={}) for room in self.floor.rooms)
        return replace(self.floor, rooms=rooms, building_type={})


def read_annotated_floors(data: Path) -> tuple[list[AnnotatedFloor], dict[str, tuple[Item, ...]]]:
    """The floors of data/buildings/school and data/buildings/office; and by type the files that cannot be read.

    The floors have a building type, and their rooms labels of its schema.
    Raises DataError when there are no floors of a type.
    """

    def set_type(annotated: AnnotatedFloor) -> AnnotatedFloor:
        return replace(annotated, floor=set_building_type(annotated.floor, annotated.kind))

    floors, failed = [], {}
    for building_type in KINDS:
        typed, failed[building_type] = read_annotated_buildings(data, building_type, set_type)
        floors += typed
    return floors, failed


def read_annotated_buildings(
    data: Path, building_type: str, prepare: Callable[[AnnotatedFloor], Prepared]
) -> tuple[list[Prepared], tuple[Item, ...]]:
    """What `prepare` returns for each drawing of data/buildings/TYPE; and the drawings that failed, with the reason.

    prepare: raises PiantaError for a drawing that fails.
    Raises DataError if there are no drawings, or if manifest.json of the data cannot be used.
    """
    folder = data / "buildings" / building_type
    prepared, failed = [], []
    for item in list_maps(folder, ".xml"):
        building = building_of(data, f"buildings/{building_type}/{item}.xml")
        try:
            floor = read_drawing(folder / f"{item}.xml")
            prepared.append(prepare(AnnotatedFloor(item, building_type, f"{building_type}/{building}", floor)))
        except PiantaError as error:
            failed.append(Item(building_type, item, one_line_reason(error)))
    return prepared, tuple(failed)


def set_building_type(floor: Floor, building_type: str) -> Floor:
    """The floor with a building type that has the labels of all its rooms.

    Raises LabelError for labels that the type does not have.
    """
    schema_of(building_type).map_labels([room.label for room in floor.rooms], LabelSet.TYPE)
    return replace(floor, building_type={building_type: 1.0})


def read_drawing(file: Path, *, grid: GridMap | None = None) -> Floor:
    """A floor from a layout XML, as read_building_xml reads it.

    Warnings are not shown: hundreds of drawings have faults, and those with one sensible repair are repaired.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        return read_building_xml(file, grid=grid)
