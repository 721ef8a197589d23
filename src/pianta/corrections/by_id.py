"""Corrections of rooms that are named by their ids on a floor, as a person sees them."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from pianta.corrections._positions import draw_line, draw_outline, find_door, position_in
from pianta.corrections.kinds import XY, DeleteDoor, LabelRoom, MergeRooms, Points, SplitRoom
from pianta.errors import CorrectionError
from pianta.floor import Floor, Room
from pianta.floor.shapes import split_shape
from pianta.labels import ALL_SCHEMAS, FCES, RC, normalize_label


def find_by_id(floor: Floor, room_id: int) -> Room:
    """The room with an id.

    Raises CorrectionError without one.
    """
    if room_id not in floor:
        raise CorrectionError(f"there is no room {room_id}, the ids of the floor are {_list_ids(floor)}")
    return floor[room_id]


def _list_ids(floor: Floor) -> str:
    """The ids of the rooms, three or more in a row by the first and the last of them: "1 … 4, 6"."""
    runs: list[list[int]] = []
    for room_id in sorted(room.id for room in floor):
        if runs and room_id == runs[-1][-1] + 1:
            runs[-1].append(room_id)
        else:
            runs.append([room_id])
    return ", ".join(f"{run[0]} … {run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs) or "none"


def position_of(floor: Floor, room_id: int) -> XY:
    """A position deep inside a room."""
    return position_in(find_by_id(floor, room_id).polygon)


def merge_by_id(floor: Floor, room_ids: Iterable[int]) -> MergeRooms:
    """The correction that merges rooms with these ids."""
    ids = [*dict.fromkeys(room_ids)]
    if len(ids) < 2:
        raise CorrectionError("one room alone cannot be merged, give the ids of two or more")
    return MergeRooms(tuple(position_of(floor, room_id) for room_id in ids))


def split_by_id(floor: Floor, room_id: int, line: Points) -> SplitRoom:
    """The correction that divides a room along a line."""
    parts, _ = split_shape(find_by_id(floor, room_id).polygon, draw_line(line))
    if len(parts) < 2:
        raise CorrectionError(f"the line does not divide room {room_id}, draw it from wall to wall")
    return SplitRoom(line, (position_in(parts[0]), position_in(parts[1])))


def outline_of(floor: Floor, room_id: int) -> Points:
    """The outline of a room, without its holes."""
    corners = find_by_id(floor, room_id).polygon.exterior.coords[:-1]
    outline: Points = tuple((float(x), float(y)) for x, y in corners)
    draw_outline(outline)
    return outline


def delete_door_at(floor: Floor, position: XY) -> DeleteDoor:
    """The correction that deletes the door or opening at a position.

    Raises CorrectionError without one: a person who deletes a door sees one.
    """
    find_door(floor, position)
    return DeleteDoor(position)


def label_by_id(floor: Floor, room_id: int, label: str | None) -> LabelRoom:
    """The correction that gives a room a label, in any case, of a schema or of another room of the floor."""
    name = normalize_label(label)
    own = {room.label for room in floor if room.label}
    labels = {*own, *RC, *FCES, *(name for schema in ALL_SCHEMAS.values() for name in schema.by_name)}
    if name is not None and name not in labels:
        similar = get_close_matches(name, sorted(labels)) or sorted(labels)[:5]
        raise CorrectionError(f"label {name[:50]!r} is in no schema, give one such as {', '.join(similar)}")
    return LabelRoom(position_of(floor, room_id), name)
