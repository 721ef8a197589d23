"""Doors by their positions, and edges of the room graph, against the true ones: figures of a map, and of a set."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pianta.evaluation.doors import DetectionScores, score_connections, score_doors, score_edges
from pianta.evaluation.segmentation import match_rooms
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta_bench.harness.records import Figures, Record, Results

# m; the middle of a door is right within half the true door's width, and at least within this: half the width of a
# door of 0.9 m, which scales the layouts of the thesis.
LEAST_REACH = 0.45
ITEMS = ("doors", "edges", "pairs")
F1_SCORES = tuple(f"{item}_f1" for item in ITEMS)
FAILED_GRAPH = {
    **dict.fromkeys(F1_SCORES, 0.0),
    **dict.fromkeys((f"{count}_{item}" for item in ITEMS for count in ("found", "right")), 0),
    **dict.fromkeys(f"true_{item}" for item in ITEMS),
}


def count_true(truth: Floor) -> Figures:
    """Numbers of the true doors, and of the pairs of rooms that they join."""
    edges = score_edges(Floor(()), truth, {}).true
    return {"true_doors": len(truth.doors), "true_edges": edges, "true_pairs": edges}


def score_graph(floor: Floor, truth: Floor, grid: GridMap) -> Figures:
    """F1 of doors, of edges, and of the pairs of true rooms that doors join, %; and how many are true, found and right.

    A room matches the true room with which it has an IoU above 0.5 on the free cells of the map.
    """
    labels, true_labels = (np.where(grid.free, each.label_image(grid), 0) for each in (floor, truth))
    scores = {
        "doors": score_doors(floor, truth, least_reach=LEAST_REACH),
        "edges": score_edges(floor, truth, match_rooms(labels, true_labels)),
        "pairs": score_connections(floor, truth),
    }
    figures: dict[str, float | None] = {}
    for item, score in scores.items():
        figures[f"{item}_f1"] = 100 * score.f1
        figures |= {f"true_{item}": score.true, f"found_{item}": score.detected, f"right_{item}": score.correct}
    return figures


def pool_maps(results: Results, part: str) -> Iterator[Record]:
    """Precision, recall and F1 of the doors, edges and pairs of all maps of a part together, %."""
    for item in ITEMS:
        true, detected, right = (
            int(sum(results.values(part=part, metric=f"{count}_{item}"))) for count in ("true", "found", "right")
        )
        pooled = DetectionScores(true, detected, right)
        shares = {"precision": pooled.precision, "recall": pooled.recall, "f1": pooled.f1}
        for score, share in shares.items():
            yield {"part": part, "metric": f"{item}_pooled_{score}", "value": 100 * share}
        yield {"part": part, "metric": f"{item}_true", "value": true}
