"""Floors with coordinates in whole millimetres."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon

from pianta.floor._floor import Floor
from pianta.floor._parts import Door, Room

Shape = TypeVar("Shape", LineString, Polygon)
Part = TypeVar("Part")

# Of a metre; the cells of maps have centimetres.
DIGITS = 3


def round_floor(floor: Floor) -> Floor:
    """The floor with coordinates and widths in whole millimetres; a polygon that would be invalid stays as it is."""
    rooms = _round_parts(floor.rooms, lambda room: room.polygon, lambda room, shape: replace(room, polygon=shape))
    return replace(
        floor,
        rooms=tuple(map(_round_prediction, rooms)),
        doors=_round_doors(floor.doors),
        walls=tuple(_round_shapes(floor.walls)),
        furniture=_round_parts(
            floor.furniture, lambda piece: piece.polygon, lambda piece, shape: replace(piece, polygon=shape)
        ),
        possible_doors=_round_doors(floor.possible_doors),
    )


def _round_prediction(room: Room) -> Room:
    return room if room.predicted is None else replace(room, predicted=_round_shapes([room.predicted])[0])


def _round_doors(doors: Sequence[Door]) -> tuple[Door, ...]:
    widths = [round(door.width, DIGITS) for door in doors]
    doors = [
        door if door.width == width else replace(door, width=width) for door, width in zip(doors, widths, strict=True)
    ]
    return _round_parts(doors, lambda door: door.line, lambda door, shape: replace(door, line=shape))


def _round_parts(
    parts: Sequence[Part], get_shape: Callable[[Part], Shape], move: Callable[[Part, Shape], Part]
) -> tuple[Part, ...]:
    """The parts of a floor with rounded shapes. move: a part with another shape."""
    before = [get_shape(part) for part in parts]
    after = _round_shapes(before)
    return tuple(part if new is old else move(part, new) for part, old, new in zip(parts, before, after, strict=True))


def _round_shapes(shapes: Sequence[Shape]) -> list[Shape]:
    """The shapes with rounded coordinates; those that have them are the same objects."""
    coordinates, owner = shapely.get_coordinates([*shapes], return_index=True)
    rounded = _round_coordinates(coordinates)
    is_other = (rounded != coordinates) | (np.signbit(rounded) != np.signbit(coordinates))
    result = [*shapes]
    for index in np.unique(owner[is_other.any(axis=1)]).tolist():
        shape: Shape = shapely.transform(shapes[index], _round_coordinates)
        if isinstance(shape, LineString) or (shape.is_valid and shape.area > 0):
            result[index] = shape
    return result


def _round_coordinates(coordinates: NDArray[np.float64]) -> NDArray[np.float64]:
    # Adding 0 makes -0.0 a plain 0
    return np.round(coordinates, DIGITS) + 0.0
