"""The exits of a floor: entrances, or rooms that lead out of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from pianta.errors import OptionError
from pianta.floor import OUTSIDE_FLAG, Floor
from pianta.labels import normalize_label

# Labels of the thesis of rooms that lead off a floor; a lift must not be used in a fire.
EXIT_LABELS = ("ENTRANCE", "STAIRS")
MAX_LISTED = 5  # ids of a message


@dataclass(frozen=True)
class Exits:
    """Where people are out: behind entrances, or in exit rooms.

    rooms: ids of exit rooms. doors: indices of entrances.
    """

    rooms: frozenset[int]
    doors: frozenset[int]


def find_exits(floor: Floor, rooms: Sequence[int] | None = None) -> Exits:
    """The given exit rooms; else the entrances and rooms outside; else the rooms labelled ENTRANCE or STAIRS.

    Raises OptionError for a room that does not exist, and for a floor without any exit.
    """
    if rooms is not None and len(rooms):
        check_rooms(floor, rooms, "exits=")
        return Exits(frozenset(rooms), frozenset())
    entrances = frozenset(index for index, door in enumerate(floor.doors) if door.is_entrance)
    outside = frozenset(room.id for room in floor.rooms if room.flag == OUTSIDE_FLAG)
    if entrances or outside:
        return Exits(outside, entrances)
    labelled = frozenset(room.id for room in floor.rooms if normalize_label(room.label) in EXIT_LABELS)
    if not labelled:
        labels = " or ".join(EXIT_LABELS)
        raise OptionError(f"no exit is known: the floor has no entrance and no room labelled {labels}, give exits=")
    return Exits(labelled, frozenset())


def find_shut_doors(floor: Floor, shut: Iterable[int | tuple[int, int | None]]) -> frozenset[int]:
    """Indices of doors by their numbers, which count from 1, or by the two rooms that they join.

    Raises OptionError for a door that does not exist.
    """
    doors: set[int] = set()
    for name in shut:
        if isinstance(name, int):
            matching = {name - 1} & {*range(len(floor.doors))}
            remedy = f"give a number from 1 to {len(floor.doors)}, or two rooms"
        else:
            pair = frozenset(name)
            matching = {index for index, door in enumerate(floor.doors) if frozenset(door.rooms) == pair}
            remedy = "give two rooms that a door joins, or the number of a door"
        if not matching:
            raise OptionError(f"shut= has the door {_describe_door(name)}, which does not exist, {remedy}")
        doors |= matching
    return frozenset(doors)


def _describe_door(name: int | tuple[int, int | None]) -> str:
    return str(name) if isinstance(name, int) else "-".join("out" if end is None else str(end) for end in name)


def check_rooms(floor: Floor, rooms: Iterable[int], argument: str) -> None:
    """Raise OptionError for ids that no room has; argument: their name, such as "exits="."""
    unknown = sorted({*rooms} - {room.id for room in floor.rooms})
    if unknown:
        listed = ", ".join(map(str, unknown[:MAX_LISTED])) + (", …" if len(unknown) > MAX_LISTED else "")
        raise OptionError(f"{argument} has the rooms {listed}, which the floor does not have, give ids of its rooms")
