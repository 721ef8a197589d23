"""Table 6.1: rooms and whole buildings."""

from __future__ import annotations

from pianta_bench._options import BuildingTypes, Data, Jobs, PlaceSplit, Seed, Trees
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="buildings",
    help="""Rooms and whole buildings (Table 6.1, Figs. 6.2 and 6.3).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data, and
    the fact files klog/*.pl of the thesis when they are there. Each building
    is classified by models that were not trained on it; of more than 36
    buildings, several are left out together. With --types only buildings are
    classified, those of your folders, of two types or more. A floor that fails
    does not count; the exit code is then 1.
    """,
    examples=(
        "pianta bench buildings --json buildings.json --pictures buildings",
        "pianta bench buildings --types dorms --types offices --types labs",
    ),
    options={
        "data": (Data, None),
        "types": (BuildingTypes, None),
        "convention": (PlaceSplit, "experiments"),
        "trees": (Trees, 100),
        "seed": (Seed, 0),
        "jobs": (Jobs, None),
    },
    pictures="places.png and buildings.png, the curves",
)
