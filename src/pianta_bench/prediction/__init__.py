"""Section 8.3: the unexplored part of a floor."""

from __future__ import annotations

from typing import Annotated

import typer

from pianta_bench._options import Data, Seed
from pianta_bench.harness.bench import Bench

COUNT = 100  # samples of a prediction; chosen by hand

Samples = Annotated[int, typer.Option("--count", "-n", help="Samples of each prediction.", min=1, max=10000)]
BENCH = Bench(
    name="prediction",
    help="""What lies beyond the explored part of a floor, predicted (section 8.3).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data. Each is
    predicted by all others. What fails does not count; the exit code is then 1.
    """,
    examples=("pianta bench prediction --json new.json --pictures new",),
    options={"data": (Data, None), "count": (Samples, COUNT), "seed": (Seed, 0)},
    pictures="TYPE_NAME_CORRIDORS.png of a few floors (Fig. 8.9)",
)
