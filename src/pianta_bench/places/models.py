"""The models that bench places compares: Extra-Trees on single rooms, as the thesis has them, and pianta's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from pianta._types import Floats
from pianta.floor import Floor, scale_floor
from pianta.labels import FCES, SCHEMAS, LabelConvention, LabelSchema, LabelSet
from pianta.rooms.completion import LABELS
from pianta.rooms.model import RoomModel
from pianta.rooms.thesis_features import GEOMETRIC, ROOM_FEATURES, compute_room_features
from pianta.rooms.training import class_probabilities, train_rooms
from pianta_bench.data.annotated_floors import AnnotatedFloor

if TYPE_CHECKING:
    from sklearn.ensemble import ExtraTreesClassifier

# Probabilities of the rooms of a floor, shape (rooms, labels), by label set.
Opinion: TypeAlias = Mapping[LabelSet, Floats]

# Of IN_DRAWINGS_SCALE the trees are those of CENTRAL.
IN_DRAWINGS_SCALE = "Ex-T, drawing's scale"
LOCAL, CENTRAL, PIANTA, MAPPED = "Ex-T", "Ex-T, centrality", "pianta", "pianta, maps too"
STEPS, LAST_STEP = ("first pass", "second pass"), "random field"
# Section 6.2; all else as scikit-learn has it.
TREES = 500
# V_n without closeness and betweenness.
LOCAL_FEATURES = len(GEOMETRIC) + 1
WITHOUT_CENTRALITY, ALL_FEATURES = slice(0, LOCAL_FEATURES), slice(0, len(ROOM_FEATURES))


@dataclass(frozen=True, eq=False)
class LocalTrees:
    """Extra-Trees over V_n of single rooms (thesis, sections 5.3 and 6.1.3), for each label set.

    forests: their classes are places in LABELS. columns: those of V_n that it sees.
    """

    forests: Mapping[LabelSet, ExtraTreesClassifier]
    columns: slice

    def judge(self, floor: Floor) -> Opinion:
        """Probabilities of the labels of each set; of what was not in the training 0."""
        features = compute_room_features(floor)[:, self.columns]
        return {
            label_set: class_probabilities(forest, features, len(LABELS[label_set]))
            for label_set, forest in self.forests.items()
        }


@dataclass(frozen=True, eq=False)
class Judges:
    """All models that were trained without one building."""

    local: Mapping[str, LocalTrees]
    places: Mapping[str, RoomModel]
    split: LabelConvention

    def judge(self, floor: Floor) -> dict[str, Opinion]:
        """What each model says of a floor, and pianta's after each of its steps, by name."""
        opinions = {name: model.judge(floor) for name, model in self.local.items()}
        for name, model in self.places.items():
            steps = model.passes(floor)
            opinions[name] = both_sets(steps[LAST_STEP], self.split)
            opinions |= {name_step(name, step): both_sets(steps[step], self.split) for step in STEPS}
        return opinions

    def judge_rescaled(self, floor: Floor, factor: float) -> dict[str, Opinion]:
        """What CENTRAL says of a floor whose lengths are multiplied by a factor."""
        return {IN_DRAWINGS_SCALE: self.local[CENTRAL].judge(scale_floor(floor, factor, factor))}


def name_step(model: str, step: str) -> str:
    """The name of a model after one of its STEPS."""
    return f"{model}: {step}"


def train_judges(
    floors: Sequence[AnnotatedFloor],
    simulated: Mapping[str, Floor],
    *,
    kind: str,
    split: LabelConvention,
    seed: int,
) -> Judges:
    """Train all models on floors: Extra-Trees on those of one type, pianta's model on all.

    simulated: by `kind/item`, readings of simulated maps of some of these floors.
    """
    of_kind = [floor for floor in floors if floor.kind == kind]
    local = {
        name: train_local_trees(of_kind, columns=columns, split=split, seed=seed)
        for name, columns in ((LOCAL, WITHOUT_CENTRALITY), (CENTRAL, ALL_FEATURES))
    }
    readings = [simulated[key] for floor in floors if (key := f"{floor.kind}/{floor.item}") in simulated]
    places = {PIANTA: train_on(floors, split=split, seed=seed)}
    places[MAPPED] = train_on(floors, readings, split=split, seed=seed)
    return Judges(local, places, split)


def train_on(
    floors: Sequence[AnnotatedFloor], simulated: Sequence[Floor] = (), *, split: LabelConvention, seed: int
) -> RoomModel:
    """Train pianta's model, its labels divided as a split has them."""
    drawn = [floor.floor for floor in floors]
    return train_rooms(drawn, simulated=simulated, schemas=schemas_of(split), seed=seed)


def train_local_trees(
    floors: Sequence[AnnotatedFloor], *, columns: slice, split: LabelConvention, seed: int
) -> LocalTrees:
    """Train Extra-Trees on the rooms of floors, for R/C and for F/C/E/S."""
    from sklearn.ensemble import ExtraTreesClassifier

    features = np.concatenate([floor.features for floor in floors])[:, columns]
    forests = {}
    for label_set, labels in LABELS.items():
        truth = [labels.index(label) for floor in floors for label in true_labels(floor.floor, label_set, split=split)]
        forests[label_set] = ExtraTreesClassifier(TREES, random_state=seed).fit(features, truth)
    return LocalTrees(forests, columns)


def true_labels(floor: Floor, label_set: LabelSet, *, split: LabelConvention) -> list[str]:
    """The labels of the rooms of a floor with one known type, in a label set."""
    (kind,) = floor.building_type
    return SCHEMAS[kind].map_labels((room.label for room in floor.rooms), label_set, convention=split)


def schemas_of(split: LabelConvention) -> dict[str, LabelSchema]:
    """The schemas with labels that lie in F/C/E/S where the split has them, in the experiments' split as well."""
    return {
        kind: LabelSchema(
            kind, tuple(replace(label, in_experiments=label.function_in(split)) for label in schema.labels)
        )
        for kind, schema in SCHEMAS.items()
    }


def both_sets(functions: Floats, split: LabelConvention) -> Opinion:
    """F/C/E/S, and R/C as the split derives it from them."""
    corridors = (FCES.CONNECTION, FCES.ENTRANCE) if split is LabelConvention.FIGURE else (FCES.CONNECTION,)
    columns = [LABELS[LabelSet.F_C_E_S].index(label) for label in corridors]
    corridor = functions[:, columns].sum(axis=1)
    return {LabelSet.R_C: np.column_stack([1 - corridor, corridor]), LabelSet.F_C_E_S: functions}
