"""The number of clusters as the set of floors grows (thesis, section 7.3.3)."""

from __future__ import annotations

import numpy as np

from pianta.errors import ModelError
from pianta.generation.area_clusters import cluster_areas, compare_areas
from pianta.generation.type_model import TypeModel
from pianta_bench.harness.records import Results

# Metric: of a draw of a number of floors, `floors`.
CLUSTERS = "clusters of fewer floors"
SIZES = (5, 10, 15, 20, 25, 30)
DRAWS = 20


def add_stability(results: Results, part: str, model: TypeModel, *, seed: int, draws: int = DRAWS) -> None:
    """Append the number of clusters of the areas of 5, 10, 15 … floors of a model, drawn at random, `draws` times each.

    The similarity of two areas does not depend on other areas, so the kernel is computed once.
    """
    gram = compare_areas(model.areas)
    floor_of = np.repeat(np.arange(len(model.floors)), [len(floor.areas) for floor in model.floors])
    random = np.random.default_rng(seed)
    for size in SIZES:
        for draw in range(draws if size < len(model.floors) else 0):
            chosen = np.flatnonzero(np.isin(floor_of, random.permutation(len(model.floors))[:size]))
            try:
                clusters = cluster_areas(gram[np.ix_(chosen, chosen)], segmentation=model.segmentation)
            except ModelError:
                number = None
            else:
                number = int(clusters.max()) + 1
            results.add(part, f"draw {draw + 1}", {CLUSTERS: number}, floors=f"{size} floors")
