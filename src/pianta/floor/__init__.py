"""Floor, Room, Door and Furniture: the building, which is the input and output of every stage."""

from pianta.floor._cells import cells_of_polygon
from pianta.floor._floor import Floor
from pianta.floor._parts import (
    BALCONY_FLAG,
    DOOR_WIDTH,
    MAX_ROOM_NAME_LENGTH,
    OUTSIDE_FLAG,
    PREDICTED_FLAG,
    Door,
    Furniture,
    Room,
)
from pianta.floor._rounding import round_floor
from pianta.floor._scaling import move_floor, scale_floor

__all__ = [
    "BALCONY_FLAG",
    "DOOR_WIDTH",
    "MAX_ROOM_NAME_LENGTH",
    "OUTSIDE_FLAG",
    "PREDICTED_FLAG",
    "Door",
    "Floor",
    "Furniture",
    "Room",
    "cells_of_polygon",
    "move_floor",
    "round_floor",
    "scale_floor",
]
