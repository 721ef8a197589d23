"""Corrections in words."""

from __future__ import annotations

from pianta.corrections._places import describe_path, describe_place
from pianta.corrections.kinds import (
    ChangeDoor,
    Correction,
    DeleteDoor,
    DeleteRoom,
    DrawDoor,
    DrawRoom,
    LabelRoom,
    MarkOutside,
    MergeRooms,
    MoveDoor,
    NameRoom,
    ScaleToArea,
    ScaleToLength,
    SetType,
    SplitRoom,
)


def describe(correction: Correction) -> str:
    """A correction as a short line."""
    match correction:
        case MergeRooms(places):
            return f"merge the rooms at {describe_path(places)}"
        case SplitRoom(line):
            return f"split the room along {describe_path(line)}"
        case DrawRoom(outline):
            return f"a room with the corners {describe_path(outline)}"
        case DeleteRoom(place):
            return f"no room at {describe_place(place)}"
        case MarkOutside(outline):
            return f"outside within {describe_path(outline)}"
        case NameRoom(place, name):
            return f"the room at {describe_place(place)} has {f'the name {name!r}' if name else 'no name'}"
        case LabelRoom(place, label):
            return f"the room at {describe_place(place)} has {f'the label {label}' if label else 'no label'}"
        case SetType(building_type):
            return f"the building is of {f'the type {building_type}' if building_type else 'no known type'}"
        case ScaleToLength(line, length):
            return f"the line {describe_path(line)} is {length:g} m long"
        case ScaleToArea(place, area):
            return f"the room at {describe_place(place)} has {area:g} m²"
        case _:
            return _describe_door(correction)


def _describe_door(correction: DrawDoor | MoveDoor | DeleteDoor | ChangeDoor) -> str:
    match correction:
        case DrawDoor(line, kind):
            return f"{_with_article(kind)} at {describe_path(line)}"
        case MoveDoor(place, line):
            return f"the door at {describe_place(place)} is at {describe_path(line)}"
        case DeleteDoor(place):
            return f"no door at {describe_place(place)}"
        case ChangeDoor(place, kind):
            return f"what is at {describe_place(place)} is {_with_article(kind)}"


def _with_article(kind: str) -> str:
    return "an opening" if kind == "opening" else "a door"
