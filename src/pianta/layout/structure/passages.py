"""Passages between rooms: the lines along which a layout was cut, as doors and openings."""

from __future__ import annotations

from collections.abc import Collection
from typing import Literal

import numpy as np
import shapely
from shapely import LineString

from pianta._types import Floats
from pianta.floor import Door
from pianta.layout._working_grid import WorkingGrid
from pianta.layout.structure.regions import Separators

# A passage of more than this many times the median width is an opening (chosen by hand).
OPENING_RATIO = 2.0


def list_passages(
    separators: Separators, rooms: Collection[int], working_grid: WorkingGrid, *, min_width: float, door_width: float
) -> list[Door]:
    """Doors and openings, in the map frame, where separators divide two rooms, or lead out of a room: entrances.

    separators: on the working grid, in cells; the ends of a line are the nearest cells of the two jambs.
    rooms: labels that are rooms, and are their ids.
    min_width: narrower passages are ignored; metres. door_width: wider passages are openings, as are those of more than
    twice the median width; metres.
    """
    # An obstacle ends half a cell before its centre.
    widths = np.maximum(separators.opening - working_grid.resolution, 0)
    used = [
        i
        for i, sides in enumerate(separators.sides.tolist())
        if widths[i] >= min_width and not set(sides).isdisjoint(rooms)
    ]
    limit = min(OPENING_RATIO * float(np.median(widths[used])), door_width) if used else door_width
    doors: dict[tuple[int, int | None], list[Door]] = {}
    for i in used:
        one, other = sorted(separators.sides[i].tolist(), key=lambda label: (label not in rooms, label))
        pair = (one, other if other in rooms else None)
        door_kind: Literal["door", "opening"] = "door" if widths[i] <= limit else "opening"
        line = LineString(working_grid.to_map(_trim_line(separators.lines[i], working_grid)))
        doors.setdefault(pair, []).append(Door(pair, line, float(widths[i]), door_kind))
    return [door for pair_doors in doors.values() for door in _drop_repeated(pair_doors)]


def _drop_repeated(doors: list[Door]) -> list[Door]:
    """Doors between two rooms, without those whose middle is within a narrower one: the same gap, cut twice."""
    distinct: list[Door] = []
    for door in sorted(doors, key=lambda door: (door.width, door.line.coords[0])):
        middle = door.line.interpolate(0.5, normalized=True)
        others = [
            (other.line.interpolate(0.5, normalized=True), max(door.width, other.width) / 2) for other in distinct
        ]
        if all(middle.distance(other) >= reach for other, reach in others):
            distinct.append(door)
    return distinct


def _trim_line(line: Floats, working_grid: WorkingGrid) -> shapely.Geometry:
    """Line between the centres of two cells, shape (2, 2), less half a cell at each end; metres of the working grid."""
    ends = line[:, ::-1] + 0.5
    length = max(float(np.hypot(*(ends[1] - ends[0]))), 1.0)
    inward = (ends[::-1] - ends) / length / 2
    return LineString((ends + inward) * working_grid.resolution)
