"""The models that bench places compares: Extra-Trees on single rooms, as the thesis has them, and pianta's."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from pianta._types import Floats
from pianta.errors import OptionError
from pianta.floor import Floor
from pianta.labels import FCES, SCHEMAS, LabelConvention, LabelSchema, LabelSet
from pianta.rooms.completion import LABELS
from pianta.rooms.extra_trees import ExtraTrees, TreeParameters, grow_extra_trees
from pianta.rooms.features import RoomContext
from pianta.rooms.model import RoomModel
from pianta.rooms.thesis_features import GEOMETRIC, ROOM_FEATURES
from pianta.rooms.training import SIMULATED_WEIGHT, TrainingFloor, prepare_floors, train_on_prepared
from pianta_bench._options import PLACE_SPLITS
from pianta_bench.data.annotated_floors import AnnotatedFloor

# Probabilities of the rooms of a floor, shape (rooms, labels), by label set.
ClassProbabilities: TypeAlias = Mapping[LabelSet, Floats]

LOCAL = "Ex-T"
CENTRAL = "Ex-T, centrality"
PIANTA = "pianta"
MAPPED = "pianta, maps too"
# The trees of CENTRAL, on a floor that is enlarged to the scale of its drawing.
IN_DRAWINGS_SCALE = "Ex-T, drawing's scale"
STEPS = ("first pass", "second pass")
LAST_STEP = "random field"
TREES = 500  # of each forest of Extra-Trees; thesis, section 6.2
LOCAL_TREES = TreeParameters(trees=TREES)
# Columns of V_n.
WITHOUT_CENTRALITY = slice(0, len(GEOMETRIC) + 1)  # without closeness and betweenness
ALL_FEATURES = slice(0, len(ROOM_FEATURES))
COLUMNS: Mapping[str, slice] = MappingProxyType({LOCAL: WITHOUT_CENTRALITY, CENTRAL: ALL_FEATURES})


@dataclass(frozen=True, eq=False)
class PreparedFloor:
    """An annotated floor with all inputs of the models, computed once.

    examples: the floor for training; then the floor reconstructed from a simulated map of it, if that has rooms.
    simulated: the reconstructed floor.
    """

    annotated: AnnotatedFloor
    examples: tuple[TrainingFloor, ...]
    simulated: Floor | None = None

    @classmethod
    def prepare(cls, annotated: AnnotatedFloor, convention: LabelConvention) -> PreparedFloor:
        """A floor without a simulated map."""
        _ = annotated.features, annotated.unlabelled  # computed here, and cached
        return cls(annotated, list_examples([annotated.floor], convention=convention))

    @property
    def context(self) -> RoomContext:
        """The context of its rooms."""
        return self.examples[0].context


def list_examples(
    floors: Sequence[Floor], simulated: Sequence[Floor] = (), *, convention: LabelConvention
) -> tuple[TrainingFloor, ...]:
    """Annotated and simulated floors as pianta's model is trained on them."""
    schemas = schemas_of(convention)
    return (*prepare_floors(floors, schemas), *prepare_floors(simulated, schemas, weight=SIMULATED_WEIGHT))


@dataclass(frozen=True, eq=False)
class Classifiers:
    """All models, trained on the same floors when they are first used."""

    floors: Sequence[PreparedFloor]
    convention: LabelConvention
    seed: int
    _forests: dict[tuple[str, str, LabelSet], ExtraTrees] = field(default_factory=dict)

    @cached_property
    def room_models(self) -> Mapping[str, RoomModel]:
        """Pianta's models by name."""
        annotated = [floor.examples[0] for floor in self.floors]
        simulated = [example for floor in self.floors for example in floor.examples[1:]]
        return {
            name: train_room_model(examples, convention=self.convention, seed=self.seed)
            for name, examples in ((PIANTA, annotated), (MAPPED, annotated + simulated))
        }

    def forest(self, model: str, building_type: str, label_set: LabelSet) -> ExtraTrees:
        """Extra-Trees over V_n of the single rooms of a type (thesis, 5.3 and 6.1.3); classes: indices in LABELS."""
        key = model, building_type, label_set
        if key not in self._forests:
            floors = [each.annotated for each in self.floors if each.annotated.kind == building_type]
            features = np.concatenate([floor.features for floor in floors])[:, COLUMNS[model]]
            labels = [true_labels(floor.floor, label_set, convention=self.convention) for floor in floors]
            truth = np.array([LABELS[label_set].index(label) for floor_labels in labels for label in floor_labels])
            self._forests[key] = grow_extra_trees(features, truth, parameters=LOCAL_TREES, seed=self.seed)
        return self._forests[key]

    def predict_local(self, model: str, building_type: str, features: Floats) -> ClassProbabilities:
        """The probabilities of Extra-Trees; 0 for labels that were not in the training. features: V_n."""
        return {
            label_set: self.forest(model, building_type, label_set).class_probabilities(
                features[:, COLUMNS[model]], len(labels)
            )
            for label_set, labels in LABELS.items()
        }

    def predict(self, building_type: str, features: Floats, context: RoomContext) -> dict[str, ClassProbabilities]:
        """The probabilities of each model for a floor of a type, for pianta's models also after each of their steps."""
        probabilities = {model: self.predict_local(model, building_type, features) for model in COLUMNS}
        for name, model in self.room_models.items():
            steps = model.predict_functions(context)
            probabilities[name] = both_sets(steps[LAST_STEP], self.convention)
            probabilities |= {name_step(name, step): both_sets(steps[step], self.convention) for step in STEPS}
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


def true_labels(floor: Floor, label_set: LabelSet, *, convention: LabelConvention) -> list[str]:
    """The labels of the rooms of a floor of one known type, in a label set."""
    (building_type,) = floor.building_type
    return SCHEMAS[building_type].map_labels((room.label for room in floor.rooms), label_set, convention=convention)


def schemas_of(convention: LabelConvention) -> dict[str, LabelSchema]:
    """The schemas with the functions (F/C/E/S) of a convention, also as the convention of the experiments."""
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
    """The convention of a name; raises OptionError unless rooms are classified by it."""
    if name not in PLACE_SPLITS:
        raise OptionError(f"split is {name!r}, give one of {', '.join(PLACE_SPLITS)}")
    return LabelConvention(name)
