"""IndoorGML 1.1: rooms as cells with states, doors as boundaries with transitions.

The elements are in the order of the schema of the core module, whose namespace versions 1.0 and 1.1 share. Each room is
a CellSpace with a surface at the height of its storey, and a State; each door or opening between two rooms is a
CellSpaceBoundary with a curve, and a Transition, and so are stairs and lifts, without a boundary. Entrances lead to the
state OUTSIDE, which has no cell.
"""

from __future__ import annotations

from itertools import pairwise
from math import dist
from pathlib import Path
from typing import TypeAlias
from xml.etree.ElementTree import Element, ElementTree, SubElement, indent, register_namespace

from shapely import Point, Polygon

from pianta.building import Building, Storey
from pianta.errors import OptionError
from pianta.floor import Door, Room
from pianta.io._files import count_noun
from pianta.io.writers._formats import WriteOptions

CORE = "http://www.opengis.net/indoorgml/1.0/core"
GML = "http://www.opengis.net/gml/3.2"
XLINK = "http://www.w3.org/1999/xlink"
XSI = "http://www.w3.org/2001/XMLSchema-instance"
OUTSIDE = "S-outside"
SCHEMA = f"{CORE} http://schemas.opengis.net/indoorgml/1.0/indoorgmlcore.xsd"
DIGITS = 3  # of a metre

XYZ: TypeAlias = tuple[float, float, float]
# The ids of two states, and the length and the points of the way between them.
Edge: TypeAlias = tuple[str, str, float, list[XYZ]]


def write_indoorgml(building: Building, target: Path, _: WriteOptions) -> list[str]:
    """One document, all storeys in one layer; coordinates are metres of the map frame, z the height of the storey."""
    for prefix, space in (("core", CORE), ("gml", GML), ("xlink", XLINK), ("xsi", XSI)):
        register_namespace(prefix, space)
    if not any(building.list_rooms()):
        raise OptionError("format indoorgml needs a room, and the building has none; read its map again")
    root = _feature("IndoorFeatures", "building", building.name)
    root.set(f"{{{XSI}}}schemaLocation", SCHEMA)
    primal = _sub_feature(_sub(root, "primalSpaceFeatures"), "PrimalSpaceFeatures", "primal")
    layers = _sub_feature(
        _sub_feature(_sub(root, "multiLayeredGraph"), "MultiLayeredGraph", "graph"), "spaceLayers", "layers"
    )
    layer = _sub_feature(_sub(layers, "spaceLayerMember"), "SpaceLayer", "layer")
    _sub(layer, "class").text = "TOPOGRAPHIC"
    nodes, edges = (_sub_feature(layer, name, name) for name in ("nodes", "edges"))
    graph = _Graph(building)
    for storey, room in building.list_rooms():
        _add_cell(_sub(primal, "cellSpaceMember"), graph, storey, room)
        _add_state(_sub(nodes, "stateMember"), graph, storey, room)
    for number, (storey, door) in enumerate(graph.doors, start=1):
        _add_boundary(_sub(primal, "cellSpaceBoundaryMember"), number, storey, door)
        _add_transition(_sub(edges, "transitionMember"), number, graph.edges[number - 1])
    for number, edge in enumerate(graph.edges[len(graph.doors) :], start=len(graph.doors) + 1):
        _add_transition(_sub(edges, "transitionMember"), number, edge, has_boundary=False)
    if graph.has_outside:
        _sub_feature(_sub(nodes, "stateMember"), "State", OUTSIDE, "outside").extend(graph.list_connects(OUTSIDE))
    if not graph.edges:
        layer.remove(edges)
    indent(root)
    ElementTree(root).write(target, encoding="utf-8", xml_declaration=True)
    return _list_left_out(building)


class _Graph:
    """Which states each transition joins; doors come first, then stairs and lifts."""

    def __init__(self, building: Building) -> None:
        self.indexes = {storey.name: index for index, storey in enumerate(building)}
        self.doors = [(storey, door) for storey in building for door in storey.floor.doors]
        points = {self.name(storey, room.id): self.locate(storey, room) for storey, room in building.list_rooms()}
        self.edges: list[Edge] = []
        for storey, door in self.doors:
            middle = door.line.interpolate(0.5, normalized=True)
            first, second = door.rooms
            ends = self.name(storey, first), OUTSIDE if second is None else self.name(storey, second)
            path = [points.get(ends[0]), (middle.x, middle.y, self._height(storey)), points.get(ends[1])]
            self._add(*ends, [point for point in path if point is not None])
        for link in building.links:
            one, other = (f"S-{self.indexes[storey]}-{room}" for storey, room in link.ends)
            self._add(one, other, [points[one], points[other]])

    @property
    def has_outside(self) -> bool:
        """Whether there is an entrance."""
        return any(OUTSIDE in edge[:2] for edge in self.edges)

    def name(self, storey: Storey, room_id: int) -> str:
        """The id of the state of a room."""
        return f"S-{self.indexes[storey.name]}-{room_id}"

    def locate(self, storey: Storey, room: Room) -> XYZ:
        """A point in a room."""
        inside: Point = room.polygon.representative_point()
        return inside.x, inside.y, self._height(storey)

    def list_connects(self, state: str) -> list[Element]:
        """The references of a state to its transitions."""
        return [_reference("connects", f"T-{n}") for n, edge in enumerate(self.edges, start=1) if state in edge[:2]]

    def _height(self, storey: Storey) -> float:
        return storey.elevation or 0.0

    def _add(self, one: str, other: str, path: list[XYZ]) -> None:
        self.edges.append((one, other, _measure(path), path))


