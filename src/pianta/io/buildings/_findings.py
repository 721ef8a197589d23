"""Shared by the readers of drawn buildings: findings (faults, lost rooms, repairs, remarks), outlines, doors."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeVar

import networkx as nx
import numpy as np
import shapely
from shapely import LinearRing, LineString, Point, Polygon, STRtree

from pianta._types import Floats
from pianta.errors import BuildingError, BuildingWarning
from pianta.floor import DOOR_WIDTH, Door, Floor, Room
from pianta.io._faults import join_faults
from pianta.io._files import short_repr
from pianta.io._xml import parse_number

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

# Limits against hostile files; the work grows with the square of each.
MAX_ROOMS = 1000  # on a floor
MAX_CORNERS = 2000  # of an outline
MAX_REPAIRED_CORNERS = 300  # of an outline that meets itself
MAX_PORTALS = 20_000  # on a floor
MAX_DOORS_BETWEEN = 100  # two rooms

MAX_OVERLAP = 0.1  # share of the smaller room; as in the table of defects that comes with the data
MAX_WALL = 1.0  # metres between the two portals of a door; chosen by hand


@dataclass(frozen=True)
class DrawnRoom:
    """A room of a file; the outline is in metres, and empty if the file has none that can be read.

    name: of the room in the file, to which doors lead; empty if it has none.
    """

    number: int
    label: str | None
    outline: Polygon
    name: str

    def __str__(self) -> str:
        return describe_room(self.number, self.label)


class DefectWarning(BuildingWarning):
    """The repairs and remarks of a file whose rooms were all read.

    repairs, remarks: how many.
    """

    def __init__(self, message: str, repairs: int = 0, remarks: int = 0) -> None:
        super().__init__(message)
        self.repairs = repairs
        self.remarks = remarks


@dataclass
class Findings:
    """Defects of a file: faults prevent a floor, lost rooms are left out, repairs have been made, remarks stay.

    Repairs are keys of a dict, because both rooms list a door and its defect counts once.
    """

    faults: list[str] = field(default_factory=list)
    lost_rooms: list[str] = field(default_factory=list)
    repairs: dict[str, None] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def raise_faults(self, file: Path) -> None:
        """Raise BuildingError, with all faults in one message, if there are any."""
        if self.faults:
            faults = join_faults([*self.faults, *self.lost_rooms])
            raise BuildingError(f"cannot read the building {short_repr(file)}: {faults}")

    def warn(self, file: Path) -> None:
        """Give one BuildingWarning for all lost rooms, repairs and remarks, at the caller of the reader."""
        parts = [f"is read without some of its rooms: {join_faults(self.lost_rooms)}"] if self.lost_rooms else []
        parts += [f"was repaired: {join_faults(list(self.repairs))}"] if self.repairs else []
        parts += [f"has defects that stay: {join_faults(self.remarks)}"] if self.remarks else []
        message = f"building {short_repr(file)} {', and '.join(parts)}"
        if self.lost_rooms:
            warnings.warn(BuildingWarning(message), stacklevel=3)
        elif parts:
            warnings.warn(DefectWarning(message, len(self.repairs), len(self.remarks)), stacklevel=3)


AnyRoom = TypeVar("AnyRoom", bound=DrawnRoom)


def describe_room(number: int, label: str | None) -> str:
    """A room in messages."""
    return f"room {number} ({label})"


def check_room_count(count: int, source: str, findings: Findings) -> None:
    """Add a fault unless there are 1 to MAX_ROOMS rooms; source: the elements of the file that are rooms."""
    if not 1 <= count <= MAX_ROOMS:
        findings.faults.append(f"it has {count} rooms ({source}), give a floor of 1 to {MAX_ROOMS}")


def check_portal_count(count: int, findings: Findings) -> None:
    """Add a fault for more than MAX_PORTALS portals."""
    if count > MAX_PORTALS:
        findings.faults.append(f"it has {count} portals, give at most {MAX_PORTALS}")


def keep_rooms(rooms: Iterable[AnyRoom], findings: Findings) -> list[AnyRoom]:
    """The rooms that have an outline, each once: of copies with one name and outline the first stays.

    A fault is added if no room remains.
    """
    remaining: list[AnyRoom] = []
    for room in rooms:
        originals = (other for other in remaining if room.name and other.name == room.name)
        original = next((other for other in originals if other.outline.equals(room.outline)), None)
        if original:
            findings.lost_rooms.append(f"{room} is a copy of {original}")
        elif not room.outline.is_empty:
            remaining.append(room)
    if findings.lost_rooms and not remaining:
        findings.faults.append("none of its rooms can be read")
    return remaining


def rooms_by_name(rooms: Iterable[AnyRoom], what: str, findings: Findings) -> dict[str, AnyRoom]:
    """The rooms whose name no other room has; what: the noun for the names.

    A name of several rooms names none: both stay, with the doors that they list themselves.
    """
    by_name: dict[str, list[AnyRoom]] = {}
    for room in rooms:
        by_name.setdefault(room.name, []).append(room)
    by_name.pop("", None)
    for name, same in by_name.items():
        if len(same) > 1:
            text = f"{len(same)} rooms have the {what} {short_repr(name)}"
            findings.repairs[f"{text}, the doors that other rooms list to it are left out"] = None
    return {name: same[0] for name, same in by_name.items() if len(same) == 1}


def find_target(room: AnyRoom, name: str, by_name: Mapping[str, AnyRoom], findings: Findings) -> AnyRoom | None:
    """The room behind a door; None, and a repair, if it is this one or was not read."""
    target = None if name == room.name else by_name.get(name)
    if target is None:
        findings.repairs[f"a door of {room} does not join two rooms, left out"] = None
    return target


def read_points(points: Iterable[Element], *, limit: float, name: str, defects: list[str]) -> Floats:
    """The x, y attributes of elements, shape (N, 2); faulty ones are nan, and defects of the room called name."""
    numbers = []
    for point in points:
        x, y = (parse_number(point.get(axis), limit=limit) for axis in "xy")
        if isnan(x) or isnan(y):
            text = f"x={short_repr(point.get('x'))}, y={short_repr(point.get('y'))}"
            defects.append(f"{name} has a point {text}, give two numbers up to {limit:.0f}")
        numbers.append((x, y))
    return np.array(numbers).reshape(-1, 2)


def polygon_of_corners(corners: Floats, name: str, findings: Findings, *, defects: list[str]) -> Polygon:
    """The outline through corners, shape (N, 2), as a valid polygon; empty if it has no area.

    An outline that meets itself is reduced to its largest part. Defects are an outline without area, one of more than
    MAX_CORNERS, and one that meets itself and has more than MAX_REPAIRED_CORNERS.
    defects: the list to which they are added. Corners that are nan have been added already.
    """
    if len(corners) > MAX_CORNERS:
        defects.append(f"{name} has an outline of {len(corners)} corners, give at most {MAX_CORNERS}")
        return Polygon()
    if np.isnan(corners).any():
        return Polygon()
    outline = Polygon(corners) if len(corners) >= 3 else Polygon()
    if outline.is_valid and outline.area > 0:
        return outline
    if len(corners) > MAX_REPAIRED_CORNERS:
        text = f"{name} has an outline of {len(corners)} corners that meets itself"
        defects.append(f"{text}, too many to repair it, draw it without crossings")
        return Polygon()
    parts = shapely.get_parts(shapely.make_valid(outline, method="structure", keep_collapsed=False))
    areas = shapely.area(parts)
    if not areas.any():
        defects.append(f"{name} has an outline without area, give at least 3 corners")
        return Polygon()
    share = areas.max() / areas.sum()
    findings.repairs[f"the outline of {name} meets itself, kept the largest part ({share:.1%})"] = None
    largest: Polygon = parts[areas.argmax()]
    return largest


def check_rooms(rooms: Sequence[DrawnRoom], *, door_width: float, findings: Findings) -> None:
    """Remark on rooms that overlap, and on those smaller than a square as wide as a door (metres).

    Which of two rooms is drawn wrong is unknown, so both stay.
    """
    outlines = np.array([room.outline for room in rooms])
    areas = shapely.area(outlines)
    tiny = [f"{rooms[index]} has {areas[index]:.2g} m²" for index in np.flatnonzero(areas < door_width**2).tolist()]
    findings.remarks += [f"{text}, less than a square as wide as a door" for text in tiny]
    pairs = STRtree(outlines).query(outlines, predicate="intersects")
    pairs = pairs[:, pairs[0] < pairs[1]]
    shared = shapely.area(shapely.intersection(*outlines[pairs])) / areas[pairs].min(axis=0)
    for (first, second), share in zip(pairs.T.tolist(), shared.tolist(), strict=True):
        if share > MAX_OVERLAP:
            text = f"{rooms[first]} and {rooms[second]} overlap by {share:.0%} of the smaller one"
            findings.remarks.append(text)


def check_doors(floor: Floor, findings: Findings) -> None:
    """Remark on rooms without a door and on groups of rooms that no door joins; not if it has no door at all."""
    if not floor.doors:
        return
    labels = {room.id: room.label for room in floor.rooms}
    groups = list(nx.connected_components(floor.graph()))
    alone = sorted(chain.from_iterable(group for group in groups if len(group) == 1))
    if alone:
        rooms = ", ".join(describe_room(room_id, labels[room_id]) for room_id in alone)
        findings.remarks.append(f"no door leads to {rooms}")
    joined = len(groups) - len(alone)
    if joined > 1:
        findings.remarks.append(f"its rooms form {joined} groups without a door from one to another")


@dataclass(frozen=True)
class DrawnPortal:
    """A door as drawn in one of its rooms; ends: shape (2, 2), metres, equal if the file marks a point."""

    room: DrawnRoom
    target: DrawnRoom
    ends: Floats
    kind: Literal["door", "opening"] = "door"


def floor_of_portals(
    file: Path,
    rooms: Sequence[DrawnRoom],
    portals: Iterable[DrawnPortal],
    listed: Iterable[tuple[DrawnRoom, DrawnRoom]],
    findings: Findings,
) -> Floor:
    """The floor of rooms and portals, after all checks.

    listed: pairs of rooms that the file joins at no position; those without a portal get a door of DOOR_WIDTH in the
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
    check_rooms(rooms, door_width=DOOR_WIDTH, findings=findings)
    check_doors(floor, findings)
    return floor


