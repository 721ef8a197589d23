"""A pairwise random field over the rooms of a floor: its labels are judged together.

Nobody knows a corridor by its shape alone. The unary potentials are the probabilities that a classifier gives each
room; the pairwise ones say which labels are found on both sides of a door, and on rooms that are alike. Marginals come
from belief propagation (Pearl 1988), which is exact on trees; graphs of floors are nearly trees (thesis, section 5.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats

Edges = NDArray[np.intp]

ITERATIONS, DAMPING, TOLERANCE = 50, 0.3, 1e-6
# A probability below this is the forest's ignorance, not knowledge.
LEAST = 0.005
# Strengths from which the fit starts, and the largest that it may find.
START, STRONGEST = (1.0, 0.1, 0.1), 3.0


@dataclass(frozen=True, eq=False)
class Neighbourhood:
    """Pairs of rooms that bear on each other, shape (N, 2) each, and the share that each pair of alike rooms counts.

    share: shape (N,); a room in a row of twenty classrooms is not told twenty times what the others are.
    """

    doors: Edges
    alike: Edges
    share: Floats


@dataclass(frozen=True, eq=False)
class RandomField:
    """Potentials of a field over L labels.

    doors, alike: shape (L, L), log of how much more often two labels meet through a door, or on two rooms that are
    alike, than by chance. temperature: divides the log probabilities of the classifier. door_strength, alike_strength:
    factors of the pairwise potentials.
    """

    doors: Floats
    alike: Floats
    temperature: float = 1.0
    door_strength: float = 0.0
    alike_strength: float = 0.0

    def compute_marginals(self, probabilities: Floats, near: Neighbourhood) -> Floats:
        """Marginal probabilities of the rooms, shape (n, L), given those of the classifier, shape (n, L)."""
        unary = np.log(np.maximum(probabilities, LEAST)) / self.temperature
        pairs = np.concatenate([near.doors, near.alike])
        strengths = [self.door_strength * np.ones(len(near.doors)), self.alike_strength * near.share]
        tables = [self.doors] * len(near.doors) + [self.alike] * len(near.alike)
        scaled = np.concatenate(strengths)[:, None, None] * np.array(tables).reshape(-1, *self.doors.shape)
        return propagate_beliefs(unary, pairs, scaled)


def propagate_beliefs(unary: Floats, pairs: Edges, pairwise: Floats) -> Floats:
    """Marginals by loopy belief propagation, shape (n, L); exact where the pairs form no loop.

    unary: log potentials of n variables, shape (n, L). pairs: shape (m, 2). pairwise: their log potentials, shape
    (m, L, L), the first variable's label first.
    """
    count = len(pairs)
    source, target = np.concatenate([pairs, pairs[:, ::-1]]).T.astype(np.intp)
    reverse = np.roll(np.arange(2 * count), count)
    factors = np.exp(np.concatenate([pairwise, pairwise.transpose(0, 2, 1)]))
    messages = np.zeros((2 * count, unary.shape[1]))
    for _ in range(ITERATIONS):
        # What a room has heard from all others but the one that it tells
        heard = _gather(unary, target, messages)[source] - messages[reverse]
        weights = np.exp(heard - heard.max(axis=1, keepdims=True))
        sums = np.matmul(weights[:, None], factors)[:, 0]
        told = np.log(sums / sums.sum(axis=1, keepdims=True))
        change = float(np.abs(told - messages).max(initial=0))
        messages = DAMPING * messages + (1 - DAMPING) * told
        if change < TOLERANCE:
            break
    beliefs = _gather(unary, target, messages)
    beliefs -= beliefs.max(axis=1, keepdims=True)
    return np.asarray(np.exp(beliefs) / np.exp(beliefs).sum(axis=1, keepdims=True))


def _gather(unary: Floats, target: Edges, messages: Floats) -> Floats:
    """Unary potentials and all messages that each variable got, shape (n, L)."""
    total = unary.copy()
    np.add.at(total, target, messages)
    return total


def fit_random_field(
    probabilities: Floats, truth: NDArray[np.intp], near: Neighbourhood, weights: Floats
) -> RandomField:
    """Field that makes the true labels of a set of floors, taken as one, most probable.

    probabilities: of a classifier that has not seen these rooms, shape (n, L). truth: shape (n,).
    weights: how much each room counts, shape (n,); a pair counts the mean of its rooms.
    The tables are counted, with one added to each cell; temperature and strengths minimise the mean negative log
    marginal of the true labels.
    """
    from scipy.optimize import minimize

    labels = probabilities.shape[1]
    doors, alike = (
        _count_meetings(truth[pairs], weights[pairs].mean(axis=1), labels) for pairs in (near.doors, near.alike)
    )

    def build(parameters: Sequence[float]) -> RandomField:
        temperature, door, alike_strength = np.clip(parameters, (0.2, 0, 0), STRONGEST).tolist()
        return RandomField(doors, alike, temperature, door, alike_strength)

    def loss(parameters: Sequence[float]) -> float:
        marginals = build(parameters).compute_marginals(probabilities, near)
        losses = -np.log(np.maximum(marginals[np.arange(len(truth)), truth], 1e-9))
        return float(np.average(losses, weights=weights))

    found = minimize(loss, START, method="Nelder-Mead", options={"maxfev": 90, "xatol": 0.01, "fatol": 1e-4})
    return build(found.x)


def _count_meetings(labels: NDArray[np.intp], weights: Floats, count: int) -> Floats:
    """Pointwise mutual information of the labels of pairs, shapes (n, 2) and (n,), as a table (count, count)."""
    meetings = np.ones((count, count))
    for one, other in (labels.T, labels.T[::-1]) if len(labels) else ():
        np.add.at(meetings, (one, other), weights)
    meetings /= meetings.sum()
    alone = meetings.sum(axis=1)
    return np.asarray(np.log(meetings / np.outer(alone, alone)))
