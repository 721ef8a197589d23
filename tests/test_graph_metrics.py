"""Metrics of graphs: values by hand, values of networkx, and independence of the names of nodes."""

from math import nan, sqrt
from random import Random

import networkx as nx
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from pianta.errors import LabelError
from pianta.graphs.centrality import (
    distances,
    drop_isolated,
    measure_betweenness,
    measure_closeness,
    measure_decay,
    measure_eigenvector,
    measure_katz,
)
from pianta.graphs.metrics import GRAPH_METRICS, find_corridors, measure_assortativity, measure_graph
from pianta.labels import SCHOOL, LabelConvention


@st.composite
def graphs(draw: st.DrawFn) -> nx.Graph:
    """Graphs of 0 to 14 nodes, sparse and dense, of one part or several, trees among them."""
    size = draw(st.integers(0, 14))
    graph = nx.empty_graph(size)
    pairs = st.tuples(st.integers(0, max(size - 1, 0)), st.integers(0, max(size - 1, 0)))
    if size > 1:
        graph.add_edges_from(pair for pair in draw(st.lists(pairs, max_size=2 * size)) if pair[0] != pair[1])
        if draw(st.booleans()):
            graph.add_edges_from((node, draw(st.integers(0, node - 1))) for node in range(1, size))
    return graph


def test_a_star_with_a_corridor_in_the_middle() -> None:
    graph = nx.star_graph(4)
    measured = measure_graph(graph, {0})
    assert tuple(measured) == GRAPH_METRICS
    expected = {
        "nodes": 5,
        "edges": 4,
        "nodes_r": 4,
        "nodes_c": 1,
        "path_length": (4 * 1 + 6 * 2) / 10,
        "diameter": 2,
        "art_points": 1,
        "assortativity": -1,
        "betweenness": 0.1,
        "betweenness_r": 0,
        "betweenness_c": 0.5,
        "closeness": (1 + 4 * 4 / 7) / 5,
        "closeness_r": 4 / 7,
        "closeness_c": 1,
        "eigenvector": (1 + 4 * 0.5) / 5,
        "eigenvector_r": 0.5,
        "eigenvector_c": 1,
    }
    assert {name: measured[name] for name in expected} == pytest.approx(expected)


def test_katz_of_a_star() -> None:
    # centre = 1 + 0.4 leaf and leaf = 1 + 0.1 centre: centre 1.4 / 0.96, leaf 1.1 / 0.96.
    length = sqrt(1.4**2 + 4 * 1.1**2)
    assert measure_katz(nx.star_graph(4)) == pytest.approx({0: 1.4 / length} | dict.fromkeys(range(1, 5), 1.1 / length))


@pytest.mark.parametrize(("rooms", "training"), [(99, True), (100, False), (101, False)])
def test_katz_has_no_answer_for_a_corridor_with_a_hundred_rooms(rooms: int, training: bool) -> None:
    measured = measure_graph(nx.star_graph(rooms), {0})
    assert [measured[name] is not None for name in ("katz", "katz_r", "katz_c")] == [training] * 3
    assert measured["eigenvector_c"] == pytest.approx(1)


def test_a_path_of_four() -> None:
    measured = measure_graph(nx.path_graph(4), {1, 2})
    assert measured["path_length"] == pytest.approx(10 / 6)
    assert (measured["diameter"], measured["art_points"]) == (3, 2)
    assert measured["assortativity"] == pytest.approx(-0.5)
    assert measured["betweenness_c"] == pytest.approx(2 / 6)
    assert (measured["closeness_r"], measured["closeness_c"]) == pytest.approx((3 / 6, 3 / 4))
    # The golden ratio is the largest eigenvalue.
    assert measured["eigenvector_r"] == pytest.approx((sqrt(5) - 1) / 2)


def test_a_ring_has_no_assortativity() -> None:
    measured = measure_graph(nx.cycle_graph(6), set())
    assert measured["assortativity"] is None
    assert (measured["art_points"], measured["diameter"]) == (0, 3)
    assert measured["eigenvector"] == pytest.approx(1)
    assert measured["katz"] == pytest.approx(1 / sqrt(6))
    assert (measured["nodes_c"], measured["katz_c"], measured["closeness_c"]) == (0, None, None)


def test_decay_is_the_closeness_that_the_thesis_prints() -> None:
    graph = nx.path_graph(3)
    graph.add_node(9)
    assert measure_decay(graph) == {0: 0.75, 1: 1.0, 2: 0.75, 9: 0.0}


def test_two_parts() -> None:
    # 2 of 4 other nodes can be reached on the path, and 1 in the pair.
    graph = nx.disjoint_union(nx.path_graph(3), nx.path_graph(2))
    assert measure_closeness(graph) == pytest.approx({0: 1 / 3, 1: 0.5, 2: 1 / 3, 3: 0.25, 4: 0.25})
    assert measure_eigenvector(graph) == pytest.approx({0: sqrt(0.5), 1: 1, 2: sqrt(0.5), 3: 0, 4: 0})
    measured = measure_graph(graph, {1})
    assert (measured["diameter"], measured["path_length"]) == (2, (1 + 1 + 2 + 1) / 4)
    # Between two others once, divided by (5 - 1)(5 - 2).
    assert measured["betweenness_c"] == pytest.approx(1 / 12)


