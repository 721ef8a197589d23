"""Graph Hopper on vectors: a slow sum over nodes, exactness, what is fitted, and GraKeL as an oracle."""

import re
from math import exp, inf, nan

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.model_selection import cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.svm import SVC

from pianta.errors import GraphError, OptionError
from pianta.graphs.gaussian_hopper import GaussianGraphHopper
from pianta.graphs.graph_hopper import GraphHopper
from pianta.labels import SCHOOL, LabelSet
from pianta.rooms.thesis_features import ROOM_FEATURES, compute_room_features
from tests.labelled_floors import labelled_floors
from tests.labelled_graphs import assert_kernel, labelled_graphs, make_path, make_plan, rename

PLANS = [make_plan(size, seed=size) for size in range(4, 18, 2)]
filled_graphs = labelled_graphs().filter(len)


def make_numbered(*numbers: object) -> nx.Graph:
    graph = make_path("A" * len(numbers))
    nx.set_node_attributes(graph, dict(enumerate(numbers)), "features")
    return graph


def test_two_nodes_and_one():
    # In the pair, each node is a path without edges, and it is at both positions of paths of one edge. Between the two
    # nodes k is e^-1.
    kernel = GaussianGraphHopper(gamma=0.25, standardize=False, normalize=False)
    gram = kernel.fit([make_numbered(0, 2), make_numbered(1)]).compare()
    np.testing.assert_allclose(gram, [[3 * 2 + 3 * 2 * exp(-1), 2 * exp(-0.25)], [2 * exp(-0.25), 1]], rtol=1e-15)


def test_scale_is_that_of_scikit_learn():
    graphs = [make_numbered((0, 10, 5), (4, 10, 5)), make_numbered((2, 40, 5))]
    together = np.array([[0, 10, 5], [4, 10, 5], [2, 40, 5]])
    raw = GaussianGraphHopper(standardize=False).fit(graphs)
    assert raw.gamma_ == SVC(kernel="rbf").fit(together, [0, 1, 1])._gamma
    kernel = GaussianGraphHopper().fit(graphs)
    np.testing.assert_allclose(kernel.means_, [2, 20, 5])
    np.testing.assert_allclose(kernel.scales_, [(8 / 3) ** 0.5, 200**0.5, 1])
    # Two of three columns have variance 1, the third is constant.
    assert kernel.gamma_ == pytest.approx(1 / (3 * 2 / 3))
    assert GaussianGraphHopper(gamma=0.3).fit(graphs).gamma_ == 0.3
    assert GaussianGraphHopper().fit([make_numbered(1, 1)]).gamma_ == 1


def test_units_do_not_matter_when_standardised():
    scaled = [graph.copy() for graph in PLANS]
    for graph in scaled:
        for node in graph:
            graph.nodes[node]["features"] = np.array(graph.nodes[node]["features"]) * (100, 1, 0.01) + (5, 0, 0)
    kernel = GaussianGraphHopper()
    np.testing.assert_allclose(kernel.fit(PLANS).compare(), kernel.fit(scaled).compare(), rtol=1e-10)


@pytest.mark.slow
@given(st.lists(filled_graphs, min_size=1, max_size=4), st.integers(0, 1000), st.booleans(), st.booleans())
def test_isomorphic_graphs_are_alike_to_the_bit(graphs, seed, standardize, labelled):
    kernel = GaussianGraphHopper(standardize=standardize, label="label" if labelled else None).fit(graphs)
    gram = kernel.compare([rename(graph, seed=seed) for graph in graphs])
    assert np.diag(gram).tolist() == [1] * len(graphs)
    np.testing.assert_allclose(gram, kernel.compare(), rtol=1e-14)


def test_large_isomorphic_graphs_are_alike_to_the_bit():
    graphs = [make_plan(size, seed=size) for size in (30, 57, 100)]
    kernel = GaussianGraphHopper().fit(graphs)
    assert np.diag(kernel.compare([rename(graph, seed=1) for graph in graphs])).tolist() == [1, 1, 1]


@pytest.mark.slow
@given(st.lists(filled_graphs, min_size=1, max_size=4), labelled_graphs())
def test_grams_are_kernels_and_transform_keeps_them(graphs, new):
    kernel = GaussianGraphHopper()
    features = kernel.fit_transform(graphs)
    gram = kernel.compare()
    assert_kernel(gram)
    assert np.diag(gram).tolist() == [1] * len(graphs)
    np.testing.assert_allclose(features @ features.T, gram, atol=1e-6)
    np.testing.assert_allclose(kernel.transform(graphs), features, atol=1e-5)
    np.testing.assert_allclose(kernel.transform([new]) @ features.T, kernel.compare([new]), atol=1e-5)


def test_a_new_graph_is_compared_as_if_fitted_with_the_others():
    kernel = GaussianGraphHopper(gamma=0.2, standardize=False)
    row = kernel.fit(PLANS[:-1]).compare(PLANS[-1:])[0]
    np.testing.assert_allclose(kernel.fit(PLANS).compare()[-1, :-1], row, rtol=1e-14)


