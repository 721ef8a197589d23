"""A classifier of realistic and unrealistic floors, for when examples of both are at hand (thesis, section 8.1.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.building_types.description import BuildingDescription
from pianta.building_types.kernel import BuildingKernel
from pianta.building_types.svm import CALIBRATION_COST, COST
from pianta.evaluation.folds import leave_buildings_out

if TYPE_CHECKING:
    from sklearn.linear_model import LogisticRegression
    from sklearn.svm import SVC


class LinearBuildingKernel(BuildingKernel):
    """The BuildingKernel with features compared by their product instead of a Gaussian.

    By the Gaussian, a floor far from all training floors is equally unlike both classes, and the decision is a
    constant. Chosen with the figures of docs/methods/realism.md in sight.
    """

    def compare_features(self, floors: Sequence[BuildingDescription]) -> Floats:
        """Similarity of the features alone, shape (floors, training floors)."""
        return np.asarray(self._standardise(floors) @ self.features_.T / self.features_.shape[1])


class RealismClassifier:
    """An SVM on a kernel of floors, with Platt's scaling; both classes have equal weight, whatever their sizes."""

    def __init__(self, *, kernel: type[BuildingKernel] = LinearBuildingKernel) -> None:
        self.kernel = kernel

    def fit(self, floors: Sequence[BuildingDescription], realistic: Sequence[bool], buildings: Sequence[str]) -> Self:
        """Fit to at least two buildings of each class; buildings: of each floor."""
        from sklearn.linear_model import LogisticRegression

        truth = np.array(realistic)
        decisions = np.zeros(len(floors))
        # Decisions about each building by an SVM that was not trained on it.
        for training, held_out in leave_buildings_out(buildings):
            fitted = self._fit_svm([floors[i] for i in training], truth[training])
            decisions[held_out] = _decide(*fitted, [floors[i] for i in held_out])
        self.fitted_ = self._fit_svm(floors, truth)
        scaling: LogisticRegression = LogisticRegression(C=CALIBRATION_COST, class_weight="balanced")
        self.scaling_ = scaling.fit(decisions[:, None], truth)
        return self

    def predict_probability(self, floor: BuildingDescription) -> float:
        """The probability that a floor is realistic, if half of all floors are."""
        return float(self.scaling_.predict_proba(_decide(*self.fitted_, [floor])[:, None])[0, 1])

    def _fit_svm(self, floors: Sequence[BuildingDescription], truth: NDArray[np.bool_]) -> tuple[BuildingKernel, SVC]:
        from sklearn.svm import SVC

        kernel = self.kernel().fit(floors)
        return kernel, SVC(kernel="precomputed", C=COST, class_weight="balanced").fit(kernel.compare(), truth)


def _decide(kernel: BuildingKernel, svm: SVC, floors: Sequence[BuildingDescription]) -> Floats:
    return np.asarray(svm.decision_function(kernel.compare(floors)))
