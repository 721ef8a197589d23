"""The classifier two-sample test: metrics by hand, different sets, equal sources, copies, and real schools."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.errors import GraphError, OptionError
from pianta.evaluation.two_sample import (
    STRUCTURE_METRICS,
    TwoSampleScores,
    describe_structure,
    forest_two_sample_test,
    kernel_two_sample_test,
)
from pianta.graphs.metrics import find_corridors
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman
from pianta.labels import SCHOOL
from tests.labelled_graphs import labelled_graphs, make_path, make_plan, rename
from tests.school_graphs import read_samples, read_schools

KERNELS = [WeisfeilerLehman(iterations=2), NeighborhoodPairs(radius=1, distance=2)]


def test_a_triangle_with_a_tail():
    described = describe_structure(nx.Graph([(0, 1), (1, 2), (2, 0), (0, 3)]), {0})
    assert dict(zip(STRUCTURE_METRICS, described, strict=True)) == pytest.approx(
        {
            "nodes": 4,
            "edges": 4,
            "nodes_r": 3,
            "nodes_c": 1,
            "mean_degree": 2,
            "largest_degree": 3,
            "leaves": 1,
            "path_length": (4 * 1 + 2 * 2) / 6,
            "diameter": 2,
            "art_points": 1,
            "assortativity": -5 / 7,
            "cycles": 1,
            "transitivity": 3 / 5,
        }
    )
    assert described.shape == (13,)


def test_measures_that_do_not_exist_are_0():
    assert describe_structure(nx.Graph(), ()).tolist() == [0] * 13
    assert describe_structure(nx.empty_graph(2), ()).tolist() == [2, 0, 2] + [0] * 10
    # Two rings of three: two cycles in two parts, and no assortativity.
    rings = nx.disjoint_union(nx.cycle_graph(3), nx.cycle_graph(3))
    assert describe_structure(rings, ()).tolist() == [6, 6, 6, 0, 2, 2, 0, 1, 1, 0, 0, 2, 1]


@pytest.mark.slow
@given(labelled_graphs(), st.integers(0, 99))
def test_names_change_nothing(graph, seed):
    renamed = rename(graph, seed=seed)
    described = [
        describe_structure(one, {node for node, label in one.nodes(data="label") if label == "A"})
        for one in (graph, renamed)
    ]
    np.testing.assert_allclose(described[1], described[0], atol=1e-9)


@pytest.mark.parametrize("kernel", KERNELS)
def test_a_kernel_always_separates_other_labels(kernel):
    real, generated = ([make_path(label * size) for size in range(3, 9)] for label in ("AB", "CD"))
    expected = TwoSampleScores((1, 1), (1, 1))
    assert kernel_two_sample_test(real, [*generated, *generated], kernel, repeats=2, seed=0) == expected
    assert not hasattr(kernel, "fitted_")


def test_siblings_are_recognised_unless_their_group_is_left_out():
    # Graphs of a group are equal; two groups have no label in common.
    real, generated = ([make_path(label * 3) for label in labels for _ in range(2)] for labels in ("ABCD", "EFGH"))
    groups = list("aabbccdd"), list("eeffgghh")
    assert kernel_two_sample_test(real, generated, KERNELS[0], repeats=2, seed=0).group_out == ()
    scores = kernel_two_sample_test(real, generated, KERNELS[0], repeats=2, seed=0, groups=groups)
    # Without its sibling each graph is as far from all others: both of a pair are predicted to be of one set.
    assert (scores.pair_out, scores.group_out) == ((1, 1), (0.5, 0.5))


def test_a_set_of_one_group():
    graphs = [make_path("AB"), make_path("ABA")]
    with pytest.raises(GraphError, match="all generated graphs are of one group, give those of 2 at least"):
        kernel_two_sample_test(graphs, graphs, KERNELS[0], seed=0, groups=("ab", "cc"))


@pytest.mark.slow
def test_trees_always_separate_other_features():
    real, generated = np.arange(12.0).reshape(6, 2), 100 + np.arange(20.0).reshape(10, 2)
    assert forest_two_sample_test(real, generated, repeats=2, seed=0, trees=10) == TwoSampleScores((1, 1), (1, 1))


@pytest.mark.slow
def test_a_classifier_without_information_predicts_the_larger_set():
    # Without a single graph its set is the smaller one, so it is classified wrongly; of a pair one is right.
    expected = TwoSampleScores((0, 0, 0), (0.5, 0.5, 0.5))
    assert (
        kernel_two_sample_test([make_path("AB")] * 5, [make_path("BA")] * 7, KERNELS[0], repeats=3, seed=0) == expected
    )
    assert forest_two_sample_test(np.ones((5, 2)), np.ones((7, 2)), repeats=3, seed=0, trees=10) == expected


@pytest.mark.slow
@pytest.mark.parametrize("kernel", KERNELS)
def test_the_accuracy_of_a_kernel_on_one_source_is_a_half(kernel):
    # The accuracy on a single set of 20 real graphs varies by chance.
    sources = [[make_plan(12, seed=100 * source + graph) for graph in range(60)] for source in range(20)]
    message = [kernel_two_sample_test(plans[:20], plans[20:], kernel, repeats=2, seed=0) for plans in sources]
    pair_out = np.mean([scores.pair_out for scores in message])
    assert pair_out == pytest.approx(0.5, abs=0.04)
    assert np.mean([scores.one_out for scores in message]) < pair_out


@pytest.mark.slow
def test_the_accuracy_of_trees_on_one_source_is_a_half():
    sources = np.random.default_rng(0).normal(size=(20, 30, 3))
    message = [forest_two_sample_test(rows[:10], rows[10:], repeats=1, seed=0, trees=10) for rows in sources]
    assert np.mean([scores.pair_out for scores in message]) == pytest.approx(0.5, abs=0.06)


@pytest.mark.slow
def test_the_accuracy_on_copies_is_below_a_half():
    real = [make_plan(12, seed=seed) for seed in range(20)]
    scores = kernel_two_sample_test(real, [rename(graph, seed=1) for graph in real], KERNELS[0], repeats=5, seed=0)
    assert max(scores.pair_out) < 0.25


@pytest.mark.slow
def test_each_repeat_draws_other_graphs():
    # Four of the generated graphs differ from the real ones, four are copies.
    real, others = ([make_path(label * size) for size in range(1, 5)] for label in ("AB", "CD"))
    run_test = [kernel_two_sample_test(real, [*real, *others], KERNELS[0], repeats=20, seed=seed) for seed in (0, 0, 1)]
    assert len(set(run_test[0].pair_out)) > 2
    assert len(set(run_test[0].one_out)) > 2
    assert run_test[0] == run_test[1] != run_test[2]


@pytest.mark.slow
def test_a_seed_grows_the_same_trees():
    features = np.random.default_rng(0).normal(size=(30, 3))
    run_test = [
        forest_two_sample_test(features[:10], features[10:], repeats=4, seed=seed, trees=5) for seed in (0, 0, 1)
    ]
    assert run_test[0] == run_test[1] != run_test[2]


@pytest.mark.slow
def test_each_fold_grows_other_trees():
    # The same graphs are left out in each repeat.
    features = np.random.default_rng(0).normal(size=(20, 3))
    assert len(set(forest_two_sample_test(features[:10], features[10:], repeats=5, seed=0, trees=1).one_out)) > 1


def test_with_a_small_cost_the_classifier_has_no_information():
    real, generated = ([make_plan(9, seed=seed) for seed in seeds] for seeds in (range(8), range(8, 16)))
    assert kernel_two_sample_test(real, generated, KERNELS[0], repeats=1, seed=0, cost=1e-6).one_out == (0,)


def test_sets_that_are_too_small():
    paths = [make_path("AB")] * 3
    with pytest.raises(GraphError, match="real"):
        kernel_two_sample_test(paths[:1], paths, KERNELS[0], seed=0)
    with pytest.raises(GraphError, match="generated"):
        forest_two_sample_test(np.ones((3, 1)), np.ones((2, 1)), seed=0)


@pytest.mark.parametrize("shapes", [((3, 2), (3, 1)), ((3,), (3,)), ((3, 2), (3,))])
def test_features_of_other_lengths(shapes):
    with pytest.raises(OptionError, match="length"):
        forest_two_sample_test(*map(np.ones, shapes), seed=0)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pianta.errors.BuildingWarning")
def test_the_samples_of_the_thesis_beside_real_schools(data):
    real, samples = read_schools(data), read_samples(data)
    kernels = NeighborhoodPairs(radius=2, distance=4), WeisfeilerLehman(iterations=5)
    message = [np.mean(kernel_two_sample_test(real, samples, kernel, seed=0).pair_out) for kernel in kernels]
    assert message == pytest.approx([0.44, 0.40], abs=0.06)
    features = [
        np.array([describe_structure(graph, find_corridors(graph, SCHOOL)) for graph in graphs])
        for graphs in (real, samples)
    ]
    assert np.mean(forest_two_sample_test(*features, seed=0, repeats=2, trees=20).pair_out) == pytest.approx(
        0.6, abs=0.1
    )
