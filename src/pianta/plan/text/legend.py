"""The legend of a plan: which numbers or letters in rooms stand for which names."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from pianta._types import Floats
from pianta.plan.sheets.sheet import PlacedText

# Files of drawings may hold anything, so there are limits, for time
MAX_TEXT_LENGTH = 200  # characters of an entry
MAX_ENTRIES = 1000  # of a legend
MAX_RANGE = 100  # keys of an entry


@dataclass(frozen=True, kw_only=True)
class LegendParameters:
    """Thresholds of `find_legend`; heights are those of a line of text. Chosen by hand, no fit is on record."""

    left_offset: float = 1.6  # heights between the left edges of entries below each other, at most
    alike_heights: float = 1.7  # ratio of the heights of two texts of a legend, at most
    line_distance: float = 3.5  # heights from one entry to the next, at most
    word_distance: float = 5.0  # heights from a key to its name, at most
    same_line: float = 0.5  # heights between the middles of a key and its name, at most
    level_slope: float = 4.0  # width of a level text over the rise of its line, at least
    max_key_step: int = 3  # from one key to the next
    min_consecutive: float = 0.6  # share of successive entries with such a step
    min_entries: int = 2  # with a heading, or signs behind at least half of the keys
    min_bare_entries: int = 4  # else, since texts such as "1 Main office" may be names in rooms


PARAMETERS = LegendParameters()

_HEADING = re.compile(r"(?:room |raum)?(?:legend[ae]?|légende|leyenda|key|schedule|liste)\b", re.IGNORECASE)
# The text reader confuses 1 with I and l, and 0 with O
_DIGITS_OF_LETTERS = str.maketrans({"I": "1", "l": "1", "|": "1", "O": "0", "o": "0"})
_KEY = r"(?:[\dIlO|]{1,3}\d?[A-Za-z]?|[A-Z])"
_KEYS = rf"(?P<keys>{_KEY}(?:\s*(?:[&,/+]|and|bis|-|–)\s*{_KEY})*)"
_NAME = r"(?P<name>[^\W\d_][^—=]*[^\W\d_].*)"
_ENTRY = re.compile(rf"{_KEYS}\s*(?P<sign>[.):=]|\s-|[—–-])\s*{_NAME}")
_BARE_ENTRY = re.compile(rf"(?P<keys>\d{{1,3}}[A-Za-z]?)(?P<sign>\s){_NAME}")
_KEY_ALONE = re.compile(rf"{_KEYS}\s*(?P<sign>[.):=—–-]?)")


@dataclass(frozen=True)
class Legend:
    """What keys stand for.

    entries: names by keys in standard form. texts: of the legend on the sheet, with its heading.
    """

    entries: Mapping[str, str] = field(default_factory=dict)
    texts: tuple[PlacedText, ...] = ()

    def find_name(self, text: str) -> str | None:
        """The name that a text stands for as a key, None if it is no key."""
        return self.entries.get(standard_key(text))


@dataclass(frozen=True, eq=False)
class _Entry:
    """A line of a legend: its keys, its name, whether a sign stands between them, and its texts.

    left, row, height: of the first text, pixels.
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


def names_legend(text: str) -> bool:
    """Whether a text is the heading of a legend."""
    return bool(_HEADING.match(text))


def find_legend(texts: Sequence[PlacedText]) -> Legend:
    """The legend on a sheet, empty without one.

    Entries are lines of a key and a name ("1. Vestibule", "6—Office", "114 & 121—Offices", or a key beside its name)
    that stand below each other, at least two, with keys that follow each other. The first name of a key counts.
    """
    level = [text for text in texts if len(text.text) <= MAX_TEXT_LENGTH and _is_level(text)]
    headings = [text for text in level if _HEADING.match(text.text)]
    entries = _read_entries(level, headed=bool(headings))
    columns = [part for column in _group_columns(entries) for part in _split_at_gaps(column)]
    listed = [entry for column in columns if _is_legend(column, headed=bool(headings)) for entry in column]
    names: dict[str, str] = {}
    for entry in listed:
        for key in entry.keys:
            names.setdefault(key, entry.name)
    used = (*(text for entry in listed for text in entry.texts), *(headings if listed else ()))
    return Legend(names, tuple(dict.fromkeys(used)))


def _is_level(text: PlacedText) -> bool:
    """Whether a text runs from left to right, nearly horizontally."""
    down, right = text.corners[1] - text.corners[0]
    return bool(right > PARAMETERS.level_slope * abs(down))


