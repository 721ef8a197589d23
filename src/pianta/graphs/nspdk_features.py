"""The features of NSPDK (Costa, De Grave, 2010): pairs of neighbourhoods whose roots are some edges apart, as codes.

Neighbourhoods are compared by hashes: the same for isomorphic ones, and nearly always different for others. This module
works without scikit-learn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TypeAlias

import numpy as np

from pianta._types import Indices
from pianta.graphs.feature_counts import FeatureCounts, gather_counts, mark_changes
from pianta.graphs.labelled_graphs import LabelledNodes
from pianta.graphs.shortest_paths import NearPairs, find_near
from pianta.graphs.stable_hash import Codes, join, mix

# The radius of the neighbourhoods, and the distance of their roots.
Block: TypeAlias = tuple[int, int]


@dataclass(frozen=True, eq=False)
class RootedPairs:
    """Ordered pairs of neighbourhoods of one block, p in number.

    roots, others: the roots of both, shape (p,). one, other: hashes of both, shape (p,).
    """

    roots: Indices
    others: Indices
    one: Codes
    other: Codes


def list_blocks(radius: int, distance: int) -> list[Block]:
    """All radii 0 … radius with all distances 0 … distance."""
    return [*product(range(radius + 1), range(distance + 1))]


def pair_neighborhoods(graph: LabelledNodes, radius: int, distance: int) -> dict[Block, RootedPairs]:
    """The pairs of neighbourhoods of a graph by block, each pair from both of its roots, by root and other root.

    Parts of the graph that are not connected have no pairs in common.
    radius: the largest of a neighbourhood. distance: the largest of two roots.
    """
    near = find_near(graph.edges, max(radius, distance))
    hashes = [hash_neighborhoods(graph, near, each) for each in range(radius + 1)]
    at_distance = [near.steps == each for each in range(distance + 1)]
    roots = [(near.roots[chosen], near.nodes[chosen]) for chosen in at_distance]
    return {
        (size, steps): RootedPairs(*roots[steps], *(hashes[size][nodes] for nodes in roots[steps]))
        for size, steps in list_blocks(radius, distance)
    }


def count_pairs(graphs: Sequence[LabelledNodes], *, radius: int, distance: int) -> list[FeatureCounts]:
    """The pairs of neighbourhoods of graphs, each pair once: a row for each graph, by radius and then distance."""
    coded = [list_codes(graph, radius=radius, distance=distance) for graph in graphs]
    blocks = range(len(list_blocks(radius, distance)))
    codes = [[pairs[block].codes for pairs in coded] for block in blocks]
    rows = [[np.full(len(each), row) for row, each in enumerate(block_codes)] for block_codes in codes]
    return [gather_counts(len(graphs), *parts) for parts in zip(rows, codes, strict=True)]


@dataclass(frozen=True, eq=False)
class CodedPairs:
    """Pairs of neighbourhoods, each once: one of the roots, and the code of the pair, shape (p,) each."""

    roots: Indices
    codes: Codes


def list_codes(graph: LabelledNodes, *, radius: int, distance: int) -> list[CodedPairs]:
    """The pairs of neighbourhoods of a graph, by block; the code does not depend on which root comes first."""
    coded = []
    for block, pairs in pair_neighborhoods(graph, radius, distance).items():
        once = pairs.roots <= pairs.others
        one, other = pairs.one[once], pairs.other[once]
        codes = encode_pairs(block, np.minimum(one, other), np.maximum(one, other))
        coded.append(CodedPairs(pairs.roots[once], codes))
    return coded


def encode_pairs(block: Block, one: Codes, other: Codes) -> Codes:
    """The codes of ordered pairs of neighbourhoods, shape (p,), from their hashes."""
    return join(*block, one, other)


def hash_neighborhoods(graph: LabelledNodes, near: NearPairs, radius: int) -> Codes:
    """Hashes of the subgraphs of all nodes at most `radius` edges from each node, shape (n,).

    near: the pairs of nodes at most `radius` edges apart; others are ignored.

    Colour refinement on each subgraph: the colour of a node begins as its label and its distance from the root, and
    each round adds the colours of its neighbours. After `radius` rounds the colour of the root of a tree depends on the
    whole tree, so different trees have different hashes. With cycles, rounds go on until the number of colours stays
    the same, as an outer ring may be long. Only very regular graphs still collide: a ring of six rooms and two rings of
    three, with doors between neighbours and to a corridor in the middle, the root.
    """
    inside = near.steps <= radius
    around = _find_neighborhoods(graph, near.roots[inside], near.nodes[inside])
    colors = join(near.steps[inside], graph.labels[around.nodes])
    for _ in range(radius):
        colors = _refine(around, colors)
    colors = _refine_to_the_end(around, colors)
    if not len(graph):
        return colors
    return join(radius, np.add.reduceat(mix(colors), np.flatnonzero(np.diff(around.roots, prepend=-1))))


@dataclass(frozen=True, eq=False)
class _Neighborhoods:
    """The neighbourhoods of all n nodes as one graph of n parts, with k members and m edges.

    roots, nodes: the root of the neighbourhood and the node of each member, shape (k,); roots ascend.
    starts, ends: members that an edge joins, shape (2m,), each edge in both directions; starts ascend.
    edge_labels: shape (2m,).
    """

    roots: Indices
    nodes: Indices
    starts: Indices
    ends: Indices
    edge_labels: Codes


def _find_neighborhoods(graph: LabelledNodes, roots: Indices, nodes: Indices) -> _Neighborhoods:
    """roots, nodes: the members, by root and then by node."""
    starts, edges = graph.edges.leave(nodes)
    # The member at the end of each edge, by binary search: (root, node) as one number ascends.
    members, reached = roots * len(graph) + nodes, roots[starts] * len(graph) + graph.ends[edges]
    ends = np.searchsorted(members, reached)
    inside = members[np.minimum(ends, len(members) - 1)] == reached if len(members) else np.zeros(0, bool)
    return _Neighborhoods(roots, nodes, starts[inside], ends[inside], graph.edge_labels[edges[inside]])


def _refine(around: _Neighborhoods, colors: Codes) -> Codes:
    """One round: a member's new colour depends on its own, and on the multiset of neighbours' and edges' colours."""
    messages = np.zeros(len(colors), np.uint64)
    if len(around.starts):
        first = np.flatnonzero(np.diff(around.starts, prepend=-1))
        messages[around.starts[first]] = np.add.reduceat(join(around.edge_labels, colors[around.ends]), first)
    return join(colors, messages)


def _refine_to_the_end(around: _Neighborhoods, colors: Codes) -> Codes:
    """Rounds for neighbourhoods with cycles, each until its number of colours stays the same.

    The last round of a neighbourhood depends only on itself, so isomorphic ones stop at the same round.
    """
    members = np.bincount(around.roots)
    edges = np.bincount(around.roots[around.starts], minlength=len(members)) // 2
    is_active = edges >= members
    counts = _count_colors(around.roots, colors)
    while is_active.any():
        colors = np.where(is_active[around.roots], _refine(around, colors), colors)
        before, counts = counts, _count_colors(around.roots, colors)
        is_active &= counts > before
    return colors


def _count_colors(roots: Indices, colors: Codes) -> Indices:
    """The number of colours in each neighbourhood, shape (n,)."""
    order = np.lexsort((colors, roots))
    roots, colors = roots[order], colors[order]
    return np.bincount(roots[mark_changes(roots, colors)])
