"""How names of rooms on synthetic sheets are read: in five fonts, three sizes, two rotations and five languages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from itertools import chain, product

from pianta.plan.text.recognition import read_texts
from pianta.plan.text.room_names import compose_room_name
from pianta.worlds.plans.name_sheets import FONTS, NAMES, ROTATIONS, letter_rooms
from pianta_bench.harness.records import Figures, Results, Track

PART = "names"
CAPITALS = (10, 16, 28)  # heights of a capital, pixels
ALL_NAMES = tuple(chain.from_iterable(NAMES.values()))
# By rotation: columns of rooms on a sheet, which make it about square, as names are wider than high.
COLUMNS = {0: 4, 90: 10}
# Metrics of a sheet: its names, those read letter by letter, their share, and the share of rooms with a name, %.
NAME_COUNT, EXACT, EXACT_SHARE, NAMED_SHARE = "names", "exact", "share", "found"
FAILED = {NAME_COUNT: None, EXACT: 0.0, EXACT_SHARE: 0.0, NAMED_SHARE: 0.0}


def measure_text(
    *,
    fonts: Sequence[str] = FONTS,
    capitals: Sequence[int] = CAPITALS,
    rotations: Sequence[int] = ROTATIONS,
    names: Sequence[str] = ALL_NAMES,
    track: Track = iter,
) -> Results:
    """How many room names are read exactly; a sheet, which is an item, for each font, size and rotation.

    capitals: heights of capital letters, pixels. rotations: 0 and 90 degrees. track: wraps the sheets, to show
    progress. Nothing is random. Raises ImportError if rapidocr is not installed.
    """
    results = Results()
    sheets = {
        f"{font} {capital} px {rotation}°": (font, capital, rotation)
        for font, capital, rotation in product(fonts, capitals, rotations)
    }
    for item in track([*sheets]):
        font, capital, rotation = sheets[item]
        fields = {"font": font, "capital": f"{capital} px", "rotation": f"{rotation}°"}
        results.measure(PART, item, partial(_measure_sheet, names, *sheets[item]), failed=FAILED, **fields)
    return results


def _measure_sheet(names: Sequence[str], font: str, capital: int, rotation: int) -> Iterator[Figures]:
    """Read a sheet with names, and count those that are read exactly and those that are read at all."""
    sheet = letter_rooms(names, font=font, capital=capital, rotation=rotation, columns=COLUMNS[rotation])
    texts = read_texts(sheet.colors)
    room_names = []
    for name in sheet.names:
        top, left, bottom, right = name.room
        inside = [text for text in texts if top <= text.middle[0] < bottom and left <= text.middle[1] < right]
        room_names.append(compose_room_name(inside))
    exact = sum(read == name.text for read, name in zip(room_names, sheet.names, strict=True))
    named = sum(read is not None for read in room_names)
    count = len(room_names)
    yield {NAME_COUNT: count, EXACT: exact, EXACT_SHARE: 100 * exact / count, NAMED_SHARE: 100 * named / count}
