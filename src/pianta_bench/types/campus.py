"""The campus of MIT: rooms with labels of their own, of whoever has the files (sections 4.2.3 and 4.2.4)."""

from __future__ import annotations

import warnings
from collections import Counter
from pathlib import Path

import numpy as np

from pianta.errors import BuildingWarning, DataError, OptionError, PiantaError
from pianta.io._faults import join_faults
from pianta.io._files import one_line_reason, short_repr
from pianta.io.buildings.read import list_buildings, read_building
from pianta.rooms.thesis_features import compute_general_features
from pianta_bench.harness.records import Item
from pianta_bench.types.clusters import MIN_POINTS
from pianta_bench.types.room_sets import GENERAL_LABELS, RoomSet, join_room_sets

MIT = "MIT"
# Table 4.2 has the labels of 1000 rooms and more.
FREQUENT = 1000
MAX_LABELS = 8  # of the table, as it prints; of a smaller campus the most frequent ones
NO_LABEL = "no label"
# Of SCALES, those without the labels behind doorways, which L_general does not have.
CAMPUS_SCALES = ("a (m²), d, rt", "% of range")


def read_campus(folder: Path) -> tuple[RoomSet, list[Item]]:
    """The rooms of all floors of a folder, with the labels of the files; and the floors that cannot be read.

    The files are MIT XML, KTH XML, or any other format of read_building. A file BUILDING_FLOOR.xml is of one building
    with the other files of that name; the floors in a subfolder are of one building too. Neighbours are not counted, as
    L_general does not have their labels.
    Raises OptionError for a path that is no folder, BuildingError for one without buildings, and DataError if fewer
    rooms can be read than a cluster needs.
    """
    if not folder.is_dir():
        raise OptionError(f"--mit is {short_repr(folder)}, which is no folder, give a folder of floors")
    sets, failed = [], []
    for file in list_buildings([folder]):
        try:
            sets.append(_read_rooms(file, folder))
        except PiantaError as error:
            failed.append(Item(MIT, file.name, one_line_reason(error)))
    rooms = sum(len(each.labels) for each in sets)
    if rooms < MIN_POINTS:
        faults = f" ({join_faults([f'{row.item} failed: {row.failure}' for row in failed])})" if failed else ""
        raise DataError(f"{short_repr(folder)} has {rooms} rooms{faults}, give a campus of at least {MIN_POINTS}")
    return join_room_sets(MIT, sets), failed


def _read_rooms(file: Path, folder: Path) -> RoomSet:
    """The rooms of a floor."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", BuildingWarning)
        floor = read_building(file)
    labels = np.array([room.label or NO_LABEL for room in floor.rooms], str)
    building = file.parent.relative_to(folder).as_posix() if file.parent != folder else file.stem.rpartition("_")[0]
    return RoomSet(
        file.name,
        compute_general_features(floor),
        np.zeros((len(labels), len(GENERAL_LABELS))),
        labels,
        np.full(len(labels), building or file.stem),
        Counter((label, label) for label in labels.tolist()),
    )


def list_frequent_labels(rooms: RoomSet) -> list[str]:
    """The labels of at least FREQUENT rooms, the most frequent first; MAX_LABELS of them if fewer are as frequent."""
    counts = Counter(rooms.labels.tolist())
    ranked = sorted(counts, key=lambda label: (-counts[label], label))
    frequent = [label for label in ranked if counts[label] >= FREQUENT]
    return frequent if len(frequent) >= MAX_LABELS else ranked[:MAX_LABELS]
