"""Section 4.2.2: how much of a floor repeats itself, beside the same rooms in random places."""

from __future__ import annotations

from typing import Annotated

import typer

from pianta_bench._options import Data, Jobs, Seed
from pianta_bench.harness.bench import Bench

Shuffles = Annotated[
    int, typer.Option(min=1, max=1000, metavar="N", help="How often the rooms of each floor are shuffled.")
]

BENCH = Bench(
    name="patterns",
    help="""Model floor plans: the share of a floor that repeats itself (section 4.2.2).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data, and
    takes the floors of one building by manifest.json as its storeys. A floor
    that fails does not count; the exit code is then 1.
    """,
    examples=("pianta bench patterns", "pianta bench patterns --shuffles 5 --json patterns.json"),
    options={"data": (Data, None), "shuffles": (Shuffles, 20), "seed": (Seed, 0), "jobs": (Jobs, None)},
    pictures="NAME.png, the patterns of every floor",
)
