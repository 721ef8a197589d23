"""Type classifiers and standard classifiers: four algorithms that predict L_general from features (section 4.2.3)."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol, Self

import numpy as np
from numpy.typing import NDArray
from sklearn.metrics import confusion_matrix
from sklearn.model_selection import GroupKFold, StratifiedKFold
from sklearn.neighbors import KNeighborsClassifier
from sklearn.neural_network import MLPClassifier
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler
from sklearn.tree import DecisionTreeClassifier

from pianta._types import Floats
from pianta_bench.types.room_sets import GENERAL_LABELS, Labels, RoomSet
from pianta_bench.types.rule_induction import RuleInduction

FOLDS = 10  # thesis, section 4.2.3
Split = tuple[NDArray[np.intp], NDArray[np.intp]]


class Classifier(Protocol):
    """Learns labels, shape (rows,), from features, shape (rows, features)."""

    def fit(self, features: Floats, labels: Labels) -> Self:
        """Learn."""

    def predict(self, features: Floats) -> Labels:
        """The labels of rows, shape (rows,)."""


def _make_perceptron(seed: int) -> Classifier:
    # L-BFGS suits sets this small. Its limits are far above the needed iterations, so that it ends by convergence.
    network = MLPClassifier((8,), solver="lbfgs", alpha=0.1, max_iter=20_000, max_fun=1_000_000, random_state=seed)
    classifier: Classifier = make_pipeline(StandardScaler(), network)
    return classifier


def _make_neighbours(_: int) -> Classifier:
    classifier: Classifier = make_pipeline(StandardScaler(), KNeighborsClassifier(5))
    return classifier


def _make_tree(seed: int) -> Classifier:
    classifier: Classifier = DecisionTreeClassifier(min_samples_leaf=5, random_state=seed)
    return classifier


# By the thesis' names, from a seed.
ALGORITHMS: MappingProxyType[str, Callable[[int], Classifier]] = MappingProxyType(
    {
        "RI": lambda seed: RuleInduction(seed=seed),
        "MLP": _make_perceptron,
        "DT": _make_tree,
        "K-NN": _make_neighbours,
    }
)
REPRESENTATIONS: MappingProxyType[str, Callable[[RoomSet], Floats]] = MappingProxyType(
    {"a, d, rt": lambda rooms: rooms.geometry, "with neighbours": RoomSet.with_neighbours}
)
# Folds are of rooms, as in the thesis, or of whole buildings, which is harder and fairer.
DIVISIONS = ("rooms", "buildings")


@dataclass(frozen=True)
class CrossValidation:
    """How well the algorithms label a set of rooms.

    accuracies: by algorithm the share of right labels in each fold.
    confusion: rows are true labels, columns predicted ones, in the order of GENERAL_LABELS; the share of each row,
        mean over algorithms, shape (5, 5); NaN in the rows of labels that the set does not have.
    misled: per label the share of rooms of other labels for which it is predicted, mean over algorithms, shape (5,).
    """

    accuracies: Mapping[str, tuple[float, ...]]
    confusion: Floats
    misled: Floats


def cross_validate(rooms: RoomSet, *, representation: str, divided: str, seed: int) -> CrossValidation:
    """Label each room by classifiers that train_features from the other folds (Fig. 4.3, Table 4.3)."""
    features = REPRESENTATIONS[representation](rooms)
    splits = divide(rooms, divided=divided, seed=seed)
    predicted = {name: _predict_folds(name, features, rooms.labels, splits, seed) for name in ALGORITHMS}
    tables = [confusion_matrix(rooms.labels, labels, labels=GENERAL_LABELS) for labels in predicted.values()]
    accuracies = {
        name: tuple(float((labels[test] == rooms.labels[test]).mean()) for _, test in splits)
        for name, labels in predicted.items()
    }
    confusion = np.mean([share_rows(table) for table in tables], axis=0)
    misled = np.mean([share_misled(table) for table in tables], axis=0)
    return CrossValidation(accuracies, confusion, misled)


def measure_transfer(train: RoomSet, test: RoomSet, *, representation: str, seed: int) -> dict[str, tuple[float, ...]]:
    """Accuracies by algorithm of training on nine tenths of a set, ten times, and labelling another set (Table 4.4)."""
    train_features, test_features = (REPRESENTATIONS[representation](rooms) for rooms in (train, test))
    accuracies: dict[str, tuple[float, ...]] = {}
    for name, make in ALGORITHMS.items():
        classifiers = [
            make(seed + fold).fit(train_features[rows], train.labels[rows])
            for fold, (rows, _) in enumerate(divide(train, divided="rooms", seed=seed))
        ]
        accuracies[name] = tuple(float((each.predict(test_features) == test.labels).mean()) for each in classifiers)
    return accuracies


def divide(rooms: RoomSet, *, divided: str, seed: int) -> list[Split]:
    """Rows to learn from and rows to label, for each of ten folds; fewer where there are fewer buildings."""
    if divided == "rooms":
        with warnings.catch_warnings():
            # A label with fewer rooms than folds is not in every fold, which harms no other.
            warnings.filterwarnings("ignore", "The least populated class", UserWarning)
            return list(StratifiedKFold(FOLDS, shuffle=True, random_state=seed).split(rooms.geometry, rooms.labels))
    count = min(FOLDS, len(np.unique(rooms.buildings)))
    return list(GroupKFold(count).split(rooms.geometry, groups=rooms.buildings))


def share_rows(table: NDArray[np.int_]) -> Floats:
    """A confusion matrix whose rows, the true labels, have the sum 1.

    The diagonal is what Table 4.3 calls TP, the rest of a row FP.
    """
    totals = table.sum(axis=1, keepdims=True)
    return np.asarray(np.divide(table, totals, out=np.full(table.shape, np.nan), where=totals > 0))


def share_misled(table: NDArray[np.int_]) -> Floats:
    """Per label the share of rooms of other labels for which it is predicted: FN of Table 4.3, and 1 - TN."""
    wrong = table.sum(axis=0) - table.diagonal()
    others = table.sum() - table.sum(axis=1)
    return np.asarray(np.divide(wrong, others, out=np.full(len(table), np.nan), where=others > 0))


def _predict_folds(name: str, features: Floats, labels: Labels, splits: Sequence[Split], seed: int) -> Labels:
    predicted = np.empty_like(labels)
    for fold, (train, test) in enumerate(splits):
        predicted[test] = ALGORITHMS[name](seed + fold).fit(features[train], labels[train]).predict(features[test])
    return predicted
