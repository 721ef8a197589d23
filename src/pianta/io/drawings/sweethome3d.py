"""Homes of Sweet Home 3D: rooms with their names, and doors, of each level."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree.ElementTree import ParseError

import numpy as np
import shapely
from defusedxml import DefusedXmlException, ElementTree
from shapely import LineString, Polygon

from pianta.floor import MAX_ROOM_NAME_LENGTH, Door, Floor, Room
from pianta.floor.polygons import find_largest_polygon
from pianta.io._files import one_line_reason, short_repr
from pianta.io._xml import parse_number
from pianta.io.drawings._ifc_passages import rooms_beside
from pianta.io.drawings._layers import check_plan_file, damage_as_plan_error, plan_error
from pianta.io.drawings.ifc import IfcStorey

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

HOME_FILE = "Home.xml"
# Limits against hostile files.
MAX_FILE_BYTES = 512 * 2**20  # models and textures of furniture are in it, and are not read
MAX_HOME_BYTES = 32 * 2**20
MAX_ROOMS = 5000
MAX_DOORS = 20_000
MAX_POINTS = 200_000
MAX_CM = 1e7  # 100 km
CM = 0.01
# Centimetres above the floor, chosen by hand: what begins higher is a window.
MAX_SILL = 30.0
_PIECES = frozenset({"doorOrWindow", "pieceOfFurniture"})


def read_sweethome3d(path: str | Path) -> list[IfcStorey]:
    """Read the levels of a .sh3d that have rooms, from the lowest to the highest, with rooms and doors.

    A room has the name that the drawing gives it; doors and windows whose lower edge is at most MAX_SILL above the
    floor are doors, between the rooms on both their sides. Only Home.xml is opened, and nothing is extracted.

    Raises PlanError, in one line, for a file that is no ZIP, damaged or too large, that has no Home.xml, as those of
    versions before 5.3, and for a home without rooms.
    Source of the format: the document type in HomeXMLHandler of Sweet Home 3D.
    """
    file = check_plan_file(path, max_bytes=MAX_FILE_BYTES)
    root = _parse_home(file)
    with damage_as_plan_error(file, "home of Sweet Home 3D"):
        return _read_levels(root, file)


def _parse_home(file: Path) -> Element:
    """The root element of Home.xml, at most MAX_HOME_BYTES of it, whatever the ZIP says about its size."""
    try:
        with zipfile.ZipFile(file) as archive, archive.open(HOME_FILE) as stream:
            content = stream.read(MAX_HOME_BYTES + 1)
    except KeyError:
        raise plan_error(file, f"has no {HOME_FILE}, save it again with Sweet Home 3D 5.3 or later") from None
    # zipfile and its decompressors raise various exceptions for damaged files.
    except Exception as exception:
        reason = one_line_reason(exception)
        raise plan_error(file, f"is no home of Sweet Home 3D or damaged, save it again: {reason}") from None
    if len(content) > MAX_HOME_BYTES:
        raise plan_error(file, f"has a {HOME_FILE} of more than {MAX_HOME_BYTES} bytes, give a smaller home")
    try:
        root: Element = ElementTree.fromstring(content, forbid_dtd=True)
    except DefusedXmlException:
        raise plan_error(file, f"declares a document type or entities in {HOME_FILE}, remove them") from None
    except (ParseError, ValueError, LookupError) as exception:
        raise plan_error(file, f"has a damaged {HOME_FILE}, save it again: {one_line_reason(exception)}") from None
    if root.tag != "home":
        raise plan_error(file, f"is no home of Sweet Home 3D, its outermost element is {short_repr(root.tag)}")
    return root


def _read_levels(root: Element, file: Path) -> list[IfcStorey]:
    rooms, pieces = root.findall("room"), [piece for piece in root.iter() if piece.tag in _PIECES and _is_door(piece)]
    points = sum(len(room.findall("point")) for room in rooms)
    for what, count, limit in (
        ("rooms", len(rooms), MAX_ROOMS),
        ("doors", len(pieces), MAX_DOORS),
        ("corners", points, MAX_POINTS),
    ):
        if count > limit:
            raise plan_error(file, f"has {count} {what}, give at most {limit}")
    levels: dict[str | None, Element | None] = {level.get("id"): level for level in root.findall("level")}
    storeys = []
    for key in levels or [None]:
        own = [_read_room(room) for room in rooms if room.get("level") == key]
        outlines = [each for each in own if each is not None]
        if outlines:
            numbered = tuple(
                Room(number, outline, name=name) for number, (outline, name) in enumerate(outlines, start=1)
            )
            doors = [_read_door(piece, numbered) for piece in pieces if piece.get("level") == key]
            floor = Floor(numbered, tuple(door for door in doors if door), source=file.name)
            storeys.append(IfcStorey(floor, *_describe_level(levels.get(key))))
    if not storeys:
        raise plan_error(file, "has no rooms, draw them with Plan > Create rooms")
    return sorted(storeys, key=lambda storey: storey.elevation)


def _describe_level(level: Element | None) -> tuple[str, float]:
    """The name and the elevation, metres, of a level."""
    if level is None:
        return "", 0.0
    elevation = parse_number(level.get("elevation"), limit=MAX_CM)
    return _clean(level.get("name")) or "", 0.0 if np.isnan(elevation) else elevation * CM


def _read_room(room: Element) -> tuple[Polygon, str | None] | None:
    """The outline, metres, y up, of the largest part, and the name; None without an area."""
    numbers = [[parse_number(point.get(axis), limit=MAX_CM) for axis in "xy"] for point in room.findall("point")]
    corners = np.array(numbers, float).reshape(-1, 2) * (CM, -CM)
    if len(corners) < 3 or not np.isfinite(corners).all():
        return None
    outline = find_largest_polygon(shapely.make_valid(Polygon(corners), method="structure"))
    return (outline, _clean(room.get("name"))) if outline.area else None


def _is_door(piece: Element) -> bool:
    """Whether a piece is a door; windows begin higher."""
    sill = parse_number(piece.get("elevation", "0"), limit=MAX_CM)
    return (piece.tag == "doorOrWindow" or piece.get("doorOrWindow") == "true") and sill <= MAX_SILL


def _read_door(piece: Element, rooms: tuple[Room, ...]) -> Door | None:
    """A door through the middle of a piece; None if it joins nothing."""
    x, y, width = (parse_number(piece.get(key), limit=MAX_CM) * CM for key in ("x", "y", "width"))
    angle = -parse_number(piece.get("angle", "0"), limit=MAX_CM)
    if not np.isfinite([x, y, width, angle]).all() or width <= 0:
        return None
    step = np.array([np.cos(angle), np.sin(angle)]) * width / 2
    line = LineString(np.array([x, -y]) + np.outer([-1, 1], step))
    beside = rooms_beside(line, rooms)
    if not beside or (len(beside) == 2 and beside[0] == beside[1]):
        return None
    return Door((beside[0], beside[1] if len(beside) == 2 else None), line, width)


def _clean(text: str | None) -> str | None:
    """A name on one line; None without text."""
    printable = "".join(filter(str.isprintable, " ".join((text or "").split())))
    return printable[:MAX_ROOM_NAME_LENGTH].strip() or None
