"""SVG: rooms, walls, doors, furniture and names in groups, a unit of the drawing is a metre."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element, ElementTree, SubElement, indent

import numpy as np
import shapely
from shapely import Polygon

from pianta._types import Floats
from pianta.building import Building, Storey
from pianta.floor import Door, Room
from pianta.floor.area_trust import AreaTrust
from pianta.io._files import count_noun
from pianta.io.drawings.svg import METRES_ATTRIBUTE
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.dxf import draw_walls, place_leaf
from pianta.io.writers.room_texts import place_text, title_storey
from pianta.io.writers.svg_legend import draw_legend, find_tints

if TYPE_CHECKING:
    from collections.abc import Iterable

NAMESPACE = "http://www.w3.org/2000/svg"
MARGIN = 1.0  # metres around each storey; two of them keep storeys apart when the drawing is read
MIN_WIDTH = 10.0  # metres, for the longest text of the legend
CM_PER_METRE = 1.0  # on paper: 1:100
DIGITS = 3  # millimetres
# Of letters: metres, and the share of the radius of the largest circle in a room.
MAX_LETTERS = 0.4
LETTERS_SHARE = 0.25
TITLE_LETTERS = 0.5  # of the titles of storeys
STYLES = {
    "rooms": {"fill": "#eef3f8", "stroke": "#7a8ea3", "stroke-width": "0.02"},
    "furniture": {"fill": "none", "stroke": "#999999", "stroke-width": "0.02"},
    "walls": {"fill": "#222222", "stroke": "none"},
    "doors": {"fill": "none", "stroke": "#1b7f3b", "stroke-width": "0.03"},
    "openings": {"fill": "none", "stroke": "#1b7f3b", "stroke-width": "0.03", "stroke-dasharray": "0.1"},
    "names": {"fill": "#222222", "font-family": "sans-serif", "text-anchor": "middle"},
}


def write_svg(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """A drawing at 1:100; the storeys are below each other, the lowest at the bottom, and a legend below that."""
    walls = [draw_walls(storey.floor) for storey in building]
    boxes = [_measure(storey, areas) for storey, areas in zip(building, walls, strict=True)]
    width = max(MIN_WIDTH, *(high[0] - low[0] + 2 * MARGIN for low, high in boxes))
    height = sum(high[1] - low[1] + 2 * MARGIN for low, high in boxes)
    legend, legend_height = draw_legend(building, (MARGIN, height), width - 2 * MARGIN, STYLES)
    root = Element(
        "svg",
        {
            "xmlns": NAMESPACE,
            "width": f"{_text(width * CM_PER_METRE)}cm",
            "height": f"{_text((height + legend_height) * CM_PER_METRE)}cm",
            "viewBox": f"0 0 {_text(width)} {_text(height + legend_height)}",
            METRES_ATTRIBUTE: "1",
        },
    )
    SubElement(root, "title").text = building.name or "Floor"
    bottom = height
    for number, (storey, areas, (low, high)) in enumerate(zip(building, walls, boxes, strict=True)):
        # A point x, y of the map is at x - left and top - y.
        left_top = np.array([low[0] - MARGIN, low[1] - MARGIN + bottom])
        _draw_storey(root, storey, f"storey-{number}-" if len(building) > 1 else "", left_top, walls=areas)
        bottom -= high[1] - low[1] + 2 * MARGIN
        if len(building) > 1:
            position = {"x": _text(MARGIN), "y": _text(bottom + MARGIN / 2), "font-size": _text(TITLE_LETTERS)}
            SubElement(root, "text", {**position, "font-family": "sans-serif"}).text = title_storey(storey)
    root.append(legend)
    indent(root)
    ElementTree(root).write(target, encoding="utf-8", xml_declaration=True)
    return (
        [f"SVG holds no {count_noun(len(building.links), 'link')} between storeys, left out"] if building.links else []
    )


def _measure(storey: Storey, walls: list[Polygon]) -> tuple[Floats, Floats]:
    """The lower left and the upper right corner of a storey, metres."""
    shapes = [
        *walls,
        *(room.polygon for room in storey.floor),
        *(door.line for door in storey.floor.doors),
    ]
    bounds = shapely.total_bounds(shapes) if shapes else np.zeros(4)
    return bounds[:2], bounds[2:]


def _draw_storey(root: Element, storey: Storey, prefix: str, left_top: Floats, *, walls: list[Polygon]) -> None:
    """The groups of a storey; prefix: of its ids."""
    floor = storey.floor
    parent = SubElement(root, "g", {"id": f"{prefix}floor"})
    if prefix:
        SubElement(parent, "title").text = title_storey(storey)
    groups = {name: SubElement(parent, "g", {"id": f"{prefix}{name}", **style}) for name, style in STYLES.items()}
    tints = find_tints(floor)
    for room in floor:
        tint = {"fill": tints[room.id]} if room.id in tints else {}
        path = _add_area(groups["rooms"], room.polygon, left_top, {"id": f"{prefix}room-{room.id}", **tint})
        SubElement(path, "title").text = ", ".join(filter(None, (room.title or f"Room {room.id}", room.label)))
        _add_name(groups["names"], room, left_top, storey.area_trust)
    for area in walls:
        _add_area(groups["walls"], area, left_top, {})
    for piece in floor.furniture:
        _add_area(groups["furniture"], piece.polygon, left_top, {})
    for number, door in enumerate(floor.doors, start=1):
        points = " ".join(map(_pair, _flip(shapely.get_coordinates(door.line), left_top)))
        if door.kind == "opening" or not door.line.length:
            SubElement(groups["openings"], "polyline", {"id": f"{prefix}opening-{number}", "points": points})
        else:
            SubElement(
                groups["doors"], "path", {"id": f"{prefix}door-{number}", "d": _draw_swing(door, storey, left_top)}
            )


def _draw_swing(door: Door, storey: Storey, left_top: Floats) -> str:
    """The opening, the leaf, and a quarter of a circle."""
    hinge, along, is_left = place_leaf(door, storey.floor)
    width = door.line.length
    across = np.array([-along[1], along[0]]) * (1 if is_left else -1)
    jamb, start, end = map(_pair, _flip(np.array([hinge + along * width, hinge, hinge + across * width]), left_top))
    return f"M {jamb} L {start} L {end} A {_text(width)} {_text(width)} 0 0 {int(is_left)} {jamb}"


def _add_area(group: Element, area: Polygon, left_top: Floats, attributes: dict[str, str]) -> Element:
    rings = (_flip(shapely.get_coordinates(ring)[:-1], left_top) for ring in (area.exterior, *area.interiors))
    outline = " ".join(f"M {' L '.join(map(_pair, ring))} Z" for ring in rings)
    return SubElement(group, "path", {**attributes, "fill-rule": "evenodd", "d": outline})


def _add_name(group: Element, room: Room, left_top: Floats, area_trust: AreaTrust) -> None:
    """The name, or else the id, with the area below it."""
    x, y, radius = place_text(room)
    name = room.title or str(room.id)
    size = min(MAX_LETTERS, radius * LETTERS_SHARE, 3 * radius / max(len(name), 1))
    ((x, y),) = _flip(np.array([[x, y]]), left_top)
    for text, line, scale in ((name, 0.0, 1.0), (area_trust.format_area(room.polygon.area), 1.1, 0.7)):
        attributes = {"x": _text(x), "y": _text(y + line * size), "font-size": _text(size * scale)}
        SubElement(group, "text", attributes).text = text


def _flip(points: Floats, left_top: Floats) -> Floats:
    """Points of the map in the drawing, whose y is down."""
    flipped: Floats = (points - left_top) * (1, -1)
    return flipped


def _pair(point: Iterable[float]) -> str:
    return " ".join(map(_text, point))


def _text(value: float) -> str:
    return f"{round(float(value), DIGITS) + 0.0:.{DIGITS}f}".rstrip("0").rstrip(".")
