"""Compare ways to decide which pieces of a floor are one room, on the pieces and weights of the method `structure`.

Run: OMP_NUM_THREADS=1 python benchmarks/compare_decisions.py NETWORKS [--data DIR]

NETWORKS is the folder of score_left_out_buildings.py, whose scores these are; schools are read by the network that
comes with pianta, which has not seen them. Energy: the sum of the weights of all pairs that are divided, on all maps of
a set, above that of the best decision; 0 is best.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from score_left_out_buildings import SETS, print_scores, score_map, use_network

from pianta._types import Floats, Indices, Mask
from pianta.graphs.components import number_components
from pianta.layout import multicut
from pianta.layout.structure import evidence, reconstruct
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import choose_sets

# A decision has the arguments and the result of solve_multicut.
Decision = Callable[[int, Indices, Floats, Mask], Indices]

SCHOOLS = "schools"


def join_pairs_one_by_one(count: int, pairs: Indices, weights: Floats, is_edge: Mask) -> Indices:
    """Join each two pieces that touch and belong together by their own pairs of cells; no other pair counts."""
    return number_components(pairs[is_edge & (weights > 0)], count)


def agglomerate_touching(count: int, pairs: Indices, weights: Floats, is_edge: Mask) -> Indices:
    """Join the two parts that belong together most, again and again, by pieces that touch alone."""
    return agglomerate(count, pairs[is_edge], weights[is_edge], is_edge[is_edge])


def agglomerate(count: int, pairs: Indices, weights: Floats, is_edge: Mask) -> Indices:
    """Join the two parts that belong together most, again and again, by all pairs between them."""
    weight, edges = multicut._list_neighbours(count, pairs, weights, is_edge)
    return np.unique(multicut._contract_greedily(count, weight, edges), return_inverse=True)[1]


def solve_touching(count: int, pairs: Indices, weights: Floats, is_edge: Mask) -> Indices:
    """One decision for the floor, by pieces that touch alone: a multicut without lifted edges."""
    return multicut.solve_multicut(count, pairs[is_edge], weights[is_edge], is_edge[is_edge])


DECISIONS: dict[str, Decision] = {
    "pairs one by one": join_pairs_one_by_one,
    "agglomeration, touching pieces": agglomerate_touching,
    "multicut, touching pieces": solve_touching,
    "agglomeration, all pairs": agglomerate,
    "lifted multicut": multicut.solve_multicut,
}


@dataclass
class SummedDecision:
    """A decision in place of solve_multicut, and the energy of its results so far."""

    decide: Decision
    energy: float = 0.0

    def __call__(self, count: int, pairs: Indices, weights: Floats, is_edge: Mask) -> Indices:
        """The result of the decision."""
        part = self.decide(count, pairs, weights, is_edge)
        self.energy += float(weights[part[pairs[:, 0]] != part[pairs[:, 1]]].sum())
        return part


def main() -> None:
    """Print the scores of each decision on each set."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("networks", type=Path)
    parser.add_argument("--data", type=Path)
    options = parser.parse_args()
    data = find_data(options.data)
    read_own_network = evidence._read_network
    for mapset, items in choose_sets((*SETS, SCHOOLS), data).items():
        summed = {name: SummedDecision(decide) for name, decide in DECISIONS.items()}
        for name, decision in summed.items():
            reconstruct.solve_multicut = decision  # type: ignore[attr-defined]
            rows = []
            for item in items:
                if mapset.name == SCHOOLS:
                    evidence._read_network = read_own_network
                else:
                    use_network(options.networks, item)
                rows.append(score_map(data, mapset, item))
            print_scores(f"{mapset.name}, {name}", rows)
        best = min(decision.energy for decision in summed.values())
        for name, decision in summed.items():
            sys.stdout.write(f"{mapset.name}, {name}: energy {decision.energy - best:.0f} above the best\n")


if __name__ == "__main__":
    main()
