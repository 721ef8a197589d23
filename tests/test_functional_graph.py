"""Step 2: moves with the printed probabilities, graphs that stay connected, and costs equal to a new computation."""

from itertools import pairwise
from math import exp, inf

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pianta._types import Floats
from pianta.generation.functional_graph import (
    DRAWS,
    FunctionalGraphs,
    draw_door_counts,
    draw_start,
    sample_functional_graphs,
)
from pianta.generation.incremental_gram import ReferenceGraphs
from pianta.generation.node_connections import Pair
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from tests.generated_types import small_model

H = [floor.functional_graph for floor in small_model().floors]
REFERENCES = ReferenceGraphs(H)


def label(graph, labels="0123456789") -> nx.Graph:
    nx.set_node_attributes(graph, dict(zip(graph, labels, strict=False)), "label")
    return graph


def measure_cost(graphs) -> Floats:
    """Γ2 by the kernel, each reference as much as 50 floors together."""
    similarity = WeisfeilerLehman().fit(H).compare(graphs)
    return np.asarray(50 * np.sqrt(np.maximum(2 - 2 * similarity, 0)).mean(axis=1))


def find_graphs(chains, labels) -> list[nx.Graph]:
    return [label(graph, graph_labels) for graph, graph_labels in zip(chains.to_graphs(), labels, strict=True)]


@pytest.mark.slow
@settings(max_examples=30)
@given(
    st.lists(st.text("01", min_size=1, max_size=7), min_size=1, max_size=4),
    st.integers(0, 3),
    st.integers(0, 1000),
)
def test_properties_after_every_move(labels, n_fixed, seed):
    generators = [np.random.default_rng((seed, number)) for number in range(len(labels))]
    n_fixed = min(n_fixed, *map(len, labels))
    functional = nx.path_graph(n_fixed) if n_fixed else None
    starts = [
        draw_start(graph_labels, generator, fixed=functional)
        for graph_labels, generator in zip(labels, generators, strict=True)
    ]
    chains = FunctionalGraphs(REFERENCES, starts, n_fixed=n_fixed)
    random = np.random.default_rng(seed)
    for _ in range(25):
        before = find_graphs(chains, labels)
        chains.move(random.random((len(labels), DRAWS)))
        after = find_graphs(chains, labels)
        np.testing.assert_allclose(chains.costs, measure_cost(after), rtol=1e-12)
        for old, new in zip(before, after, strict=True):
            assert nx.is_connected(new)
            assert not [*nx.selfloop_edges(new)]
            assert set(new.subgraph(range(n_fixed)).edges) == set(pairwise(range(n_fixed)))
            added, removed = set(new.edges) - set(old.edges), set(old.edges) - set(new.edges)
            assert max(len(added), len(removed)) <= 1
            if added and removed:
                assert len({*added.pop()} & {*removed.pop()}) == 1


def move_ring(uniforms) -> tuple[set[Pair], set[Pair]]:
    """The edges of a ring of four areas before and after a move that is accepted if it can be."""
    chains = FunctionalGraphs(REFERENCES, [label(nx.cycle_graph(4), "0101")])
    # Draws: move, edge, end of the edge, target, source, acceptance.
    chains.move(np.array([uniforms]))
    return set(nx.cycle_graph(4).edges), set(chains.to_graphs()[0].edges)


def test_add_remove_and_swap_have_the_printed_probabilities():
    # Equally many edges and areas: P_ADD = ε = 1 - e^-0.1; ε with the sign of method-notes.md.
    add = 1 - exp(-0.1)
    remove = (1 - add) * (1 - exp(-0.1))
    middle = (0.0, 0.0, 0.6, 0.1, 0.0)
    before, after = move_ring((add - 1e-9, *middle))
    assert after - before == {(0, 2)}
    assert not before - after
    for draw in (add + 1e-9, add + remove - 1e-9):
        before, after = move_ring((draw, *middle))
        assert before - after == {(0, 1)}
        assert not after - before
    for draw in (add + remove + 1e-9, 0.999999):
        before, after = move_ring((draw, *middle))
        assert before - after == {(0, 1)}
        assert after - before == {(0, 2)}


