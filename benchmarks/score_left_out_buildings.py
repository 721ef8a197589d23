"""Score the method `structure` on real maps, each with a network of map regions that its building was left out of.

Run: OMP_NUM_THREADS=1 python benchmarks/score_left_out_buildings.py NETWORKS [--data DIR] [--items] [--calibration]

NETWORKS is a folder with 0.onnx … 3.onnx: training/fit_map_regions.py with --annotated and --leave-out, for each group
of FOLDS of training/annotated_lessons.py. Scores and counts are those of `pianta bench segmentation --count`, on the
survey also by the counts of Table 3.1b;
--calibration prints the figures of `pianta bench calibration` instead.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import cv2
import numpy as np

from pianta.layout.structure import evidence
from pianta_bench.calibration.measure import REGIONS, measure_apart
from pianta_bench.calibration.tables import REAL, describe_bins, describe_set, list_groups
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import MapSet, choose_sets
from pianta_bench.harness.records import Results
from pianta_bench.segmentation.measure import COUNT_SCORES, measure_map
from pianta_bench.segmentation.tables import PUBLISHED_SETS

sys.path.append(str(Path(__file__).parents[1] / "training"))
from annotated_lessons import FOLDS, SETS


def main() -> None:
    """Print the scores of each set, and of each map if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("networks", type=Path)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--items", action="store_true", help="print the scores of each map too")
    parser.add_argument("--calibration", action="store_true", help="print the calibration of rooms and doors")
    options = parser.parse_args()
    data = find_data(options.data)
    if options.calibration:
        print_calibration(data, options.networks)
        return
    for mapset, items in choose_sets(SETS, data).items():
        rows = []
        for item in items:
            use_network(options.networks, mapset.building_of(data, item))
            rows.append(score_map(data, mapset, item))
            if options.items:
                print_scores(item, rows[-1:])
        print_scores(mapset.name, rows)
        if mapset.name in PUBLISHED_SETS:
            print_counts(mapset.name, rows)


def score_map(data: Path, mapset: MapSet, item: str) -> dict[str, float]:
    """Scores and counts of a map by the method `structure`, as `pianta bench segmentation --count` has them."""
    figures: dict[str, float | None] = {}
    for part in measure_map(
        item,
        mapset=mapset,
        method="structure",
        read=lambda mapset, item: mapset.read(data / mapset.folder, item),
        earlier=None,
        count=True,
        pictures=None,
    ):
        figures |= part
    return {name: float(value or 0) for name, value in figures.items()}


def use_network(networks: Path, building: str) -> None:
    """Let reconstruct read the network that a building was left out of."""
    fold = next(fold for fold, buildings in enumerate(FOLDS) if building in buildings)
    network = cv2.dnn.readNetFromONNX(str(networks / f"{fold}.onnx"))
    evidence._read_network = lambda: network  # type: ignore[assignment]


def print_calibration(data: Path, networks: Path) -> None:
    """Print the calibration of rooms, and of doors where true ones are known, in per cent and points."""
    results = Results()
    for mapset, items in choose_sets(SETS, data).items():
        for item in items:
            use_network(networks, mapset.building_of(data, item))
            results.extend(measure_apart(data, mapset.name, item))
    for regions in REGIONS:
        for part, probabilities, is_right in list_groups(results, regions):
            figures = {record["metric"]: record["value"] for record in describe_set(part, probabilities, is_right)}
            sys.stdout.write(f"{regions} of {part}: {figures}\n")
            if part == REAL:
                sys.stdout.writelines(f"    {record}\n" for record in describe_bins(part, probabilities, is_right))


def print_scores(name: str, rows: list[dict[str, float]]) -> None:
    """Print mean ± sd of IoU and F1, and the counts of all maps together."""

    def total(*names: str) -> float:
        return sum(row[name] for row in rows for name in names)

    values = {key: np.array([row[key] for row in rows]) for key in ("mean_iou", "f1")}
    spread = 1 if len(rows) > 1 else 0
    means = " ".join(f"{key} {each.mean():.1f} ± {each.std(ddof=spread):.1f}" for key, each in values.items())
    sys.stdout.write(
        f"{name} ({len(rows)}): {means}, found / true {total('found') / total('true'):.2f}, "
        f"right {100 * total('right') / total('counted_true'):.1f} %, "
        f"whole {100 * total('right_whole') / total('counted_true'):.1f} %, "
        f"splits {total('splits') / len(rows):.1f}, merges {total('merges') / len(rows):.1f} a map, "
        f"wrong doors {100 * total('within', 'nowhere') / max(total('doors'), 1):.1f} %\n"
    )
    sys.stdout.flush()


def print_counts(name: str, rows: list[dict[str, float]]) -> None:
    """Print mean ± sd of precision and recall by the counts of Table 3.1b, and of IoU and F1 where they have them."""
    for count, scores in COUNT_SCORES.items():
        printed = [score for score in ("precision", "recall", "mean_iou", "f1") if score in scores]
        values = [np.array([row[f"{score}_{count}"] for row in rows]) for score in printed]
        text = ", ".join(
            f"{score} {each.mean():.1f} ± {each.std(ddof=1):.1f}" for score, each in zip(printed, values, strict=True)
        )
        sys.stdout.write(f"{name}, count {count}: {text}\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
