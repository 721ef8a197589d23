"""Gram rows kept up to date: the same numbers as the kernel gives from scratch, to the last digit."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta._types import Floats
from pianta.generation.incremental_gram import IncrementalGram, ReferenceGraphs
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from tests.generated_types import make_schools
from tests.labelled_graphs import labelled_graphs, make_path

MOVES = st.lists(st.tuples(*[st.integers(0, 10**6)] * 3, st.booleans()), max_size=12)


def compare(references, graphs, *, iterations=5) -> Floats:
    return WeisfeilerLehman(iterations=iterations).fit(references).compare(graphs)


def change(batch, graphs, moves, *, together=False) -> list[tuple[int, int, int, bool]]:
    """Make the changes in the graphs and in the batch, one by one or all at once; no pair of nodes twice."""
    done: list[tuple[int, int, int, bool]] = []
    for graph, one, other, present in moves:
        number = graph % len(graphs)
        size = len(graphs[number])
        ends = sorted({one % size, other % size})
        if len(ends) == 2 and (number, *ends) not in [step[:3] for step in done]:
            done.append((number, *ends, present))
            edit = graphs[number].add_edges_from if present else graphs[number].remove_edges_from
            edit([ends])
    if together and done:
        numbers, ones, others, presents = (np.array(column) for column in zip(*done, strict=True))
        batch.change_edges(numbers, ones, others, present=presents)
    for number, one, other, present in () if together else done:
        batch.change_edges(np.array([number]), np.array([one]), np.array([other]), present=present)
    return done


@st.composite
def batches(draw):
    """ReferenceGraphs and graphs of several sizes, some of their labels the same."""
    references = draw(st.lists(labelled_graphs(), min_size=1, max_size=3).filter(lambda graphs: all(map(len, graphs))))
    graphs = draw(st.lists(labelled_graphs(), min_size=1, max_size=4).filter(lambda graphs: all(map(len, graphs))))
    for graph in graphs:
        for node in graph:
            if draw(st.booleans()):
                graph.nodes[node]["label"] = draw(st.sampled_from("ABC"))
    return references, graphs


@pytest.mark.slow
@given(batches(), MOVES, st.integers(0, 5), st.booleans())
def test_equal_to_the_kernel_after_any_changes(sampled, moves, iterations, together):
    references, graphs = sampled
    batch = IncrementalGram(ReferenceGraphs(references, iterations=iterations), graphs)
    np.testing.assert_array_equal(batch.measure_similarity(), compare(references, graphs, iterations=iterations))
    change(batch, graphs, moves, together=together)
    np.testing.assert_array_equal(batch.measure_similarity(), compare(references, graphs, iterations=iterations))


@pytest.mark.slow
@given(batches(), MOVES)
def test_undoing_restores_everything(sampled, moves):
    references, graphs = sampled
    batch = IncrementalGram(ReferenceGraphs(references), graphs)
    before = [batch.adjacency.copy(), batch.products.copy(), batch.squares.copy(), batch.measure_similarity()]
    moves = [(*move[:3], True) for move in moves]
    new = [graph.copy() for graph in graphs]
    done = [move for move in change(batch, new, moves) if not graphs[move[0]].has_edge(*move[1:3])]
    if done:
        numbers, ones, others, _ = (np.array(column) for column in zip(*done, strict=True))
        batch.change_edges(numbers, others, ones, present=False)
    after = [batch.adjacency, batch.products, batch.squares, batch.measure_similarity()]
    for one, other in zip(before, after, strict=True):
        np.testing.assert_array_equal(one, other)


def test_long_walks_of_graphs_of_the_size_of_schools():
    references = make_schools()
    graphs = [nx.cycle_graph(size) for size in (3, 17, 40)]
    for graph in graphs:
        nx.set_node_attributes(graph, {node: ("CORRIDOR", "CLASSROOM")[node % 3 > 0] for node in graph}, "label")
    batch = IncrementalGram(ReferenceGraphs(references), graphs)
    random = np.random.default_rng(0)
    for _ in range(20):
        change(batch, graphs, [(*random.integers(0, 1000, 3).tolist(), bool(random.integers(2))) for _ in range(6)])
        np.testing.assert_array_equal(batch.measure_similarity(), compare(references, graphs))


def test_one_node():
    references = [make_path("A"), make_path("B"), make_path("AB")]
    batch = IncrementalGram(ReferenceGraphs(references), [make_path("A")])
    np.testing.assert_array_equal(batch.measure_similarity(), compare(references, [make_path("A")]))
    assert batch.measure_similarity()[0, 1] == 0


def test_graphs_of_other_sizes_do_not_count():
    references = ReferenceGraphs([make_path("ABA")])
    alone = IncrementalGram(references, [make_path("AB")]).measure_similarity()
    beside = IncrementalGram(references, [make_path("A" * 30), make_path("AB")]).measure_similarity()
    np.testing.assert_array_equal(alone[0], beside[1])


def test_labels_that_no_reference_has():
    batch = IncrementalGram(ReferenceGraphs([make_path("AAB")]), [make_path("XYZ")])
    assert batch.measure_similarity().tolist() == [[0.0]]
    assert batch.squares.tolist() == WeisfeilerLehman(normalize=False).fit([make_path("XYZ")]).compare()[0].tolist()


def test_no_change_at_all():
    batch = IncrementalGram(ReferenceGraphs([make_path("AAB")]), [make_path("ABA")])
    before = batch.measure_similarity()
    batch.change_edges(*[np.zeros(0, np.intp)] * 3, present=True)
    np.testing.assert_array_equal(batch.measure_similarity(), before)


def test_adding_an_edge_that_is_there():
    batch = IncrementalGram(ReferenceGraphs([make_path("AAB")]), [make_path("ABA")])
    before = batch.measure_similarity()
    batch.change_edges(np.array([0]), np.array([1]), np.array([0]), present=True)
    np.testing.assert_array_equal(batch.measure_similarity(), before)


@pytest.mark.parametrize("present", [True, False])
def test_only_what_is_near_is_hashed_again(present, monkeypatch):
    # An end of the path sees a change at the other, 9 edges away, in no round of 5.
    graph = make_path("ABABABABAB")
    batch = IncrementalGram(ReferenceGraphs([make_path("AB")]), [graph])
    far = batch._features[0, 9].copy()
    near = batch._features[0, 0].copy()
    batch.change_edges(np.array([0]), np.array([0]), np.array([2 if present else 1]), present=present)
    np.testing.assert_array_equal(batch._features[0, 9], far)
    assert (batch._features[0, 0] != near).tolist() == [False, True, True, True, True, True]
