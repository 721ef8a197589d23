"""Tables 4.2 to 4.4: types of buildings by their rooms."""

from __future__ import annotations

from pianta_bench._options import Data, Seed, TypeMaps
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="types",
    help="""Types of buildings: classifiers and clusters of rooms (Tables 4.2 to 4.4).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data, and
    buildings/house/*.xml with labels.yaml when there are any. With --maps it
    reads the robots' maps of buildings of a known type instead, and predicts
    their types, each by a model without the building. A building or map that
    fails does not count; the exit code is then 1.
    """,
    examples=("pianta bench types", "pianta bench types --pictures types", "pianta bench types --maps"),
    options={"data": (Data, None), "maps": (TypeMaps, False), "seed": (Seed, 0)},
    pictures="accuracy, k_distance, clusters and cluster_scores, as .png",
)
