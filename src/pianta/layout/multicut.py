"""Lifted multicut: the partition of a graph's nodes whose joined pairs have the largest sum of weights.

minimise the sum of the weights of all pairs in two parts, where each part is connected by edges; weights are positive
between nodes that belong together and negative between others. Further pairs without an edge have weights too (Keuper
et al., Efficient decomposition of image and mesh graphs by lifted multicuts, ICCV 2015). The problem is NP-hard: the
greedy additive contraction of that paper gives a solution, and moves of single nodes and joins of parts improve it
(after Kernighan and Lin, 1970).
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable

import numpy as np

from pianta._types import Floats, Indices, Mask

# Rounds of moves over all nodes, at most (chosen by hand; two or three change anything).
MAX_ROUNDS = 10
# A change counts if it gains more than this, so that rounding errors do not.
MIN_GAIN = 1e-9

Neighbours = list[dict[int, float]]


def solve_multicut(count: int, pairs: Indices, weights: Floats, is_edge: Mask) -> Indices:
    """Part of each node, shape (count,), numbered from 0 in the order of their first nodes.

    pairs: shape (P, 2), different nodes, each pair once. weights: shape (P,). is_edge: shape (P,), whether the pair
    is an edge, along which a part may be connected.
    """
    weight, edges = _list_neighbours(count, pairs, weights, is_edge)
    part = _contract_greedily(count, weight, edges)
    part = _improve(part, weight, edges)
    return np.unique(part, return_inverse=True)[1]


def _list_neighbours(count: int, pairs: Indices, weights: Floats, is_edge: Mask) -> tuple[Neighbours, list[set[int]]]:
    """The weight of each node to others, and the nodes that it has an edge to."""
    weight: Neighbours = [{} for _ in range(count)]
    edges: list[set[int]] = [set() for _ in range(count)]
    for (one, other), value, edge in zip(pairs.tolist(), weights.tolist(), is_edge.tolist(), strict=True):
        weight[one][other] = weight[other][one] = weight[one].get(other, 0.0) + value
        if edge:
            edges[one].add(other)
            edges[other].add(one)
    return weight, edges


def _contract_greedily(count: int, weights: Neighbours, all_edges: list[set[int]]) -> Indices:
    """Join the edge of the largest weight, again and again, while it is positive; the part of each node."""
    weight, edges = [dict(row) for row in weights], [set(row) for row in all_edges]
    owner = np.arange(count)
    members = {node: [node] for node in range(count)}
    heap = [(-weight[one].get(other, 0.0), one, other) for one in range(count) for other in edges[one] if one < other]
    heapq.heapify(heap)
    while heap:
        negative, one, other = heapq.heappop(heap)
        if -negative <= MIN_GAIN:
            break
        if one not in members or other not in members or weight[one].get(other) != -negative:
            continue
        members[one] += members.pop(other)
        for node, value in weight[other].items():
            if node != one:
                weight[one][node] = weight[node][one] = weight[one].get(node, 0.0) + value
                del weight[node][other]
        del weight[one][other]
        for node in edges[other] - {one}:
            edges[one].add(node)
            edges[node].add(one)
            edges[node].discard(other)
        edges[one].discard(other)
        for node in edges[one]:
            heapq.heappush(heap, (-weight[one].get(node, 0.0), min(one, node), max(one, node)))
    for root, nodes in members.items():
        owner[nodes] = root
    return owner


def _improve(part: Indices, weight: Neighbours, edges: list[set[int]]) -> Indices:
    """Move nodes to other parts, or to parts of their own, and join parts, while this lowers the sum."""
    part = part.copy()
    members: dict[int, set[int]] = {}
    for node, root in enumerate(part.tolist()):
        members.setdefault(root, set()).add(node)
    next_part = len(part)
    for _ in range(MAX_ROUNDS):
        gained = False
        for node in range(len(part)):
            own = int(part[node])
            pull: dict[int, float] = {}
            for other, value in weight[node].items():
                pull[int(part[other])] = pull.get(int(part[other]), 0.0) + value
            stay = pull.get(own, 0.0)
            reachable = {int(part[other]) for other in edges[node]} - {own}
            choices = [(pull.get(root, 0.0), root) for root in sorted(reachable)]
            if len(members[own]) > 1:
                choices.append((0.0, next_part))
            best, root = max(choices, key=lambda choice: (choice[0], -choice[1]), default=(0.0, own))
            if best > stay + MIN_GAIN and _is_connected(members[own] - {node}, edges):
                members[own].discard(node)
                if not members[own]:
                    del members[own]
                members.setdefault(root, set()).add(node)
                part[node] = root
                next_part = max(next_part, root + 1)
                gained = True
        gained |= _join_parts(part, members, weight, edges)
        if not gained:
            break
    # Number the parts by their first nodes
    _, first, index = np.unique(part, return_index=True, return_inverse=True)
    rank = np.empty(len(first), np.intp)
    rank[np.argsort(first)] = np.arange(len(first))
    return np.asarray(rank[index])


def _join_parts(part: Indices, members: dict[int, set[int]], weight: Neighbours, edges: list[set[int]]) -> bool:
    """Join two or three parts that are connected and have a positive sum of weights, in place; whether there were any.

    Three parts may gain where no two of them do: the middle one may belong to both others, or only connect them.
    """
    gained = False
    for root in sorted(members):
        while root in members:
            pull, adjacent = _pull_parts(root, part, members, weight, edges)
            choices: list[tuple[float, int, tuple[int, ...]]] = [
                (pull.get(other, 0.0), -other, (other,)) for other in adjacent
            ]
            for other in adjacent:
                other_pull, further = _pull_parts(other, part, members, weight, edges)
                choices += [
                    (pull.get(other, 0.0) + pull.get(third, 0.0) + other_pull.get(third, 0.0), -other, (other, third))
                    for third in further - {root}
                ]
            best, _, joined = max(choices, default=(0.0, 0, ()))
            if best <= MIN_GAIN:
                break
            for other in joined:
                nodes = members.pop(other)
                part[list(nodes)] = root
                members[root] |= nodes
            gained = True
    return gained


def _pull_parts(
    root: int, part: Indices, members: dict[int, set[int]], weight: Neighbours, edges: list[set[int]]
) -> tuple[dict[int, float], set[int]]:
    """The sum of the weights between a part and each other one, and the parts that it has an edge to."""
    pull: dict[int, float] = {}
    adjacent: set[int] = set()
    for node in members[root]:
        adjacent |= {int(part[other]) for other in edges[node]}
        for other, value in weight[node].items():
            pull[int(part[other])] = pull.get(int(part[other]), 0.0) + value
    return pull, adjacent - {root}


def _is_connected(nodes: Iterable[int], edges: list[set[int]]) -> bool:
    """Whether nodes are connected by edges among themselves; no node is connected as well."""
    rest = set(nodes)
    queue = [rest.pop()] if rest else []
    while queue:
        reached = edges[queue.pop()] & rest
        rest -= reached
        queue += reached
    return not rest
