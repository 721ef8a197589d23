"""Weisfeiler-Lehman: counts made by hand, pinned features, and GraKeL as an oracle."""

from math import sqrt

import numpy as np
import pytest

from pianta.errors import OptionError
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from tests.labelled_graphs import make_path, make_plan

PATHS = [make_path("ABC"), make_path("AB"), make_path("BAB")]


def test_labels_and_what_is_around_them():
    # A, B, C; then A by B, B by A and C, C by B. The second path shares A, B and A by B.
    # The third has A, B, B; then A by B and B, and twice B by A, as the second has once.
    gram = WeisfeilerLehman(iterations=1, normalize=False).fit(PATHS).compare()
    assert gram.tolist() == [[6, 3, 3], [3, 4, 5], [3, 5, 10]]


def test_normalised():
    gram = WeisfeilerLehman(iterations=1).fit(PATHS).compare()
    expected = [[1, 3 / sqrt(24), 3 / sqrt(60)], [3 / sqrt(24), 1, 5 / sqrt(40)], [3 / sqrt(60), 5 / sqrt(40), 1]]
    np.testing.assert_allclose(gram, expected, rtol=1e-15)


def test_without_iterations_labels_are_counted():
    gram = WeisfeilerLehman(iterations=0, normalize=False).fit(PATHS).compare()
    assert gram.tolist() == [[3, 2, 3], [2, 2, 3], [3, 3, 5]]


def test_features_that_no_fitted_graph_has_count_in_the_length():
    kernel = WeisfeilerLehman(iterations=0).fit([make_path("A")])
    assert kernel.compare([make_path("AB")])[0, 0] == 1 / sqrt(2)
    assert kernel.transform([make_path("AB")]).toarray().tolist() == [[1 / sqrt(2)]]


def test_pinned_features():
    counts = WeisfeilerLehman(iterations=1).count_features([make_path("AB")])[0]
    assert counts.codes.tolist() == [
        *(1249310869337180232, 10840056188734169290),
        *(2590049045565789995, 13633045443299368593),
    ]


@pytest.mark.parametrize("iterations", [-1, 1.5, "2", None, True])
def test_iterations_that_are_none(iterations):
    with pytest.raises(OptionError, match=f"iterations is {iterations!r}, give whole numbers of 0 or more"):
        WeisfeilerLehman(iterations=iterations).fit(PATHS)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("normalize", [True, False])
def test_equal_to_grakel(normalize):
    grakel = pytest.importorskip("grakel")
    graphs = [make_plan(size, seed=size) for size in range(2, 40)]
    inputs = [
        grakel.Graph({node: list(graph[node]) for node in graph}, node_labels=dict(graph.nodes(data="label")))
        for graph in graphs
    ]
    reference = grakel.WeisfeilerLehman(n_iter=4, base_graph_kernel=grakel.VertexHistogram, normalize=normalize)
    expected = reference.fit_transform(inputs[:30]), reference.transform(inputs[30:])
    kernel = WeisfeilerLehman(iterations=4, normalize=normalize).fit(graphs[:30])
    np.testing.assert_allclose(kernel.compare(), expected[0], rtol=1e-12)
    np.testing.assert_allclose(kernel.compare(graphs[30:]), expected[1], rtol=1e-12)
