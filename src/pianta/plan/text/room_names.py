"""Names of rooms: the texts in each room put together, and its number looked up in the legend."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.floor import MAX_ROOM_NAME_LENGTH, Floor
from pianta.gridmap import GridMap
from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.text.dimensions import parse_length, parse_size, remove_measures
from pianta.plan.text.legend import Legend

# Files of drawings may hold anything, so there are limits, for time
MAX_TEXTS = 60  # of a room, the highest ones
MAX_CHARACTERS = 200  # of a text


@dataclass(frozen=True, kw_only=True)
class RoomNameParameters:
    """Thresholds of `compose_room_name`; heights are those of a line of text. Chosen by hand, no fit is on record."""

    line_distance: float = 1.9  # heights from one line of a name to the next, at most
    word_distance: float = 2.0  # heights between two words on a line, at most
    code_distance: float = 0.7  # the same if one is a code such as TM, which plans write on furniture
    same_line: float = 0.6  # heights between middles, from which on two texts are on different lines
    line_indent: float = 0.5  # heights of blank between texts on different lines, along them, at most
    join_line: float = 0.5  # heights between the middles of two texts of a line when they are joined
    same_direction: float = 0.35  # rad between the directions of the texts of a name, at most
    alike_heights: float = 2.0  # ratio of their heights, at most
    enough_letters: int = 12  # more letters do not make a text more likely the name


PARAMETERS = RoomNameParameters()

# What plans write at a spot in a room, not about the room; and chairs, tables and crosses that were read as letters
_REMARKS = frozenset({"up", "dn", "down", "su", "giu", "auf", "ab", "oh", "ref", "dw", "w", "d", "wh", "fe", "exit"})
# A text without a word that has these is a size or a strength which was misread
_MISREAD_MEASURE = re.compile(r"\d\s*['\"°“”„*~=]|\d\W*[x×*]\W*\d|\d\w*#|=\s*\d", re.IGNORECASE)
# What may stand before the name of a room: 12, B-12, 2.04a
_ROOM_NUMBER = re.compile(r"[^\W\d_]{0,3}[-. ]?\d[\d./-]*[^\W\d_]?\.?")
_FURNITURE_CODE = re.compile(r"[A-Z]{1,2}(/[A-Z]{1,2})?")
_CIRCLES = re.compile(r"[0Oo\s]+|[xX]")


def name_rooms(floor: Floor, texts: Sequence[PlacedText], grid: GridMap, legend: Legend | None = None) -> Floor:
    """The floor with a name for each room in which texts stand; other rooms keep theirs.

    texts: corners in pixels of the grid. legend: its texts name no rooms themselves, its keys do.
    Lines of a name are joined in the direction in which they are read. Lengths, areas and remarks on stairs are left
    out. A room's number stays before its name, unless it is a key of the legend.
    """
    legend = legend or Legend()
    in_legend = set(map(id, legend.texts))
    words = [word for text in texts if id(text) not in in_legend for word in _split_at_rooms(text, floor, grid)]
    room_texts: dict[int, list[PlacedText]] = {}
    for text, index in zip(words, _find_rooms([word.middle for word in words], floor, grid), strict=True):
        if index >= 0:
            room_texts.setdefault(int(index), []).append(text)
    names = {index: name for index, inside in room_texts.items() if (name := compose_room_name(inside, legend))}
    rooms = (replace(room, name=names.get(index, room.name)) for index, room in enumerate(floor.rooms))
    return replace(floor, rooms=tuple(rooms))


def compose_room_name(texts: Sequence[PlacedText], legend: Legend | None = None) -> str | None:
    """The name of a room by the texts in it, None if they name nothing.

    Of texts apart from each other, numbers come first, then the largest and longest of the others; codes such as TM
    name a room only if nothing else does.
    """
    legend = legend or Legend()
    highest = sorted(texts, key=lambda text: (-text.height, *text.middle, text.text))[:MAX_TEXTS]
    candidates = sorted(_without_measures(highest), key=lambda text: (*text.middle, text.text))
    keys = [text for text in candidates if legend.find_name(text.text)]
    groups = [_join_lines(group) for group in _group_lines([text for text in candidates if text not in keys])]
    codes = [text for text, _ in groups if not _has_word(text)]
    numbers = [*(text.text for text in keys), *(text for text in codes if _ROOM_NUMBER.fullmatch(text))]
    own = max(((weight, text) for text, weight in groups if _has_word(text)), default=None)
    by_legend = [name for text in keys if (name := legend.find_name(text.text))]
    parts = [*numbers[:1], own[1]] if own else list(dict.fromkeys(by_legend)) or (numbers or codes)[:1]
    name = "".join(sign if sign.isprintable() else " " for sign in " ".join(parts))
    return " ".join(name.split())[:MAX_ROOM_NAME_LENGTH].strip() or None


def _find_rooms(points: Sequence[Floats], floor: Floor, grid: GridMap) -> NDArray[np.int64]:
    """The index of the room of each point, row and col; -1 for none."""
    indices = np.full(len(points), -1)
    if not (len(points) and floor.rooms):
        return indices
    rows, cols = np.array(points).T
    tree = shapely.STRtree(shapely.points(*grid.pixel_to_map(rows, cols)))
    rooms, inside = tree.query([room.polygon for room in floor.rooms], predicate="intersects")
    indices[inside] = rooms
    return indices


def _split_at_rooms(text: PlacedText, floor: Floor, grid: GridMap) -> Iterator[PlacedText]:
    """The text, or its words if they stand in different rooms: the text reader joins neighbours to one line."""
    words = text.text.split()
    if len(words) < 2 or len(text.text) > MAX_CHARACTERS:
        yield text
        return
    upper_left, upper_right, lower_right, lower_left = text.corners
    upper, lower = upper_right - upper_left, lower_right - lower_left
    placed, start = [], 0
    for word in words:
        start = text.text.index(word, start)
        first, last = start / len(text.text), (start + len(word)) / len(text.text)
        top = [upper_left + first * upper, upper_left + last * upper]
        bottom = [lower_left + last * lower, lower_left + first * lower]
        placed.append(PlacedText(word, np.array(top + bottom), text.confidence))
        start += len(word)
    rooms = _find_rooms([word.middle for word in placed], floor, grid)
    inside = {int(room) for room in rooms if room >= 0}
    yield from placed if len(inside) > 1 else [text]


def _without_measures(texts: Sequence[PlacedText]) -> list[PlacedText]:
    """The texts without their lengths, sizes and areas, and without remarks."""
    rests = [replace(text, text=remove_measures(text.text[:MAX_CHARACTERS])) for text in texts]
    return [
        text
        for text in rests
        if any(map(str.isalnum, text.text))
        and not _CIRCLES.fullmatch(text.text)
        and (_has_word(text.text) or not _MISREAD_MEASURE.search(text.text))
        and parse_length(text.text) is None
        and parse_size(text.text) is None
        and text.text.strip(" .").lower() not in _REMARKS
    ]


def _has_word(text: str) -> bool:
    """Whether a text is more than a number such as 12, B or B-12."""
    letters = [len(word) for word in re.findall(r"[^\W\d_]+", text)]
    digits = any(map(str.isdigit, text))
    return max(letters, default=0) >= (3 if digits else 2)


def _frame(text: PlacedText) -> tuple[Floats, Floats]:
    """Unit vectors, row and col, of the way in which a text is read and of the way down to its next line."""
    along, down = text.corners[1] - text.corners[0], text.corners[3] - text.corners[0]
    return along / max(float(np.hypot(*along)), 1e-9), down / max(float(np.hypot(*down)), 1e-9)


def _belong(one: PlacedText, other: PlacedText) -> bool:
    """Whether two texts are lines below each other, or words on a line."""
    p = PARAMETERS
    along, down = _frame(one)
    if float(along @ _frame(other)[0]) < np.cos(p.same_direction):
        return False
    height = max(one.height, other.height)
    if height > p.alike_heights * min(one.height, other.height):
        return False
    offset = other.middle - one.middle
    widths = [float(np.hypot(*(text.corners[1] - text.corners[0]))) for text in (one, other)]
    gap = abs(float(offset @ along)) - sum(widths) / 2
    lines = abs(float(offset @ down)) / height
    word_gap = (
        p.code_distance if any(_FURNITURE_CODE.fullmatch(text.text) for text in (one, other)) else p.word_distance
    )
    longest_gap = p.line_indent if lines > p.same_line else word_gap
    return lines <= p.line_distance and gap <= longest_gap * height


def _group_lines(texts: Sequence[PlacedText]) -> list[list[PlacedText]]:
    """Texts that belong to each other, directly or through others."""
    groups: list[list[PlacedText]] = []
    for text in texts:
        near = [group for group in groups if any(_belong(text, other) for other in group)]
        groups = [group for group in groups if not any(group is one for one in near)]
        groups.append([*(other for group in near for other in group), text])
    return groups


def _join_lines(texts: Sequence[PlacedText]) -> tuple[str, float]:
    """Lines in reading order as one text, and its weight as the name of the room."""
    along, down = _frame(texts[0])
    height = max(text.height for text in texts)
    lines: list[list[PlacedText]] = []
    for text in sorted(texts, key=lambda text: float(text.middle @ down)):
        if lines and float((text.middle - lines[-1][0].middle) @ down) <= PARAMETERS.join_line * height:
            lines[-1].append(text)
        else:
            lines.append([text])
    joined = ""
    for line in lines:
        words = " ".join(text.text for text in sorted(line, key=lambda text: float(text.middle @ along)))
        # A word that is hyphenated at the end of its line goes on in small letters
        cut = joined.endswith("-") and joined[-2:-1].isalpha() and words[:1].islower()
        joined = joined[:-1] + words if cut else f"{joined} {words}".strip()
    letters = min(sum(map(str.isalpha, joined)), PARAMETERS.enough_letters)
    return joined, letters * height * float(np.mean([text.confidence for text in texts]))
