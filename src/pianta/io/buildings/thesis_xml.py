"""Layout XML of the thesis' annotated buildings: outlines of rooms with labels, and doors, drawn on an image.

Only `floor/spaces/space` are rooms; bounding boxes, centroids, features, groups, the room's `type` and the building's
name, which holds paths of its annotator, are not read.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from shapely import LineString, get_coordinates

from pianta._types import Floats
from pianta.errors import LabelError
from pianta.floor import Door, Floor, Room
from pianta.gridmap import UNKNOWN, GridMap
from pianta.io._files import short_repr
from pianta.io._xml import parse_number
from pianta.io.buildings._findings import (
    DrawnRoom,
    Findings,
    check_doors,
    check_portal_count,
    check_room_count,
    check_rooms,
    describe_room,
    keep_rooms,
    line_along_wall,
    line_in_middle,
    polygon_of_corners,
    read_points,
    rooms_by_name,
)
from pianta.io.buildings._formats import BuildingFormat, open_building
from pianta.labels import normalize_label, standard_building_type

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MAX_COORDINATE_PX = 1e6  # beyond any image
MIN_DISTANCE = 0.1  # of the two distances that define the scale, in pixels and cm
MAX_BEYOND_PX = 5  # corners outside the map by less are inaccuracies of the annotator; chosen by hand


def read_building_xml(path: str | Path, *, grid: GridMap | None = None) -> Floor:
    """Read a floor from a layout XML, rooms numbered from 1 in the order of the file.

    grid: the map on whose image the layout was drawn; the floor is in its map frame. If None, the floor is in metres by
    the file's own scale, y up, with the origin in the top left corner of the drawing, so that y is negative.

    Labels are in capitals with single blanks, the building's type in lower case, as in pianta.labels. The file
    marks a door by a point. It becomes a line along the wall, as wide as the distance that scales the drawing, which
    is a door's width by definition (0.9 m). A portal of type IMPLICIT is a door of kind "opening"; one that only one of
    its rooms lists is an ordinary door.

    One BuildingWarning lists all defects. Defects with one sensible repair are repaired: an outline that crosses itself
    keeps its largest part, a door without a position is put in the middle of the wall between its rooms, a door that
    joins a room to itself or to nothing is left out. A room whose outline has no area or an invalid number is left out
    with its doors; the others keep their numbers. What else is wrong stays: rooms that overlap by more than a tenth of
    the smaller one or are smaller than a door is wide, corners outside the map, and, if the floor has any door, rooms
    without a door and groups of rooms without a door from one to another.
    Raises BuildingError, with every fault in one message, for what cannot be repaired.
    """
    file, root = open_building(path, BuildingFormat.LAYOUT)
    findings = Findings()
    metres_per_px, door_px = _read_scale(root, findings.faults)
    frame = grid or GridMap(np.array([[UNKNOWN]]), metres_per_px, (0.0, -metres_per_px, 0.0))
    spaces = keep_rooms(_read_spaces(root, frame, findings), findings)
    building_type = _read_type(root, findings.faults)
    findings.raise_faults(file)
    door_width = door_px * frame.resolution
    rooms = tuple(Room(space.number, space.outline, space.label) for space in spaces)
    floor = Floor(rooms, _read_doors(spaces, door_width, findings), building_type=building_type, source=file.name)
    check_rooms(spaces, door_width=door_width, findings=findings)
    if grid:
        _check_corners(floor, grid, findings)
    check_doors(floor, findings)
    findings.warn(file)
    return floor


@dataclass(frozen=True)
class _Space(DrawnRoom):
    """A room, the two ends of each portal segment by its id, shape (2, 2), and the elements of its portals."""

    segments: Mapping[str | None, Floats]
    portals: Sequence[Element]


def _read_scale(root: Element, faults: list[str]) -> tuple[float, float]:
    """Metres per pixel, and the pixels of a door's width; both 1 after a fault."""
    distances = ("represented_distance", "real_distance")
    texts = [root.findtext(f"scale/{distance}/{part}") for distance in distances for part in ("value", "um")]
    pixels, centimetres = (parse_number(text, limit=MAX_COORDINATE_PX) for text in texts[::2])
    if pixels >= MIN_DISTANCE and centimetres >= MIN_DISTANCE and texts[1::2] == ["pixel", "cm"]:
        return centimetres / 100 / pixels, pixels
    faults.append("its scale is {} {} for {} {}, give pixel for cm".format(*map(short_repr, texts)))
    return 1.0, 1.0


