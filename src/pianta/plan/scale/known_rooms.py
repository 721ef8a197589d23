"""Usual areas of rooms by the names that are written in them, of homes and of other buildings."""

from __future__ import annotations

import json
import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

# Names in English, Italian, German, French, Spanish, Portuguese and some others. The median of bedrooms is measured:
# it alone gives the scale of 16 named house plans within a factor of 1.27 (shared/reference/plans-review.md). The
# others are what norms and guides ask for (Neufert; the English space standard of 2015; Building Bulletin 103 for
# schools), and their spreads are estimates, wide on purpose. The layouts in shared/data/buildings are no source: by
# the widths of doors in them an office has 48 m².
KNOWN_ROOMS = Path(__file__).with_name("known_rooms.json")
MAX_TEXT_LENGTH = 100  # characters of a text that may be a name
SHORTEST_WORD = 4  # letters of a name that may stand among other words; shorter ones must stand alone
SHORTEST_EAST_ASIAN_WORD = 2


@dataclass(frozen=True)
class KnownRoom:
    """A kind of room: its median area, m², and the standard deviation of the area's logarithm.

    in_home: whether it is of a home; None if its name occurs in homes and elsewhere. Its area is then that in homes.
    """

    kind: str
    area: float
    log_sd: float
    in_home: bool | None


def find_known_rooms(text: str) -> tuple[KnownRoom, ...]:
    """The kinds of room that a text names, such as two for Living/Dining; none if it names something else.

    Case, accents, numbers and signs do not matter.
    """
    if len(text) > MAX_TEXT_LENGTH:
        return ()
    parts = [part for part in map(fold_name, re.split(r"[/&+,()]", text)) if part]
    rooms = (room for part in parts if (room := _find_in_part(part)))
    return tuple(dict.fromkeys(rooms))


def fold_name(text: str) -> str:
    """A name in small letters without accents, numbers and signs, its words separated by single blanks."""
    plain = unicodedata.normalize("NFKD", unicodedata.normalize("NFKC", text).casefold())
    # Marks of Japanese syllables lie outside of these: they make other letters
    letters = "".join(sign for sign in plain if not "\u0300" <= sign <= "\u036f")
    return " ".join(re.findall(r"[^\W\d_]+", unicodedata.normalize("NFC", letters)))


@cache
def _read_names() -> Mapping[str, KnownRoom]:
    rooms = json.loads(KNOWN_ROOMS.read_text(encoding="utf-8"))
    return {
        fold_name(word): KnownRoom(room["kind"], room["area"], room["log_sd"], room["in_home"])
        for room in rooms
        for word in room["words"]
    }


def _find_in_part(part: str) -> KnownRoom | None:
    """The room that a folded text names as a whole, or by the longest name among its words."""
    names, words = _read_names(), part.split()
    if part in names:
        return names[part]
    for length in range(len(words) - 1, 0, -1):
        for start in range(len(words) - length + 1):
            run = " ".join(words[start : start + length])
            if run in names and len(run) >= (SHORTEST_WORD if run.isascii() else SHORTEST_EAST_ASIAN_WORD):
                return names[run]
    return None
