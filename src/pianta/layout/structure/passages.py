"""Passages between rooms: the lines along which a layout was cut, as doors and openings."""

from __future__ import annotations

from collections.abc import Collection
from typing import Literal

import numpy as np
import shapely
from shapely import LineString

from pianta._types import Floats
from pianta.floor import Door
from pianta.layout._canvas import Canvas
from pianta.layout.structure.pieces import Borders

# A passage is an opening when it is this many times as wide as the one in the middle of all.
WIDE = 2.0


def list_passages(
    borders: Borders, rooms: Collection[int], canvas: Canvas, *, least: float, door_width: float
) -> list[Door]:
    """Doors and openings, in the map frame, where borders part two rooms, or a room from what is none: an entrance.

    borders: on the canvas, in cells; both ends of a line are the nearest cells of the two jambs. rooms: the labels that
    are rooms, and their ids.
    least: narrower passages are none; metres. door_width: wider ones are openings, as are those twice as wide as the
    one in the middle of all; metres.
    """
    # An obstacle ends half a cell before its centre.
    widths = np.maximum(borders.opening - canvas.resolution, 0)
    chosen = [
        i for i, sides in enumerate(borders.sides.tolist()) if widths[i] >= least and not set(sides).isdisjoint(rooms)
    ]
    limit = min(WIDE * float(np.median(widths[chosen])), door_width) if chosen else door_width
    found: dict[tuple[int, int | None], list[Door]] = {}
    for i in chosen:
        one, other = sorted(borders.sides[i].tolist(), key=lambda label: (label not in rooms, label))
        pair = (one, other if other in rooms else None)
        kind: Literal["door", "opening"] = "door" if widths[i] <= limit else "opening"
        passage = LineString(canvas.to_map(_trim_line(borders.lines[i], canvas)))
        found.setdefault(pair, []).append(Door(pair, passage, float(widths[i]), kind))
    return [door for doors in found.values() for door in _drop_repeated(doors)]


def _drop_repeated(doors: list[Door]) -> list[Door]:
    """Doors of one pair of rooms, without those whose middle is in that of a narrower one: one gap, cut twice."""
    kept: list[Door] = []
    for door in sorted(doors, key=lambda door: (door.width, door.line.coords[0])):
        middle = door.line.interpolate(0.5, normalized=True)
        others = [(other.line.interpolate(0.5, normalized=True), max(door.width, other.width) / 2) for other in kept]
        if all(middle.distance(other) >= reach for other, reach in others):
            kept.append(door)
    return kept


def _trim_line(line: Floats, canvas: Canvas) -> shapely.Geometry:
    """Line between the centres of two cells, shape (2, 2), less half a cell at each end; metres of the canvas."""
    ends = line[:, ::-1] + 0.5
    length = max(float(np.hypot(*(ends[1] - ends[0]))), 1.0)
    inward = (ends[::-1] - ends) / length / 2
    return LineString((ends + inward) * canvas.resolution)
