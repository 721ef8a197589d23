"""Titles of storeys on sheets, such as Ground floor or 2. OG, and how high each is above the others."""

from __future__ import annotations

import re
from collections.abc import Sequence

from pianta.plan.sheets.sheet import PlacedText

MAX_LETTERS = 60  # of a title

# English, German, Italian, French and Spanish. Levels only order storeys: 1 is one above the ground.
_LEVELS: tuple[tuple[int, str], ...] = (
    (-1, r"basement|cellar|lower (?:level|ground)|(?:unter|keller)geschoss|\bug\b|piano (?:inter|semi\w+)rato|cantina"),
    (-1, r"sous-?\s?sol|s[óo]tano"),
    (0, r"ground floor|main (?:floor|level)|street level|erdgeschoss|\beg\b|piano terra|pianoterra"),
    (0, r"rez[- ]de[- ]chauss[ée]e|\brdc\b|planta baja"),
    (1, r"first floor|upper (?:floor|level)|primo piano|piano primo|premier [ée]tage|primera planta|planta alta"),
    (2, r"second floor|secondo piano|piano secondo|deuxi[èe]me [ée]tage|segunda planta"),
    (3, r"third floor|terzo piano|piano terzo|troisi[èe]me [ée]tage|tercera planta"),
    (99, r"attic|loft|dachgeschoss|\bdg\b|mansarda|sottotetto|combles|[áa]tico"),
)
_NUMBERED = re.compile(
    r"\b(?:(?P<before>\d{1,2})\s?(?:st|nd|rd|th|er|e|[èe]me|[°ºª.])?\s?"
    r"(?:floor|level|storey|story|obergeschoss|og|stock|piano|[ée]tage|planta)\b"
    r"|(?:floor|level|storey|story|obergeschoss|og|piano|[ée]tage|planta)\s?(?P<after>\d{1,2})\b)",
    re.IGNORECASE,
)
_NAMED = tuple((level, re.compile(pattern, re.IGNORECASE)) for level, pattern in _LEVELS)


def find_storey_title(texts: Sequence[PlacedText]) -> tuple[str, int] | None:
    """The title of the storey on a sheet, and its level; None without one, or if texts of one size name several.

    The largest text that names a storey is the title.
    """
    named = [(text, level) for text in texts if (level := parse_level(text.text)) is not None]
    if not named:
        return None
    tallest = max(text.height for text, _ in named)
    titles = [(text, level) for text, level in named if text.height >= 0.95 * tallest]
    if len({level for _, level in titles}) > 1:
        return None
    return " ".join(titles[0][0].text.split()), titles[0][1]


def parse_level(text: str) -> int | None:
    """The level that a short text names: 0 for the ground, negative below; None without one.

    Examples
    --------
    >>> [parse_level(text) for text in ("Ground Floor Plan", "2. OG", "Piano 3", "Floor area 12 m2", "Kitchen")]
    [0, 2, 3, None, None]
    """
    if len(text) > MAX_LETTERS or re.search(r"\barea\b|\d\s?(?:m2|m²|sq|sf)\b", text, re.IGNORECASE):
        return None
    match = _NUMBERED.search(text)
    if match is not None:
        return int(match["before"] or match["after"])
    return next((level for level, pattern in _NAMED if pattern.search(text)), None)
