"""Time and memory of the methods."""

from __future__ import annotations

from pianta_bench._options import Methods
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="cost",
    help="""Time and memory for sixteen floors on one map, against one of them.

    The floors are generated, no data are needed: a map of 1000 x 1000 cells,
    and one of 4000 x 4000 with sixteen copies of it. With the method structure
    also what each stage of a whole `pianta read` takes.
    """,
    examples=("pianta bench cost --method structure", "pianta bench cost --method thesis"),
    options={"methods": (Methods, None)},
)
