"""A fitted support vector machine for building types, with Platt's scaling, as a few arrays.

It predicts exactly what SVC and LogisticRegression of scikit-learn predict, but needs scikit-learn only for fitting.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pianta._types import Floats, Indices
from pianta.evaluation.folds import leave_buildings_out

if TYPE_CHECKING:
    from sklearn.linear_model import LogisticRegression
    from sklearn.svm import SVC


# C of the support vector machine; chosen by hand.
COST = 10.0
# C of Platt's logistic regression: below infinity, as few buildings determine the probabilities badly; chosen by hand.
CALIBRATION_COST = 10.0
# Folds for the calibration; of more buildings, several are left out together.
MAX_FOLDS = 64


@dataclass(frozen=True, eq=False)
class BuildingTypeSvm:
    """One-against-one votes between k types, from the similarity of a floor to n training floors.

    weights: of each training floor in the votes between its type and each of the others, shape (n, k - 1).
    intercepts: of the votes between types 0 and 1, 0 and 2, …, 1 and 2, …; shape (k (k - 1) / 2,).
    slopes: turn decision values into logarithms of probabilities, shape (d, k); d is 1 for two types, else k.
    offsets: of these logarithms, shape (k,).
    """

    weights: Floats
    intercepts: Floats
    slopes: Floats
    offsets: Floats

    def decide(self, gram: Floats, truth: Indices) -> Floats:
        """Decision values as decision_function of SVC, shape (floors, d).

        gram: similarity to the training floors, shape (floors, n). truth: their types 0 … k - 1, each at least once.
        For two types the value is that of the second; for more, by how far each type wins its votes.
        """
        votes = self._vote(gram, truth)
        return -votes if len(self.offsets) == 2 else _join_votes(votes, len(self.offsets))

    def predict_probabilities(self, gram: Floats, truth: Indices) -> Floats:
        """Probabilities of the types as predict_proba of LogisticRegression, shape (floors, k)."""
        logs = self.decide(gram, truth) @ self.slopes + self.offsets
        shares = np.exp(logs - logs.max(axis=1, keepdims=True))
        return np.asarray(shares / shares.sum(axis=1, keepdims=True))

    def _vote(self, gram: Floats, truth: Indices) -> Floats:
        """Votes between each two types, positive for the first, shape (floors, k (k - 1) / 2)."""
        order = np.argsort(truth, kind="stable")
        firsts = np.searchsorted(truth[order], np.arange(len(self.offsets)))
        # Contribution of the training floors of each type to its votes against the others, shape (floors, k, k - 1).
        sums = np.add.reduceat(gram[:, order, None] * self.weights[order], firsts, axis=1)
        one, other = np.triu_indices(len(self.offsets), 1)
        return np.asarray(sums[:, one, other - 1] + sums[:, other, one] + self.intercepts)


def fit_type_svm(gram: Floats, truth: Indices, buildings: Sequence[str]) -> BuildingTypeSvm:
    """Fit an SVM to training floors, with scikit-learn.

    Platt's scaling is fitted to decisions about each building by an SVM that was not trained on it. The prior of a type
    is its frequency among the training floors.
    gram: similarity of the training floors, shape (n, n). truth: their types 0 … k - 1. buildings: of each floor.
    """
    from sklearn.linear_model import LogisticRegression

    types = len(np.unique(truth))
    decisions, held_out_types = [], []
    for others, held_out in leave_buildings_out(buildings, parts=MAX_FOLDS):
        # The only building of a type cannot be left out, so an SVM trained on it decides about it.
        training = others if len(np.unique(truth[others])) == types else np.arange(len(truth))
        svm = _fit_svm(gram[np.ix_(training, training)], truth[training])
        values = svm.decision_function(gram[np.ix_(held_out, training)])
        decisions.append(np.asarray(values).reshape(len(held_out), -1))
        held_out_types.append(truth[held_out])
    scaling = LogisticRegression(C=CALIBRATION_COST).fit(np.concatenate(decisions), np.concatenate(held_out_types))
    return _to_arrays(_fit_svm(gram, truth), scaling)


def _to_arrays(svm: SVC, scaling: LogisticRegression) -> BuildingTypeSvm:
    """The arrays of an SVM of scikit-learn, and of the logistic regression that scales its decision values."""
    two = len(svm.classes_) == 2
    weights = np.zeros((svm.shape_fit_[0], len(svm.classes_) - 1))
    # scikit-learn turns the sign for two types only.
    weights[svm.support_] = -svm.dual_coef_.T if two else svm.dual_coef_.T
    intercepts = -svm.intercept_ if two else svm.intercept_
    slopes, offsets = scaling.coef_.T, scaling.intercept_
    if two:
        # The logistic function of x is the softmax of (0, x).
        slopes, offsets = (np.concatenate([np.zeros_like(each), each], axis=-1) for each in (slopes, offsets))
    return BuildingTypeSvm(weights, intercepts, slopes, offsets)


def _fit_svm(gram: Floats, truth: Indices) -> SVC:
    from sklearn.svm import SVC

    return SVC(kernel="precomputed", C=COST, class_weight="balanced").fit(gram, truth)


def _join_votes(votes: Floats, types: int) -> Floats:
    """The number of votes that each type wins, plus its clarity as less than half a vote, shape (floors, types).

    As _ovr_decision_function of scikit-learn: the sum of the votes for a type is mapped to -1/3 … 1/3.
    """
    one, other = np.triu_indices(types, 1)
    is_won = np.zeros((len(votes), types, types), bool)
    is_won[:, one, other], is_won[:, other, one] = votes >= 0, votes < 0
    signed = np.zeros(is_won.shape)
    signed[:, one, other], signed[:, other, one] = votes, -votes
    clarity = signed.sum(axis=2)
    return np.asarray(is_won.sum(axis=2) + clarity / (3 * (np.abs(clarity) + 1)))
