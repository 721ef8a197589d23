"""Graph Hopper kernels: hops along shortest paths meet on similar nodes (thesis, section 7.1; Feragen et al., 2013).

K(G, G') = Σ_v Σ_v' k(v, v') Σ_l Σ_i M_v(l, i) M_v'(l, i), where M_v(l, i) is the number of shortest paths of l edges
with v at position i. A path counts in both directions, and a node is a path without edges.
"""

from __future__ import annotations

from collections.abc import Iterable

import networkx as nx
import numpy as np
from scipy.sparse import csr_array

from pianta._types import Floats, Indices
from pianta.graphs.explicit_kernel import ExplicitKernel
from pianta.graphs.feature_counts import FeatureCounts, gather_counts
from pianta.graphs.labelled_graphs import LabelledGraph, read_labelled_graphs
from pianta.graphs.stable_hash import Codes, join


class GraphHopper(ExplicitKernel):
    """Graph Hopper with the node kernel of section 7.1: 1 for two nodes of the same label, 0 for others.

    A feature is a label at a position of a shortest path of some length.

    label: the node attribute. normalize: divide by the length of both graphs' counts.
    """

    def __init__(self, *, label: str = "label", normalize: bool = True) -> None:
        self.label = label
        self.normalize = normalize

    def count_features(self, graphs: Iterable[nx.Graph]) -> list[FeatureCounts]:
        """Labels at positions of shortest paths, in one block."""
        read = read_labelled_graphs(graphs, node_label=self.label)
        counted = [_count_labels(graph) for graph in read]
        rows = [np.full(len(codes), row) for row, (codes, _) in enumerate(counted)]
        return [gather_counts(len(read), rows, [codes for codes, _ in counted], [counts for _, counts in counted])]


def _count_labels(graph: LabelledGraph) -> tuple[Codes, Floats]:
    """Codes of length, position and label, and the number of paths with each, shape (k,) each."""
    labels, groups = np.unique(graph.labels, return_inverse=True)
    hops = count_hops(graph, groups)
    nonzero = further, positions, label_indices = np.nonzero(hops)
    return join(further + positions, positions, labels[label_indices]), hops[nonzero]


def count_hops(graph: LabelledGraph, groups: Indices) -> Floats:
    """Σ M_v(l, i) over the nodes v of each group, shape (longest + 1, longest + 1, groups), by l - i, then i.

    M_v(l, i) is the number of shortest paths of l edges with v at position i = 0 … l; as a path counts in both
    directions, l - i and i may be swapped. `longest` is the length of the longest of these paths.
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
    # Paths from a start to a node, times their continuations that are `further` edges long.
    ways = np.ones(len(reach))
    for further in range(longest + 1):
        if further:
            ways = onward @ ways
        counts = np.bincount(bins, weights=(paths * ways)[inside], minlength=hops[further].size)
        hops[further] = counts.reshape(longest + 1, k)
    return hops


def _step_onward(graph: LabelledGraph) -> csr_array:
    """Steps from (start, node) to (start, next node) along all shortest paths, shape (n², n²)."""
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
