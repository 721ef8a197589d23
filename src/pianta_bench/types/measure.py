"""Building types: whether rooms of one type are more alike than those of others (chapter 4)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import permutations, product
from pathlib import Path

import numpy as np

from pianta_bench.harness.table import Row
from pianta_bench.types.classifiers import (
    DIVISIONS,
    REPRESENTATIONS,
    CrossValidation,
    Transfer,
    cross_validate,
    measure_transfer,
)
from pianta_bench.types.clusters import SCALES, RoomClusters, find_room_clusters
from pianta_bench.types.published import CHARACTERISTICS
from pianta_bench.types.room_sets import GENERAL_LABELS, RoomSet, join_room_sets, name_sizes_by_area, read_room_sets

# Section 4.2.3 has the labels of the rooms behind the doorways among what represents a room, and divides rooms.
OF_THESIS = ("with neighbours", "rooms")
# How S, M and B are given: by the label's name, or by area.
BY_NAME, BY_AREA = "by name", "by area"


@dataclass(frozen=True)
class Characteristics:
    """Rooms of a label in a set (Table 4.2).

    share: of the rooms of the set. means, sds: of area (m²), doorways, axes ratio; None where rooms are too few.
    """

    label: str
    rooms: int
    share: float
    means: tuple[float | None, ...]
    sds: tuple[float | None, ...]


@dataclass(frozen=True)
class TypesBench:
    """What was measured of each set, in the order of the thesis; the union comes last where there is one.

    seed: of folds and of algorithms. validations, transfers: by BY_NAME and BY_AREA; the latter only OF_THESIS.
    transfers: between sets of one type each. failed: by building type, the floors that no set has, and why.
    """

    seed: int
    sets: tuple[RoomSet, ...]
    validations: dict[str, tuple[CrossValidation, ...]]
    transfers: dict[str, tuple[Transfer, ...]]
    clusters: tuple[RoomClusters, ...]
    failed: dict[str, tuple[Row, ...]]


def measure_types(data: Path, *, seed: int = 0, track: Callable[[Sequence[str]], Iterable[str]] = iter) -> TypesBench:
    """Measure Tables 4.2, 4.3, 4.4 and Figs. 4.3, 4.4 on the buildings of the data.

    A floor that fails does not count.
    track: as of measure_segmentation, over the classifications. Raises what read_room_sets raises.
    """
    read, failed = read_room_sets(data)
    sets = {BY_NAME: read, BY_AREA: _name_all_by_area(read)}
    trials = [(BY_NAME, *trial) for trial in product(sets[BY_NAME], REPRESENTATIONS, DIVISIONS)]
    trials += [(BY_AREA, rooms, *OF_THESIS) for rooms in sets[BY_AREA]]
    validations: dict[str, list[CrossValidation]] = {BY_NAME: [], BY_AREA: []}
    tracked = track([f"{rooms.name}, {name}, {divided}" for _, rooms, name, divided in trials])
    for (sizes, rooms, representation, divided), _ in zip(trials, tracked, strict=True):
        validations[sizes].append(cross_validate(rooms, representation=representation, divided=divided, seed=seed))
    return TypesBench(
        seed,
        sets[BY_NAME],
        {sizes: tuple(measured) for sizes, measured in validations.items()},
        {
            BY_NAME: _measure_transfers(sets[BY_NAME], REPRESENTATIONS, seed),
            BY_AREA: _measure_transfers(sets[BY_AREA], OF_THESIS[:1], seed),
        },
        tuple(find_room_clusters(rooms, scale=scale) for rooms, scale in product(sets[BY_NAME], SCALES)),
        failed,
    )


def characterise(rooms: RoomSet) -> tuple[Characteristics, ...]:
    """Share, means and standard deviations (n - 1) of each label of L_general (Table 4.2)."""
    return tuple(_characterise_label(rooms, label) for label in GENERAL_LABELS)


def bounds_of_sizes(building_type: str) -> tuple[float, float]:
    """Areas (m²) halfway between the means of S, M and B that Table 4.2 prints for a type of building."""
    small, medium, big = (CHARACTERISTICS[building_type][label][1] for label in "SMB")
    return (small + medium) / 2, (medium + big) / 2


def _name_all_by_area(sets: Sequence[RoomSet]) -> tuple[RoomSet, ...]:
    types = [name_sizes_by_area(rooms, bounds_of_sizes(rooms.name)) for rooms in _without_union(sets)]
    return (*types, join_room_sets(sets[-1].name, types)) if len(sets) > 1 else tuple(types)


def _measure_transfers(sets: Sequence[RoomSet], representations: Iterable[str], seed: int) -> tuple[Transfer, ...]:
    pairs = product(permutations(_without_union(sets), 2), representations)
    return tuple(
        measure_transfer(train, test, representation=representation, seed=seed)
        for (train, test), representation in pairs
    )


def _without_union(sets: Sequence[RoomSet]) -> Sequence[RoomSet]:
    return sets[:-1] if len(sets) > 1 else sets


def _characterise_label(rooms: RoomSet, label: str) -> Characteristics:
    geometry = rooms.geometry[rooms.labels == label]
    nothing: tuple[float | None, ...] = (None,) * rooms.geometry.shape[1]
    return Characteristics(
        label,
        len(geometry),
        len(geometry) / len(rooms.labels),
        tuple(geometry.mean(axis=0).tolist()) if len(geometry) else nothing,
        tuple(np.std(geometry, axis=0, ddof=1).tolist()) if len(geometry) > 1 else nothing,
    )
