"""NSPDK, the Neighborhood Subgraph Pairwise Distance Kernel of kLog (thesis, section 6.1.2; Costa, De Grave, 2010)."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from itertools import product

import networkx as nx
import numpy as np

from pianta.errors import GraphError
from pianta.graphs.explicit_kernel import ExplicitKernel, FeatureCounts, check_numbers, gather_counts
from pianta.graphs.labelled_graphs import Indices, LabelledGraph, name_some, read_labelled_graphs
from pianta.graphs.neighborhoods import hash_neighborhoods
from pianta.graphs.stable_hash import Codes, join
from pianta.io._faults import join_faults


class NeighborhoodPairs(ExplicitKernel):
    """NSPDK: counts pairs of neighbourhoods of radius 0 … `radius` whose roots are 0 … `distance` edges apart.

    Two pairs are the same feature where their neighbourhoods are isomorphic, as far as `hash_neighborhoods` tells. Each
    radius with each distance is a block; normalised, all blocks count the same, as in the paper.

    label: the node attribute. edge_label: an edge attribute, unless all edges are alike.
    """

    def __init__(
        self,
        *,
        radius: int = 2,
        distance: int = 3,
        label: str = "label",
        edge_label: str | None = None,
        normalize: bool = True,
    ) -> None:
        self.radius = radius
        self.distance = distance
        self.label = label
        self.edge_label = edge_label
        self.normalize = normalize

    def count_features(self, graphs: Iterable[nx.Graph]) -> list[FeatureCounts]:
        """Pairs of neighbourhoods, each pair once, by radius and then distance of the block."""
        found = self._open_blocks()
        read = self._read(graphs)
        for row, graph in enumerate(read):
            hashes = self._hash(graph)
            pairs = [np.nonzero(np.triu(graph.distances == distance)) for distance in range(self.distance + 1)]
            for (radius, distance), (rows, codes) in found.items():
                one, other = (hashes[radius][roots] for roots in pairs[distance])
                rows.append(np.full(len(one), row))
                codes.append(join(radius, distance, np.minimum(one, other), np.maximum(one, other)))
        return [gather_counts(len(read), rows, codes) for rows, codes in found.values()]

    def count_rooted_features(
        self, graphs: Iterable[nx.Graph], roots: Sequence[Sequence[Hashable]]
    ) -> list[FeatureCounts]:
        """The pairs that one node is in, in blocks like those of `count_features`, the node's neighbourhood first.

        roots: of each graph the nodes that get a row; those of the first graph come first, in the order given.
        Raises GraphError as `count_features` does, and for roots that are no nodes.
        """
        found = self._open_blocks()
        first_row = 0
        for graph, places in _find_roots(self._read(graphs), roots):
            hashes = self._hash(graph)
            pairs = [np.nonzero(graph.distances[places] == distance) for distance in range(self.distance + 1)]
            for (radius, distance), (rows, codes) in found.items():
                which, others = pairs[distance]
                rows.append(first_row + which)
                codes.append(join(radius, distance, hashes[radius][places[which]], hashes[radius][others]))
            first_row += len(places)
        return [gather_counts(first_row, rows, codes) for rows, codes in found.values()]

    def _open_blocks(self) -> dict[tuple[int, int], tuple[list[Indices], list[Codes]]]:
        """Rows and codes by radius and distance."""
        check_numbers(radius=self.radius, distance=self.distance)
        return {block: ([], []) for block in product(range(self.radius + 1), range(self.distance + 1))}

    def _read(self, graphs: Iterable[nx.Graph]) -> list[LabelledGraph]:
        return read_labelled_graphs(graphs, node_label=self.label, edge_label=self.edge_label)

    def _hash(self, graph: LabelledGraph) -> list[Codes]:
        """The hashes of all neighbourhoods, by radius."""
        return [hash_neighborhoods(graph, radius) for radius in range(self.radius + 1)]


def _find_roots(
    graphs: Sequence[LabelledGraph], roots: Sequence[Sequence[Hashable]]
) -> list[tuple[LabelledGraph, Indices]]:
    """Each graph with the places of its roots."""
    if len(roots) != len(graphs):
        raise GraphError(f"roots are given for {len(roots)} of {len(graphs)} graphs, give a list for each")
    of_graphs = [{node: place for place, node in enumerate(graph.graph)} for graph in graphs]
    unknown = [[root for root in given if root not in places] for given, places in zip(roots, of_graphs, strict=True)]
    if any(unknown):
        faults = [f"{name_some(names)} of graph {number}" for number, names in enumerate(unknown) if names]
        raise GraphError(f"roots {join_faults(faults)} are no nodes, give nodes")
    found = ([places[root] for root in given] for given, places in zip(roots, of_graphs, strict=True))
    return [(graph, np.array(places, np.intp)) for graph, places in zip(graphs, found, strict=True)]
