"""The features of NSPDK: pairs of neighbourhoods whose roots are some edges apart, as codes (Costa, De Grave, 2010)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TypeAlias

import numpy as np

from pianta._types import Indices
from pianta.graphs.feature_counts import FeatureCounts, gather_counts
from pianta.graphs.labelled_graphs import LabelledNodes
from pianta.graphs.neighborhoods import hash_neighborhoods
from pianta.graphs.shortest_paths import NearPairs, find_near
from pianta.graphs.stable_hash import Codes, join

# The radius of the neighbourhoods, and the distance of their roots.
Block: TypeAlias = tuple[int, int]


@dataclass(frozen=True, eq=False)
class RootedPairs:
    """Ordered pairs of neighbourhoods of one block, p in number.

    roots, others: the nodes whose neighbourhoods they are, shape (p,). one, other: hashes of these, shape (p,).
    """

    roots: Indices
    others: Indices
    one: Codes
    other: Codes


def list_blocks(radius: int, distance: int) -> list[Block]:
    """All radii 0 … radius with all distances 0 … distance."""
    return [*product(range(radius + 1), range(distance + 1))]


def pair_neighborhoods(graph: LabelledNodes, radius: int, distance: int) -> dict[Block, RootedPairs]:
    """The pairs of neighbourhoods of a graph by block, each pair from both of its roots.

    Parameters
    ----------
    graph : LabelledNodes
        Of any number of parts, which have no pairs in common.
    radius, distance : int
        The largest radius of a neighbourhood, and the largest distance of two roots.

    Returns
    -------
    dict of (radius, distance) to RootedPairs
        By root and then by the other node.

    """
    near = find_near(graph.edges, max(radius, distance))
    hashes = [hash_neighborhoods(graph, near, each) for each in range(radius + 1)]
    apart = [_take_apart(near, each) for each in range(distance + 1)]
    return {
        (size, steps): RootedPairs(*apart[steps], *(hashes[size][nodes] for nodes in apart[steps]))
        for size, steps in list_blocks(radius, distance)
    }


def count_pairs(graphs: Sequence[LabelledNodes], *, radius: int, distance: int) -> list[FeatureCounts]:
    """The pairs of neighbourhoods of graphs, each pair once: a row for each graph, by radius and then distance."""
    found = [list_codes(graph, radius=radius, distance=distance) for graph in graphs]
    blocks = range(len(list_blocks(radius, distance)))
    codes = [[blocks_of_graph[block].codes for blocks_of_graph in found] for block in blocks]
    rows = [[np.full(len(each), row) for row, each in enumerate(of_block)] for of_block in codes]
    return [gather_counts(len(graphs), *parts) for parts in zip(rows, codes, strict=True)]


@dataclass(frozen=True, eq=False)
class NamedPairs:
    """Pairs of neighbourhoods, each once: one of the roots, and the code of the pair, shape (p,) each."""

    roots: Indices
    codes: Codes


def list_codes(graph: LabelledNodes, *, radius: int, distance: int) -> list[NamedPairs]:
    """The pairs of neighbourhoods of a graph, by block; the same pair has one code whichever root comes first."""
    named = []
    for block, pairs in pair_neighborhoods(graph, radius, distance).items():
        once = pairs.roots <= pairs.others
        one, other = pairs.one[once], pairs.other[once]
        named.append(NamedPairs(pairs.roots[once], name_pairs(block, np.minimum(one, other), np.maximum(one, other))))
    return named


def name_pairs(block: Block, one: Codes, other: Codes) -> Codes:
    """The codes of ordered pairs of neighbourhoods, shape (p,), given their hashes."""
    return join(*block, one, other)


def _take_apart(near: NearPairs, steps: int) -> tuple[Indices, Indices]:
    apart = near.steps == steps
    return near.roots[apart], near.nodes[apart]
