"""Steps 2 and 4 with the Graph Hopper kernel, the second row of Table 7.2: rows of its Gram matrix of changing graphs.

A changed edge moves shortest paths anywhere in its graph, so the row of a changed graph is computed again as a whole.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import networkx as nx
import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.generation.incremental_gram import sum_distances


class HopperReferences:
    """The fixed graphs, with a `label` at each node; stands for ReferenceGraphs."""

    def __init__(self, graphs: Iterable[nx.Graph]) -> None:
        from pianta.graphs.graph_hopper import GraphHopper

        self.kernel = GraphHopper().fit(graphs)

    def start(self, graphs: Sequence[nx.Graph]) -> HopperGram:
        """The rows of graphs whose edges can change."""
        return HopperGram(self, graphs)


class HopperGram:
    """b graphs of up to n nodes each, whose edges can change, and their rows of the Gram matrix, as in IncrementalGram.

    adjacency: shape (b, n, n). present: shape (b, n), whether the node exists; the others have no edges.
    """

    def __init__(self, references: HopperReferences, graphs: Sequence[nx.Graph]) -> None:
        self._kernel = references.kernel
        self._labels = [[str(label) for _, label in graph.nodes(data="label")] for graph in graphs]
        sizes = [len(graph) for graph in graphs]
        most = max(sizes, default=0)
        self.present = np.arange(most) < np.array(sizes, int).reshape(-1, 1)
        self.adjacency = np.zeros((len(graphs), most, most), bool)
        for number, graph in enumerate(graphs):
            self.adjacency[number, : len(graph), : len(graph)] = nx.to_numpy_array(graph, weight=None, dtype=bool)
        # Of each graph its rows by edges, as it is now and as it was before: a rejected move needs no new row.
        self._rows: list[dict[bytes, Floats]] = [{} for _ in graphs]

    def change_edges(self, batch: Indices, ones: Indices, others: Indices, *, present: bool | Mask) -> None:
        """Add edges, or remove them where `present` is False.

        batch, ones, others: the graph and the two nodes of each edge, shape (k,) each.
        """
        self.adjacency[batch, ones, others] = self.adjacency[batch, others, ones] = present

    def measure_similarity(self) -> Floats:
        """Rows of the normalised Gram matrix, shape (b, references)."""
        keys = [adjacency.tobytes() for adjacency in self.adjacency]
        new = [number for number, key in enumerate(keys) if key not in self._rows[number]]
        if new:
            rows = self._kernel.compare([self._build(number) for number in new])
            for number, row in zip(new, rows, strict=True):
                last = [*self._rows[number].items()][-1:]
                self._rows[number] = {**dict(last), keys[number]: row}
        for number, key in enumerate(keys):
            # The current row is the last one.
            self._rows[number][key] = self._rows[number].pop(key)
        return np.array([rows[key] for rows, key in zip(self._rows, keys, strict=True)])

    def measure_costs(self) -> Floats:
        """Γ2 and Γ4 times α, shape (b,), as in IncrementalGram."""
        return sum_distances(self.measure_similarity())

    def _build(self, number: int) -> nx.Graph:
        """A graph as it is now."""
        labels = self._labels[number]
        graph: nx.Graph = nx.from_numpy_array(self.adjacency[number, : len(labels), : len(labels)], edge_attr=None)
        nx.set_node_attributes(graph, dict(enumerate(labels)), "label")
        return graph