def test_labels_have_to_be_the_same_too():
    for plan in (alike := [plan.copy() for plan in PLANS]):
        nx.set_node_attributes(plan, 0.0, "features")
    kernel = GaussianGraphHopper(label="label", normalize=False).fit(alike)
    np.testing.assert_array_equal(kernel.compare(), GraphHopper(normalize=False).fit(PLANS).compare())
    assert (GaussianGraphHopper(normalize=False).fit(alike).compare() >= kernel.compare()).all()


def test_graphs_without_nodes_and_of_several_parts():
    parts = nx.disjoint_union(make_numbered(0, 1), make_numbered(0))
    gram = GaussianGraphHopper().fit([nx.Graph(), parts, make_numbered(0)]).compare()
    assert not gram[0].any()
    assert gram[1, 1] == gram[2, 2] == 1
    assert 0 < gram[1, 2] < 1


def test_rooms_of_floors():
    floors = labelled_floors()
    graphs = [floor.graph() for floor in floors]
    for floor, graph in zip(floors, graphs, strict=True):
        names = SCHOOL.map_labels((room.label for room in floor.rooms), LabelSet.F_C_E_S)
        nx.set_node_attributes(graph, dict(zip(graph, names, strict=True)), "label")
        nx.set_node_attributes(graph, dict(zip(graph, compute_room_features(floor), strict=True)), "features")
    kernel = GaussianGraphHopper(label="label").fit(graphs)
    assert kernel.means_.shape == (len(ROOM_FEATURES),)
    gram = kernel.compare()
    assert np.diag(gram).tolist() == [1] * len(floors)
    # Pairs of floors are of one shape, and more similar than floors of different shapes.
    np.fill_diagonal(gram, 0)
    assert gram.argmax(axis=1).tolist() == [1, 0, 3, 2, 5, 4]


def test_a_column_that_never_varies_does_not_count():
    kernel = GaussianGraphHopper(gamma=1).fit([make_numbered((0.1, 1), (0.1, 2), (0.1, 4))])
    assert kernel.scales_[0] == 1


def test_changing_a_gram_matrix_changes_no_later_one():
    kernel = GaussianGraphHopper(normalize=False).fit(PLANS)
    kernel.compare()[:] = 0
    assert kernel.compare().all()


def test_no_graphs_at_all():
    for graphs in ([], [nx.Graph()]):
        with pytest.raises(GraphError, match="nodes"):
            GaussianGraphHopper().fit(graphs)
    kernel = GaussianGraphHopper().fit([make_numbered(0, 1)])
    assert kernel.compare([]).shape == (0, 1)
    assert kernel.transform([]).shape == (0, 1)


def test_transformer_of_scikit_learn():
    kernel = GaussianGraphHopper(gamma=0.5, label="label")
    assert clone(kernel).get_params() == kernel.get_params()
    assert repr(kernel) == "GaussianGraphHopper(gamma=0.5, label='label')"
    with pytest.raises(NotFittedError, match="not fitted yet"):
        kernel.compare()
    small, large = (
        [make_numbered(*(at + (k % 3) * 0.1 for k in range(size))) for size in range(3, 13)] for at in (0, 3)
    )
    classifier = make_pipeline(GaussianGraphHopper(), SVC(kernel="linear"))
    assert cross_val_score(classifier, small + large, [0] * 10 + [1] * 10, cv=5).mean() == 1


def test_all_nodes_without_numbers_are_listed():
    graphs = [make_numbered((1, 2), (1, nan), "x"), make_numbered((1, 2), (1, 2, 3), (1, inf), None)]
    with pytest.raises(GraphError) as caught:
        GaussianGraphHopper().fit(graphs)
    assert re.match(r"nodes 1, 2 of graph 0 .*features.*; nodes 1, 2, 3 of graph 1 .*features", str(caught.value))
    with pytest.raises(GraphError, match="features"):
        GaussianGraphHopper().fit([make_numbered(1, 2)]).compare([make_numbered((1, 2))])
    with pytest.raises(GraphError, match="features"):
        GaussianGraphHopper().fit([make_path("AB")])
    with pytest.raises(GraphError, match="kind"):
        GaussianGraphHopper(label="kind").fit([make_numbered(1, 2)])


@pytest.mark.parametrize("gamma", [0, -1, nan, inf, "auto", None])
def test_invalid_gammas_are_refused(gamma):
    with pytest.raises(OptionError, match=f"gamma.*{gamma!r}"):
        GaussianGraphHopper(gamma=gamma).fit(PLANS)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("normalize", [True, False])
def test_equal_to_grakel(normalize):
    grakel = pytest.importorskip("grakel")
    grakel_graphs = [
        grakel.Graph({node: list(graph[node]) for node in graph}, node_labels=dict(graph.nodes(data="features")))
        for graph in PLANS
    ]
    expected = grakel.GraphHopper(normalize=normalize, kernel_type=("gaussian", 0.3)).fit_transform(grakel_graphs)
    kernel = GaussianGraphHopper(gamma=0.3, standardize=False, normalize=normalize)
    np.testing.assert_allclose(kernel.fit(PLANS).compare(), expected, rtol=1e-10)
