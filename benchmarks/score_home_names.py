"""Which plans are taken for homes by the texts on them: plans of schools and offices, and plans of strangers.

Every text counts as the name of a room of its own, so that no plan depends on the rooms that are read.

    python benchmarks/score_home_names.py
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

from shapely import box

from pianta.errors import PlanError
from pianta.floor import Floor, Room
from pianta.plan.sheets.open_sheet import open_sheet
from pianta.plan.text.recognition import read_texts
from pianta.rooms.home import find_home_evidence

DATA = Path(os.environ.get("PIANTA_DATA") or Path(__file__).parents[2] / "shared" / "data")
# Of the plans of strangers, by eye: floors of offices, schools and a laboratory; the others are houses and flats
NO_HOMES = frozenset({"cmu_newell_A", "dfki_selfie", "evac_a", "evac_nf", "hulme", "raumplanung"})
SUFFIXES = (".png", ".jpg", ".gif", ".svg")


def main() -> None:
    """Print the probability of a home for each plan, and how many are right."""
    schools = sorted((DATA / "floorplans").rglob("*.png")) + sorted((DATA / "floorplans").rglob("*.jpg"))
    schools = [file for file in schools if "symbols" not in file.parts]
    strangers = [file for file in sorted((DATA / "planfiles").rglob("*")) if file.suffix in SUFFIXES]
    for title, files in (("plans of schools and offices", schools), ("plans of strangers", strangers)):
        right, count = 0, 0
        for file in files:
            probability = measure_home(file)
            if probability is None:
                continue
            is_home = title == "plans of strangers" and file.stem not in NO_HOMES
            right, count = right + ((probability > 0) is is_home), count + 1
            sys.stdout.write(f"{file.stem:40} {probability:.2f} {'home' if is_home else ''}\n")
        sys.stdout.write(f"{title}: {right} of {count} right\n")


def measure_home(file: Path) -> float | None:
    """The probability that a plan is a home, 0 for another building; None for a file that is no plan."""
    try:
        sheet = open_sheet(file)
    except PlanError:
        return None
    texts = sheet.texts if sheet.texts is not None else read_texts(sheet.colors)
    rooms = tuple(Room(number, box(0, 0, 1, 1), name=text.text[:100]) for number, text in enumerate(texts, start=1))
    return find_home_evidence(Floor(rooms)).probability


if __name__ == "__main__":
    main()
