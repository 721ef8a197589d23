"""The models that bench buildings compares, each judging floors that it was not trained on.

Extra-Trees on single rooms and the relational kernel are those of Table 6.1; the third is pianta's own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Indices
from pianta.building_types.model import BuildingTypeModel
from pianta.evaluation.folds import leave_buildings_out
from pianta.labels import LabelConvention, LabelSet
from pianta.relational.kernels import FloorKernel, RoomKernel, decide, fit_svm
from pianta.rooms.completion import LABELS
from pianta.rooms.training import class_probabilities
from pianta_bench.buildings.floors import BuildingFloor
from pianta_bench.places.models import (
    ALL_FEATURES,
    CENTRAL,
    LAST_STEP,
    LOCAL,
    PIANTA,
    WITHOUT_CENTRALITY,
    both_sets,
    train_on,
)

if TYPE_CHECKING:
    from sklearn.ensemble import ExtraTreesClassifier

Folds = Sequence[tuple[Indices, Indices]]

KLOG = "kLog-style"
MODELS = (LOCAL, CENTRAL, KLOG, PIANTA)
COLUMNS: Mapping[str, slice] = {LOCAL: WITHOUT_CENTRALITY, CENTRAL: ALL_FEATURES}
# The bins of the relational kernel are cut so many times, each time without the floors of a part of the buildings.
PARTS = 3


def list_folds(buildings: Sequence[str]) -> Folds:
    """For each building the places of the floors of all others, and of its own."""
    return list(leave_buildings_out(buildings))


def judge_places_by_trees(
    floors: Sequence[BuildingFloor], label_set: LabelSet, *, model: str, trees: int, seed: int
) -> list[Floats]:
    """Of each floor the probabilities of the labels of its rooms, shape (rooms, labels), by trees (section 6.1.3)."""
    labels = LABELS[label_set]
    features = [floor.drawn.features[:, COLUMNS[model]] for floor in floors]
    truth = [np.array([labels.index(label) for label in floor.labels[label_set]]) for floor in floors]
    judged = [np.zeros((0, len(labels)))] * len(floors)
    for seen, held_out in list_folds([floor.drawn.building for floor in floors]):
        forest = _grow([features[i] for i in seen], [truth[i] for i in seen], trees=trees, seed=seed)
        for i in held_out.tolist():
            judged[i] = class_probabilities(forest, features[i], len(labels))
    return judged


def judge_places_by_relations(floors: Sequence[BuildingFloor]) -> dict[LabelSet, list[Floats]]:
    """By label set, of each floor decision values, shape (rooms, labels); all sets share the Gram matrices."""
    buildings = [floor.drawn.building for floor in floors]
    facts = [floor.facts for floor in floors]
    compare = _compare_by_part(
        buildings, lambda others: RoomKernel().fit(facts, binned=[facts[i] for i in others]).compare()
    )
    starts = np.cumsum([0, *(len(floor.drawn.floor.rooms) for floor in floors)])
    rows = [np.arange(start, end) for start, end in pairwise(starts)]
    judged = {label_set: [np.zeros((0, len(labels)))] * len(floors) for label_set, labels in LABELS.items()}
    for seen, held_out in list_folds(buildings):
        gram = compare(buildings[held_out[0]])
        known, new = (np.concatenate([rows[i] for i in places]) for places in (seen, held_out))
        ends = np.cumsum([len(rows[i]) for i in held_out])[:-1]
        for label_set, labels in LABELS.items():
            machine = fit_svm(gram[np.ix_(known, known)], [name for i in seen for name in floors[i].labels[label_set]])
            decided = np.split(decide(machine, gram[np.ix_(new, known)], labels), ends)
            for i, values in zip(held_out.tolist(), decided, strict=True):
                judged[label_set][i] = values
    return judged


def judge_places_by_pianta(
    floors: Sequence[BuildingFloor], building: str, *, split: LabelConvention, seed: int
) -> Iterator[tuple[int, Mapping[LabelSet, Floats]]]:
    """Of each floor of a building its place, and probabilities by label set, by pianta's model of all other floors."""
    model = train_on([floor.drawn for floor in floors if floor.drawn.building != building], split=split, seed=seed)
    for place, floor in enumerate(floors):
        if floor.drawn.building == building:
            yield place, both_sets(model.passes(floor.drawn.unlabelled)[LAST_STEP], split)