def _read_type(root: Element, faults: list[str]) -> dict[str, float]:
    """The type of the building with probability 1; empty if the file has none."""
    text = root.findtext("building_type/main_type", "").strip()
    try:
        return {standard_building_type(text): 1.0} if text else {}
    except LabelError as error:
        faults.append(f"its building type is invalid: {error}")
        return {}


def _read_spaces(root: Element, frame: GridMap, findings: Findings) -> list[_Space]:
    """The rooms of the file, numbered from 1."""
    elements = root.findall("floor/spaces/space")
    floors = len(root.findall("floor"))
    if floors != 1:
        findings.faults.append(f"it has {floors} floors, give one")
    check_room_count(len(elements), "floor/spaces/space", findings)
    spaces = [_read_space(number, element, frame, findings) for number, element in enumerate(elements, start=1)]
    check_portal_count(sum(len(space.portals) for space in spaces), findings)
    listed = [element.find("portals") is not None for element in elements]
    if any(listed):
        without = (space for space, has_list in zip(spaces, listed, strict=True) if not has_list)
        findings.remarks += [f"{space} has no list of portals" for space in without]
    return spaces


def _read_space(number: int, element: Element, frame: GridMap, findings: Findings) -> _Space:
    """A room with its portals, metres; number: of the room. frame: the map in whose pixels the file has its points."""
    label = normalize_label(element.findtext("labels/label"))
    name = describe_room(number, label)
    corners = _read_points(element.iterfind("bounding_polygon[1]/point"), frame, name, findings.lost_rooms)
    segments = {
        segment.get("id"): ends[[0, -1]]
        for segment in element.iterfind("space_representation/linesegment")
        if segment.findtext("class") == "PORTAL"
        and len(ends := _read_points(segment.iterfind("point"), frame, name, findings.remarks))
        and not np.isnan(ends).any()
    }
    outline = polygon_of_corners(corners, name, findings, defects=findings.lost_rooms)
    return _Space(number, label, outline, element.get("id", ""), segments, element.findall("portals/portal"))


def _read_points(points: Iterable[Element], frame: GridMap, name: str, defects: list[str]) -> Floats:
    """Points in metres, shape (N, 2); faulty ones are nan, and added to the defects."""
    cols, rows = read_points(points, limit=MAX_COORDINATE_PX, name=name, defects=defects).T
    return np.column_stack(frame.pixel_to_map(rows, cols))


def _check_corners(floor: Floor, grid: GridMap, findings: Findings) -> None:
    """Remark on corners more than MAX_BEYOND_PX outside the map."""
    corners = get_coordinates([room.polygon.exterior for room in floor.rooms])
    pixels = np.column_stack(grid.map_to_pixel(*corners.T))
    beyond = np.maximum(-pixels, pixels - grid.shape).max(axis=1)
    outside = np.unique(pixels[beyond > MAX_BEYOND_PX].round(3), axis=0)
    if len(outside):
        findings.remarks.append(f"corners outside the map: {len(outside)}, by up to {beyond.max():.0f} pixels")


def _read_doors(spaces: Sequence[_Space], width: float, findings: Findings) -> tuple[Door, ...]:
    """The doors between two rooms, each once; other portals are repairs. width: of a door without segment, metres."""
    doors: dict[tuple[str | None, int, int], Door] = {}
    by_id = rooms_by_name(spaces, "id", findings)
    for space in spaces:
        for portal in space.portals:
            ids = {end.text or "" for end in portal.findall("target/id")}
            others = ids - {space.name}
            ends = [by_id.get(id_) for id_ in ids] if len(others) == 2 else [space, *map(by_id.get, others)]
            joined = sorted((end for end in ends if end), key=lambda end: end.number)
            if len(ids) != 2 or len(joined) != 2:
                findings.repairs[f"a door of {space} does not join two rooms, left out"] = None
                continue
            first, second = joined
            segment = portal.findtext("linesegment")
            key = segment, first.number, second.number
            if key in doors:
                continue
            line = _line_of_door(first, second, segment, width, findings)
            implicit = portal.findtext("type") == "IMPLICIT"
            doors[key] = Door(key[1:], line, line.length, "opening" if implicit else "door")
    return tuple(doors.values())


def _line_of_door(first: _Space, second: _Space, segment: str | None, width: float, findings: Findings) -> LineString:
    """The portal's segment; if that is a point, a line of a door's width along the wall through it."""
    segments = [space.segments[segment] for space in (first, second) if segment in space.segments]
    if not segments:
        return line_in_middle(first, second, width, findings)
    longest = max(segments, key=lambda ends: float(np.ptp(ends, axis=0).max()))
    if np.ptp(longest, axis=0).any():
        return LineString(longest)
    return line_along_wall(np.mean(segments, axis=(0, 1)), first.outline, second.outline, width)
