"""Ways out of annotated schools and offices, by `pianta.evacuate` with its defaults."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from math import isfinite
from pathlib import Path
from statistics import median

from pianta.evacuation.evacuate import evacuate
from pianta.evacuation.evacuation import Evacuation
from pianta.io.buildings.thesis_xml import read_building_xml
from pianta_bench.data.folders import find_data, list_maps
from pianta_bench.evacuation.maps import measure_maps
from pianta_bench.graphs.measure import PARTS
from pianta_bench.harness.records import Figures, Results, Track


def measure(data: Path | None = None, *, maps: bool = False, track: Track = iter) -> Results:
    """Evacuate each floor of data/buildings/school/*.xml and office/*.xml; one record for each figure.

    A floor without a known exit, or that cannot be read, has no records.
    maps: measure robots' maps instead, against their drawn floors. track: wraps the names, to show progress.
    Raises DataError if there are no buildings of a type, or no maps.
    """
    if maps:
        return measure_maps(data, track=track)
    folder = find_data(data) / "buildings"
    names = [(building_type, name) for building_type in PARTS for name in list_maps(folder / building_type, ".xml")]
    results = Results()
    for (building_type, name), _ in zip(names, track([f"{each}/{name}" for each, name in names]), strict=True):
        measure_one = partial(_measure_file, folder / building_type / f"{name}.xml")
        results.measure(PARTS[building_type], name, measure_one)
    return results


def _measure_file(file: Path) -> Iterator[Figures]:
    yield describe_evacuation(evacuate(read_building_xml(file)))


def describe_evacuation(evacuation: Evacuation) -> Figures:
    """Figures of a floor, over its rooms that are no exits; lengths and times of those that have a way out."""
    ways = [way for way in evacuation.ways if way.room not in evacuation.exit_rooms]
    reached = [way for way in ways if isfinite(way.longest)]
    dead_ends = [way.dead_end for way in reached if way.dead_end is not None]
    # Doors whose loss leaves every room a way: what they cost is time alone.
    bypassed = [door.time_if_shut - evacuation.time for door in evacuation.doors if not door.cut_off]
    return {
        "exits": len(evacuation.exit_rooms) + len(evacuation.exit_doors),
        "people": evacuation.people,
        "median way": median(way.distance for way in reached),
        "median farthest": median(way.longest for way in reached),
        "longest": evacuation.longest.longest,
        "one way": len(evacuation.one_way) / len(ways),
        "dead ends": len(evacuation.dead_ends) / len(ways),
        "longest dead end": max(dead_ends, default=None),
        "no way": 1 - len(reached) / len(ways),
        "worst door": max((len(door.cut_off) for door in evacuation.doors), default=0) / len(ways),
        "time": evacuation.time,
        "time without queues": evacuation.time_without_queues,
        "delay": max(bypassed, default=None),
    }
