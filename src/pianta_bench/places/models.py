"""The models that bench places compares: Extra-Trees on single rooms, as the thesis has them, and pianta's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.floor import Floor, scale_floor
from pianta.labels import FCES, SCHEMAS, LabelConvention, LabelSchema, LabelSet
from pianta.rooms.completion import LABELS
from pianta.rooms.extra_trees import ExtraTrees, TreeParameters, grow_extra_trees
from pianta.rooms.features import RoomContext, describe_rooms
from pianta.rooms.model import RoomModel
from pianta.rooms.thesis_features import GEOMETRIC, ROOM_FEATURES, compute_room_features
from pianta.rooms.training import SIMULATED_WEIGHT, TrainingFloor, prepare_floors, train_on_prepared
from pianta_bench._options import PLACE_SPLITS
from pianta_bench.data.annotated_floors import AnnotatedFloor

# Probabilities of the rooms of a floor, shape (rooms, labels), by label set.
ClassProbabilities: TypeAlias = Mapping[LabelSet, Floats]

LOCAL, CENTRAL, PIANTA, MAPPED = "Ex-T", "Ex-T, centrality", "pianta", "pianta, maps too"
# The trees of CENTRAL, on a floor that is enlarged to the scale of its drawing.
IN_DRAWINGS_SCALE = "Ex-T, drawing's scale"
STEPS, LAST_STEP = ("first pass", "second pass"), "random field"
TREES = 500  # of each forest; thesis, section 6.2
# Columns of V_n: without closeness and betweenness, and all.
COLUMNS: Mapping[str, slice] = {LOCAL: slice(0, len(GEOMETRIC) + 1), CENTRAL: slice(0, len(ROOM_FEATURES))}
WITHOUT_CENTRALITY, ALL_FEATURES = COLUMNS.values()


@dataclass(frozen=True, eq=False)
class DescribedFloor:
    """The features of a floor, as models classify its rooms: those of the thesis, and those of pianta."""

    features: Floats
    context: RoomContext
    rescaled: Floats | None = None

    @classmethod
    def describe(cls, floor: Floor, *, scale: float | None = None) -> DescribedFloor:
        """Describe a floor. scale: by what its lengths are multiplied for IN_DRAWINGS_SCALE; None to leave that out."""
        rescaled = None if scale is None else compute_room_features(scale_floor(floor, scale, scale))
        return cls(compute_room_features(floor), describe_rooms(floor), rescaled)


@dataclass(frozen=True, eq=False)
class PreparedFloor:
    """An annotated floor with all that training needs; computed once for all models.

    described: as it is classified. simulated: as it was reconstructed from a simulated map, None if that failed.
    examples, simulated_examples: both as floors for training; empty without rooms.
    """

    annotated: AnnotatedFloor
    described: DescribedFloor
    examples: tuple[TrainingFloor, ...]
    simulated: Floor | None = None
    simulated_examples: tuple[TrainingFloor, ...] = ()


def list_examples(
    floors: Sequence[Floor], simulated: Sequence[Floor] = (), *, convention: LabelConvention
) -> tuple[TrainingFloor, ...]:
    """Annotated and simulated floors as pianta's model is trained on them."""
    schemas = schemas_of(convention)
    return (*prepare_floors(floors, schemas), *prepare_floors(simulated, schemas, weight=SIMULATED_WEIGHT))


@dataclass(frozen=True, eq=False)
class LocalTrees:
    """Extra-Trees over V_n of single rooms (thesis, sections 5.3 and 6.1.3), for each label set.

    forests: their classes are indices in LABELS. columns: those of V_n that it uses.
    """

    forests: Mapping[LabelSet, ExtraTrees]
    columns: slice

    def predict(self, features: Floats) -> ClassProbabilities:
        """Probabilities of the labels of each set; 0 for labels that were not in the training."""
        return {
            label_set: forest.class_probabilities(features[:, self.columns], len(LABELS[label_set]))
            for label_set, forest in self.forests.items()
        }


