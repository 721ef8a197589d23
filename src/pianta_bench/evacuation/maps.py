"""Ways out on floors that pianta reads from robots' maps, against the ways on the drawn floors of these maps."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from math import isfinite
from pathlib import Path
from statistics import fmean, median

import shapely

from pianta.errors import DataError
from pianta.evacuation.evacuate import evacuate
from pianta.evacuation.evacuation import Evacuation
from pianta.evacuation.exits import find_exits
from pianta.evacuation.people import DEFAULT_DENSITY
from pianta.floor import Floor
from pianta.io.maps import read_map
from pianta.layout.reconstruct import reconstruct
from pianta_bench.data.annotated_floors import read_drawing
from pianta_bench.data.folders import SLAM_FOLDER, SLAM_RESOLUTION, SLAM_TRUTH, find_data, list_maps
from pianta_bench.harness.records import Figures, Results, Track

MAPS = "maps of schools"
MIN_IOU = 0.5  # of a true room and the same room on the map
MIN_OVERLAP = 0.5  # share of a true exit that the room on the map covers


def measure_maps(data: Path | None = None, *, track: Track = iter) -> Results:
    """Evacuate the floors that are read from the maps of data/slam, and their drawn floors; one record for each figure.

    A map on which no exit is found has no records.
    track: wraps the names of the maps, to show progress.
    Raises DataError if there are no maps.
    """
    folder = find_data(data) / SLAM_FOLDER
    results = Results()
    for name in track(list_maps(folder, SLAM_TRUTH)):
        results.measure(MAPS, name, partial(_measure_map, folder, name))
    return results


def _measure_map(folder: Path, name: str) -> Iterator[Figures]:
    grid = read_map(folder / f"{name}.png", resolution=SLAM_RESOLUTION)
    true = read_drawing(folder / f"{name}{SLAM_TRUTH}", grid=grid)
    yield compare_floors(reconstruct(grid, predict_partial=False), true)


def compare_floors(floor: Floor, true: Floor) -> Figures:
    """Figures of a floor of a map against the true one; exits are where they are in truth, all rooms have one density.

    Rooms are the same that overlap most, with an IoU of MIN_IOU at least.
    Raises DataError if no room on the map covers a true exit.
    """
    true_exits = sorted(find_exits(true).rooms)
    exits = [room for exit_room in true_exits if (room := _cover(floor, true, exit_room)) is not None]
    if not exits:
        raise DataError("no room on the map covers an exit, leave the map out")
    expected = evacuate(true, exits=true_exits, density=DEFAULT_DENSITY)
    measured = evacuate(floor, exits=exits, density=DEFAULT_DENSITY)
    return {
        "exits": len({*exits}) / len(true_exits),
        **_compare_rooms(measured, expected),
        "longest, truth": expected.longest.longest,
        "longest, map": measured.longest.longest,
        "one way, truth": len(expected.one_way) / (len(true) - len(true_exits)),
        "one way, map": len(measured.one_way) / (len(floor) - len({*exits})),
    }


def _cover(floor: Floor, true: Floor, room: int) -> int | None:
    """The room on the map that covers most of a true one, None if that is less than MIN_OVERLAP."""
    polygon = true[room].polygon
    areas = {each.id: each.polygon.intersection(polygon).area for each in floor.rooms}
    best = max(areas, key=lambda room_id: areas[room_id])
    return best if areas[best] >= MIN_OVERLAP * polygon.area else None


def _compare_rooms(measured: Evacuation, expected: Evacuation) -> dict[str, float | None]:
    """Share of true rooms on the map, and of these the errors of ways and of whether they have one way out."""
    same = _match_rooms(measured.floor, expected.floor)
    ways = {way.room: way for way in measured.ways}
    true_ways = [way for way in expected.ways if way.room not in expected.exit_rooms and isfinite(way.longest)]
    pairs = [(ways[same[way.room]], way) for way in true_ways if way.room in same]
    reached = [(way, true) for way, true in pairs if isfinite(way.longest)]
    agreement = [way.has_one_way == true.has_one_way for way, true in reached]
    return {
        "rooms": len(pairs) / len(true_ways),
        "no way": 1 - len(reached) / len(pairs) if pairs else None,
        "error": median(abs(way.longest - true.longest) for way, true in reached) if reached else None,
        "relative error": median(abs(way.longest / true.longest - 1) for way, true in reached) if reached else None,
        "agreement": fmean(agreement) if agreement else None,
        "agreement by chance": _measure_majority([true.has_one_way for _, true in reached]),
    }


def _measure_majority(values: list[bool]) -> float | None:
    """The agreement of the answer that is right most often on this map."""
    return max(fmean(values), 1 - fmean(values)) if values else None


def _match_rooms(floor: Floor, true: Floor) -> Mapping[int, int]:
    """True rooms and the same rooms on the map, by their ids."""
    pairs = {}
    polygons = [room.polygon for room in floor.rooms]
    for room in true.rooms:
        shared = shapely.area(shapely.intersection(polygons, room.polygon))
        index = int(shared.argmax())
        if shared[index] >= MIN_IOU * (polygons[index].area + room.polygon.area - shared[index]):
            pairs[room.id] = floor.rooms[index].id
    return pairs