def _read_entries(texts: Sequence[PlacedText], *, headed: bool) -> list[_Entry]:
    """Texts that may be lines of a legend, and pairs of a key and the name beside it; MAX_ENTRIES at most.

    headed: whether the sheet has a heading; else a key needs a sign, as in "6.", to be paired with a name.
    """
    entries: list[_Entry] = []
    lines = _Lines.from_texts(texts)
    for text in texts:
        match = _ENTRY.fullmatch(text.text) or _BARE_ENTRY.fullmatch(text.text)
        used: tuple[PlacedText, ...] = (text,)
        if match:
            name = match["name"]
        else:
            match = _KEY_ALONE.fullmatch(text.text)
            beside = lines.name_beside(text) if match and (match["sign"] or headed) else None
            if match is None or beside is None:
                continue
            name, used = beside.text, (text, beside)
        keys = _unfold_keys(match["keys"])
        if keys:
            name, signed = " ".join(name.split()).rstrip(" ,;"), bool(match["sign"].strip())
            left, row = float(text.corners[0][1]), float(text.middle[0])
            entries.append(_Entry(keys, name, signed, used, left, row, text.height))
        if len(entries) == MAX_ENTRIES:
            break
    return entries


@dataclass(frozen=True, eq=False)
class _Lines:
    """Texts from top to bottom; rows, lefts, heights: shape (N,), of their middles, left edges and lines, pixels."""

    texts: Sequence[PlacedText]
    rows: Floats
    lefts: Floats
    heights: Floats

    @classmethod
    def from_texts(cls, texts: Sequence[PlacedText]) -> _Lines:
        """The texts of a sheet."""
        ordered = sorted(texts, key=lambda text: float(text.middle[0]))
        lines = np.array([(text.middle[0], text.corners[0][1], text.height) for text in ordered]).reshape(-1, 3)
        return cls(ordered, *lines.T)

    def name_beside(self, text: PlacedText) -> PlacedText | None:
        """The next text on the right on the same line, of the same height, unless it is no name or has a key."""
        height, middle, reach = text.height, float(text.middle[0]), PARAMETERS.same_line * text.height
        first, last = np.searchsorted(self.rows, (middle - reach, np.nextafter(middle + reach, np.inf)))
        lefts, heights = self.lefts[first:last], self.heights[first:last]
        gaps = lefts - (text.corners[1][1] - 0.5 * height)
        alike = np.maximum(heights, height) <= PARAMETERS.alike_heights * np.minimum(heights, height)
        # A text that is narrower than half its height would be beside itself
        beyond = (gaps >= 0) & (lefts > text.corners[0][1])
        near = np.flatnonzero(beyond & (gaps <= PARAMETERS.word_distance * height) & alike)
        if not len(near):
            return None
        beside = self.texts[first + near[lefts[near].argmin()]]
        is_name = re.match(r"[^\W\d_].*[^\W\d_]", beside.text) and not _ENTRY.fullmatch(beside.text)
        return beside if is_name else None


def _unfold_keys(text: str) -> tuple[str, ...]:
    """The keys that an entry names: 114 and 121 of "114 & 121", 1 to 4 of "1-4"; empty for other texts."""
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
    """A key in standard form, with digits for letters that the text reader confuses with them."""
    digits = text.translate(_DIGITS_OF_LETTERS)
    return standard_key(digits if digits.isdigit() and text not in ("I", "O", "l", "o") else text)


def _group_columns(entries: Sequence[_Entry]) -> list[list[_Entry]]:
    """Entries in columns, each from top to bottom: the texts of a column have the same left edge and height, nearly."""
    columns: list[list[_Entry]] = []
    for entry in sorted(entries, key=lambda entry: (entry.row, entry.left)):
        for column in columns:
            last = column[-1]
            height = min(last.height, entry.height)
            alike = max(last.height, entry.height) <= PARAMETERS.alike_heights * height
            if alike and abs(last.left - entry.left) <= PARAMETERS.left_offset * height:
                column.append(entry)
                break
        else:
            columns.append([entry])
    return columns


def _split_at_gaps(column: Sequence[_Entry]) -> list[list[_Entry]]:
    """A column split where an entry is too far below the one before."""
    parts = [[column[0]]]
    for above, below in pairwise(column):
        if below.row - above.row <= PARAMETERS.line_distance * above.height:
            parts[-1].append(below)
        else:
            parts.append([below])
    return parts


def _is_legend(column: Sequence[_Entry], *, headed: bool) -> bool:
    """Whether a column of entries is a legend, rather than names of rooms that happen to be below each other.

    It must have enough entries, and most keys must follow the key above them by a small step. headed: whether the sheet
    has a heading such as "Legend"; then two entries are enough, and a column of two may have keys in any order.
    """
    p, signed = PARAMETERS, sum(entry.signed for entry in column)
    least = p.min_entries if headed or 2 * signed >= len(column) else p.min_bare_entries
    if len(column) < least:
        return False
    steps = [_key_step(above, below) for above, below in pairwise(column)]
    share = float(np.mean([0 < step <= p.max_key_step for step in steps]))
    return share >= p.min_consecutive or (headed and len(steps) == 1)


def _key_step(above: _Entry, below: _Entry) -> int:
    """By how much the key of an entry follows that of the entry above it; 0 if unknown."""
    last, first = above.keys[-1], below.keys[0]
    if last.isdigit() and first.isdigit():
        return int(first) - int(last)
    return ord(first) - ord(last) if len(first) == len(last) == 1 else 0
