"""For robot vacuums: the map JSON of Valetudo, and the rooms of the vacuum map card of Home Assistant.

The card is PiotrMachowski/lovelace-xiaomi-vacuum-map-card, platform Hypfer/Valetudo; the members of its rooms are
those of docs/templates/hypferValetudo.md there.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import floor as round_down
from pathlib import Path
from typing import Any

import numpy as np
import shapely
import yaml
from numpy.typing import NDArray

from pianta._types import Floats, Mask
from pianta.building import Building, Storey
from pianta.errors import OptionError
from pianta.floor import Floor, Room
from pianta.gridmap import GridMap
from pianta.io._files import count_noun, short_repr
from pianta.io.vacuum_segments import match_segments
from pianta.io.valetudo import CLASS_NAME, CM_PER_METRE, VacuumMap, read_vacuum_map
from pianta.io.writers._formats import WriteOptions

# Of the corners of outlines in the card, from those of the room; metres.
TOLERANCE = 0.05
MAX_LISTED = 5  # rooms in a note
# Between the middle of a room and its name in the card, pixels; as in the card's own examples.
LABEL_OFFSET = 35
# Icons of Material Design, by a word of the label or of the name; else the broom.
ICONS = {
    "KITCHEN": "mdi:silverware-fork-knife",
    "BATHROOM": "mdi:shower",
    "BEDROOM": "mdi:bed",
    "LIVING": "mdi:sofa",
    "CORRIDOR": "mdi:door",
    "TOILET": "mdi:toilet",
    "OFFICE": "mdi:desk",
}
DEFAULT_ICON = "mdi:broom"


@dataclass(frozen=True, eq=False)
class _Sheet:
    """What segments are drawn on: a map, the column and row of its first cell, and the members of the JSON.

    floor: in the frame of the map. numbers: room -> id of its segment. names: id -> name that the robot has.
    """

    grid: GridMap
    corner: tuple[int, int]
    floor: Floor
    numbers: dict[int, str]
    members: dict[str, Any]
    names: dict[str, str | None]
    notes: list[str]


def write_valetudo(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """The map JSON with a segment for each room: that of the robot with other segments, or a new one of the map."""
    storey = _only_storey(building)
    sheet = _make_sheet(storey) if options.robot_map is None else _open_sheet(storey, options.robot_map)
    grid, side = sheet.grid, sheet.grid.resolution * CM_PER_METRE
    labels = sheet.floor.label_image(grid)
    masks = {room.id: grid.free & (labels == room.id) for room in sheet.floor}
    empty = [number for number, mask in masks.items() if not mask.any()]
    parts: list[tuple[str, Mask, dict[str, Any]]] = [
        ("floor", grid.free & (labels == 0), {}),
        ("wall", grid.occupied, {}),
        *(("segment", masks[room.id], _describe_segment(room, sheet)) for room in storey.floor),
    ]
    layers = [_make_layer(layer_type, mask, sheet, data) for layer_type, mask, data in parts if mask.any()]
    bottom, right = sheet.corner[1] + grid.shape[0], sheet.corner[0] + grid.shape[1]
    area = sum(layer["metaData"]["area"] for layer in layers if layer["type"] != "wall")
    content = {
        "__class": CLASS_NAME,
        "size": {"x": _drop_point(right * side), "y": _drop_point(bottom * side)},
        "pixelSize": _drop_point(side),
        **sheet.members,
        "metaData": {**sheet.members["metaData"], "totalLayerArea": area},
        "layers": layers,
    }
    target.write_text(json.dumps(content, ensure_ascii=False), encoding="utf-8")
    return [*sheet.notes, *([f"no free floor is in {_list_rooms(storey.floor, empty)}, left out"] if empty else [])]


def _open_sheet(storey: Storey, path: Path) -> _Sheet:
    """The map of the robot, whose ids rooms get where they are its segments."""
    robot = read_vacuum_map(path)
    numbers, new = _number_rooms(storey.floor, robot)
    notes = [f"the robot has no segment for {_list_rooms(storey.floor, new)}, their ids are new"] if new else []
    data = robot.members.get("metaData")
    members = {**robot.members, "metaData": data if isinstance(data, dict) else {}}
    names = {segment.id: segment.name for segment in robot.segments}
    return _Sheet(robot.grid, robot.corner, storey.floor, numbers, members, names, notes)


def _make_sheet(storey: Storey) -> _Sheet:
    """The map of the storey, moved to whole pixels from zero if it is not there."""
    grid = storey.grid
    if grid is None:
        raise OptionError("format valetudo needs the map, which the floor is without; give it as grid=, or a robot map")
    x, y, yaw = grid.origin
    left, top = round(x / grid.resolution), round(-y / grid.resolution) - grid.shape[0]
    at_pixels = np.allclose([left * grid.resolution, -(top + grid.shape[0]) * grid.resolution], [x, y], atol=1e-6)
    numbers, members = {room.id: str(room.id) for room in storey.floor}, {"metaData": {"version": 2}, "entities": []}
    if yaw == 0 and at_pixels and left >= 0 and top >= 0:
        return _Sheet(grid, (left, top), storey.floor, numbers, members, {}, [])
    moved = replace(grid, origin=(0.0, -grid.shape[0] * grid.resolution, 0.0))
    turned = "" if yaw == 0 else f", turned by {-yaw:.4f} rad"
    notes = [f"the map begins at 0, 0{turned}: Valetudo has no negative coordinates and no angle"]
    return _Sheet(moved, (0, 0), _move_floor(storey.floor, grid, moved), numbers, members, {}, notes)


def write_map_card(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """The configuration of the card, with a room of each segment that the robot can clean."""
    storey = _only_storey(building)
    notes = ["write the entities of your robot into the file: entity, camera and topic are examples"]
    numbers = {room.id: str(room.id) for room in storey.floor}
    if options.robot_map is None:
        notes.append("the ids are those of pianta; give --robot-map, the map JSON of the robot, for those of the robot")
    else:
        numbers = match_segments(storey.floor, read_vacuum_map(options.robot_map))
        new = [room.id for room in storey.floor if room.id not in numbers]
        if new:
            notes.append(f"the robot has no segment for {_list_rooms(storey.floor, new)}, left out")
    card = {
        "type": "custom:xiaomi-vacuum-map-card",
        "entity": "vacuum.valetudo",
        "vacuum_platform": "Hypfer/Valetudo",
        "map_source": {"camera": "camera.valetudo"},
        "calibration_source": {"camera": True},
        "internal_variables": {"topic": "valetudo/robot"},
        "map_modes": [
            {
                "template": "vacuum_clean_segment",
                "predefined_selections": [
                    _describe_selection(room, numbers[room.id]) for room in storey.floor if room.id in numbers
                ],
            }
        ],
    }
    text = yaml.safe_dump(card, sort_keys=False, allow_unicode=True, width=1000)
    target.write_text(text, encoding="utf-8")
    return notes


def _number_rooms(floor: Floor, robot: VacuumMap) -> tuple[dict[int, str], list[int]]:
    """The id of the segment of each room, and the rooms that the robot does not have, whose ids are new."""
    numbers = match_segments(floor, robot)
    new = [room.id for room in floor if room.id not in numbers]
    highest = max((int(each.id) for each in robot.segments if each.id.isdecimal() and len(each.id) < 10), default=0)
    return numbers | {room: str(highest + number) for number, room in enumerate(new, start=1)}, new


def _only_storey(building: Building) -> Storey:
    if len(building) > 1:
        names = ", ".join(short_repr(storey.name) for storey in building)
        raise OptionError(f"a vacuum has one storey, and the building has {names}; convert the folder of one")
    return building.storeys[0]


def _move_floor(floor: Floor, grid: GridMap, moved: GridMap) -> Floor:
    """The rooms on the same cells of a map that was moved."""

    def move(points: Floats) -> Floats:
        return np.column_stack(moved.pixel_to_map(*grid.map_to_pixel(points[:, 0], points[:, 1])))

    return Floor(tuple(Room(room.id, shapely.transform(room.polygon, move)) for room in floor))


def _make_layer(layer_type: str, mask: Mask, sheet: _Sheet, data: dict[str, Any]) -> dict[str, Any]:
    """A layer of the cells of a mask, shape (H, W), as Valetudo writes it: runs, extent, and area in cm²."""
    rows, cols = np.nonzero(mask)
    x, y = cols + sheet.corner[0], rows + sheet.corner[1]
    starts = np.flatnonzero((np.diff(y, prepend=-1) != 0) | (np.diff(x, prepend=-2) != 1))
    runs = np.column_stack([x[starts], y[starts], np.diff(starts, append=len(x))])
    return {
        "__class": "MapLayer",
        "metaData": {**data, "area": _drop_point(len(x) * (sheet.grid.resolution * CM_PER_METRE) ** 2)},
        "type": layer_type,
        "pixels": [],
        "dimensions": {"x": _measure_extent(x), "y": _measure_extent(y), "pixelCount": len(x)},
        "compressedPixels": runs.ravel().tolist(),
    }


def _measure_extent(values: NDArray[np.int64]) -> dict[str, int]:
    low, high = int(values.min()), int(values.max())
    middle, mean = round_down((low + high) / 2 + 0.5), round_down(float(values.mean()) + 0.5)
    return {"min": low, "max": high, "mid": middle, "avg": mean}


def _describe_segment(room: Room, sheet: _Sheet) -> dict[str, Any]:
    """The id, and the name that people gave the room here, or in the robot; else what it is for."""
    number = sheet.numbers[room.id]
    name = room.title or sheet.names.get(number) or room.label
    return {"segmentId": number, "active": False, **({"name": name} if name else {})}


def _describe_selection(room: Room, number: str) -> dict[str, Any]:
    """A room of the card: centimetres, y down."""
    inside = room.polygon.representative_point()
    x, y = _to_valetudo([(inside.x, inside.y)])[0]
    words = f"{room.label or ''} {room.title or ''}".upper()
    icon = next((icon for word, icon in ICONS.items() if word in words), DEFAULT_ICON)
    outline = room.polygon.exterior.simplify(TOLERANCE).coords[:-1]
    return {
        "id": number,
        "outline": _to_valetudo(outline),
        "label": {"text": room.title or room.label or f"Room {number}", "x": x, "y": y, "offset_y": LABEL_OFFSET},
        "icon": {"name": icon, "x": x, "y": y},
    }


def _to_valetudo(points: Iterable[tuple[float, ...]]) -> list[list[int]]:
    return [[round(x * CM_PER_METRE), round(-y * CM_PER_METRE)] for x, y, *_ in points]


def _drop_point(value: float) -> float | int:
    """The number without a point if it is whole, up to rounding."""
    return round(value) if abs(value - round(value)) < 1e-6 else round(value, 6)


def _list_rooms(floor: Floor, ids: list[int]) -> str:
    listed = [f"{number} {floor[number].name or ''}".strip() for number in ids[:MAX_LISTED]]
    return f"{count_noun(len(ids), 'room')} ({', '.join(listed)}{', …' if len(ids) > MAX_LISTED else ''})"
