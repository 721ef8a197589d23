"""Dense furniture of floors by the labels of their rooms, which may part rooms for the eye of a lidar."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
import shapely
from shapely import LineString, Polygon, unary_union

from pianta._types import Floats
from pianta.floor import Floor, Room
from pianta.worlds.pieces import FurnitureStyle, Outlines, make_person, transform_outlines
from pianta.worlds.room_furniture import furnish_by_label
from pianta.worlds.room_space import RoomSpace

# The measures and shares of this module were chosen by hand.
# Clear space on both sides of a door's line; metres.
DOOR_CLEARANCE = 0.55
# Smaller rooms stay empty; m².
SMALLEST_ROOM = 0.8
# Persons per m² of floor, at density 1.
PERSONS = 0.008


@dataclass(frozen=True)
class StandingPiece:
    """A piece in a room. kind: as of Piece. parts: what a lidar detects of it, metres in the floor's frame."""

    room: int
    kind: str
    parts: tuple[Polygon, ...]


def furnish_densely(floor: Floor, *, density: float, rng: np.random.Generator) -> list[Polygon]:
    """Obstacles that a lidar detects in the rooms of a floor: the parts of the pieces of `place_pieces`."""
    return [part for piece in place_pieces(floor, density=density, rng=rng) for part in piece.parts]


def place_pieces(floor: Floor, *, density: float, rng: np.random.Generator) -> list[StandingPiece]:
    """Furniture and people in the rooms of a floor, by their labels.

    density: 0 empty, 1 a usual place that is in use, 2 a crowded one.
    Pieces keep clear of doors and of each other, but desks, shelves and partitions may nearly close a passage.
    """
    furniture = FurnitureStyle.draw(rng)
    outlines: Outlines = []
    pieces: list[tuple[int, str, int]] = []
    zones: dict[int, list[LineString]] = {room.id: [] for room in floor.rooms}
    for door in floor.doors:
        for room_id in door.room_ids:
            zones[room_id].append(door.line)
    if density > 0:
        for room in floor.rooms:
            added, added_pieces = _furnish_room(room, zones[room.id], furniture, density, rng)
            outlines += added
            pieces += [(room.id, *piece) for piece in added_pieces]
    polygons = iter(_make_polygons(outlines))
    return [StandingPiece(room_id, name, tuple(islice(polygons, count))) for room_id, name, count in pieces]


def _make_polygons(outlines: Outlines) -> list[Polygon]:
    """Polygons of outlines, made together by their numbers of corners, in the order of the outlines."""
    polygons: list[Polygon] = [Polygon()] * len(outlines)
    sizes = np.array([len(outline) for outline in outlines], dtype=int)
    for size in np.unique(sizes):
        indices = np.flatnonzero(sizes == size)
        for index, polygon in zip(indices, shapely.polygons([outlines[i] for i in indices]), strict=True):
            polygons[index] = polygon
    return polygons


def _furnish_room(
    room: Room, doors: Sequence[LineString], furniture: FurnitureStyle, density: float, rng: np.random.Generator
) -> tuple[Outlines, list[tuple[str, int]]]:
    """Outlines of the obstacles in a room; kind and number of outlines of each piece."""
    if room.polygon.area < SMALLEST_ROOM:
        return [], []
    ring = np.asarray(room.polygon.exterior.coords)[:, :2]
    sides = np.diff(ring, axis=0)
    lengths = np.hypot(*sides.T)
    longest = sides[int(np.argmax(lengths))]
    turn = float(np.arctan2(longest[1], longest[0])) % (np.pi / 2)
    origin = ring.mean(axis=0)
    polygon = _turn_polygon(room.polygon, -turn, origin)
    lines = [_turn_line(line, -turn, origin) for line in doors]
    zones = unary_union([line.buffer(_clearance(line, rng), cap_style="square") for line in lines])
    shapely.prepare(polygon)
    shapely.prepare(zones)
    ring = np.asarray(polygon.exterior.coords)
    sides = np.diff(ring, axis=0)
    lengths = np.hypot(*sides.T)
    used = lengths > 0.2
    space = RoomSpace(
        polygon, zones, turn, rng, furniture, density, ring[:-1][used], (sides[used].T / lengths[used]).T, lengths[used]
    )
    furnish_by_label(space, room.label)
    for _ in range(space.count(PERSONS * space.area)):
        space.put_free(make_person(rng), any_angle=1.0)
    return transform_outlines(space.outlines, float(origin[0]), float(origin[1]), turn), space.pieces


def _clearance(line: LineString, rng: np.random.Generator) -> float:
    """Clear space around a door, metres: wide openings are less often kept free."""
    return DOOR_CLEARANCE * float(rng.uniform(0.5, 1.3)) if line.length < 1.5 else 0.3


def _turn_polygon(polygon: Polygon, turn: float, origin: Floats) -> Polygon:
    rings = [np.asarray(ring.coords)[:, :2] - origin for ring in (polygon.exterior, *polygon.interiors)]
    shell, *holes = transform_outlines(rings, 0, 0, turn)
    return Polygon(shell, holes)


def _turn_line(line: LineString, turn: float, origin: Floats) -> LineString:
    return LineString(transform_outlines([np.asarray(line.coords)[:, :2] - origin], 0, 0, turn)[0])
