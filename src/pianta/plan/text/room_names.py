"""Names of rooms: the texts in each room put together, and its number looked up in the legend."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
import shapely
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.floor import MAX_ROOM_NAME_LENGTH, Floor
from pianta.gridmap import GridMap
from pianta.plan.sheets.sheet import PlacedText
from pianta.plan.text.dimensions import parse_length, parse_size, remove_measures
from pianta.plan.text.legend import Legend

# Lines of a name follow each other within this many heights of a line, words on a line within so many.
NEXT_LINE, NEXT_WORD = 1.9, 2.0
# Directions of texts that differ by less than this are one, rad.
SAME_DIRECTION = 0.35
# Files of drawings may hold anything: of more texts in a room the highest are read, and the first signs of each.
MOST_TEXTS, MOST_SIGNS = 60, 200
# More letters than these say no more about which text is the name.
ENOUGH_LETTERS = 12

# What plans say about a place in a room, not of the room; and chairs, tables and crosses that were read as letters.
_REMARKS = frozenset({"up", "dn", "down", "su", "giu", "auf", "ab", "oh", "ref", "dw", "w", "d", "wh", "fe", "exit"})

# A text without a word that has these is a size or a strength which was misread.
_MISREAD_MEASURE = re.compile(r"\d\s*['\"°“”„*~=]|\d\W*[x×*]\W*\d|\d\w*#", re.IGNORECASE)
_CIRCLES = re.compile(r"[0Oo\s]+|[xX]")


def name_rooms(floor: Floor, texts: Sequence[PlacedText], grid: GridMap, legend: Legend | None = None) -> Floor:
    """The floor with a name for each room in which texts stand; other rooms keep theirs.

    texts: corners in pixels of the grid. legend: its texts name no room themselves, its keys do.
    Lines of a name are put together in the direction in which they are read. Lengths, areas and remarks on stairs are
    left out. A room's number stays before its name, unless the legend says what it stands for.
    """
    legend = legend or Legend()
    in_legend = set(map(id, legend.texts))
    words = [word for text in texts if id(text) not in in_legend for word in _split_at_rooms(text, floor, grid)]
    of_room: dict[int, list[PlacedText]] = {}
    for text, index in zip(words, _find_rooms([word.middle for word in words], floor, grid), strict=True):
        if index >= 0:
            of_room.setdefault(int(index), []).append(text)
    names = {index: name for index, inside in of_room.items() if (name := name_of_texts(inside, legend))}
    rooms = (replace(room, name=names.get(index, room.name)) for index, room in enumerate(floor.rooms))
    return replace(floor, rooms=tuple(rooms))


def name_of_texts(texts: Sequence[PlacedText], legend: Legend | None = None) -> str | None:
    """The name that the texts of one room give it, None where they give none.

    Of texts apart from each other, numbers come first, then the largest and longest of the others.
    """
    legend = legend or Legend()
    highest = sorted(texts, key=lambda text: (-text.height, *text.middle, text.text))[:MOST_TEXTS]
    telling = sorted(_without_measures(highest), key=lambda text: (*text.middle, text.text))
    keys = [text for text in telling if legend.find_name(text.text)]
    groups = [_join_lines(group) for group in _group_lines([text for text in telling if text not in keys])]
    numbers = [*(text.text for text in keys), *(text for text, _ in groups if not _has_word(text))]
    own = max(((weight, text) for text, weight in groups if _has_word(text)), default=None)
    known = [name for text in keys if (name := legend.find_name(text.text))]
    parts = [*numbers[:1], own[1]] if own else list(dict.fromkeys(known)) or numbers[:1]
    name = "".join(sign if sign.isprintable() else " " for sign in " ".join(parts))
    return " ".join(name.split())[:MAX_ROOM_NAME_LENGTH].strip() or None


def _find_rooms(places: Sequence[Floats], floor: Floor, grid: GridMap) -> NDArray[np.int64]:
    """The index of the room in which each place, row and col, lies; -1 for none."""
    found = np.full(len(places), -1)
    if not (len(places) and floor.rooms):
        return found
    rows, cols = np.array(places).T
    points = shapely.points(*grid.pixel_to_map(rows, cols))
    tree = shapely.STRtree(points)
    rooms, inside = tree.query([room.polygon for room in floor.rooms], predicate="intersects")
    found[inside] = rooms
    return found


def _split_at_rooms(text: PlacedText, floor: Floor, grid: GridMap) -> Iterator[PlacedText]:
    """The text, or its words where these stand in different rooms: OCR takes neighbours for one line."""
    words = text.text.split()
    if len(words) < 2 or len(text.text) > MOST_SIGNS:
        yield text
        return
    along = (text.corners[1] - text.corners[0], text.corners[2] - text.corners[3])
    placed, start = [], 0
    for word in words:
        start = text.text.index(word, start)
        first, last = start / len(text.text), (start + len(word)) / len(text.text)
        upper, lower = ([near + share * side for share in (first, last)] for near, side in _sides(text, along))
        corners = np.array([upper[0], upper[1], lower[1], lower[0]])
        placed.append(PlacedText(word, corners, text.confidence))
        start += len(word)
    rooms = _find_rooms([word.middle for word in placed], floor, grid)
    inside = {int(room) for room in rooms if room >= 0}
    yield from placed if len(inside) > 1 else [text]


def _sides(text: PlacedText, along: tuple[Floats, Floats]) -> Iterator[tuple[Floats, Floats]]:
    """The upper and the lower side of a text: where it starts, and which way and how far it goes."""
    yield text.corners[0], along[0]
    yield text.corners[3], along[1]


def _without_measures(texts: Sequence[PlacedText]) -> list[PlacedText]:
    """The texts that say something else than lengths, areas and ways up."""
    left = [replace(text, text=remove_measures(text.text[:MOST_SIGNS])) for text in texts]
    return [
        text
        for text in left
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
    along, down = _frame(one)
    if float(along @ _frame(other)[0]) < np.cos(SAME_DIRECTION):
        return False
    height = max(one.height, other.height)
    if height > 2 * min(one.height, other.height):
        return False
    offset = other.middle - one.middle
    widths = [float(np.hypot(*(text.corners[1] - text.corners[0]))) for text in (one, other)]
    gap = abs(float(offset @ along)) - sum(widths) / 2
    lines = abs(float(offset @ down)) / height
    return lines <= NEXT_LINE and gap <= (0.5 if lines > 0.6 else NEXT_WORD) * height


def _group_lines(texts: Sequence[PlacedText]) -> list[list[PlacedText]]:
    """Texts that belong to each other, directly or through others."""
    groups: list[list[PlacedText]] = []
    for text in texts:
        near = [group for group in groups if any(_belong(text, other) for other in group)]
        groups = [group for group in groups if not any(group is one for one in near)]
        groups.append([*(other for group in near for other in group), text])
    return groups


def _join_lines(texts: Sequence[PlacedText]) -> tuple[str, float]:
    """Lines in reading order as one text, and how much they look like the name of the room."""
    along, down = _frame(texts[0])
    height = max(text.height for text in texts)
    lines: list[list[PlacedText]] = []
    for text in sorted(texts, key=lambda text: float(text.middle @ down)):
        if lines and float((text.middle - lines[-1][0].middle) @ down) <= 0.5 * height:
            lines[-1].append(text)
        else:
            lines.append([text])
    joined = ""
    for line in lines:
        words = " ".join(text.text for text in sorted(line, key=lambda text: float(text.middle @ along)))
        # A word that is cut at the end of its line goes on in small letters.
        cut = joined.endswith("-") and joined[-2:-1].isalpha() and words[:1].islower()
        joined = joined[:-1] + words if cut else f"{joined} {words}".strip()
    letters = min(sum(map(str.isalpha, joined)), ENOUGH_LETTERS)
    return joined, letters * height * float(np.mean([text.confidence for text in texts]))
