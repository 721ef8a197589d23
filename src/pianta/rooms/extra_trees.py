"""Extra-Trees (Geurts et al. 2006), grown by the tree builder of scikit-learn.

ExtraTreesClassifier checks input and parameters again for each tree, which takes about as long as growing a small one.
Here they are checked by the caller; the trees are the same to the bit.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices


@dataclass(frozen=True, eq=False)
class ExtraTrees:
    """A grown forest.

    trees: of scikit-learn. classes: that were in the training, ascending, shape (c,).
    """

    trees: Sequence[Any]
    classes: Indices

    def class_probabilities(self, features: Floats, classes: int) -> Floats:
        """Share of the votes for the classes 0 … classes - 1, shape (n, classes), as predict_proba of scikit-learn."""
        rows = features.astype(np.float32)
        votes = np.zeros((len(features), len(self.classes)))
        for tree in self.trees:
            votes += tree.predict(rows)
        probabilities = np.zeros((len(features), classes))
        probabilities[:, self.classes] = votes / len(self.trees)
        return probabilities


@dataclass(frozen=True, kw_only=True)
class TreeParameters:
    """How a forest is grown, by default as scikit-learn does.

    trees: their number. feature_share: of the features, from which a split is chosen; None for the square root of their
    number. min_leaf: least number of training rows in a leaf. max_leaves: of a tree; None for any number.
    """

    trees: int
    feature_share: float | None = None
    min_leaf: int = 1
    max_leaves: int | None = None

    def count_features(self, features: int) -> int:
        """Number of randomly chosen features that each split considers."""
        return max(1, int(sqrt(features) if self.feature_share is None else self.feature_share * features))


def grow_extra_trees(
    features: Floats, truth: Indices, weights: Floats | None = None, *, parameters: TreeParameters, seed: int
) -> ExtraTrees:
    """Grow a forest on rows of features.

    features: all finite, shape (n, k). truth: the class of each row, shape (n,). weights: of the rows, shape (n,).
    """
    classes, encoded = np.unique(truth, return_inverse=True)
    rows = np.ascontiguousarray(features, np.float32)
    try:
        trees = list(_grow_directly(rows, encoded, weights, parameters, seed))
    # Another release of scikit-learn, whose builder has moved or takes other arguments.
    except (ImportError, TypeError):
        trees = _grow_by_classifier(rows, encoded, weights, parameters, seed)
    return ExtraTrees(trees, classes)


def _grow_directly(
    rows: NDArray[np.float32], truth: Indices, weights: Floats | None, parameters: TreeParameters, seed: int
) -> Iterator[Any]:
    """Trees by the classes that ExtraTreesClassifier of scikit-learn uses."""
    from sklearn.tree._criterion import Gini
    from sklearn.tree._splitter import RandomSplitter
    from sklearn.tree._tree import BestFirstTreeBuilder, DepthFirstTreeBuilder, Tree

    target, classes = truth.astype(float).reshape(-1, 1), np.array([truth.max() + 1], np.intp)
    features = parameters.count_features(rows.shape[1])
    min_leaf, min_split = parameters.min_leaf, max(2, 2 * parameters.min_leaf)
    least_weight, least_gain, depth = 0.0, 0.0, np.iinfo(np.int32).max
    random, tree_random = np.random.RandomState(seed), np.random.RandomState()
    for _ in range(parameters.trees):
        tree_random.seed(random.randint(np.iinfo(np.int32).max))
        splitter = RandomSplitter(Gini(1, classes), features, min_leaf, least_weight, tree_random, None)
        if parameters.max_leaves is None:
            builder = DepthFirstTreeBuilder(splitter, min_split, min_leaf, least_weight, depth, least_gain)
        else:
            builder = BestFirstTreeBuilder(
                splitter, min_split, min_leaf, least_weight, depth, parameters.max_leaves, least_gain
            )
        tree = Tree(rows.shape[1], classes, 1)
        builder.build(tree, rows, target, weights, None)
        yield tree


def _grow_by_classifier(
    rows: NDArray[np.float32], truth: Indices, weights: Floats | None, parameters: TreeParameters, seed: int
) -> list[Any]:
    """Trees by ExtraTreesClassifier of scikit-learn; rows: shape (n, k). truth: the class of each row, shape (n,)."""
    from sklearn.ensemble import ExtraTreesClassifier

    classifier = ExtraTreesClassifier(
        parameters.trees,
        max_features=parameters.count_features(rows.shape[1]),
        min_samples_leaf=parameters.min_leaf,
        max_leaf_nodes=parameters.max_leaves,
        random_state=seed,
    )
    return [estimator.tree_ for estimator in classifier.fit(rows, truth, weights).estimators_]
