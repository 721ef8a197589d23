"""Scores: the scores that all models give rooms and floors in bench buildings, and the errors that follow."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from pianta._types import Floats, Mask
from pianta.evaluation.curves import Curve, measure_precision_recall, measure_roc
from pianta.labels import RC, LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.buildings.floors import BuildingFloor
from pianta_bench.buildings.models import MODELS, FloorScores, list_types
from pianta_bench.data.annotated_floors import KINDS

# The training leaves out the building, or only the floor, as in the thesis.
BUILDING = "building"
FLOOR = "floor"
PARTS = {"school": "S", "office": "O"}
BOTH = "S+O"
POSITIVE = "office"  # the rarer type is the positive one in the curves of buildings
DIGITS = 4  # of scores and curves in the JSON file


@dataclass(frozen=True, eq=False)
class Scores:
    """Scores of rooms and floors; the highest score of a row is the prediction.

    rooms: by model and label set, for each floor the scores of its rooms, shape (rooms, labels); empty for floors of
        folders. types: by what was left out (BUILDING or FLOOR), model and label set, the scores of the floors.
    """

    floors: Sequence[BuildingFloor]
    rooms: dict[tuple[str, LabelSet], dict[int, Floats]] = field(default_factory=dict)
    types: dict[tuple[str, str, LabelSet], FloorScores] = field(default_factory=dict)

    @property
    def building_types(self) -> list[str]:
        """The types, in the order of their scores."""
        return list_types(self.floors)

    def list_type(self, building_type: str) -> list[int]:
        """The indices of the floors of a type."""
        return [index for index, floor in enumerate(self.floors) if floor.annotated.kind == building_type]

    def predicted_labels(self, index: int, model: str, label_set: LabelSet) -> list[str]:
        """The labels that a model gives the rooms of a floor."""
        return [LABELS[label_set][column] for column in self.rooms[model, label_set][index].argmax(axis=1)]

    def wrong_rooms(self, index: int, model: str, label_set: LabelSet) -> Mask:
        """Which rooms of a floor have a wrong label, shape (rooms,)."""
        predicted = np.array(self.predicted_labels(index, model, label_set))
        return np.asarray(predicted != np.array(self.floors[index].labels[label_set]))

    def predicted_types(self, left_out: str, model: str, label_set: LabelSet) -> list[str]:
        """The types that a model gives the floors."""
        return [self.building_types[column] for column in self.types[left_out, model, label_set].values.argmax(axis=1)]

    def wrong_floors(self, left_out: str, model: str, label_set: LabelSet) -> Mask:
        """Which floors have a wrong type, shape (floors,)."""
        truth = [floor.annotated.kind for floor in self.floors]
        return np.asarray(np.array(self.predicted_types(left_out, model, label_set)) != np.array(truth))

    def measure_curves(self) -> Iterator[tuple[str, str, str, Curve]]:
        """ROC and PR curves in R/C: part (S, O or S+O), model, name, curve."""
        for building_type, model in product(KINDS, MODELS):
            indices, labels = self.list_type(building_type), LABELS[LabelSet.R_C]
            truth = [label == RC.CORRIDOR for index in indices for label in self.floors[index].labels[LabelSet.R_C]]
            rooms = np.concatenate([self.rooms[model, LabelSet.R_C][index] for index in indices])
            yield from _measure_both(PARTS[building_type], model, truth, rooms[:, labels.index(RC.CORRIDOR)])
        truth = [floor.annotated.kind == POSITIVE for floor in self.floors]
        for model in MODELS:
            scores = self.types[BUILDING, model, LabelSet.R_C].values
            yield from _measure_both(BOTH, model, truth, scores[:, self.building_types.index(POSITIVE)])

    def as_json(self) -> list[dict[str, object]]:
        """For each floor the truth, the predicted labels of its rooms, and the scores of the types."""
        return [
            {
                "item": floor.annotated.item,
                "building": floor.annotated.building,
                "type": floor.annotated.kind,
                "rooms": [room.id for room in floor.annotated.floor.rooms],
                "true": {str(label_set): labels for label_set, labels in floor.labels.items()},
                "predicted": [
                    {"model": model, "labels": label_set, "predicted": self.predicted_labels(index, model, label_set)}
                    for model, label_set in self.rooms
                ],
                "scores": [
                    {"left_out": left_out, "model": model, "labels": label_set}
                    | dict(zip(self.building_types, scores.values[index].round(DIGITS).tolist(), strict=True))
                    for (left_out, model, label_set), scores in self.types.items()
                ],
            }
            for index, floor in enumerate(self.floors)
        ]


def _measure_both(
    part: str, model: str, truth: Sequence[bool], scores: Floats
) -> Iterator[tuple[str, str, str, Curve]]:
    yield part, model, "ROC", measure_roc(truth, scores.tolist())
    yield part, model, "PR", measure_precision_recall(truth, scores.tolist())
