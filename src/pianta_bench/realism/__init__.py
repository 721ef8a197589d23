"""Table 8.2: real and simulated offices."""

from __future__ import annotations

from pianta_bench._options import Data, Seed
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="realism",
    help="""Real offices distinguished from simulated ones (Table 8.2, Fig. 8.4).

    Reads buildings/office/*.xml and buildings/robocup/*.xml of the data, and
    buildings/school/*.xml when there are any, which are assessed as if they
    were offices. A floor that fails does not count; the exit code is then 1.
    """,
    examples=("pianta bench realism", "pianta bench realism --pictures realism"),
    options={"data": (Data, None), "seed": (Seed, 0)},
    pictures="scores.png and curves.png (Fig. 8.4)",
)
