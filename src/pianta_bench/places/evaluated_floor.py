"""JudgedFloor: what models say of the rooms of a floor that they were not trained on, and the truth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats
from pianta.evaluation.semantics import LabelPair, pair_backward, pair_forward
from pianta.floor import Floor
from pianta.labels import LabelConvention, LabelSet
from pianta.rooms.completion import LABELS
from pianta_bench.places.models import Opinion, true_labels

SCHOOLS, OFFICES, LAYOUTS, TRUE_LAYOUTS = "schools", "offices", "layouts", "true layouts"
PLACES_DIGITS = 4


@dataclass(frozen=True, eq=False)
class JudgedFloor:
    """A floor as models saw it, and as it is.

    part: SCHOOLS and OFFICES are drawn floors, LAYOUTS reconstructed ones, TRUE_LAYOUTS the truth of these.
    found: the rooms that were judged. true: the labelled rooms; the same rooms where nothing was reconstructed.
    opinions: by model and label set.
    """

    part: str
    item: str
    building: str
    found: Floor
    true: Floor
    opinions: Mapping[str, Opinion]
    split: LabelConvention

    def given(self, model: str, label_set: LabelSet) -> list[str]:
        """The most probable label of each judged room."""
        return [LABELS[label_set][column] for column in self.opinions[model][label_set].argmax(axis=1)]

    def truth(self, label_set: LabelSet) -> list[str]:
        """The label of each true room."""
        return true_labels(self.true, label_set, split=self.split)

    def pair(self, model: str, label_set: LabelSet, *, backward: bool = False) -> list[LabelPair]:
        """Given and true labels of all judged rooms, or backward of all true rooms (eqs. 5.1 and 5.2)."""
        given, truth = self.given(model, label_set), self.truth(label_set)
        if self.part != LAYOUTS:
            return [LabelPair(one, other) for one, other in zip(given, truth, strict=True)]
        found, true = ([room.polygon for room in floor.rooms] for floor in (self.found, self.true))
        return (pair_backward if backward else pair_forward)(found, given, true, truth)

    def known(self, model: str, label_set: LabelSet) -> tuple[Floats, NDArray[np.intp]]:
        """Probabilities of judged rooms whose true label is known, shape (n, labels), and its column, shape (n,)."""
        columns = [LABELS[label_set].index(pair.true) if pair.true else None for pair in self.pair(model, label_set)]
        is_known = np.array([column is not None for column in columns], bool)
        truth = np.array([column for column in columns if column is not None], np.intp)
        return self.opinions[model][label_set][is_known], truth

    def as_json(self) -> dict[str, object]:
        """Every judged room: the true label in F/C/E/S, None where it overlaps no true room, and what models say."""
        functions = LabelSet.F_C_E_S
        pairs = self.pair(next(iter(self.opinions)), functions)
        return {
            "part": self.part,
            "item": self.item,
            "building": self.building,
            "rooms": [room.id for room in self.found.rooms],
            "true": [pair.true for pair in pairs],
            "probabilities": {
                model: opinion[functions].round(PLACES_DIGITS).tolist() for model, opinion in self.opinions.items()
            },
        }
