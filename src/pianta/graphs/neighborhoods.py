"""Hashes of the neighbourhoods of nodes: the same for isomorphic ones, and nearly always another for others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pianta._types import Indices
from pianta.graphs.labelled_graphs import LabelledNodes
from pianta.graphs.shortest_paths import NearPairs
from pianta.graphs.stable_hash import Codes, join, mix


def hash_neighborhoods(graph: LabelledNodes, near: NearPairs, radius: int) -> Codes:
    """Hashes of the subgraphs of all nodes at most `radius` edges from each node, shape (n,).

    near: the pairs of nodes at most `radius` edges apart, or more of them.

    Colour refinement on each subgraph: a node starts with its label and its distance from the root, and takes in the
    colours of its neighbours, round by round. After `radius` rounds the root of a tree has taken in the whole tree, so
    trees are told from all others. Where there are cycles rounds go on until one tells no more nodes apart, for what
    lies along an outer ring may be far. What is not told apart then is as regular as a ring of six rooms and two rings
    of three, each with doors between neighbours and to a corridor in the middle, the root.
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

    roots, nodes: shape (k,): whose neighbourhood it is, and which node is in it; roots ascend.
    starts, ends: places of members, shape (2m,): each edge from both of its ends; starts ascend.
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
    # Where an edge leads to the same neighbourhood: pairs as numbers, which ascend.
    members, reached = roots * len(graph) + nodes, roots[starts] * len(graph) + graph.ends[edges]
    ends = np.searchsorted(members, reached)
    inside = members[np.minimum(ends, len(members) - 1)] == reached if len(members) else np.zeros(0, bool)
    return _Neighborhoods(roots, nodes, starts[inside], ends[inside], graph.edge_labels[edges[inside]])


def _refine(around: _Neighborhoods, colors: Codes) -> Codes:
    """One round: the new colour of a member is its own, with the multiset of its neighbours' and the edges to them."""
    messages = np.zeros(len(colors), np.uint64)
    if len(around.starts):
        first = np.flatnonzero(np.diff(around.starts, prepend=-1))
        messages[around.starts[first]] = np.add.reduceat(join(around.edge_labels, colors[around.ends]), first)
    return join(colors, messages)


def _refine_to_the_end(around: _Neighborhoods, colors: Codes) -> Codes:
    """Rounds for the neighbourhoods with cycles, each until its number of colours stays as it is.

    When a neighbourhood stops depends on nothing but itself, so that isomorphic ones stop at the same round.
    """
    members = np.bincount(around.roots)
    edges = np.bincount(around.roots[around.starts], minlength=len(members)) // 2
    going = edges >= members
    told = _count_colors(around.roots, colors)
    while going.any():
        colors = np.where(going[around.roots], _refine(around, colors), colors)
        before, told = told, _count_colors(around.roots, colors)
        going &= told > before
    return colors


def _count_colors(roots: Indices, colors: Codes) -> Indices:
    """The number of colours in each neighbourhood, shape (n,)."""
    order = np.lexsort((colors, roots))
    roots, colors = roots[order], colors[order]
    new = np.ones(len(roots), bool)
    new[1:] = (roots[1:] != roots[:-1]) | (colors[1:] != colors[:-1])
    return np.bincount(roots[new])
