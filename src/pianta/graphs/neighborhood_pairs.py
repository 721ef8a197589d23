"""NSPDK, the Neighborhood Subgraph Pairwise Distance Kernel of kLog (thesis, section 6.1.2; Costa, De Grave, 2010)."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence

import networkx as nx
import numpy as np

from pianta._types import Indices
from pianta.errors import GraphError
from pianta.graphs.explicit_kernel import ExplicitKernel, check_numbers
from pianta.graphs.feature_counts import FeatureCounts, gather_counts
from pianta.graphs.labelled_graphs import LabelledGraph, name_some, read_labelled_graphs
from pianta.graphs.neighborhood_features import count_pairs, list_blocks, name_pairs, pair_neighborhoods
from pianta.graphs.shortest_paths import Adjacency
from pianta.graphs.stable_hash import Codes
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
        check_numbers(radius=self.radius, distance=self.distance)
        return count_pairs(self._read(graphs), radius=self.radius, distance=self.distance)

    def count_rooted_features(
        self, graphs: Iterable[nx.Graph], roots: Sequence[Sequence[Hashable]]
    ) -> list[FeatureCounts]:
        """The pairs that one node is in, in blocks like those of `count_features`, the node's neighbourhood first.

        roots: of each graph the nodes that get a row; those of the first graph come first, in the order given.
        Raises GraphError as `count_features` does, and for roots that are no nodes.
        """
        check_numbers(radius=self.radius, distance=self.distance)
        rows: list[list[Indices]] = [[] for _ in list_blocks(self.radius, self.distance)]
        codes: list[list[Codes]] = [[] for _ in rows]
        first_row = 0
        for graph, places in _find_roots(self._read(graphs), roots):
            blocks = pair_neighborhoods(graph, self.radius, self.distance).items()
            for (block, pairs), of_rows, of_codes in zip(blocks, rows, codes, strict=True):
                which, own = Adjacency(len(graph), pairs.roots, pairs.others).leave(places)
                of_rows.append(first_row + which)
                of_codes.append(name_pairs(block, pairs.one[own], pairs.other[own]))
            first_row += len(places)
        return [gather_counts(first_row, *parts) for parts in zip(rows, codes, strict=True)]

    def _read(self, graphs: Iterable[nx.Graph]) -> list[LabelledGraph]:
        return read_labelled_graphs(graphs, node_label=self.label, edge_label=self.edge_label)


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
