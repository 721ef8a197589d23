"""TypeMachine: a fitted support vector machine that tells types of buildings, with Platt's scaling.

It is a few arrays, and says what SVC and LogisticRegression of scikit-learn say without them. They are needed only to
fit it.
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


COST = 10.0
# How far probabilities may be drawn from their mean, which few buildings do not tell well.
CALIBRATION_COST = 10.0
# For the calibration buildings are left out one by one, of more than these some together.
MAX_PARTS = 64


@dataclass(frozen=True, eq=False)
class TypeMachine:
    """Tells k types apart, given how alike a floor is to n known floors.

    Parameters
    ----------
    weights : Floats, shape (n, k - 1)
        Of each known floor, in the votes between its type and each of the others, in their order.
    intercepts : Floats, shape (k (k - 1) / 2,)
        Of the votes between two types: 0 and 1, 0 and 2, …, 1 and 2, ….
    slopes : Floats, shape (d, k)
        By which the decisions become the logarithms of probabilities; d is 1 for two types, k for more.
    offsets : Floats, shape (k,)
        Of these logarithms.

    """

    weights: Floats
    intercepts: Floats
    slopes: Floats
    offsets: Floats

    def decide(self, gram: Floats, truth: Indices) -> Floats:
        """Decision values: that it is the second of two types, or how far each of more types wins its votes.

        Parameters
        ----------
        gram : Floats, shape (floors, n)
            How alike floors are to the known ones.
        truth : Indices, shape (n,)
            The types of these, 0 … k - 1, each at least once.

        Returns
        -------
        Floats, shape (floors, d)
            As decision_function of SVC has them.

        """
        votes = self._vote(gram, truth)
        return -votes if len(self.offsets) == 2 else _join_votes(votes, len(self.offsets))

    def judge(self, gram: Floats, truth: Indices) -> Floats:
        """Probabilities of the types, shape (floors, k), as predict_proba of LogisticRegression has them."""
        logs = self.decide(gram, truth) @ self.slopes + self.offsets
        shares = np.exp(logs - logs.max(axis=1, keepdims=True))
        return np.asarray(shares / shares.sum(axis=1, keepdims=True))

    def _vote(self, gram: Floats, truth: Indices) -> Floats:
        """Between each two types, above 0 for the first of them, shape (floors, k (k - 1) / 2)."""
        order = np.argsort(truth, kind="stable")
        firsts = np.searchsorted(truth[order], np.arange(len(self.offsets)))
        # What the known floors of each type say in its votes with each of the others, shape (floors, k, k - 1).
        said = np.add.reduceat(gram[:, order, None] * self.weights[order], firsts, axis=1)
        one, other = np.triu_indices(len(self.offsets), 1)
        return np.asarray(said[:, one, other - 1] + said[:, other, one] + self.intercepts)


def fit_machine(gram: Floats, truth: Indices, buildings: Sequence[str]) -> TypeMachine:
    """Fit a machine to known floors, with scikit-learn.

    Probabilities come from Platt's scaling, on what is said of each building by a machine that was not trained on it.
    Types are as probable as they are frequent among the known floors.

    Parameters
    ----------
    gram : Floats, shape (n, n)
        How alike known floors are to each other.
    truth : Indices, shape (n,)
        The type of each, 0 … k - 1.
    buildings : sequence of str
        The building of each.

    """
    from sklearn.linear_model import LogisticRegression

    types = len(np.unique(truth))
    decisions, of_whom = [], []
    for others, held_out in leave_buildings_out(buildings, parts=MAX_PARTS):
        # The only building of a type has to be judged by what has seen it.
        seen = others if len(np.unique(truth[others])) == types else np.arange(len(truth))
        svm = _fit_svm(gram[np.ix_(seen, seen)], truth[seen])
        decisions.append(_decide(svm, gram[np.ix_(held_out, seen)]))
        of_whom.append(truth[held_out])
    scaling = LogisticRegression(C=CALIBRATION_COST).fit(np.concatenate(decisions), np.concatenate(of_whom))
    return _describe_machine(_fit_svm(gram, truth), scaling)


def _describe_machine(svm: SVC, scaling: LogisticRegression) -> TypeMachine:
    """What is fitted, as arrays."""
    two = len(svm.classes_) == 2
    weights = np.zeros((svm.shape_fit_[0], len(svm.classes_) - 1))
    # scikit-learn turns the sign of two types, and only theirs.
    weights[svm.support_] = -svm.dual_coef_.T if two else svm.dual_coef_.T
    intercepts = -svm.intercept_ if two else svm.intercept_
    slopes, offsets = scaling.coef_.T, scaling.intercept_
    if two:
        # The logistic function of a number is the share of its exponential beside that of 0.
        slopes, offsets = (np.concatenate([np.zeros_like(each), each], axis=-1) for each in (slopes, offsets))
    return TypeMachine(weights, intercepts, slopes, offsets)


def _fit_svm(gram: Floats, truth: Indices) -> SVC:
    from sklearn.svm import SVC

    return SVC(kernel="precomputed", C=COST, class_weight="balanced").fit(gram, truth)


def _decide(svm: SVC, gram: Floats) -> Floats:
    """Decision values of an SVC, shape (floors, 1) of two types, (floors, types) of more."""
    return np.asarray(svm.decision_function(gram)).reshape(len(gram), -1)


def _join_votes(votes: Floats, types: int) -> Floats:
    """The number of votes that each type wins, with less than half a vote for how clearly; shape (floors, types).

    As _ovr_decision_function of scikit-learn: the sums of what is said for a type become -1/3 … 1/3.
    """
    one, other = np.triu_indices(types, 1)
    won = np.zeros((len(votes), types, types), bool)
    won[:, one, other], won[:, other, one] = votes >= 0, votes < 0
    said = np.zeros(won.shape)
    said[:, one, other], said[:, other, one] = votes, -votes
    clearly = said.sum(axis=2)
    return np.asarray(won.sum(axis=2) + clearly / (3 * (np.abs(clearly) + 1)))
