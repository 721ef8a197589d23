"""Drawn buildings: doors, areas and time; and whether a robot that scans them finds the same building.

Run: OMP_NUM_THREADS=1 python benchmarks/measure_drawing.py school.json [--count 200] [--seed 1] [--scanned 12]

Buildings are generated from a model and drawn. Areas of the most frequent labels are compared with those of the floors
of the model by the test of Kolmogorov and Smirnov. The first buildings of at most 35 rooms are scanned without noise,
without furniture and with it, and read by the method `structure`: rooms with an IoU of 0.6 and doors as F1, and the
share whose topological graph, without labels, is isomorphic to the drawn one.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path

import networkx as nx
import numpy as np
from scipy.stats import ks_2samp

import pianta
from pianta.evaluation.doors import score_doors
from pianta.floor import Floor
from pianta.generation.type_model import TypeFloor
from pianta.generation.type_model_file import read_type_model
from pianta.worlds.scan import simulate_map

LABELS = 6  # most frequent ones
LARGEST_DRAWN = 60  # rooms of the buildings that must be drawn
LARGEST_SCANNED = 35  # rooms
FURNITURE = (0.0, 0.3)
MIN_IOU = 0.6


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("model", type=Path)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--scanned", type=int, default=12)
    options = parser.parse_args()
    model = read_type_model(options.model)
    start = time.perf_counter()
    graphs = pianta.generate(model, options.count, seed=options.seed)
    print(f"{time.perf_counter() - start:.1f} s to generate {len(graphs)} graphs")
    plans, seconds = [], []
    for number, graph in enumerate(graphs):
        start = time.perf_counter()
        plans.append(pianta.draw_plan(graph, model, seed=number))
        seconds.append(time.perf_counter() - start)
    doors, given_up = sum(graph.number_of_edges() for graph in graphs), sum(len(plan.given_up) for plan in plans)
    small = [not plan.given_up for plan in plans if len(plan.floor) <= LARGEST_DRAWN]
    share = 1 - given_up / doors
    print(f"all doors: {sum(not plan.given_up for plan in plans)} of {len(plans)} buildings")
    print(f"of those up to {LARGEST_DRAWN} rooms {sum(small)} of {len(small)}; {share:.2%} of {doors} doors")
    print(f"{np.mean(seconds):.2f} ± {np.std(seconds):.2f} s, at most {max(seconds):.1f} s")
    compare_areas([plan.floor for plan in plans], model.floors)
    scanned = [plan.floor for plan in plans if len(plan.floor) <= LARGEST_SCANNED][: options.scanned]
    for furniture in FURNITURE:
        scan(scanned, furniture)


def compare_areas(floors: list[Floor], type_floors: Sequence[TypeFloor]) -> None:
    """Print the test of each frequent label."""
    real: defaultdict[str, list[float]] = defaultdict(list)
    generated: defaultdict[str, list[float]] = defaultdict(list)
    for type_floor in type_floors:
        for _, room in type_floor.graph.nodes(data=True):
            real[room["label"]].append(room["area"])
    for room in (room for floor in floors for room in floor):
        generated[str(room.label)].append(room.polygon.area)
    for label in sorted(real, key=lambda label: -len(real[label]))[:LABELS]:
        test = ks_2samp(real[label], generated[label])
        medians = f"median {np.median(real[label]):.1f} and {np.median(generated[label]):.1f} m²"
        print(f"{label}: {len(real[label])} real, {len(generated[label])} drawn, {medians}, p = {test.pvalue:.2f}")


def scan(floors: list[Floor], furniture: float) -> None:
    """Print how the floors are read from their maps."""
    rooms, doors, same = [], [], []
    for number, floor in enumerate(floors):
        again = pianta.reconstruct(simulate_map(floor, seed=number, furniture=furniture))
        rooms.append(2 * count_matches(floor, again) / (len(floor) + len(again)))
        doors.append(score_doors(again, floor).f1)
        same.append(nx.is_isomorphic(again.graph(), floor.graph()))
    figures = ", ".join(
        f"{name} {100 * np.mean(values):.1f} ± {100 * np.std(values):.1f}"
        for name, values in (("rooms F1", rooms), ("doors F1", doors))
    )
    print(f"furniture {furniture}: {len(floors)} buildings, {figures}, same graph {np.mean(same):.0%}")


def count_matches(floor: Floor, other: Floor) -> int:
    """Rooms with an IoU of 0.6 with a room of the other floor: at most one."""
    return sum(
        any(
            room.polygon.intersection(each.polygon).area >= MIN_IOU * room.polygon.union(each.polygon).area
            for each in other
            if each.polygon.intersects(room.polygon)
        )
        for room in floor
    )


if __name__ == "__main__":
    main()
