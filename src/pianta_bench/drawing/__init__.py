"""Buildings drawn from graphs: whether all doors are there, sizes, realism, and what a robot reads of them."""

from __future__ import annotations

from typing import Annotated

import typer

from pianta_bench._options import Data, Jobs, Seed
from pianta_bench.harness.bench import Bench

COUNT = 200  # generated buildings
SCANNED = 30  # drawn buildings of each part that are scanned and read again

Buildings = Annotated[int, typer.Option("--count", "-n", help="Graphs to generate and to draw.", min=1, max=10000)]
Scanned = Annotated[
    int, typer.Option(help="Drawn buildings that are scanned and read again, the first of each part.", min=0)
]
Type = Annotated[str, typer.Option(help="Type of the buildings: school or office.", metavar="TYPE")]
BENCH = Bench(
    name="drawing",
    help="""Buildings drawn from graphs, against real ones, scanned and read again.

    Reads buildings/TYPE/*.xml of the data, and buildings/robocup/*.xml when it
    is there. Draws graphs that a model of these floors generates, and the
    graphs of the floors themselves, each without the geometry of its building.
    A floor that fails does not count; the exit code is then 1.
    """,
    examples=("pianta bench drawing", "pianta bench drawing --count 20 --scanned 5 --pictures drawn"),
    options={
        "data": (Data, None),
        "type": (Type, "school"),
        "count": (Buildings, COUNT),
        "scanned": (Scanned, SCANNED),
        "seed": (Seed, 0),
        "jobs": (Jobs, None),
    },
    pictures="pairs.png: real floors beside what is drawn from their graphs",
)