def judge_buildings_by_trees(
    floors: Sequence[BuildingFloor], folds: Folds, label_set: LabelSet, *, model: str, trees: int, seed: int
) -> Floats:
    """Shares of the rooms that are given each type, shape (floors, types): the floor has the most frequent one.

    A room has its features and its label (section 6.2.2).
    """
    types = list_types(floors)
    labels = np.array(LABELS[label_set])
    features = [
        np.column_stack([floor.drawn.features[:, COLUMNS[model]], np.array(floor.labels[label_set])[:, None] == labels])
        for floor in floors
    ]
    truth = [np.full(len(each), types.index(floor.drawn.kind)) for each, floor in zip(features, floors, strict=True)]
    judged = np.zeros((len(floors), len(types)))
    for seen, held_out in folds:
        forest = _grow([features[i] for i in seen], [truth[i] for i in seen], trees=trees, seed=seed)
        for i in held_out.tolist():
            judged[i] = np.bincount(forest.predict(features[i]), minlength=len(types)) / len(features[i])
    return judged


def compare_floors(floors: Sequence[BuildingFloor], label_set: LabelSet) -> Callable[[str], Floats]:
    """The Gram matrix of all floors for the judgement of a building, whose floors had no part in the bins."""
    told = [floor.told[label_set] for floor in floors]

    def compare(others: Indices) -> Floats:
        kernel = FloorKernel()
        return kernel.fit(told, binned=[told[i] for i in others]).compare()

    return _compare_by_part([floor.drawn.building for floor in floors], compare)


def judge_buildings_by_relations(
    floors: Sequence[BuildingFloor], folds: Folds, compare: Callable[[str], Floats]
) -> Floats:
    """Decision values of the types, shape (floors, types); compare: as compare_floors gives it."""
    types = list_types(floors)
    judged = np.zeros((len(floors), len(types)))
    for seen, held_out in folds:
        gram = compare(floors[held_out[0]].drawn.building)
        machine = fit_svm(gram[np.ix_(seen, seen)], [floors[i].drawn.kind for i in seen])
        judged[held_out] = decide(machine, gram[np.ix_(held_out, seen)], types)
    return judged


def judge_buildings_by_pianta(
    floors: Sequence[BuildingFloor], folds: Folds, label_set: LabelSet
) -> tuple[Floats, NDArray[np.bool_]]:
    """Probabilities of the types, shape (floors, types), and whether each floor is like known ones at all."""
    types = list_types(floors)
    known = tuple(floor.descriptions[label_set] for floor in floors)
    kinds, buildings = ([getattr(floor.drawn, name) for floor in floors] for name in ("kind", "building"))
    model = BuildingTypeModel(known, tuple(kinds), tuple(buildings), label_set)
    judged, typical = np.zeros((len(floors), len(types))), np.ones(len(floors), bool)
    for _, held_out in folds:
        without = model.leave_out(held_out)
        for i in held_out.tolist():
            verdict = without.predict_description(known[i])
            judged[i] = [verdict.probabilities[name] for name in types]
            typical[i] = verdict.is_known
    return judged, typical


def list_types(floors: Sequence[BuildingFloor]) -> list[str]:
    """The types of floors, sorted."""
    return sorted({floor.drawn.kind for floor in floors})


def _compare_by_part(buildings: Sequence[str], compare: Callable[[Indices], Floats]) -> Callable[[str], Floats]:
    """What is compared for a building, once for all buildings of its part.

    compare: is given the places of the floors of all other parts.
    """
    part_of = {name: number % PARTS for number, name in enumerate(sorted(set(buildings)))}
    parts = np.array([part_of[name] for name in buildings])
    of_part = cache(lambda part: compare(np.flatnonzero(parts != part)))
    return lambda building: of_part(part_of[building])


def _grow(features: Sequence[Floats], truth: Sequence[Indices], *, trees: int, seed: int) -> ExtraTreesClassifier:
    from sklearn.ensemble import ExtraTreesClassifier

    return ExtraTreesClassifier(trees, random_state=seed).fit(np.concatenate(features), np.concatenate(truth))
