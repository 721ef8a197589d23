"""MIT XML: floor plans of the campus of MIT (Whiting, Battat and Teller, CAAD Futures 2007).

A file is one floor of one building. Each `space` has a contour of points and portals to other spaces, by their names,
at a position along an edge of the contour.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np
from shapely.affinity import translate

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.io._files import short_repr
from pianta.io._xml import parse_number
from pianta.io.buildings._findings import (
    DrawnPortal,
    DrawnRoom,
    Findings,
    check_portal_count,
    check_room_count,
    describe_room,
    find_target,
    floor_of_portals,
    keep_rooms,
    polygon_of_corners,
    read_points,
    rooms_by_name,
)
from pianta.io.buildings._formats import BuildingFormat, open_building
from pianta.labels import normalize_label

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MAX_COORDINATE = 1e8  # feet or metres; beyond any state plane
METRES = {"foot": 1200 / 3937, "metre": 1.0}  # US survey foot, the unit of state planes


def read_mit_xml(path: str | Path, *, unit: Literal["foot", "metre"] = "foot") -> Floor:
    """Read a floor from a MIT XML, rooms numbered from 1 in the order of the file.

    unit: of the coordinates, which are in a Massachusetts state plane, around 10^5. The file does not name it; the US
        survey foot, usual for plans there, is an assumption, which the size of a door or of a room can confirm.

    The floor is in metres, x east and y north, with its origin in the lower left corner of all contours. Labels are the
    file's types, such as P CIRC, in capitals.

    A horizontal portal is a door of 0.9 m at its position; one with several positions spans them. An implicit one is an
    opening as wide as its edge, the shorter one of the two rooms. The portals of both rooms are one Door. Vertical
    portals (stairs, lifts) lead to other files and are not read, not even as entrances; a portal to a space that the
    file does not have is left out, and one without a position is put in the middle of the wall between its rooms.

    One BuildingWarning lists all defects, which are treated as in read_building_xml.
    Raises BuildingError, with every fault in one message, for what cannot be repaired; OptionError for another unit.
    Source of the format: samples of the published files.
    """
    if unit not in METRES:
        raise OptionError(f"unit is {short_repr(unit)}, give one of {', '.join(METRES)}")
    file, root = open_building(path, BuildingFormat.MIT)
    findings = Findings()
    spaces = _read_spaces(root, METRES[unit], findings)
    by_name = rooms_by_name(spaces, "name", findings)
    portals, listed = _read_portals(spaces, by_name, findings)
    floor = floor_of_portals(file, spaces, portals, listed, findings)
    findings.warn(file)
    return floor


@dataclass(frozen=True)
class _Space(DrawnRoom):
    """A room with the corners that number its edges, shape (N, 2), metres, and its portals."""

    corners: Floats
    portals: tuple[Element, ...]


def _read_spaces(root: Element, metres: float, findings: Findings) -> list[_Space]:
    """The rooms, with the origin in the lower left corner of all contours; metres: per unit of the file."""
    floors = [floor for floor in root.iter("floor") if floor.find(".//space") is not None]
    elements = list(root.iter("space"))
    if len(floors) > 1:
        findings.faults.append(f"it has rooms on {len(floors)} floors, give one floor")
    check_room_count(len(elements), "space", findings)
    contours = [_read_points(number, element, findings) for number, element in enumerate(elements, start=1)]
    # Moved to the origin before any geometry: large coordinates leave few digits for small distances.
    origin = np.nanmin(np.concatenate([np.full((1, 2), MAX_COORDINATE), *contours]), axis=0)
    spaces = [
        _read_space(number, element, (corners - origin) * metres, findings)
        for number, (element, corners) in enumerate(zip(elements, contours, strict=True), start=1)
    ]
    check_portal_count(sum(len(space.portals) for space in spaces), findings)
    return _to_origin(keep_rooms(spaces, findings))


def _to_origin(spaces: list[_Space]) -> list[_Space]:
    """The rooms with the origin in the lower left corner of their contours; those that were left out moved it."""
    low = np.concatenate([space.corners for space in spaces]).min(axis=0) if spaces else np.zeros(2)
    if not low.any():
        return spaces
    return [
        replace(space, corners=space.corners - low, outline=translate(space.outline, *-low.astype(float)))
        for space in spaces
    ]


def _read_space(number: int, element: Element, corners: Floats, findings: Findings) -> _Space:
    label = normalize_label(element.get("type"))
    outline = polygon_of_corners(corners, describe_room(number, label), findings, defects=findings.lost_rooms)
    return _Space(number, label, outline, element.get("name", ""), corners, tuple(element.iterfind("portal")))


def _read_points(number: int, element: Element, findings: Findings) -> Floats:
    """The points of a contour in units of the file, shape (N, 2); faulty ones are nan, and the room is lost."""
    name = describe_room(number, normalize_label(element.get("type")))
    return read_points(element.iterfind("contour/point"), limit=MAX_COORDINATE, name=name, defects=findings.lost_rooms)


def _read_portals(
    spaces: list[_Space], by_name: Mapping[str, _Space], findings: Findings
) -> tuple[list[DrawnPortal], list[tuple[_Space, _Space]]]:
    """The portals with a position, and the pairs of rooms of those without."""
    portals, listed = [], []
    for space, target, portal in _horizontal_portals(spaces, by_name, findings):
        implicit = portal.get("type", "").lower() == "implicit"
        ends = _ends_of_portal(space.corners, portal, whole_edge=implicit)
        if ends is None:
            listed.append((space, target))
        else:
            portals.append(DrawnPortal(space, target, ends, "opening" if implicit else "door"))
    return portals, listed


def _horizontal_portals(
    spaces: list[_Space], by_name: Mapping[str, _Space], findings: Findings
) -> Iterator[tuple[_Space, _Space, Element]]:
    """Each portal that is not vertical, with its room and the one behind; a repair if it does not join two rooms."""
    for space in spaces:
        for portal in space.portals:
            if portal.get("class", "").lower() == "vertical":
                continue
            # Either end may be this room.
            others = {portal.get("source", space.name), portal.get("target", "")} - {space.name}
            if target := find_target(space, others.pop() if len(others) == 1 else space.name, by_name, findings):
                yield space, target, portal


def _ends_of_portal(corners: Floats, portal: Element, *, whole_edge: bool) -> Floats | None:
    """The first and the last position of a portal on a contour, shape (2, 2), metres; None if it has no position.

    A position is a share of the way along an edge; an edge starts at the corner of its index.
    """
    positions = []
    for edge in portal.iterfind("edge"):
        index, share = parse_number(edge.get("index"), limit=len(corners)), parse_number(edge.get("param"), limit=1)
        if index in range(len(corners)) and (whole_edge or share >= 0):
            start, end = corners[int(index)], corners[(int(index) + 1) % len(corners)]
            positions += [start, end] if whole_edge else [start + share * (end - start)]
    return np.array([positions[0], positions[-1]]) if positions else None
