"""DXF as facility management takes it: a closed polyline for each room, stamps with numbers and names, doors, walls."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely import LineString, Polygon

from pianta.building import Building, Storey
from pianta.floor import Door, Floor, Room
from pianta.floor.polygons import list_polygons
from pianta.io._files import count_noun
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.room_texts import number_and_name, place_text
from pianta.io.writers.wall_parts import find_walls

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.layouts import Modelspace

VERSION = "R2010"  # the first with UTF-8 and true colours that all programs of the last decade read
METRES = 6  # $INSUNITS of the DXF reference
# Layers with their colours, numbers of the DXF reference: 7 is black on paper, 8 grey.
LAYERS = {"ROOMS": 5, "ROOM_STAMPS": 7, "WALLS": 7, "DOORS": 3, "OPENINGS": 4, "FURNITURE": 8}
STAMP = "ROOM_STAMP"
# The block of a door 1 m wide, from hinge to jamb along x.
DOOR = "DOOR"
# Attributes of the stamp, with their lines below the middle of the room in heights of letters.
ATTRIBUTES = {"NUMBER": 1.2, "NAME": -0.4, "AREA": -2.0}
HIDDEN_ATTRIBUTES = ("LABEL", "ID", "STOREY")
# Heights of letters, metres, and the share of the radius of the largest circle in a room.
MIN_LETTERS = 0.08
MAX_LETTERS = 0.25
LETTERS_SHARE = 0.2
# Codes in texts of DXF: %%d for °, \U+00B0, ^J for a new line.
_CODES = re.compile(r"%%|\\[UM]\+|\^")
# Names of layers have none of these by the DXF reference.
_FORBIDDEN = re.compile(r"[<>/\\\":;?*|=`,\x00-\x1f]")
MAX_LAYER_NAME = 60


def write_dxf(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """A drawing in metres; of several storeys each has layers of its own, and only those of the lowest are on."""
    import ezdxf

    with _fixed_meta_data():
        document = ezdxf.new(VERSION, units=METRES)
    _make_blocks(document)
    notes: list[str] = []
    for number, storey in enumerate(building):
        prefix = f"{number}_{_name_layer(storey.name)}_" if len(building) > 1 else ""
        for name, color in LAYERS.items():
            layer = document.layers.add(prefix + name, color=color)
            if number:
                layer.off()
        notes += _draw_storey(document, storey, prefix)
    if len(building) > 1:
        notes.append("each storey has its own layers, those of the lowest one are on")
    if building.links:
        notes.append(f"DXF holds no {count_noun(len(building.links), 'link')} between storeys, left out")
    with _fixed_meta_data():
        document.saveas(target)
    return notes


@contextmanager
def _fixed_meta_data() -> Iterator[None]:
    """A block in which ezdxf writes no times and random ids, so that equal floors give equal bytes."""
    from ezdxf import options

    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def escape_text(text: str) -> str:
    """A text without the codes of DXF: a caret gets its blank, and codes that begin with %% or a backslash are cut."""
    return _CODES.sub(lambda code: {"%%": "% %", "^": "^ "}.get(code.group(), code.group().replace("\\", "/")), text)


def _name_layer(name: str) -> str:
    return _FORBIDDEN.sub("-", name)[:MAX_LAYER_NAME]


def _make_blocks(document: Drawing) -> None:
    """The stamp of a room, letters 1 m high, and a door: leaf, swing and opening."""
    stamp = document.blocks.new(STAMP)
    for tag, line in ATTRIBUTES.items():
        stamp.add_attdef(tag, dxfattribs={"height": 1}).set_placement((0, line), align=_middle())
    for line, tag in enumerate(HIDDEN_ATTRIBUTES):
        attribute = stamp.add_attdef(tag, (0, -4 - line), dxfattribs={"height": 1})
        attribute.is_invisible = True
    door = document.blocks.new(DOOR)
    door.add_line((0, 0), (0, 1))
    door.add_arc((0, 0), radius=1, start_angle=0, end_angle=90)
    door.add_line((0, 0), (1, 0))


def _middle() -> object:
    from ezdxf.enums import TextEntityAlignment

    return TextEntityAlignment.MIDDLE_CENTER


def _draw_storey(document: Drawing, storey: Storey, prefix: str) -> list[str]:
    space, floor = document.modelspace(), storey.floor
    changed = 0
    for room in floor:
        _draw_rings(space, room.polygon, f"{prefix}ROOMS")
        changed += _draw_stamp(space, room, storey, f"{prefix}ROOM_STAMPS")
    for area in draw_walls(floor):
        _draw_rings(space, area, f"{prefix}WALLS")
    for door in floor.doors:
        _draw_door(space, door, floor, prefix)
    for piece in floor.furniture:
        _draw_rings(space, piece.polygon, f"{prefix}FURNITURE")
    return [f"{count_noun(changed, 'name')} with codes of DXF (%%, ^, \\U+) changed"] if changed else []


def draw_walls(floor: Floor) -> list[Polygon]:
    """The areas of the walls, with gaps at doors."""
    parts = [part.area for part in find_walls(floor).solid]
    return list_polygons(shapely.union_all(parts))


def _draw_rings(space: Modelspace, polygon: Polygon, layer: str) -> None:
    """The outline and each hole as a closed polyline."""
    for ring in (polygon.exterior, *polygon.interiors):
        corners = shapely.get_coordinates(ring)[:-1]
        space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})


def _draw_stamp(space: Modelspace, room: Room, storey: Storey, layer: str) -> bool:
    """The stamp of a room; whether its name was changed for it."""
    x, y, radius = place_text(room)
    number, name = number_and_name(room)
    height = float(np.clip(radius * LETTERS_SHARE, MIN_LETTERS, MAX_LETTERS))
    values = {
        "NUMBER": number or str(room.id),
        "NAME": name or "",
        "AREA": storey.area_trust.format_area(room.polygon.area, digits=2),
        "LABEL": room.label or "",
        "ID": str(room.id),
        "STOREY": storey.name,
    }
    escaped = {tag: escape_text(value) for tag, value in values.items()}
    stamp = space.add_blockref(STAMP, (x, y), dxfattribs={"layer": layer, "xscale": height, "yscale": height})
    stamp.add_auto_attribs(escaped)
    for attribute in stamp.attribs:
        attribute.dxf.layer = layer
    return escaped != values


def _draw_door(space: Modelspace, door: Door, floor: Floor, prefix: str) -> None:
    """A door swings into the smaller of its rooms; an opening is its line."""
    ends = shapely.get_coordinates(door.line)[[0, -1]]
    if door.kind == "opening" or not door.line.length:
        space.add_line(ends[0], ends[1], dxfattribs={"layer": f"{prefix}OPENINGS"})
        return
    hinge, along, turned = place_leaf(door, floor)
    width = float(door.line.length)
    attributes = {"layer": f"{prefix}DOORS", "xscale": width, "yscale": width if turned else -width}
    angle = float(np.degrees(np.arctan2(along[1], along[0])))
    space.add_blockref(DOOR, hinge, dxfattribs={**attributes, "rotation": angle})


def place_leaf(door: Door, floor: Floor) -> tuple[np.ndarray, np.ndarray, bool]:
    """The hinge of a door, the unit vector from there to its jamb, and whether it swings to the left of that.

    Nothing says how a door swings: it is drawn into the smaller room.
    """
    ends = shapely.get_coordinates(door.line)[[0, -1]]
    along = (ends[1] - ends[0]) / np.hypot(*(ends[1] - ends[0]))
    room = min((floor[each] for each in door.room_ids), key=lambda each: each.polygon.area)
    left = np.array([-along[1], along[0]]) * door.line.length
    sides = [
        shapely.intersection(room.polygon, LineString([*ends, ends[1] + side * left]).convex_hull).area
        for side in (1, -1)
    ]
    return ends[0], along, sides[0] >= sides[1]
