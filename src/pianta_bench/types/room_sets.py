"""RoomSet: the rooms of all buildings of a type, as chapter 4 represents them."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.errors import BuildingWarning, DataError, LabelError, OptionError, PiantaError
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.io._files import one_line_reason, short_repr
from pianta.io.buildings.read import list_buildings, read_building
from pianta.io.label_schemas import read_label_schema
from pianta.labels import HOUSE, GeneralLabel, LabelSchema, LabelSet, schema_of
from pianta.rooms.thesis_features import GENERAL_FEATURES, compute_general_features
from pianta_bench.data.annotated_floors import AnnotatedFloor, read_annotated_buildings
from pianta_bench.data.folders import REMEDY
from pianta_bench.harness.records import Item

Labels = NDArray[np.str_]

BUILDING_TYPES = ("house", "school", "office")
GENERAL_LABELS = tuple(str(label) for label in GeneralLabel)
CORRIDORS = (str(GeneralLabel.CORRIDOR), str(GeneralLabel.HALL))
USER_SCHEMA = "labels.yaml"
FEWEST_ROOMS = 10  # of a label, as many as there are folds


@dataclass(frozen=True)
class RoomSet:
    """Rooms of a type of building, or of several.

    name: House, School, Office, or the initials of several, such as S+O.
    geometry: area (m²), doorways, axes ratio, shape (rooms, 3).
    neighbours: how many of a room's doorways lead to rooms of each label of GENERAL_LABELS, shape (rooms, 5).
    labels: of L_general, shape (rooms,). buildings: the building of each room, shape (rooms,).
    names: number of rooms by label of L_general and label of the file.
    """

    name: str
    geometry: Floats
    neighbours: Floats
    labels: Labels
    buildings: Labels
    names: Mapping[tuple[str, str], int]

    @property
    def corridors(self) -> NDArray[np.bool_]:
        """Which rooms are CORRIDOR (C or H); the others are ROOM (section 4.3.1); shape (rooms,)."""
        return np.isin(self.labels, CORRIDORS)

    def with_neighbours(self) -> Floats:
        """Geometry and neighbours, shape (rooms, 8)."""
        return np.hstack([self.geometry, self.neighbours])


def read_room_sets(data: Path | None, *, houses: Path | None = None) -> tuple[tuple[RoomSet, ...], list[Item]]:
    """The sets of types that data/buildings has, and their union when there are several (section 4.2.3).

    Then the floors that failed, because they cannot be read or have labels that the schema does not have; their rooms
    are in no set.

    A house set is the user's: the folder `houses` with files of any format of read_building, or else
    data/buildings/house with layout XMLs. Labels are those of L_general, or of the schema labels.yaml in the folder, or
    of HOUSE. Rooms of `houses` without a label, such as the uncovered parts of HouseExpo's plans, are in no set.
    data: None for no other sets than houses.

    Raises DataError if there are no sets, or if one is too small to learn from; LabelError for an invalid schema;
    OptionError for houses that are no folder, and BuildingError for a folder without buildings.
    """
    sets: list[RoomSet] = []
    failed: list[Item] = []
    for name, folder in _list_type_folders(data, houses).items():
        represent = partial(_represent, _schema_of_folder(folder, name))
        rows: Sequence[Item]
        if folder == houses:
            floors, rows = _read_houses(folder, represent)
        elif data:
            floors, rows = read_annotated_buildings(data, name, represent)
        faults = [Item(f"{name}s", row.item, row.failure) for row in rows]
        _check_size(floors, faults, folder)
        failed += faults
        sets.append(join_room_sets(name.capitalize(), floors))
    if len(sets) > 1:
        sets.append(join_room_sets("+".join(rooms.name[0] for rooms in sets), sets))
    return tuple(sets), failed


def _list_type_folders(data: Path | None, houses: Path | None) -> dict[str, Path]:
    """The folder of each type; DataError without any."""
    if houses and not houses.is_dir():
        raise OptionError(f"--houses is {short_repr(houses)}, which is no folder, give a folder of houses")
    inside = {name: data / "buildings" / name for name in BUILDING_TYPES} if data else {}
    folders = inside | ({"house": houses} if houses else {})
    there = {name: folders[name] for name in BUILDING_TYPES if name in folders and folders[name].is_dir()}
    if not there:
        raise DataError(f"no buildings in any of {', '.join(map(short_repr, inside.values()))}, {REMEDY}")
    return there


def _read_houses(folder: Path, represent: Callable[[AnnotatedFloor], RoomSet]) -> tuple[list[RoomSet], list[Item]]:
    """The rooms of each house of a folder, and the houses that failed; floors in one subfolder are of one house."""
    floors, failed = [], []
    for file in list_buildings([folder]):
        parts = file.relative_to(folder).parts
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", BuildingWarning)
                floor = read_building(file)
            if not any(room.label for room in floor.rooms):
                raise LabelError("none of its rooms has a label, give labels")
            floors.append(represent(AnnotatedFloor(file.stem, "house", f"house/{parts[0]}", floor)))
        except PiantaError as error:
            failed.append(Item("house", "/".join(parts), one_line_reason(error)))
    return floors, failed


def join_room_sets(name: str, sets: Sequence[RoomSet]) -> RoomSet:
    """The union of sets."""
    return RoomSet(
        name,
        np.concatenate([rooms.geometry for rooms in sets]),
        np.concatenate([rooms.neighbours for rooms in sets]),
        np.concatenate([rooms.labels for rooms in sets]),
        np.concatenate([rooms.buildings for rooms in sets]),
        sum((Counter(rooms.names) for rooms in sets), Counter()),
    )


def name_sizes_by_area(rooms: RoomSet, bounds: tuple[float, float]) -> RoomSet:
    """The set with S, M and B by area: up to the first bound (m²), up to the second, above; C and H stay.

    The counts of neighbours' labels stay those of the files.
    """
    by_area = np.array([str(GeneralLabel.SMALL), str(GeneralLabel.MEDIUM), str(GeneralLabel.BIG)])
    sizes = by_area[np.searchsorted(bounds, rooms.geometry[:, GENERAL_FEATURES.index("area")])]
    return replace(rooms, labels=np.where(rooms.corridors, rooms.labels, sizes))


def represent_floor(floor: Floor, labels: Sequence[str]) -> tuple[Floats, Floats]:
    """Geometry and neighbours of the rooms of a floor, with labels of L_general, "" for none, as in a RoomSet."""
    label_of = {room.id: label for room, label in zip(floor.rooms, labels, strict=True)}
    row_of = {room.id: row for row, room in enumerate(floor.rooms)}
    neighbours = np.zeros((len(labels), len(GENERAL_LABELS)))
    for door in floor.doors:
        if not door.is_entrance:
            for one, other in (door.room_ids, door.room_ids[::-1]):
                if label_of[other]:
                    neighbours[row_of[one], GENERAL_LABELS.index(label_of[other])] += 1
    return compute_general_features(floor), neighbours


def _represent(generalise: Callable[[Sequence[str | None]], list[str]], annotated: AnnotatedFloor) -> RoomSet:
    """The rooms of one floor; those of a house without a label are left out."""
    floor = annotated.floor
    is_labelled = np.array([room.label is not None or annotated.kind != "house" for room in floor.rooms], bool)
    labelled = [room for room, chosen in zip(floor.rooms, is_labelled, strict=True) if chosen]
    general = generalise([room.label for room in labelled])
    label_of = {room.id: label for room, label in zip(labelled, general, strict=True)}
    geometry, neighbours = represent_floor(floor, [label_of.get(room.id, "") for room in floor.rooms])
    names = Counter(zip(general, (str(room.label) for room in labelled), strict=True))
    buildings = np.full(len(general), annotated.building)
    rooms = geometry[is_labelled], neighbours[is_labelled], np.array(general, str)
    return RoomSet(annotated.item, *rooms, buildings, names)


def _check_size(floors: Sequence[RoomSet], failed: Sequence[Item], folder: Path) -> None:
    """Refuse a set that cannot be divided into folds; the message lists its floors that failed."""
    counts = Counter(label for floor in floors for label in floor.labels.tolist())
    buildings = len({building for floor in floors for building in floor.buildings.tolist()})
    if sum(count >= FEWEST_ROOMS for count in counts.values()) < 2 or buildings < 2:
        size = f"{counts.total()} rooms in {buildings} building{'s' * (buildings != 1)}"
        need = f"at least 2 buildings, and {FEWEST_ROOMS} rooms of each of 2 labels of L_general"
        faults = f" ({join_faults([f'{row.item} failed: {row.failure}' for row in failed])})" if failed else ""
        raise DataError(f"{short_repr(folder)} has {size}, too few to learn from{faults}, give {need}")


def _schema_of_folder(folder: Path, building_type: str) -> Callable[[Sequence[str | None]], list[str]]:
    """Maps labels of files to L_general by the user's schema, else that of the type; houses may already have these."""
    if (folder / USER_SCHEMA).is_file():
        return _by_schema(read_label_schema(folder / USER_SCHEMA))
    return _generalise_house if building_type == "house" else _by_schema(schema_of(building_type))


def _by_schema(schema: LabelSchema) -> Callable[[Sequence[str | None]], list[str]]:
    return lambda names: [str(label) for label in schema.map_labels(names, LabelSet.GENERAL)]


def _generalise_house(names: Sequence[str | None]) -> list[str]:
    """Labels of HOUSE mapped to L_general; those of L_general unchanged; LabelError for any other, or both."""
    is_general = {name in GENERAL_LABELS for name in names}
    has_type_label = any(name in HOUSE.by_name for name in names)
    return _by_schema(HOUSE)(names) if has_type_label and is_general == {False} else _check_general(names)


def _check_general(names: Sequence[str | None]) -> list[str]:
    """The same names; LabelError if any is not a general label."""
    unknown = sorted({str(name) for name in names} - {*GENERAL_LABELS})
    if unknown:
        raise LabelError(
            f"labels {', '.join(unknown)} are not among {', '.join(GENERAL_LABELS)}, "
            f"give the schema of houses as {USER_SCHEMA}"
        )
    return [str(name) for name in names]
