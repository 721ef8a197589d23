"""Rooms and doors counted on maps with a truth: figures of a map, and of a set."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pianta.evaluation.room_counts import count_doors, count_rooms
from pianta.floor import Floor
from pianta_bench.data.map_sets import TrueMap
from pianta_bench.harness.records import Figures, Record, Results

ROOM_COUNTS = ("right", "right_whole", "splits", "merges", "no_rooms")
DOOR_COUNTS = ("doors", "within", "nowhere")
TOTALS = ("counted_true", "counted_found")
FAILED_COUNTS = {**dict.fromkeys((*ROOM_COUNTS, *DOOR_COUNTS, "counted_found"), 0), "counted_true": None}
# Shares of sums over all maps, %: by metric the numerators and the denominator.
SHARES = {
    "share_right": (("right",), "counted_true"),
    "share_whole": (("right_whole",), "counted_true"),
    "share_doors_wrong": (("within", "nowhere"), "doors"),
}
# Sums over all maps, divided by the number of maps.
PER_MAP = {"splits_per_map": "splits", "merges_per_map": "merges"}


def count_true_rooms(truth: NDArray[np.int32], true_map: TrueMap) -> Figures:
    """The number of the true rooms with a free cell."""
    return {"counted_true": len(np.unique(truth[true_map.free & (truth > 0)]))}


def count_map(floor: Floor, spaces: NDArray[np.int32], truth: NDArray[np.int32], true_map: TrueMap) -> Figures:
    """Counts of rooms on the free cells of a map, and of the doors between them.

    spaces, truth: shape (H, W), reconstructed and true rooms, without the smallest.
    """
    rooms = count_rooms(spaces, truth, counted=true_map.free, resolution=true_map.grid.resolution)
    doors = count_doors(floor.doors, rooms.true_ids)
    figures: dict[str, float | None] = {name: getattr(rooms, name) for name in ROOM_COUNTS}
    figures |= {name: getattr(doors, name) for name in DOOR_COUNTS}
    return figures | {"counted_true": rooms.true, "counted_found": rooms.detected}


def pool_counts(results: Results, part: str) -> Iterator[Record]:
    """For each method the sums of all counts, and shares and means of them; none without counts."""
    for method in results.options["methods"]:
        sums = {name: results.values(part=part, method=method, metric=name) for name in FAILED_COUNTS}
        maps = len(sums["right"])
        if not maps:
            continue
        totals = {name: sum(values) for name, values in sums.items()}
        figures: dict[str, float | None] = {f"all_{name}": total for name, total in totals.items()}
        for name, (above, below) in SHARES.items():
            figures[name] = 100 * sum(totals[each] for each in above) / totals[below] if totals[below] else None
        figures |= {name: totals[count] / maps for name, count in PER_MAP.items()}
        for name, value in figures.items():
            yield {"part": part, "method": method, "metric": name, "value": value}
