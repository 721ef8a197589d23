"""Algorithm 1 as the thesis prints it, and what each of our departures from it brings."""

from __future__ import annotations

from pianta_bench._options import Data, DepartureSets
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="departures",
    help="""Algorithm 1 as printed, with each of our departures, and ours without each.

    Reads the schools, and the survey without and with furniture: A_FC and A_BC
    of Table 3.1a, precision and recall of Table 3.1b, mean IoU and F1. A map
    that fails counts as 0; the exit code is then 1.
    """,
    examples=("pianta bench departures", "pianta bench departures --set schools --json departures.json"),
    options={"data": (Data, None), "sets": (DepartureSets, None)},
)
