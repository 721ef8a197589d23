"""Corrections as data: what a person says about a floor, at positions of the map frame and not by ids.

A position is a point deep inside a room, or the middle of a door. So a correction still holds when the map is read
again and rooms have other outlines or ids. All coordinates are metres of the map frame.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from types import MappingProxyType
from typing import Annotated, Any, Literal, TypeAlias, TypeVar

import numpy as np
from pydantic import ConfigDict, Field

from pianta._types import Floats
from pianta.errors import CorrectionError

# Beyond any map frame; metres.
MAX_COORDINATE = 1e8
# Points of a line or an outline, at most; a limit of time.
MAX_POINTS = 1000
# Characters of a name, a label or a type, as in floor.geojson.
MAX_TEXT = 200
Metres = Annotated[float, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE, allow_inf_nan=False)]
Size = Annotated[float, Field(gt=0, le=MAX_COORDINATE**2, allow_inf_nan=False)]
Text = Annotated[str, Field(min_length=1, max_length=MAX_TEXT)]
XY: TypeAlias = tuple[Metres, Metres]
Points = Annotated[tuple[XY, ...], Field(min_length=2, max_length=MAX_POINTS)]
DoorKind: TypeAlias = Literal["door", "opening"]


class _Checked:
    """How pydantic checks a correction in a file: types as they are, and no further members."""

    __pydantic_config__ = ConfigDict(extra="forbid", strict=True)


def describe_points(*points: XY) -> str:
    """The first points of a correction in a message."""
    first = " ".join(f"({x:.2f}, {y:.2f})" for x, y in points[:3])
    return f"{first} …" if len(points) > 3 else first


def _with_article(door: DoorKind) -> str:
    return "an opening" if door == "opening" else "a door"


@dataclass(frozen=True)
class MergeRooms(_Checked):
    """The rooms at these positions are one room."""

    positions: Points

    def __str__(self) -> str:
        return f"merge the rooms at {describe_points(*self.positions)}"


@dataclass(frozen=True)
class SplitRoom(_Checked):
    """A border divides a room; the two sides are positions in different rooms. line: from wall to wall."""

    line: Points
    sides: tuple[XY, XY]

    def __str__(self) -> str:
        return f"split the room along {describe_points(*self.line)}"


@dataclass(frozen=True)
class DrawRoom(_Checked):
    """There is a room with this outline, whose last corner is not the first one again."""

    outline: Points

    def __str__(self) -> str:
        return f"a room with the corners {describe_points(*self.outline)}"


@dataclass(frozen=True)
class DeleteRoom(_Checked):
    """There is no room at this position, and no door to it."""

    position: XY

    def __str__(self) -> str:
        return f"no room at {describe_points(self.position)}"


@dataclass(frozen=True)
class MarkOutside(_Checked):
    """The area in this outline is outside of the building; doors to rooms in it are entrances."""

    outline: Points

    def __str__(self) -> str:
        return f"outside within {describe_points(*self.outline)}"


@dataclass(frozen=True)
class DrawDoor(_Checked):
    """There is a door or an opening. line: from jamb to jamb."""

    line: Points
    door: DoorKind = "door"

    def __str__(self) -> str:
        return f"{_with_article(self.door)} at {describe_points(*self.line)}"


@dataclass(frozen=True)
class MoveDoor(_Checked):
    """The door at a position is elsewhere. line: from jamb to jamb."""

    position: XY
    line: Points

    def __str__(self) -> str:
        return f"the door at {describe_points(self.position)} is at {describe_points(*self.line)}"


@dataclass(frozen=True)
class DeleteDoor(_Checked):
    """There is no door or opening at this position."""

    position: XY

    def __str__(self) -> str:
        return f"no door at {describe_points(self.position)}"


@dataclass(frozen=True)
class ChangeDoor(_Checked):
    """What is at this position is a door, or an opening."""

    position: XY
    door: DoorKind

    def __str__(self) -> str:
        return f"what is at {describe_points(self.position)} is {_with_article(self.door)}"


@dataclass(frozen=True)
class NameRoom(_Checked):
    """The room at a position has this name; None for no name."""

    position: XY
    name: Text | None

    def __str__(self) -> str:
        return (
            f"the room at {describe_points(self.position)} has {f'the name {self.name!r}' if self.name else 'no name'}"
        )


@dataclass(frozen=True)
class NumberRoom(_Checked):
    """The room at a position has this number, as on its door; None for no number."""

    position: XY
    number: Text | None

    def __str__(self) -> str:
        number = f"the number {self.number!r}" if self.number else "no number"
        return f"the room at {describe_points(self.position)} has {number}"


@dataclass(frozen=True)
class LabelRoom(_Checked):
    """The room at a position is for this purpose; None for an unknown one."""

    position: XY
    label: Text | None

    def __str__(self) -> str:
        label = f"the label {self.label}" if self.label else "no label"
        return f"the room at {describe_points(self.position)} has {label}"


@dataclass(frozen=True)
class SetType(_Checked):
    """The building is of this type; None for an unknown one."""

    building_type: Text | None

    def __str__(self) -> str:
        return f"the building is of {f'the type {self.building_type}' if self.building_type else 'no known type'}"


@dataclass(frozen=True)
class ScaleToLength(_Checked):
    """A line on the floor is so long, metres. All later corrections are in the new metres."""

    line: Points
    length: Size

    def __str__(self) -> str:
        return f"the line {describe_points(*self.line)} is {self.length:g} m long"


@dataclass(frozen=True)
class ScaleToArea(_Checked):
    """The room at a position has this area, m². All later corrections are in the new metres."""

    position: XY
    area: Size

    def __str__(self) -> str:
        return f"the room at {describe_points(self.position)} has {self.area:g} m²"


Correction: TypeAlias = (
    MergeRooms
    | SplitRoom
    | DrawRoom
    | DeleteRoom
    | MarkOutside
    | DrawDoor
    | MoveDoor
    | DeleteDoor
    | ChangeDoor
    | NameRoom
    | NumberRoom
    | LabelRoom
    | SetType
    | ScaleToLength
    | ScaleToArea
)
AnyCorrection = TypeVar("AnyCorrection", bound=Correction)

# The name of each kind in corrections.json and on the page.
KINDS = MappingProxyType(
    {
        "merge": MergeRooms,
        "split": SplitRoom,
        "draw room": DrawRoom,
        "delete room": DeleteRoom,
        "outside": MarkOutside,
        "draw door": DrawDoor,
        "move door": MoveDoor,
        "delete door": DeleteDoor,
        "change door": ChangeDoor,
        "name": NameRoom,
        "number": NumberRoom,
        "label": LabelRoom,
        "type": SetType,
        "length": ScaleToLength,
        "area": ScaleToArea,
    }
)
# Members that are a point, and members that are several points.
_POINTS = ("position",)
_PATHS = ("positions", "line", "sides", "outline")


def name_kind(correction: Correction) -> str:
    """The name of the kind of a correction, as in KINDS."""
    return next(name for name, each in KINDS.items() if each is type(correction))


def check_positions(*positions: XY) -> None:
    """Raise CorrectionError for points that are no positions of a map frame."""
    if not (np.abs(np.array(positions, float)) <= MAX_COORDINATE).all():
        raise CorrectionError(f"{describe_points(*positions)} is no position, give metres of the map frame")


def move_correction(correction: AnyCorrection, move: Callable[[Floats], Floats]) -> AnyCorrection:
    """The correction with all its points moved. move: takes and gives points of shape (N, 2)."""

    def move_points(points: Points) -> Points:
        return tuple((float(x), float(y)) for x, y in move(np.array(points, float).reshape(-1, 2)))

    changes: dict[str, Any] = {}
    for member in fields(correction):
        value = getattr(correction, member.name)
        if member.name in _POINTS:
            changes[member.name] = move_points((value,))[0]
        elif member.name in _PATHS:
            changes[member.name] = move_points(value)
    return replace(correction, **changes)
