"""AnnotatedFloor: a floor that somebody drew and labelled, its building, and the building's type."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from pianta._types import Floats
from pianta.errors import BuildingWarning, DataError, PiantaError
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._files import one_line_reason, short_repr
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta.labels import LabelSet, schema_of
from pianta.rooms.thesis_features import compute_room_features
from pianta_bench.data.folders import list_maps
from pianta_bench.harness.records import Item

KINDS = ("school", "office")

Made = TypeVar("Made")


@dataclass(frozen=True, eq=False)
class AnnotatedFloor:
    """A floor as its file has it.

    item: name of its file. kind: school, office or house. building: what it must be left out with, such as
    school/plans.
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
        """The floor as a model may see it: nothing is said about rooms or building."""
        rooms = tuple(replace(room, label=None, labels={}, label_probabilities={}) for room in self.floor.rooms)
        return replace(self.floor, rooms=rooms, building_type={})


def read_annotated_floors(data: Path) -> tuple[list[AnnotatedFloor], dict[str, tuple[Item, ...]]]:
    """The floors of data/buildings/school and data/buildings/office, and by type those that could not be read.

    The floors have a building type, and their rooms labels of its schema.
    Raises DataError when there are no floors of a type.
    """

    def give_type(drawn: AnnotatedFloor) -> AnnotatedFloor:
        return replace(drawn, floor=set_building_type(drawn.floor, drawn.kind))

    floors, failed = [], {}
    for kind in KINDS:
        of_kind, failed[kind] = read_annotated_buildings(data, kind, give_type)
        floors += of_kind
    return floors, failed


def read_annotated_buildings(
    data: Path, kind: str, make: Callable[[AnnotatedFloor], Made]
) -> tuple[list[Made], tuple[Item, ...]]:
    """What is made of each drawing of data/buildings/KIND, and the drawings of which nothing can be made, with why.

    make: raises PiantaError for such a drawing.
    Raises DataError when there is no drawing, or when the data's list of files is none.
    """
    folder, buildings = data / "buildings" / kind, read_buildings_of_files(data)
    made, failed = [], []
    for item in list_maps(folder, ".xml"):
        building = buildings.get(f"buildings/{kind}/{item}.xml", item)
        try:
            made.append(make(AnnotatedFloor(item, kind, f"{kind}/{building}", read_drawing(folder / f"{item}.xml"))))
        except PiantaError as error:
            failed.append(Item(kind, item, one_line_reason(error)))
    return made, tuple(failed)


def set_building_type(floor: Floor, kind: str) -> Floor:
    """The floor with a type, once each of its rooms has a label of that type.

    Raises LabelError for labels that the type does not have.
    """
    schema_of(kind).map_labels([room.label for room in floor.rooms], LabelSet.TYPE)
    return replace(floor, building_type={kind: 1.0})


def read_drawing(file: Path, *, grid: GridMap | None = None) -> Floor:
    """A floor from a layout XML, as read_building_xml reads it.

    Warnings are not told: what has one sensible repair is repaired, and hundreds of drawings have some of it.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        return read_building_xml(file, grid=grid)


def read_buildings_of_files(data: Path) -> dict[str, str]:
    """The building of each file, by manifest.json of the data; nothing without it, when a file is a building.

    Raises DataError when that file is none.
    """
    file = data / "manifest.json"
    if not file.is_file():
        return {}
    try:
        return {record["path"]: record["building"] for record in json.loads(file.read_text(encoding="utf-8"))}
    except (OSError, ValueError, KeyError, TypeError):
        raise DataError(
            f"{short_repr(file)} is no list of files with `path` and `building`, repair or remove it"
        ) from None
