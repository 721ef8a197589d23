"""Tables 4.2 to 4.4: types of buildings by their rooms."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pianta_bench._options import Data, Seed, TypeMaps
from pianta_bench.harness.bench import Bench

Houses = Annotated[
    Path | None,
    typer.Option(
        help="Folder of houses: HouseExpo JSON, layout XML or another format; labels.yaml for your labels.",
        metavar="DIR",
    ),
]
Mit = Annotated[Path | None, typer.Option(help="Folder of floors of MIT's campus, MIT XML (Fig. 4.4e).", metavar="DIR")]

BENCH = Bench(
    name="types",
    help="""Types of buildings: classifiers and clusters of rooms (Tables 4.2 to 4.4).

    Reads buildings/school/*.xml and buildings/office/*.xml of the data, and
    buildings/house/*.xml with labels.yaml when there are any. --houses and
    --mit are folders of those who have these sets. With --maps it
    reads the robots' maps of buildings of a known type instead, and predicts
    their types, each by a model without the building. A building or map that
    fails does not count; the exit code is then 1.
    """,
    examples=(
        "pianta bench types",
        "pianta bench types --pictures types",
        "pianta bench types --houses HouseExpo --mit MITquest",
        "pianta bench types --maps",
    ),
    options={
        "data": (Data, None),
        "houses": (Houses, None),
        "mit": (Mit, None),
        "maps": (TypeMaps, False),
        "seed": (Seed, 0),
    },
    pictures="accuracy, k_distance, clusters, cluster_scores and clusters_mit, as .png",
)
