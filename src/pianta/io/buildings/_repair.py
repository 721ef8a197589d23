"""What the readers of drawn buildings share: outlines made valid, labels, and everything found wrong, told at once."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Literal

import networkx as nx
import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LinearRing, LineString, Point, Polygon, STRtree

from pianta.errors import BuildingError, BuildingWarning
from pianta.floor import Door, Floor, Room
from pianta.io._faults import join_faults
from pianta.io._files import short_repr

MAX_ROOMS = 1000
MAX_CORNERS, MAX_REPAIRED_CORNERS = 2000, 300
MAX_PORTALS = 20_000
MAX_OVERLAP = 0.1  # of the smaller room, as the data's table of defects counts
DOOR_WIDTH = 0.9
MAX_WALL = 1.0
MAX_DOORS_BETWEEN = 100


@dataclass(frozen=True)
class DrawnRoom:
    """A room of a file; its outline is in metres, and empty where the file has none that encloses anything."""

    number: int
    label: str | None
    outline: Polygon

    def __str__(self) -> str:
        return name_of_room(self.number, self.label)


@dataclass
class Findings:
    """What is wrong with a file: faults forbid a floor, repairs were made, remarks are defects that stay.

    Repairs are keys, because each door is listed in both its rooms and its defects count once.
    """

    faults: list[str] = field(default_factory=list)
    repairs: dict[str, None] = field(default_factory=dict)
    remarks: list[str] = field(default_factory=list)

    def raise_faults(self, file: Path) -> None:
        """Raises BuildingError, with every fault in one message, when there is one."""
        if self.faults:
            raise BuildingError(f"cannot read the building {short_repr(file)}: {join_faults(self.faults)}")

    def tell(self, file: Path) -> None:
        """One BuildingWarning for all that was repaired or stays, at the caller of the reader."""
        told = [f"was repaired: {join_faults(list(self.repairs))}"] if self.repairs else []
        told += [f"has defects that stay: {join_faults(self.remarks)}"] if self.remarks else []
        if told:
            warnings.warn(f"building {short_repr(file)} {', and '.join(told)}", BuildingWarning, stacklevel=3)


def name_of_room(number: int, label: str | None) -> str:
    """How messages call a room."""
    return f"room {number} ({label})"


def normalize_label(text: str | None) -> str | None:
    """A label in capitals with single blanks, None for an empty one; whether anybody knows it is not asked."""
    return " ".join((text or "").split()).upper() or None


def check_room_count(count: int, place: str, findings: Findings) -> None:
    """Find a floor without rooms, and one of so many that comparing all of them would take forever."""
    if not 1 <= count <= MAX_ROOMS:
        findings.faults.append(f"it has {count} rooms ({place}), give a floor of 1 to {MAX_ROOMS}")


def check_portal_count(count: int, findings: Findings) -> None:
    """Find a floor of so many portals that placing them all would take forever."""
    if count > MAX_PORTALS:
        findings.faults.append(f"it has {count} portals, give at most {MAX_PORTALS}")


def refuse_repeated(names: Iterable[str | None], what: str, findings: Findings) -> None:
    """Find names, or other ids as `what` calls them, that more than one room has; rooms without are passed by."""
    repeated = [(name, count) for name, count in Counter(names).items() if name and count > 1]
    findings.faults += [f"{count} rooms have the {what} {short_repr(name)}" for name, count in repeated]


def polygon_of_corners(corners: NDArray[np.float64], name: str, findings: Findings) -> Polygon:
    """The outline through corners, shape (N, 2), as a valid polygon.

    Of one that meets itself the largest part stays. One that encloses nothing is a fault, and so is one of more
    than MAX_CORNERS, or MAX_REPAIRED_CORNERS when it meets itself, because it may do so as often as the square of that;
    they come out empty.
    """
    if len(corners) > MAX_CORNERS:
        findings.faults.append(f"{name} has an outline of {len(corners)} corners, give at most {MAX_CORNERS}")
        return Polygon()
    outline = Polygon(corners) if len(corners) >= 3 else Polygon()
    if outline.is_valid and outline.area > 0:
        return outline
    if len(corners) > MAX_REPAIRED_CORNERS:
        text = f"{name} has an outline of {len(corners)} corners that meets itself"
        findings.faults.append(f"{text}, too many to repair it, draw it without crossings")
        return Polygon()
    parts = shapely.get_parts(shapely.make_valid(outline, method="structure", keep_collapsed=False))
    areas = shapely.area(parts)
    if not areas.any():
        findings.faults.append(f"{name} has an outline without area, give at least 3 corners")
        return Polygon()
    share = areas.max() / areas.sum()
    findings.repairs[f"the outline of {name} meets itself, kept the largest part ({share:.1%})"] = None
    largest: Polygon = parts[areas.argmax()]
    return largest


def remark_on_rooms(rooms: Sequence[DrawnRoom], *, door: float, findings: Findings) -> None:
    """Find rooms that overlap, and those that hold no square as wide as a door.

    Which of two rooms is drawn wrong cannot be known, so they stay.
    door: width of a door, metres.
    """
    outlines = np.array([room.outline for room in rooms])
    areas = shapely.area(outlines)
    tiny = [f"{rooms[index]} has {areas[index]:.2g} m²" for index in np.flatnonzero(areas < door**2).tolist()]
    findings.remarks += [f"{text}, less than a square as wide as a door" for text in tiny]
    pairs = STRtree(outlines).query(outlines, predicate="intersects")
    pairs = pairs[:, pairs[0] < pairs[1]]
    shared = shapely.area(shapely.intersection(*outlines[pairs])) / areas[pairs].min(axis=0)
    for (first, second), share in zip(pairs.T.tolist(), shared.tolist(), strict=True):
        if share > MAX_OVERLAP:
            text = f"{rooms[first]} and {rooms[second]} overlap by {share:.0%} of the smaller one"
            findings.remarks.append(text)


def remark_on_doors(floor: Floor, findings: Findings) -> None:
    """Find rooms without a door, and groups of rooms that no door joins; a floor of areas without any door has none."""
    if not floor.doors:
        return
    labels = {room.id: room.label for room in floor.rooms}
    groups = list(nx.connected_components(floor.graph()))
    alone = sorted(chain.from_iterable(group for group in groups if len(group) == 1))
    if alone:
        rooms = ", ".join(name_of_room(room_id, labels[room_id]) for room_id in alone)
        findings.remarks.append(f"no door leads to {rooms}")
    joined = len(groups) - len(alone)
    if joined > 1:
        findings.remarks.append(f"its rooms form {joined} groups without a door from one to another")


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
