"""NSPDK: counts made by hand, and a slow count that decides by networkx which neighbourhoods are isomorphic."""

from collections.abc import Hashable
from itertools import combinations_with_replacement, product
from math import sqrt

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from networkx.algorithms.isomorphism import categorical_edge_match, categorical_node_match

from pianta.errors import GraphError, OptionError
from pianta.graphs.labelled_graphs import read_labelled_graphs
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.graphs.nspdk_features import hash_neighborhoods
from pianta.graphs.shortest_paths import find_near
from tests.labelled_graphs import labelled_graphs, make_path, make_plan, rename

PATHS = [make_path("ABC"), make_path("AB")]


def hash_one(graph: nx.Graph, radius: int, root: Hashable) -> int:
    (read,) = read_labelled_graphs([graph], node_label="label")
    return int(hash_neighborhoods(read, find_near(read.edges, radius), radius)[list(graph).index(root)])


def test_pairs_of_two_paths():
    # Roots: 3 and 2, A and B in both. Pairs of roots: 2 and 1, that of A and B in both.
    # Neighbourhoods of radius 1: that of A is in both, that of B differs, so no pair of these is in both.
    gram = NeighborhoodPairs(radius=1, distance=1, normalize=False).fit(PATHS).compare()
    assert gram.tolist() == [[3 + 2 + 3 + 2, 2 + 1 + 1 + 0], [4, 2 + 1 + 2 + 1]]


def test_normalised_by_block():
    gram = NeighborhoodPairs(radius=1, distance=1).fit(PATHS).compare()
    np.testing.assert_allclose(gram[0, 1], (2 / sqrt(6) + 1 / sqrt(2) + 1 / sqrt(6) + 0) / 4, rtol=1e-15)
    assert np.diag(gram).tolist() == [1, 1]


def test_blocks_without_pairs_do_not_count():
    # The single node has pairs of distance 0 only: two blocks of four, in both of which its features are half.
    pair = nx.disjoint_union(make_path("A"), make_path("B"))
    kernel = NeighborhoodPairs(radius=1, distance=1).fit([make_path("A"), pair])
    np.testing.assert_allclose(kernel.compare()[0, 1], 1 / sqrt(2), rtol=1e-15)


def test_doors_distinguish_neighbourhoods():
    wide, narrow = make_path("AB"), make_path("AB")
    wide.edges[0, 1]["door"], narrow.edges[0, 1]["door"] = "wide", "narrow"
    assert NeighborhoodPairs().fit([wide]).compare([narrow])[0, 0] == 1
    gram = NeighborhoodPairs(radius=1, distance=0, edge_label="door", normalize=False).fit([wide]).compare([narrow])
    assert gram.tolist() == [[2]]


def test_rows_of_rooms():
    kernel = NeighborhoodPairs(radius=0, distance=1, normalize=False)
    counts = kernel.count_rooted_features(PATHS, [[1, 0], [1]])
    # Rows are B and A of the first path and B of the second; B has two neighbours in the first.
    table = kernel.fit_counts(counts).compare_counts()
    assert table.tolist() == [[1 + 2, 0, 1 + 1], [0, 1 + 1, 0], [2, 0, 1 + 1]]
    np.testing.assert_array_equal(kernel.transform_counts(counts).sum(axis=1), [3, 2, 2])


def test_rooms_whose_surroundings_are_isomorphic_have_the_same_row():
    graph = make_plan(20, seed=5)
    kernel = NeighborhoodPairs(edge_label="door")
    kernel.fit_counts(kernel.count_rooted_features([graph], [list(graph)]))
    copy = nx.relabel_nodes(graph, {node: f"room {node}" for node in graph})
    copy = copy.subgraph(copy).copy()
    roots = [f"room {node}" for node in graph]
    gram = kernel.compare_counts(kernel.count_rooted_features([copy], [roots]))
    np.testing.assert_array_equal(np.diag(gram), np.ones(20))
    np.testing.assert_array_equal(gram, kernel.compare_counts())


def test_rooms_of_no_graphs():
    kernel = NeighborhoodPairs()
    assert [block.n for block in kernel.count_rooted_features([], [])] == [0] * 12
    assert [block.n for block in kernel.count_rooted_features([make_path("A"), nx.Graph()], [[], []])] == [0] * 12


