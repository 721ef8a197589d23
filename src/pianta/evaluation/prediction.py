"""What was predicted of the unknown part of a floor against what is there (thesis, section 8.3)."""

from __future__ import annotations

from collections.abc import Sequence

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from pianta._types import Floats, Indices
from pianta.evaluation.semantics import BINS, Reliability, measure_reliability
from pianta.graphs.explicit_kernel import ExplicitKernel

# Matchings of nodes that are tried beside the best guess.
RANDOM_STARTS = 3


def measure_divergence(one: Floats, other: Floats) -> Floats:
    """Jensen-Shannon divergence of distributions along the last axis, bits: 0 where they are the same, at most 1."""
    middle = (one + other) / 2

    def relative(part: Floats) -> Floats:
        logs = np.log2(part, out=np.zeros_like(part), where=part > 0)
        of_middle = np.log2(middle, out=np.zeros_like(middle), where=middle > 0)
        return np.asarray((part * (logs - of_middle)).sum(axis=-1))

    return np.maximum(
        (relative(np.broadcast_to(one, middle.shape)) + relative(np.broadcast_to(other, middle.shape))) / 2, 0
    )


def expect_divergence(truth: Floats, drawn_from: Floats, *, count: int, draws: int, seed: int) -> float:
    """The mean divergence from a true distribution of those of so many labels that are drawn from another.

    truth, drawn_from: shape (labels,). count: labels of a draw, above 0.
    """
    drawn = np.random.default_rng(seed).multinomial(count, drawn_from / drawn_from.sum(), size=draws)
    return float(measure_divergence(drawn / count, truth).mean())


def measure_kernel_distances(truth: nx.Graph, guesses: Sequence[nx.Graph], kernel: ExplicitKernel) -> Floats:
    """The distance of a normalised kernel, sqrt(2 - 2 k), of each guess from the truth, 0 … sqrt 2."""
    similarity = kernel.fit([truth]).compare(guesses)[:, 0]
    return np.asarray(np.sqrt(np.maximum(2 - 2 * similarity, 0)))


def bound_edit_distance(one: nx.Graph, other: nx.Graph) -> int:
    """About how many nodes and edges are to be added, removed or, nodes, given another label to make one the other.

    Never less than the edit distance, which takes too long to find: of graphs whose nodes are matched by what they and
    the nodes next to them are (Riesen and Bunke, 2009), or at random, then swapped in pairs as long as that helps.
    """
    size = max(len(one), len(other))
    if not size:
        return 0
    names = sorted({f"={label}" for graph in (one, other) for _, label in graph.nodes(data="label")})
    adjacency = [_pad_adjacency(graph, size) for graph in (one, other)]
    labels = [_pad_labels(graph, names, size) for graph in (one, other)]
    mismatch = np.abs(labels[0][:, None] - labels[1][None]).sum(axis=2).clip(0, 1)
    near = [matrix @ of_nodes for matrix, of_nodes in zip(adjacency, labels, strict=True)]
    around = np.abs(near[0][:, None] - near[1][None]).sum(axis=2) / 2
    random = np.random.default_rng(0)
    starts = [linear_sum_assignment(mismatch + around)[1], *(random.permutation(size) for _ in range(RANDOM_STARTS))]
    return int(min(_swap_pairs(adjacency, mismatch, start) for start in starts))


def measure_label_reliability(
    probabilities: NDArray[np.float64], truth: NDArray[np.integer], *, bins: int = BINS
) -> Reliability:
    """Reliability of each label of each room, probable or not; labels that have no probability and are wrong are none.

    probabilities: shape (rooms, labels). truth: the column of the true label, shape (rooms,).
    """
    is_true = np.arange(probabilities.shape[1]) == np.asarray(truth)[:, None]
    counted = (probabilities > 0) | is_true
    confidence, right = probabilities[counted], is_true[counted]
    edges = np.linspace(0, 1, bins + 1)
    bin_of = np.clip(np.searchsorted(edges, confidence, side="left") - 1, 0, bins - 1)
    counts = np.bincount(bin_of, minlength=bins)
    sums = (np.bincount(bin_of, weights=values, minlength=bins) for values in (confidence, right))
    means = (np.divide(total, counts, out=np.full(bins, np.nan), where=counts > 0) for total in sums)
    return Reliability(edges, counts, *means)


def expect_calibration_error(probabilities: Floats, *, draws: int, seed: int, bins: int = BINS) -> float:
    """The mean calibration error of the top labels if their probabilities were exact: what few rooms leave to chance.

    probabilities: shape (rooms, labels), rooms above 0.
    """
    random = np.random.default_rng(seed)
    top = probabilities.max(axis=1)
    said = np.column_stack([top, np.zeros_like(top)])
    errors = []
    for _ in range(draws):
        wrong = (random.random(len(top)) >= top).astype(np.intp)
        errors.append(measure_reliability(said, wrong, bins=bins).error)
    return float(np.mean(errors))


def _swap_pairs(adjacency: Sequence[Floats], mismatch: Floats, order: Indices) -> float:
    """The fewest edits that swaps of pairs of a matching lead to."""
    cost = float(_count_edits(adjacency, mismatch, order[None])[0])
    firsts, seconds = np.triu_indices(len(order), 1)
    every = np.arange(len(firsts))
    while len(firsts):
        swapped = np.repeat(order[None], len(firsts), axis=0)
        swapped[every, firsts], swapped[every, seconds] = order[seconds], order[firsts]
        costs = _count_edits(adjacency, mismatch, swapped)
        if costs.min() >= cost:
            break
        order, cost = swapped[int(costs.argmin())], float(costs.min())
    return cost


def _pad_labels(graph: nx.Graph, names: Sequence[str], size: int) -> Floats:
    """Which label each node has, shape (size, names); none where a node is missing."""
    labels = np.zeros((size, len(names)))
    for row, (_, label) in enumerate(graph.nodes(data="label")):
        labels[row, names.index(f"={label}")] = 1
    return labels


def _pad_adjacency(graph: nx.Graph, size: int) -> Floats:
    adjacency = np.zeros((size, size))
    adjacency[: len(graph), : len(graph)] = nx.to_numpy_array(graph, weight=None) if len(graph) else 0
    return adjacency


def _count_edits(adjacency: Sequence[Floats], mismatch: Floats, orders: Indices) -> Floats:
    """The edits of each matching, shape (n,); orders: nodes of the second graph, shape (n, size)."""
    moved = adjacency[1][orders[:, :, None], orders[:, None, :]]
    edges = np.abs(adjacency[0] - moved).sum(axis=(1, 2)) / 2
    labels = mismatch[np.arange(mismatch.shape[0]), orders].sum(axis=1)
    return np.asarray(edges + labels)
