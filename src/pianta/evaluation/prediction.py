"""Predictions for the unexplored part of a floor against the truth (thesis, section 8.3)."""

from __future__ import annotations

from collections.abc import Sequence

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from pianta._types import Floats, Indices
from pianta.evaluation.semantics import BINS, Reliability, bin_reliability, measure_reliability
from pianta.graphs.explicit_kernel import ExplicitKernel

# Random matchings of nodes from which the search also starts.
RANDOM_STARTS = 3


def measure_divergence(one: Floats, other: Floats) -> Floats:
    """Jensen-Shannon divergence of distributions along the last axis, bits: 0 if they are equal, at most 1."""
    middle = (one + other) / 2

    def relative(part: Floats) -> Floats:
        logs = np.log2(part, out=np.zeros_like(part), where=part > 0)
        middle_logs = np.log2(middle, out=np.zeros_like(middle), where=middle > 0)
        return np.asarray((part * (logs - middle_logs)).sum(axis=-1))

    return np.maximum(
        (relative(np.broadcast_to(one, middle.shape)) + relative(np.broadcast_to(other, middle.shape))) / 2, 0
    )


def expect_divergence(truth: Floats, source: Floats, *, count: int, draws: int, seed: int) -> float:
    """The mean divergence between a true distribution and samples of `count` labels from another, `source`.

    truth, source: shape (labels,). count: above 0.
    """
    samples = np.random.default_rng(seed).multinomial(count, source / source.sum(), size=draws)
    return float(measure_divergence(samples / count, truth).mean())


def measure_kernel_distances(truth: nx.Graph, guesses: Sequence[nx.Graph], kernel: ExplicitKernel) -> Floats:
    """The distance of a normalised kernel, sqrt(2 - 2 k), of each guess from the truth, 0 … sqrt 2."""
    similarity = kernel.fit([truth]).compare(guesses)[:, 0]
    return np.asarray(np.sqrt(np.maximum(2 - 2 * similarity, 0)))


def bound_edit_distance(one: nx.Graph, other: nx.Graph) -> int:
    """An upper bound of the edit distance of graphs: added, removed and relabelled nodes, added and removed edges.

    The exact distance takes too long. Nodes are matched by their labels and those of their neighbours (Riesen and
    Bunke, 2009), or at random; then pairs of the matching are swapped while that helps.
    """
    size = max(len(one), len(other))
    if not size:
        return 0
    names = sorted({f"={label}" for graph in (one, other) for _, label in graph.nodes(data="label")})
    adjacency = [_pad_adjacency(graph, size) for graph in (one, other)]
    labels = [_pad_labels(graph, names, size) for graph in (one, other)]
    mismatch = np.abs(labels[0][:, None] - labels[1][None]).sum(axis=2).clip(0, 1)
    near = [matrix @ node_labels for matrix, node_labels in zip(adjacency, labels, strict=True)]
    around = np.abs(near[0][:, None] - near[1][None]).sum(axis=2) / 2
    random = np.random.default_rng(0)
    starts = [linear_sum_assignment(mismatch + around)[1], *(random.permutation(size) for _ in range(RANDOM_STARTS))]
    return int(min(_swap_pairs(adjacency, mismatch, start) for start in starts))


def measure_label_reliability(
    probabilities: NDArray[np.float64], truth: NDArray[np.integer], *, bins: int = BINS
) -> Reliability:
    """Reliability of every label of each room, except wrong labels with probability 0.

    probabilities: shape (rooms, labels). truth: the column of the true label, shape (rooms,).
    """
    is_true = np.arange(probabilities.shape[1]) == np.asarray(truth)[:, None]
    counted = (probabilities > 0) | is_true
    return bin_reliability(probabilities[counted], is_true[counted], bins=bins)


def expect_calibration_error(probabilities: Floats, *, draws: int, seed: int, bins: int = BINS) -> float:
    """The expected calibration error of the top labels if their probabilities were exact: the effect of few rooms.

    probabilities: shape (rooms, labels), rooms above 0.
    """
    random = np.random.default_rng(seed)
    top = probabilities.max(axis=1)
    columns = np.column_stack([top, np.zeros_like(top)])
    errors = []
    for _ in range(draws):
        wrong = (random.random(len(top)) >= top).astype(np.intp)
        errors.append(measure_reliability(columns, wrong, bins=bins).error)
    return float(np.mean(errors))


def _swap_pairs(adjacency: Sequence[Floats], mismatch: Floats, order: Indices) -> float:
    """The number of edits after greedy swaps of pairs of a matching."""
    cost = float(_count_edits(adjacency, mismatch, order[None])[0])
    firsts, seconds = np.triu_indices(len(order), 1)
    rows = np.arange(len(firsts))
    while len(firsts):
        swapped = np.repeat(order[None], len(firsts), axis=0)
        swapped[rows, firsts], swapped[rows, seconds] = order[seconds], order[firsts]
        costs = _count_edits(adjacency, mismatch, swapped)
        if costs.min() >= cost:
            break
        order, cost = swapped[int(costs.argmin())], float(costs.min())
    return cost


def _pad_labels(graph: nx.Graph, names: Sequence[str], size: int) -> Floats:
    """The label of each node as a one-hot row, shape (size, names); zeros for missing nodes."""
    labels = np.zeros((size, len(names)))
    for row, (_, label) in enumerate(graph.nodes(data="label")):
        labels[row, names.index(f"={label}")] = 1
    return labels


def _pad_adjacency(graph: nx.Graph, size: int) -> Floats:
    adjacency = np.zeros((size, size))
    adjacency[: len(graph), : len(graph)] = nx.to_numpy_array(graph, weight=None) if len(graph) else 0
    return adjacency


def _count_edits(adjacency: Sequence[Floats], mismatch: Floats, orders: Indices) -> Floats:
    """The number of edits for each matching, shape (n,); orders: nodes of the second graph, shape (n, size)."""
    moved = adjacency[1][orders[:, :, None], orders[:, None, :]]
    edges = np.abs(adjacency[0] - moved).sum(axis=(1, 2)) / 2
    labels = mismatch[np.arange(mismatch.shape[0]), orders].sum(axis=1)
    return np.asarray(edges + labels)
