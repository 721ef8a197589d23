"""All kernels with explicit features: they are kernels, and do not depend on the names of nodes."""

import os
import subprocess
import sys

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.base import clone
from sklearn.exceptions import NotFittedError
from sklearn.model_selection import cross_val_score
from sklearn.pipeline import make_pipeline
from sklearn.svm import SVC

from pianta.errors import GraphError
from pianta.graphs.graph_hopper import GraphHopper
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from tests.labelled_graphs import assert_kernel, labelled_graphs, make_path, make_plan, rename

kernels = pytest.mark.parametrize(
    "kernel",
    [
        WeisfeilerLehman(iterations=3),
        WeisfeilerLehman(iterations=0, normalize=False),
        GraphHopper(),
        GraphHopper(normalize=False),
        NeighborhoodPairs(),
        NeighborhoodPairs(radius=1, distance=1, edge_label="door", normalize=False),
    ],
    ids=str,
)
lists_of_graphs = st.lists(labelled_graphs(), min_size=1, max_size=5)


@pytest.mark.slow
@kernels
@settings(max_examples=40)
@given(lists_of_graphs, st.integers(0, 1000))
def test_isomorphic_graphs_have_identical_values(kernel, graphs, seed):
    kernel.fit(graphs)
    copies = [rename(graph, seed=seed) for graph in graphs]
    gram = kernel.compare(copies)
    np.testing.assert_array_equal(gram, kernel.compare())
    if kernel.normalize:
        np.testing.assert_array_equal(np.diag(gram), [float(len(graph) > 0) for graph in graphs])


@pytest.mark.slow
@kernels
@settings(max_examples=40)
@given(lists_of_graphs)
def test_grams_are_symmetric_and_positive(kernel, graphs):
    gram = kernel.fit(graphs).compare()
    assert gram.shape == (len(graphs), len(graphs))
    assert gram.dtype == np.float64
    assert_kernel(gram)
    if kernel.normalize:
        assert gram.max() <= 1 + 1e-15


@pytest.mark.slow
@kernels
@settings(max_examples=40)
@given(lists_of_graphs, labelled_graphs())
def test_products_of_features_are_the_kernel(kernel, graphs, new):
    features = kernel.fit_transform(graphs)
    np.testing.assert_array_equal(features.toarray(), kernel.transform(graphs).toarray())
    np.testing.assert_allclose((features @ features.T).toarray(), kernel.compare(), atol=1e-12)
    np.testing.assert_allclose((kernel.transform([new]) @ features.T).toarray(), kernel.compare([new]), atol=1e-12)


@pytest.mark.slow
@kernels
@settings(max_examples=40)
@given(lists_of_graphs, labelled_graphs())
def test_a_new_graph_is_compared_as_if_fitted_with_the_others(kernel, graphs, new):
    row = kernel.fit(graphs).compare([new])[0]
    np.testing.assert_allclose(clone(kernel).fit([*graphs, new]).compare()[-1, :-1], row, atol=1e-15)


@kernels
def test_counts_serve_for_all_the_rest(kernel):
    graphs, new = [make_plan(8, seed=1), make_plan(9, seed=2)], [make_plan(7, seed=3)]
    counts, new_counts = kernel.count_features(graphs), kernel.count_features(new)
    same = clone(kernel).fit_counts(counts)
    kernel.fit(graphs)
    np.testing.assert_array_equal(same.compare_counts(), kernel.compare())
    np.testing.assert_array_equal(same.compare_counts(new_counts), kernel.compare(new))
    np.testing.assert_array_equal(same.transform_counts(new_counts).toarray(), kernel.transform(new).toarray())


@kernels
def test_small_and_loose_graphs(kernel):
    loose = nx.disjoint_union(make_path("A"), make_path("B"))
    gram = kernel.fit([nx.Graph(), make_path("A"), make_path("C"), loose]).compare()
    assert not gram[0].any()
    features = sum(len(block.codes) for block in kernel.count_features([make_path("A")]))
    assert gram[1, 1] == (1 if kernel.normalize else features)
    assert gram[1, 2] == gram[2, 3] == 0
    assert gram[1, 3] > 0


@kernels
def test_no_graphs_at_all(kernel):
    assert kernel.fit([]).compare().shape == (0, 0)
    assert kernel.compare([make_path("A")]).shape == (1, 0)
    assert kernel.transform([make_path("A")]).shape == (1, 0)
    kernel.fit([make_path("A")])
    assert kernel.compare([]).shape == (0, 1)
    assert kernel.transform([]).shape[0] == 0


