"""The models that bench realism compares with pianta's: each scores floors of a building that it was not trained on."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.building_types.description import BuildingDescription, describe_building
from pianta.building_types.kernel import BuildingKernel
from pianta.evaluation.folds import leave_buildings_out
from pianta.labels import LabelSet
from pianta.realism.classifier import RealismClassifier
from pianta.relational.classifiers import RelationalTypeClassifier
from pianta.rooms.completion import LABELS
from pianta_bench.data.annotated_floors import AnnotatedFloor
from pianta_bench.places.models import ALL_FEATURES, CENTRAL, LOCAL, WITHOUT_CENTRALITY

KLOG = "kLog-style"
GAUSSIAN = "pianta, Gaussian features"
REAL = "real"
SIMULATED = "simulated"


@dataclass(frozen=True, eq=False)
class Fold:
    """The task to score the floors of one building by floors of other buildings.

    training: floors of other buildings. real: which of them are real. tested: the floors of one building.
    seed, trees: of Extra-Trees.
    """

    training: Sequence[AnnotatedFloor]
    real: NDArray[np.bool_]
    tested: Sequence[AnnotatedFloor]
    label_set: LabelSet
    seed: int
    trees: int


def score_by_trees(fold: Fold, columns: slice) -> list[float]:
    """Share of the rooms that Extra-Trees classify as real, by columns of V_n and the label."""
    from sklearn.ensemble import ExtraTreesClassifier

    features = [_list_features(floor, columns, fold.label_set) for floor in fold.training]
    truth = np.repeat(fold.real, [len(rooms) for rooms in features])
    forest = ExtraTreesClassifier(fold.trees, random_state=fold.seed).fit(np.concatenate(features), truth)
    return [float(forest.predict(_list_features(floor, columns, fold.label_set)).mean()) for floor in fold.tested]


def score_by_relations(fold: Fold) -> list[float]:
    """Decision values of an SVM on NSPDK over graphs of facts; above 0 for real floors."""
    classifier = RelationalTypeClassifier(label_set=fold.label_set)
    classifier.fit([floor.floor for floor in fold.training], [REAL if is_real else SIMULATED for is_real in fold.real])
    decided = classifier.decide([floor.floor for floor in fold.tested])
    real, simulated = (classifier.types_.index(name) for name in (REAL, SIMULATED))
    return [float(row[real] - row[simulated]) for row in decided]


def score_by_gaussian(fold: Fold) -> list[float]:
    """Probability of being real, with the kernel of the one class."""
    training = [describe_annotated(floor, fold.label_set) for floor in fold.training]
    buildings = [floor.building for floor in fold.training]
    classifier = RealismClassifier(kernel=BuildingKernel).fit(training, fold.real.tolist(), buildings)
    return [classifier.predict_probability(describe_annotated(floor, fold.label_set)) for floor in fold.tested]


SCORERS: Mapping[str, Callable[[Fold], list[float]]] = MappingProxyType(
    {
        LOCAL: lambda fold: score_by_trees(fold, WITHOUT_CENTRALITY),
        CENTRAL: lambda fold: score_by_trees(fold, ALL_FEATURES),
        KLOG: score_by_relations,
        GAUSSIAN: score_by_gaussian,
    }
)


def score_left_out(
    model: str, floors: Sequence[AnnotatedFloor], real: NDArray[np.bool_], label_set: LabelSet, *, seed: int, trees: int
) -> list[float]:
    """The score of each floor by a model of SCORERS that was not trained on its building."""
    scores = np.zeros(len(floors))
    for others, held_out in leave_buildings_out([floor.building for floor in floors]):
        training, tested = ([floors[index] for index in indices] for indices in (others, held_out))
        scores[held_out] = SCORERS[model](Fold(training, real[others], tested, label_set, seed, trees))
    return list(map(float, scores))


def describe_annotated(floor: AnnotatedFloor, label_set: LabelSet) -> BuildingDescription:
    """The description of a floor whose rooms have labels in the label set."""
    return describe_building(floor.floor, label_set)


def _list_features(floor: AnnotatedFloor, columns: slice, label_set: LabelSet) -> Floats:
    labels = np.array([room.labels[str(label_set)] for room in floor.floor.rooms])
    return np.column_stack([floor.features[:, columns], labels[:, None] == np.array(LABELS[label_set])])
