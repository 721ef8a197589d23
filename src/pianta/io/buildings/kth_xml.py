"""KTH XML: floor plans of the campus of KTH in Stockholm (Aydemir, Jensfelt and Folkesson, IROS 2012).

Each `space` has a contour of line segments, of which those of type Portal name the space behind them. Walls have their
thickness: rooms next to each other do not touch, and a door is drawn in both.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pianta.floor import Floor
from pianta.io._files import short_repr
from pianta.io._xml import parse_number
from pianta.io.buildings._kinds import Kind, parse_building
from pianta.io.buildings._repair import (
    DrawnPortal,
    DrawnRoom,
    Findings,
    check_portal_count,
    check_room_count,
    floor_of_portals,
    name_of_room,
    normalize_label,
    polygon_of_corners,
    refuse_repeated,
)

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MAX_COORDINATE = 1e6
MIN_DISTANCE = 1e-3


def read_kth_xml(path: str | Path) -> Floor:
    """Read a floor from a KTH XML, rooms numbered from 1 in the order of the file.

    Metres are coordinates times RealDistance / PixelDistance. The drawing's y grows downwards like that of an image;
    the floor's grows upwards, with the drawing's origin. Labels are the file's types, which are Swedish, in capitals.

    The two portals of a door become one Door halfway through the wall. A target whose portal has no segment gets a door
    of 0.9 m in the middle of the wall between the rooms; a portal to a space that the file does not have is left out,
    because it may lead to another floor as well as outside. Windows are walls.

    One BuildingWarning tells all defects, which are treated as read_building_xml treats them.
    Raises BuildingError, with every fault in one message, for what cannot be repaired.
    Source of the format: samples of the published files; that y grows downwards is taken from their unit, pixels.
    """
    file, root = parse_building(path, Kind.KTH)
    findings = Findings()
    spaces = _read_spaces(root, _read_scale(root, findings), findings)
    by_name = {space.name: space for space in spaces if space.name}
    drawn = _drawn_portals(spaces, by_name, findings)
    listed = _listed_pairs(spaces, by_name, findings)
    floor = floor_of_portals(file, spaces, list(drawn), list(listed), findings)
    findings.tell(file)
    return floor


@dataclass(frozen=True)
class _Space(DrawnRoom):
    """A room with its name, its portal segments (target and ends, shape (2, 2), metres), and the targets it lists."""

    name: str
    segments: tuple[tuple[str, NDArray[np.float64]], ...]
    targets: tuple[str, ...]


def _read_scale(root: Element, findings: Findings) -> float:
    """Metres per unit of the drawing; 1 when it is faulty."""
    scale = root.find("Scale")
    texts = [None if scale is None else scale.get(name) for name in ("PixelDistance", "RealDistance")]
    drawn, real = (parse_number(text, limit=MAX_COORDINATE) for text in texts)
    if drawn >= MIN_DISTANCE and real >= MIN_DISTANCE:
        return real / drawn
    given = "PixelDistance {} and RealDistance {}".format(*map(short_repr, texts))
    findings.faults.append(f"its Scale has {given}, give two positive numbers")
    return 1.0


def _read_spaces(root: Element, scale: float, findings: Findings) -> list[_Space]:
    elements = root.findall("space")
    check_room_count(len(elements), "floor/space", findings)
    refuse_repeated((element.get("name") for element in elements), "name", findings)
    spaces = [_read_space(number, element, scale, findings) for number, element in enumerate(elements, start=1)]
    check_portal_count(sum(len(space.segments) + len(space.targets) for space in spaces), findings)
    return spaces


def _read_space(number: int, element: Element, scale: float, findings: Findings) -> _Space:
    label = normalize_label(element.get("type"))
    name = name_of_room(number, label)
    corners, segments = [], []
    for segment in element.iterfind("contour/linesegment"):
        ends = _read_ends(segment, scale, name, findings)
        corners.append(ends)
        if segment.get("type", "").lower() == "portal":
            segments.append((segment.get("target", ""), ends))
    # The end of a segment is the start of the next; where it is not, a straight line bridges the gap.
    outline = polygon_of_corners(np.array(corners).reshape(-1, 2), name, findings)
    targets = tuple(portal.get("target", "") for portal in element.iterfind("portal"))
    return _Space(number, label, outline, element.get("name", ""), tuple(segments), targets)


def _read_ends(segment: Element, scale: float, name: str, findings: Findings) -> NDArray[np.float64]:
    """The two ends in metres, shape (2, 2); zeros when they are faulty."""
    texts = {axis: segment.get(axis) for axis in ("x1", "y1", "x2", "y2")}
    numbers = [parse_number(text, limit=MAX_COORDINATE) for text in texts.values()]
    if any(map(isnan, numbers)):
        given = ", ".join(f"{axis}={short_repr(text)}" for axis, text in texts.items())
        findings.faults.append(f"{name} has a segment {given}, give four numbers up to {MAX_COORDINATE:.0f}")
        return np.zeros((2, 2))
    return np.array(numbers).reshape(2, 2) * (scale, -scale)


def _drawn_portals(spaces: list[_Space], by_name: Mapping[str, _Space], findings: Findings) -> Iterator[DrawnPortal]:
    for space in spaces:
        for name, ends in space.segments:
            target = by_name.get(name)
            if target is None or target is space:
                findings.repairs[f"a door of {space} does not join two rooms, left out"] = None
            else:
                yield DrawnPortal(space, target, ends)


def _listed_pairs(
    spaces: list[_Space], by_name: Mapping[str, _Space], findings: Findings
) -> Iterator[tuple[_Space, _Space]]:
    for space in spaces:
        for name in space.targets:
            target = by_name.get(name)
            if target is None or target is space:
                findings.repairs[f"a door of {space} does not join two rooms, left out"] = None
            else:
                yield space, target
