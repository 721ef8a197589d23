"""Count what is read from the PDF and SVG plans of strangers, beside what a person counts on them.

    python benchmarks/count_plan_rooms.py

A numbered room is right if its number stands in a room that has no other number. Rooms and leaves of doors were counted
by eye on the drawings, which were also looked at while the reader was written: nothing here is held out. Rooms with a
flag, which people may not count, are counted apart. Of the pictures, whose outlines `score_plan_rooms.py` scores, only
`hulme.jpg`, two floors of which there are no outlines, is counted here.
"""

from __future__ import annotations

import os
import re
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path

import shapely

from pianta.errors import PlanWarning
from pianta.floor import Floor
from pianta.plan.read_plan import PlanReading, read_plan

DATA = Path(os.environ.get("PIANTA_DATA") or Path(__file__).parents[2] / "shared" / "data")


@dataclass(frozen=True)
class Counted:
    """A plan with its rooms and leaves of doors by eye, None if not counted; numbers: what those of rooms look like."""

    file: str
    rooms: int | None
    doors: int | None
    page: int | None = None
    numbers: str | None = None


PLANS = (
    Counted("raster/hulme.jpg", rooms=54, doors=50),
    Counted("svg/ianmc.svg", rooms=8, doors=None),
    Counted("svg/dfki_selfie.svg", rooms=30, doors=42),
    Counted("pdf/dimension_extraction.pdf", rooms=8, doors=6),
    Counted("pdf/asheville.pdf", rooms=14, doors=11, page=2),
    Counted("pdf/cmu_newell_A.pdf", rooms=None, doors=None, numbers=r"A\d{3}[A-Z]?"),
)


def main() -> None:
    """Print a line for each plan."""
    warnings.simplefilter("ignore", PlanWarning)
    sys.stdout.write(f"{'plan':36}{'rooms':>7}{'by eye':>8}{'flags':>7}{'doors':>7}{'by eye':>8}  numbers\n")
    for plan in PLANS:
        path = DATA / "planfiles" / plan.file
        reading = read_plan(path) if plan.page is None else read_plan(path, page=plan.page)
        floors = [each.floor for each in reading.floors]
        flags = sum(room.flag is not None for floor in floors for room in floor)
        counts = sum(map(len, floors)), "-" if plan.rooms is None else plan.rooms, flags
        doors = sum(door.kind == "door" for floor in floors for door in floor.doors)
        name = plan.file if plan.page is None else f"{plan.file}, page {plan.page}"
        numbers = "" if plan.numbers is None else score_numbers(reading, floors[0], plan.numbers)
        rooms = "".join(f"{count:>{width}}" for count, width in zip(counts, (7, 8, 7), strict=True))
        sys.stdout.write(f"{name:36}{rooms}{doors:>7}{'-' if plan.doors is None else plan.doors:>8}  {numbers}\n")


def score_numbers(reading: PlanReading, floor: Floor, pattern: str) -> str:
    """How many numbers of rooms stand in a room without another number."""
    grid = reading.floors[0].grid
    all_texts = (reading.sheet.texts if reading.sheet else None) or ()
    texts = [text for text in all_texts if re.fullmatch(pattern, text.text.strip())]
    points = [shapely.Point(*grid.pixel_to_map(*text.middle)) for text in texts]
    alone = 0
    for room in floor:
        inside = {text.text for text, point in zip(texts, points, strict=True) if room.polygon.contains(point)}
        alone += len(inside) == 1
    return f"{alone} of {len({text.text for text in texts})} alone in a room"


if __name__ == "__main__":
    main()
