"""RealismClassifier: tells realistic floors from others, where examples of both are known (thesis, section 8.1.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices
from pianta.building_types.description import BuildingDescription
from pianta.building_types.kernel import BuildingKernel
from pianta.building_types.machine import COST
from pianta.evaluation.folds import leave_buildings_out

if TYPE_CHECKING:
    from sklearn.linear_model import LogisticRegression
    from sklearn.svm import SVC


# How far probabilities may be drawn from their mean, which few floors do not tell well.
CALIBRATION_COST = 10.0


class LinearBuildingKernel(BuildingKernel):
    """The BuildingKernel with features compared by their product, so that a floor like no known one is on a side too.

    By the Gaussian such a floor is as unlike both classes, and nothing can be said of it.
    """

    def compare_features(self, floors: Sequence[BuildingDescription]) -> Floats:
        """The share of the features in `compare`, shape (floors, known)."""
        return np.asarray(self._standardise(floors) @ self.known_.T / self.known_.shape[1])


class RealismClassifier:
    """An SVM on a kernel of floors, with Platt's scaling; both classes count the same, however many floors they have.

    kernel: compares floors.
    """

    def __init__(self, *, kernel: type[BuildingKernel] = LinearBuildingKernel) -> None:
        self.kernel = kernel

    def fit(self, floors: Sequence[BuildingDescription], realistic: Sequence[bool], buildings: Sequence[str]) -> Self:
        """Learn from two buildings of each class at least; buildings: of each floor."""
        from sklearn.linear_model import LogisticRegression

        truth = np.array(realistic)
        decisions = np.zeros(len(floors))
        # What is said of each building by an SVM that has not seen it.
        for seen, held_out in leave_buildings_out(buildings):
            learnt = self._fit_svm(_pick(floors, seen), truth[seen])
            decisions[held_out] = _decide(*learnt, _pick(floors, held_out))
        self.learnt_ = self._fit_svm(floors, truth)
        scaling: LogisticRegression = LogisticRegression(C=CALIBRATION_COST, class_weight="balanced")
        self.scaling_ = scaling.fit(decisions[:, None], truth)
        return self

    def judge(self, floor: BuildingDescription) -> float:
        """The probability that a floor is realistic, where as many floors are as are not."""
        return float(self.scaling_.predict_proba(_decide(*self.learnt_, [floor])[:, None])[0, 1])

    def _fit_svm(self, floors: Sequence[BuildingDescription], truth: NDArray[np.bool_]) -> tuple[BuildingKernel, SVC]:
        from sklearn.svm import SVC

        kernel = self.kernel().fit(floors)
        return kernel, SVC(kernel="precomputed", C=COST, class_weight="balanced").fit(kernel.compare(), truth)


def _decide(kernel: BuildingKernel, machine: SVC, floors: Sequence[BuildingDescription]) -> Floats:
    return np.asarray(machine.decision_function(kernel.compare(floors)))


def _pick(floors: Sequence[BuildingDescription], places: Indices) -> list[BuildingDescription]:
    return [floors[place] for place in places]
