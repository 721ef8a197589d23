"""EvaluatedFloor: class probabilities of the rooms of a floor, by models that were not trained on it, and the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from pianta._types import Floats, Indices
from pianta.evaluation.semantics import LabelPair, Reliability, measure_reliability, pair_backward, pair_forward
from pianta.floor import Floor
from pianta.labels import LabelConvention, LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.places.models import ClassProbabilities, true_labels

SCHOOLS = "schools"
OFFICES = "offices"
LAYOUTS = "layouts"
THESIS_LAYOUTS = "layouts, Algorithm 1"
TRUE_LAYOUTS = "true layouts"
# By part of reconstructed floors the method.
METHODS: Mapping[str, str] = MappingProxyType({LAYOUTS: "structure", THESIS_LAYOUTS: "thesis"})
# Each reconstructed room is paired with a true one (eq. 5.1), or each true room with a reconstructed one (eq. 5.2).
FORWARD = "FC"
BACKWARD = "BC"
DIGITS = 4  # of probabilities in the JSON file


@dataclass(frozen=True, eq=False)
class EvaluatedFloor:
    """A floor with the predictions of models, and its truth.

    part: SCHOOLS and OFFICES are annotated floors, LAYOUTS and THESIS_LAYOUTS reconstructed ones, TRUE_LAYOUTS the
        truth of these.
    floor: its rooms were classified. truth: with labels; the same rooms unless the floor was reconstructed.
    probabilities: by model and label set.
    """

    part: str
    item: str
    building: str
    floor: Floor
    truth: Floor
    probabilities: Mapping[str, ClassProbabilities]
    convention: LabelConvention

    def pair_labels(self, model: str, label_set: LabelSet, way: str = FORWARD) -> list[LabelPair]:
        """Predicted and true labels: FORWARD of all classified rooms, BACKWARD of all true rooms."""
        predicted = [LABELS[label_set][column] for column in self.probabilities[model][label_set].argmax(axis=1)]
        truth = true_labels(self.truth, label_set, convention=self.convention)
        if self.part not in METHODS:
            return [LabelPair(one, other) for one, other in zip(predicted, truth, strict=True)]
        rooms, true_rooms = ([room.polygon for room in floor.rooms] for floor in (self.floor, self.truth))
        return (pair_backward if way == BACKWARD else pair_forward)(rooms, predicted, true_rooms, truth)

    def select_labelled(self, model: str, label_set: LabelSet) -> tuple[Floats, Indices]:
        """Probabilities of the rooms with a true label, shape (n, labels), and the columns of these, shape (n,)."""
        true = [pair.true for pair in self.pair_labels(model, label_set)]
        columns = [LABELS[label_set].index(label) for label in true if label]
        return self.probabilities[model][label_set][np.array(true, bool)], np.array(columns, np.intp)

    def as_json(self) -> dict[str, object]:
        """True labels of the rooms in F/C/E/S, None for a room that overlaps no true room, and the probabilities."""
        functions = LabelSet.F_C_E_S
        pairs = self.pair_labels(next(iter(self.probabilities)), functions)
        return {
            "part": self.part,
            "item": self.item,
            "building": self.building,
            "rooms": [room.id for room in self.floor.rooms],
            "true": [pair.true for pair in pairs],
            "probabilities": {
                model: by_set[functions].round(DIGITS).tolist() for model, by_set in self.probabilities.items()
            },
        }


def measure_curve(floors: Sequence[EvaluatedFloor], model: str, label_set: LabelSet) -> Reliability:
    """Reliability of a model over the rooms of floors whose true label is known."""
    labelled = [floor.select_labelled(model, label_set) for floor in floors]
    probabilities = [np.zeros((0, len(LABELS[label_set]))), *(one for one, _ in labelled)]
    truth = [np.zeros(0, np.intp), *(columns for _, columns in labelled)]
    return measure_reliability(np.concatenate(probabilities), np.concatenate(truth))
