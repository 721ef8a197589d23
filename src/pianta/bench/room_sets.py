"""RoomSet: the rooms of all buildings of a type, as chapter 4 represents them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pianta.bench.annotated_floors import read_buildings_of_files, read_drawing
from pianta.bench.data import REMEDY, list_maps
from pianta.errors import DataError, LabelError
from pianta.floor import Floor
from pianta.formats.files import shown
from pianta.formats.label_schema import read_label_schema
from pianta.graphs.features import GENERAL_FEATURES, compute_general_features
from pianta.labels import General, LabelSchema, LabelSet, schema_of

Floats = NDArray[np.float64]
Labels = NDArray[np.str_]

BUILDING_TYPES = ("house", "school", "office")
GENERAL_LABELS = tuple(str(label) for label in General)
CORRIDORS = (str(General.CORRIDOR), str(General.HALL))
USER_SCHEMA = "labels.yaml"
# As many as there are folds.
FEWEST_ROOMS = 10


@dataclass(frozen=True)
class RoomSet:
    """Rooms of a type of building, or of several.

    name: House, School, Office, or the initials of several, such as S+O.
    geometry: area (m²), doorways, axes ratio, shape (rooms, 3).
    neighbours: how many of a room's doorways lead to rooms of each label of GENERAL_LABELS, shape (rooms, 5).
    labels: of L_general, shape (rooms,). buildings: the building of each room, shape (rooms,).
    names: how many rooms each label of the files has, by its label of L_general.
    """

    name: str
    geometry: Floats
    neighbours: Floats
    labels: Labels
    buildings: Labels
    names: Mapping[tuple[str, str], int]

    @property
    def corridors(self) -> NDArray[np.bool_]:
        """Which rooms are CORRIDOR, which C and H are; the others are ROOM (section 4.3.1); shape (rooms,)."""
        return np.isin(self.labels, CORRIDORS)

    def with_neighbours(self) -> Floats:
        """Geometry and neighbours, shape (rooms, 8)."""
        return np.hstack([self.geometry, self.neighbours])


def read_room_sets(data: Path) -> tuple[RoomSet, ...]:
    """The sets of types that data/buildings has, and their union when there are several (section 4.2.3).

    A house set is the user's: data/buildings/house with layout XMLs, and their schema in labels.yaml unless the
    labels are already those of L_general.

    Raises DataError when there is none, or one that is too small to learn from; LabelError for labels that the schema
    does not have.
    """
    folder = data / "buildings"
    types = [name for name in BUILDING_TYPES if (folder / name).is_dir()]
    if not types:
        places = ", ".join(shown(folder / name) for name in BUILDING_TYPES)
        raise DataError(f"no buildings in any of {places}, {REMEDY}")
    buildings = read_buildings_of_files(data)
    sets = [_read_room_set(folder / name, buildings) for name in types]
    initials = "+".join(rooms.name[0] for rooms in sets)
    return (*sets, join_room_sets(initials, sets)) if len(sets) > 1 else tuple(sets)


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
    """The set with S, M and B given by area, up to the first bound, up to the second, above, m²; C and H as they are.

    The counts of neighbours' labels stay those of the files.
    """
    by_area = np.array([str(General.SMALL), str(General.MEDIUM), str(General.BIG)])
    sizes = by_area[np.searchsorted(bounds, rooms.geometry[:, GENERAL_FEATURES.index("area")])]
    return replace(rooms, labels=np.where(rooms.corridors, rooms.labels, sizes))


def represent_floor(floor: Floor, labels: Sequence[str]) -> tuple[Floats, Floats]:
    """Geometry and neighbours of the rooms of a floor, whose labels are of L_general, as a RoomSet has them."""
    label_of = {room.id: label for room, label in zip(floor.rooms, labels, strict=True)}
    row_of = {room.id: row for row, room in enumerate(floor.rooms)}
    neighbours = np.zeros((len(labels), len(GENERAL_LABELS)))
    for door in floor.doors:
        if not door.is_entrance:
            for one, other in (door.room_ids, door.room_ids[::-1]):
                neighbours[row_of[one], GENERAL_LABELS.index(label_of[other])] += 1
    return compute_general_features(floor), neighbours


def _read_room_set(folder: Path, buildings: Mapping[str, str]) -> RoomSet:
    generalise = _schema_of_folder(folder)
    floors = []
    for item in list_maps(folder, ".xml"):
        floor = read_drawing(folder / f"{item}.xml")
        labels = generalise([room.label for room in floor.rooms])
        building = buildings.get(f"buildings/{folder.name}/{item}.xml", item)
        names = Counter(zip(labels, (str(room.label) for room in floor.rooms), strict=True))
        places = np.full(len(labels), f"{folder.name}/{building}")
        floors.append(RoomSet(item, *represent_floor(floor, labels), np.array(labels, str), places, names))
    return _checked(join_room_sets(folder.name.capitalize(), floors), folder)


def _checked(rooms: RoomSet, folder: Path) -> RoomSet:
    """Refuse a set that cannot be divided into folds."""
    _, counts = np.unique(rooms.labels, return_counts=True)
    buildings = len(np.unique(rooms.buildings))
    if np.sum(counts >= FEWEST_ROOMS) < 2 or buildings < 2:
        found = f"{len(rooms.labels)} rooms in {buildings} building{'s' * (buildings != 1)}"
        need = f"at least 2 buildings, and {FEWEST_ROOMS} rooms of each of 2 labels of L_general"
        raise DataError(f"{shown(folder)} has {found}, too few to learn from, give {need}")
    return rooms


def _schema_of_folder(folder: Path) -> Callable[[Sequence[str | None]], list[str]]:
    """Maps labels of files to L_general: by the user's schema, else by that of the type, else they are so already."""
    if (folder / USER_SCHEMA).is_file():
        return _by_schema(read_label_schema(folder / USER_SCHEMA))
    return _check_general if folder.name == "house" else _by_schema(schema_of(folder.name))


def _by_schema(schema: LabelSchema) -> Callable[[Sequence[str | None]], list[str]]:
    return lambda names: [str(label) for label in schema.map_labels(names, LabelSet.GENERAL)]


def _check_general(names: Sequence[str | None]) -> list[str]:
    strange = sorted({str(name) for name in names} - {*GENERAL_LABELS})
    if strange:
        told = ", ".join(strange)
        raise LabelError(
            f"labels {told} are none of {', '.join(GENERAL_LABELS)}, give the schema of houses as {USER_SCHEMA}"
        )
    return [str(name) for name in names]
