"""Doors of drawn buildings: a line in metres for what a file marks by a point, in both its rooms, or not at all."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LinearRing, LineString, Point, Polygon

from pianta.floor import Door, Floor, Room
from pianta.io.buildings._repair import DrawnRoom, Findings, remark_on_doors, remark_on_rooms

DOOR_WIDTH = 0.9
MAX_WALL = 1.0
MAX_DOORS_BETWEEN = 100


@dataclass(frozen=True)
class DrawnPortal:
    """A door as one of its rooms draws it; ends: shape (2, 2), metres, equal where the file marks a point."""

    room: DrawnRoom
    target: DrawnRoom
    ends: NDArray[np.float64]
    kind: Literal["door", "opening"] = "door"


def floor_of_portals(
    file: Path,
    rooms: Sequence[DrawnRoom],
    portals: Iterable[DrawnPortal],
    listed: Iterable[tuple[DrawnRoom, DrawnRoom]],
    findings: Findings,
) -> Floor:
    """The floor of rooms and portals; repairs and remarks go to the findings.

    listed: rooms that the file joins without a place; where no portal does, they get a door of DOOR_WIDTH in the
        middle of the wall between them.
    Raises BuildingError for faults.
    """
    findings.raise_faults(file)
    doors = join_portals(portals, width=DOOR_WIDTH, findings=findings)
    findings.raise_faults(file)
    joined = {door.rooms for door in doors}
    for pair in listed:
        first, second = sorted(pair, key=lambda room: room.number)
        numbers = first.number, second.number
        if numbers not in joined:
            joined.add(numbers)
            line = line_in_middle(first, second, DOOR_WIDTH, findings)
            doors.append(Door(numbers, line, line.length))
    floor = Floor(tuple(Room(room.number, room.outline, room.label) for room in rooms), tuple(doors), source=file.name)
    remark_on_rooms(rooms, door=DOOR_WIDTH, findings=findings)
    remark_on_doors(floor, findings)
    return floor


def join_portals(portals: Iterable[DrawnPortal], *, width: float, findings: Findings) -> list[Door]:
    """Doors of portals that may be drawn in both rooms, ordered by rooms.

    The two sides of a door are the portals of two rooms to each other that lie nearest, at most MAX_WALL metres apart;
    the door is the shorter of them, halfway through the wall. A point becomes a line of `width` metres along it.
    More than MAX_DOORS_BETWEEN doors from a room to another are a fault.
    """
    sides: dict[tuple[int, int], tuple[list[DrawnPortal], list[DrawnPortal]]] = {}
    for portal in portals:
        first, second = sorted((portal.room.number, portal.target.number))
        sides.setdefault((first, second), ([], []))[portal.room.number == second].append(portal)
    doors = []
    for rooms, (here, there) in sorted(sides.items()):
        if max(len(here), len(there)) > MAX_DOORS_BETWEEN:
            findings.faults.append(f"rooms {rooms[0]} and {rooms[1]} have more than {MAX_DOORS_BETWEEN} doors")
            continue
        for portal, other in _match_sides(here, there):
            line = _line_in_wall(portal, other, width)
            opening = "opening" in {portal.kind, (other or portal).kind}
            doors.append(Door(rooms, line, line.length, "opening" if opening else "door"))
    return doors


def _match_sides(
    here: Sequence[DrawnPortal], there: Sequence[DrawnPortal]
) -> list[tuple[DrawnPortal, DrawnPortal | None]]:
    """Each portal once, with its other side, or None where only one room draws it."""
    from scipy.optimize import linear_sum_assignment

    middles = [np.array([side.ends.mean(axis=0) for side in sides]).reshape(-1, 2) for sides in (here, there)]
    apart = np.linalg.norm(middles[0][:, None] - middles[1][None], axis=2)
    matched = {row: col for row, col in zip(*linear_sum_assignment(apart), strict=True) if apart[row, col] <= MAX_WALL}
    pairs = [(portal, there[matched[row]] if row in matched else None) for row, portal in enumerate(here)]
    return pairs + [(portal, None) for col, portal in enumerate(there) if col not in matched.values()]


def _line_in_wall(portal: DrawnPortal, other: DrawnPortal | None, width: float) -> LineString:
    lines = sorted((LineString(side.ends) for side in (portal, other) if side), key=lambda line: line.length)
    middle = lines[0].interpolate(0.5, normalized=True)
    through_wall = np.diff(shapely.get_coordinates(shapely.shortest_line(middle, lines[-1])), axis=0)[0]
    ends = shapely.get_coordinates(lines[0]) + through_wall / 2
    if np.ptp(ends, axis=0).any():
        return LineString(ends)
    return line_along_wall(ends[0], portal.room.outline, portal.target.outline, width)


def line_in_middle(first: DrawnRoom, second: DrawnRoom, width: float, findings: Findings) -> LineString:
    """A line of a width in the middle of the wall between two rooms, and a repair that says so."""
    findings.repairs[f"the door between {first} and {second} has no place, put in the middle of their wall"] = None
    middle = _middle_of_wall(first.outline.exterior, second.outline.exterior, reach=width / 4)
    return line_along_wall(middle, first.outline, second.outline, width)


def line_along_wall(middle: NDArray[np.float64], first: Polygon, second: Polygon, width: float) -> LineString:
    """Of the lines of a width through a point, along walls near it, the one whose ends lie nearest to both outlines."""
    rings = np.array([first.exterior, second.exterior])
    steps = np.concatenate([_directions_of_walls(ring, middle, reach=width / 4) for ring in rings]) * width / 2
    ends = np.stack([middle - steps, middle + steps], axis=1)
    off = shapely.distance(rings[:, None, None], shapely.points(ends)).sum(axis=(0, 2))
    return LineString(ends[np.argmin(off)])


def _directions_of_walls(ring: LinearRing, place: NDArray[np.float64], *, reach: float) -> NDArray[np.float64]:
    """Unit vectors, shape (N, 2), of the edges of a ring that are at most `reach` further off than the nearest."""
    corners = shapely.get_coordinates(ring)
    corners = corners[np.append(True, np.diff(corners, axis=0).any(axis=1))]
    away = shapely.distance(shapely.linestrings(np.stack([corners[:-1], corners[1:]], axis=1)), Point(place))
    along = np.diff(corners, axis=0)[away <= away.min() + reach]
    return np.asarray(along / np.linalg.norm(along, axis=1, keepdims=True))


def _middle_of_wall(first: LinearRing, second: LinearRing, *, reach: float) -> NDArray[np.float64]:
    """Middle of the longest piece of one outline that is at most `reach` further from the other than the nearest."""
    near = shapely.line_merge(first.intersection(second.buffer(first.distance(second) + reach)))
    if near.is_empty:  # far apart, where a buffer's polygonal corners fall short
        near = shapely.shortest_line(first, second)
    longest = max(shapely.get_parts(near), key=lambda part: part.length)
    middle = first.interpolate(first.project(longest.centroid))
    return np.array(middle.coords[0])
