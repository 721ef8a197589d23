"""Names of rooms on synthetic sheets, read: five fonts, three sizes, two rotations, five languages."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain

from pianta.plan.text.recognition import read_texts
from pianta.plan.text.room_names import compose_room_name
from pianta.worlds.plans.name_sheets import FONTS, NAMES, ROTATIONS, letter_rooms
from pianta_bench.harness.table import BenchTable, Column, Figures, Part, Row, measure_rows

# Heights of a capital, pixels.
CAPITALS = (10, 16, 28)
PRINTED = tuple(chain.from_iterable(NAMES.values()))
# Columns of rooms that make a sheet of names, which are wider than high, about square.
COLUMNS_OF_ROTATION = {0: 4, 90: 10}
SCORES = (
    Column("names", "names", "", digits=0),
    Column("exact", "read\nexactly", "", digits=0, failed=0.0),
    Column("share", "of these", "%", failed=0.0),
    Column("found", "rooms with\na name", "%", failed=0.0),
)
NOTE = (
    "exactly: letter by letter, with capitals, accents and blanks. Names of schools and offices in English, Italian, "
    "German, French and Spanish, black on white, each in a room of walls."
)


def measure_text(
    *,
    fonts: Sequence[str] = FONTS,
    capitals: Sequence[int] = CAPITALS,
    rotations: Sequence[int] = ROTATIONS,
    names: Sequence[str] = PRINTED,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
) -> BenchTable:
    """Share of printed room names that are read exactly, a part a font, a row a size and rotation.

    capitals: heights of capital letters, pixels. rotations: 0 and 90 degrees. track: wraps the rows, to show progress.
    Nothing is drawn by lot. Raises ImportError where rapidocr is not installed.
    """
    items = [f"{font} {capital} px {rotation}°" for font in fonts for capital in capitals for rotation in rotations]

    def measure(item: str) -> Iterator[Figures]:
        font, capital, _, rotation = item.replace("°", "").split()
        yield _measure_sheet(names, font, int(capital), int(rotation))

    rows = measure_rows(track(items), measure, columns=SCORES)
    parts = tuple(Part(font, tuple(row for row in rows if row.item.split()[0] == font), "rapidocr") for font in fonts)
    whole = Part("all", rows, "rapidocr")
    sets = [whole, *_parts_of(rows, [f"{capital} px" for capital in capitals])]
    sets += _parts_of(rows, [f"{rotation}°" for rotation in rotations])
    return BenchTable(
        bench="plan text",
        title="Names of rooms on synthetic plans",
        methods=("rapidocr",),
        columns=SCORES,
        parts=parts,
        scores=(),
        compared={},
        printed=(),
        notes=("Read exactly: " + ", ".join(map(_describe_share, sets)) + ".", NOTE),
        ratios={"read_exactly": ("exact", "names")},
    )


def _measure_sheet(names: Sequence[str], font: str, capital: int, rotation: int) -> Figures:
    columns = COLUMNS_OF_ROTATION[rotation]
    sheet = letter_rooms(names, font=font, capital=capital, rotation=rotation, columns=columns)
    texts = read_texts(sheet.colors)
    read = []
    for name in sheet.names:
        top, left, bottom, right = name.room
        inside = [text for text in texts if top <= text.middle[0] < bottom and left <= text.middle[1] < right]
        read.append(compose_room_name(inside))
    exact = sum(got == name.text for got, name in zip(read, sheet.names, strict=True))
    found = sum(got is not None for got in read)
    return {
        "names": len(read),
        "exact": exact,
        "share": 100 * exact / len(read),
        "found": 100 * found / len(read),
    }


def _parts_of(rows: Sequence[Row], settings: Sequence[str]) -> list[Part]:
    """The rows of each size or rotation."""
    return [Part(name, tuple(row for row in rows if f" {name} " in f"{row.item} "), "rapidocr") for name in settings]


def _describe_share(part: Part) -> str:
    share = part.divide_sums("exact", "names")
    return f"{part.name} {'–' if share is None else f'{share:.1%}'}"
