"""Table 3.1a: layouts of schools."""

from __future__ import annotations

from pianta_bench._options import Data, Method
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="layout",
    help="""Layouts of schools against the true ones (Table 3.1a).

    Reads slam/NAME.png and slam/NAME_gt.xml of the data. A map that fails
    counts as 0; the exit code is then 1.
    """,
    examples=("pianta bench layout", "pianta bench layout --pictures layouts"),
    options={"data": (Data, None), "method": (Method, "thesis")},
    pictures="a picture of every floor that was reconstructed",
)
