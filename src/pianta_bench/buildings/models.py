"""The models that bench buildings compares, each on floors that it was not trained on.

Extra-Trees on single rooms and the relational kernel are those of Table 6.1; the third is pianta's own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from pianta._types import Floats, Indices, Mask
from pianta.building_types.model import BuildingTypeModel
from pianta.labels import LabelConvention, LabelSet
from pianta.relational.kernels import FloorKernel, RoomKernel, decide, fit_svm
from pianta.rooms.completion import LABELS
from pianta.rooms.extra_trees import ExtraTrees, TreeParameters, grow_extra_trees
from pianta_bench.buildings.floors import BuildingFloor
from pianta_bench.harness.folds import list_folds
from pianta_bench.places.models import (
    CENTRAL,
    COLUMNS,
    LAST_STEP,
    LOCAL,
    PIANTA,
    PreparedFloor,
    both_sets,
    train_room_model,
)

Folds = Sequence[tuple[Indices, Indices]]

# What a step returns: for each timed task its name, the model, seconds, and scores by their key in Scores.
Outcomes = list[tuple[str, str, float, Mapping[Any, Any]]]

KLOG = "kLog-style"
MODELS = (LOCAL, CENTRAL, KLOG, PIANTA)
# The bins of the relational kernel are computed three times, each time without a third of the buildings (docs,
# results of building classification).
BIN_FOLDS = 3


class FloorScores(NamedTuple):
    """Scores of the types, shape (floors, types); and which floors pianta finds like those of the training."""

    values: Floats
    typical: Mask | None = None


def classify_rooms_by_trees(
    floors: Sequence[BuildingFloor], *, model: str, trees: int, seed: int
) -> dict[LabelSet, list[Floats]]:
    """By label set, for each floor the probabilities of labels, shape (rooms, labels) (section 6.1.3)."""
    features = [floor.annotated.features[:, COLUMNS[model]] for floor in floors]
    probabilities = {label_set: [np.zeros((0, len(labels)))] * len(floors) for label_set, labels in LABELS.items()}
    for label_set, labels in LABELS.items():
        truth = [np.array([labels.index(label) for label in floor.labels[label_set]]) for floor in floors]
        for training, held_out in list_folds(list_buildings(floors)):
            forest = _grow(features, truth, training, trees=trees, seed=seed)
            for i in held_out.tolist():
                probabilities[label_set][i] = forest.class_probabilities(features[i], len(labels))
    return probabilities


def classify_rooms_by_relations(floors: Sequence[BuildingFloor]) -> dict[LabelSet, list[Floats]]:
    """By label set, for each floor decision values, shape (rooms, labels); all sets share the Gram matrices."""
    buildings, facts = list_buildings(floors), [floor.facts for floor in floors]
    compare = compare_by_fold(
        buildings, lambda others: RoomKernel().fit(facts, binned=[facts[i] for i in others]).compare()
    )
    starts = np.cumsum([0, *(len(floor.annotated.floor.rooms) for floor in floors)])
    rows = [np.arange(start, end) for start, end in pairwise(starts)]
    decisions = {label_set: [np.zeros((0, len(labels)))] * len(floors) for label_set, labels in LABELS.items()}
    for training, held_out in list_folds(buildings):
        train_rows = np.concatenate([rows[i] for i in training])
        for building, own in _group(held_out, buildings).items():
            gram = compare(building)
            train_gram = gram[np.ix_(train_rows, train_rows)]
            for label_set, labels in LABELS.items():
                truth = [label for i in training for label in floors[i].labels[label_set]]
                svm = fit_svm(train_gram, truth)
                for i in own:
                    decisions[label_set][i] = decide(svm, gram[np.ix_(rows[i], train_rows)], labels)
    return decisions


def classify_rooms_by_pianta(
    training: Sequence[PreparedFloor], held_out: Sequence[PreparedFloor], *, convention: LabelConvention, seed: int
) -> dict[LabelSet, list[Floats]]:
    """By label set, for each held-out floor the probabilities of labels, by pianta's model of the other floors."""
    model = train_room_model([floor.examples[0] for floor in training], convention=convention, seed=seed)
    by_floor = [both_sets(model.predict_functions(each.context)[LAST_STEP], convention) for each in held_out]
    return {label_set: [each[label_set] for each in by_floor] for label_set in LABELS}


