"""Weisfeiler-Lehman subtree kernel (thesis, section 7.1; Shervashidze et al., 2011)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import networkx as nx
import numpy as np
from scipy.sparse import csr_array

from pianta.graphs.explicit_kernel import ExplicitKernel, check_numbers
from pianta.graphs.feature_counts import FeatureCounts, gather_counts
from pianta.graphs.labelled_graphs import LabelledGraph, read_labelled_graphs
from pianta.graphs.stable_hash import join, mix


class WeisfeilerLehman(ExplicitKernel):
    """Counts nodes by their label, and by the labels within 1, 2, … `iterations` edges.

    label: the node attribute. normalize: divide by the length of both graphs' counts.
    """

    def __init__(self, *, iterations: int = 5, label: str = "label", normalize: bool = True) -> None:
        self.iterations = iterations
        self.label = label
        self.normalize = normalize

    def count_features(self, graphs: Iterable[nx.Graph]) -> list[FeatureCounts]:
        """Labels of all rounds, the first being the nodes' own, in one block."""
        check_numbers(iterations=self.iterations)
        read = read_labelled_graphs(graphs, node_label=self.label)
        labels = np.concatenate([np.zeros(0, np.uint64), *(graph.labels for graph in read)])
        neighbours = _join_parts(read)
        rounds = [join(0, labels)]
        for iteration in range(1, self.iterations + 1):
            # The new label of a node is a hash of its own and of the multiset of its neighbours'.
            labels = join(iteration, labels, neighbours @ mix(labels))
            rounds.append(labels)
        rows = np.repeat(np.arange(len(read)), [len(graph) for graph in read])
        return [gather_counts(len(read), [rows] * len(rounds), rounds)]


def _join_parts(graphs: Sequence[LabelledGraph]) -> csr_array:
    """The adjacency matrix of all graphs as components of one graph."""
    firsts = np.cumsum([0, *(len(graph) for graph in graphs)])
    pairs = list(zip(graphs, firsts[:-1], strict=True))
    starts = np.concatenate([np.zeros(0, np.intp), *(graph.starts + first for graph, first in pairs)])
    ends = np.concatenate([np.zeros(0, np.intp), *(graph.ends + first for graph, first in pairs)])
    return csr_array((np.ones(len(starts), np.uint64), (starts, ends)), shape=(firsts[-1], firsts[-1]))
