"""The probability of each room and door, and whether it is right."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from pianta._types import LabelImage, Mask
from pianta.evaluation.doors import list_counted_doors, match_connections, match_doors
from pianta.evaluation.room_counts import count_rooms
from pianta.evaluation.segmentation import drop_small_rooms
from pianta.floor import Door, Floor, Room
from pianta.gridmap import GridMap
from pianta.layout.reconstruct import find_rooms
from pianta_bench.data.folders import CALIBRATION_SET_NAMES, DEFAULT_CALIBRATION_SETS, find_data
from pianta_bench.data.layout_sets import LAYOUT_SETS, choose_maps
from pianta_bench.data.map_sets import SETS
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.layout.graph_scores import LEAST_REACH

ROOMS, DOORS, EITHER = "rooms", "doors", "doors by place or rooms"
REGIONS = (ROOMS, DOORS, EITHER)
# A record is of a room or door, by its number.
NAMES = ("regions", "number", "metric")


def measure(
    data: Path | None = None,
    *,
    sets: Sequence[str] | None = None,
    items: Sequence[str] | None = None,
    jobs: int = 1,
    track: Track = iter,
) -> Results:
    """The probability of each room and door of method `structure`, and whether it is right.

    A room is right if a true room has an IoU of at least 0.6 with it, as `bench segmentation --count` counts, a door
    if its middle is within half a width of a true door, as `bench layout` counts; by place or rooms it is right
    if it is near a true door, or joins the true rooms that a true door joins.
    sets: of CALIBRATION_SET_NAMES. items: only maps of these names.
    jobs: processes; the figures do not depend on them. track: wraps the maps, to show progress.
    Raises OptionError for the name of no set or map, DataError if there are no maps.
    """
    folder = find_data(data)
    pairs = choose_maps(folder, sets, items, names=CALIBRATION_SET_NAMES, usual=DEFAULT_CALIBRATION_SETS)
    results = Results({"sets": [*dict.fromkeys(part for part, _ in pairs)]})
    steps = {f"{part}, {name}": partial(measure_apart, folder, part, name) for part, name in pairs}
    for outcome in run_steps(steps, jobs=jobs, track=track):
        results.extend(outcome)
    return results


def measure_apart(data: Path, part: str, name: str) -> Results:
    """The results of one map."""
    results = Results()
    results.measure(part, name, partial(measure_map, data, part, name), names=NAMES)
    return results


def measure_map(data: Path, part: str, name: str) -> Iterator[Figures]:
    """The probability of each room and door of a map, and whether it is right; doors only if there are true ones."""
    true_floor = None
    if part in LAYOUT_SETS:
        grid, true_floor = LAYOUT_SETS[part].read(data, name)
        truth, counted, free_only = true_floor.label_image(grid).astype(np.int32), grid.free, True
    if part in SETS:
        true_map = SETS[part].read(data / SETS[part].folder, name)
        grid, truth, counted, free_only = true_map.grid, true_map.spaces, true_map.free, SETS[part].free_only
    floor = find_rooms(grid, method="structure")
    right_rooms = find_right_rooms(floor, grid, truth, counted, free_only=free_only)
    yield describe(ROOMS, floor.rooms, [room.id in right_rooms for room in floor.rooms])
    if true_floor is None:
        return
    doors = list_counted_doors(floor, true_floor)
    yield describe(DOORS, doors, match_doors(doors, true_floor.doors, least_reach=LEAST_REACH).tolist())
    joining = [door for door in floor.doors if not door.is_entrance]
    is_near = match_doors(joining, true_floor.doors, least_reach=LEAST_REACH)
    joins_pair = match_connections(replace(floor, doors=tuple(joining)), true_floor)
    yield describe(EITHER, joining, (is_near | joins_pair).tolist())


def describe(regions: str, items: Sequence[Room | Door], is_right: Sequence[bool]) -> Figures:
    """The probability of each room or door, and whether it is right, by their numbers in the list."""
    figures: dict[tuple[str, int, str], float | None] = {}
    for number, (item, right) in enumerate(zip(items, is_right, strict=True), start=1):
        figures[regions, number, "probability"] = item.probability
        figures[regions, number, "right"] = float(right)
    return figures


def find_right_rooms(
    floor: Floor, grid: GridMap, truth: LabelImage, counted: Mask, *, free_only: bool
) -> frozenset[int]:
    """The ids of the rooms that are right; smaller rooms than `bench segmentation` counts are not.

    truth: true rooms on the grid, shape (H, W). counted: its free cells, shape (H, W).
    free_only: whether rooms are cut to free cells first.
    """
    labels, truth = (
        drop_small_rooms(np.where(counted, rooms, 0) if free_only else rooms, resolution=grid.resolution)
        for rooms in (floor.label_image(grid).astype(np.int32), truth)
    )
    return count_rooms(labels, truth, counted=counted, resolution=grid.resolution).right_ids