def classify_floors_by_trees(
    floors: Sequence[BuildingFloor], folds: Folds, label_set: LabelSet, *, model: str, trees: int, seed: int
) -> FloorScores:
    """Shares of the rooms with each predicted type, shape (floors, types): the most frequent one is the floor's.

    A room is described by its features and its label (section 6.2.2).
    """
    types, labels = list_types(floors), np.array(LABELS[label_set])
    features, truth = [], []
    for floor in floors:
        is_label = np.array(floor.labels[label_set])[:, None] == labels
        features.append(np.column_stack([floor.annotated.features[:, COLUMNS[model]], is_label]))
        truth.append(np.full(len(is_label), types.index(floor.annotated.kind)))
    shares = np.zeros((len(floors), len(types)))
    for training, held_out in folds:
        forest = _grow(features, truth, training, trees=trees, seed=seed)
        for i in held_out.tolist():
            predicted = forest.class_probabilities(features[i], len(types)).argmax(axis=1)
            shares[i] = np.bincount(predicted, minlength=len(types)) / len(predicted)
    return FloorScores(shares)


def compare_floors(floors: Sequence[BuildingFloor], label_set: LabelSet) -> Callable[[str], Floats]:
    """By building the Gram matrix of all floors that classifies it, with bins fitted without its floors."""
    facts = [floor.labelled_facts[label_set] for floor in floors]
    return compare_by_fold(
        list_buildings(floors), lambda others: FloorKernel().fit(facts, binned=[facts[i] for i in others]).compare()
    )


def classify_floors_by_relations(
    floors: Sequence[BuildingFloor], folds: Folds, compare: Callable[[str], Floats]
) -> FloorScores:
    """Decision values of the types, shape (floors, types); compare: as compare_floors gives it."""
    types, buildings = list_types(floors), list_buildings(floors)
    decisions = np.zeros((len(floors), len(types)))
    for training, held_out in folds:
        for building, own in _group(held_out, buildings).items():
            gram = compare(building)
            svm = fit_svm(gram[np.ix_(training, training)], [floors[i].annotated.kind for i in training])
            decisions[own] = decide(svm, gram[np.ix_(own, training)], types)
    return FloorScores(decisions)


def classify_floors_by_pianta(floors: Sequence[BuildingFloor], folds: Folds, label_set: LabelSet) -> FloorScores:
    """Probabilities of the types, and which floors pianta finds typical."""
    types, descriptions = list_types(floors), tuple(floor.descriptions[label_set] for floor in floors)
    true_types = tuple(floor.annotated.kind for floor in floors)
    model = BuildingTypeModel(descriptions, true_types, tuple(list_buildings(floors)), label_set)
    probabilities, typical = np.zeros((len(floors), len(types))), np.ones(len(floors), bool)
    for _, held_out in folds:
        others = model.leave_out(held_out)
        for i in held_out.tolist():
            prediction = others.predict_description(descriptions[i])
            probabilities[i] = [prediction.probabilities[name] for name in types]
            typical[i] = prediction.is_known
    return FloorScores(probabilities, typical)


def list_types(floors: Sequence[BuildingFloor]) -> list[str]:
    """The types of floors, sorted."""
    return sorted({floor.annotated.kind for floor in floors})


def list_buildings(floors: Sequence[BuildingFloor]) -> list[str]:
    """The building of each floor."""
    return [floor.annotated.building for floor in floors]


def compare_by_fold(buildings: Sequence[str], compare: Callable[[Indices], Floats]) -> Callable[[str], Floats]:
    """A function from a building to its Gram matrix, which all buildings of one of BIN_FOLDS folds share.

    compare: computes the matrix from the indices of the floors of all other folds.
    """
    fold_of = {name: number % BIN_FOLDS for number, name in enumerate(sorted(set(buildings)))}
    folds = np.array([fold_of[name] for name in buildings])
    compare_fold = cache(lambda fold: compare(np.flatnonzero(folds != fold)))
    return lambda building: compare_fold(fold_of[building])


def _group(held_out: Indices, buildings: Sequence[str]) -> dict[str, Indices]:
    """The indices of held-out floors by building."""
    names = [buildings[i] for i in held_out]
    return {name: held_out[[other == name for other in names]] for name in dict.fromkeys(names)}


def _grow(
    features: Sequence[Floats], truth: Sequence[Indices], training: Indices, *, trees: int, seed: int
) -> ExtraTrees:
    rows, classes = (np.concatenate([values[i] for i in training]) for values in (features, truth))
    return grow_extra_trees(rows, classes, parameters=TreeParameters(trees=trees), seed=seed)
