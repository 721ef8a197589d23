"""The trees of an Extra-Trees classifier as a few arrays, which predict without scikit-learn.

The nodes of all trees are in level order: first the roots, then the two children of each inner node, left before right,
in the order of these nodes. So the children of the k-th inner node are at trees + 2 k, and need no pointers.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices
from pianta.errors import ModelError
from pianta.rooms.extra_trees import ExtraTrees

# The feature of a leaf.
LEAF = -1
# Tolerance for the sum of the shares in a leaf, which is 1.
SUM_TOLERANCE = 1e-6


@dataclass(frozen=True, eq=False)
class Forest:
    """T trees over F features and L classes, with n nodes in all, of which m are inner ones.

    features: index of the feature of each node, LEAF for a leaf, shape (n,).
    thresholds: of the inner nodes; a sample whose feature is not above it goes left, shape (m,).
    votes: of the leaves, the shares of the classes, shape (n - m, L).
    Raises ModelError for arrays that do not describe such trees.
    """

    features: NDArray[np.int16]
    thresholds: NDArray[np.float32]
    votes: Floats

    def __post_init__(self) -> None:
        fault = self._find_fault()
        if fault:
            raise ModelError(f"the forest cannot be walked through: {fault}")

    @classmethod
    def from_trees(cls, forest: ExtraTrees, classes: int) -> Self:
        """The trees of Extra-Trees, with exactly the same predictions.

        Thresholds are rounded down to float32, as features are, so that no decision changes.
        classes: L; the classes of the forest are some of 0 … L - 1, and the others get no votes.
        """
        trees = forest.trees
        starts = np.cumsum([0, *(tree.node_count for tree in trees)])
        left, right = (
            np.concatenate([getattr(tree, name) + start for tree, start in zip(trees, starts[:-1], strict=True)])
            for name in ("children_left", "children_right")
        )
        features, thresholds, values = (
            np.concatenate([getattr(tree, name) for tree in trees]) for name in ("feature", "threshold", "value")
        )
        leaf = features < 0
        order = _order_by_level(starts[:-1], left, right, leaf)
        inner, leaves = order[~leaf[order]], order[leaf[order]]
        votes = np.zeros((len(leaves), classes))
        votes[:, forest.classes] = values[leaves, 0]
        return cls(np.where(leaf, LEAF, features)[order].astype(np.int16), _round_down(thresholds[inner]), votes)

    def predict(self, features: Floats) -> Floats:
        """Probabilities as predict_proba of scikit-learn, shape (n, L), for finite features of shape (n, F)."""
        values, samples = features.astype(np.float32), np.arange(len(features))
        nodes = np.repeat(np.arange(self.trees)[:, None], len(features), axis=1)
        moving = nodes >= 0
        while moving.any():
            right = values[samples, self._compared[nodes]] > self._limits[nodes]
            below = self._left[nodes] + right
            moving, nodes = below != nodes, below
        return np.asarray(self.votes[self._leaf[nodes]].sum(axis=0) / self.trees)

    @property
    def trees(self) -> int:
        """The number of trees."""
        return len(self.features) - 2 * len(self.thresholds)

    @property
    def classes(self) -> int:
        """The number of classes."""
        return int(self.votes.shape[1])

    @cached_property
    def _inner(self) -> Indices:
        """Indices of the inner nodes, shape (m,)."""
        return np.flatnonzero(self.features != LEAF)

    # Next steps by node, shape (n,): a leaf compares the first feature with infinity and leads to itself.

    @cached_property
    def _compared(self) -> Indices:
        return np.maximum(self.features, 0).astype(np.intp)

    @cached_property
    def _limits(self) -> NDArray[np.float32]:
        limits = np.full(len(self.features), np.inf, np.float32)
        limits[self._inner] = self.thresholds
        return limits

    @cached_property
    def _left(self) -> Indices:
        left = np.arange(len(self.features))
        left[self._inner] = self.trees + 2 * np.arange(len(self._inner))
        return left

    @cached_property
    def _leaf(self) -> Indices:
        """The row of votes of each leaf."""
        return np.cumsum(self.features == LEAF) - 1

    def _find_fault(self) -> str | None:
        """What is wrong with the arrays; None if nothing is."""
        inner, leaves = len(self._inner), len(self.features) - len(self._inner)
        if self.trees < 1:
            return f"{len(self.features)} nodes with {len(self.thresholds)} thresholds make no tree"
        if (inner, leaves) != (len(self.thresholds), len(self.votes)):
            counts = f"{len(self.thresholds)} thresholds and {len(self.votes)} votes"
            return f"{inner} inner nodes and {leaves} leaves have {counts}"
        if self.features.min() < LEAF:
            return f"a node decides by feature {self.features.min()}"
        # If all children come after their parents, each node has exactly one parent.
        if (self._left[self._inner] <= self._inner).any():
            return "a node does not lead downwards"
        if not np.isfinite(self.thresholds).all():
            return "a threshold is not finite"
        # The sum of numbers that are not all finite is never near 1.
        with np.errstate(invalid="ignore", over="ignore"):
            is_one = np.abs(self.votes.sum(axis=1) - 1) <= SUM_TOLERANCE
        return None if is_one.all() and (self.votes >= 0).all() else "the votes of a leaf are no shares of 1"


def _order_by_level(roots: Indices, left: Indices, right: Indices, leaf: NDArray[np.bool_]) -> Indices:
    """Indices of the nodes in level order, shape (n,)."""
    levels, level = [], roots
    while len(level):
        levels.append(level)
        inner = level[~leaf[level]]
        level = np.stack([left[inner], right[inner]], axis=1).ravel()
    return np.concatenate(levels)


def _round_down(thresholds: Floats) -> NDArray[np.float32]:
    """The largest float32 not above each threshold: scikit-learn compares features as float32 with its thresholds."""
    rounded = thresholds.astype(np.float32)
    return np.where(rounded > thresholds, np.nextafter(rounded, np.float32(-np.inf)), rounded)
