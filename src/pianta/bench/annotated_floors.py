"""AnnotatedFloor: a floor that somebody drew and labelled, its building, and the building's type."""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta.bench.data import list_maps
from pianta.bench.table import Row
from pianta.errors import BuildingWarning, DataError, PiantaError
from pianta.floor import Floor
from pianta.formats.building_xml import read_building_xml
from pianta.formats.files import reason_of, shown
from pianta.graphs.features import compute_room_features
from pianta.gridmap import GridMap
from pianta.labels import LabelSet, schema_of

Floats = NDArray[np.float64]

KINDS = ("school", "office")


@dataclass(frozen=True, eq=False)
class AnnotatedFloor:
    """A floor whose rooms have labels of the schema of its type.

    item: name of its file. kind: school or office. building: what it must be left out with, such as school/plans.
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


def read_annotated_floors(data: Path) -> tuple[list[AnnotatedFloor], dict[str, tuple[Row, ...]]]:
    """The floors of data/buildings/school and data/buildings/office, and by type those that could not be read.

    Raises DataError when there are no floors of a type.
    """
    buildings = read_buildings_of_files(data)
    floors, failed = [], {}
    for kind in KINDS:
        folder = data / "buildings" / kind
        faults = []
        for item in list_maps(folder, ".xml"):
            building = buildings.get(f"buildings/{kind}/{item}.xml", item)
            try:
                floor = label_floor(read_drawing(folder / f"{item}.xml"), kind)
                floors.append(AnnotatedFloor(item, kind, f"{kind}/{building}", floor))
            except PiantaError as error:
                faults.append(Row(item, {}, reason_of(error)))
        failed[kind] = tuple(faults)
    return floors, failed


def label_floor(floor: Floor, kind: str) -> Floor:
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
        raise DataError(f"{shown(file)} is no list of files with `path` and `building`, repair or remove it") from None