@kernels
def test_graphs_may_come_one_by_one(kernel):
    graphs = [make_plan(8, seed=1), make_plan(9, seed=2)]
    np.testing.assert_array_equal(
        kernel.fit_transform(iter(graphs)).toarray(), kernel.transform(iter(graphs)).toarray()
    )


@kernels
def test_transformers_of_scikit_learn(kernel):
    assert type(kernel)(**kernel.get_params()).get_params() == kernel.get_params()
    copy = clone(kernel)
    with pytest.raises(NotFittedError, match="not fitted yet"):
        copy.compare()
    with pytest.raises(NotFittedError, match="not fitted yet"):
        copy.transform([])
    with pytest.raises(NotFittedError, match="not fitted yet"):
        copy.transform_counts([])


@pytest.mark.slow
@pytest.mark.parametrize("kernel", [WeisfeilerLehman(), GraphHopper(), NeighborhoodPairs()], ids=str)
def test_support_vector_machines_accept_the_features(kernel):
    stars, paths = ([make(size) for size in range(5, 15)] for make in (nx.star_graph, nx.path_graph))
    for graph in (*stars, *paths):
        nx.set_node_attributes(graph, "A", "label")
    classifier = make_pipeline(kernel, SVC(kernel="linear"))
    assert cross_val_score(classifier, stars + paths, ["star"] * 10 + ["path"] * 10, cv=5).mean() >= 0.9


@pytest.mark.parametrize("kernel", [WeisfeilerLehman(), GraphHopper(), NeighborhoodPairs(edge_label="door")], ids=str)
def test_all_faults_of_graphs_are_listed_together(kernel):
    bare = nx.path_graph(7)
    loop = make_path("AB")
    loop.add_edge(0, 0, door="x")
    loop.add_edge(0, 1, door="x")
    with pytest.raises(GraphError) as caught:
        kernel.fit([bare, loop, nx.DiGraph(), nx.MultiGraph(), 5])
    faults = str(caught.value).split("; ")
    doors = ["edges (0, 1), (1, 2), (2, 3), (3, 4), (4, 5), … of graph 0 have no 'door', label them"]
    assert faults == [
        "nodes 0, 1, 2, 3, 4, … of graph 0 have no 'label', label them",
        *(doors if isinstance(kernel, NeighborhoodPairs) else []),
        "nodes 0 of graph 1 have edges to themselves, remove these",
        "graph 2 is a DiGraph, give a networkx.Graph with no directions, no parallel edges",
        "graph 3 is a MultiGraph, give a networkx.Graph with no directions, no parallel edges",
        "graph 4 is a int, give a networkx.Graph with no directions, no parallel edges",
    ]


def test_many_faults_are_cut_short():
    with pytest.raises(GraphError, match=r"; and 2 more$"):
        WeisfeilerLehman().fit([nx.path_graph(1)] * 12)


def test_one_graph_is_no_list_of_graphs():
    with pytest.raises(GraphError, match="graphs is one graph, give a list of graphs"):
        WeisfeilerLehman().fit(make_path("AB"))


def test_labels_are_distinguished_by_their_text():
    one, same, other = (nx.Graph() for _ in range(3))
    one.add_node(0, room=7)
    same.add_node(0, room="7")
    other.add_node(0, room="8")
    assert WeisfeilerLehman(label="room").fit([one, same, other]).compare()[0].tolist() == [1, 1, 0]


SCRIPT = """
import networkx as nx
from pianta.graphs.graph_hopper import GraphHopper
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

graph = nx.Graph()
for name in {"hall", "office", "closet", "kitchen", "stairs", "lab"}:
    graph.add_node(name, label=name[0])
graph.add_edges_from([("hall", "office"), ("hall", "closet"), ("hall", "kitchen"), ("kitchen", "stairs")])
for kernel in (WeisfeilerLehman(), GraphHopper(), NeighborhoodPairs()):
    print(kernel.fit([graph]).transform([graph]).toarray().tolist(), [v.tolist() for v in kernel.vocabularies_])
print(list(graph))
"""


@pytest.mark.slow
def test_results_do_not_depend_on_the_hash_seed():
    outputs = [
        subprocess.run(
            [sys.executable, "-c", SCRIPT],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.splitlines()
        for seed in ("1", "2")
    ]
    # The nodes come in another order.
    assert outputs[0][-1] != outputs[1][-1]
    assert outputs[0][:-1] == outputs[1][:-1]
