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
from pianta.graphs.nspdk_features import count_pairs, encode_pairs, list_blocks, pair_neighborhoods
from pianta.graphs.shortest_paths import Adjacency
from pianta.graphs.stable_hash import Codes
from pianta.io._faults import join_faults


class NeighborhoodPairs(ExplicitKernel):
    """NSPDK: counts pairs of neighbourhoods of radius 0 … `radius` whose roots are 0 … `distance` edges apart.

    Two pairs are the same feature if their neighbourhoods are isomorphic, by `hash_neighborhoods`. Each radius with
    each distance is a block; if normalised, all blocks have equal weight, as in the paper.

    label: the node attribute. edge_label: an edge attribute; None to ignore labels of edges.
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
        """The pairs that contain a node, the node's neighbourhood first, in the blocks of `count_features`.

        roots: for each graph, the nodes that get a row; rows are in this order, graph by graph.
        Raises GraphError as `count_features` does, and for roots that are not nodes.
        """
        check_numbers(radius=self.radius, distance=self.distance)
        rows: list[list[Indices]] = [[] for _ in list_blocks(self.radius, self.distance)]
        codes: list[list[Codes]] = [[] for _ in rows]
        first_row = 0
        for graph, indices in _find_roots(self._read(graphs), roots):
            blocks = pair_neighborhoods(graph, self.radius, self.distance).items()
            for (block, pairs), block_rows, block_codes in zip(blocks, rows, codes, strict=True):
                row, own = Adjacency(len(graph), pairs.roots, pairs.others).leave(indices)
                block_rows.append(first_row + row)
                block_codes.append(encode_pairs(block, pairs.one[own], pairs.other[own]))
            first_row += len(indices)
        return [gather_counts(first_row, *parts) for parts in zip(rows, codes, strict=True)]

    def _read(self, graphs: Iterable[nx.Graph]) -> list[LabelledGraph]:
        return read_labelled_graphs(graphs, node_label=self.label, edge_label=self.edge_label)


def _find_roots(
    graphs: Sequence[LabelledGraph], roots: Sequence[Sequence[Hashable]]
) -> list[tuple[LabelledGraph, Indices]]:
    """Each graph with the indices of its roots."""
    if len(roots) != len(graphs):
        raise GraphError(f"roots are given for {len(roots)} of {len(graphs)} graphs, give a list for each")
    indices = [{node: index for index, node in enumerate(graph.graph)} for graph in graphs]
    unknown = [[root for root in each if root not in nodes] for each, nodes in zip(roots, indices, strict=True)]
    if any(unknown):
        faults = [f"{name_some(names)} of graph {number}" for number, names in enumerate(unknown) if names]
        raise GraphError(f"roots {join_faults(faults)} are no nodes, give nodes")
    chosen = ([nodes[root] for root in each] for each, nodes in zip(roots, indices, strict=True))
    return [(graph, np.array(each, np.intp)) for graph, each in zip(graphs, chosen, strict=True)]
