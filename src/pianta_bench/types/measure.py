"""Building types: whether rooms of one type are more similar than rooms of different types (chapter 4)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import permutations, product
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from pianta.errors import DataError, OptionError
from pianta_bench.data.folders import find_data
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.harness.tables import read_published
from pianta_bench.types.campus import CAMPUS_SCALES, list_frequent_labels, read_campus
from pianta_bench.types.classifiers import DIVISIONS, REPRESENTATIONS, cross_validate, measure_transfer
from pianta_bench.types.clusters import SCALES, find_room_clusters
from pianta_bench.types.room_sets import GENERAL_LABELS, RoomSet, join_room_sets, name_sizes_by_area, read_room_sets

# Section 4.2.3 represents a room also by the labels of the rooms behind its doorways, and its folds are of rooms.
REPRESENTATION_OF_THESIS = "with neighbours"
DIVISION_OF_THESIS = "rooms"
# How a room becomes S, M or B: by the name of its label, or by its area.
BY_NAME = "by name"
BY_AREA = "by area"
GEOMETRY = ("area", "doorways", "axes ratio")


def measure(
    data: Path | None = None,
    *,
    houses: Path | None = None,
    mit: Path | None = None,
    maps: bool = False,
    seed: int = 0,
    pictures: Path | None = None,
    track: Track = iter,
) -> Results:
    """Measure Tables 4.2, 4.3, 4.4 and Figs. 4.3, 4.4 on the buildings of the data; shares from 0 to 1, areas in m².

    A floor that fails does not count. The union of all types comes last, if there are several.
    houses: folder of houses, instead of data/buildings/house. mit: folder of the campus of MIT, of which Table 4.2 and
    Fig. 4.4e are measured; with either of them the data may be missing.
    maps: measure building types of robots' maps instead, as measure_maps does; pictures, houses and mit are refused.
    seed: of folds and of algorithms. track: wraps the classifications, to show progress.
    Raises what read_room_sets, read_campus or measure_maps raises, and OptionError.
    """
    if maps:
        if pictures or houses or mit:
            raise OptionError("--pictures, --houses and --mit are of the rooms of drawn floors, leave --maps out")
        from pianta_bench.types.maps import measure_maps

        return measure_maps(data, track=track)
    campus, lost = read_campus(mit) if mit else (None, [])
    folder = _find_data(data, is_needed=houses is None and mit is None)
    read, failed = read_room_sets(folder, houses=houses) if folder or houses else ((), [])
    sets = {BY_NAME: read, BY_AREA: name_all_by_area(read)}
    results = Results({"seed": seed}, items=[*failed, *lost])
    for rooms in read:
        results.add(rooms.name, "", describe_labels(rooms), names=("label", "metric"))
    trials = [(BY_NAME, *trial) for trial in product(read, REPRESENTATIONS, DIVISIONS)]
    trials += [(BY_AREA, rooms, REPRESENTATION_OF_THESIS, DIVISION_OF_THESIS) for rooms in sets[BY_AREA]]
    tracked = track([f"{rooms.name}, {name}, {divided}" for _, rooms, name, divided in trials])
    for (sizes, rooms, representation, divided), _ in zip(trials, tracked, strict=True):
        add_validation(results, rooms, sizes=sizes, representation=representation, divided=divided)
    for sizes, representations in ((BY_NAME, tuple(REPRESENTATIONS)), (BY_AREA, (REPRESENTATION_OF_THESIS,))):
        add_transfers(results, without_union(sets[sizes]), sizes=sizes, representations=representations)
    clusters = [find_room_clusters(rooms, scale=scale) for rooms, scale in product(read, SCALES)]
    if campus:
        add_campus(results, campus)
    for each in clusters:
        results.add(each.rooms, "", {"bend": each.bend, **each.figures}, features=each.scale)
    results.details["sets"] = [describe_set(rooms) for rooms in read]
    results.objects["clusters"] = clusters
    return results


def _find_data(data: Path | None, *, is_needed: bool) -> Path | None:
    """The folder of the data; None if it is missing and not needed."""
    try:
        return find_data(data)
    except DataError:
        if is_needed or data is not None:
            raise
        return None


def add_campus(results: Results, campus: RoomSet) -> None:
    """Append Table 4.2 of the frequent labels of a campus, and its clusters (Fig. 4.4e)."""
    frequent = list_frequent_labels(campus)
    results.add(campus.name, "", describe_labels(campus, frequent), names=("label", "metric"))
    clusters = [find_room_clusters(campus, scale=scale) for scale in CAMPUS_SCALES]
    for each in clusters:
        results.add(each.rooms, "", {"bend": each.bend, **each.figures}, features=each.scale)
    results.details["campus"] = {
        "rooms": len(campus.labels),
        "buildings": len(set(campus.buildings.tolist())),
        "labels": dict(sorted(Counter(campus.labels.tolist()).items())),
        "frequent": frequent,
    }
    results.objects["campus"] = clusters


def add_validation(results: Results, rooms: RoomSet, *, sizes: str, representation: str, divided: str) -> None:
    """Append the accuracies of each fold, and the confusion, of classifiers of a set."""
    validation = cross_validate(rooms, representation=representation, divided=divided, seed=results.options["seed"])
    fields: dict[str, Any] = {"sizes": sizes, "features": representation, "folds_of": divided}
    for algorithm, folds in validation.accuracies.items():
        for number, accuracy in enumerate(folds):
            results.add(rooms.name, f"fold {number}", {"accuracy": accuracy}, algorithm=algorithm, **fields)
    rows = dict(zip((*GENERAL_LABELS, "FN"), (*validation.confusion, validation.misled), strict=True))
    for label, shares in rows.items():
        predicted = dict(
            zip(GENERAL_LABELS, (share if isfinite(share) else None for share in shares.tolist()), strict=True)
        )
        results.add(rooms.name, "", predicted, names=("given",), metric="confusion", label=label, **fields)


def add_transfers(results: Results, sets: Sequence[RoomSet], *, sizes: str, representations: Sequence[str]) -> None:
    """Append the accuracies of classifiers of one set on another, one for each fold that was left out of training."""
    for (train, test), representation in product(permutations(sets, 2), representations):
        accuracies = measure_transfer(train, test, representation=representation, seed=results.options["seed"])
        for algorithm, folds in accuracies.items():
            for number, accuracy in enumerate(folds):
                results.add(
                    f"{train.name}, {test.name}",
                    f"fold {number}",
                    {"transfer": accuracy},
                    algorithm=algorithm,
                    sizes=sizes,
                    features=representation,
                )


def describe_labels(rooms: RoomSet, labels: Sequence[str] = GENERAL_LABELS) -> Figures:
    """Rooms, their share, and means and standard deviations (n - 1) of geometry, for each label (Table 4.2)."""
    return dict(_describe_labels(rooms, labels))


def _describe_labels(rooms: RoomSet, labels: Sequence[str]) -> Iterator[tuple[tuple[str, str], float | None]]:
    """Keys (label, figure) and values: rooms, their share, and mean and standard deviation of geometry."""
    for label in labels:
        geometry = rooms.geometry[rooms.labels == label]
        yield (label, "rooms"), len(geometry)
        yield (label, "share"), len(geometry) / len(rooms.labels)
        for column, name in enumerate(GEOMETRY):
            figures = geometry[:, column]
            yield (label, name), float(figures.mean()) if len(figures) else None
            yield (label, f"{name} sd"), float(np.std(figures, ddof=1)) if len(figures) > 1 else None


def describe_set(rooms: RoomSet) -> dict[str, Any]:
    """Rooms and buildings of a set, the areas between S, M and B, and by label of L_general the labels of the files."""
    return {
        "name": rooms.name,
        "rooms": len(rooms.labels),
        "buildings": len(set(rooms.buildings.tolist())),
        "bounds_by_area": None if "+" in rooms.name else size_bounds(rooms.name),
        "mapping": {
            label: {name: count for (general, name), count in sorted(rooms.names.items()) if general == label}
            for label in GENERAL_LABELS
        },
    }


def size_bounds(building_type: str) -> tuple[float, float]:
    """Areas (m²) halfway between the means of S, M and B that Table 4.2 prints for a type of building."""
    areas = {
        record["label"]: float(record["mean"])
        for record in read_published("table_4_2.csv")
        if (record["part"], record["metric"]) == (building_type, "area")
    }
    return (areas["S"] + areas["M"]) / 2, (areas["M"] + areas["B"]) / 2


def name_all_by_area(sets: Sequence[RoomSet]) -> tuple[RoomSet, ...]:
    """The sets with S, M and B by area, and their union."""
    types = [name_sizes_by_area(rooms, size_bounds(rooms.name)) for rooms in without_union(sets)]
    return (*types, join_room_sets(sets[-1].name, types)) if len(sets) > 1 else tuple(types)


def without_union(sets: Sequence[RoomSet]) -> Sequence[RoomSet]:
    """The sets of single types."""
    return sets[:-1] if len(sets) > 1 else sets
