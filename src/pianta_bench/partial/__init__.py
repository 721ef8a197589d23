"""Section 8.2: rooms that were seen in part."""

from __future__ import annotations

from pianta.layout.reconstruct import DEFAULT_METHOD
from pianta_bench._options import Data, Method
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="partial",
    help="""Rooms that were seen in part, predicted as a whole (section 8.2).

    Reads partial/*/steps.json and its maps of the data with the whole
    buildings, and simulates some more. A map that fails does not count; the
    exit code is then 1.
    """,
    examples=("pianta bench partial", "pianta bench partial --pictures partial"),
    options={"data": (Data, None), "method": (Method, DEFAULT_METHOD)},
    pictures="RUN_STEP.png, the reconstructed floor of each map",
)
