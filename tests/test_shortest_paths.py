"""Shortest paths of arrays against networkx."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.graphs.centrality import measure_betweenness, measure_closeness, to_arrays
from pianta.graphs.shortest_paths import find_near, find_shortest_paths


@st.composite
def graphs(draw: st.DrawFn) -> nx.Graph:
    """Graphs of 0 to 15 nodes, of any number of parts."""
    n = draw(st.integers(0, 15))
    return nx.gnp_random_graph(n, draw(st.floats(0, 0.6)), seed=draw(st.integers(0, 1000)))


@given(graphs())
def test_distances_and_numbers_of_paths(graph):
    paths = find_shortest_paths(to_arrays(graph))
    for root in graph:
        lengths = nx.single_source_shortest_path_length(graph, root)
        for node in graph:
            assert paths.distances[root, node] == lengths.get(node, np.inf)
            message = len([*nx.all_shortest_paths(graph, root, node)]) if node in lengths else 0
            assert paths.counts[root, node] == message


@given(graphs(), st.integers(0, 6))
def test_pairs_that_are_near(graph, reach):
    distances, near = find_shortest_paths(to_arrays(graph)).distances, find_near(to_arrays(graph), reach)
    roots, nodes = np.nonzero(distances <= reach)
    np.testing.assert_array_equal(near.roots, roots)
    np.testing.assert_array_equal(near.nodes, nodes)
    np.testing.assert_array_equal(near.steps, distances[roots, nodes])


@given(graphs())
def test_centralities(graph):
    assert measure_betweenness(graph) == pytest.approx(
        {node: value / 2 for node, value in nx.betweenness_centrality(graph).items()}
    )
    assert measure_closeness(graph) == pytest.approx(nx.closeness_centrality(graph))


def test_edges_from_nodes_that_are_given_twice():
    origins, gone = to_arrays(nx.path_graph(3)).leave(np.array([1, 0, 1]))
    assert origins.tolist() == [0, 0, 1, 2, 2]
    assert to_arrays(nx.path_graph(3)).ends[gone].tolist() == [2, 0, 1, 2, 0]
