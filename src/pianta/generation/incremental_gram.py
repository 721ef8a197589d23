"""Rows of the Weisfeiler-Lehman Gram matrix of many changing graphs against fixed ones, updated edge by edge.

In round r + 1, an edge changes the labels of nodes within r hops of its ends only, so only these are hashed again, in
all graphs at once. The numbers equal those of `pianta.graphs.weisfeiler_lehman` exactly.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import networkx as nx
import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.graphs.stable_hash import Codes, hash_name, join, mix

# α of Γ2 and Γ4, and the authors' number of floors (thesis, section 7.4; method-notes.md).
ALPHA = 1.0
PUBLISHED_FLOORS = 50


class ReferenceGraphs:
    """The fixed graphs, as counts of the features of the kernel.

    graphs: with a `label` at each node. iterations: rounds after round 0, that of the labels themselves.
    """

    def __init__(self, graphs: Iterable[nx.Graph], *, iterations: int = 5) -> None:
        from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

        self.iterations = iterations
        (counts,) = WeisfeilerLehman(iterations=iterations).count_features(graphs)
        self.codes, columns = np.unique(counts.codes, return_inverse=True)
        # The last row is for features that no reference has.
        self.counts = np.zeros((len(self.codes) + 1, counts.n))
        np.add.at(self.counts, (columns, counts.rows), counts.counts)
        self.squares = (self.counts**2).sum(axis=0)

    def __len__(self) -> int:
        return self.counts.shape[1]

    def start(self, graphs: Sequence[nx.Graph]) -> IncrementalGram:
        """The rows of graphs whose edges can change."""
        return IncrementalGram(self, graphs)

    def find_rows(self, codes: Codes) -> Indices:
        """The row of `counts` of each feature, shape of the codes."""
        rows = np.searchsorted(self.codes, codes)
        exists = self.codes[np.minimum(rows, len(self.codes) - 1)] == codes
        return np.where(exists, rows, len(self.codes))


class IncrementalGram:
    """b graphs of up to n nodes each, whose edges can change, and their rows of the Gram matrix.

    adjacency: shape (b, n, n). present: shape (b, n), whether the node exists; the others have no edges.
    products: shape (b, references), the kernel before normalisation. squares: shape (b,), of a graph with itself.
    """

    def __init__(self, references: ReferenceGraphs, graphs: Sequence[nx.Graph]) -> None:
        sizes = [len(graph) for graph in graphs]
        shape = len(graphs), max(sizes, default=0)
        self.references = references
        self.present = np.arange(shape[1]) < np.array(sizes, int).reshape(-1, 1)
        self.adjacency = np.zeros((*shape, shape[1]), bool)
        names = np.zeros(shape, np.uint64)
        for number, graph in enumerate(graphs):
            size = sizes[number]
            self.adjacency[number, :size, :size] = nx.to_numpy_array(graph, weight=None, dtype=bool)
            names[number, :size] = [hash_name(str(label)) for _, label in graph.nodes(data="label")]
        rounds = references.iterations + 1
        # In round 0 a feature is a label, and the next round hashes the label itself.
        self._codes = np.zeros((rounds, *shape), np.uint64)
        self._codes[0] = names
        self._mixed = mix(self._codes)
        self._features = np.zeros((*shape, rounds), np.uint64)
        self._features[:, :, 0] = join(0, names.ravel()).reshape(shape)
        self._rows = np.full((*shape, rounds), len(references.codes), np.intp)
        self._rows[:, :, 0] = references.find_rows(self._features[:, :, 0])
        self._rows[~self.present] = len(references.codes)
        self.products = references.counts[self._rows[:, :, 0]].sum(axis=1)
        self.squares = np.zeros(shape[0])
        self._hash_again(self.present)
        self.squares = self._square(np.arange(shape[0]))

    def measure_similarity(self) -> Floats:
        """Rows of the normalised Gram matrix, shape (b, references)."""
        lengths = np.sqrt(np.outer(self.squares, self.references.squares))
        similarity: Floats = self.products / lengths
        return similarity

    def measure_costs(self) -> Floats:
        """Γ2 and Γ4 times α, shape (b,)."""
        return sum_distances(self.measure_similarity())

    def change_edges(self, batch: Indices, ones: Indices, others: Indices, *, present: bool | Mask) -> None:
        """Add edges, or remove them where `present` is False, and update the rows.

        batch, ones, others: the graph and the two nodes of each edge, shape (k,) each.
        """
        if not len(batch):
            return
        self.adjacency[batch, ones, others] = self.adjacency[batch, others, ones] = present
        changed = np.zeros(self.present.shape, bool)
        changed[batch, ones] = changed[batch, others] = True
        self._hash_again(changed)
        graphs = np.unique(batch)
        self.squares[graphs] = self._square(graphs)

    def _hash_again(self, changed: Mask) -> None:
        """Hash the nodes that changed in round 1, and in each further round their neighbours as well."""
        for iteration in range(1, self.references.iterations + 1):
            if iteration > 1:
                graphs, nodes = np.nonzero(changed)
                reached, neighbours = np.nonzero(self.adjacency[graphs, nodes])
                changed = changed.copy()
                changed[graphs[reached], neighbours] = True
            graphs, nodes = np.nonzero(changed)
            if not len(graphs):
                return
            around = np.where(self.adjacency[graphs, nodes], self._mixed[iteration - 1, graphs], np.uint64(0)).sum(
                axis=1
            )
            codes = join(iteration, self._codes[iteration - 1, graphs, nodes], around)
            self._codes[iteration, graphs, nodes] = codes
            self._mixed[iteration, graphs, nodes] = mix(codes)
            self._features[graphs, nodes, iteration] = codes
            rows = self.references.find_rows(codes)
            gain = self.references.counts[rows] - self.references.counts[self._rows[graphs, nodes, iteration]]
            self._rows[graphs, nodes, iteration] = rows
            firsts = np.flatnonzero(np.diff(graphs, prepend=-1))
            self.products[graphs[firsts]] += np.add.reduceat(gain, firsts, axis=0)

    def _square(self, graphs: Indices) -> Floats:
        """Sums of the squared counts of all features of graphs."""
        features = self._features[graphs]
        # Features of absent nodes get distinct codes, each of which adds 1, subtracted below.
        absent = ~self.present[graphs]
        fillers = np.arange(features[0].size, dtype=np.uint64).reshape(features.shape[1:])
        features = np.where(absent[:, :, None], fillers, features).reshape(len(graphs), -1)
        ordered = np.sort(features, axis=1)
        starts = np.ones(ordered.shape, bool)
        starts[:, 1:] = ordered[:, 1:] != ordered[:, :-1]
        firsts = np.flatnonzero(starts)
        lengths = np.diff(firsts, append=starts.size).astype(np.float64)
        squares = np.bincount(firsts // ordered.shape[1], lengths**2, minlength=len(graphs))
        return np.asarray(squares - absent.sum(axis=1) * (self.references.iterations + 1))


def sum_distances(similarity: Floats) -> Floats:
    """Γ2 and Γ4 times α, shape (b,): mean distances sqrt(2 - 2 K) from the references, times 50.

    The thesis sums similarities, but a cost must fall as similarity rises (method-notes.md). The mean, times 50,
    makes α independent of the number of floors.
    similarity: K, the normalised kernel, shape (b, references).
    """
    distances = np.sqrt(np.maximum(2 - 2 * similarity, 0))
    costs: Floats = ALPHA * PUBLISHED_FLOORS * distances.mean(axis=1)
    return costs