def test_the_probabilities_follow_the_numbers_of_areas_and_edges():
    # Five areas, ten edges: P_ADD = 1 - e^-0.05, ε = 1 - e^-0.2.
    add, remove = 1 - exp(-0.05), exp(-0.05) * (1 - exp(-0.2))
    for draw, edges in ((add - 1e-9, 10), (add + 1e-9, 9), (add + remove - 1e-9, 9), (add + remove + 1e-9, 10)):
        chains = FunctionalGraphs(REFERENCES, [label(nx.complete_graph(5), "01010")])
        chains.move(np.array([[draw, 0.0, 0.6, 0.1, 0.9, 0.0]]))
        assert chains.to_graphs()[0].number_of_edges() == edges


@pytest.mark.parametrize("end", [0.4, 0.6])
def test_either_end_of_an_edge_is_swapped(end):
    chains = FunctionalGraphs(REFERENCES, [label(nx.Graph([(0, 1), (1, 2), (2, 0), (2, 3)]), "0101")])
    chains.move(np.array([[0.999, 0.0, end, 0.9, 0.0, 0.0]]))
    (added,) = set(chains.to_graphs()[0].edges) - {(0, 1), (1, 2), (0, 2), (2, 3)}
    assert added == ((0, 3) if end < 0.5 else (1, 3))


def test_edges_between_fixed_areas_stay():
    start = label(nx.Graph([(0, 1), (1, 2), (2, 3), (3, 4)]), "01010")
    chains = FunctionalGraphs(REFERENCES, [start] * 20, n_fixed=3)
    random = np.random.default_rng(0)
    for _ in range(40):
        chains.move(random.random((20, DRAWS)))
        assert {frozenset(graph.subgraph(range(3)).edges) for graph in chains.to_graphs()} == {
            frozenset({(0, 1), (1, 2)})
        }
    assert len({frozenset(graph.edges) for graph in chains.to_graphs()}) > 1


def move_closed(start: nx.Graph, *, n_fixed: int, closed: bool = True) -> list[nx.Graph]:
    """The graphs after each of forty moves of twenty chains from one start."""
    chains = FunctionalGraphs(REFERENCES, [start] * 20, n_fixed=n_fixed, closed=closed)
    random = np.random.default_rng(0)
    result = []
    for _ in range(40):
        chains.move(random.random((20, DRAWS)))
        result += chains.to_graphs()
    return result


@pytest.mark.slow
def test_closed_areas_lead_to_as_many_others():
    """Areas 0 and 1 are fixed, and lead to one and to two others; which others may change."""
    start = label(nx.Graph([(0, 1), (0, 2), (1, 3), (1, 4), (2, 3), (4, 5)]), "010101")
    result = move_closed(start, n_fixed=2)
    for graph in result:
        assert nx.is_connected(graph)
        assert graph.has_edge(0, 1)
        assert (graph.degree(0), graph.degree(1)) == (2, 3)
    assert {frozenset(graph[0]) for graph in result} >= {frozenset({1, index}) for index in (2, 3, 4)}
    # The degrees of other areas may change, and those of fixed areas that are not closed, too.
    assert len({graph.number_of_edges() for graph in result}) > 1
    assert len({graph.degree(0) for graph in move_closed(start, n_fixed=2, closed=False)}) > 1


def test_known_edges_stay():
    """Area 0 and its edge to the open area 1 are known; its other edge may lead to any area."""
    start = label(nx.Graph([(0, 1), (0, 2), (1, 3), (2, 3)]), "0111")
    start.edges[0, 1]["known"] = True
    result = move_closed(start, n_fixed=1)
    assert all(graph.has_edge(0, 1) and graph.degree(0) == 2 for graph in result)
    assert {frozenset(graph[0]) for graph in result} == {frozenset({1, 2}), frozenset({1, 3})}
    assert len({graph.degree(1) for graph in result}) > 1
    start.edges[0, 1]["known"] = False
    assert not all(graph.has_edge(0, 1) for graph in move_closed(start, n_fixed=1))


