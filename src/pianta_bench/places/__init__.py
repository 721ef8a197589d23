"""Tables 5.2 to 5.4 and 6.1: what each room is for."""

from __future__ import annotations

from pianta_bench._options import Data, Jobs, PlaceSplit, Seed
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="places",
    help="""What rooms are for (Table 6.1, Tables 5.2 to 5.4), calibration and cost.

    Reads buildings/school/*.xml and buildings/office/*.xml of the data, and
    slam/NAME.png with slam/NAME_gt.xml. Maps are reconstructed by the method
    structure and by the thesis' Algorithm 1. Each building is labelled by
    models that were not trained on it; of more than 36 buildings, several are
    left out together. A floor that fails does not count; the exit code is then
    1.
    """,
    examples=("pianta bench places", "pianta bench places --json places.json --pictures places"),
    options={"data": (Data, None), "convention": (PlaceSplit, "experiments"), "seed": (Seed, 0), "jobs": (Jobs, None)},
    pictures="reliability.png, confusion.png, and NAME.png and NAME_true.png of each map",
)
