"""Stamps of rooms: which attribute of a block is the number, the name and the area of the room."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable
from typing import Literal

Meaning = Literal["number", "name", "area"]

MAX_ATTRIBUTES = 50  # of a block
MAX_LETTERS = 200  # of a tag or a value

# Parts of tags without accents, in English, German, Italian, French and Spanish; the first that fits decides.
_TAGS: tuple[tuple[Meaning | None, re.Pattern[str]], ...] = (
    # What stamps say besides: storeys, buildings, departments, floor coverings, sizes, lengths, dates, identifiers.
    (
        None,
        re.compile(
            r"storey|story|geschoss|etage|floor|piano|planta|level|ebene|gebaude|building|belag|finish|ceiling|decke"
            r"|height|hohe|hoehe|altezza|hauteur|altura|umfang|perim|volum|datum|date|guid|^id$|uuid|handle|scale"
            r"|person|label|occup|depart|abteil|kosten|cost|wand|boden|tur$|tuer$|door"
        ),
    ),
    ("area", re.compile(r"area|flache|flaeche|superfic|surface|sqm|sqft|^m2$|^qm$|^mq$|^sf$|^n[gu]?f$|^nrf$|^sup$")),
    ("name", re.compile(
        r"nam|bezeich|nutzung|descr|denomin|destinaz|nom$|nombre|nomb|^use$|usage|titel|title|funktion|function|uso$"
    )),
    ("number", re.compile(
        r"num|nr|no$|^n$|numero|codice|code|kennung|^nb$|schluss|rm$|^raum$|^room$|^local$|^locale$|^vano$|id$"
    )),
)  # fmt: skip
_AREA = re.compile(r"(?:[^\d]*)[\d., ]+\s*(?:m2|m²|qm|mq|sqm|sq\.?\s?m|sf|sq\.?\s?ft|ft2|ft²)\.?", re.IGNORECASE)
_NUMBER = re.compile(r"(?=.*\d)[\w.\-/ ]{1,12}")


def read_stamp(attributes: Iterable[tuple[str, str]]) -> dict[Meaning, str]:
    """What the attributes of a block, tags and values, say about a room; empty if they are no stamp.

    The tag decides; for a tag without a known word the value does: an area has a unit, a number has a digit.
    """
    values: dict[Meaning, str] = {}
    unknown: list[str] = []
    for tag, text in list(attributes)[:MAX_ATTRIBUTES]:
        value = " ".join(text[:MAX_LETTERS].split())
        if not any(map(str.isalnum, value)):
            continue
        meaning = _meaning_of(tag)
        if meaning == "unknown":
            unknown.append(value)
        elif meaning is not None:
            values.setdefault(meaning, value)
    for value in unknown:
        if _AREA.fullmatch(value):
            values.setdefault("area", value)
        elif _NUMBER.fullmatch(value):
            values.setdefault("number", value)
        else:
            values.setdefault("name", value)
    return values


def _meaning_of(tag: str) -> Meaning | Literal["unknown"] | None:
    """What a tag stands for; None for what is not about a room."""
    composed = unicodedata.normalize("NFD", tag[:MAX_LETTERS].lower())
    letters = "".join(letter for letter in composed if letter.isascii() and letter.isalnum())
    return next((meaning for meaning, pattern in _TAGS if pattern.search(letters)), "unknown")
