"""A world of Gazebo (SDF 1.9): walls and furniture as boxes, gaps with lintels at doors, a frame in each room."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from xml.etree.ElementTree import Element, ElementTree, SubElement, indent

import numpy as np
import shapely
from shapely import Polygon

from pianta.building import Building, Storey
from pianta.io._files import count_noun
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.room_texts import place_text, title_storey
from pianta.io.writers.storey_heights import list_elevations
from pianta.io.writers.wall_parts import DOOR_HEIGHT, WALL_HEIGHT, WallPart, Walls, find_walls

SDF_VERSION = "1.9"
WORLD_FILE = "world.sdf"
ROOMS_FILE = "rooms.json"
FURNITURE_HEIGHT = 0.75  # metres, of a table
SLAB = 0.1  # metres, thickness of the floor of an upper storey
WALL_COLOR = "0.85 0.85 0.82 1"
FURNITURE_COLOR = "0.55 0.45 0.35 1"
SLAB_COLOR = "0.7 0.7 0.7 1"
PLANE_SIZE = "200 200"  # metres; collisions have no edge, only its picture has


def write_gazebo(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """world.sdf, a model for each storey; and rooms.json, the names, labels and positions of the frames."""
    heights, notes = list_elevations(building)
    root = Element("sdf", {"version": SDF_VERSION})
    name = clean_name(building.name or "building")
    world = SubElement(root, "world", {"name": name})
    _add_light(world)
    _add_ground(world)
    rooms = []
    for number, (storey, height) in enumerate(zip(building, heights, strict=True)):
        rooms += _add_storey(world, storey, number, height)
    indent(root)
    ElementTree(root).write(target / WORLD_FILE, encoding="utf-8", xml_declaration=True)
    (target / ROOMS_FILE).write_text(json.dumps(rooms, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    if name != (building.name or "building"):
        notes.append(f"a world has no :: and no __ around its name, this one is named {name}")
    if building.links:
        notes.append(f"no steps and no cabins: {count_noun(len(building.links), 'link')} between storeys left out")
    return notes


def clean_name(name: str) -> str:
    """A name without what SDF keeps for itself: :: between names, and __ around them."""
    return name.replace("::", "-").strip("_") or "building"


def _add(parent: Element, tag: str, text: str | None = None, **attributes: str) -> Element:
    element = SubElement(parent, tag, attributes)
    element.text = text
    return element


def _add_light(world: Element) -> None:
    light = _add(world, "light", name="sun", type="directional")
    for tag, text in (("pose", "0 0 20 0 0 0"), ("diffuse", "0.8 0.8 0.8 1"), ("direction", "-0.5 0.1 -0.9")):
        _add(light, tag, text)


def _add_ground(world: Element) -> None:
    model = _add(world, "model", name="ground_plane")
    _add(model, "static", "true")
    link = _add(model, "link", name="ground")
    for tag_name in ("collision", "visual"):
        plane = _add(_add(_add(link, tag_name, name=f"ground_{tag_name}"), "geometry"), "plane")
        _add(plane, "normal", "0 0 1")
        _add(plane, "size", PLANE_SIZE)


def _add_storey(world: Element, storey: Storey, number: int, height: float) -> list[dict[str, object]]:
    """The model of a storey, and the entries of its rooms in rooms.json."""
    floor, name = storey.floor, f"storey_{number}"
    model = _add(world, "model", name=name)
    _add(model, "static", "true")
    _add(model, "pose", _join(0, 0, height, 0, 0, 0))
    rooms: list[dict[str, object]] = []
    for room in floor:
        x, y, _ = place_text(room)
        frame = _add(model, "frame", name=f"room_{room.id}")
        _add(frame, "pose", _join(x, y, 0, 0, 0, 0))
        texts = {"name": room.title, "label": room.label, "storey": title_storey(storey)}
        rooms.append({"frame": f"{name}::room_{room.id}", "room": room.id, **texts, "x": x, "y": y, "z": height})
    walls, link = find_walls(floor), _add(model, "link", name="walls")
    for index, part in enumerate(walls.solid, start=1):
        _add_part(link, f"wall_{index}", part, 0, WALL_HEIGHT)
    for index, part in enumerate(_list_lintels(walls, storey), start=1):
        _add_part(link, f"lintel_{index}", part, DOOR_HEIGHT, WALL_HEIGHT)
    if number:
        _add_slab(_add(model, "link", name="slab"), [room.polygon for room in floor])
    if floor.furniture:
        link = _add(model, "link", name="furniture")
        for index, piece in enumerate(floor.furniture, start=1):
            _add_furniture(link, f"furniture_{index}", piece.polygon)
    return rooms


def _list_lintels(walls: Walls, storey: Storey) -> list[WallPart]:
    """The walls above doors; openings reach the ceiling."""
    lintels = []
    for door, host in zip(storey.floor.doors, walls.hosts, strict=True):
        part = walls.parts[host]
        low, high = np.sort((shapely.get_coordinates(door.line)[[0, -1]] - part.ends[0]) @ part.direction)
        if door.kind == "door" and high > low:
            lintels.append(part.cut(float(low), float(high)))
    return lintels


def _add_part(link: Element, name: str, part: WallPart, low: float, high: float) -> None:
    middle, yaw = part.ends.mean(axis=0), float(np.arctan2(part.direction[1], part.direction[0]))
    _add_box(link, name, (*middle, (low + high) / 2, yaw), (part.length, part.thickness, high - low), WALL_COLOR)


def _add_furniture(link: Element, name: str, area: Polygon) -> None:
    """The smallest box around a piece of furniture."""
    corners = shapely.get_coordinates(shapely.oriented_envelope(area))
    along, across = corners[1] - corners[0], corners[2] - corners[1]
    pose = (*corners[:4].mean(axis=0), FURNITURE_HEIGHT / 2, float(np.arctan2(along[1], along[0])))
    _add_box(link, name, pose, (np.hypot(*along), np.hypot(*across), FURNITURE_HEIGHT), FURNITURE_COLOR)


def _add_slab(link: Element, outlines: Sequence[Polygon]) -> None:
    """A box below all rooms of an upper storey."""
    x_min, y_min, x_max, y_max = shapely.total_bounds([*outlines])
    pose = ((x_min + x_max) / 2, (y_min + y_max) / 2, -SLAB / 2, 0.0)
    _add_box(link, "slab", pose, (x_max - x_min, y_max - y_min, SLAB), SLAB_COLOR)


def _add_box(link: Element, name: str, pose: Sequence[float], size: Sequence[float], color: str) -> None:
    """A box that collides and is seen; pose: x, y, z and yaw of its middle."""
    x, y, z, yaw = pose
    for tag_name in ("collision", "visual"):
        element = _add(link, tag_name, name=f"{name}_{tag_name}")
        _add(element, "pose", _join(x, y, z, 0, 0, yaw))
        _add(_add(_add(element, "geometry"), "box"), "size", _join(*size))
        if tag_name == "visual":
            material = _add(element, "material")
            _add(material, "ambient", color)
            _add(material, "diffuse", color)


def _join(*values: float) -> str:
    return " ".join(f"{round(float(value), 4) + 0.0:.4f}".rstrip("0").rstrip(".") for value in values)
