"""Rooms and buildings as kLog classifies them, the whole floor as the interpretation (thesis, section 6.2)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from pianta._types import Floats
from pianta.errors import ModelError
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.labels import LabelSet
from pianta.relational.facts import Interpretation, Value
from pianta.relational.interpretation import FLOOR_RELATIONS, interpret_floor
from pianta.relational.kernels import (
    COST,
    ROOM_RELATIONS,
    FloorKernel,
    RoomKernel,
    decide,
    fit_svm,
)

# Of each floor, a label for each room.
Labels: TypeAlias = Sequence[Sequence[str]]
TARGET = "buildingtype"
_RELATIONS = (*ROOM_RELATIONS, *(each for each in FLOOR_RELATIONS if each.signature.name == TARGET))


class RelationalRoomClassifier:
    """A classifier of rooms on a kernel of rooms: fit to labelled floors, then predict those of others.

    Floors are Floor, told by ROOM_RELATIONS, or Interpretation, such as read_interpretations gives; the labels to be
    learnt are hidden.
    kernel: RoomKernel() unless given. cost: C of the support vector machines.

    labels_: by the name of a label set, the labels learnt.
    """

    def __init__(self, kernel: RoomKernel | None = None, *, cost: float = COST) -> None:
        self.kernel = kernel or RoomKernel()
        self.cost = cost

    def fit(
        self, floors: Sequence[Floor | Interpretation], labels: Mapping[str, Labels] | None = None
    ) -> RelationalRoomClassifier:
        """Learn the labels of all label sets from one Gram matrix.

        labels: by the name of a label set, of each floor those of its rooms in order. Where none are given, those that
        the facts of the target tell are one set with the target's name.
        Raises ModelError for rooms without a label or with several, and for fewer than two labels, RelationError as
        RoomKernel.
        """
        told = to_interpretations(floors)
        self.kernel.check(told)
        rooms = [self.kernel.list_rooms(each) for each in told]
        given = {self.kernel.target: self._read_labels(told)} if labels is None else labels
        for name, of_floors in given.items():
            counts = [len(each) for each in of_floors]
            if counts != [len(each) for each in rooms]:
                raise ModelError(
                    f"labels of {name} are not one for each room of each floor, give {sum(map(len, rooms))}"
                )
        gram = self.kernel.fit(told).compare()
        joined = {name: [label for each in of_floors for label in each] for name, of_floors in given.items()}
        self.machines_ = {name: fit_svm(gram, each, cost=self.cost) for name, each in joined.items()}
        self.labels_ = {name: tuple(sorted(set(each))) for name, each in joined.items()}
        return self

    def decide(self, floors: Sequence[Floor | Interpretation]) -> dict[str, list[Floats]]:
        """By label set, of each floor the decision values of its rooms, shape (rooms, labels_).

        Raises ModelError before `fit`, RelationError as RoomKernel.
        """
        told = to_interpretations(floors)
        gram = self.kernel.compare(told)
        ends = np.cumsum([0, *(len(self.kernel.list_rooms(each)) for each in told)])
        decided = {name: decide(machine, gram, self.labels_[name]) for name, machine in self.machines_.items()}
        return {name: [values[start:end] for start, end in pairwise(ends)] for name, values in decided.items()}

    def predict(self, floors: Sequence[Floor | Interpretation]) -> dict[str, list[list[str]]]:
        """By label set, of each floor the labels of its rooms: those with the highest decision values."""
        return {
            name: [[self.labels_[name][column] for column in values.argmax(axis=1)] for values in of_floors]
            for name, of_floors in self.decide(floors).items()
        }

    def _read_labels(self, told: Sequence[Interpretation]) -> list[list[str]]:
        """The labels that the facts of the target tell."""
        target = self.kernel.target
        missing, several, read = [], [], []
        for each in told:
            labels = self._read_targets(each)
            rooms = self.kernel.list_rooms(each)
            missing += [f"{room} of {each.name}" for room in rooms if room not in labels]
            several += [
                f"{room} of {each.name} ({', '.join(labels[room])})" for room in rooms if len(labels.get(room, ())) > 1
            ]
            read.append([name for room in rooms for name in labels.get(room, ())])
        if missing:
            raise ModelError(f"rooms {join_faults(missing)} have no {target}, give each one")
        if several:
            raise ModelError(f"rooms {join_faults(several)} have more than one {target}, give each one")
        return read

    def _read_targets(self, interpretation: Interpretation) -> dict[Value, list[str]]:
        """By room the labels that the facts of the target tell, each once."""
        arguments = self.kernel.signatures[self.kernel.target].arguments
        places = [place for place, argument in enumerate(arguments) if argument.is_entity]
        others = [place for place in range(len(arguments)) if place not in places]
        found: dict[Value, dict[str, None]] = {}
        for fact in interpretation.facts_of(self.kernel.target):
            label = ",".join(str(fact.arguments[place]) for place in others)
            found.setdefault(fact.arguments[places[0]], {})[label] = None
        return {room: [*labels] for room, labels in found.items()}


def to_interpretations(
    floors: Sequence[Floor | Interpretation], *, label_set: LabelSet = LabelSet.TYPE
) -> list[Interpretation]:
    """Floors as interpretations, by ROOM_RELATIONS with labels of a label set; interpretations as they are."""
    return [
        interpret_floor(each, relations=ROOM_RELATIONS, label_set=label_set) if isinstance(each, Floor) else each
        for each in floors
    ]


class RelationalTypeClassifier:
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

    def fit(
        self, floors: Sequence[Floor | Interpretation], types: Sequence[str] | None = None
    ) -> RelationalTypeClassifier:
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
        self.machine_ = fit_svm(gram, given, cost=self.cost)
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