def join_portals(portals: Iterable[DrawnPortal], *, width: float, findings: Findings) -> list[Door]:
    """Doors of portals, ordered by rooms; a door may have a portal in each of its rooms.

    The two sides of a door are the nearest portals of two rooms to each other, at most MAX_WALL metres apart; the door
    is the shorter of them, halfway through the wall. A point becomes a line of `width` metres along the wall.
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
    """Each portal once, with its other side; None if only one room draws it."""
    from scipy.optimize import linear_sum_assignment

    middles = [np.array([side.ends.mean(axis=0) for side in sides]).reshape(-1, 2) for sides in (here, there)]
    distances = np.linalg.norm(middles[0][:, None] - middles[1][None], axis=2)
    matched = {
        row: col for row, col in zip(*linear_sum_assignment(distances), strict=True) if distances[row, col] <= MAX_WALL
    }
    pairs = [(portal, there[matched[row]] if row in matched else None) for row, portal in enumerate(here)]
    return pairs + [(portal, None) for col, portal in enumerate(there) if col not in matched.values()]


def _line_in_wall(portal: DrawnPortal, other: DrawnPortal | None, width: float) -> LineString:
    """The shorter portal of a door, moved halfway to the other; for a point, a line of `width` metres along a wall."""
    lines = sorted((LineString(side.ends) for side in (portal, other) if side), key=lambda line: line.length)
    middle = lines[0].interpolate(0.5, normalized=True)
    through_wall = np.diff(shapely.get_coordinates(shapely.shortest_line(middle, lines[-1])), axis=0)[0]
    ends = shapely.get_coordinates(lines[0]) + through_wall / 2
    if np.ptp(ends, axis=0).any():
        return LineString(ends)
    return line_along_wall(ends[0], portal.room.outline, portal.target.outline, width)


def line_in_middle(first: DrawnRoom, second: DrawnRoom, width: float, findings: Findings) -> LineString:
    """A door line in the middle of the wall between two rooms, width in metres; adds a repair."""
    findings.repairs[f"the door between {first} and {second} has no place, put in the middle of their wall"] = None
    middle = _middle_of_wall(first.outline.exterior, second.outline.exterior, reach=width / 4)
    return line_along_wall(middle, first.outline, second.outline, width)


def line_along_wall(middle: Floats, first: Polygon, second: Polygon, width: float) -> LineString:
    """The line of `width` metres through a point, along a wall near it, whose ends are nearest to both outlines."""
    rings = np.array([first.exterior, second.exterior])
    steps = np.concatenate([_directions_of_walls(ring, middle, reach=width / 4) for ring in rings]) * width / 2
    ends = np.stack([middle - steps, middle + steps], axis=1)
    distances = shapely.distance(rings[:, None, None], shapely.points(ends)).sum(axis=(0, 2))
    return LineString(ends[np.argmin(distances)])


def _directions_of_walls(ring: LinearRing, point: Floats, *, reach: float) -> Floats:
    """Unit vectors, shape (N, 2), of the nearest edge of a ring and all edges at most `reach` further away."""
    corners = shapely.get_coordinates(ring)
    corners = corners[np.append(True, np.diff(corners, axis=0).any(axis=1))]
    distances = shapely.distance(shapely.linestrings(np.stack([corners[:-1], corners[1:]], axis=1)), Point(point))
    along = np.diff(corners, axis=0)[distances <= distances.min() + reach]
    return np.asarray(along / np.linalg.norm(along, axis=1, keepdims=True))


def _middle_of_wall(first: LinearRing, second: LinearRing, *, reach: float) -> Floats:
    """Middle of the longest piece of the first ring that is within `reach` of its least distance to the second."""
    near = shapely.line_merge(first.intersection(second.buffer(first.distance(second) + reach)))
    if near.is_empty:  # far apart: the polygonal corners of the buffer do not reach the ring
        near = shapely.shortest_line(first, second)
    longest = max(shapely.get_parts(near), key=lambda part: part.length)
    middle = first.interpolate(first.project(longest.centroid))
    return np.array(middle.coords[0])
