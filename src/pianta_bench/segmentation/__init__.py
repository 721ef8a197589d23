"""Table 3.1b and more: rooms on real and simulated maps."""

from __future__ import annotations

from pianta_bench._options import Count, Data, Maps, Methods, Sets, WithAsPrinted
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="segmentation",
    help="""Rooms of all methods on real and simulated maps (Table 3.1b and more).

    Reads the sets of maps that are in the data: the survey without and with
    furniture, real clutter, homes, closed doors, schools, and a map that
    grows. The survey is counted in three ways: on free cells, with the rest
    as one room, and as polygons against the layouts that were drawn of it.
    A map that fails counts as 0; the exit code is then 1.
    """,
    examples=(
        "pianta bench segmentation --json figures.json",
        "pianta bench segmentation --method thesis --set survey --set clutter --pictures errors",
        "pianta bench segmentation --method structure --set clutter --set vacuum --count",
        "pianta bench segmentation --set survey --set furniture --as-printed",
    ),
    options={
        "data": (Data, None),
        "methods": (Methods, None),
        "sets": (Sets, None),
        "maps": (Maps, False),
        "count": (Count, False),
        "as_printed": (WithAsPrinted, False),
    },
    pictures="METHOD/SET/NAME.png, true rooms beside reconstructed ones, with errors marked",
)
