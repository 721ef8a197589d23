"""Chapter 7: generated buildings."""

from __future__ import annotations

from typing import Annotated

import typer

from pianta_bench._options import Data, Seed
from pianta_bench.harness.bench import Bench

COUNT = 200  # buildings of each model; thesis, section 7.4

Buildings = Annotated[
    int,
    typer.Option(
        "--count", "-n", help="Buildings to generate with each model, as many as are real or more.", min=1, max=10000
    ),
]
Type = Annotated[str, typer.Option(help="Type of the buildings: school or office.", metavar="TYPE")]
BENCH = Bench(
    name="generation",
    help="""Models of schools and new ones made by them (chapter 7, Tables 7.1, 7.2).

    Reads buildings/school/*.xml of the data, and sampled/corr_table7_1.json
    when it is there, the thesis' own new schools. With --type office it
    reads buildings/office/*.xml. A floor that fails does not count; the
    exit code is then 1.
    """,
    examples=(
        "pianta bench generation",
        "pianta bench generation --type office",
        "pianta bench generation --json new.json --pictures new",
    ),
    options={"data": (Data, None), "type": (Type, "school"), "count": (Buildings, COUNT), "seed": (Seed, 0)},
    pictures="heatmap, areas, buildings (Figs. 7.5, 7.7, 7.9), clusters, and sheets real, corr, ncut, as .png",
)
