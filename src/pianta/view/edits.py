"""Edits of the page, which name rooms by their ids, as corrections, which name positions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from pianta.corrections.by_id import delete_door_at, label_by_id, merge_by_id, outline_of, position_of, split_by_id
from pianta.corrections.corrections_file import parse_correction
from pianta.corrections.kinds import (
    Correction,
    DeleteDoor,
    DeleteRoom,
    MarkOutside,
    NameRoom,
    NumberRoom,
    Points,
    ScaleToArea,
    Size,
    Text,
)
from pianta.errors import CorrectionError
from pianta.floor import Floor
from pianta.io._faults import describe_validation

# Rooms that are merged at once, at most; the points of a correction.
MAX_ROOMS = 1000


def read_edit(floor: Floor, edit: Mapping[str, Any]) -> Correction:
    """The correction that an edit of a floor means.

    edit: an object of JSON with a `kind`, as in corrections.json, but with the members `room` or `rooms`, ids,
    instead of `position` or `positions`; a split has no `sides`.

    Raises CorrectionError, in one line, for an edit of another form, or of a room that the floor does not have.
    """
    if not ({"room", "rooms"} & edit.keys()):
        correction = parse_correction(dict(edit))
        return delete_door_at(floor, correction.position) if isinstance(correction, DeleteDoor) else correction
    try:
        parsed: _Edit = _ADAPTER.validate_python(edit)
    except ValidationError as error:
        raise CorrectionError(describe_validation(error)) from None
    return parsed.correct(floor)


class _EditOfRoom(BaseModel):
    # Not strict: a point is a list in JSON, and a tuple in corrections.
    model_config = ConfigDict(extra="forbid", frozen=True)

    room: Annotated[int, Field(strict=True)]


class _Merge(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    kind: Literal["merge"]
    rooms: Annotated[list[Annotated[int, Field(strict=True)]], Field(max_length=MAX_ROOMS)]

    def correct(self, floor: Floor) -> Correction:
        return merge_by_id(floor, self.rooms)


class _Split(_EditOfRoom):
    kind: Literal["split"]
    line: Points

    def correct(self, floor: Floor) -> Correction:
        return split_by_id(floor, self.room, self.line)


class _Delete(_EditOfRoom):
    kind: Literal["delete room"]

    def correct(self, floor: Floor) -> Correction:
        return DeleteRoom(position_of(floor, self.room))


class _Outside(_EditOfRoom):
    kind: Literal["outside"]

    def correct(self, floor: Floor) -> Correction:
        return MarkOutside(outline_of(floor, self.room))


class _Name(_EditOfRoom):
    kind: Literal["name"]
    name: Text | None

    def correct(self, floor: Floor) -> Correction:
        return NameRoom(position_of(floor, self.room), self.name)


class _Number(_EditOfRoom):
    kind: Literal["number"]
    number: Text | None

    def correct(self, floor: Floor) -> Correction:
        return NumberRoom(position_of(floor, self.room), self.number)


class _Label(_EditOfRoom):
    kind: Literal["label"]
    label: Text | None

    def correct(self, floor: Floor) -> Correction:
        return label_by_id(floor, self.room, self.label)


class _Area(_EditOfRoom):
    kind: Literal["area"]
    area: Size

    def correct(self, floor: Floor) -> Correction:
        return ScaleToArea(position_of(floor, self.room), self.area)


_Edit = Annotated[_Merge | _Split | _Delete | _Outside | _Name | _Number | _Label | _Area, Field(discriminator="kind")]
_ADAPTER: TypeAdapter[Any] = TypeAdapter(_Edit)
