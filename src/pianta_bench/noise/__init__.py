"""Rooms, labels and building types over noise, drift, furniture, missing doors and the reach of the lidar."""

from __future__ import annotations

from typing import Annotated

import typer

from pianta_bench._options import Data, Methods, Seed, TimedJobs
from pianta_bench.harness.bench import Bench

# Drawn floors of the data, or made ones.
DRAWN_SET = "drawn"
WORLDS_SET = "worlds"
FACTOR_NAMES = ("noise", "drift", "furniture", "doors", "reach")

FloorSet = Annotated[
    str,
    typer.Option("--set", metavar="NAME", help=f"{DRAWN_SET}: of the data; {WORLDS_SET}: made offices."),
]
Count = Annotated[int, typer.Option("--floors", min=1, max=1000, help="Number of floors.")]
Factors = Annotated[
    list[str] | None,
    typer.Option("--factor", metavar="NAME", help=f"May be repeated: {', '.join(FACTOR_NAMES)}; all unless given."),
]
Levels = Annotated[
    int, typer.Option("--levels", min=1, max=4, help="Levels of each factor beside the clean map, evenly chosen.")
]

BENCH = Bench(
    name="noise",
    help="""Rooms, labels and building types as maps get worse, one factor at a time (chapter 9).

    Simulates maps of drawn schools and offices of the data, or of made offices,
    with noise, drift, furniture, missing doors, or a lidar of a short reach, and
    all else clean. A map on which no room is found counts as 0. A map that fails
    counts as 0 too; the exit code is then 1.
    """,
    examples=(
        "pianta bench noise --set worlds --floors 2 --factor doors --method structure",
        "pianta bench noise --floors 6 --json noise.json --pictures noise",
    ),
    options={
        "data": (Data, None),
        "floor_set": (FloorSet, DRAWN_SET),
        "floors": (Count, 6),
        "factors": (Factors, None),
        "levels": (Levels, 4),
        "methods": (Methods, None),
        "seed": (Seed, 0),
        "jobs": (TimedJobs, 1),
    },
    pictures="curves.png, each figure over the levels of each factor",
)