def _measure(path: list[XYZ]) -> float:
    return sum(dist(one, other) for one, other in pairwise(path))


def _add_cell(parent: Element, graph: _Graph, storey: Storey, room: Room) -> None:
    state = graph.name(storey, room.id)
    cell = _sub_feature(parent, "CellSpace", f"C{state[1:]}", room.title or f"Room {room.id}", _describe(storey, room))
    surface = _sub(_sub(cell, "cellSpaceGeometry"), "Geometry2D")
    _add_polygon(surface, f"G{state[1:]}", room.polygon, storey.elevation or 0.0)
    cell.append(_reference("duality", state))
    for number, (other, door) in enumerate(graph.doors, start=1):
        if other is storey and room.id in door.room_ids:
            cell.append(_reference("partialboundedBy", f"B-{number}"))


def _describe(storey: Storey, room: Room) -> str:
    """What the core module has no element for, as the tools that write IndoorGML put it."""
    values = {"storey": storey.title or storey.name, "usage": room.label or "", "id": str(room.id)}
    return ":".join(f'{name}="{value}"' for name, value in values.items() if value)


def _add_state(parent: Element, graph: _Graph, storey: Storey, room: Room) -> None:
    name = graph.name(storey, room.id)
    state = _sub_feature(parent, "State", name, room.title or f"Room {room.id}")
    state.append(_reference("duality", f"C{name[1:]}"))
    state.extend(graph.list_connects(name))
    point = _sub_gml(_sub(state, "geometry"), "Point", f"P{name[1:]}")
    _sub_gml(point, "pos").text = _list_numbers([graph.locate(storey, room)])


def _add_boundary(parent: Element, number: int, storey: Storey, door: Door) -> None:
    name = "entrance" if door.is_entrance else door.kind
    boundary = _sub_feature(parent, "CellSpaceBoundary", f"B-{number}", f"{name} {number}")
    boundary.append(_reference("duality", f"T-{number}"))
    curve = _sub(_sub(boundary, "cellSpaceBoundaryGeometry"), "geometry2D")
    _add_line(curve, f"BG-{number}", [(x, y, storey.elevation or 0.0) for x, y, *_ in door.line.coords])


def _add_transition(parent: Element, number: int, edge: Edge, *, has_boundary: bool = True) -> None:
    one, other, length, path = edge
    transition = _sub_feature(parent, "Transition", f"T-{number}")
    _sub(transition, "weight").text = str(round(length, DIGITS))
    transition.extend([_reference("connects", one), _reference("connects", other)])
    if has_boundary:
        transition.append(_reference("duality", f"B-{number}"))
    _add_line(_sub(transition, "geometry"), f"TG-{number}", path)


def _add_polygon(parent: Element, name: str, polygon: Polygon, height: float) -> None:
    surface = _sub_gml(parent, "Polygon", name)
    for index, ring in enumerate((polygon.exterior, *polygon.interiors)):
        side = _sub_gml(surface, "interior" if index else "exterior")
        positions = _sub_gml(_sub_gml(side, "LinearRing"), "posList", srsDimension="3")
        positions.text = _list_numbers([(x, y, height) for x, y, *_ in ring.coords])


def _add_line(parent: Element, name: str, points: list[XYZ]) -> None:
    line = _sub_gml(parent, "LineString", name)
    _sub_gml(line, "posList", srsDimension="3").text = _list_numbers(points)


def _list_numbers(points: list[XYZ]) -> str:
    return " ".join(f"{value + 0.0:.{DIGITS}f}" for point in points for value in point)


def _list_left_out(building: Building) -> list[str]:
    names = ("walls", "furniture", "possible_doors")
    counts = {name: sum(len(getattr(storey.floor, name)) for storey in building) for name in names}
    nouns = {"walls": "wall", "furniture": "piece", "possible_doors": "possible door"}
    notes = [f"{count_noun(counts[name], nouns[name])}{' of furniture' * (name == 'furniture')}" for name in names]
    listed = [note for note, name in zip(notes, names, strict=True) if counts[name]]
    return [f"{', '.join(listed)} left out, which cells and doors alone describe"] if listed else []


def _feature(tag: str, name: str, title: str = "", description: str = "") -> Element:
    element = Element(f"{{{CORE}}}{tag}", {f"{{{GML}}}id": name})
    if description:
        _sub_gml(element, "description").text = description
    if title:
        _sub_gml(element, "name").text = title
    return element


def _sub_feature(parent: Element, tag: str, name: str, title: str = "", description: str = "") -> Element:
    element = _feature(tag, name, title, description)
    parent.append(element)
    return element


def _reference(tag: str, name: str) -> Element:
    return Element(f"{{{CORE}}}{tag}", {f"{{{XLINK}}}href": f"#{name}"})


def _sub(parent: Element, tag: str) -> Element:
    return SubElement(parent, f"{{{CORE}}}{tag}")


def _sub_gml(parent: Element, tag: str, name: str = "", **attributes: str) -> Element:
    identifier = {f"{{{GML}}}id": name} if name else {}
    return SubElement(parent, f"{{{GML}}}{tag}", {**identifier, **attributes})
