"""A home of Sweet Home 3D: a ZIP with Home.xml, whose levels have rooms, walls and doors; centimetres, y down."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
import shapely

from pianta._types import Floats
from pianta.building import Building, Storey
from pianta.floor import Door, Floor
from pianta.io._files import count_noun
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.room_texts import title_storey
from pianta.io.writers.storey_heights import list_elevations
from pianta.io.writers.wall_parts import DOOR_HEIGHT, WALL_HEIGHT, WallPart, Walls, find_walls

HOME_FILE = "Home.xml"
VERSION = "7000"  # of Sweet Home 3D 7, whose class HomeXMLHandler defines the file
CM = 100.0
SLAB = 12.0  # centimetres, thickness of a floor: the default of the program
FURNITURE_HEIGHT = 75.0  # centimetres, of a table
# A box of one metre, which the program scales to the size of a piece.
BOX_FILE = "0/box.obj"
BOX = """\
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
f 1 4 3 2
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""
# Moment at which files in the ZIP are dated, so that the same building gives the same bytes.
DATE = (1980, 1, 1, 0, 0, 0)


def write_sweethome3d(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """A level for each storey; holes of rooms are cut open, for the program has rooms without holes."""
    heights, notes = list_elevations(building)
    root = Element("home", {"version": VERSION, "name": building.name or "Building", "wallHeight": _cm(WALL_HEIGHT)})
    pieces: list[Element] = []
    walls: list[Element] = []
    rooms: list[Element] = []
    holes = 0
    for number, (storey, height) in enumerate(zip(building, heights, strict=True)):
        level = f"level{number}"
        sizes = {"elevation": _cm(height), "floorThickness": f"{SLAB:g}", "height": _cm(WALL_HEIGHT)}
        SubElement(root, "level", {"id": level, "name": title_storey(storey) or "Floor", **sizes})
        own_walls = find_walls(storey.floor)
        pieces += [*_list_pieces(storey, level, own_walls)]
        parts = enumerate(_list_walls(storey.floor, own_walls))
        walls += [_make_wall(part, f"{level}-wall{index}", level) for index, part in parts]
        rooms += [*_list_rooms(storey, level)]
        holes += sum(bool(room.polygon.interiors) for room in storey.floor)
    root.extend((*pieces, *walls, *rooms))
    indent(root)
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in ((HOME_FILE, tostring(root, encoding="utf-8", xml_declaration=True)), (BOX_FILE, BOX)):
            archive.writestr(zipfile.ZipInfo(name, DATE), content, zipfile.ZIP_DEFLATED)
    if holes:
        notes.append(f"{count_noun(holes, 'room')} with holes: their outlines lead around the holes")
    if building.links:
        notes.append(f"Sweet Home 3D holds no {count_noun(len(building.links), 'link')} between storeys, left out")
    return notes


def _list_walls(floor: Floor, walls: Walls) -> tuple[WallPart, ...]:
    """Walls that are whole at their doors, which cut them, and have gaps at openings."""
    opened = {host for host, door in zip(walls.hosts, floor.doors, strict=True) if door.kind == "opening"}
    parts = []
    for index, part in enumerate(walls.parts):
        gaps = [
            door.line for host, door in zip(walls.hosts, floor.doors, strict=True) if host == index and index in opened
        ]
        spans = [np.sort((shapely.get_coordinates(gap)[[0, -1]] - part.ends[0]) @ part.direction) for gap in gaps]
        start = 0.0
        for low, high in sorted(map(tuple, spans)):
            parts += [part.cut(start, low)] if low > start else []
            start = max(start, high)
        parts += [part.cut(start, part.length)] if start < part.length else []
    return tuple(parts)


def _make_wall(part: WallPart, name: str, level: str) -> Element:
    (x_start, y_start), (x_end, y_end) = part.ends * (1, -1)
    lengths = {"xStart": x_start, "yStart": y_start, "xEnd": x_end, "yEnd": y_end, "thickness": part.thickness}
    values = {key: _cm(value) for key, value in lengths.items()}
    return Element("wall", {"id": name, "level": level, **values, "height": _cm(WALL_HEIGHT), "pattern": "hatchUp"})


def _list_rooms(storey: Storey, level: str) -> list[Element]:
    rooms = []
    for room in storey.floor:
        name = room.title or room.label or f"Room {room.id}"
        values = {"id": f"{level}-room{room.id}", "level": level, "name": name, "areaVisible": "true"}
        rooms.append(Element("room", values))
        for x, y in _open_holes(room.polygon):
            SubElement(rooms[-1], "point", {"x": _cm(x), "y": _cm(-y)})
    return rooms


def _open_holes(polygon: shapely.Polygon) -> Floats:
    """The corners of an outline that goes to each hole and back, at the nearest corners; the first one not again."""
    corners: Floats = shapely.get_coordinates(polygon.exterior)[:-1]
    holes = [shapely.get_coordinates(ring)[:-1] for ring in polygon.interiors]
    for hole in sorted(holes, key=lambda ring: float(ring[:, 0].min())):
        distances = np.linalg.norm(corners[:, None] - hole[None], axis=2)
        at, start = np.unravel_index(int(distances.argmin()), distances.shape)
        around = np.roll(hole, -start, axis=0)
        corners = np.concatenate([corners[: at + 1], around, around[:1], corners[at:]])
    return corners


def _list_pieces(storey: Storey, level: str, walls: Walls) -> list[Element]:
    """Doors, then furniture."""
    floor = storey.floor
    doors = [
        _make_door(door, walls.parts[host], f"{level}-door{number}", level)
        for number, (door, host) in enumerate(zip(floor.doors, walls.hosts, strict=True), start=1)
        if door.kind == "door" and door.line.length
    ]
    furniture = []
    for number, piece in enumerate(floor.furniture, start=1):
        corners = shapely.get_coordinates(shapely.oriented_envelope(piece.polygon))
        sizes = np.hypot(*(corners[1] - corners[0])), np.hypot(*(corners[2] - corners[1]))
        values = _locate(corners[:4].mean(axis=0), corners[1] - corners[0], sizes, FURNITURE_HEIGHT)
        furniture.append(
            _make_piece("pieceOfFurniture", f"{level}-piece{number}", f"Furniture {number}", level, values)
        )
    return [*doors, *furniture]


def _make_door(door: Door, part: WallPart, name: str, level: str) -> Element:
    """A door as deep as its wall, with a sash that opens by a quarter turn."""
    ends = shapely.get_coordinates(door.line)[[0, -1]]
    values = _locate(ends.mean(axis=0), ends[1] - ends[0], (door.line.length, part.thickness), DOOR_HEIGHT * CM)
    element = _make_piece("doorOrWindow", name, "Door", level, {**values, "doorOrWindow": "true"})
    SubElement(
        element, "sash", {"xAxis": "0", "yAxis": "0.5", "width": "1", "startAngle": "0", "endAngle": "1.5707964"}
    )
    return element


def _locate(middle: Floats, along: Floats, sizes: tuple[float, float], height: float) -> dict[str, str]:
    """Position, angle (clockwise on the plan, y down) and size."""
    angle = -float(np.arctan2(along[1], along[0]))
    lengths = {"x": _cm(middle[0]), "y": _cm(-middle[1]), "angle": f"{angle:.6f}"}
    return {**lengths, "width": _cm(sizes[0]), "depth": _cm(sizes[1]), "height": f"{height:g}"}


def _make_piece(tag: str, name: str, title: str, level: str, values: dict[str, str]) -> Element:
    return Element(tag, {"id": name, "level": level, "name": title, "model": BOX_FILE, **values})


def _cm(metres: float) -> str:
    return f"{round(float(metres) * CM, 3) + 0.0:.3f}".rstrip("0").rstrip(".")
