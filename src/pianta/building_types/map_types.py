"""The building type of a floor that was read from a map, or that it is of none of the types.

The labels of such a floor are predicted, and wrong ones mislead a comparison by labels (`model`). Here a floor is
described by its rooms alone: means of their features, by which labels are predicted too. The forest was trained on
readings of simulated, furnished maps as well, and on places that are of none of the types: homes, wards and depots.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.errors import LabelError
from pianta.evaluation.folds import leave_buildings_out
from pianta.floor import Floor
from pianta.rooms.extra_trees import TreeParameters, grow_extra_trees
from pianta.rooms.features import CONTEXT_FEATURES, RoomContext, describe_rooms
from pianta.rooms.forest import Forest

# The type of training floors that are of none of the types that the model predicts.
OTHER = "other"
# A type with less is not given: it would too often be wrong. Chosen by hand.
MIN_TYPE_PROBABILITY = 0.55
# Chosen among sixteen settings of trees and features by the logarithmic loss of floors whose building was left out.
TREES = TreeParameters(trees=300, feature_share=0.2, min_leaf=3)
# Divides the logarithms of the votes. Of 0.45 to 1 it has the lowest logarithmic loss on floors of the training whose
# building was left out.
TEMPERATURE = 0.8
# Folds of the cross-validation by buildings; of more buildings, several are left out together.
FOLDS = 12
# Least probability of a type, before a temperature: less is ignorance of a model, not knowledge. Chosen by hand.
MIN_VOTES = 0.01
# Rooms whose share of the area is a feature: the largest ones.
LARGEST_ROOMS = 3
FLOOR_FEATURES = ("rooms", "largest_share", "concentration", "share_of_largest_rooms", "median_to_mean_area")


@dataclass(frozen=True)
class MapTypePrediction:
    """The predicted building type of a floor.

    probabilities: of the types that the model knows. neither: that the building is of none of them; all sum to 1.
    """

    probabilities: Mapping[str, float]
    neither: float

    @property
    def is_known(self) -> bool:
        """Whether one of the types is probable enough to be given."""
        return self.probabilities[self.likeliest] >= MIN_TYPE_PROBABILITY

    @property
    def likeliest(self) -> str:
        """The most probable type, whether `is_known` or not."""
        return max(self.probabilities, key=self.probabilities.__getitem__)


@dataclass(frozen=True, eq=False)
class MapExamples:
    """Floors to train on.

    features: of `describe_map`, shape (n, k). types: of each, OTHER for none of the predicted ones.
    buildings: of each; floors of one building have the same, and are left out together. sources: the name of each, or
    where it comes from.
    """

    features: Floats
    types: tuple[str, ...]
    buildings: tuple[str, ...]
    sources: tuple[str, ...]

    @property
    def classes(self) -> tuple[str, ...]:
        """The types that occur, sorted."""
        return tuple(sorted(set(self.types)))

    @property
    def truth(self) -> Indices:
        """The type of each floor, as its index in `classes`, shape (n,)."""
        return np.array([self.classes.index(name) for name in self.types])

    def select(self, chosen: Mask | Indices) -> MapExamples:
        """Some of the floors; chosen: a mask, or indices."""
        rows = np.arange(len(self.types))[chosen].tolist()
        types, buildings, sources = (
            tuple(values[i] for i in rows) for values in (self.types, self.buildings, self.sources)
        )
        return MapExamples(self.features[rows], types, buildings, sources)

    def weigh(self) -> Floats:
        """Weights by which all types count the same, and within one all buildings, shape (n,); their mean is 1."""
        per_building = Counter(zip(self.types, self.buildings, strict=True))
        buildings = Counter(name for name, _ in per_building)
        weights = [
            1 / (per_building[name, building] * buildings[name])
            for name, building in zip(self.types, self.buildings, strict=True)
        ]
        return np.array(weights) * len(weights) / sum(weights)


@dataclass(frozen=True, eq=False)
class MapTypeModel:
    """A trained model of the building types of maps.

    forest: over the classes, of which OTHER may be one. temperature: divides the logarithms of its votes.
    examples: what it was trained on.
    """

    forest: Forest
    classes: tuple[str, ...]
    temperature: float
    examples: MapExamples

    @property
    def building_types(self) -> tuple[str, ...]:
        """The types that it can predict."""
        return tuple(name for name in self.classes if name != OTHER)

    def predict(self, floor: Floor, *, context: RoomContext | None = None) -> MapTypePrediction:
        """The type of a floor, by its rooms and doors alone; raises LabelError for a floor without rooms.

        context: of its rooms, by `describe_rooms`; None to compute it.
        """
        if not floor.rooms:
            raise LabelError("the floor has no rooms, so its building type cannot be predicted")
        return self.predict_description(describe_map(context or describe_rooms(floor)))

    def predict_description(self, features: Floats) -> MapTypePrediction:
        """The type of a floor, from its features of `describe_map`, shape (k,)."""
        votes = self.forest.predict(features[None])
        return make_prediction(self.classes, soften(votes, self.temperature)[0])

    def leave_out(self, building: str) -> MapTypeModel:
        """The model of all other buildings, trained anew."""
        others = self.examples.select(np.array(self.examples.buildings) != building)
        return replace(train_map_types(others), temperature=self.temperature)


def make_prediction(classes: Sequence[str], chances: Floats) -> MapTypePrediction:
    """The prediction with the probabilities of the classes, shape (classes,), of which OTHER may be one."""
    by_class = dict(zip(classes, chances.tolist(), strict=True))
    neither = by_class.pop(OTHER, 0.0)
    return MapTypePrediction(by_class, neither)


def name_map_features() -> tuple[str, ...]:
    """The names of the features of `describe_map`, in order."""
    return (
        *(f"mean {name}" for name in CONTEXT_FEATURES),
        *(f"mean {name} by area" for name in CONTEXT_FEATURES),
        *FLOOR_FEATURES,
    )


def describe_map(context: RoomContext) -> Floats:
    """Features of a floor that need no labels, shape (k,); context: of its rooms, one at least.

    They do not depend on scale, rotation, translation and the order of the rooms.
    """
    shares = np.sort(context.area / context.area.sum())[::-1]
    sizes = [
        np.log(len(shares)),
        np.log(shares[0]),
        np.log((shares**2).sum()),
        shares[:LARGEST_ROOMS].sum(),
        np.log(np.median(shares) * len(shares)),
    ]
    by_area = context.area @ context.features / context.area.sum()
    return np.concatenate([context.features.mean(axis=0), by_area, sizes])


def train_map_types(examples: MapExamples, *, seed: int = 0) -> MapTypeModel:
    """Train a model on floors of at least two types; needs scikit-learn."""
    forest = _grow(examples, np.arange(len(examples.types)), seed=seed)
    return MapTypeModel(forest, examples.classes, TEMPERATURE, examples)


def predict_left_out(examples: MapExamples, *, seed: int = 0) -> Floats:
    """Votes for the types of each floor, shape (n, classes), by forests that were not trained on its building."""
    votes = np.zeros((len(examples.types), len(examples.classes)))
    for training, held_out in leave_buildings_out(examples.buildings, parts=FOLDS):
        votes[held_out] = _grow(examples, training, seed=seed).predict(examples.features[held_out])
    return votes


def soften(votes: Floats, temperature: float) -> Floats:
    """Probabilities from the shares of votes, or other probabilities, shape (n, classes)."""
    logs = np.log(np.maximum(votes, MIN_VOTES)) / temperature
    shares = np.exp(logs - logs.max(axis=1, keepdims=True))
    return np.asarray(shares / shares.sum(axis=1, keepdims=True))


def join_examples(parts: Sequence[MapExamples]) -> MapExamples:
    """The floors of several sets, one after the other."""
    types, buildings, sources = (
        tuple(value for part in parts for value in getattr(part, name)) for name in ("types", "buildings", "sources")
    )
    return MapExamples(np.concatenate([part.features for part in parts]), types, buildings, sources)


def _grow(examples: MapExamples, rows: Indices, *, seed: int) -> Forest:
    """The forest of some of the floors."""
    chosen = examples.select(rows)
    grown = grow_extra_trees(chosen.features, examples.truth[rows], chosen.weigh(), parameters=TREES, seed=seed)
    return Forest.from_trees(grown, len(examples.classes))
