"""Sections 8.3 and 8.4: how far robots drive."""

from __future__ import annotations

from typing import Annotated

import typer

from pianta_bench._options import Data, TimedJobs
from pianta_bench.harness.bench import Bench

SYNTHETIC = "synthetic"
DRAWN_SET = "drawn"
# The folder of the maps of campus floors in the data too.
CAMPUS = "kth"
# Those of a bench without options; campus floors are as large as several schools.
DEFAULT_SETS = ("school", "office", SYNTHETIC, DRAWN_SET)
SETS = (*DEFAULT_SETS, CAMPUS)

Sets = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="NAME",
        help=f"Which buildings, may be repeated: {', '.join(SETS)}; all but {CAMPUS} unless given.",
    ),
]
Policies = Annotated[
    list[str] | None,
    typer.Option("--policy", metavar="NAME", help="Which policies, may be repeated, with nearest; all by default."),
]
Starts = Annotated[int, typer.Option(min=0, help="The most for each building; 0 for all.")]
Resolution = Annotated[float, typer.Option(help="Of the robots' map, metres per cell.")]
Searches = Annotated[bool, typer.Option(help="Whether the robots also search for rooms by their labels.")]
Seed = Annotated[int, typer.Option(min=0, max=2**31, help="Of the noise of the lidars.")]

BENCH = Bench(
    name="exploration",
    help="""Distances of robots that explore, or search for a room (sections 8.3, 8.4).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data, makes
    synthetic ones, and draws schools that a model of the schools generates.
    Policies that predict learn from the other buildings; in drawn schools from
    the schools of the data. Campus floors, kth/*.png with their *_rooms.png,
    have no labels: nothing is learned for them, and robots start at their widest
    point and at random ones. What fails does not count; the exit code is then 1.
    """,
    examples=(
        "pianta bench exploration --jobs 2 --json new.json --pictures new",
        "pianta bench exploration --set school --set drawn --starts 1 --resolution 0.2 --no-searches",
        "pianta bench exploration --set office --starts 1 --resolution 0.2 --no-searches",
        "pianta bench exploration --set kth --starts 1 --resolution 0.15",
    ),
    options={
        "data": (Data, None),
        "sets": (Sets, None),
        "policies": (Policies, None),
        "starts": (Starts, 3),
        "resolution": (Resolution, 0.1),
        "searches": (Searches, True),
        "jobs": (TimedJobs, 1),
        "seed": (Seed, 0),
    },
    pictures="curves.png, and SET_NAME.png of a few buildings with all tracks",
)
