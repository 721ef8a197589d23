"""Numbers of rooms under noise and turns."""

from __future__ import annotations

from typing import Annotated

import typer

from pianta.layout.reconstruct import DEFAULT_METHOD
from pianta_bench._options import Data, Items, Method, TimedJobs
from pianta_bench.data.folders import DEFAULT_ROBUSTNESS_SETS, ROBUSTNESS_SET_NAMES
from pianta_bench.harness.bench import Bench

Sets = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME",
        help=f"Which maps, may be repeated: {', '.join(ROBUSTNESS_SET_NAMES)}; {', '.join(DEFAULT_ROBUSTNESS_SETS)} "
        "unless given.",
    ),
]
Draws = Annotated[int, typer.Option(min=0, max=100000, help="Draws of noise for each map; 0 for no noise.")]
Turns = Annotated[
    int, typer.Option(min=0, max=180, metavar="DEGREES", help="From one rotation to the next; 0 for no rotations.")
]
Seed = Annotated[int, typer.Option(min=0, max=2**31, help="Of the noise.")]

BENCH = Bench(
    name="robustness",
    help="""Numbers of rooms on maps with noise, and on rotated maps.

    Reads the survey, real clutter and homes of the data, and makes furnished
    worlds. A map that fails counts as changed by all draws and turns; the exit
    code is then 1. Some hours of one core: try few maps and draws first.
    """,
    examples=(
        "pianta bench robustness --item lab_c_scan --draws 5 --turns 45",
        "pianta bench robustness --set vacuum --turns 0 --jobs 2 --json noise.json",
    ),
    options={
        "data": (Data, None),
        "method": (Method, DEFAULT_METHOD),
        "sets": (Sets, None),
        "items": (Items, None),
        "draws": (Draws, 100),
        "turns": (Turns, 5),
        "jobs": (TimedJobs, 1),
        "seed": (Seed, 0),
    },
)
