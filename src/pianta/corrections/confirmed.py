"""Rooms that a person confirms by correcting them: who names a room says that it is one, with this outline."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from pianta.corrections._doors import find_beside
from pianta.corrections._positions import draw_line, find_door, find_nearest_room
from pianta.corrections.kinds import (
    ChangeDoor,
    Correction,
    DeleteDoor,
    DeleteRoom,
    DrawDoor,
    LabelRoom,
    MergeRooms,
    MoveDoor,
    NameRoom,
    NumberRoom,
    ScaleToArea,
    SplitRoom,
)
from pianta.errors import CorrectionError
from pianta.floor import Floor, Room


def list_confirmed(floor: Floor, corrections: Iterable[Correction]) -> list[Room]:
    """The rooms that corrections confirm, each once, in the order of the floor.

    floor: without the corrections. Its metres are those of the corrections. Rooms are confirmed that are named,
    numbered, labelled, measured, split or merged, and those on both sides of a door that is drawn, moved, changed or
    deleted. Of a room that is deleted the outline is confirmed: no more than this is deleted the next time.
    """
    ids = {room_id for correction in corrections for room_id in _list_ids(floor, correction)}
    return [room for room in floor if room.id in ids]


def _list_ids(floor: Floor, correction: Correction) -> Sequence[int]:
    if isinstance(correction, DeleteDoor | ChangeDoor):
        try:
            return find_door(floor, correction.position).room_ids
        except CorrectionError:  # A door that an earlier correction has drawn
            return []
    if isinstance(correction, DrawDoor | MoveDoor):
        beside = (find_beside(floor, draw_line(correction.line), side) for side in (1, -1))
        return [room_id for room_id in beside if room_id is not None]
    if isinstance(correction, MergeRooms):
        positions = correction.positions
    elif isinstance(correction, SplitRoom):
        positions = correction.sides
    elif isinstance(correction, NameRoom | NumberRoom | LabelRoom | ScaleToArea | DeleteRoom):
        positions = (correction.position,)
    else:
        positions = ()
    rooms = (find_nearest_room(floor.rooms, position) for position in positions)
    return [room.id for room in rooms if room is not None]
