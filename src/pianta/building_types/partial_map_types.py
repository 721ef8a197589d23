"""The building type of a part of a floor, by logistic regression and a forest over the features of whole floors.

The parts are of drawn floors, of real maps, and of made floors. Most schools are drawn and most offices are real maps,
so a model could learn what distinguishes drawings from maps instead. Therefore in each source all types count the
same, but for "neither", which counts twice. The regression finds more than the forest in parts like those of the
training; the forest errs less in others.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from pianta._types import Floats
from pianta.building_types.map_types import (
    FOLDS,
    OTHER,
    MapExamples,
    MapTypePrediction,
    make_prediction,
    name_map_features,
    soften,
)
from pianta.errors import LabelError, ModelError
from pianta.evaluation.folds import leave_buildings_out
from pianta.rooms.extra_trees import TreeParameters, grow_extra_trees
from pianta.rooms.forest import Forest

# The card has how these were chosen. The weights in the file are of these values; others need another training.
# C of scikit-learn, one over the strength of the L2 penalty, with a mean weight of 1.
INVERSE_PENALTY = 1.0
# Spreads from the mean, at which a feature stops counting: a sum that goes on grows certain of maps unlike all others.
MAX_DEVIATION = 3.0
TREES = TreeParameters(trees=300, feature_share=0.4, min_leaf=10)
# These divide the logarithms of the probabilities of both; their geometric mean is the prediction.
REGRESSION_TEMPERATURE = 0.8
FOREST_TEMPERATURE = 0.5
# How often OTHER counts, over each type: it stands for all other buildings.
OTHER_WEIGHT = 2.0
# Of any number of the regression: with larger ones scores would overflow.
MAX_WEIGHT = 1e9
# Of a feature of the training, below which it is a constant, and its differences are errors of rounding.
MIN_SPREAD = 1e-6
# With two, weights have another form.
MIN_CLASSES = 3
# Of the optimisation, which needs some hundred.
MAX_ITERATIONS = 3000


@dataclass(frozen=True, eq=False)
class Regression:
    """Multinomial logistic regression over standardised features.

    mean, spread: of the features of the training, shape (k,). weights: shape (classes, k). biases: shape (classes,).
    Raises ModelError for arrays that do not fit, and for numbers with which scores would overflow.
    """

    mean: Floats
    spread: Floats
    weights: Floats
    biases: Floats

    def __post_init__(self) -> None:
        """Check the arrays."""
        arrays = self.mean, self.spread, self.weights, self.biases
        classes, features = len(self.biases), len(self.mean)
        if [each.shape for each in arrays] != [(features,), (features,), (classes, features), (classes,)]:
            raise ModelError(f"the weights of {classes} types and {features} features have other shapes")
        if not all((np.abs(each) <= MAX_WEIGHT).all() for each in arrays):
            raise ModelError(f"a weight is not a number up to {MAX_WEIGHT:g}")
        if not (self.spread >= MIN_SPREAD).all():
            raise ModelError(f"the spread of a feature is below {MIN_SPREAD:g}")

    def predict(self, features: Floats) -> Floats:
        """Probabilities of the classes, shape (n, classes), from features of shape (n, k)."""
        scores = self.standardise(features) @ self.weights.T + self.biases
        chances = np.exp(scores - scores.max(axis=1, keepdims=True))
        return np.asarray(chances / chances.sum(axis=1, keepdims=True))

    def standardise(self, features: Floats) -> Floats:
        """Spreads from the mean, MAX_DEVIATION at most, shape (n, k)."""
        return np.clip((features - self.mean) / self.spread, -MAX_DEVIATION, MAX_DEVIATION)


@dataclass(frozen=True, eq=False)
class PartialMapTypeModel:
    """A model of the types of parts of floors.

    regression, forest: over the classes, of which OTHER may be one. examples: what it was trained on.
    Raises ModelError if both are not over the classes.
    """

    regression: Regression
    forest: Forest
    classes: tuple[str, ...]
    examples: MapExamples

    def __post_init__(self) -> None:
        """Check the numbers of classes."""
        if not len(self.classes) == len(self.regression.biases) == self.forest.classes:
            raise ModelError(f"its weights or trees are not over the {len(self.classes)} types that it names")

    def predict_description(self, features: Floats) -> MapTypePrediction:
        """The type of a floor, from its features of `describe_map`, shape (k,)."""
        return make_prediction(self.classes, self.predict_chances(features[None])[0])

    def predict_chances(self, features: Floats) -> Floats:
        """Probabilities of the classes, shape (n, classes), from features of shape (n, k)."""
        by_regression = soften(self.regression.predict(features), REGRESSION_TEMPERATURE)
        by_forest = soften(self.forest.predict(features), FOREST_TEMPERATURE)
        chances = np.sqrt(by_regression * by_forest)
        return np.asarray(chances / chances.sum(axis=1, keepdims=True))

    def leave_out(self, building: str) -> PartialMapTypeModel:
        """The model of all other buildings, trained anew."""
        return train_partial_map_types(self.examples.select(np.array(self.examples.buildings) != building))


def compute_weights(examples: MapExamples) -> Floats:
    """Weights by which all sources count the same, in one all types, in these all buildings, shape (n,); mean 1.

    After that OTHER counts OTHER_WEIGHT times as much, so that sources with it count more.
    """
    rows = [*zip(examples.sources, examples.types, examples.buildings, strict=True)]
    per_building = Counter(rows)
    buildings = Counter((source, name) for source, name, _ in per_building)
    types = Counter(source for source, _ in buildings)
    weights = [
        (OTHER_WEIGHT if row[1] == OTHER else 1) / (per_building[row] * buildings[row[:2]] * types[row[0]])
        for row in rows
    ]
    return np.array(weights) * len(weights) / sum(weights)


def train_partial_map_types(examples: MapExamples, *, seed: int = 0) -> PartialMapTypeModel:
    """Train a model on parts of floors, with their sources; needs scikit-learn.

    Raises LabelError for fewer than three types, OTHER among them.
    """
    if len(examples.classes) < MIN_CLASSES:
        raise LabelError(
            f"the parts are of {len(examples.classes)} types, give {MIN_CLASSES}, of which one may be {OTHER!r}"
        )
    weights = compute_weights(examples)
    grown = grow_extra_trees(examples.features, examples.truth, weights, parameters=TREES, seed=seed)
    forest = Forest.from_trees(grown, len(examples.classes))
    return PartialMapTypeModel(_fit_regression(examples, weights), forest, examples.classes, examples)


def predict_left_out_parts(examples: MapExamples) -> Floats:
    """Probabilities of the types, shape (n, classes), by models that were not trained on the building."""
    chances = np.zeros((len(examples.types), len(examples.classes)))
    for training, held_out in leave_buildings_out(examples.buildings, parts=FOLDS):
        model = train_partial_map_types(examples.select(training))
        chances[held_out] = model.predict_chances(examples.features[held_out])
    return chances


def _fit_regression(examples: MapExamples, weights: Floats) -> Regression:
    from sklearn.linear_model import LogisticRegression

    count, features = len(examples.classes), len(name_map_features())
    mean, spread = examples.features.mean(axis=0), examples.features.std(axis=0)
    blank = Regression(mean, np.where(spread >= MIN_SPREAD, spread, 1.0), np.zeros((count, features)), np.zeros(count))
    fitted = LogisticRegression(C=INVERSE_PENALTY, max_iter=MAX_ITERATIONS).fit(
        blank.standardise(examples.features), examples.truth, sample_weight=weights
    )
    return Regression(blank.mean, blank.spread, fitted.coef_, fitted.intercept_)
