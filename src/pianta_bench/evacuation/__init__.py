"""Evacuation of annotated buildings (section 8.4)."""

from __future__ import annotations

from pianta_bench._options import Data, EvacuationMaps
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="evacuation",
    help="""Ways out of schools and offices, and rooms with one way out (section 8.4).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data; with
    --maps the maps of slam, which are compared with their drawn floors. A
    floor that fails, such as one without an exit, does not count; the exit
    code is then 1.
    """,
    examples=("pianta bench evacuation", "pianta bench evacuation --maps --json evacuation.json"),
    options={"data": (Data, None), "maps": (EvacuationMaps, False)},
)
