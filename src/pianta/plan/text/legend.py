"""The legend of a plan: which numbers or letters in rooms stand for which names."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from pianta._types import Floats
from pianta.plan.sheets.sheet import PlacedText

# Left edges of entries below each other differ by less than this many heights of a line, and their heights by less
# than this factor; lines follow each other within this many heights, and a name follows its key within so many.
ALIGNED, ALIKE, NEXT_LINE, NEXT_WORD = 1.6, 1.7, 3.5, 5.0
# Successive keys differ by this much at most, in at least this share of the pairs.
NEXT_KEY, CONSECUTIVE = 3, 0.6
# Entries without a sign behind the key, such as "1 Main office", look like names in rooms: it takes more of them.
LEAST_ENTRIES, LEAST_BARE_ENTRIES = 2, 4
MAX_RANGE = 100
# Files of drawings may hold anything: longer texts are no entries, and no legend has more.
MAX_TEXT_LENGTH, MAX_ENTRIES = 200, 1000

_HEADING = re.compile(r"(?:room |raum)?(?:legend[ae]?|légende|leyenda|key|schedule|liste)\b", re.IGNORECASE)
# OCR takes a 1 for I or l, and a 0 for O.
_LOOK_ALIKE = str.maketrans({"I": "1", "l": "1", "|": "1", "O": "0", "o": "0"})
_KEY = r"(?:[\dIlO|]{1,3}\d?[A-Za-z]?|[A-Z])"
_KEYS = rf"(?P<keys>{_KEY}(?:\s*(?:[&,/+]|and|bis|-|–)\s*{_KEY})*)"
_NAME = r"(?P<name>[^\W\d_][^—=]*[^\W\d_].*)"
_ENTRY = re.compile(rf"{_KEYS}\s*(?P<sign>[.):=]|\s-|[—–-])\s*{_NAME}")
_BARE_ENTRY = re.compile(rf"(?P<keys>\d{{1,3}}[A-Za-z]?)(?P<sign>\s){_NAME}")
_KEY_ALONE = re.compile(rf"{_KEYS}\s*(?P<sign>[.):=—–-]?)")


@dataclass(frozen=True)
class Legend:
    """What keys stand for.

    entries: names by keys in standard form. texts: those on the sheet that make the legend, its heading too.
    """

    entries: Mapping[str, str] = field(default_factory=dict)
    texts: tuple[PlacedText, ...] = ()

    def find_name(self, text: str) -> str | None:
        """The name that a text stands for when it is a key, None when it is none."""
        return self.entries.get(standard_key(text))


@dataclass(frozen=True, eq=False)
class _Entry:
    """A line of a legend: its keys, its name, whether a sign stands between, and the texts that it was read from.

    left, row, height: of the first of these, pixels.
    """

    keys: tuple[str, ...]
    name: str
    signed: bool
    texts: tuple[PlacedText, ...]
    left: float
    row: float
    height: float


def standard_key(text: str) -> str:
    """A key in capitals, without signs around it and zeros before it."""
    key = text.strip(" .):(=—–-#").upper()
    return key.lstrip("0") or key


def find_legend(texts: Sequence[PlacedText]) -> Legend:
    """The legend on a sheet, empty where there is none.

    Entries are lines of a key and a name ("1. Vestibule", "6—Office", "114 & 121—Offices", a key and its name apart)
    that stand below each other, two at least, with keys that follow each other. The first name of a key counts.
    """
    level = [text for text in texts if len(text.text) <= MAX_TEXT_LENGTH and _is_level(text)]
    headings = [text for text in level if _HEADING.match(text.text)]
    entries = _read_entries(level, headed=bool(headings))
    columns = [part for column in _align(entries) for part in _cut(column)]
    listed = [entry for column in columns if _is_list(column, headed=bool(headings)) for entry in column]
    names: dict[str, str] = {}
    for entry in listed:
        for key in entry.keys:
            names.setdefault(key, entry.name)
    used = (*(text for entry in listed for text in entry.texts), *(headings if listed else ()))
    return Legend(names, tuple(dict.fromkeys(used)))


def _is_level(text: PlacedText) -> bool:
    down, right = text.corners[1] - text.corners[0]
    return bool(right > 4 * abs(down))


def _read_entries(texts: Sequence[PlacedText], *, headed: bool) -> list[_Entry]:
    """The first texts that may be lines of a legend, and pairs of texts where key and name stand apart."""
    entries: list[_Entry] = []
    lines = _Lines.of(texts)
    for text in texts:
        found = _ENTRY.fullmatch(text.text) or _BARE_ENTRY.fullmatch(text.text)
        used: tuple[PlacedText, ...] = (text,)
        if found:
            name = found["name"]
        else:
            found = _KEY_ALONE.fullmatch(text.text)
            beside = lines.name_beside(text) if found and (found["sign"] or headed) else None
            if found is None or beside is None:
                continue
            name, used = beside.text, (text, beside)
        keys = _unfold_keys(found["keys"])
        if keys:
            place = float(text.corners[0][1]), float(text.middle[0]), text.height
            entries.append(
                _Entry(keys, " ".join(name.split()).rstrip(" ,;"), bool(found["sign"].strip()), used, *place)
            )
        if len(entries) == MAX_ENTRIES:
            break
    return entries


@dataclass(frozen=True, eq=False)
class _Lines:
    """Texts from top to bottom; rows, lefts, heights: shape (N,), where they lie, pixels."""

    texts: Sequence[PlacedText]
    rows: Floats
    lefts: Floats
    heights: Floats

    @classmethod
    def of(cls, texts: Sequence[PlacedText]) -> _Lines:
        """Those of a sheet."""
        ordered = sorted(texts, key=lambda text: float(text.middle[0]))
        places = np.array([(text.middle[0], text.corners[0][1], text.height) for text in ordered]).reshape(-1, 3)
        return cls(ordered, *places.T)

    def name_beside(self, text: PlacedText) -> PlacedText | None:
        """Of texts on its line the next one on the right, of the same height, unless it is no name or has a key."""
        height, middle = text.height, float(text.middle[0])
        first, last = np.searchsorted(self.rows, (middle - 0.5 * height, np.nextafter(middle + 0.5 * height, np.inf)))
        lefts, heights = self.lefts[first:last], self.heights[first:last]
        gaps = lefts - (text.corners[1][1] - 0.5 * height)
        alike = np.maximum(heights, height) <= ALIKE * np.minimum(heights, height)
        # A text narrower than half its height ends so near to its left edge that it would be beside itself.
        beyond = (gaps >= 0) & (lefts > text.corners[0][1])
        near = np.flatnonzero(beyond & (gaps <= NEXT_WORD * height) & alike)
        if not len(near):
            return None
        beside = self.texts[first + near[lefts[near].argmin()]]
        is_name = re.match(r"[^\W\d_].*[^\W\d_]", beside.text) and not _ENTRY.fullmatch(beside.text)
        return beside if is_name else None


def _unfold_keys(text: str) -> tuple[str, ...]:
    """The keys that an entry names: 114 and 121 of "114 & 121", 1 to 4 of "1-4"; none for what cannot be unfolded."""
    parts = re.split(r"\s*(&|,|/|\+|and|bis|-|–)\s*", text)
    keys = [_read_key(part) for part in parts[::2]]
    unfolded = keys[:1]
    for sign, key in zip(parts[1::2], keys[1:], strict=True):
        if sign in ("-", "–", "bis"):
            start = unfolded[-1]
            if not (start.isdigit() and key.isdigit() and 0 < int(key) - int(start) <= MAX_RANGE):
                return ()
            unfolded += map(str, range(int(start) + 1, int(key) + 1))
        else:
            unfolded.append(key)
        if len(unfolded) > MAX_RANGE:
            return ()
    return tuple(unfolded)


def _read_key(text: str) -> str:
    """A key in standard form, with digits where letters were read for them."""
    digits = text.translate(_LOOK_ALIKE)
    return standard_key(digits if digits.isdigit() and text not in ("I", "O", "l", "o") else text)


def _align(entries: Sequence[_Entry]) -> list[list[_Entry]]:
    """Entries that begin below each other, each column from top to bottom."""
    columns: list[list[_Entry]] = []
    for entry in sorted(entries, key=lambda entry: (entry.row, entry.left)):
        for column in columns:
            last = column[-1]
            height = min(last.height, entry.height)
            alike = max(last.height, entry.height) <= ALIKE * height
            if alike and abs(last.left - entry.left) <= ALIGNED * height:
                column.append(entry)
                break
        else:
            columns.append([entry])
    return columns


def _cut(column: Sequence[_Entry]) -> list[list[_Entry]]:
    """A column cut where a line is too far below the one before."""
    parts = [[column[0]]]
    for above, below in pairwise(column):
        if below.row - above.row <= NEXT_LINE * above.height:
            parts[-1].append(below)
        else:
            parts.append([below])
    return parts


def _is_list(column: Sequence[_Entry], *, headed: bool) -> bool:
    """Whether entries below each other are a legend, and not rooms in a row."""
    signed = sum(entry.signed for entry in column)
    least = LEAST_ENTRIES if headed or 2 * signed >= len(column) else LEAST_BARE_ENTRIES
    if len(column) < least:
        return False
    steps = [_step_between(above, below) for above, below in pairwise(column)]
    return float(np.mean([0 < step <= NEXT_KEY for step in steps])) >= CONSECUTIVE or (headed and len(steps) == 1)


def _step_between(above: _Entry, below: _Entry) -> int:
    """By how much the key of an entry follows that of the entry above it; 0 where that cannot be said."""
    last, first = above.keys[-1], below.keys[0]
    if last.isdigit() and first.isdigit():
        return int(first) - int(last)
    return ord(first) - ord(last) if len(first) == len(last) == 1 else 0
