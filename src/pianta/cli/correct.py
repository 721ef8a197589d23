"""The verb correct: mend a floor that was read, so that every later reading is mended too."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

import typer

from pianta.cli.terminal import Quiet, describe_floor, print_result
from pianta.corrections.by_id import delete_door_at, label_by_id, merge_by_id, outline_of, position_of, split_by_id
from pianta.corrections.kinds import (
    XY,
    ChangeDoor,
    Correction,
    DeleteRoom,
    DrawDoor,
    DrawRoom,
    MarkOutside,
    MoveDoor,
    NameRoom,
    NumberRoom,
    Points,
    ScaleToArea,
    ScaleToLength,
    SetType,
)
from pianta.errors import CorrectionError, OptionError
from pianta.floor import Floor
from pianta.io._files import count_noun, short_repr
from pianta.io._folders import only_writer
from pianta.reading.saved_reading import SavedReading

EXAMPLES = (
    "pianta correct building --merge 4 5 --name 4 Kitchen",
    "pianta correct building --number 4 204 --name 4 French",
    'pianta correct building --split 7 "2.5,1 2.5,4" --label 7 OFFICE',
    'pianta correct building --door "3,0 3.9,0" --delete-door 8,2.5',
    "pianta correct building --undo 1",
    "pianta correct building --list",
)
# Corrections are parsed here, in their order, which typer does not keep.
SETTINGS = {"allow_extra_args": True, "ignore_unknown_options": True}

Out = Annotated[Path, typer.Argument(metavar="OUT", help="A folder that `pianta read` has written.")]
Undo = Annotated[int, typer.Option(min=0, metavar="N", help="First take the last N corrections back.")]
List = Annotated[bool, typer.Option("--list", help="Print the corrections of the floor.")]


def correct_floor(
    context: typer.Context, out: Out, *, undo: Undo = 0, list_them: List = False, quiet: Quiet = False
) -> None:
    """Correct a floor: merge, split, draw and name rooms, mend doors.

    The corrections are written into corrections.json, and all other files are
    made again. `pianta read --previous OUT` applies them to a newer map. They
    follow OUT in the order in which they are made; points are "x,y" in metres:

    --merge ID ID …   --split ID LINE   --room OUTLINE   --delete ID

    --name ID TEXT   --number ID TEXT   --label ID LABEL

    --outside ID|OUTLINE

    --door LINE   --opening LINE   --delete-door POINT   --move-door POINT LINE

    --to-door POINT   --to-opening POINT

    --type NAME   --length LINE METRES   --area ID M²

    A LINE is "x,y x,y" from wall to wall or from jamb to jamb, an OUTLINE has
    all corners. An empty name, number or label, "", takes it away.
    """
    if str(out).startswith("--"):
        raise OptionError(f"the folder is {short_repr(out)}, give the folder first and then the corrections")
    # Another that is made at the same time waits, and then adds to these
    with only_writer(out):
        saved = SavedReading.open(out)
        if undo > len(saved.corrections):
            raise OptionError(f"--undo is {undo} and the floor has {count_noun(len(saved.corrections), 'correction')}")
        edits = [*_split_edits(context.args)]
        if not (undo or edits or list_them):
            raise OptionError("no correction is given, such as --merge 4 5; --list prints those of the floor")
        changed = saved.keep(saved.corrections[:-undo]) if undo else saved
        for edit in edits:
            changed = edit.apply(changed)
        if changed is not saved:
            changed.save()
    if quiet:
        return
    for number, outcome in enumerate(changed.outcomes if list_them else (), start=1):
        problem = f" (does not fit: {outcome.problem})" if outcome.problem else ""
        print_result(f"{number}. {outcome.correction}{problem}")
    described = describe_floor(changed.floor, changed.area_trust)
    print_result(f"{described}, {count_noun(len(changed.corrections), 'correction')}, in {out}")


@dataclass(frozen=True)
class _Edit:
    """An edit as it was typed: its flag, and the words behind it."""

    flag: str
    words: tuple[str, ...]

    def __str__(self) -> str:
        return " ".join([self.flag, *map(short_repr, self.words)])

    def apply(self, saved: SavedReading) -> SavedReading:
        """The reading with the correction; raises OptionError or CorrectionError, which name the edit."""
        form = _FORMS[self.flag]
        if len(self.words) < form.count or (len(self.words) > form.count and not form.repeats):
            raise OptionError(f"{self} does not have the form {self.flag} {form.words}")
        try:
            corrected = saved.add(form.make(saved.floor, *self.words))
        except (CorrectionError, OptionError) as error:
            raise type(error)(f"{self}: {error}") from error
        if corrected is saved:
            raise CorrectionError(f"{self} changes nothing, leave it out")
        return corrected


@dataclass(frozen=True)
class _Form:
    """What follows a flag. count: words, at least; repeats: or more."""

    words: str
    make: Callable[..., Correction]
    repeats: bool = False

    @property
    def count(self) -> int:
        return len(self.words.replace(" …", "").split())


def _split_edits(arguments: Sequence[str]) -> Iterator[_Edit]:
    """The edits of a command line, in their order."""
    edits: list[tuple[str, list[str]]] = []
    for argument in arguments:
        if argument in _FORMS:
            edits.append((argument, []))
        elif argument.startswith("--"):
            raise OptionError(f"there is no correction {short_repr(argument)}, give one of {', '.join(_FORMS)}")
        elif edits:
            edits[-1][1].append(argument)
        else:
            raise OptionError(f"{short_repr(argument)} belongs to no correction, give the folder and then --merge, …")
    for flag, words in edits:
        yield _Edit(flag, tuple(words))


def _read_id(word: str) -> int:
    try:
        return int(word)
    except ValueError:
        raise OptionError(f"{short_repr(word)} is no id, give that of a room, such as 7") from None


def _read_number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise OptionError(f"{short_repr(word)} is no number, give metres, or m² of an area") from None


def _read_points(text: str, *, least: int = 2) -> Points:
    """The points of "x,y x,y"."""
    try:
        points = tuple((float(x), float(y)) for x, y in (point.split(",") for point in text.split()))
    except ValueError:
        points = ()
    if len(points) < least:
        raise OptionError(f'{short_repr(text)} are no {least} points or more, give "x,y x,y" in metres')
    return points


def _read_point(text: str) -> XY:
    points = _read_points(text, least=1)
    if len(points) > 1:
        raise OptionError(f"{short_repr(text)} is more than one point, give x,y in metres")
    return points[0]


def _read_area(floor: Floor, text: str) -> Points:
    """The outline of a room with an id, or an outline as it is typed."""
    return outline_of(floor, _read_id(text)) if text.isdecimal() else _read_points(text, least=3)


def _read_room_area(floor: Floor, room: str, size: str) -> ScaleToArea:
    return ScaleToArea(position_of(floor, _read_id(room)), _read_number(size))


_FORMS: Mapping[str, _Form] = MappingProxyType(
    {
        "--merge": _Form("ID ID …", lambda floor, *ids: merge_by_id(floor, map(_read_id, ids)), repeats=True),
        "--split": _Form("ID LINE", lambda floor, room, line: split_by_id(floor, _read_id(room), _read_points(line))),
        "--room": _Form("OUTLINE", lambda _, outline: DrawRoom(_read_points(outline, least=3))),
        "--delete": _Form("ID", lambda floor, room: DeleteRoom(position_of(floor, _read_id(room)))),
        "--outside": _Form("ID|OUTLINE", lambda floor, area: MarkOutside(_read_area(floor, area))),
        "--name": _Form(
            "ID TEXT", lambda floor, room, name: NameRoom(position_of(floor, _read_id(room)), name or None)
        ),
        "--number": _Form(
            "ID TEXT", lambda floor, room, number: NumberRoom(position_of(floor, _read_id(room)), number or None)
        ),
        "--label": _Form("ID LABEL", lambda floor, room, label: label_by_id(floor, _read_id(room), label)),
        "--door": _Form("LINE", lambda _, line: DrawDoor(_read_points(line))),
        "--opening": _Form("LINE", lambda _, line: DrawDoor(_read_points(line), "opening")),
        "--delete-door": _Form("POINT", lambda floor, position: delete_door_at(floor, _read_point(position))),
        "--move-door": _Form(
            "POINT LINE", lambda _, position, line: MoveDoor(_read_point(position), _read_points(line))
        ),
        "--to-door": _Form("POINT", lambda _, position: ChangeDoor(_read_point(position), "door")),
        "--to-opening": _Form("POINT", lambda _, position: ChangeDoor(_read_point(position), "opening")),
        "--type": _Form("NAME", lambda _, name: SetType(name or None)),
        "--length": _Form("LINE METRES", lambda _, line, size: ScaleToLength(_read_points(line), _read_number(size))),
        "--area": _Form("ID M²", _read_room_area),
    }
)
