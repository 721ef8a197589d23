"""Chapters 8 and 9: what a robot understands of a building while it maps it."""

from __future__ import annotations

from typing import Annotated

import typer

from pianta_bench._options import Data, TimedJobs
from pianta_bench.harness.bench import Bench

MOST_ROOMS = 60  # of buildings, by default: larger ones take minutes each
STARTS = 2  # of each building, by default: metres from one start are mostly chance

Type = Annotated[str, typer.Option(help="Type of the buildings: school or office.", metavar="TYPE")]
Items = Annotated[
    list[str] | None,
    typer.Option("--item", help="Only the building of this name, may be repeated.", metavar="NAME"),
]
MostRooms = Annotated[int, typer.Option("--most-rooms", help="Larger buildings are left out.", min=2)]
Starts = Annotated[
    int, typer.Option(help="From which metres are measured, the most for each building; 0 for all.", min=0)
]
Seed = Annotated[int, typer.Option(min=0, max=2**31, help="Of the noise of the lidar.")]

BENCH = Bench(
    name="online",
    help="""What a robot understands of a building while it maps it (chapters 8, 9).

    Reads buildings/TYPE/*.xml of the data. A robot explores each building with
    the policy that predicts, once with perfect knowledge of rooms and once with
    what it reads from its map, from each of some starts; what it understands is
    that of the first. Models are learned from the other buildings. A building that
    fails does not count; the exit code is then 1.
    """,
    examples=("pianta bench online", "pianta bench online --item sabadell1 --item franch1 --pictures new"),
    options={
        "data": (Data, None),
        "type": (Type, "school"),
        "items": (Items, None),
        "most_rooms": (MostRooms, MOST_ROOMS),
        "starts": (Starts, STARTS),
        "jobs": (TimedJobs, 1),
        "seed": (Seed, 0),
    },
    pictures="curves.png, what is right over the way and what updates cost",
)