def test_fully_known_graphs_do_not_change():
    start = label(nx.Graph([(0, 1), (1, 2)]), "010")
    assert all(set(graph.edges) == {(0, 1), (1, 2)} for graph in move_closed(start, n_fixed=3))


def test_bridges_are_never_removed():
    chains = FunctionalGraphs(REFERENCES, [label(nx.path_graph(4), "0101")])
    costs = chains.costs.copy()
    for edge in (0.0, 0.5, 0.9):
        chains.move(np.array([[0.2, edge, 0.0, 0.0, 0.0, 0.0]]))
        assert set(chains.to_graphs()[0].edges) == set(nx.path_graph(4).edges)
    np.testing.assert_array_equal(chains.costs, costs)


def test_one_area_stays_alone():
    chains = FunctionalGraphs(REFERENCES, [label(nx.empty_graph(1), "0"), label(nx.path_graph(3), "011")])
    random = np.random.default_rng(0)
    for _ in range(50):
        chains.move(random.random((2, DRAWS)))
    assert chains.to_graphs()[0].number_of_edges() == 0
    assert np.isfinite(chains.costs).all()


def test_chains_are_independent():
    labels = ["0101", "0", "0011010"]

    def sample(numbers) -> list[list[Pair]]:
        generators = [np.random.default_rng(number) for number in numbers]
        starts = [draw_start(labels[number], generator) for number, generator in zip(numbers, generators, strict=True)]
        graphs = sample_functional_graphs(FunctionalGraphs(REFERENCES, starts), generators, moves=80)
        return [sorted(graph.edges) for graph in graphs]

    together = sample([0, 1, 2])
    assert [sample([0])[0], sample([1])[0], sample([2])[0]] == together


@pytest.mark.slow
def test_chains_approach_the_references():
    labels = ["0101"] * 60
    generators = [np.random.default_rng(number) for number in range(60)]
    starts = [draw_start(graph_labels, generator) for graph_labels, generator in zip(labels, generators, strict=True)]
    traces: list[np.ndarray] = []
    chains = FunctionalGraphs(REFERENCES, starts)
    sample_functional_graphs(chains, generators, moves=150, traces=traces)
    assert len(traces) == 150
    assert traces[-1] is not traces[-2]
    assert np.mean(traces[-50:]) < np.mean(traces[0])


@given(st.integers(1, 12), st.integers(0, 4), st.integers(0, 1000))
def test_starts_are_connected(size, n_fixed, seed):
    functional = label(nx.path_graph(min(n_fixed, size))) if n_fixed else None
    start = draw_start(["1"] * size, np.random.default_rng(seed), fixed=functional)
    assert nx.is_connected(start)
    assert list(start) == [*range(size)]
    assert start.number_of_edges() == size - 1
    assert {edge for edge in start.edges if max(edge) < n_fixed} >= set(functional.edges if functional else ())


def test_numbers_of_doors_have_the_given_frequencies():
    graph = nx.star_graph(4000)
    graph.edges[0, 1]["cuts"] = 9
    draw_door_counts(graph, [1, 1, 1, 2], np.random.default_rng(0))
    counts = [count for *_, count in graph.edges(data="cuts")]
    assert counts[0] == 9
    assert counts.count(1) / 3999 == pytest.approx(0.75, abs=0.03)
    assert set(counts) == {1, 2, 9}


def test_numbers_of_doors_do_not_depend_on_the_order_of_edges():
    one, other = nx.Graph([(0, 1), (2, 1), (0, 3)]), nx.Graph([(3, 0), (1, 2), (1, 0)])
    for graph in (one, other):
        draw_door_counts(graph, [1, 2, 3, 4, 5], np.random.default_rng(0))
    assert all(one.edges[edge]["cuts"] == other.edges[edge]["cuts"] for edge in one.edges)


def test_disconnected_graphs_are_never_accepted():
    chains = FunctionalGraphs(REFERENCES, [label(nx.path_graph(2), "01")])
    chains.move(np.array([[0.2, 0.0, 0.0, 0.0, 0.0, 0.0]]))
    assert chains.costs[0] < inf
