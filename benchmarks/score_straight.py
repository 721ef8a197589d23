"""Score right-angled outlines (`pianta convert --straight`) on the readings of real maps.

Run: OMP_NUM_THREADS=1 python benchmarks/score_straight.py [SET ...] [--data DIR]

Each map is read by `structure`, and its floor straightened. A room is changed if it got another outline. Of the changed
rooms the change of the area is printed, mean ± sd of its absolute value, and the share within 2 %; of all rooms the
share of corners that are right angles, to a degree, before and after. Overlaps are those that were not there before.
Nothing was fitted; the constants of `pianta.floor.straight` were chosen by hand on three maps of the survey and one of
the vacuums.
"""

from __future__ import annotations

import argparse
import sys
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pianta.floor import Floor
from pianta.floor.straight import MAX_AREA_CHANGE, measure_right_angles, straighten_floor
from pianta.layout.reconstruct import reconstruct
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import SETS

DEFAULT_SETS = ("survey", "furniture", "vacuum")


class Scores(NamedTuple):
    """Of a floor: change of the area of each changed room, share of right angles of all before and after."""

    changes: list[float]
    before: list[float]
    after: list[float]
    overlap: float


def main() -> None:
    """Print the scores of each map, then those of all rooms of each set."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sets", nargs="*", metavar="SET", choices=[*SETS, []], help=f"of {', '.join(SETS)}")
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    options = parser.parse_args()
    data = find_data(options.data)
    for name in options.sets or DEFAULT_SETS:
        scores = []
        for item in SETS[name].list_items(data):
            true_map = SETS[name].read(data / SETS[name].folder, item)
            scores.append(score_floor(reconstruct(true_map.grid)))
            print_scores(f"{name} {item}", scores[-1:])
        print_scores(f"{name}, {len(scores)} maps", scores)


def score_floor(floor: Floor) -> Scores:
    """Straighten a floor and compare its rooms."""
    straight, unchanged = straighten_floor(floor)
    pairs = [(room.polygon, twin.polygon) for room, twin in zip(floor, straight, strict=True)]
    changed = [pair for room, pair in zip(floor, pairs, strict=True) if room.id not in unchanged]
    overlap = sum(
        max(0.0, twin.polygon.intersection(mate.polygon).area - one.polygon.intersection(other.polygon).area)
        for (one, twin), (other, mate) in combinations([*zip(floor, straight, strict=True)], 2)
    )
    before, after = (measure_right_angles(pair[index] for pair in pairs) for index in (0, 1))
    return Scores([after.area / before.area - 1 for before, after in changed], [*before], [*after], overlap)


def print_scores(name: str, scores: list[Scores]) -> None:
    """Print one line."""
    changes = np.abs([change for each in scores for change in each.changes])
    before, after = (np.array([share for each in scores for share in each[index]]) for index in (1, 2))
    text = "no room changed"
    if len(changes):
        within = 100 * np.mean(changes <= MAX_AREA_CHANGE + 1e-9)
        text = f"area {100 * changes.mean():.2f} ± {100 * changes.std():.2f} %, {within:.1f} % of them within 2 %"
    angles = f"right angles {100 * before.mean():.1f} ± {100 * before.std():.1f} -> " if len(before) else ""
    angles += f"{100 * after.mean():.1f} ± {100 * after.std():.1f} %" if len(after) else "no rooms"
    overlap = sum(each.overlap for each in scores)
    sys.stdout.write(
        f"{name}: {len(changes)} of {len(before)} rooms changed, {text}; {angles}; overlap {overlap:.4f} m²\n"
    )
    sys.stdout.flush()


if __name__ == "__main__":
    main()
