"""Lifted multicut: partitions with known sums, brute force on small graphs, and invariants."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.layout.multicut import solve_multicut


def solve(count: int, weighted: Sequence[tuple[float, ...]]) -> tuple[Indices, Indices, Floats, Mask]:
    """Solve for (one, other, weight) edges, and (one, other, weight, False) pairs without an edge."""
    pairs = np.array([row[:2] for row in weighted], int).reshape(-1, 2)
    weights = np.array([row[2] for row in weighted], float)
    is_edge = np.array([row[3] if len(row) > 3 else True for row in weighted], bool)
    return solve_multicut(count, pairs, weights, is_edge), pairs, weights, is_edge


def measure_cut(part: Indices, pairs: Indices, weights: Floats) -> float:
    """Sum of the weights of pairs in two parts, which a multicut minimises."""
    return float(weights[part[pairs[:, 0]] != part[pairs[:, 1]]].sum())


def is_feasible(part: Indices, pairs: Indices, is_edge: Mask) -> bool:
    """Whether each part is connected by edges."""
    for name in set(part.tolist()):
        nodes = set(np.flatnonzero(part == name).tolist())
        reached, queue = set(), [min(nodes)]
        while queue:
            node = queue.pop()
            reached.add(node)
            for one, other in pairs[is_edge].tolist():
                for a, b in ((one, other), (other, one)):
                    if a == node and b in nodes and b not in reached:
                        queue.append(b)
        if reached != nodes:
            return False
    return True


def test_positive_edges_join_and_negative_edges_divide():
    part, *_ = solve(4, [(0, 1, 2.0), (1, 2, -1.0), (2, 3, 3.0)])
    assert part.tolist() == [0, 0, 1, 1]


def test_a_weak_positive_edge_is_cut_where_the_others_are_against_it():
    # Joined, the triangle gains 1 + 1 - 3 = -1; the best partition keeps one positive edge
    part, pairs, weights, _ = solve(3, [(0, 1, 1.0), (1, 2, 1.0), (0, 2, -3.0)])
    assert measure_cut(part, pairs, weights) == -2.0


def test_a_pair_without_an_edge_counts_but_joins_nothing():
    # 0 and 2 belong together by 5, and are connected through 1 only
    part, *_ = solve(3, [(0, 1, -1.0), (1, 2, -1.0), (0, 2, 5.0, False)])
    assert part.tolist() == [0, 0, 0]
    part, *_ = solve(3, [(0, 1, -3.0), (1, 2, -3.0), (0, 2, 5.0, False)])
    assert len(set(part.tolist())) == 3
    part, *_ = solve(2, [(0, 1, 5.0, False)])
    assert part.tolist() == [0, 1]


def test_no_node_and_no_edge():
    assert solve(0, [])[0].tolist() == []
    assert solve(3, [])[0].tolist() == [0, 1, 2]


def test_parts_are_numbered_by_their_first_nodes():
    part, *_ = solve(4, [(0, 3, 1.0), (1, 2, 1.0)])
    assert part.tolist() == [0, 1, 1, 0]


def list_partitions(count: int) -> list[Indices]:
    """All partitions of nodes, each as the part of each node: every node is in an earlier part or starts the next."""
    partitions = [[0]]
    for _ in range(count - 1):
        partitions = [[*names, part] for names in partitions for part in range(max(names) + 2)]
    return [np.array(names) for names in partitions]


def test_partitions_are_as_many_as_bell_numbers():
    assert [len(list_partitions(count)) for count in (1, 2, 3, 6)] == [1, 2, 5, 203]


def test_small_graphs_are_solved_as_well_as_by_brute_force():
    partitions, gaps = list_partitions(6), []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        pairs = np.array([(i, j) for i in range(6) for j in range(i + 1, 6) if rng.random() < 0.7])
        weights = rng.normal(0.2, 1, len(pairs)).round(2)
        is_edge = rng.random(len(pairs)) < 0.7
        part = solve_multicut(6, pairs, weights, is_edge)
        assert is_feasible(part, pairs, is_edge)
        best = min(measure_cut(names, pairs, weights) for names in partitions if is_feasible(names, pairs, is_edge))
        gaps.append(measure_cut(part, pairs, weights) - best)
    assert min(gaps) > -1e-9
    # Local search need not be exact; on these graphs it is
    assert max(gaps) < 1e-9
