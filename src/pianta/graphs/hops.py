"""How often a node is where on the shortest paths of a graph, for Graph Hopper kernels (Feragen et al., 2013)."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from pianta._types import Floats, Indices
from pianta.graphs.labelled_graphs import LabelledGraph


def count_hops(graph: LabelledGraph, groups: Indices) -> Floats:
    """Σ M_v(l, i) over the nodes v of each group, shape (longest + 1, longest + 1, groups), by l - i, then i.

    M_v(l, i) is the number of shortest paths of l edges that have v in place i = 0 … l; a path counts from both of its
    ends, so l - i and i may be swapped. `longest` is the longest of these paths.
    groups: the group of each node, 0 … k - 1, shape (n,).
    """
    reach = graph.distances.ravel()
    inside = np.isfinite(reach)
    longest = int(reach[inside].max(initial=0))
    k = int(groups.max(initial=-1)) + 1
    bins = reach[inside].astype(np.intp) * k + np.tile(groups, len(graph))[inside]
    onward = _step_onward(graph)
    paths = _count_paths(onward, len(graph), longest)
    hops = np.zeros((longest + 1, longest + 1, k))
    # Paths from a start to a node, times the ways on from there that are `further` edges long.
    ways = np.ones(len(reach))
    for further in range(longest + 1):
        if further:
            ways = onward @ ways
        counts = np.bincount(bins, weights=(paths * ways)[inside], minlength=hops[further].size)
        hops[further] = counts.reshape(longest + 1, k)
    return hops


def _step_onward(graph: LabelledGraph) -> csr_array:
    """From (start, node) to (start, next node) wherever a shortest path goes on, shape (n², n²)."""
    n = len(graph)
    here, there = graph.distances[:, graph.starts], graph.distances[:, graph.ends]
    start, edge = np.nonzero((there == here + 1) & np.isfinite(here))
    pairs = start * n + graph.starts[edge], start * n + graph.ends[edge]
    return csr_array((np.ones(len(start)), pairs), shape=(n * n, n * n))


def _count_paths(onward: csr_array, n: int, longest: int) -> Floats:
    """The number of shortest paths from each start to each node, shape (n²,)."""
    reached = np.eye(n).ravel()
    paths = reached
    for _ in range(longest):
        reached = onward.T @ reached
        paths = paths + reached
    return paths
