"""Graph Hopper kernel: two hops along shortest paths meet on alike nodes (thesis, section 7.1; Feragen et al., 2013).

K(G, G') = Σ_v Σ_v' k(v, v') Σ_l Σ_i M_v(l, i) M_v'(l, i), where M_v(l, i) is the number of shortest paths of l edges
that have v in place i. A path counts from both of its ends, and a node is a path of no edges.
"""

from __future__ import annotations

from collections.abc import Iterable

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.graphs.explicit_kernel import ExplicitKernel
from pianta.graphs.feature_counts import FeatureCounts, gather_counts
from pianta.graphs.hops import count_hops
from pianta.graphs.labelled_graphs import LabelledGraph, read_labelled_graphs
from pianta.graphs.stable_hash import Codes, join


class GraphHopper(ExplicitKernel):
    """Graph Hopper with the node kernel of section 7.1: 1 for two nodes of the same label, 0 for others.

    Its features are the numbers of times that shortest paths of a length have a label in a place.

    label: the node attribute. normalize: divide by the length of both graphs' counts.
    """

    def __init__(self, *, label: str = "label", normalize: bool = True) -> None:
        self.label = label
        self.normalize = normalize

    def count_features(self, graphs: Iterable[nx.Graph]) -> list[FeatureCounts]:
        """Labels in places of shortest paths, in one block."""
        read = read_labelled_graphs(graphs, node_label=self.label)
        counted = [_count_labels(graph) for graph in read]
        rows = [np.full(len(codes), row) for row, (codes, _) in enumerate(counted)]
        return [gather_counts(len(read), rows, [codes for codes, _ in counted], [counts for _, counts in counted])]


def _count_labels(graph: LabelledGraph) -> tuple[Codes, Floats]:
    """Codes of length, place and label, and how many paths have them, shape (k,) each."""
    labels, groups = np.unique(graph.labels, return_inverse=True)
    hops = count_hops(graph, groups)
    found = further, places, of_group = np.nonzero(hops)
    return join(further + places, places, labels[of_group]), hops[found]
