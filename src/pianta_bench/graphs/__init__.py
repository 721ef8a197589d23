"""Table 5.1: buildings as graphs."""

from __future__ import annotations

from pianta_bench._options import Data
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="graphs",
    help="""Metrics of schools and offices as graphs (Table 5.1).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data. A
    building that fails does not count; the exit code is then 1.
    """,
    examples=("pianta bench graphs", "pianta bench graphs --pictures graphs"),
    options={"data": (Data, None)},
    pictures="graphs.png, every published metric of every building",
)
