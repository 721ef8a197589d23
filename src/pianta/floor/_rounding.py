"""Floors with coordinates in whole millimetres."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from shapely import LineString, Polygon, transform

from pianta.floor._floor import Floor
from pianta.floor._parts import Door

Shape = TypeVar("Shape", LineString, Polygon)

# Of a metre; the cells of maps have centimetres.
DIGITS = 3


def round_floor(floor: Floor) -> Floor:
    """The floor with coordinates and widths in whole millimetres; a polygon that would be invalid stays as it is."""
    rooms = tuple(
        replace(room, polygon=_round_shape(room.polygon), predicted=room.predicted and _round_shape(room.predicted))
        for room in floor.rooms
    )
    return replace(
        floor,
        rooms=rooms,
        doors=tuple(map(_round_door, floor.doors)),
        walls=tuple(map(_round_shape, floor.walls)),
        furniture=tuple(replace(piece, polygon=_round_shape(piece.polygon)) for piece in floor.furniture),
        possible_doors=tuple(map(_round_door, floor.possible_doors)),
    )


def _round_door(door: Door) -> Door:
    return replace(door, line=_round_shape(door.line), width=round(door.width, DIGITS))


def _round_shape(shape: Shape) -> Shape:
    rounded: Shape = transform(shape, _round_coordinates)
    is_kept = isinstance(shape, LineString) or (rounded.is_valid and rounded.area > 0)
    return rounded if is_kept else shape


def _round_coordinates(coordinates: NDArray[np.float64]) -> NDArray[np.float64]:
    # Adding 0 makes -0.0 a plain 0
    return np.round(coordinates, DIGITS) + 0.0
