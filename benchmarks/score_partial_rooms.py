"""Score predictions of partial rooms on real maps of four buildings that nothing was learned from.

Run: OMP_NUM_THREADS=1 python benchmarks/score_partial_rooms.py [--data DIR]

The buildings are VALIDATION of training/partial_maps.py; a simulated robot explores a part of their maps in slam
and survey. The weights of network and hypotheses were chosen on other explorations of them. Guesses and scores are
those of `pianta bench partial`.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from pianta.errors import PiantaError
from pianta.layout.reconstruct import reconstruct
from pianta_bench.data.folders import find_data
from pianta_bench.partial.guesses import GUESSES
from pianta_bench.partial.measure import EvaluatedRoom, evaluate_rooms
from pianta_bench.partial.tables import A_THIRD

sys.path.append(str(Path(__file__).parents[1] / "training"))
from partial_maps import DRAWING, VALIDATION, add_data_option, list_jobs


def main() -> None:
    """Print the mean IoU ± sd of each guess, for truly partial rooms and for all that are called partial."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_data_option(parser)
    data = find_data(parser.parse_args().data)
    rooms: list[EvaluatedRoom] = []
    for job in list_jobs(data):
        if job.building in VALIDATION and job.source != DRAWING:
            try:
                partial_map = job.read(data)
                rooms += evaluate_rooms(reconstruct(partial_map.grid), partial_map)
            except PiantaError as error:
                sys.stdout.write(f"{job.name}: {error}\n")
    measured = [room for room in rooms if room.seen_share >= A_THIRD]
    print_scores("truly partial", [room for room in measured if room.truly_partial])
    print_scores("called partial", [room for room in measured if room.called_partial])


def print_scores(name: str, rooms: list[EvaluatedRoom]) -> None:
    """Print the mean IoU ± sd of each guess, %."""
    ious = {guess: 100 * np.array([room.ious[guess] for room in rooms]) for guess in GUESSES}
    scores = ", ".join(f"{guess} {each.mean():.1f} ± {each.std(ddof=1):.1f}" for guess, each in ious.items())
    sys.stdout.write(f"{name} ({len(rooms)} rooms, at least a third seen): {scores}\n")


if __name__ == "__main__":
    main()
