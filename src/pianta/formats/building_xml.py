"""Layout XML of the thesis' annotated buildings: outlines of rooms with labels, and doors, drawn on an image.

Only `floor/spaces/space` are rooms; bounding boxes, centroids, features, groups and the room's `type` are not read.
"""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree.ElementTree import ParseError

import numpy as np
import shapely
from defusedxml import DefusedXmlException, ElementTree
from numpy.typing import NDArray
from shapely import LinearRing, LineString, Point, Polygon

from pianta.errors import BuildingError, BuildingWarning
from pianta.floor import Door, Floor, Room
from pianta.formats.faults import join_faults
from pianta.formats.files import checked_input, reason_of, shown
from pianta.gridmap import UNKNOWN, GridMap

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

MAX_FILE_BYTES = 64 * 2**20
MAX_COORDINATE_PX = 1e6
MIN_SCALE = 0.1


def read_building_xml(path: str | Path, *, grid: GridMap | None = None) -> Floor:
    """Read a floor from a layout XML, rooms numbered from 1 in the order of the file.

    grid: the map on whose image the layout was drawn; the floor comes out in its map frame. When None, the floor is in
    metres by the file's own scale, y up, with the origin in the top left corner of the drawing, so that y is negative.

    The file marks a door by a point. It becomes a line along the wall, as wide as the distance that scales the
    drawing, which is a door's width by definition (0.9 m). A portal of type IMPLICIT is a door of kind "opening".

    Defects that have one sensible repair are repaired, with one BuildingWarning for all of them: an outline that
    crosses itself keeps its largest part, a door without a place goes to the middle of the wall between its rooms,
    a door that joins a room to itself or to nothing is left out.
    Raises BuildingError, with every fault in one message, for what cannot be repaired.
    """
    file = checked_input(path, "building", BuildingError)
    root = _parse_xml(file)
    faults: list[str] = []
    repairs: dict[str, None] = {}  # each door is listed twice, its defects count once
    metres_per_px, door_px = _read_scale(root, faults)
    frame = grid or GridMap(np.array([[UNKNOWN]]), metres_per_px, (0.0, -metres_per_px, 0.0))
    spaces = _read_spaces(root, frame, faults, repairs)
    if faults:
        raise BuildingError(f"cannot read the building {shown(file)}: {join_faults(faults)}")
    doors = _read_doors(spaces, door_px * frame.resolution, repairs)
    if repairs:
        told = join_faults(list(repairs))
        warnings.warn(f"building {shown(file)} was repaired: {told}", BuildingWarning, stacklevel=2)
    rooms = tuple(Room(space.number, space.outline, space.label) for space in spaces.values())
    building_type = root.findtext("building_type/main_type", "").strip()
    return Floor(rooms, doors, building_type={building_type: 1.0} if building_type else {}, source=file.name)


@dataclass(frozen=True)
class _Space:
    """A room of the file: outline in metres, and the two ends of each portal segment by its id, shape (2, 2)."""

    number: int
    label: str | None
    outline: Polygon
    segments: Mapping[str | None, NDArray[np.float64]]
    portals: Sequence[Element]

    def __str__(self) -> str:
        return f"room {self.number} ({self.label})"


def _parse_xml(file: Path) -> Element:
    name = f"building {shown(file)}"
    if file.stat().st_size > MAX_FILE_BYTES:
        raise BuildingError(f"{name} has more than {MAX_FILE_BYTES} bytes, too many for a layout")
    try:
        root: Element = ElementTree.parse(file, forbid_dtd=True).getroot()
    except DefusedXmlException:
        raise BuildingError(f"{name} declares a document type or entities, remove them") from None
    except (ParseError, ValueError, LookupError, OSError) as exception:
        raise BuildingError(f"{name} is no XML: {reason_of(exception)}") from None
    return root


def _read_scale(root: Element, faults: list[str]) -> tuple[float, float]:
    """Metres per pixel, and the pixels of a door's width; ones when they are faulty."""
    drawn_and_real = (
        "represented_distance/value",
        "represented_distance/um",
        "real_distance/value",
        "real_distance/um",
    )
    texts = [root.findtext(f"scale/{name}") for name in drawn_and_real]
    drawn, real = _parse_number(texts[0]), _parse_number(texts[2])
    if drawn >= MIN_SCALE and real >= MIN_SCALE and texts[1::2] == ["pixel", "cm"]:
        return real / 100 / drawn, drawn
    faults.append("its scale is {} {} for {} {}, give pixel for cm".format(*map(shown, texts)))
    return 1.0, 1.0


def _parse_number(text: str | None) -> float:
    """The number to a millionth, which is finer than any drawing; nan when it is none or too large for one."""
    try:
        number = round(float(text or nan), 6)
    except ValueError:
        return nan
    return number if abs(number) <= MAX_COORDINATE_PX else nan


