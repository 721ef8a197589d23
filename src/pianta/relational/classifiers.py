"""Classifiers of rooms and of buildings as in kLog, where an interpretation is a whole floor (thesis, section 6.2)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from pianta._types import Floats
from pianta.errors import ModelError
from pianta.floor import Floor
from pianta.io._faults import join_faults
from pianta.labels import LabelSet
from pianta.relational.facts import Interpretation, Value
from pianta.relational.interpretation import FLOOR_RELATIONS, Relation, interpret_floor
from pianta.relational.kernels import COST, ROOM_RELATIONS, FloorKernel, RoomKernel, decide, fit_svm

# For each floor, a label for each room.
Labels: TypeAlias = Sequence[Sequence[str]]
TARGET = "buildingtype"
_TYPE_RELATIONS = (*ROOM_RELATIONS, *(each for each in FLOOR_RELATIONS if each.signature.name == TARGET))


class RelationalRoomClassifier:
    """A classifier of rooms on a kernel of rooms: fit to labelled floors, then predict the labels of other floors.

    Floors are of type Floor, interpreted by ROOM_RELATIONS, or Interpretation, such as read_interpretations gives; the
    target labels are hidden from the kernel.
    kernel: None for RoomKernel(). cost: C of the support vector machines.

    labels_: by the name of a label set, the labels that were learnt.
    """

    def __init__(self, kernel: RoomKernel | None = None, *, cost: float = COST) -> None:
        self.kernel = kernel or RoomKernel()
        self.cost = cost

    def fit(
        self, floors: Sequence[Floor | Interpretation], labels: Mapping[str, Labels] | None = None
    ) -> RelationalRoomClassifier:
        """Learn the labels of all label sets from one Gram matrix.

        labels: by the name of a label set, labels of the rooms of each floor, in order; None to read one set, with the
        name of the target, from the facts of the target.
        Raises ModelError for rooms without a label or with several, and for fewer than two labels; RelationError for
        floors that RoomKernel refuses.
        """
        interpretations = to_interpretations(floors)
        self.kernel.check(interpretations)
        counts = [len(self.kernel.list_rooms(each)) for each in interpretations]
        targets = {self.kernel.target: self._read_labels(interpretations)} if labels is None else labels
        for name, floor_labels in targets.items():
            if [len(each) for each in floor_labels] != counts:
                raise ModelError(f"labels of {name} are not one for each room of each floor, give {sum(counts)}")
        gram = self.kernel.fit(interpretations).compare()
        joined = {name: [label for each in floor_labels for label in each] for name, floor_labels in targets.items()}
        self.machines_ = {name: fit_svm(gram, each, cost=self.cost) for name, each in joined.items()}
        self.labels_ = {name: tuple(sorted(set(each))) for name, each in joined.items()}
        return self

    def decide(self, floors: Sequence[Floor | Interpretation]) -> dict[str, list[Floats]]:
        """By label set, the decision values of the rooms of each floor, shape (rooms, labels_).

        Raises ModelError before `fit`, RelationError for floors that RoomKernel refuses.
        """
        interpretations = to_interpretations(floors)
        gram = self.kernel.compare(interpretations)
        ends = np.cumsum([0, *(len(self.kernel.list_rooms(each)) for each in interpretations)])
        decided = {name: decide(machine, gram, self.labels_[name]) for name, machine in self.machines_.items()}
        return {name: [values[start:end] for start, end in pairwise(ends)] for name, values in decided.items()}

    def predict(self, floors: Sequence[Floor | Interpretation]) -> dict[str, list[list[str]]]:
        """By label set, the labels of the rooms of each floor: those with the highest decision values."""
        return {
            name: [[self.labels_[name][column] for column in values.argmax(axis=1)] for values in floor_values]
            for name, floor_values in self.decide(floors).items()
        }

    def _read_labels(self, interpretations: Sequence[Interpretation]) -> list[list[str]]:
        """For each floor, the labels of its rooms by the facts of the target; ModelError unless each room has one."""
        target = self.kernel.target
        missing, several, labels = [], [], []
        for each in interpretations:
            by_room = self._read_targets(each)
            rooms = self.kernel.list_rooms(each)
            missing += [f"{room} of {each.name}" for room in rooms if room not in by_room]
            several += [
                f"{room} of {each.name} ({', '.join(by_room[room])})"
                for room in rooms
                if len(by_room.get(room, ())) > 1
            ]
            labels.append([name for room in rooms for name in by_room.get(room, ())])
        if missing:
            raise ModelError(f"rooms {join_faults(missing)} have no {target}, give each one")
        if several:
            raise ModelError(f"rooms {join_faults(several)} have more than one {target}, give each one")
        return labels

    def _read_targets(self, interpretation: Interpretation) -> dict[Value, list[str]]:
        """By the identifier of a room, its different labels in the facts of the target."""
        arguments = self.kernel.signatures[self.kernel.target].arguments
        entities = [index for index, argument in enumerate(arguments) if argument.is_entity]
        others = [index for index in range(len(arguments)) if index not in entities]
        labels: dict[Value, dict[str, None]] = {}
        for fact in interpretation.facts_of(self.kernel.target):
            label = ",".join(str(fact.arguments[index]) for index in others)
            labels.setdefault(fact.arguments[entities[0]], {})[label] = None
        return {room: [*names] for room, names in labels.items()}


class RelationalTypeClassifier:
    """A classifier of building types on a kernel of floors; fit to floors with types, then predict for others.

    Floors are of type Floor, interpreted by ROOM_RELATIONS and their labels in label_set, or Interpretation, such as
    read_interpretations gives; the type is hidden from the kernel.
    kernel: None for FloorKernel(). cost: C of the support vector machine.

    types_: the types that were learnt.
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
        """Learn the building types of floors.

        types: the type of each floor, in order; None to read the types from the facts of the floors.
        Raises ModelError for floors without a type and for fewer than two types, RelationError for floors that
        FloorKernel refuses, LabelError for floors that interpret_floor refuses.
        """
        interpretations = self._interpret(floors)
        self.kernel.check(interpretations)
        targets = _read_types(interpretations) if types is None else list(types)
        if len(targets) != len(interpretations):
            raise ModelError(f"{len(targets)} types are given for {len(interpretations)} floors, give one each")
        gram = self.kernel.fit(interpretations).compare()
        self.machine_ = fit_svm(gram, targets, cost=self.cost)
        self.types_ = tuple(sorted(set(targets)))
        return self

    def decide(self, floors: Sequence[Floor | Interpretation]) -> Floats:
        """Decision values, shape (floors, types_); raises ModelError before `fit`, and what `fit` raises."""
        gram = self.kernel.compare(self._interpret(floors))
        return decide(self.machine_, gram, self.types_)

    def predict(self, floors: Sequence[Floor | Interpretation]) -> list[str]:
        """The type of each floor: that with the highest decision value."""
        return [self.types_[column] for column in self.decide(floors).argmax(axis=1)]

    def _interpret(self, floors: Sequence[Floor | Interpretation]) -> list[Interpretation]:
        return to_interpretations(floors, relations=_TYPE_RELATIONS, label_set=self.label_set)


def to_interpretations(
    floors: Sequence[Floor | Interpretation],
    *,
    relations: Iterable[Relation] = ROOM_RELATIONS,
    label_set: LabelSet = LabelSet.TYPE,
) -> list[Interpretation]:
    """Floors as interpretations, by relations and with labels of a label set; interpretations as they are."""
    return [
        interpret_floor(each, relations=relations, label_set=label_set) if isinstance(each, Floor) else each
        for each in floors
    ]


def _read_types(interpretations: Sequence[Interpretation]) -> list[str]:
    """The building type of each floor by its facts; raises ModelError unless each floor has one."""
    types = [[str(fact.arguments[0]) for fact in each.facts_of(TARGET)] for each in interpretations]
    faults = [
        f"{each.name} ({len(names)})" for each, names in zip(interpretations, types, strict=True) if len(names) != 1
    ]
    if faults:
        raise ModelError(f"floors {join_faults(faults)} do not have exactly one {TARGET}, give each one")
    return [name for (name,) in types]
