"""Corrections applied to floors, undone, and applied again to floors that were read anew."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from math import isclose, isfinite, sqrt
from types import MappingProxyType
from typing import Any

from pianta.corrections import _doors, _rooms
from pianta.corrections._positions import draw_line, find_nearest_room, find_room
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
    NumberRoom,
    ScaleToArea,
    ScaleToLength,
    SetType,
    SplitRoom,
)
from pianta.errors import CorrectionError, PiantaError
from pianta.floor import Floor, scale_floor

# A floor whose scale differs by less has the right one (chosen by hand).
SAME_SCALE = 1e-4
# A correction of the scale by more is a slip, and would lead beyond what a map can have (chosen by hand).
MAX_FACTOR = 1e4


@dataclass(frozen=True)
class Outcome:
    """What became of a correction. problem: why it does not fit the floor; None if it does.

    changed: whether the floor is another one; it is not if it was as the correction says already. factor: by which all
    lengths were multiplied.
    """

    correction: Correction
    changed: bool
    problem: str | None = None
    factor: float = 1.0


@dataclass(frozen=True, eq=False)
class Inverse:
    """What takes a correction back. changes: member of the floor -> its value after the correction, and before it."""

    changes: Mapping[str, tuple[Any, Any]]

    def apply(self, floor: Floor) -> Floor:
        """The floor as it was before the correction.

        Raises CorrectionError if the floor has changed since.
        """
        changed = [name for name, (after, _) in self.changes.items() if getattr(floor, name) != after]
        if changed:
            raise CorrectionError(f"{' and '.join(changed)} have changed since, take back the later corrections first")
        return replace(floor, **{name: before for name, (_, before) in self.changes.items()})


def correct(floor: Floor, correction: Correction) -> Floor:
    """The floor with a correction; the same object if it is as the correction says already.

    Raises CorrectionError, in one line, if the correction does not fit the floor.
    """
    try:
        return _APPLY[type(correction)](floor, correction)
    except CorrectionError:
        raise
    except PiantaError as error:
        raise CorrectionError(str(error)) from error


def invert(floor: Floor, correction: Correction) -> Inverse:
    """What takes a correction of a floor back: `invert(floor, c).apply(correct(floor, c)) == floor`.

    Raises CorrectionError if the correction does not fit the floor.
    """
    after = correct(floor, correction)
    names = [member.name for member in fields(floor) if getattr(floor, member.name) != getattr(after, member.name)]
    return Inverse(MappingProxyType({name: (getattr(after, name), getattr(floor, name)) for name in names}))


def correct_all(floor: Floor, corrections: Iterable[Correction]) -> tuple[Floor, list[Outcome]]:
    """The floor with all corrections that fit, in their order, and what became of each."""
    outcomes = []
    for correction in corrections:
        try:
            corrected = correct(floor, correction)
        except CorrectionError as error:
            outcomes.append(Outcome(correction, changed=False, problem=str(error)))
        else:
            factor = _measure_factor(floor, corrected) if isinstance(correction, ScaleToLength | ScaleToArea) else 1.0
            outcomes.append(Outcome(correction, changed=corrected is not floor, factor=factor))
            floor = corrected
    return floor, outcomes


def find_unlabelled(floor: Floor, outcomes: Sequence[Outcome]) -> list[int]:
    """The indexes of the rooms from which corrections have taken the label, after all of them."""
    factor = 1.0
    labels: dict[int, str | None] = {}
    for outcome in reversed(outcomes):
        if isinstance(outcome.correction, LabelRoom) and outcome.problem is None:
            x, y = outcome.correction.position
            room = find_nearest_room(floor.rooms, (x * factor, y * factor))
            if room is not None:
                labels.setdefault(room.id, outcome.correction.label)
        # A position is in the metres of its time, and the floor is in the last ones
        factor *= outcome.factor
    return [index for index, room in enumerate(floor) if room.id in labels and labels[room.id] is None]


def _set_type(floor: Floor, correction: SetType) -> Floor:
    types = {correction.building_type: 1.0} if correction.building_type else {}
    changed = replace(floor, building_type=types)
    return floor if changed.building_type == floor.building_type else changed


def _scale_to_length(floor: Floor, correction: ScaleToLength) -> Floor:
    return _scale(floor, correction.length / draw_line(correction.line).length, f"a length of {correction.length} m")


def _scale_to_area(floor: Floor, correction: ScaleToArea) -> Floor:
    _check_positive(correction.area, f"an area of {correction.area} m²")
    room = find_room(floor, correction.position)
    return _scale(floor, sqrt(correction.area / room.polygon.area), f"an area of {correction.area} m²")


def _scale(floor: Floor, factor: float, what: str) -> Floor:
    _check_positive(factor, what)
    if not 1 / MAX_FACTOR <= factor <= MAX_FACTOR:
        raise CorrectionError(f"{what} multiplies all lengths by {factor:g}, give one that changes them less")
    return floor if isclose(factor, 1, rel_tol=SAME_SCALE) else scale_floor(floor, factor, factor)


def _measure_factor(floor: Floor, scaled: Floor) -> float:
    """By how much the lengths of a floor were multiplied; 1 for a floor without rooms."""
    area, scaled_area = (sum(room.polygon.area for room in each) for each in (floor, scaled))
    return sqrt(scaled_area / area) if area else 1.0


def _check_positive(value: float, what: str) -> None:
    if not (isfinite(value) and value > 0):
        raise CorrectionError(f"{what} is no size, give a positive number")


_APPLY: Mapping[type, Callable[[Floor, Any], Floor]] = MappingProxyType(
    {
        MergeRooms: _rooms.merge_rooms,
        SplitRoom: _rooms.split_room,
        DrawRoom: _rooms.draw_room,
        DeleteRoom: _rooms.delete_room,
        MarkOutside: _rooms.mark_outside,
        DrawDoor: _doors.draw_door,
        MoveDoor: _doors.move_door,
        DeleteDoor: _doors.delete_door,
        ChangeDoor: _doors.change_door,
        NameRoom: _rooms.name_room,
        NumberRoom: _rooms.number_room,
        LabelRoom: _rooms.label_room,
        SetType: _set_type,
        ScaleToLength: _scale_to_length,
        ScaleToArea: _scale_to_area,
    }
)