@dataclass(frozen=True, eq=False)
class Classifiers:
    """All models, trained on the same floors when they are first used."""

    floors: Sequence[PreparedFloor]
    convention: LabelConvention
    seed: int
    _local: dict[str, Mapping[str, LocalTrees]] = field(default_factory=dict)

    def local(self, building_type: str) -> Mapping[str, LocalTrees]:
        """Extra-Trees by name, trained on the floors of a building type."""
        if building_type not in self._local:
            floors = [floor.annotated for floor in self.floors if floor.annotated.kind == building_type]
            self._local[building_type] = {
                name: train_local_trees(floors, columns=columns, convention=self.convention, seed=self.seed)
                for name, columns in COLUMNS.items()
            }
        return self._local[building_type]

    @cached_property
    def room_models(self) -> Mapping[str, RoomModel]:
        """Pianta's models by name, trained on the floors of all types."""
        annotated = [example for floor in self.floors for example in floor.examples]
        simulated = [example for floor in self.floors for example in floor.simulated_examples]
        return {
            name: train_room_model(examples, convention=self.convention, seed=self.seed)
            for name, examples in ((PIANTA, annotated), (MAPPED, annotated + simulated))
        }

    def predict(self, floor: DescribedFloor, building_type: str) -> dict[str, ClassProbabilities]:
        """The probabilities of each model for a floor of a type, and those of pianta's after each of their steps."""
        local = self.local(building_type)
        probabilities = {name: model.predict(floor.features) for name, model in local.items()}
        for name, model in self.room_models.items():
            steps = model.predict_functions(floor.context)
            probabilities[name] = both_sets(steps[LAST_STEP], self.convention)
            probabilities |= {name_step(name, step): both_sets(steps[step], self.convention) for step in STEPS}
        if floor.rescaled is not None:
            probabilities[IN_DRAWINGS_SCALE] = local[CENTRAL].predict(floor.rescaled)
        return probabilities


def name_step(model: str, step: str) -> str:
    """The name of a model after one of its STEPS."""
    return f"{model}: {step}"


def with_steps(model: str) -> list[str]:
    """The names of a model and of its STEPS."""
    return [model, *(name_step(model, step) for step in STEPS)]


def train_room_model(examples: Sequence[TrainingFloor], *, convention: LabelConvention, seed: int) -> RoomModel:
    """Train pianta's model with the labels of a convention."""
    return train_on_prepared(examples, schemas=schemas_of(convention), seed=seed)


def train_local_trees(
    floors: Sequence[AnnotatedFloor], *, columns: slice, convention: LabelConvention, seed: int
) -> LocalTrees:
    """Train Extra-Trees on the rooms of floors, for R/C and for F/C/E/S."""
    features = np.concatenate([floor.features for floor in floors])[:, columns]
    forests = {}
    for label_set, labels in LABELS.items():
        truth = [true_labels(floor.floor, label_set, convention=convention) for floor in floors]
        columns_of_truth = np.array([labels.index(label) for floor in truth for label in floor])
        parameters = TreeParameters(trees=TREES)
        forests[label_set] = grow_extra_trees(features, columns_of_truth, parameters=parameters, seed=seed)
    return LocalTrees(forests, columns)


def true_labels(floor: Floor, label_set: LabelSet, *, convention: LabelConvention) -> list[str]:
    """The labels of the rooms of a floor of one known type, in a label set."""
    (building_type,) = floor.building_type
    return SCHEMAS[building_type].map_labels((room.label for room in floor.rooms), label_set, convention=convention)


def schemas_of(convention: LabelConvention) -> dict[str, LabelSchema]:
    """The schemas, whose labels have the place in F/C/E/S of a convention, by the convention of the experiments too."""
    return {
        building_type: LabelSchema(
            building_type,
            tuple(replace(label, in_experiments=label.function_in(convention)) for label in schema.labels),
        )
        for building_type, schema in SCHEMAS.items()
    }


def both_sets(functions: Floats, convention: LabelConvention) -> ClassProbabilities:
    """F/C/E/S, and R/C as the convention derives it from them."""
    corridors = (FCES.CONNECTION, FCES.ENTRANCE) if convention is LabelConvention.FIGURE else (FCES.CONNECTION,)
    columns = [LABELS[LabelSet.F_C_E_S].index(label) for label in corridors]
    corridor = functions[:, columns].sum(axis=1)
    return {LabelSet.R_C: np.column_stack([1 - corridor, corridor]), LabelSet.F_C_E_S: functions}


def check_convention(name: str) -> LabelConvention:
    """The convention of a name; raises OptionError unless labels can be classified in it."""
    if name not in PLACE_SPLITS:
        raise OptionError(f"split is {name!r}, give one of {', '.join(PLACE_SPLITS)}")
    return LabelConvention(name)
