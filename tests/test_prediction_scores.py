"""Scores of predictions on answers made by hand."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pianta.evaluation.prediction import (
    bound_edit_distance,
    expect_calibration_error,
    expect_divergence,
    measure_divergence,
    measure_kernel_distances,
    measure_label_reliability,
)
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

SHARES = st.lists(st.integers(0, 9), min_size=4, max_size=4).filter(any)


def label(graph: nx.Graph, labels: str) -> nx.Graph:
    nx.set_node_attributes(graph, dict(zip(graph, labels, strict=True)), "label")
    return graph


def test_divergence():
    half = np.array([0.5, 0.5, 0])
    assert measure_divergence(half, half) == 0
    assert measure_divergence(half, np.array([0, 0, 1.0])) == 1
    # Of [1/2, 1/2] and [1, 0] the middle is [3/4, 1/4]: half of log2 4/3, and of (log2 2/3 + log2 2) / 2.
    expected = (np.log2(4 / 3) + (np.log2(2 / 3) + 1) / 2) / 2
    assert measure_divergence(half, np.array([1.0, 0, 0])) == pytest.approx(expected)
    rows = measure_divergence(np.array([half, [1.0, 0, 0]]), half)
    np.testing.assert_allclose(rows, [0, expected])


@given(SHARES, SHARES)
def test_divergence_is_symmetric_and_below_a_bit(one, other):
    p, q = (np.array(counts) / sum(counts) for counts in (one, other))
    assert measure_divergence(p, q) == pytest.approx(float(measure_divergence(q, p)))
    assert 0 <= measure_divergence(p, q) <= 1 + 1e-12


def test_divergence_that_chance_leaves():
    """One label drawn of two alike is either of them, as far from both as [1, 0] is."""
    half = np.array([0.5, 0.5])
    expected = float(measure_divergence(half, np.array([1.0, 0])))
    assert expect_divergence(half, half * 7, count=1, draws=50, seed=0) == pytest.approx(expected)
    many = [expect_divergence(half, half, count=count, draws=400, seed=0) for count in (2, 8, 64)]
    assert many == sorted(many, reverse=True)
    assert many[-1] < 0.02
    assert expect_divergence(half, np.array([0, 1.0]), count=9, draws=3, seed=0) == pytest.approx(expected)


@pytest.mark.parametrize("kernel", [WeisfeilerLehman(), NeighborhoodPairs()])
def test_kernel_distances(kernel):
    truth = label(nx.path_graph(3), "CCH")
    unusual = label(nx.path_graph(3), "ZZZ")
    larger = label(nx.path_graph(4), "CCCH")
    same, far, near = measure_kernel_distances(truth, [truth, unusual, larger], kernel)
    assert same == 0
    assert far == pytest.approx(2**0.5)
    assert 0 < near < far


def test_kernel_distance_as_written():
    """Without rounds counts of labels are compared: (2, 1) and (1, 1) have k = 3 / sqrt 10."""
    distances = measure_kernel_distances(
        label(nx.path_graph(3), "CCH"), [label(nx.path_graph(2), "CH")], WeisfeilerLehman(iterations=0)
    )
    assert distances[0] == pytest.approx((2 - 6 / 10**0.5) ** 0.5)


def test_edits():
    path = label(nx.path_graph(3), "CCC")
    assert bound_edit_distance(path, path) == 0
    # A label; a node with its edge; an edge.
    assert bound_edit_distance(path, label(nx.path_graph(3), "CHC")) == 1
    assert bound_edit_distance(path, label(nx.path_graph(4), "CCCC")) == 2
    assert bound_edit_distance(path, label(nx.cycle_graph(3), "CCC")) == 1
    assert bound_edit_distance(path, nx.Graph()) == 5
    assert bound_edit_distance(nx.Graph(), nx.Graph()) == 0


@pytest.mark.slow
@given(st.integers(0, 10**6))
def test_edits_bound_the_edit_distance(seed):
    random = np.random.default_rng(seed)
    sizes = random.integers(0, 5, 2).tolist()
    one, other = (
        label(nx.gnp_random_graph(size, 0.5, seed=seed + size), "".join("AB"[i] for i in random.integers(0, 2, size)))
        for size in sizes
    )
    exact = nx.graph_edit_distance(one, other, node_match=lambda first, second: first["label"] == second["label"])
    result = bound_edit_distance(one, other)
    assert result >= exact
    assert result <= len(one) + len(other) + one.number_of_edges() + other.number_of_edges()


def test_edits_do_not_depend_on_the_order_of_equal_graphs():
    ring = label(nx.cycle_graph(6), "CHCLCC")
    turned = label(nx.relabel_nodes(nx.cycle_graph(6), {n: n for n in range(6)}), "CCHCLC")
    assert bound_edit_distance(ring, turned) == 0


def test_reliability_of_every_label():
    """0.8 right, 0.2 wrong; 0.6 wrong, 0.4 right: bins above 0.7, 0.1, 0.5 and 0.3."""
    result = measure_label_reliability(np.array([[0.8, 0.2, 0], [0.6, 0.4, 0]]), np.array([0, 1]))
    assert result.counts.tolist() == [0, 1, 0, 1, 0, 1, 0, 1, 0, 0]
    assert result.accuracy[[1, 3, 5, 7]].tolist() == [0, 1, 0, 1]
    assert result.error == pytest.approx((0.2 + 0.6 + 0.6 + 0.2) / 4)
    # A true label that was held impossible counts, and others without probability do not.
    missed = measure_label_reliability(np.array([[1.0, 0, 0]]), np.array([2]))
    assert missed.counts.tolist() == [1, 0, 0, 0, 0, 0, 0, 0, 0, 1]
    assert missed.error == 1
    assert np.isnan(measure_label_reliability(np.zeros((0, 3)), np.zeros(0, int)).error)


def test_calibration_error_that_chance_leaves():
    """One guess of 0.8 is right in four of five draws: 0.8 · 0.2 + 0.2 · 0.8."""
    one = expect_calibration_error(np.array([[0.8, 0.2]]), draws=4000, seed=0)
    assert one == pytest.approx(0.32, abs=0.02)
    assert expect_calibration_error(np.array([[1.0, 0]] * 3), draws=5, seed=0) == 0
    many = expect_calibration_error(np.array([[0.1, 0.8]] * 400), draws=50, seed=0)
    # The mean of |p - 0.8| of 400, 0.8 times its standard deviation of 0.02.
    assert many == pytest.approx(0.016, abs=0.005)
