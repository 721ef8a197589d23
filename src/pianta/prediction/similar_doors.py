"""What is behind an unopened door, from what was behind similar doors of the floors of a model."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pianta._types import Floats, Mask
from pianta.evaluation.prediction import measure_divergence
from pianta.labels import LabelConvention, LabelSchema, LabelSet
from pianta.prediction.explored_part import ExploredPart
from pianta.prediction.open_ends import DoorExample, count_labels_of_part

# Each label of the schema counts as this many doors, so that none is impossible. Chosen by hand.
LEAST_DOORS = 1e-3


@dataclass(frozen=True)
class DoorWeights:
    """How much the doors of a model count; chosen by training/choose_door_labels.py.

    size_width: of the kernel over logarithms of the areas of rooms with a door. label_width: of that over divergences
    of the labels of known rooms, bits. any_doors: as many doors of rooms with the same function as all doors of
    corridors, or of other rooms, weigh together. function_doors: as many doors of rooms with the same label as those
    with the same function weigh.
    """

    size_width: float = 0.5
    label_width: float = 0.2
    any_doors: float = 1.0
    function_doors: float = 10.0


class SimilarDoors:
    """The doors of the floors of a model, and what was behind them. examples: of a model with this schema."""

    def __init__(
        self, examples: Sequence[DoorExample], schema: LabelSchema, weights: DoorWeights | None = None
    ) -> None:
        self.schema, self.weights = schema, weights or DoorWeights()
        self.names = [*schema.by_name]
        functions = schema.map_labels(self.names, LabelSet.F_C_E_S, convention=LabelConvention.GRAPHS)
        self._functions = dict(zip(self.names, functions, strict=True))
        self._near = np.array([example.near for example in examples], str)
        self._near_functions = np.array([self._functions[example.near] for example in examples], str)
        self._sizes = np.array([_log_area(example.area) for example in examples])
        self._known = np.array([example.labels / example.labels.sum() for example in examples])
        self._behind = np.array([[float(example.far == name) for name in self.names] for example in examples])
        self._at_corridor = np.array([example.is_corridor for example in examples])

    def predict(self, explored: ExploredPart) -> dict[int, dict[str, float]]:
        """By unopened door the probability of each label of the schema behind it; empty without examples.

        A door of the model counts less the more the area of its room and the known labels differed. Those of rooms with
        the same label count most, those of rooms with the same function (F/C/E/S) next, then all: all doors of
        corridors for a corridor, all others for a room.
        """
        if not len(self._behind):
            return {}
        labels = count_labels_of_part(explored, self.schema)
        weights = np.exp(-measure_divergence(self._known, labels / labels.sum()) / self.weights.label_width)
        predictions = {}
        for door, near in explored.doors.items():
            is_alike = self._at_corridor == (near in explored.corridors)
            room = explored.graph.nodes[near]
            # Without any door of corridors, those of rooms say more than nothing, and the other way round
            shares = self._predict_door(room["label"], room.get("area"), weights, is_alike | (not is_alike.any()))
            predictions[door] = dict(zip(self.names, shares.tolist(), strict=True))
        return predictions

    def _predict_door(self, label: str, area: float | None, weights: Floats, is_alike: Mask) -> Floats:
        """The probabilities behind a door of a room with this label and area.

        weights, is_alike: of the examples; how much they count, and whether they count at all.
        """
        # Examples count fully if one of both areas is unknown.
        gaps = np.nan_to_num(self._sizes - _log_area(area))
        weights = weights * is_alike * np.exp(-(gaps**2) / (2 * self.weights.size_width**2))
        any_door = _normalise(is_alike @ self._behind + LEAST_DOORS)
        same_function = (weights * (self._near_functions == self._functions[label])) @ self._behind
        same_label = (weights * (self._near == label)) @ self._behind
        shares = _normalise(same_function + self.weights.any_doors * any_door)
        return _normalise(same_label + self.weights.function_doors * shares)


def _log_area(area: float | None) -> float:
    return np.nan if area is None else float(np.log(area))


def _normalise(counts: Floats) -> Floats:
    shares: Floats = counts / counts.sum()
    return shares
