"""Rooms that people name: by ids, names or labels."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

from pianta.errors import OptionError
from pianta.floor import Floor

MAX_SUGGESTED = 5


def choose_rooms(floor: Floor, words: Iterable[str]) -> set[int]:
    """The ids of the rooms that have one of these words as id, number, name or label, in any case; all with it.

    Raises OptionError, with similar words, for words that no room has.
    """
    by_word: dict[str, set[int]] = {}
    for room in floor:
        for text in filter(None, (str(room.id), room.number, room.name, room.title, room.label, *room.labels.values())):
            by_word.setdefault(text.casefold(), set()).add(room.id)
    faults, chosen = [], set()
    for word in words:
        if word.strip().casefold() in by_word:
            chosen |= by_word[word.strip().casefold()]
        else:
            similar = (
                get_close_matches(word.casefold(), [*by_word], MAX_SUGGESTED, 0.5) or sorted(by_word)[:MAX_SUGGESTED]
            )
            faults.append(f"no room has the id, name or label {word[:50]!r}, give one such as {', '.join(similar)}")
    if faults:
        raise OptionError("; ".join(faults))
    return chosen
