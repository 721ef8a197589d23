"""Graph Hopper on labels: counts made by hand, a slow count of paths, and GraKeL as an oracle."""

from collections import Counter
from itertools import product

import networkx as nx
import numpy as np
import pytest
from hypothesis import given

from pianta.graphs.graph_hopper import GraphHopper, count_hops
from pianta.graphs.labelled_graphs import read_labelled_graphs
from tests.labelled_graphs import labelled_graphs, make_path, make_plan, rename


def test_hops_along_a_path():
    (graph,) = read_labelled_graphs([make_path("ABC")], node_label="label")
    hops = count_hops(graph, np.arange(3))
    # By edges that follow, edges before, node: the middle is within the two paths of two edges.
    assert hops.tolist() == [
        [[1, 1, 1], [1, 2, 1], [1, 0, 1]],
        [[1, 2, 1], [0, 2, 0], [0, 0, 0]],
        [[1, 0, 1], [0, 0, 0], [0, 0, 0]],
    ]


def test_labels_in_places_of_paths():
    gram = GraphHopper(normalize=False).fit([make_path("ABC"), make_path("AB")]).compare()
    # Nodes: 3. One edge: A, B twice and C in either place. Two edges: A and C at the ends, B twice in the middle.
    # The second path shares the nodes A and B, and of one edge A and B, which the first has twice.
    assert gram.tolist() == [[3 + 2 * (1 + 4 + 1) + (2 + 4 + 2), 2 + 2 * (1 + 2)], [8, 2 + 2 * 2]]


def test_all_shortest_paths_count():
    square = nx.cycle_graph(4)
    nx.set_node_attributes(square, "A", "label")
    # 4 nodes, 8 paths of one edge, and 8 of two: two ways to the opposite corner.
    assert GraphHopper(normalize=False).fit([square]).compare().tolist() == [[4**2 + 2 * 8**2 + 3 * 8**2]]


def test_pinned_features():
    counts = GraphHopper().count_features([make_path("AB")])[0]
    assert counts.codes[:3].tolist() == [3652842396065601605, 6989355481789535610, 5667601732478835329]


def count_slowly(graph: nx.Graph) -> "Counter[tuple[int, int, str]]":
    """By length, place and label: how many shortest paths have it."""
    counts: Counter[tuple[int, int, str]] = Counter()
    for start, end in product(graph, repeat=2):
        for path in nx.all_shortest_paths(graph, start, end) if nx.has_path(graph, start, end) else []:
            counts.update((len(path), index, graph.nodes[node]["label"]) for index, node in enumerate(path))
    return counts


@pytest.mark.slow
@given(labelled_graphs(), labelled_graphs())
def test_as_many_as_counted_one_by_one(one, other):
    gram = GraphHopper(normalize=False).fit([one, other]).compare()
    counts = [count_slowly(graph) for graph in (one, other)]
    expected = [[sum(row[hop] * column[hop] for hop in row) for column in counts] for row in counts]
    assert gram.tolist() == expected


def test_many_paths_are_exact_too():
    # 40 million shortest paths between two corners: sums of squares have more digits than numbers have.
    grid = nx.grid_2d_graph(15, 15)
    nx.set_node_attributes(grid, "A", "label")
    kernel = GraphHopper().fit([grid])
    assert kernel.compare([rename(grid, seed=1)]).tolist() == kernel.compare().tolist() == [[1]]


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("normalize", [True, False])
def test_equal_to_grakel(normalize):
    grakel = pytest.importorskip("grakel")
    graphs = [make_plan(size, seed=size) for size in range(4, 18, 2)]
    grakel_graphs = [
        grakel.Graph(
            {node: list(graph[node]) for node in graph},
            node_labels={
                node: [float(label == label_text) for label_text in "ABCD"] for node, label in graph.nodes(data="label")
            },
        )
        for graph in graphs
    ]
    expected = grakel.GraphHopper(normalize=normalize, kernel_type="linear").fit_transform(grakel_graphs)
    np.testing.assert_allclose(GraphHopper(normalize=normalize).fit(graphs).compare(), expected, rtol=1e-12)
