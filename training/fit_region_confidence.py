"""Fit how probable it is that a room or a door of the method `structure` is right, on simulated maps.

    pip install '.[sim]'
    python training/fit_region_confidence.py MAPS [--maps N] [--data DIR] [-o region_confidence.json]

MAPS is a folder of simulated maps with their truth. Maps that it lacks are made first, as those of map_lessons.py:
furnished floors of `data/buildings` and of `pianta.worlds`. Then each map is read with the network that is shipped now,
so after a new network the script is only run again. A room is right if a true room has an IoU of at least 0.6 with it
on free cells (`count_rooms`), a door if its middle is within half the width of a true door (`match_doors`).

Before the fit to all maps the models are measured on buildings left out, in four folds.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

import cv2
import numpy as np
import shapely
from lesson_worlds import FINE, list_annotated_floors
from map_lessons import COARSE_SHARE, FACTOR, FREE_CELL, MIN_FREE_CELLS, OCCUPIED_CELL, map_random_floor, warp
from numpy.typing import NDArray
from shapely import LineString
from sklearn.linear_model import LogisticRegression

from pianta._types import Floats, LabelImage, Mask
from pianta.errors import MapError, PiantaError
from pianta.evaluation.doors import match_doors
from pianta.evaluation.room_counts import count_rooms
from pianta.evaluation.segmentation import drop_small_rooms
from pianta.floor import Door, Floor, Room
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure.confidence import (
    DOOR_MEASURES,
    MODEL_FILE,
    ROOM_MEASURES,
    ConfidenceModel,
    LogisticModel,
    measure_doors,
    measure_least_rooms,
    measure_rooms,
)
from pianta.layout.structure.reconstruct import divide_floor, list_regions
from pianta_bench.calibration.tables import describe_set
from pianta_bench.data.folders import find_data
from pianta_bench.layout.graph_scores import LEAST_REACH

# The constants were chosen by hand. Maps unless given.
MAPS = 200
# Weight of the mean square of the weights against the mean loss. It is large, because the measures mean less on real
# maps than on simulated ones: chosen on survey, clutter and vacuum.
PENALTY = 0.02
FOLDS = 4
# Maps after which the progress is printed.
PRINT_MAPS = 20
# Digits of the weights after the point.
DIGITS = 4
# Radius of the disc that shows where a door has moved; fine cells.
DISC_RADIUS = 2


STRUCTURE = StructureParameters()


@dataclass(frozen=True, eq=False)
class TrueMap:
    """A simulated map with its truth.

    building: maps of one building are left out together. rooms: shape (H, W), 0 no room, n a true room.
    """

    building: str
    grid: GridMap
    rooms: LabelImage
    doors: tuple[Door, ...]


def simulate(annotated: list[Floor], rng: np.random.Generator) -> dict[str, NDArray] | None:
    """A simulated map as arrays, cut to what is free; None if the floor is too large, or little of it is free."""
    mapped = map_random_floor(annotated, rng)
    if mapped is None:
        return None
    floor, world, cells = mapped
    discs = np.zeros(world.rooms.shape, np.float32)
    for number, door in enumerate(world.floor.doors, start=1):
        middle = np.array(door.line.interpolate(0.5, normalized=True).coords[0][:2]) / FINE
        cv2.circle(discs, middle.astype(int).tolist(), DISC_RADIUS, number, cv2.FILLED)
    cells, rooms, discs = warp([cells, world.rooms.astype(np.float32), discs], rng)
    if rng.random() < COARSE_SHARE:
        cells, rooms, discs = _join_cells(cells), rooms[::FACTOR, ::FACTOR], discs[::FACTOR, ::FACTOR]
        resolution = FINE * FACTOR
    else:
        resolution = FINE
    free_area = np.count_nonzero(cells == FREE_CELL) * resolution**2
    if free_area < MIN_FREE_CELLS * (FINE * FACTOR) ** 2:
        return None
    middles = [
        (*np.mean(np.nonzero(discs == number), axis=1) + 0.5, door.width)
        for number, door in enumerate(world.floor.doors, start=1)
        if (discs == number).any()
    ]
    return {
        "cells": cells.astype(np.uint8),
        "rooms": rooms.astype(np.uint16),
        # Row and col of the middle, and width
        "doors": np.reshape(middles, (-1, 3)),
        "resolution": np.array(resolution),
        "building": np.array(floor.source or f"{len(floor.rooms)} {floor.rooms[0].polygon.wkt}"),
    }


def _join_cells(cells: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Cells of FACTOR times the side, each occupied if any part is, else free if any part is."""
    height, width = (side // FACTOR * FACTOR for side in cells.shape)
    parts = cells[:height, :width].reshape(height // FACTOR, FACTOR, width // FACTOR, FACTOR)
    occupied, free = ((parts == value).any(axis=(1, 3)) for value in (OCCUPIED_CELL, FREE_CELL))
    return np.select([occupied, free], [OCCUPIED_CELL, FREE_CELL], 0).astype(np.uint8)


def make_maps(folder: Path, count: int, data: Path, seed: int) -> list[Path]:
    """The files of the first `count` simulated maps; those that the folder lacks are made."""
    folder.mkdir(parents=True, exist_ok=True)
    annotated: list[Floor] = []
    paths: list[Path] = []
    number = 0
    while len(paths) < count:
        number += 1
        path = folder / f"{seed:03d}_{number:06d}.npz"
        skipped = path.with_suffix(".skipped")
        if skipped.exists():
            continue
        if not path.exists():
            annotated = annotated or list_annotated_floors(data)
            try:
                arrays = simulate(annotated, np.random.default_rng([seed, number]))
            except (PiantaError, shapely.errors.GEOSException):
                # Some floors are no floors any more when they are turned, or furnished
                arrays = None
            if arrays is None:
                skipped.touch()
                continue
            np.savez_compressed(path, **arrays)
        paths.append(path)
    return paths


def read_map(path: Path) -> TrueMap:
    """A map of make_maps."""
    with np.load(path) as file:
        arrays = dict(file)
    values = np.array([UNKNOWN, FREE, OCCUPIED], np.int8)
    resolution = float(arrays["resolution"])
    grid = GridMap(values[arrays["cells"]], resolution)
    doors = []
    for row, col, width in arrays["doors"].tolist():
        x, y = grid.pixel_to_map(row, col)
        half = max(width, resolution) / 2
        # Only the middle and the width of a true door are used
        doors.append(Door((1, 2), LineString([(x - half, y), (x + half, y)]), width))
    rooms = arrays["rooms"][: grid.shape[0], : grid.shape[1]].astype(np.int32)
    return TrueMap(str(arrays["building"]), grid, rooms, tuple(doors))


@dataclass(frozen=True, eq=False)
class ReadRegions:
    """The rooms and doors of a map, with their measures and whether they are right.

    room_measures: shape (rooms, measures). rooms_right: shape (rooms,). door_measures: without the last one, shape
    (doors, measures - 1). doors_right: shape (doors,).
    """

    building: str
    rooms: list[Room]
    room_measures: Floats
    rooms_right: Mask
    doors: list[Door]
    door_measures: Floats
    doors_right: Mask

    @property
    def fold(self) -> int:
        """Number of the fold of the building."""
        return crc32(self.building.encode()) % FOLDS


def read_regions(true_map: TrueMap) -> ReadRegions:
    """Read a map, and compare its rooms and doors with the true ones; doors between rooms only."""
    grid = true_map.grid
    division = divide_floor(grid, STRUCTURE)
    rooms, doors = list_regions(division, STRUCTURE)
    doors = [door for door in doors if not door.is_entrance]
    image = Floor(tuple(rooms)).label_image(grid).astype(np.int32)
    labels, truth = (
        drop_small_rooms(np.where(grid.free, each, 0), resolution=grid.resolution) for each in (image, true_map.rooms)
    )
    right_ids = count_rooms(labels, truth, counted=grid.free, resolution=grid.resolution).right_ids
    return ReadRegions(
        true_map.building,
        rooms,
        measure_rooms(rooms, division.labels, division.evidence),
        np.array([room.id in right_ids for room in rooms]),
        doors,
        measure_doors(doors, division.working_grid, division.evidence),
        match_doors(doors, true_map.doors, least_reach=LEAST_REACH),
    )


def fit_logistic(measures: Floats, is_right: Mask) -> LogisticModel:
    """A logistic model of measures, shape (N, measures)."""
    means, spreads = measures.mean(axis=0), measures.std(axis=0) + 1e-6
    start = LogisticModel(means, spreads, np.zeros(len(means)), 0.0)
    network = LogisticRegression(C=1 / (PENALTY * len(measures)))
    network.fit(start.standardise(measures), is_right)
    return LogisticModel(means, spreads, network.coef_[0], float(network.intercept_[0]))


def fit_model(maps: Sequence[ReadRegions]) -> ConfidenceModel:
    """The models of rooms and doors."""
    rooms = fit_logistic(
        np.concatenate([each.room_measures for each in maps]), np.concatenate([each.rooms_right for each in maps])
    )
    measures = np.concatenate([complete_doors(each, rooms) for each in maps])
    return ConfidenceModel(rooms, fit_logistic(measures, np.concatenate([each.doors_right for each in maps])))


def complete_doors(regions: ReadRegions, rooms: LogisticModel) -> Floats:
    """All measures of the doors of a map, shape (doors, measures)."""
    chances = rooms.predict(regions.room_measures).tolist()
    by_id = {room.id: chance for room, chance in zip(regions.rooms, chances, strict=True)}
    return np.column_stack([regions.door_measures, measure_least_rooms(regions.doors, by_id)])


def measure_left_out(maps: Sequence[ReadRegions]) -> dict[str, dict[str, float]]:
    """Figures of rooms and doors whose building was left out of the fit."""
    chances: dict[str, list[Floats]] = {"rooms": [], "doors": []}
    right: dict[str, list[Mask]] = {"rooms": [], "doors": []}
    for fold in range(FOLDS):
        model = fit_model([each for each in maps if each.fold != fold])
        for each in maps:
            if each.fold == fold:
                chances["rooms"].append(model.rooms.predict(each.room_measures))
                chances["doors"].append(model.doors.predict(complete_doors(each, model.rooms)))
                right["rooms"].append(each.rooms_right)
                right["doors"].append(each.doors_right)
    return {
        noun: {
            record["metric"]: round(float(record["value"]), 1)
            for record in describe_set(noun, np.concatenate(chances[noun]), np.concatenate(right[noun]))
        }
        for noun in chances
    }


def write_model(model: ConfidenceModel, left_out: dict[str, dict[str, float]], path: Path) -> None:
    """Write the model, rounded, as JSON."""
    content: dict[str, object] = {}
    for noun, part, names in (("rooms", model.rooms, ROOM_MEASURES), ("doors", model.doors, DOOR_MEASURES)):
        columns = np.round([part.means, part.spreads, part.weights], DIGITS).T.tolist()
        by_name = {
            name: dict(zip(("mean", "spread", "weight"), column, strict=True))
            for name, column in zip(names, columns, strict=True)
        }
        content[noun] = {"measures": by_name, "bias": round(part.bias, DIGITS)}
    content["on_buildings_left_out"] = left_out
    path.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    """Make the maps that are missing, read all, measure on buildings left out, fit, and write the model."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, metavar="MAPS")
    parser.add_argument("--maps", type=int, default=MAPS)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--data", type=Path)
    parser.add_argument("-o", "--out", type=Path, default=MODEL_FILE)
    options = parser.parse_args()
    maps = []
    paths = make_maps(options.folder, options.maps, find_data(options.data), options.seed)
    for number, path in enumerate(paths, start=1):
        try:
            maps.append(read_regions(read_map(path)))
        except MapError as error:
            sys.stdout.write(f"{path.name}: {error}\n")
        if number % PRINT_MAPS == 0:
            sys.stdout.write(f"{number} of {len(paths)} maps read\n")
            sys.stdout.flush()
    left_out = measure_left_out(maps)
    sys.stdout.write(f"{len(maps)} maps; on buildings left out: {json.dumps(left_out, indent=1)}\n")
    write_model(fit_model(maps), left_out, options.out)


if __name__ == "__main__":
    main()
