"""Building types as kLog classifies them: one decision for a floor, by all facts of it (thesis, section 6.2.2)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pianta.errors import ModelError
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.labels import LabelSet
from pianta.relational.facts import Interpretation
from pianta.relational.interpretation import FLOOR_RELATIONS, interpret_floor
from pianta.relational.kernels import (
    COST,
    ROOM_RELATIONS,
    FloorKernel,
    decide,
    fit_machine,
)

Floats = NDArray[np.float64]

TARGET = "buildingtype"
_RELATIONS = (*ROOM_RELATIONS, *(each for each in FLOOR_RELATIONS if each.signature.name == TARGET))


class RelationalBuildings:
    """A classifier of floors by type of building on a kernel of floors: fit to known floors, then predict others.

    Floors are Floor, told by ROOM_RELATIONS and their labels in label_set, or Interpretation, such as
    read_interpretations gives; the type is hidden.
    kernel: FloorKernel() unless given. cost: C of the support vector machine.

    types_: the types learnt.
    """

    def __init__(
        self, kernel: FloorKernel | None = None, *, label_set: LabelSet = LabelSet.R_C, cost: float = COST
    ) -> None:
        self.kernel = kernel or FloorKernel()
        self.label_set = label_set
        self.cost = cost

    def fit(self, floors: Sequence[Floor | Interpretation], types: Sequence[str] | None = None) -> RelationalBuildings:
        """Learn the types of floors; those that their own facts tell where none are given.

        Raises ModelError for floors without a type and fewer than two types, RelationError as FloorKernel, LabelError
        as interpret_floor.
        """
        told = self._tell(floors)
        self.kernel.check(told)
        given = _read_types(told) if types is None else list(types)
        if len(given) != len(told):
            raise ModelError(f"{len(given)} types are given for {len(told)} floors, give one each")
        gram = self.kernel.fit(told).compare()
        self.machine_ = fit_machine(gram, given, cost=self.cost)
        self.types_ = tuple(sorted(set(given)))
        return self

    def decide(self, floors: Sequence[Floor | Interpretation]) -> Floats:
        """Decision values, shape (floors, types_); raises ModelError before `fit`, and what `fit` raises."""
        gram = self.kernel.compare(self._tell(floors))
        return decide(self.machine_, gram, self.types_)

    def predict(self, floors: Sequence[Floor | Interpretation]) -> list[str]:
        """The type of each floor: that with the highest decision value."""
        return [self.types_[column] for column in self.decide(floors).argmax(axis=1)]

    def _tell(self, floors: Sequence[Floor | Interpretation]) -> list[Interpretation]:
        return [
            interpret_floor(each, relations=_RELATIONS, label_set=self.label_set) if isinstance(each, Floor) else each
            for each in floors
        ]


def _read_types(told: Sequence[Interpretation]) -> list[str]:
    """The types that facts tell."""
    types = [[str(fact.arguments[0]) for fact in each.facts_of(TARGET)] for each in told]
    faults = [
        f"{each.name} ({len(of_floor)})" for each, of_floor in zip(told, types, strict=True) if len(of_floor) != 1
    ]
    if faults:
        raise ModelError(f"floors {join_faults(faults)} tell not one {TARGET}, give each one")
    return [name for (name,) in types]
