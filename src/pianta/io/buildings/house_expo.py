"""HouseExpo JSON: plans of homes (Li et al., HouseExpo, IROS 2019): an outline, and boxes around the rooms, in metres.

Boxes overlap, and doors and corridors are not in the file.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, FiniteFloat, ValidationError
from shapely import Polygon, box
from shapely.geometry.base import BaseGeometry

from pianta.errors import BuildingError
from pianta.floor import Floor, Room
from pianta.floor.polygons import find_largest_polygon, list_polygons
from pianta.io._faults import describe_validation
from pianta.io._files import short_repr
from pianta.io.buildings._findings import MAX_CORNERS, Findings, check_room_count, polygon_of_corners
from pianta.io.buildings._formats import BuildingFormat, open_building
from pianta.labels import normalize_label

MAX_COORDINATE = 1e4  # metres; beyond any home
MAX_BOXES = 1000  # against hostile files
# Chosen by hand:
MIN_AREA = 1.0  # m² of a room that no box covers
MIN_WIDTH = 0.5  # metres of such a room
MIN_REMAINDER = 0.01  # m² of a box that smaller boxes leave over


def read_house_expo(path: str | Path) -> Floor:
    """Read a floor from a HouseExpo JSON, rooms numbered from 1 in the order of the file, without doors.

    A room is its box within the outline. If boxes overlap, the smaller one wins, or the first of equal ones; a room is
    the largest remaining part of its box. The same box under several labels is one room with the first of them. Labels
    are in capitals, with blanks for underscores.

    Uncovered parts of the outline that are at least 0.5 m wide and 1 m² large, mostly corridors, become rooms without a
    label, numbered last, the largest first.

    One BuildingWarning lists all repairs: an outline that meets itself keeps its largest part; a box without area,
    outside the outline or hidden behind smaller ones is left out.
    Raises BuildingError, with every fault in one message, for what cannot be repaired.
    """
    file, content = open_building(path, BuildingFormat.HOUSE_EXPO)
    try:
        house = _House.model_validate_json(content.removeprefix(b"\xef\xbb\xbf"))
    except ValidationError as exception:
        raise BuildingError(f"cannot read the building {short_repr(file)}: {describe_validation(exception)}") from None
    findings = Findings()
    boxes = _read_boxes(house, findings)
    outline = polygon_of_corners(np.array(house.verts), "the house", findings, defects=findings.faults)
    findings.raise_faults(file)
    shapes, free = _divide_outline(outline, boxes, findings)
    labelled = [(shapes[bounds], label) for bounds, label in boxes.items() if bounds in shapes]
    labelled += [(part, None) for part in _wide_parts(free)]
    check_room_count(len(labelled), "room_category, or an outline of a square metre", findings)
    findings.raise_faults(file)
    findings.warn(file)
    rooms = [Room(number, shape, label) for number, (shape, label) in enumerate(labelled, start=1)]
    return Floor(tuple(rooms), source=file.name)


def _round(metres: float) -> float:
    """Round to the micrometre, so that no shape is thinner than the accuracy of its corners."""
    return round(metres, 6)


_Metres = Annotated[FiniteFloat, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE), AfterValidator(_round)]
_Box = tuple[_Metres, _Metres, _Metres, _Metres]


class _House(BaseModel):
    """The members that are read; the number of rooms and the bounds are skipped, they contradict the boxes."""

    model_config = ConfigDict(strict=True, frozen=True)

    verts: Annotated[list[tuple[_Metres, _Metres]], Field(min_length=3, max_length=MAX_CORNERS)]
    room_category: dict[str, Annotated[list[_Box], Field(max_length=MAX_BOXES)]]


def _read_boxes(house: _House, findings: Findings) -> dict[_Box, str | None]:
    """The boxes with their labels, in the order of the file."""
    labels: dict[_Box, str | None] = {}
    for text, boxes in house.room_category.items():
        for bounds in boxes:
            labels[bounds] = labels.get(bounds) or normalize_label(text.replace("_", " "))
    if len(labels) > MAX_BOXES:
        findings.faults.append(f"it has {len(labels)} boxes, give at most {MAX_BOXES}")
        return {}
    flat = {bounds for bounds in labels if bounds[0] >= bounds[2] or bounds[1] >= bounds[3]}
    for bounds in flat:
        findings.repairs[f"the box {bounds} ({labels[bounds]}) has no area, left out"] = None
    return {bounds: label for bounds, label in labels.items() if bounds not in flat}


def _divide_outline(
    outline: Polygon, boxes: dict[_Box, str | None], findings: Findings
) -> tuple[dict[_Box, Polygon], BaseGeometry]:
    """The remaining part of each box, and the part of the outline that no room covers."""
    free: BaseGeometry = outline
    shapes: dict[_Box, Polygon] = {}
    for bounds in sorted(boxes, key=lambda bounds: box(*bounds).area):
        part = find_largest_polygon(free.intersection(box(*bounds)))
        if part.area < MIN_REMAINDER:
            text = f"the box {bounds} ({boxes[bounds]}) is hidden by smaller ones or outside the outline, left out"
            findings.repairs[text] = None
            continue
        shapes[bounds] = part
        free = free.difference(part)
    return shapes, free


def _wide_parts(shape: BaseGeometry) -> list[Polygon]:
    """The parts of a shape with the width and area of a room, the largest first."""
    core = shape.buffer(-MIN_WIDTH / 2, join_style="mitre").buffer(MIN_WIDTH / 2, join_style="mitre")
    parts = [part for part in list_polygons(shape.intersection(core)) if part.area >= MIN_AREA]
    return sorted(parts, key=lambda part: -part.area)
