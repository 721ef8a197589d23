"""Floors in another frame, or of another size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

from shapely import LineString, Polygon
from shapely.affinity import scale

from pianta.floor._floor import Floor
from pianta.floor._parts import Door, Room

Shape = TypeVar("Shape", LineString, Polygon)


def move_floor(floor: Floor, move: Callable[[Shape], Shape]) -> Floor:
    """The floor with all shapes moved by a function, which keeps lengths."""

    def move_room(room: Room) -> Room:
        return replace(room, polygon=move(room.polygon), predicted=move(room.predicted) if room.predicted else None)

    return replace(
        floor,
        rooms=tuple(map(move_room, floor.rooms)),
        doors=tuple(replace(door, line=move(door.line)) for door in floor.doors),
        walls=tuple(map(move, floor.walls)),
        furniture=tuple(replace(piece, polygon=move(piece.polygon)) for piece in floor.furniture),
        possible_doors=tuple(replace(door, line=move(door.line)) for door in floor.possible_doors),
    )


def scale_floor(floor: Floor, x_factor: float, y_factor: float) -> Floor:
    """The floor with all lengths multiplied by a factor along each axis; the width of a door scales with its line.

    The width of a door whose line is a point scales by the geometric mean of the factors.
    """
    mean_factor = (x_factor * y_factor) ** 0.5

    def scale_shape(shape: Shape) -> Shape:
        larger: Shape = scale(shape, x_factor, y_factor, origin=(0, 0))
        return larger

    def scale_door(door: Door) -> Door:
        line, length = scale_shape(door.line), door.line.length
        return replace(door, line=line, width=door.width * (line.length / length if length else mean_factor))

    return replace(
        move_floor(floor, scale_shape),
        doors=tuple(map(scale_door, floor.doors)),
        possible_doors=tuple(map(scale_door, floor.possible_doors)),
    )