def _read_spaces(root: Element, frame: GridMap, faults: list[str], repairs: dict[str, None]) -> dict[str, _Space]:
    """The rooms by the ids that the file gives them."""
    elements = root.findall("floor/spaces/space")
    ids = [element.get("id", "") for element in elements]
    floors = len(root.findall("floor"))
    if not elements or floors != 1:
        found = f"{floors} floors and {len(elements)} rooms (floor/spaces/space)"
        faults.append(f"it has {found}, give one floor with rooms")
    faults += [f"{count} rooms have the id {shown(id_)}" for id_, count in Counter(ids).items() if count > 1]
    spaces = [_read_space(number, element, frame, faults, repairs) for number, element in enumerate(elements, start=1)]
    return dict(zip(ids, spaces, strict=True))


def _read_space(number: int, element: Element, frame: GridMap, faults: list[str], repairs: dict[str, None]) -> _Space:
    label = " ".join(element.findtext("labels/label", "").split()) or None
    name = f"room {number} ({label})"
    corners = _read_points(element.find("bounding_polygon"), frame, name, faults)
    segments = {
        segment.get("id"): ends[[0, -1]]
        for segment in element.iterfind("space_representation/linesegment")
        if segment.findtext("class") == "PORTAL" and len(ends := _read_points(segment, frame, name, faults))
    }
    outline = _polygon_of_corners(corners, name, faults, repairs)
    return _Space(number, label, outline, segments, element.findall("portals/portal"))


def _read_points(element: Element | None, frame: GridMap, name: str, faults: list[str]) -> NDArray[np.float64]:
    """The `point` children in metres, shape (N, 2); faulty ones are left out."""
    points = element.findall("point") if element is not None else []
    pixels = []
    for point in points:
        row, col = _parse_number(point.get("y")), _parse_number(point.get("x"))
        if isnan(row) or isnan(col):
            x, y = shown(point.get("x")), shown(point.get("y"))
            faults.append(f"{name} has a point x={x}, y={y}, give two numbers up to {MAX_COORDINATE_PX:.0f}")
        else:
            pixels.append((row, col))
    rows_and_cols = np.array(pixels).reshape(-1, 2).T
    return np.column_stack(frame.pixel_to_map(*rows_and_cols))


def _polygon_of_corners(
    corners: NDArray[np.float64], name: str, faults: list[str], repairs: dict[str, None]
) -> Polygon:
    """The outline as a valid polygon; an empty one, and a fault, when it encloses nothing."""
    outline = Polygon(corners) if len(corners) >= 3 else Polygon()
    if outline.is_valid and outline.area > 0:
        return outline
    parts = shapely.get_parts(shapely.make_valid(outline, method="structure", keep_collapsed=False))
    areas = shapely.area(parts)
    if not areas.any():
        faults.append(f"{name} has an outline without area, give at least 3 corners")
        return Polygon()
    repairs[f"the outline of {name} meets itself, kept the largest part ({areas.max() / areas.sum():.1%})"] = None
    largest: Polygon = parts[areas.argmax()]
    return largest


def _read_doors(spaces: Mapping[str, _Space], width: float, repairs: dict[str, None]) -> tuple[Door, ...]:
    doors: dict[tuple[str | None, int, int], Door] = {}
    for space in spaces.values():
        for portal in space.portals:
            ends = {end.text: spaces.get(end.text or "") for end in portal.findall("target/id")}
            joined = sorted((end for end in ends.values() if end), key=lambda end: end.number)
            if len(ends) != 2 or len(joined) != 2:
                repairs[f"a door of {space} does not join two rooms, left out"] = None
                continue
            first, second = joined
            segment = portal.findtext("linesegment")
            key = segment, first.number, second.number
            if key in doors:
                continue
            line = _line_of_door(first, second, segment, width, repairs)
            implicit = portal.findtext("type") == "IMPLICIT"
            doors[key] = Door(key[1:], line, line.length, "opening" if implicit else "door")
    return tuple(doors.values())


def _line_of_door(
    first: _Space, second: _Space, segment: str | None, width: float, repairs: dict[str, None]
) -> LineString:
    """The portal's segment; where that is a point, a line of a door's width along the wall through it."""
    drawn = [space.segments[segment] for space in (first, second) if segment in space.segments]
    if not drawn:
        repairs[f"the door between {first} and {second} has no place, put in the middle of their wall"] = None
        middle = _middle_of_wall(first.outline.exterior, second.outline.exterior, reach=width / 4)
        return _line_along_wall(middle, first, second, width)
    longest = max(drawn, key=lambda ends: float(np.ptp(ends, axis=0).max()))
    if np.ptp(longest, axis=0).any():
        return LineString(longest)
    return _line_along_wall(np.mean(drawn, axis=(0, 1)), first, second, width)


def _line_along_wall(middle: NDArray[np.float64], first: _Space, second: _Space, width: float) -> LineString:
    """Of the lines of a width through a point, along walls near it, the one whose ends lie nearest to both outlines."""
    rings = np.array([first.outline.exterior, second.outline.exterior])
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
