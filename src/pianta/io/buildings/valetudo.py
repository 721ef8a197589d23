"""The segments of Valetudo's map JSON as the rooms of a floor, for a truth: what the robot and its owner agreed on."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from pianta.errors import BuildingError, MapError
from pianta.floor import Floor, Room
from pianta.floor.polygons import list_polygons
from pianta.io._files import short_repr
from pianta.io.buildings._findings import Findings, check_room_count
from pianta.io.buildings._formats import BuildingFormat, open_building
from pianta.io.valetudo import Segment, parse_vacuum_map

MAX_ID = 2**31 - 1
METRE_DIGITS = 6  # after the point
# Of the area of a segment that lies in other parts than its largest; less is left out without a word.
MAX_SCATTERED = 0.01


def read_valetudo_floor(path: str | Path) -> Floor:
    """Read the segments of Valetudo's map JSON as rooms, with the robot's names and ids, without doors.

    A room has the outline of its pixels, in metres; a point x, y is Valetudo's 100 x, -100 y. Ids that are no positive
    numbers, or occur twice, become the next free ones. A segment in several parts keeps its largest.

    Raises BuildingError, with every fault in one message.
    """
    file, content = open_building(path, BuildingFormat.VALETUDO)
    try:
        vacuum_map = parse_vacuum_map(content, file.name)
    except MapError as error:
        raise BuildingError(f"cannot read the building {short_repr(file)}: {error}") from None
    findings = Findings()
    check_room_count(len(vacuum_map.segments), "segments", findings)
    findings.raise_faults(file)
    side = vacuum_map.grid.resolution
    rooms = [
        Room(number, outline_runs(segment.runs, side, findings, segment.id), name=segment.name)
        for number, segment in _number_segments(vacuum_map.segments, findings)
    ]
    findings.warn(file)
    return Floor(tuple(rooms), source=file.name)


def outline_runs(runs: NDArray[np.int64], side: float, findings: Findings, name: str) -> Polygon:
    """The outline of the largest part of runs of pixels, in metres. side: of a pixel, metres."""
    left, top, length = runs.T
    shape = shapely.union_all(shapely.box(left, -(top + 1.0), left + length, -1.0 * top))
    parts = list_polygons(shape)
    largest = max(parts, key=lambda part: part.area)
    scattered = 1 - largest.area / shape.area
    if scattered > MAX_SCATTERED:
        text = f"segment {name!r} has {len(parts)} parts, {scattered:.0%} of it left out"
        findings.repairs[text] = None
    return Polygon(shapely.transform(largest.simplify(0), lambda points: np.round(points * side, METRE_DIGITS)))


def _number_segments(segments: tuple[Segment, ...], findings: Findings) -> Iterator[tuple[int, Segment]]:
    """The segments with their ids, those that are no ids of rooms with the next free ones."""
    valid_ids = {
        int(segment.id) for segment in segments if segment.id.isdecimal() and 0 < int(segment.id[:12] or 0) <= MAX_ID
    }
    used_ids: set[int] = set()
    for segment in segments:
        number = int(segment.id[:12]) if segment.id.isdecimal() else 0
        if number not in valid_ids or number in used_ids:
            number = max(valid_ids | used_ids, default=0) + 1
            findings.repairs[f"segment {segment.id[:40]!r} has the id {number} now"] = None
        used_ids.add(number)
        yield number, segment
