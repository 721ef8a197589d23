"""The doors of an IFC, and where its rooms are open to each other: virtual boundaries and openings without a door."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from math import isfinite
from typing import TYPE_CHECKING, Literal

import numpy as np
import shapely
from shapely import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from pianta._types import Floats
from pianta.floor import DOOR_WIDTH, Door, Room
from pianta.io.drawings._ifc_model import IfcModel, Shape, list_boundaries, read_global_id, read_text
from pianta.io.drawings._ifc_outside import Outside

if TYPE_CHECKING:
    from ifcopenshell import entity_instance

# Doors of models that pianta wrote before it wrote openings as IFC has them.
OPENING_TYPE = "OPENING"

# Metres, chosen by hand:
MAX_WALL = 1.0  # from the middle of a door to its room
_MIN_DEPTH = 0.05  # of a room in front of a door
MAX_SILL = 0.3  # of an opening that people go through
MIN_HEAD = 1.5  # height of the head of such an opening above the floor
TOUCHING = 0.02  # between rooms without a wall
MIN_OPENING = 0.5  # width; a narrower gap is no way


@dataclass(frozen=True)
class StoreyRooms:
    """The rooms of a storey. by_space: by the numbers of their spaces. base: height of the floor, metres."""

    storey: entity_instance
    rooms: tuple[Room, ...]
    by_space: Mapping[int, Room]
    base: float


@dataclass
class Passages:
    """Reads how rooms are joined."""

    model: IfcModel
    outside: Outside

    def read_door(self, door: entity_instance, on: StoreyRooms) -> Door | None:
        """A door between rooms or from a room to elsewhere; None if it joins none."""
        line, width = self._line_of_door(door)
        bounded = _bounded_spaces(door)
        joined = list(dict.fromkeys(on.by_space[space].id for space, _ in bounded if space in on.by_space))
        is_outer = any(boundary.startswith("EXTERNAL") for _, boundary in bounded)
        if len(joined) != 2 and not (len(joined) == 1 and is_outer):
            beside = rooms_beside(line, on.rooms)
            joined = beside if beside else joined[:2]
        if not joined or (len(joined) == 2 and joined[0] == joined[1]):
            return None
        door_kind: Literal["door", "opening"] = "opening" if read_text(door, "ObjectType") == OPENING_TYPE else "door"
        if len(joined) == 2:
            return Door((joined[0], joined[1]), line, width, door_kind, global_id=read_global_id(door))
        inner = next(room.polygon for room in on.rooms if room.id == joined[0])
        out = self.outside.leads_out(door, line, inner, on.storey)
        return Door((joined[0], None), line, width, door_kind, leads_out=out, global_id=read_global_id(door))

    def _line_of_door(self, door: entity_instance) -> tuple[LineString, float]:
        """From jamb to jamb, metres, through the middle of the opening or the door if it has a shape; and the width."""
        matrix = self.model.locate(door)
        width = float(door.OverallWidth or 0) * self.model.metres_per_unit
        opening = next((fill.RelatingOpeningElement for fill in door.FillsVoids), None)
        shapes = (self.model.shape_of(product) for product in (opening, door) if product is not None)
        shape = next((shape for shape in shapes if len(shape.corners)), None)
        if shape is None:
            line = LineString(matrix[:2, 3] + np.array([[0, 0], [width or DOOR_WIDTH, 0]]) @ matrix[:2, :2].T)
        else:
            line = draw_line_through(shape, matrix)
        return line, width if isfinite(width) and width > 0 else float(line.length)

    def list_openings(self, on: StoreyRooms, doors: Sequence[Door]) -> Iterator[Door]:
        """Where rooms are open to each other, each place once, and not where a door is."""
        lines: dict[tuple[int, int | None], list[LineString]] = {}
        for door in doors:
            lines.setdefault(door.rooms, []).append(door.line)
        for opening in (*self._list_unfilled(on), *self._list_virtual(on)):
            same = lines.setdefault(opening.rooms, [])
            if all(opening.line.distance(line) > MAX_WALL for line in same):
                same.append(opening.line)
                yield opening

    def _list_virtual(self, on: StoreyRooms) -> Iterator[Door]:
        """Openings at the virtual boundaries between rooms of the storey."""
        for boundary in self.model.list_products("IfcRelSpaceBoundary"):
            space = boundary.RelatingSpace
            if boundary.PhysicalOrVirtualBoundary != "VIRTUAL" or space is None or space.id() not in on.by_space:
                continue
            room = on.by_space[space.id()]
            line = self._line_of_boundary(boundary)
            for other in self._rooms_behind(boundary, room, line, on):
                border = line if line is not None else draw_border(room.polygon, other.polygon)
                yield Door((room.id, other.id), border, float(border.length), "opening")

    def _rooms_behind(
        self, boundary: entity_instance, room: Room, line: LineString | None, on: StoreyRooms
    ) -> list[Room]:
        """The rooms on the other side of a virtual boundary: as the file relates them, else the one that meets it."""
        paired = getattr(boundary, "CorrespondingBoundary", None)
        shared = boundary.RelatedBuildingElement
        related = [paired] if paired is not None else list_boundaries(shared) if shared is not None else []
        spaces = [each.RelatingSpace for each in related if each.RelatingSpace is not None]
        others = [space.id() for space in spaces if space.id() != boundary.RelatingSpace.id()]
        if others:
            return [on.by_space[number] for number in dict.fromkeys(others) if number in on.by_space]
        if line is None:
            return []
        beside = [each for each in on.rooms if each.id != room.id and each.polygon.distance(line) <= MAX_SILL]
        lengths = [each.polygon.buffer(MAX_SILL).intersection(line).length for each in beside]
        return [beside[int(np.argmax(lengths))]] if beside else []

    def _line_of_boundary(self, boundary: entity_instance) -> LineString | None:
        """The line of an upright boundary from above, metres; None if its shape is unknown, or it is level."""
        points = _list_points(boundary.ConnectionGeometry)
        if len(points) < 2:
            return None
        matrix = self.model.locate(boundary.RelatingSpace)
        world = points * self.model.metres_per_unit @ matrix[:3, :3].T + matrix[:3, 3]
        hull = shapely.MultiPoint(world[:, :2]).minimum_rotated_rectangle
        if isinstance(hull, LineString) and hull.length >= TOUCHING:
            return LineString(shapely.get_coordinates(hull)[[0, -1]])
        return None

    def _list_unfilled(self, on: StoreyRooms) -> Iterator[Door]:
        """Openings of walls that people go through, without a door, between two rooms."""
        for opening, shape in self.outside.walls.openings:
            if opening.HasFillings or not _is_way(shape, on.base):
                continue
            line = draw_line_through(shape, self.model.locate(opening))
            bounded = [space for space, _ in _bounded_spaces(opening) if space in on.by_space]
            joined = list(dict.fromkeys(on.by_space[space].id for space in bounded)) or rooms_beside(line, on.rooms)
            is_outer = any(boundary.startswith("EXTERNAL") for _, boundary in _bounded_spaces(opening))
            if len(joined) == 2 and joined[0] != joined[1]:
                yield Door((joined[0], joined[1]), line, float(line.length), "opening")
            elif len(joined) == 1 and is_outer and self.outside.is_ground(on.storey):
                yield Door((joined[0], None), line, float(line.length), "opening")

    def list_gaps(self, on: StoreyRooms, joined: Sequence[Door]) -> Iterator[Door]:
        """Where rooms that no passage joins touch each other and no wall is between them."""
        pairs = {door.rooms for door in joined}
        polygons = np.array([room.polygon for room in on.rooms])
        tree = shapely.STRtree(polygons)
        for first, second in tree.query(polygons, predicate="dwithin", distance=TOUCHING).T:
            one, other = sorted((on.rooms[first], on.rooms[second]), key=lambda room: room.id)
            if first >= second or (one.id, other.id) in pairs:
                continue
            border = one.polygon.boundary.intersection(other.polygon.buffer(TOUCHING))
            if border.length < MIN_OPENING:
                continue
            free = border.difference(self.outside.cut_of(on.storey, on.base).buffer(TOUCHING))
            line = _longest_line(free)
            if line is not None and line.length >= MIN_OPENING:
                yield Door((one.id, other.id), line, float(line.length), "opening")


def draw_line_through(shape: Shape, matrix: Floats) -> LineString:
    """The longer middle line of a shape from above, in the axes of its placement, metres."""
    start, axes = matrix[:2, 3], matrix[:2, :2]
    local = (shape.corners[:, :2] - start) @ axes
    low, high = local.min(axis=0), local.max(axis=0)
    longer = int(high[1] - low[1] > high[0] - low[0])
    ends = np.tile((low + high) / 2, (2, 1))
    ends[:, longer] = low[longer], high[longer]
    return LineString(start + ends @ axes.T)


def draw_border(one: Polygon, other: Polygon) -> LineString:
    """The line on which two outlines meet, or else the shortest one between them, metres."""
    reach = one.distance(other) + TOUCHING
    line = _longest_line(one.boundary.intersection(other.buffer(reach)))
    return line if line is not None else shapely.shortest_line(one, other)


def rooms_beside(line: LineString, rooms: Sequence[Room]) -> list[int]:
    """The ids of the rooms on both sides of a door: those with the longest share of MAX_WALL metres in front of it.

    The ids are equal if the same room is on both sides.
    """
    ends = shapely.get_coordinates(line)
    along = ends[1] - ends[0]
    length = np.hypot(*along)
    if not np.isfinite(length) or length == 0 or not rooms:
        return []
    outlines = np.array([room.polygon for room in rooms])
    beside = []
    for side in (-1, 1):
        across = np.array([-along[1], along[0]]) * side * MAX_WALL / length
        ray = LineString([ends.mean(axis=0), ends.mean(axis=0) + across])
        depths = shapely.length(shapely.intersection(outlines, ray))
        if depths.max() > _MIN_DEPTH:
            beside.append(rooms[int(depths.argmax())].id)
    return beside


def _longest_line(lines: BaseGeometry) -> LineString | None:
    """From end to end of the longest connected piece of a border; None without one."""
    merged = shapely.line_merge(lines) if lines.geom_type == "MultiLineString" else lines
    pieces = [piece for piece in shapely.get_parts(merged) if isinstance(piece, LineString) and piece.length > 0]
    if not pieces:
        return None
    corners = shapely.get_coordinates(max(pieces, key=lambda piece: piece.length))
    far = max(combinations(corners, 2), key=lambda pair: float(np.hypot(*(pair[1] - pair[0]))))
    return LineString(far)


def _is_way(shape: Shape, base: float) -> bool:
    """Whether people go through an opening: it begins at the floor and is high and wide enough."""
    if not len(shape.faces):
        return False
    width = np.ptp(shape.corners[:, :2], axis=0).max()
    return bool(abs(shape.low - base) <= MAX_SILL and shape.high >= base + MIN_HEAD and width >= MIN_OPENING)


def _bounded_spaces(element: entity_instance) -> list[tuple[int, str]]:
    """The numbers of the spaces that an element bounds, and whether each boundary is INTERNAL or EXTERNAL."""
    boundaries = ((each.RelatingSpace, each.InternalOrExternalBoundary) for each in list_boundaries(element))
    return [
        (space.id(), str(boundary)) for space, boundary in boundaries if space is not None and space.is_a("IfcSpace")
    ]


def _list_points(geometry: entity_instance | None) -> Floats:
    """Points of the surface of a boundary, shape (N, 3), in units of the file and the frame of its space; or none."""
    surface = getattr(geometry, "SurfaceOnRelatingElement", None)
    if surface is None:
        return np.zeros((0, 3))
    if surface.is_a("IfcCurveBoundedPlane"):
        return _place_points(_list_curve(surface.OuterBoundary), surface.BasisSurface.Position)
    if surface.is_a("IfcSurfaceOfLinearExtrusion"):
        curve = getattr(surface.SweptCurve, "Curve", None)
        return _place_points(_list_curve(curve), surface.Position)
    return np.zeros((0, 3))


def _list_curve(curve: entity_instance | None) -> Floats:
    """The corners of a curve of straight pieces, shape (N, 3); none for another."""
    if curve is None:
        return np.zeros((0, 3))
    if curve.is_a("IfcPolyline"):
        points = [tuple(point.Coordinates) for point in curve.Points]
    elif curve.is_a("IfcIndexedPolyCurve"):
        points = [tuple(point) for point in curve.Points.CoordList]
    elif curve.is_a("IfcCompositeCurve"):
        return np.concatenate([_list_curve(segment.ParentCurve) for segment in curve.Segments])
    elif curve.is_a("IfcTrimmedCurve"):
        ends = [part for trim in (curve.Trim1, curve.Trim2) for part in trim if hasattr(part, "Coordinates")]
        points = [tuple(point.Coordinates) for point in ends]
    else:
        points = []
    return np.array([(*point, 0.0)[:3] for point in points], float).reshape(-1, 3)


def _place_points(points: Floats, position: entity_instance | None) -> Floats:
    from ifcopenshell.util.placement import get_axis2placement

    if position is None:
        return points
    matrix = np.array(get_axis2placement(position), float)
    placed: Floats = points @ matrix[:3, :3].T + matrix[:3, 3]
    return placed