def test_roots_that_are_no_nodes():
    with pytest.raises(GraphError, match="roots 7, 'x' of graph 0; 5 of graph 1 are no nodes, give nodes"):
        NeighborhoodPairs().count_rooted_features(PATHS, [[0, 7, "x"], [5]])
    with pytest.raises(GraphError, match="roots are given for 1 of 2 graphs, give a list for each"):
        NeighborhoodPairs().count_rooted_features(PATHS, [[0]])


def test_all_bad_numbers_are_listed_together():
    with pytest.raises(OptionError, match=r"radius is -1; distance is True, give whole numbers of 0 or more"):
        NeighborhoodPairs(radius=-1, distance=True).fit(PATHS)


def test_pinned_neighbourhoods():
    path, ring = make_path("ABC"), make_path("ABBB")
    ring.add_edge(3, 0)
    assert hash_one(path, 0, 0) == 2429444257125404240
    assert hash_one(path, 1, 0) == 7757589053169528939
    assert hash_one(ring, 2, 0) == 16039297040866851997


def make_wheel(rim: str) -> nx.Graph:
    """A corridor with a room for each letter around it, each with a door to the next."""
    graph = nx.wheel_graph(len(rim) + 1)
    nx.set_node_attributes(graph, dict(enumerate(f"C{rim}")), "label")
    return graph


def test_the_outer_ring_counts():
    # Two rooms of B among those of A, at different distances along the ring: two rounds do not see that.
    near, far = make_wheel("BAAAABAAAAAA"), make_wheel("BAAAAABAAAAA")
    assert hash_one(near, 1, 0) != hash_one(far, 1, 0)
    copy = rename(near, seed=1)
    assert hash_one(near, 1, 0) == hash_one(copy, 1, find_hub(copy))


def find_hub(graph: nx.Graph) -> Hashable:
    hubs: list[Hashable] = [node for node, label in graph.nodes(data="label") if label == "C"]
    return hubs[0]


def count_slowly(one: nx.Graph, other: nx.Graph, radius: int, distance: int, *, edge_label: str | None) -> list[int]:
    """By block, pairs of pairs of isomorphic neighbourhoods."""

    def list_pairs(graph: nx.Graph, size: int, apart: int) -> list[tuple[nx.Graph, nx.Graph]]:
        lengths = dict(nx.all_pairs_shortest_path_length(graph))
        around = {node: nx.ego_graph(graph, node, size) for node in graph}
        for node, part in around.items():
            nx.set_node_attributes(part, {each: each == node for each in part}, "root")
        pairs = combinations_with_replacement(graph, 2)
        return [(around[first], around[second]) for first, second in pairs if lengths[first].get(second) == apart]

    def are_isomorphic(first: nx.Graph, second: nx.Graph) -> bool:
        edges = None if edge_label is None else categorical_edge_match(edge_label, None)
        return bool(nx.is_isomorphic(first, second, categorical_node_match(["label", "root"], [None, None]), edges))

    def are_alike(pair: tuple[nx.Graph, nx.Graph], same: tuple[nx.Graph, nx.Graph]) -> bool:
        (a, b), (c, d) = pair, same
        return (are_isomorphic(a, c) and are_isomorphic(b, d)) or (are_isomorphic(a, d) and are_isomorphic(b, c))

    blocks = product(range(radius + 1), range(distance + 1))
    return [
        sum(are_alike(*pairs) for pairs in product(list_pairs(one, *block), list_pairs(other, *block)))
        for block in blocks
    ]


# Colour refinement distinguishes all graphs of up to six nodes: the root and five others.
@pytest.mark.slow
@settings(max_examples=40)
@given(labelled_graphs(max_size=6), labelled_graphs(max_size=6))
@pytest.mark.parametrize("edge_label", [None, "door"])
def test_as_many_as_counted_one_by_one(edge_label, one, other):
    kernel = NeighborhoodPairs(radius=2, distance=2, edge_label=edge_label, normalize=False)
    counts = np.array(
        [[count_slowly(a, b, 2, 2, edge_label=edge_label) for b in (one, other)] for a in (one, other)], np.float64
    )
    np.testing.assert_array_equal(kernel.fit([one, other]).compare(), counts.sum(axis=2))
    filled = np.diagonal(counts) > 0
    lengths = np.sqrt(counts[0, 0] * counts[1, 1])
    blocks = np.divide(counts[0, 1], lengths, out=np.zeros_like(lengths), where=lengths > 0)
    expected = blocks.sum() / max(np.sqrt(filled.sum(axis=0).prod()), 1)
    np.testing.assert_allclose(kernel.set_params(normalize=True).fit([one]).compare([other]), [[expected]], atol=1e-12)
