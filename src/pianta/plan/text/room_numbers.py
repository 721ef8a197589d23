"""Numbers of rooms: apart from their names, and misread ones corrected by the others: 25020 beside 2502A and 2502B."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

from pianta.floor import Floor, Room
from pianta.io.writers.room_texts import split_number

MIN_SIBLINGS = 2  # numbers with a letter after the same digits
# Letters that are read as digits
_MISREAD = {"0": "CDOQ", "1": "I", "4": "A", "5": "S", "6": "G", "8": "B"}
_WITH_LETTER = re.compile(r"\d{2,5}[A-Z]")
_DIGITS = re.compile(r"\d{3,6}")


def split_title(title: str | None) -> tuple[str | None, str | None]:
    """The number that begins a title, and the rest; the 2 of Bedroom 2 is a part of its name."""
    number, name = split_number(title)
    return (number, name) if number and title and title.startswith(number) else (None, title)


def split_room_numbers(floor: Floor) -> Floor:
    """The floor with the numbers that begin the names of its rooms apart from the names."""

    def split(room: Room) -> Room:
        if room.number is not None:
            return room
        number, name = split_title(room.name)
        return replace(room, number=number, name=name)

    return replace(floor, rooms=tuple(map(split, floor)))


def correct_room_numbers(floor: Floor) -> Floor:
    """The floor with the numbers in names of rooms corrected by those of the other rooms."""
    words = [(room.name or "").split() for room in floor]
    corrected = dict(zip(_list_numbers(words), correct_numbers(_list_numbers(words)), strict=True))
    rooms = (
        replace(room, name=" ".join([corrected.get(own[0], own[0]), *own[1:]])) if own else room
        for room, own in zip(floor, words, strict=True)
    )
    return replace(floor, rooms=tuple(rooms))


def _list_numbers(words: Sequence[Sequence[str]]) -> list[str]:
    return list(dict.fromkeys(own[0] for own in words if own))


def correct_numbers(numbers: Sequence[str]) -> list[str]:
    """Numbers of rooms with a digit at the end replaced where the others show that it is a letter.

    That is so if at least two others have the digits before it and a letter, and exactly one letter that looks like the
    digit is the next one after theirs, or missing among them.

    Examples
    --------
    >>> correct_numbers(["2502A", "2502B", "25020", "2504"])
    ['2502A', '2502B', '2502C', '2504']
    """
    letters: dict[str, set[str]] = defaultdict(set)
    for number in numbers:
        if _WITH_LETTER.fullmatch(number):
            letters[number[:-1]].add(number[-1])
    return [_correct(number, letters.get(number[:-1], set())) for number in numbers]


def _correct(number: str, siblings: set[str]) -> str:
    if not _DIGITS.fullmatch(number) or len(siblings) < MIN_SIBLINGS:
        return number
    expected = {chr(code) for code in range(ord("A"), ord(max(siblings)) + 2)} - siblings
    fitting = [letter for letter in _MISREAD.get(number[-1], "") if letter in expected]
    return number[:-1] + fitting[0] if len(fitting) == 1 else number
