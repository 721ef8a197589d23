"""How often rooms and doors are right, by their probability."""

from __future__ import annotations

from typing import Annotated

import typer

from pianta_bench._options import Data, Items, TimedJobs
from pianta_bench.data.folders import CALIBRATION_SET_NAMES, DEFAULT_CALIBRATION_SETS
from pianta_bench.harness.bench import Bench

Sets = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME",
        help=f"Which maps, may be repeated: {', '.join(CALIBRATION_SET_NAMES)}; those in the data of "
        f"{', '.join(DEFAULT_CALIBRATION_SETS)} unless given.",
    ),
]

BENCH = Bench(
    name="calibration",
    help="""How often rooms and doors are right, by their probability.

    Reads the sets of maps with true rooms that are in the data, and makes
    furnished worlds. Rooms are counted on all sets, doors on those with true
    doors: schools, survey, furniture and worlds. Rooms and doors of a map that
    fails are missing; the exit code is then 1.
    """,
    examples=(
        "pianta bench calibration --set clutter --set vacuum",
        "pianta bench calibration --jobs 2 --pictures reliability --json calibration.json",
    ),
    options={
        "data": (Data, None),
        "sets": (Sets, None),
        "items": (Items, None),
        "jobs": (TimedJobs, 1),
    },
    pictures="reliability.png, the share of right rooms and doors by probability",
)
