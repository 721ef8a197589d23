"""KTH XML: floor plans of the campus of KTH in Stockholm (Aydemir, Jensfelt and Folkesson, IROS 2012).

Each `space` has a contour of line segments, of which those of type Portal name the space behind them. Walls have their
thickness: rooms next to each other do not touch, and a door is drawn in both.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pianta._types import Floats
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
    rooms_by_name,
)
from pianta.io.buildings._formats import BuildingFormat, open_building
from pianta.labels import normalize_label

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MAX_COORDINATE = 1e6  # beyond any building, in metres or pixels
MIN_DISTANCE = 1e-3  # of the two distances that define the scale


def read_kth_xml(path: str | Path) -> Floor:
    """Read a floor from a KTH XML, rooms numbered from 1 in the order of the file.

    Metres are coordinates times RealDistance / PixelDistance. The drawing's y grows downwards like that of an image;
    the floor's grows upwards, with the drawing's origin. Labels are the file's types, which are Swedish, in capitals.

    The two portals of a door become one Door halfway through the wall. A target whose portal has no segment gets a door
    of 0.9 m in the middle of the wall between the rooms; a portal to a space that the file does not have is left out,
    because it may lead to another floor or outside. Windows are walls.

    One BuildingWarning lists all defects, which are treated as in read_building_xml.
    Raises BuildingError, with every fault in one message, for what cannot be repaired.
    Source of the format: samples of the published files; that y grows downwards is taken from their unit, pixels.
    """
    file, root = open_building(path, BuildingFormat.KTH)
    findings = Findings()
    spaces = keep_rooms(_read_spaces(root, _read_scale(root, findings), findings), findings)
    by_name = rooms_by_name(spaces, "name", findings)
    portals = [
        DrawnPortal(space, target, ends)
        for space in spaces
        for name, ends in space.segments
        if (target := find_target(space, name, by_name, findings))
    ]
    listed = [
        (space, target)
        for space in spaces
        for name in space.targets
        if (target := find_target(space, name, by_name, findings))
    ]
    floor = floor_of_portals(file, spaces, portals, listed, findings)
    findings.warn(file)
    return floor


@dataclass(frozen=True)
class _Space(DrawnRoom):
    """A room with its portal segments (target and ends, shape (2, 2), metres), and the targets it lists."""

    segments: tuple[tuple[str, Floats], ...]
    targets: tuple[str, ...]


def _read_scale(root: Element, findings: Findings) -> float:
    """Metres per unit of the drawing; 1 after a fault."""
    scale = root.find("Scale")
    texts = [None if scale is None else scale.get(name) for name in ("PixelDistance", "RealDistance")]
    units, metres = (parse_number(text, limit=MAX_COORDINATE) for text in texts)
    if units >= MIN_DISTANCE and metres >= MIN_DISTANCE:
        return metres / units
    distances = "PixelDistance {} and RealDistance {}".format(*map(short_repr, texts))
    findings.faults.append(f"its Scale has {distances}, give two positive numbers")
    return 1.0


def _read_spaces(root: Element, scale: float, findings: Findings) -> list[_Space]:
    """The rooms of the file, numbered from 1; scale: metres per unit of the drawing. Faults are added to findings."""
    elements = root.findall("space")
    check_room_count(len(elements), "floor/space", findings)
    spaces = [_read_space(number, element, scale, findings) for number, element in enumerate(elements, start=1)]
    check_portal_count(sum(len(space.segments) + len(space.targets) for space in spaces), findings)
    return spaces


def _read_space(number: int, element: Element, scale: float, findings: Findings) -> _Space:
    """A room with its portals, metres, y up; number: of the room. scale: metres per unit of the drawing."""
    label = normalize_label(element.get("type"))
    name = describe_room(number, label)
    corners, segments = [], []
    for segment in element.iterfind("contour/linesegment"):
        ends = _read_ends(segment, scale, name, findings)
        corners.append(ends)
        if segment.get("type", "").lower() == "portal":
            segments.append((segment.get("target", ""), ends))
    # The end of a segment should be the start of the next; otherwise a straight line bridges the gap.
    outline = polygon_of_corners(np.array(corners).reshape(-1, 2), name, findings, defects=findings.lost_rooms)
    targets = tuple(portal.get("target", "") for portal in element.iterfind("portal"))
    return _Space(number, label, outline, element.get("name", ""), tuple(segments), targets)


def _read_ends(segment: Element, scale: float, name: str, findings: Findings) -> Floats:
    """The two ends in metres, shape (2, 2); nan, and the room is lost, if one is invalid."""
    texts = {axis: segment.get(axis) for axis in ("x1", "y1", "x2", "y2")}
    numbers = [parse_number(text, limit=MAX_COORDINATE) for text in texts.values()]
    if any(map(isnan, numbers)):
        values = ", ".join(f"{axis}={short_repr(text)}" for axis, text in texts.items())
        findings.lost_rooms.append(f"{name} has a segment {values}, give four numbers up to {MAX_COORDINATE:.0f}")
        return np.full((2, 2), nan)
    return np.array(numbers).reshape(2, 2) * (scale, -scale)
