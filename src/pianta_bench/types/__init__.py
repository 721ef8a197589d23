"""Tables 4.2 to 4.4: types of buildings by their rooms."""

from __future__ import annotations

from pianta_bench._options import Data, Seed
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="types",
    help="""Types of buildings: classifiers and clusters of rooms (Tables 4.2 to 4.4).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data, and
    buildings/house/*.xml with labels.yaml when there are any. A building that
    fails does not count; the exit code is then 1.
    """,
    examples=("pianta bench types", "pianta bench types --pictures types"),
    options={"data": (Data, None), "seed": (Seed, 0)},
    pictures="accuracy, k_distance, clusters and cluster_scores, as .png",
)
