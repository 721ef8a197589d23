"""Measure how far two divisions of one home into rooms agree, both by owners: what a perfect method could reach.

Run: python benchmarks/compare_owners.py [--data DIR]

Two maps of `vacuum` show the same home, from robots of one or two owners. The second map is shifted by whole cells so
that most free cells agree; counted are cells that are free in both. Each division is scored against the other.
"""

from __future__ import annotations

import argparse
import sys
from itertools import product
from pathlib import Path

import numpy as np

from pianta.evaluation.segmentation import drop_small_rooms, score_labels
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import choose_sets

MAPS = ("l10su_1058_goto_target", "z10_1056_paths")
# The second map is shifted by at most this many cells.
MAX_SHIFT = 8


def main() -> None:
    """Print IoU and F1 both ways."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path)
    data = find_data(parser.parse_args().data)
    ((mapset, _),) = choose_sets(("vacuum",), data).items()
    one, other = (mapset.read(data / mapset.folder, name) for name in MAPS)
    shifts = product(range(-MAX_SHIFT, MAX_SHIFT + 1), repeat=2)
    shift = max(shifts, key=lambda shift: np.count_nonzero(one.grid.free & np.roll(other.grid.free, shift, (0, 1))))
    both = one.grid.free & np.roll(other.grid.free, shift, (0, 1))
    divisions = [
        drop_small_rooms(np.where(both, spaces, 0), resolution=one.grid.resolution)
        for spaces in (one.spaces, np.roll(other.spaces, shift, (0, 1)))
    ]
    for scored, true in ((0, 1), (1, 0)):
        score = score_labels(divisions[scored], divisions[true])
        sys.stdout.write(
            f"{MAPS[scored]} against {MAPS[true]}: mean IoU {100 * score.mean_iou:.1f}, F1 {100 * score.f1:.1f}, "
            f"rooms {score.reconstructed} / {score.true}\n"
        )


if __name__ == "__main__":
    main()
