"""A pairwise random field over the rooms of a floor, which decides about their labels together.

A corridor is hard to recognise by its shape alone. The unary potentials are the probabilities that a classifier gives
each room; the pairwise ones say which labels occur on both sides of a door, and on rooms that are alike. Marginals come
from belief propagation (Pearl 1988), which is exact on trees; graphs of floors are nearly trees (thesis, section 5.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats

Edges = NDArray[np.intp]

# Belief propagation: most iterations, share of the old message that stays, largest change when it has converged.
MAX_ITERATIONS = 50
DAMPING = 0.3
TOLERANCE = 1e-6
# Lower bound of a probability of the classifier: less is ignorance of the forest, not knowledge. Chosen by hand.
MIN_PROBABILITY = 0.005
# Temperature, door strength and alike strength at the start of the fit, and their bounds.
START = (1.0, 0.1, 0.1)
LOWER_BOUNDS = (0.2, 0, 0)
UPPER_BOUND = 3.0


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """Pairs of rooms that influence each other, rows of shape (N, 2).

    doors: joined by a door. alike: of nearly the same size and shape. share: weight of each pair of alike rooms, so
    that a row of twenty classrooms does not count twenty times, shape (N,).
    """

    doors: Edges
    alike: Edges
    share: Floats


@dataclass(frozen=True, eq=False)
class RandomField:
    """Potentials of a field over L labels.

    doors, alike: log of how much more often than by chance two labels meet through a door, or on two rooms that are
    alike, shape (L, L). temperature: divides the log probabilities of the classifier. door_strength, alike_strength:
    factors of the pairwise potentials.
    """

    doors: Floats
    alike: Floats
    temperature: float = 1.0
    door_strength: float = 0.0
    alike_strength: float = 0.0

    def compute_marginals(self, probabilities: Floats, near: Neighbourhood) -> Floats:
        """Marginal probabilities of the rooms, shape (n, L), given those of the classifier, shape (n, L)."""
        unary = np.log(np.maximum(probabilities, MIN_PROBABILITY)) / self.temperature
        pairs = np.concatenate([near.doors, near.alike])
        doors = np.broadcast_to(self.door_strength * self.doors, (len(near.doors), *self.doors.shape))
        alike = (self.alike_strength * near.share)[:, None, None] * self.alike
        return propagate_beliefs(unary, pairs, np.concatenate([doors, alike]))


def propagate_beliefs(unary: Floats, pairs: Edges, pairwise: Floats) -> Floats:
    """Marginals by loopy belief propagation, shape (n, L); exact if the pairs form no loop.

    unary: log potentials of n variables, shape (n, L). pairs: shape (m, 2). pairwise: their log potentials, shape
    (m, L, L), rows for the label of the first variable.
    """
    count, labels = len(pairs), unary.shape[1]
    source, target = np.concatenate([pairs, pairs[:, ::-1]]).T.astype(np.intp)
    factors = np.exp(np.concatenate([pairwise, pairwise.transpose(0, 2, 1)])).transpose(1, 2, 0).copy()
    # A column for each message, as numpy is slow along a short last axis.
    messages = np.zeros((labels, 2 * count))
    for _ in range(MAX_ITERATIONS):
        totals = _add_messages(unary, messages, target)
        # All messages to the source of each message, except the one from its target.
        incoming = totals.take(source, axis=1) - np.roll(messages, count, axis=1)
        weights = np.exp(incoming - incoming.max(axis=0))
        sums = np.einsum("ie,ije->je", weights, factors)
        outgoing = np.log(sums / sums.sum(axis=0))
        change = float(np.abs(outgoing - messages).max(initial=0))
        messages = DAMPING * messages + (1 - DAMPING) * outgoing
        if change < TOLERANCE:
            break
    beliefs = _add_messages(unary, messages, target).T
    beliefs -= beliefs.max(axis=1, keepdims=True)
    return np.asarray(np.exp(beliefs) / np.exp(beliefs).sum(axis=1, keepdims=True))


def _add_messages(unary: Floats, messages: Floats, target: NDArray[np.intp]) -> Floats:
    """Unary potentials, shape (n, L), plus all messages to each variable, shapes (L, M) and (M,); shape (L, n)."""
    sums = [np.bincount(target, weights=row, minlength=len(unary)) for row in messages]
    return np.asarray(unary.T + np.array(sums))


def fit_random_field(
    probabilities: Floats, truth: NDArray[np.intp], near: Neighbourhood, weights: Floats
) -> RandomField:
    """The field under which the true labels of a set of floors are most probable.

    probabilities: of a classifier that was not trained on these rooms, shape (n, L). truth: shape (n,).
    weights: of each room, shape (n,); a pair has the mean of its rooms.
    The tables are counts, with one added to each cell; temperature and strengths minimise the mean negative log
    marginal of the true labels.
    """
    from scipy.optimize import minimize

    labels = probabilities.shape[1]
    doors, alike = (
        _compute_mutual_information(truth[pairs], weights[pairs].mean(axis=1), labels)
        for pairs in (near.doors, near.alike)
    )

    def build(parameters: Sequence[float]) -> RandomField:
        temperature, door, alike_strength = np.clip(parameters, LOWER_BOUNDS, UPPER_BOUND).tolist()
        return RandomField(doors, alike, temperature, door, alike_strength)

    def loss(parameters: Sequence[float]) -> float:
        marginals = build(parameters).compute_marginals(probabilities, near)
        losses = -np.log(np.maximum(marginals[np.arange(len(truth)), truth], 1e-9))
        return float(np.average(losses, weights=weights))

    fit = minimize(loss, START, method="Nelder-Mead", options={"maxfev": 90, "xatol": 0.01, "fatol": 1e-4})
    return build(fit.x)


def _compute_mutual_information(labels: NDArray[np.intp], weights: Floats, count: int) -> Floats:
    """Pointwise mutual information of the labels of pairs, shapes (n, 2) and (n,), as a table (count, count)."""
    joint = np.ones((count, count))
    for one, other in (labels.T, labels.T[::-1]) if len(labels) else ():
        np.add.at(joint, (one, other), weights)
    joint /= joint.sum()
    marginal = joint.sum(axis=1)
    return np.asarray(np.log(joint / np.outer(marginal, marginal)))
