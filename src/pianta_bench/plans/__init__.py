"""Section 3.3: pictures of plans."""

from __future__ import annotations

from typing import Annotated

import typer

from pianta_bench._options import Data, TimedJobs
from pianta_bench.harness.bench import Bench

SET_NAMES = ("real", "drawn")

Sets = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="NAME", help=f"Which plans, may be repeated: {', '.join(SET_NAMES)}; both by default."
    ),
]
Only = Annotated[list[str] | None, typer.Option(metavar="NAME", help="Only this plan, may be repeated.")]
WithText = Annotated[bool, typer.Option("--text/--no-text", help="Whether what is written on plans is read, too.")]

BENCH = Bench(
    name="plans",
    help="""Pictures of plans, read with and without symbols (section 3.3).

    Reads floorplans/NAME.png or .jpg with NAME.xml of the data, and draws some
    plans. A plan that fails counts as 0; the exit code is then 1.
    """,
    examples=(
        "pianta bench plans --jobs 2 --json plans.json --pictures plans",
        "pianta bench plans --only off2 --only milano1 --no-text",
    ),
    options={
        "data": (Data, None),
        "sets": (Sets, None),
        "only": (Only, None),
        "with_text": (WithText, True),
        "jobs": (TimedJobs, 1),
    },
    pictures="NAME.png, detected rooms and doors over each plan, the truth in red",
)