def test_twin_parts_share_the_eigenvector() -> None:
    graph = nx.disjoint_union(nx.star_graph(3), nx.star_graph(3))
    assert measure_eigenvector(graph) == pytest.approx(dict.fromkeys(graph, sqrt(1 / 3)) | {0: 1, 4: 1})


@pytest.mark.parametrize("size", [0, 1, 2, 3])
def test_without_edges(size: int) -> None:
    measured = measure_graph(nx.empty_graph(size), {0})
    assert tuple(measured) == GRAPH_METRICS
    assert (measured["nodes"], measured["edges"], measured["art_points"]) == (size, 0, 0)
    assert (measured["path_length"], measured["assortativity"]) == (None, None)
    assert measured["diameter"] == (0 if size else None)
    for name in ("betweenness", "closeness", "eigenvector"):
        assert measured[name] == (0 if size else None)
    assert measured["katz"] == (pytest.approx(1 / sqrt(size)) if size else None)


def test_dropping_isolated_rooms_leaves_the_graph_as_it_was() -> None:
    graph = nx.path_graph(3)
    graph.add_node(9, label="ATTIC")
    assert set(drop_isolated(graph)) == {0, 1, 2}
    assert set(graph) == {0, 1, 2, 9}


def test_corridors_by_the_split_of_the_graphs() -> None:
    graph = nx.empty_graph(0)
    for node, label in enumerate(("CLASSROOM", "CORRIDOR", "HALL", "LOBBY", "ENTRANCE", "STAIRS", "WASHROOM")):
        graph.add_node(node, label=label)
    assert find_corridors(graph, SCHOOL) == {1, 2, 3, 4}
    assert find_corridors(graph, SCHOOL, convention=LabelConvention.EXPERIMENTS) == {1, 2, 3}
    graph.add_node(7)
    with pytest.raises(LabelError, match="None"):
        find_corridors(graph, SCHOOL)


@pytest.mark.slow
@given(graphs())
def test_networkx_measures_the_same(graph: nx.Graph) -> None:
    half = {node: value / 2 for node, value in nx.betweenness_centrality(graph).items()}
    assert measure_betweenness(graph) == pytest.approx(half)
    assert measure_closeness(graph) == pytest.approx(nx.closeness_centrality(graph))
    lengths = dict(nx.all_pairs_shortest_path_length(graph))
    assert distances(graph).tolist() == [[lengths[a].get(b, float("inf")) for b in graph] for a in graph]
    assert measure_graph(graph, ())["art_points"] == len(set(nx.articulation_points(graph)))
    decay = {a: sum(2.0**-length for b, length in lengths[a].items() if a != b) for a in graph}
    assert measure_decay(graph) == pytest.approx(decay)


@pytest.mark.slow
@given(graphs())
def test_networkx_has_the_same_vectors(graph: nx.Graph) -> None:
    assume(len(graph) and max(dict(graph.degree).values()) < 8)  # beyond, its iteration for Katz is slow or diverges
    assert measure_katz(graph) == pytest.approx(nx.katz_centrality(graph, max_iter=10**4, tol=1e-10), abs=1e-7)
    largest = np.linalg.eigvalsh(nx.to_numpy_array(graph))[::-1]
    assume(graph.size() and largest[0] - largest[1] > 0.05)
    vector = nx.eigenvector_centrality(graph, max_iter=10**4, tol=1e-10)
    most = max(vector.values())
    measured = measure_eigenvector(graph)
    assert measured == pytest.approx({node: value / most for node, value in vector.items()}, abs=1e-5)
    assert max(measured.values()) == 1


@given(graphs())
def test_networkx_has_the_same_assortativity(graph: nx.Graph) -> None:
    degrees = {graph.degree(node) for edge in graph.edges for node in edge}
    measured = measure_assortativity(graph)
    assert (measured is None) == (len(degrees) < 2)
    if measured is not None:
        assert measured == pytest.approx(nx.degree_pearson_correlation_coefficient(graph), abs=1e-9)


@pytest.mark.slow
@given(graphs(), st.randoms(use_true_random=False))
def test_the_names_and_the_order_of_nodes_do_not_matter(graph: nx.Graph, random: Random) -> None:
    names = [f"room {node}" for node in graph]
    random.shuffle(names)
    corridors = {node for node in graph if node % 3 == 0}
    renamed = nx.Graph()
    renamed.add_nodes_from(sorted(names))
    renamed.add_edges_from((names[first], names[second]) for first, second in graph.edges)
    expected = {name: nan if value is None else value for name, value in measure_graph(graph, corridors).items()}
    measured = measure_graph(renamed, {names[node] for node in corridors})
    numbers = {name: nan if value is None else value for name, value in measured.items()}
    assert numbers == pytest.approx(expected, nan_ok=True)
